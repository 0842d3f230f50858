"""What a patient can be: limits within which numbers are accepted, and within which patients are drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from fesloop.errors import InputError, InputErrors
from fesloop.hand.movements import MUSCLES, muscle

Limits = tuple[float, float]

LIMITS: dict[str, dict[str, Limits]] = {
    # (chosen: hands from a child of eight years to the largest; arms that carry arrays of 96 mm)
    "anthropometry": {"hand_mm": (130.0, 240.0), "forearm_mm": (160.0, 400.0),
                      "forearm_radius_mm": (25.0, 65.0)},
    # (chosen: from a trace of force, 1 % of the able-bodied adult's, to an athlete's)
    "strength": {"overall": (0.01, 3.0), "muscles": (0.01, 3.0), "denervated": (0.0, 1.0)},
    # (chosen: nothing within reach of 126 mA tells thresholds further off apart)
    "recruitment": {"threshold": (0.1, 10.0), "thresholds": (0.1, 10.0), "spread": (0.0, 1.0),
                    "chronaxie_us": (20.0, 2000.0), "axon_seed": (0.0, 2.0**53)},
    # Delay: 10-20 ms in models, 40-140 measured at the wrist; speed: models are off by up to 5 times from
    # 20-25 rad/s (Hunt 1998).
    "muscle": {"delay_ms": (5.0, 200.0), "natural_rad_s": (4.0, 125.0), "fusion_hz": (2.0, 50.0)},
    "fatigue": {"endurance": (0.05, 20.0), "floor": (0.0, 1.0), "fatigue_s": (0.05, 1000.0),
                "recovery_s": (1.0, 10000.0), "frequency_weight": (0.0, 1.0)},
    "voluntary": {"limit": (0.0, 1.0), "muscles": (0.0, 1.0)},
    # MCP joints: .033 N m/rad in health to .64 at MAS 3 (PMC7775510), and twice that.
    "passive": {"mcp_n_m_per_rad": (0.02, 1.3), "stiffness": (0.1, 10.0), "damping": (0.1, 10.0),
                "tension": (0.0, 5.0), "rest_deg": (-180.0, 180.0)},
    "spasticity": {"gain_s": (0.0, 20.0), "threshold_per_s": (0.0, 20.0), "delay_ms": (10.0, 200.0),
                   "limit": (0.0, 1.0)},
    "tremor": {"activation": (0.0, 0.5), "frequency_hz": (2.0, 15.0), "spread_hz": (0.001, 3.0)},
    # Shifts of +-10 mm, +-10 deg are to be expected; beyond, the arrays were put on wrongly.
    "placement": {"along_mm": (-40.0, 40.0), "around_deg": (-45.0, 45.0), "skin": (0.05, 1.5),
                  "element_sd": (0.0, 1.0), "skin_seed": (0.0, 2.0**53)},
    # Stimulators give 126 mA, 126 mA x 500 us = 63 uC, and 50 of them a second.
    "tolerance": {"current_max_ma": (1.0, 126.0), "charge_max_uc": (0.1, 63.0),
                  "charge_per_s_max_uc": (0.1, 3150.0)},
}
"""By section of a patient's file; a limit of a table holds for each of its values."""
SPREADS: dict[str, Limits] = {
    "hand_mm": (0.0, 40.0), "forearm_radius_mm": (0.0, 15.0), "delay_ms": (0.0, 50.0),
    "voluntary": (0.0, 0.5), "denervated": (0.0, 0.5), "along_mm": (0.0, 20.0), "around_deg": (0.0, 20.0),
    "tremor_hz": (0.0, 5.0)}
"""Of standard deviations; those that are not named are of logarithms, and go from 0 to 1."""

_UNITS = {"_mm": " mm", "_deg": " deg", "_ms": " ms", "_s": " s", "_per_s": " 1/s", "_rad_s": " rad/s",
          "_us": " us", "_hz": " Hz", "_ma": " mA", "_n_m_per_rad": " N m/rad", "_uc": " uC",
          "_per_s_max_uc": " uC/s"}
"""By the end of a number's name; the last that fits counts."""


def refuse(section: str, parameters: object, limits: Mapping[str, Limits], *muscle_tables: str) -> None:
    """Raise InputErrors naming every number of a section outside its limits, and every unknown muscle."""
    faults = list(_faults(section, parameters, limits, muscle_tables))
    if faults:
        raise InputErrors(faults)


def _faults(section: str, parameters: Any, limits: Mapping[str, Limits],
            muscle_tables: tuple[str, ...]) -> Iterator[InputError]:
    for key, (low, high) in limits.items():
        value = getattr(parameters, key)
        named = value.items() if isinstance(value, Mapping) else (("", value),)
        for name, number in named:
            where = f"{section}.{key}" + (f".{name}" if name else "")
            if key in muscle_tables and name not in MUSCLES:
                yield _unknown_muscle(where, name)
            elif number is not None and not (math.isfinite(number) and low <= number <= high):
                unit = next((unit for end, unit in reversed(_UNITS.items()) if key.endswith(end)), "")
                yield InputError(where, f"{number:g}{unit}", f"{low:g} to {high:g}{unit}")


def _unknown_muscle(where: str, name: str) -> InputError:
    try:
        muscle(name)
    except InputError as fault:
        return InputError(where, f"there is no muscle {name!r}", fault.allowed, fault.remedy)
    raise AssertionError(f"{name} is a muscle")


def spread_limits(keys: tuple[str, ...]) -> dict[str, Limits]:
    """Limits of standard deviations."""
    return {key: SPREADS.get(key, (0.0, 1.0)) for key in keys}

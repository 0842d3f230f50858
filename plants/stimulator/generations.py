"""Ranges of three generations of an 8-channel stimulator, and the pulse that a device gives for a command.

Ranges, steps and latencies are those of such devices as usually quoted: 0-126 mA in steps of 2 mA, 0.5 mA on
newer ones, 20-500 us in steps of 1 us, 20-50 Hz, 1-24 ms from command to pulse. The assignment of latencies
to generations and the compliance voltage are chosen. The terms are those of IEC 60601-2-10; no certification
is implied.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

PresetName = Literal["generation1", "generation2", "generation3"]
_ROUND_OFF = 1e-9
IEC_LOAD_OHM = 500.0
"""Load for which IEC 60601-2-10 states its limits."""
IEC_ENERGY_J = 0.3
"""Greatest energy of a pulse into that load."""
IEC_VOLTAGE_V = 500.0
"""Greatest peak voltage."""
IEC_DENSITY_MA_CM2 = 2.0
"""Current density (r.m.s.) under an electrode above which the operator must be alerted."""

BAD, CURRENT, VOLTAGE, SMALL, WIDTH, SHORT, CHARGE, ENERGY = 1, 2, 4, 8, 16, 32, 64, 128
LIMITED = ((BAD, "bad_input", "negative or not finite: no pulse"),
           (CURRENT, "current_limited", "current above the device's range"),
           (VOLTAGE, "voltage_limited", "current above the limit of the device's voltage at the load"),
           (SMALL, "current_too_small", "current rounds to 0: no pulse"),
           (WIDTH, "width_limited", "pulse width above the device's range"),
           (CHARGE, "charge_limited", "charge per phase above the user's limit: pulse shortened"),
           (ENERGY, "energy_limited", "energy of the pulse above 300 mJ into 500 ohm: pulse shortened"),
           (SHORT, "width_too_short", "pulse width below the device's range: no pulse"))
"""Bits of limits that change or suppress a pulse, with their statuses."""


class Preset(NamedTuple):
    """Ranges of a device.

    Attributes
    ----------
    channels: number of channels.
    current_max_ma, current_step_ma: range from 0, and resolution.
    width_min_us, width_max_us, width_step_us: range and resolution of the pulse width.
    frequency_min_hz, frequency_max_hz: range of the stimulation frequency.
    latency_ms: latency from a command to its pulses.
    compliance_v: greatest voltage.
    """

    channels: int
    current_max_ma: float
    current_step_ma: float
    width_min_us: float
    width_max_us: float
    width_step_us: float
    frequency_min_hz: float
    frequency_max_hz: float
    latency_ms: float
    compliance_v: float


PRESETS = {
    "generation1": Preset(8, 126.0, 2.0, 20.0, 500.0, 1.0, 20.0, 50.0, 24.0, 150.0),
    "generation2": Preset(8, 126.0, 2.0, 20.0, 500.0, 1.0, 20.0, 50.0, 10.0, 150.0),
    "generation3": Preset(8, 126.0, 0.5, 20.0, 500.0, 1.0, 20.0, 50.0, 1.0, 150.0),
}


class Limits(NamedTuple):
    """Ranges and resolutions of one device in use, in A, s, C.

    Attributes
    ----------
    current_max, current_step: range and resolution of the current, A.
    current_driven: current of the compliance voltage through the load, A.
    width_min, width_max, width_step: range and resolution of the pulse width, s.
    charge_max: the user's limit of a phase's charge, C.
    """

    current_max: float
    current_step: float
    current_driven: float
    width_min: float
    width_max: float
    width_step: float
    charge_max: float


def given_pulse(
    limits: Limits, current: float, width: float, *, never_more: bool = False
) -> tuple[float, float, int]:
    """Pulse that a device gives for a command: current, A, width, s, and bits of the limits that changed it.

    Values are rounded to the nearest step, but down if a limit applies, or if the command must not be
    exceeded (`never_more`). Charge per phase and energy are limited by shortening the pulse; the energy, 2 R
    I^2 w, counts both phases.
    """
    if not (math.isfinite(current) and math.isfinite(width) and current >= 0.0 and width >= 0.0):
        return 0.0, 0.0, BAD
    if current == 0.0 or width == 0.0:
        return 0.0, 0.0, 0
    rounded = _down if never_more else _nearest
    cut = CURRENT if current > limits.current_max * (1.0 + _ROUND_OFF) else 0
    if current > limits.current_driven * (1.0 + _ROUND_OFF):
        cut |= VOLTAGE
    most = min(limits.current_max, limits.current_driven)
    current = min(rounded(current, limits.current_step), _down(most, limits.current_step))
    if current == 0.0:
        return 0.0, 0.0, cut | SMALL
    if width > limits.width_max * (1.0 + _ROUND_OFF):
        cut |= WIDTH
    elif width < limits.width_min * (1.0 - _ROUND_OFF):
        return 0.0, 0.0, cut | SHORT
    width = min(rounded(width, limits.width_step), _down(limits.width_max, limits.width_step))
    energetic = IEC_ENERGY_J / (2.0 * IEC_LOAD_OHM * current)
    for charge, bit in ((limits.charge_max, CHARGE), (energetic, ENERGY)):
        if current * width > charge * (1.0 + _ROUND_OFF):
            width, cut = _down(charge / current, limits.width_step), cut | bit
    if width < limits.width_min * (1.0 - _ROUND_OFF):
        return 0.0, 0.0, cut | SHORT
    return current, width, cut


def _nearest(value: float, step: float) -> float:
    return math.floor(value / step + 0.5) * step


def _down(value: float, step: float) -> float:
    """Greatest multiple of the step up to the value, within round-off."""
    return math.floor(value / step * (1.0 + _ROUND_OFF)) * step

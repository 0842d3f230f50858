"""A patient in the parameters of the blocks `electrodes`, `muscles`, `hand`, `myohand` and `safety`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fesloop.errors import InputError
from fesloop.forms.schema import plain
from fesloop.hand.movements import MUSCLES
from fesloop.loop.noise import NoiseStream, stream_key
from plants.checks import MOST_ELEMENTS
from plants.electrodes.arrays import DORSAL
from plants.electrodes.axons import MOTOR_POINTS, AxonScatter
from plants.muscles.ding import Ding2003, Ding2003Fatigue
from plants.muscles.lags import Hammerstein

if TYPE_CHECKING:
    from plants.patients.patient import Patient

ADULT_FOREARM_MM = 260.0
"""Elbow to wrist of the forearm that motor points and arrays are of (chosen, as by `electrodes`)."""
HEALTHY_MCP, JOINT_SHARE = 0.04, 0.03
"""Stiffness of a finger's MCP joint, N m/rad, and what of it is the joint's own: the rest are its tendons
(`plants.hand.model`)."""
LEAST_STRENGTH = 1e-4
"""Of a muscle without nerve (chosen: no force to speak of; MuJoCo divides by it)."""


def hand(patient: Patient) -> dict[str, Any]:
    """Parameters of `hand`, and but for the hand's own measures of `myohand`."""
    strength, passive = patient.strength, patient.passive
    factors = tuple(
        max(strength.overall * strength.muscles.get(name, 1.0) * (1.0 - strength.denervated.get(name, 0.0)),
            LEAST_STRENGTH) for name in MUSCLES)
    tendons = HEALTHY_MCP - JOINT_SHARE
    return {"hand": patient.anthropometry.size, "strength": factors, "stiffness": passive.stiffness,
            "damping": passive.damping, "passive_tension": passive.tension,
            "contracture": (passive.mcp_n_m_per_rad - tendons) / JOINT_SHARE,
            "rest_deg": dict(passive.rest_deg)}


def muscles(patient: Patient, model: str = "") -> dict[str, Any]:
    """Parameters of `muscles`; `model` in place of the patient's.

    `ding2003` has a fatigue of its own: a patient who tires gets it with its own numbers, uncalibrated.
    """
    dynamics, voluntary = patient.muscle, patient.voluntary
    model = model or dynamics.model
    parameters: dict[str, Any] = {
        "model": model, "delay_ms": dynamics.delay_ms, "fusion_hz": dynamics.fusion_hz,
        "natural_rad_s": dynamics.natural_rad_s, "voluntary_limit": voluntary.limit,
        "voluntary_limits": dict(voluntary.muscles),
        "hammerstein": Hammerstein(activation_rad_s=dynamics.natural_rad_s)}
    if patient.fatigue is not None:
        if model == "ding2003":
            parameters["ding2003"] = Ding2003(fatigue=Ding2003Fatigue())
        else:
            parameters["fatigue"] = patient.fatigue.of_muscles
    if patient.spasticity is not None:
        parameters["reflex"] = patient.spasticity.reflex
    if patient.tremor is not None:
        parameters["tremor"] = patient.tremor.of_muscles
    return parameters


def electrodes(patient: Patient, elements: int) -> dict[str, Any]:
    """Parameters of `electrodes` with that many elements.

    Motor points and arrays lie along the forearm in proportion to its length.
    """
    person, recruitment, place = patient.anthropometry, patient.recruitment, patient.placement
    length_mm = 1e3 * person.size.forearm
    scale = length_mm / ADULT_FOREARM_MM
    points = tuple(replace(point, along_mm=scale * point.along_mm) for point in MOTOR_POINTS)
    return {
        "radius_mm": person.forearm_radius_mm, "length_mm": length_mm, "motor_points": points,
        "axons": replace(AxonScatter(), spread=recruitment.spread),
        "axon_seed": recruitment.axon_seed, "chronaxie_us": recruitment.chronaxie_us,
        "threshold": tuple(recruitment.threshold * recruitment.thresholds.get(name, 1.0) for name in MUSCLES),
        "shift_mm": place.along_mm + (scale - 1.0) * DORSAL.centre_mm, "shift_deg": place.around_deg,
        "skin_gain": skin_gains(patient, elements)}


def skin_gains(patient: Patient, elements: int) -> tuple[float, ...]:
    """Share of each element's current that passes on this day."""
    place = patient.placement
    stream = NoiseStream(stream_key(place.skin_seed, "skin", 0), 1)
    drawn = np.array([stream.row(element)[0] for element in range(elements)])
    return tuple(float(gain) for gain in place.skin * np.exp(place.element_sd * drawn))


def table_of(patient: Patient, kind: str, own: Mapping[str, Any]) -> dict[str, Any]:
    """What stands in an experiment file for the patient under a block of that kind; empty for other kinds.

    `own` is what the file says of the block itself, unchecked: it decides on the muscles' model and on the
    number of elements.
    """
    if kind in ("hand", "myohand"):
        parameters = hand(patient)
        if kind == "myohand":
            del parameters["hand"]  # it has a size of its own
        return _plain(parameters)
    if kind == "muscles":
        model = own.get("model")
        return _plain(muscles(patient, model if isinstance(model, str) else ""))
    if kind == "electrodes":
        elements = _elements(own.get("arrays"))
        parameters = electrodes(patient, elements)
        if not elements:
            del parameters["skin_gain"]
        return _plain(parameters)
    if kind == "safety":
        return safety(patient, own)
    return {}


def safety(patient: Patient, own: Mapping[str, Any]) -> dict[str, Any]:
    """Limits of the `safety` block.

    Raises InputError where the experiment itself says more than the patient may be given.
    """
    limits = cast("dict[str, float]", plain(patient.tolerance))
    for key, limit in limits.items():
        said = own.get(key)  # one value for all channels, or one for each
        most = max((value for value in (said if isinstance(said, (list, tuple)) else (said,))
                    if isinstance(value, (int, float))), default=limit)
        if most > limit:
            raise InputError(f"safety.{key}", f"{most:g}", f"at most {limit:g} for {patient.name}",
                             "leave it out, or lower it")
    return dict(limits)


def _plain(parameters: dict[str, Any]) -> dict[str, Any]:
    return {key: plain(value) for key, value in parameters.items()}


def _elements(arrays: Any) -> int:
    """Elements of unchecked arrays; 0 where they are not what arrays are, which the check will say."""
    if arrays is None:
        from plants.electrodes.block import Electrodes

        return Electrodes().elements
    try:
        count = sum(len(array.get("positions", ())) or array.get("rows", 0) * array.get("columns", 0)
                    for array in arrays)
        return count if 0 < count <= len(arrays) * MOST_ELEMENTS else 0
    except (TypeError, AttributeError):
        return 0

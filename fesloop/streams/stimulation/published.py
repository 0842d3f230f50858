"""Published recordings of stimulated muscle, kept as NumPy archives.

| set | what | source |
|---|---|---|
| `fes_exo` | arms in an exoskeleton: eight muscles, four joints | github.com/mahilab/FES_Exo, b674cb4 |
| `rat_gm` | gastrocnemius of rats: force against length and pulses | doi 10.1101/2025.09.29.678508 |
| `biceps_force` | twenty trains of one biceps | doi 10.5281/zenodo.10427934 |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from fesloop.errors import InputError
from fesloop.streams.stimulation.recording import (
    PASSIVE,
    Array,
    ForceCourse,
    Movement,
    SteadyTrials,
    StimulationRecording,
    TorqueCourse,
)

_US, _MA, _MNM, _MN, _UM = 1e-6, 1e-3, 1e-3, 1e-3, 1e-6
_MISSING = -32768
_EXO_JOINTS = ("elbow_flexion", "forearm_pronation", "wrist_flexion", "wrist_radial_deviation")
_EXO_ZERO_DEG = (90.0, 0.0, 0.0, 0.0)
_EXO_NOTES = (
    "Torque is what the position controller of the exoskeleton (MAHI Exo-II) commands, from nominal "
    "constants of its motors, not a load cell's; muscle torque within the joints' dry friction is hidden. "
    "Signs of joints are inferred from the muscles. Phase form and electrode size are not stated.")
_RAT_NOTES = (
    "Medial gastrocnemius in situ, stimulated through a cuff on the sciatic nerve; force of the lateral head "
    "(.03 to .11 N, not stimulated) is left out. Force begins some 8 ms after the first pulse.")
_BICEPS_NOTES = (
    "Force is not measured: it is torque at the hand through a model (arm26), over its moment arm. Its "
    "course is the measurement's, its scale the model's; no delay can be read from it.")


class Published(NamedTuple):
    """A published set: name, keys that tell it, and its reader."""

    name: str
    keys: frozenset[str]
    read: Callable[[Mapping[str, Any], str, str], StimulationRecording]


def fes_exo(found: Mapping[str, Any], where: str, source: str) -> StimulationRecording:
    """Arm in an exoskeleton; muscle 0 of the file is the passive trial."""
    names = tuple(str(name) for name in found["muscles"])
    if not names or names[0] != "passive" or np.shape(found["joints"]) != (len(_EXO_JOINTS),):
        raise InputError(where, "has other muscles or joints", "passive, then muscles; four joints")
    muscles = names[1:]
    low, high, current = _usable_widths(found, len(muscles))
    return StimulationRecording(
        person=str(found["subject"]), side="right", muscles=muscles, joints=_EXO_JOINTS,
        zero_rad=np.radians(_EXO_ZERO_DEG), friction_nm=np.full(4, np.nan),
        frequency_hz=float(found["frequency_hz"]), lowest_width_s=low, highest_width_s=high,
        width_current_a=current, source=source, source_format="fes_exo", notes=_EXO_NOTES,
        steady=_exo_steady(found) if "steady_muscle" in found else None,
        courses=tuple(_exo_ramp(found, i, muscles) for i in range(len(found.get("ramp_muscle", ())))),
        movements=tuple(_exo_loop(found, i) for i in range(len(found.get("loop_name", ())))))


def _usable_widths(found: Mapping[str, Any], muscles: int) -> tuple[Array, Array, Array]:
    """Lowest and highest pulse width and their current, of the lab's curve, or else of its settings."""
    curve, settings = (np.asarray(found[key], float)[1:] for key in ("lab_recruitment", "lab_settings"))
    current, low, high = curve[:, 3], curve[:, 4], curve[:, 5]
    use = np.isfinite(high)
    current, low, high = (np.where(use, a, b) for a, b in (
        (current, settings[:, 1]), (low, settings[:, 2]), (high, settings[:, 3])))
    known = np.isfinite(high) & (high > 0.0) & (low > 0.0)
    return tuple(np.where(known, each * unit, np.nan) for each, unit in (  # type: ignore[return-value]
        (low, _US), (high, _US), (current, _MA)))


def _exo_steady(found: Mapping[str, Any]) -> SteadyTrials:
    def numbers(key: str) -> Array:
        return np.asarray(found[f"steady_{key}"], float)

    def whole(key: str) -> Any:
        return np.asarray(found[f"steady_{key}"], np.int64)

    muscle = whole("muscle") - 1
    trace = np.asarray(found["steady_trace_exo_mnm"])
    return SteadyTrials(
        muscle=np.where(muscle < 0, PASSIVE, muscle), posture=np.asarray(found["steady_posture"], str),
        visit=whole("visit"), order=whole("order"), repeat=whole("repeat"), time_s=numbers("end_s"),
        reference_rad=np.radians(numbers("reference_deg")), angle_rad=np.radians(numbers("angle_deg")),
        pulse_width_s=numbers("pulse_width_us") * _US, current_a=numbers("current_ma") * _MA,
        device_torque_nm=numbers("exo_torque_nm"), device_torque_sd_nm=numbers("exo_torque_sd_nm"),
        creep_nm=numbers("creep_nm"), stiffness_nm_rad=numbers("gain_nm_rad"),
        trace_nm=_milli(trace), trace_period_s=0.01)


def _milli(values: Any) -> Array:
    """Newton metres of int16 mN m, NaN where missing."""
    return np.where(np.asarray(values) == _MISSING, np.nan, np.asarray(values, float) * _MNM)


def _exo_ramp(found: Mapping[str, Any], i: int, muscles: tuple[str, ...]) -> TorqueCourse:
    """One ramp recording, up to its last sample."""
    torque, muscle = _milli(found["ramp_exo_torque_mnm"][i]), int(found["ramp_muscle"][i]) - 1
    angle = np.asarray(found["ramp_angle_cdeg"][i], float)
    angle = np.radians(np.where(angle == _MISSING, np.nan, angle / 100.0))
    kept = int(np.flatnonzero(np.isfinite(torque).any(axis=1))[-1]) + 1
    return TorqueCourse(
        name=f"{muscles[muscle]} {found['ramp_at'][i]}", muscle=muscle,
        current_a=float(found["ramp_current_ma"][i]) * _MA, period_s=_period(found["ramp_step_s"]),
        pulse_width_s=np.asarray(found["ramp_pulse_width_us"][i][:kept], float) * _US,
        reference_rad=np.radians(np.asarray(found["ramp_reference_deg"], float)),
        stiffness_nm_rad=np.asarray(found["ramp_gain_nm_rad"][i], float),
        angle_rad=angle[:kept], device_torque_nm=torque[:kept])


def _exo_loop(found: Mapping[str, Any], i: int) -> Movement:
    rows = slice(int(found["loop_first"][i]), int(found["loop_first"][i]) + int(found["loop_count"][i]))
    settings = {key: float(found[f"loop_{key}"][i]) for key in ("fes_share", "exo_share", "kp", "kd")}
    angle, reference = (np.radians(np.asarray(found[f"loop_{key}_cdeg"][rows], float) / 100.0)
                        for key in ("angle", "reference"))
    return Movement(
        name=str(found["loop_name"][i]), period_s=_period(found["loop_step_s"]), reference_rad=reference,
        angle_rad=angle, device_torque_nm=_milli(found["loop_exo_torque_mnm"][rows]),
        planned_nm=_milli(found["loop_planned_fes_torque_mnm"][rows]),
        pulse_width_s=np.asarray(found["loop_pulse_width_us"][rows], float) * _US,
        current_a=np.asarray(found["loop_current_ma"][i], float) * _MA,
        settings={key: value for key, value in settings.items() if np.isfinite(value)})


def _period(step: Any) -> float:
    """Seconds of a single-precision number, as the decimal that was meant."""
    return float(f"{float(step):.6g}")


def rat_gm(found: Mapping[str, Any], where: str, source: str) -> StimulationRecording:
    """Medial gastrocnemius of a rat; pulses begin where the stimulator's trace rises."""
    step = float(found["step_s"])
    forces = []
    for kind, name, first, count in zip(found["kind"], found["name"], found["first"], found["count"],
                                        strict=True):
        rows = slice(int(first), int(first) + int(count))
        pulse = np.asarray(found["pulse"][rows], np.int64)
        forces.append(ForceCourse(
            name=str(name), kind=str(kind), muscle=0, start_s=0.0, period_s=step,
            force_n=np.asarray(found["force_mn"][rows], float) * _MN,
            length_m=np.asarray(found["length_um"][rows], float) * _UM,
            pulses_s=np.asarray(np.flatnonzero(np.diff(pulse, prepend=0) == 1) * step, float)))
    return _forces(forces, person=str(found["rat"]), muscle="gastrocnemius medialis", frequency_hz=100.0,
                   source=source, source_format="rat_gm", notes=_RAT_NOTES)


def biceps_force(found: Mapping[str, Any], where: str, source: str) -> StimulationRecording:
    """Twenty trains of one biceps, 32 ms between pulses."""
    forces: list[ForceCourse] = []
    pulses: Array = np.asarray(found["pulse_s"], float)
    for number, (first, count) in enumerate(zip(found["first"], found["count"], strict=True)):
        time = found["time_s"][int(first):int(first) + int(count)]
        own = pulses[(pulses > time[0] - 5e-4) & (pulses <= time[-1])] - time[0]
        forces.append(ForceCourse(
            name=f"train {number:02d}", kind="train", muscle=0, start_s=float(time[0]), period_s=1e-3,
            force_n=np.asarray(found["force_n"][int(first):int(first) + int(count)], float),
            length_m=np.full(len(time), np.nan), pulses_s=own.clip(0.0)))
    return _forces(forces, person="biceps", muscle="biceps", frequency_hz=1.0 / 0.032, source=source,
                   source_format="biceps_force", notes=_BICEPS_NOTES)


def _forces(forces: list[ForceCourse], *, muscle: str, **named: Any) -> StimulationRecording:
    """A recording of one muscle's force alone."""
    return StimulationRecording(
        muscles=(muscle,), joints=(), zero_rad=np.empty(0), friction_nm=np.empty(0),
        lowest_width_s=np.full(1, np.nan), highest_width_s=np.full(1, np.nan),
        width_current_a=np.full(1, np.nan), forces=tuple(forces), **named)


PUBLISHED = (
    Published("fes_exo", frozenset(("subject", "muscles", "joints", "lab_settings", "lab_recruitment")),
              fes_exo),
    Published("rat_gm", frozenset(("rat", "kind", "length_um", "force_mn", "pulse")), rat_gm),
    Published("biceps_force", frozenset(("first", "count", "time_s", "force_n", "pulse_s")), biceps_force))


def read_published(found: Mapping[str, Any], where: str, source: str) -> StimulationRecording | None:
    """The recording in a NumPy archive of a published set; None for an archive of something else.

    Raises InputError for an archive that has the keys of a set, but not its arrays.
    """
    for each in PUBLISHED:
        if each.keys <= set(found):
            try:
                return each.read(found, where, source)
            except InputError as fault:
                raise fault.within(where) from None
            except (KeyError, IndexError, ValueError, TypeError) as fault:
                reason = f"{type(fault).__name__}: {fault}"
                raise InputError(where, f"is no whole archive of {each.name} ({reason})",
                                 "the arrays of the published set") from None
    return None

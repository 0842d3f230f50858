"""Recordings of stimulated muscle, of whatever file: isometric trials, courses of torque and force, movement.

Every number is SI; `_s`, `_a`, `_nm` (newton metres) and `_rad` in a name say which. A joint is named after
its positive direction, of angle and torque, such as `elbow_flexion` or `wrist_radial_deviation`. Arrays are
read-only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, in_one_line

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
Texts = NDArray[np.str_]
Baseline = Literal["visit_median", "passive", "none"]

PASSIVE = -1
"""Number of the muscle in a trial without stimulation."""

OPPOSITES = {"flexion": "extension", "pronation": "supination", "radial_deviation": "ulnar_deviation",
             "abduction": "adduction"}
"""Directions of joints, each with the opposite one."""

LARGEST_TORQUE_NM = MappingProxyType({
    "elbow": 145.0, "forearm": 18.0, "wrist_flexion": 38.0, "wrist_extension": 38.0,
    "wrist_radial_deviation": 31.0, "wrist_ulnar_deviation": 31.0})
"""Torque beyond what a joint can do, N m (chosen: twice the greatest published voluntary maximum, so that
strong people pass, and wrong units, which are wrong by ten or more, do not). Elbow 71
and forearm 8.9 are means of men (Askew 1987, Clinical Orthopaedics 222:261), wrist 18.7 and 15.3 the greatest
of ten wrists (Delp 1996, doi 10.1016/0021-9290(96)00029-2)."""
_OTHER_JOINT_NM = 145.0
LONGEST_PULSE_S, SHORTEST_PULSE_S, LARGEST_CURRENT_A = 2e-3, 1e-6, 0.2
"""Pulses beyond what stimulators of muscle give (chosen: commercial ones end at 1 ms and 130 mA)."""


SAME_PULSES = 0.02
"""Relative difference below which currents or pulse widths are one and the same (chosen: finer than the steps
in which stimulators change them)."""
_APART_RAD = np.radians(30.0)
"""Angle further from its reference than a device that holds a joint yields (chosen: the published ones yield
by up to 6 deg)."""


class Sized(NamedTuple):
    """Axes of an array by name, and whether it may hold NaN."""

    axes: tuple[str, ...]
    lacks: bool = False


_PerTrial = Annotated[Array, Sized(("trials",))]
_TrialJoint = Annotated[Array, Sized(("trials", "joints"))]
_TrialJointLacking = Annotated[Array, Sized(("trials", "joints"), True)]
_PerSample = Annotated[Array, Sized(("samples",))]
_SampleLacking = Annotated[Array, Sized(("samples",), True)]
_SampleJointLacking = Annotated[Array, Sized(("samples", "joints"), True)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyTrials:
    """Isometric trials with constant stimulation, one row each.

    A visit is the time in a posture in which the muscles follow each other; the same posture is visited again
    later. Postures are named by a code, which sorts and selects.

    Attributes
    ----------
    muscle: (trials,), number in the recording's `muscles`, or `PASSIVE`.
    posture: (trials,), its code, such as "0110".
    visit: (trials,), number of the visit. order: (trials,), place in the visit, from 0.
    repeat: (trials,), number of earlier visits of the posture.
    time_s: (trials,), end of the trial since the first; NaN where unknown.
    reference_rad: (trials, joints), commanded angle; angle_rad: the mean measured one.
    pulse_width_s, current_a: (trials,); 0 in a passive trial.
    device_torque_nm: (trials, joints), mean torque that the device which holds the arm exerts on it.
    device_torque_sd_nm: (trials, joints), sd of its samples within the trial; NaN where unknown.
    creep_nm: (trials, joints), last less first tenth of the trial's samples; NaN where unknown.
    stiffness_nm_rad: (trials, joints), of the device; NaN where unknown.
    trace_nm: (trials, samples, joints), device torque over the trial, NaN after its end; or None.
    trace_period_s: time between two of its samples.
    baseline: what the device holds without the muscle: "visit_median", the median of the visit's trials;
        "passive", its passive trial; "none", nothing.
    """

    muscle: Annotated[Whole, Sized(("trials",))]
    posture: Annotated[Texts, Sized(("trials",))]
    visit: Annotated[Whole, Sized(("trials",))]
    order: Annotated[Whole, Sized(("trials",))]
    repeat: Annotated[Whole, Sized(("trials",))]
    time_s: Annotated[Array, Sized(("trials",), True)]
    reference_rad: _TrialJoint
    angle_rad: _TrialJoint
    pulse_width_s: _PerTrial
    current_a: _PerTrial
    device_torque_nm: _TrialJoint
    device_torque_sd_nm: _TrialJointLacking
    creep_nm: _TrialJointLacking
    stiffness_nm_rad: _TrialJointLacking
    trace_nm: Annotated[Array, Sized(("trials", "trace_samples", "joints"), True)] | None = None
    trace_period_s: float = 0.0
    baseline: Baseline = "visit_median"

    def __len__(self) -> int:
        """Number of trials."""
        return int(self.muscle.size)

    @property
    def stimulated(self) -> NDArray[np.bool_]:
        """(trials,), False in passive trials."""
        return np.asarray(self.muscle != PASSIVE)

    @property
    def evoked_nm(self) -> Array:
        """(trials, joints), torque that stimulation evokes: minus the change of the device's."""
        return self.as_evoked(-self.device_torque_nm)

    def as_evoked(self, torque_nm: Array) -> Array:
        """Torque of muscles less the baseline of its visit.

        Predictions go through it before they are compared with `evoked_nm`: a visit's median holds a part of
        what its muscles do.

        Parameters
        ----------
        torque_nm: (trials, joints) of these trials, passive ones included.
        """
        if self.baseline == "none":
            return np.asarray(torque_nm, float)
        if self.baseline == "visit_median":
            return relative_to_visit(torque_nm, self.visit)
        return relative_to_visit(torque_nm, self.visit, ~self.stimulated)

    @property
    def stimulus(self) -> Whole:
        """(trials,), number of each trial's muscle, current and pulse width; `PASSIVE` in passive trials.

        Pulses within `SAME_PULSES` of the next weaker ones are the same.
        """
        keys = np.full((len(self), 3), PASSIVE)
        for muscle in np.unique(self.muscle[self.stimulated]):
            here = self.muscle == muscle
            keys[here] = np.column_stack([self.muscle[here], _levels(self.current_a[here]),
                                          _levels(self.pulse_width_s[here])])
        found = np.full(len(self), PASSIVE)
        found[self.stimulated] = np.unique(keys[self.stimulated], axis=0, return_inverse=True)[1]
        return found

    def repeats(self) -> list[Whole]:
        """Trials of the same muscle, posture and pulses, a group each, groups of one trial included."""
        keys = list(zip(self.stimulus.tolist(), self.posture.tolist(), strict=True))
        return [np.array([row for row, each in enumerate(keys) if each == key])
                for key in sorted({each for each in keys if each[0] != PASSIVE})]

    def cells(self) -> dict[tuple[int, str], Whole]:
        """Trials of each muscle, by its number, in each posture, by its code, without passive ones."""
        keys = sorted({(int(m), str(p)) for m, p in zip(self.muscle, self.posture, strict=True)
                       if m != PASSIVE})
        return {(m, p): np.flatnonzero((self.muscle == m) & (self.posture == p)) for m, p in keys}

    def repeatability(self) -> Repeatability:
        """Scatter between repeats and size of the evoked torque; see `Repeatability`."""
        evoked, rows = self.evoked_nm, self.repeats()
        missing = np.full(evoked.shape[1], np.nan)
        free = sum(len(each) - 1 for each in rows)
        if not free:
            return Repeatability(missing, missing)
        sd = np.sqrt(sum((len(each) - 1) * evoked[each].var(axis=0, ddof=1) for each in rows
                         if len(each) > 1) / free)
        of_noise = np.mean([1.0 / len(each) for each in rows]) * sd**2
        means = np.array([evoked[each].mean(axis=0) for each in rows])
        return Repeatability(sd, np.sqrt(np.maximum((means**2).mean(axis=0) - of_noise, 0.0)))


class Repeatability(NamedTuple):
    """Scatter between repeats, pooled over muscles, postures and pulses.

    Attributes
    ----------
    sd_nm: (joints,), standard deviation of a repeat; NaN where nothing was repeated.
    rms_nm: (joints,), root mean square of the evoked torque over muscles and postures, less what the scatter
        adds to it.
    """

    sd_nm: Array
    rms_nm: Array

    @property
    def snr(self) -> Array:
        """(joints,), `rms_nm` over `sd_nm`."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return self.rms_nm / self.sd_nm


def _levels(values: Array) -> Whole:
    """Rank (n,) of values; those within `SAME_PULSES` of the next smaller one share its rank."""
    order = np.argsort(values, kind="stable")
    steps = values[order][1:] > (1.0 + SAME_PULSES) * values[order][:-1]
    ranks = np.zeros(len(values), np.int64)
    ranks[order[1:]] = np.cumsum(steps)
    return ranks


def relative_to_visit(torque_nm: Array, visit: Whole, of: NDArray[np.bool_] | None = None) -> Array:
    """Torque (trials, joints) less the median of its visit's trials (trials,), or of those in `of` alone.

    It is NaN in a visit without such a trial.
    """
    out = np.full(np.shape(torque_nm), np.nan)
    for number in np.unique(visit):
        here = visit == number
        rested = here if of is None else here & of
        if rested.any():
            out[here] = torque_nm[here] - np.median(torque_nm[rested], axis=0)
    return out


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TorqueCourse:
    """Isometric torque over time while the pulse width of one muscle changes: steps, trains, ramps.

    Attributes
    ----------
    name: unique within the recording. muscle: number in `muscles`. current_a: constant.
    period_s: time between two samples, the first at 0.
    pulse_width_s: (samples,), as commanded.
    reference_rad, stiffness_nm_rad: (joints,), of the device; NaN where unknown.
    angle_rad: (samples, joints). device_torque_nm: (samples, joints); NaN where a sample was lost.
    """

    name: str
    muscle: int
    current_a: float
    period_s: float
    pulse_width_s: _PerSample
    reference_rad: Annotated[Array, Sized(("joints",), True)]
    stiffness_nm_rad: Annotated[Array, Sized(("joints",), True)]
    angle_rad: _SampleJointLacking
    device_torque_nm: _SampleJointLacking

    @property
    def time_s(self) -> Array:
        """(samples,), from 0."""
        return np.arange(self.pulse_width_s.size, dtype=float) * self.period_s

    def evoked_nm(self, begin_s: float, end_s: float) -> Array:
        """(samples, joints), minus the change of device torque from its mean in begin_s <= t < end_s."""
        rest = (self.time_s >= begin_s) & (self.time_s < end_s)
        if not rest.any():
            raise InputError(self.name, f"has no sample from {begin_s:g} to {end_s:g} s",
                             f"an interval within 0 to {self.time_s[-1]:g} s")
        return np.asarray(np.nanmean(self.device_torque_nm[rest], axis=0) - self.device_torque_nm)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Movement:
    """A movement, free or led by a device, with all muscles' stimulation.

    Attributes
    ----------
    name: unique within the recording. period_s: time between two samples, the first at 0.
    reference_rad, angle_rad, device_torque_nm: (samples, joints); NaN where unknown or lost.
    planned_nm: (samples, joints), torque that a controller planned for stimulation; NaN where unknown.
    pulse_width_s: (samples, muscles), as commanded. current_a: (muscles,).
    settings: numbers by name that tell movements apart, such as gains.
    """

    name: str
    period_s: float
    reference_rad: _SampleJointLacking
    angle_rad: _SampleJointLacking
    device_torque_nm: _SampleJointLacking
    planned_nm: _SampleJointLacking
    pulse_width_s: Annotated[Array, Sized(("samples", "muscles"))]
    current_a: Annotated[Array, Sized(("muscles",))]
    settings: Mapping[str, float] = field(default_factory=dict)

    @property
    def time_s(self) -> Array:
        """(samples,), from 0."""
        return np.arange(len(self.angle_rad), dtype=float) * self.period_s


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceCourse:
    """Force of one muscle over time, against its pulses and its length.

    Attributes
    ----------
    name: unique within the recording. kind: of the experiment, such as "ISOM"; may be empty.
    muscle: number in `muscles`.
    start_s: instant of the first sample in the session; 0 where unknown. period_s: between two samples.
    force_n: (samples,), + pulls; NaN where lost.
    length_m: (samples,), of muscle and tendon; NaN where unknown.
    pulses_s: (pulses,), instants at which pulses begin, from the first sample on.
    """

    name: str
    kind: str
    muscle: int
    start_s: float
    period_s: float
    force_n: _SampleLacking
    length_m: _SampleLacking
    pulses_s: Annotated[Array, Sized(("pulses",))]

    @property
    def time_s(self) -> Array:
        """(samples,), from 0."""
        return np.arange(self.force_n.size, dtype=float) * self.period_s


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StimulationRecording:
    """All recordings of one person, or one animal, under stimulation.

    Attributes
    ----------
    person: name. side: "left", "right", or empty where unknown.
    muscles: names, each once.
    joints: names, each with its positive direction; none where forces alone were recorded.
    zero_rad: (joints,), anatomical angle at which `angle_rad` is 0, such as 90 deg of an elbow that counts
        from there; NaN where unknown.
    friction_nm: (joints,), dry friction of the device, within which torque does not show; NaN: unknown.
    frequency_hz: pulses a second of each muscle.
    lowest_width_s, highest_width_s, width_current_a: (muscles,), usable pulse widths and the current of
        these, as found before the recording; NaN where unknown.
    electrodes: by muscle, in words.
    notes: in words, such as what the torque is.
    source, source_format: file that the numbers come from, and its form.
    steady, courses, movements, forces: the recordings; None or empty where there are none.
    """

    person: str
    muscles: tuple[str, ...]
    joints: tuple[str, ...]
    zero_rad: Annotated[Array, Sized(("joints",), True)]
    friction_nm: Annotated[Array, Sized(("joints",), True)]
    frequency_hz: float
    lowest_width_s: Annotated[Array, Sized(("muscles",), True)]
    highest_width_s: Annotated[Array, Sized(("muscles",), True)]
    width_current_a: Annotated[Array, Sized(("muscles",), True)]
    source: str
    source_format: str
    side: Literal["left", "right", ""] = ""
    electrodes: Mapping[str, str] = field(default_factory=dict)
    notes: str = ""
    steady: SteadyTrials | None = None
    courses: tuple[TorqueCourse, ...] = ()
    movements: tuple[Movement, ...] = ()
    forces: tuple[ForceCourse, ...] = ()

    def __post_init__(self) -> None:
        _require_names(self)
        if not 0.0 < self.frequency_hz < np.inf:
            raise InputError("frequency_hz", f"{self.frequency_hz}", "more than 0")
        for place, part in self.parts():
            _require_sound(part, place, {"muscles": len(self.muscles), "joints": len(self.joints)})
        if self.steady is not None:
            _require_sound_trials(self.steady, self.muscles, self.joints)
        for place, part in self.parts():
            if isinstance(part, (TorqueCourse, ForceCourse)) and not 0 <= part.muscle < len(self.muscles):
                raise InputError(f"{place}: muscle", f"{part.muscle}", f"0 to {len(self.muscles) - 1}")
            if isinstance(part, ForceCourse) and not np.isfinite(part.force_n).any():
                raise InputError(f"{place}: force_n", "holds no number", "one or more samples of force")
            if hasattr(part, "period_s") and not 0.0 < part.period_s < np.inf:
                raise InputError(f"{place}: period_s", f"{part.period_s}", "more than 0")
            if hasattr(part, "device_torque_nm"):
                require_possible_torque(part.device_torque_nm, self.joints, place)
                require_possible_pulses(part.pulse_width_s, part.current_a, place)
                _require_possible_angles(part.angle_rad, self.joints, place)
        for kind in ("courses", "movements", "forces"):
            names = [part.name for part in getattr(self, kind)]
            if len(set(names)) < len(names):
                twice = next(name for name in names if names.count(name) > 1)
                raise InputError(kind, f"{twice!r} is listed twice", "names that differ")

    def parts(self) -> Iterator[tuple[str, Any]]:
        """The recording itself and all it holds, each with its place in messages."""
        yield "recording", self
        if self.steady is not None:
            yield "steady", self.steady
        for kind in ("courses", "movements", "forces"):
            for part in getattr(self, kind):
                yield f"{kind}: {part.name}", part


class Form(NamedTuple):
    """Form of an array: its type, its axes, and whether it may be left out."""

    dtype: np.dtype[Any]
    sized: Sized
    optional: bool


def _arrays_of(kind: type[Any]) -> dict[str, Form]:
    found: dict[str, Form] = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        for each in (hint, *get_args(hint)):
            sized = next((m for m in getattr(each, "__metadata__", ()) if isinstance(m, Sized)), None)
            if sized is not None:
                dtype = {Whole: "i8", Texts: "U"}.get(each.__origin__, "f8")
                found[name] = Form(np.dtype(dtype), sized, each is not hint)
    return found


ARRAYS: Mapping[type[Any], Mapping[str, Form]] = {kind: _arrays_of(kind) for kind in (
    StimulationRecording, SteadyTrials, TorqueCourse, Movement, ForceCourse)}
"""Forms of the arrays of each part of a recording, by name."""


def _require_sound(part: Any, place: str, sizes: dict[str, int]) -> None:
    """Check type, shape and numbers of a part's arrays, and make them read-only."""
    for name, (dtype, sized, optional) in ARRAYS[type(part)].items():
        values = getattr(part, name)
        if values is None and optional:
            continue
        where = f"{place}: {name}"
        if values.dtype.kind != dtype.kind or values.ndim != len(sized.axes):
            raise InputError(where, f"is of {values.dtype} with {values.ndim} axes",
                             f"{dtype} of {', '.join(sized.axes)}")
        for axis, length in zip(sized.axes, values.shape, strict=True):
            if sizes.setdefault(axis, length) != length:
                raise InputError(where, f"has {length} {axis}, others have {sizes[axis]}", "equal numbers")
        if dtype.kind == "f" and (np.isinf(values).any() or (not sized.lacks and np.isnan(values).any())):
            raise InputError(where, "holds numbers that are not finite",
                             "finite ones" + (", NaN where unknown" if sized.lacks else ""))
        values.flags.writeable = False
    for each in fields(part):
        value = getattr(part, each.name)
        if isinstance(value, float) and np.isnan(value):
            raise InputError(f"{place}: {each.name}", "is not a number", "a finite number")
        for text in _texts_in(value):
            try:
                text.encode()
            except UnicodeEncodeError:
                raise InputError(f"{place}: {each.name}", f"{text!r} is no UTF-8 text",
                                 "text without surrogates") from None


def _texts_in(value: Any) -> list[str]:
    """Texts of a field: its own, or those that it holds."""
    if isinstance(value, np.ndarray):
        return list(np.unique(value)) if value.dtype.kind == "U" else []
    held = [*value, *value.values()] if isinstance(value, Mapping) else value if isinstance(value, tuple) \
        else [value]
    return [each for each in held if isinstance(each, str)]


def _require_names(recording: StimulationRecording) -> None:
    """Check the names of muscles and joints, and that each joint has a direction."""
    for kind, names in (("muscles", recording.muscles), ("joints", recording.joints)):
        for name in names:
            if not name.strip() or in_one_line(name) != name:
                raise InputError(kind, f"{name!r} is no name", "one line of text")
            if names.count(name) > 1:
                raise InputError(kind, f"{name!r} is listed twice", "names that differ")
    if not recording.muscles:
        raise InputError("muscles", "no muscle", "one or more")
    for name in recording.joints:
        direction_of(name, "joints")
    if not recording.joints and (recording.steady is not None or recording.courses or recording.movements):
        raise InputError("joints", "no joint", "one or more, or forces alone")


def utf8_name(path: Path) -> str:
    """Name of a file as UTF-8 text; names of files can be any bytes."""
    return path.name.encode("utf-8", "replace").decode()


def direction_of(joint: str, where: str) -> str:
    """Direction that a joint's name ends in, such as "flexion"; InputError for a name without one."""
    known = [*OPPOSITES, *OPPOSITES.values()]
    found = [each for each in known if joint.endswith(f"_{each}")]
    if not found:
        raise InputError(where, f"{joint!r} does not say which way is positive",
                         f"a joint and its direction ({', '.join(known)})", f"such as {joint}_flexion")
    return found[0]


def largest_torque_nm(joint: str) -> float:
    """Torque that nobody's joint of this name reaches; see `LARGEST_TORQUE_NM`."""
    return next((limit for name, limit in LARGEST_TORQUE_NM.items() if joint.startswith(name)),
                _OTHER_JOINT_NM)


def require_possible_torque(torque_nm: Array, joints: tuple[str, ...], place: str) -> None:
    """Raise InputError for a torque (rows, joints) beyond what a joint can do."""
    for j, joint in enumerate(joints):
        limit, size = largest_torque_nm(joint), np.abs(torque_nm[:, j])
        if (size > limit).any():
            row = int(np.nanargmax(size))
            raise InputError(f"{place}: {joint}: row {row + 1}",
                             f"{torque_nm[row, j]:.4g} N m is beyond what this joint can do",
                             f"at most {limit:g} N m", "check the unit of torque")


def require_possible_pulses(width_s: Array, current_a: Any, place: str) -> None:
    """Raise InputError for pulse widths and currents that no stimulator of muscle gives."""
    given = width_s[width_s != 0.0]
    if given.size and not (given.min() > 0.0 and SHORTEST_PULSE_S <= given.max() <= LONGEST_PULSE_S):
        raise InputError(f"{place}: pulse width", f"is {1e6 * given.min():.4g} to {1e6 * given.max():.4g} us",
                         f"0, or {1e6 * SHORTEST_PULSE_S:g} to {1e6 * LONGEST_PULSE_S:g} us",
                         "check the unit of pulse width")
    currents = np.asarray(current_a)
    if currents.size and (currents.min() < 0.0 or currents.max() > LARGEST_CURRENT_A):
        raise InputError(f"{place}: current",
                         f"is {1e3 * currents.min():.4g} to {1e3 * currents.max():.4g} mA",
                         f"0 to {1e3 * LARGEST_CURRENT_A:g} mA", "check the unit of current")


def _require_possible_angles(angle_rad: Array, joints: tuple[str, ...], place: str) -> None:
    beyond = np.abs(angle_rad) > np.pi
    if beyond.any():
        row, j = np.argwhere(beyond)[0]
        raise InputError(f"{place}: {joints[j]}: row {row + 1}",
                         f"{np.degrees(angle_rad[row, j]):.4g} deg is no angle of a joint",
                         "-180 to 180 deg", "check the unit of angles")


def _require_sound_trials(trials: SteadyTrials, muscles: tuple[str, ...], joints: tuple[str, ...]) -> None:
    """Check what rows of isometric trials say about each other."""
    if not len(trials):
        raise InputError("steady", "holds no trial", "one or more")
    unknown = (trials.muscle < PASSIVE) | (trials.muscle >= len(muscles))
    if unknown.any():
        row = int(np.argmax(unknown))
        raise InputError(f"steady: muscle: row {row + 1}", f"{trials.muscle[row]}",
                         f"0 to {len(muscles) - 1}, or {PASSIVE} in a passive trial")
    apart = np.abs(trials.angle_rad - trials.reference_rad) > _APART_RAD
    if apart.any():
        row, j = np.argwhere(apart)[0]
        at, reference = (np.degrees(each[row, j]) for each in (trials.angle_rad, trials.reference_rad))
        raise InputError(f"steady: row {row + 1}: {joints[j]}",
                         f"is at {at:.4g} deg, its reference is {reference:.4g} deg",
                         f"angles within {np.degrees(_APART_RAD):.3g} deg of their reference",
                         "check units and signs of both")
    pulsed = (trials.pulse_width_s > 0.0) & (trials.current_a > 0.0)
    wrong = pulsed & ~trials.stimulated
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(f"steady: row {row + 1}", "is passive, but has pulses of "
                         f"{1e6 * trials.pulse_width_s[row]:.4g} us and {1e3 * trials.current_a[row]:.4g} mA",
                         "no pulses in passive trials, or the name of a muscle")
    for visit in np.unique(trials.visit):
        here = trials.visit == visit
        postures = np.unique(trials.posture[here])
        if postures.size > 1:
            raise InputError(f"steady: visit {visit}", f"is in {postures.size} postures "
                             f"({', '.join(postures[:3])})", "one posture a visit")
        if trials.baseline == "passive" and trials.stimulated[here].all():
            raise InputError(f"steady: visit {visit}", "has no passive trial",
                             "one a visit, for the baseline 'passive'", "use the baseline 'visit_median'")

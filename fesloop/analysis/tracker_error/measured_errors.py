"""Measures errors of a tracker in a run's recording, against a recorded reference or the plant's truth.

Where the run played a recording of inertial sensors with a reference, the error of each pair of neighbouring
segments is the error of their relative orientation, as a rotation vector in the child's frame: its component
about a joint's axis is the error of the joint's angle, its length the total error of the relative orientation
(`fesloop.experiment.metrics.orientation`). Where the reference's frames are not the sensors', it is the error
of the angle between the two segments. Where truth and estimate are joint angles, it is their difference at
the instant of capture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from fesloop.analysis.tracker_error.error_record import ErrorRecord
from fesloop.analysis.tracker_error.reference_agreement import require_agreement, rotation_vector
from fesloop.errors import InputError
from fesloop.experiment.metrics.joints import columns, held
from fesloop.experiment.metrics.scoring import measuring, never_aligned
from fesloop.experiment.recording.reading import Recording, Signal
from fesloop.experiment.score_spec import Score
from fesloop.forms.schema import make
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import FOREVER, NS_PER_S
from fesloop.loop.signals import NEVER
from fesloop.streams.blocks.replay import replay_of
from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]
_AXES = "xyz"
_MOVED_DEG, _MOVED_SHARE = 5.0, 0.2
"""Least RMS motion about an axis about which a joint moves: absolute, and as a share of the greatest axis."""
_RATE_S, _RATE_ORDER = 0.2, 3
"""Window and order of the polynomial fit that gives a measured angle's rate (chosen: noise in differences of
samples makes a delay look shorter; a sine of 2 Hz keeps 0.97 of its rate)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredErrors:
    """Errors of a tracker in a run.

    Attributes
    ----------
    records: one per angle, all at the same instants.
    cut_s: middle of the recording.
    estimates: the tracker's output. lost: (n,), ticks for which a sensor's sample was lost.
    recorded: whether the errors are against a recorded reference rather than a plant's truth.
    source: recording and tracker, in words. tracker: its kind; empty for a run, whose truth is its plant's.
    """

    records: tuple[ErrorRecord, ...]
    cut_s: float
    estimates: Signal
    lost: NDArray[np.bool_]
    recorded: bool
    source: str
    tracker: str = ""


def measured_errors(recording: Recording, reference_late_ns: int = 0) -> MeasuredErrors:
    """Measure the errors in trial 0 of a run.

    `reference_late_ns` is the delay of a recorded reference's stamps; negative where they are early.

    Raises InputError for a run that neither played a reference nor scores an estimate against a truth.
    """
    score = recording.experiment["score"]
    if score.get("orientation") and score.get("recording"):
        return _against_reference(recording, score["orientation"], score["recording"], reference_late_ns)
    if score.get("truth") and score.get("estimate"):
        return _against_truth(recording, score)
    raise InputError(str(recording.path), "compares no tracker with a reference or a truth",
                     "a run whose [score] has orientation and recording, or truth and estimate")


def _against_reference(recording: Recording, name: str, player: str, late_ns: int) -> MeasuredErrors:
    table = recording.experiment["blocks"][player]
    played = replay_of(table)
    source, reference = played.source, played.source.reference
    if reference is None or not source.pairs:
        raise InputError(table["recording"], "has no reference of two neighbouring segments",
                         "a recording with one, such as of the sets chain5 and wrist")
    require_agreement(source)
    signal = recording.signal(name)
    scored_ticks = measuring(recording, make(Score, recording.experiment["score"], {}, "score"), name, signal)
    captured = signal.newest_ns[scored_ticks] + played.start_ns
    _require_aligned(recording, name)
    stamps = reference.stamps_ns - late_ns
    inside = (stamps >= captured.min(initial=FOREVER)) & (stamps <= captured.max(initial=NEVER))
    if inside.sum() < 2:
        raise InputError(str(recording.path), f"{name} has no estimate captured during the reference",
                         "estimates of the whole run")
    at, scored = stamps[inside], reference.scored[inside]
    estimate = quaternion.interpolate(captured, signal.values[scored_ticks], at)
    true = reference.orientation[inside]
    times_s = (at - played.start_ns) / NS_PER_S
    cut_s = 0.5 * float(times_s[0] + times_s[-1])
    records: list[ErrorRecord] = []
    for parent, child in source.pairs:
        pair = source.pair_name((parent, child))
        ends = (quaternion.relative(estimate[:, parent], estimate[:, child]),
                quaternion.relative(true[:, parent], true[:, child]))
        errors = _orientation_errors if reference.sensor_frames else _angle_errors
        records += errors(pair, times_s, *ends, scored, cut_s)
    kind = recording.experiment["blocks"][name.partition(".")[0]]["kind"]
    of_set = f" {source.sensor_set}" if source.sensor_set else ""
    return MeasuredErrors(records=tuple(records), cut_s=cut_s, estimates=signal,
                          lost=_lost_samples(source, captured, scored_ticks), recorded=True,
                          source=f"{source.path.name}{of_set}, tracker {kind}", tracker=kind)


def _require_aligned(recording: Recording, estimate: str) -> None:
    """Raise InputError for an estimate whose tracker never took its initial pose, with its last event."""
    why = never_aligned(recording, estimate, 0)
    if why is None:
        return
    tracker = why.partition(" ")[0]
    details = [event.detail for event in recording.events
            if event.where == tracker and event.status == "initial_pose_failed"]
    raise InputError(str(recording.path), why + (f" ({details[-1]})" if details else ""),
                     "a tracker that aligns within the recording",
                     "record a still initial pose, choose a part that begins in one (blocks.recording."
                     "start_s), or a tracker without one, such as vqf")


def _lost_samples(source: MotionRecording, captured: NDArray[np.int64],
                  scored: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a tick's sample is missing, for a sensor of some pair or altogether, (ticks,)."""
    sensors = sorted({sensor for pair in source.pairs for sensor in pair})
    missing = np.logical_not(np.isfinite(source.gyr[:, sensors] + source.acc[:, sensors]).all(axis=(1, 2)))
    lost = np.zeros(scored.size, dtype=bool)
    newest = np.clip(np.searchsorted(source.stamps_ns, captured), 0, missing.size - 1)
    lost[scored] = missing[newest] | (source.stamps_ns[newest] != captured)  # or it is in a gap
    return lost


def _orientation_errors(pair: str, times_s: Array, estimate: Array, true: Array, scored: NDArray[np.bool_],
                     cut_s: float) -> list[ErrorRecord]:
    """The three components of a relative orientation's error; orientations (n, 4), child to parent."""
    early = (times_s < cut_s) & scored & np.isfinite(true).all(axis=1)
    if not early.any():
        return []
    centre = mean_orientation(true[early])
    posture = rotation_vector(quaternion.relative(centre, true))
    error = rotation_vector(quaternion.relative(true, estimate))
    error[~scored] = np.nan
    spread = np.degrees(np.sqrt(np.mean(np.square(posture[early]), axis=0)))
    moved = (spread > _MOVED_DEG) & (spread > _MOVED_SHARE * spread.max())
    records = []
    for axis in range(3):
        driver = axis if moved[axis] else int(np.argmax(spread))
        angle = np.unwrap(filled(times_s, posture[:, driver]))
        records.append(ErrorRecord(name=f"{pair}.{_AXES[axis]}", moved=bool(moved[axis]), times_s=times_s,
                                   error=error[:, axis], angle=angle, rate=rate_of(times_s, angle)))
    return records


def _angle_errors(pair: str, times_s: Array, estimate: Array, true: Array, scored: NDArray[np.bool_],
              cut_s: float) -> list[ErrorRecord]:
    """The error of the angle between two segments."""
    angle = quaternion.rotation_angle(true)
    early = (times_s < cut_s) & scored & np.isfinite(angle)
    if not early.any():
        return []
    error = np.where(scored, quaternion.rotation_angle(estimate) - angle, np.nan)
    centred = filled(times_s, angle) - float(np.mean(angle[early]))
    return [ErrorRecord(name=f"{pair}.angle", moved=True, times_s=times_s, error=error, angle=centred,
                        rate=rate_of(times_s, centred))]


def _against_truth(recording: Recording, score: dict[str, object]) -> MeasuredErrors:
    """Errors of joint angles of a simulated hand."""
    estimate, truth = str(score["estimate"]), str(score["truth"])
    signal = recording.signal(estimate)
    scored_ticks = measuring(recording, make(Score, score, {}, "score"), estimate, signal)
    _require_aligned(recording, estimate)
    captured, newest = np.unique(signal.newest_ns[scored_ticks], return_index=True)
    if captured.size < 2:
        raise InputError(str(recording.path), f"{estimate} has fewer than two captures",
                         "estimates of the whole run")
    values = columns(signal.values[scored_ticks][newest])
    true = columns(held(recording.column(truth), captured))
    times_s = captured / NS_PER_S
    cut_s = 0.5 * float(times_s[0] + times_s[-1])
    early = times_s < cut_s
    names = _joint_names(score, values.shape[1])
    centred = true - np.nanmean(true[early], axis=0)
    angles = [filled(times_s, column) for column in centred.T]
    records = [ErrorRecord(name=name, moved=True, times_s=times_s, error=values[:, i] - true[:, i],
                           angle=angles[i], rate=np.gradient(angles[i], times_s))
               for i, name in enumerate(names)]
    return MeasuredErrors(records=tuple(records), cut_s=cut_s, estimates=signal,
                          lost=np.zeros(signal.times_ns.size, dtype=bool), recorded=False,
                          source=f"{recording.name} {recording.fingerprint[:12]} {estimate}")


def _joint_names(score: dict[str, object], count: int) -> tuple[str, ...]:
    given = score.get("joints")
    if isinstance(given, list) and len(given) == count:
        return tuple(str(name) for name in given)
    freedoms = hand_tree(HandSize()).freedoms
    return freedoms if len(freedoms) == count else tuple(f"angle {i}" for i in range(count))


def rate_of(times_s: Array, angle: Array) -> Array:
    """Rate of a measured angle (n,), rad/s, from cubic fits, or from differences of few samples."""
    size = 2 * round(0.5 * _RATE_S / float(np.median(np.diff(times_s)))) + 1
    if size <= _RATE_ORDER + 2 or size > angle.size:
        return np.gradient(angle, times_s)
    slopes = savgol_filter(np.stack([angle, times_s]), size, _RATE_ORDER, deriv=1)
    return np.asarray(slopes[0] / slopes[1])


def mean_orientation(q: Array) -> Array:
    """Mean of orientations (n, 4) with the least mean square distance: (4,) (doi 10.2514/1.28949)."""
    _, vectors = np.linalg.eigh(q.T @ q)
    return np.asarray(vectors[:, -1])


def filled(times_s: Array, values: Array) -> Array:
    """Values (n,) with NaN replaced by interpolation."""
    known = np.isfinite(values)
    return np.interp(times_s, times_s[known], values[known])

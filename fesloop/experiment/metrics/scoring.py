"""Metrics of a run, computed from the signals of its recording that [score] names."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.cycles import cycle_metrics
from fesloop.experiment.metrics.grasp import grasp_metrics
from fesloop.experiment.metrics.joints import (
    Trace,
    by_tip,
    columns,
    coverage,
    fingertip_error,
    fingertip_rmse_mm,
    held,
    joint_rmse_deg,
    range_deg,
    rmse_deg,
    split_error,
    tracker_rmse_deg,
    unmoved_rmse_deg,
)
from fesloop.experiment.metrics.missing import MISSING, give_reasons, note
from fesloop.experiment.metrics.search import search_metrics
from fesloop.experiment.recording.reading import Recording, Signal
from fesloop.experiment.score_spec import Score
from fesloop.experiment.specification import with_transport
from fesloop.forms.schema import make
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import FOREVER, NS_PER_S
from fesloop.loop.signals import NEVER, Sample
from fesloop.loop.wire import Link, Wire

if TYPE_CHECKING:
    from fesloop.streams.recording import MotionRecording

_SPLIT = ("total", "tracker", "controller")
_OF_PAIRS = ("vqf", "vqf9", "seel_ruppin")
"""Kinds of trackers whose angles are the flexion between pairs of sensors."""


@np.errstate(over="ignore", invalid="ignore")  # an unstable loop: what is infinite then has its reason
def metrics_of(recording: Recording) -> dict[str, Any]:
    """Compute the metrics of the experiment's [score].

    joint_rmse_deg: one a trial, truth against reference; unmoved_rmse_deg: what it would be had the joints
    stayed where they were when the trial began. Both hold the reference between its own ticks, so a reference
    that moves is a staircase. tracker_rmse_deg: one a trial, estimate against
    the truth of the instant of its capture, once the tracker has taken its initial pose: earlier
    outputs are assumptions. split_rmse_deg: the error of the movement (total), the part that the controller
    cannot observe (tracker, latency included), and the part that it observes and does not correct
    (controller), one a trial; split_from_s: the first instant that counts for these, at which the trial is
    scored (after_s), the reference is known, and an estimate that an aligned tracker put out had reached the
    controller: the total need not be joint_rmse_deg. Under joints the same by joint; range_deg, how far each
    joint moved, where only truth is scored. `grasp_metrics`, `cycle_metrics`, `search_metrics` and
    `sweep_metrics` describe their own. orientation_rmse_deg and relative_angle_rmse_deg: against the
    reference of the recording that was played, from orientation_from_s on where the tracker is aligned later.
    joint_angle_rmse_deg: by pair, of the angle that the tracker gives to a controller, against that of the
    reference by the same convention; flexion_axis_share: share of a pair's turning about the axis of that
    angle, where it turns.
    fingertip_rmse_mm: by tracker and fingertip, one a trial; fingertip_coverage likewise, where the tracker
    gives its sd. step_us: median and 99th percentile of the timed blocks' steps. missing: of every number
    that is NaN or None the reason in words (`fesloop.experiment.metrics.missing`).
    """
    score = make(Score, recording.experiment["score"], {}, "score")
    metrics = _joint_metrics(recording, score)
    if score.orientation is not None:
        metrics |= _orientation_metrics(recording, score)
        note(metrics, ("orientation_rmse_deg",), 0, 1, never_aligned(recording, score.orientation, 0))
    if score.fingertips is not None:
        metrics |= _fingertip_metrics(recording, score, score.fingertips)
    if score.grasp is not None:
        reasons = metrics.pop(MISSING, {})
        metrics |= grasp_metrics(recording, score.grasp)
        if reasons:
            metrics[MISSING] = reasons | metrics.get(MISSING, {})
    if score.cycles is not None:
        metrics |= cycle_metrics(recording, score.cycles)
    if score.search is not None:
        metrics |= search_metrics(recording, score.search)
    sweep = next((name for name, table in recording.experiment["blocks"].items()
                  if table.get("kind") == "element_sweep" and f"{name}.stair" in recording.signals), None)
    if sweep is not None and score.truth is not None:
        from fesloop.experiment.metrics.sweep import sweep_metrics

        truth = [_trace(recording, score.truth, trial, 0.0) for trial in range(recording.trials)]
        found = sweep_metrics(recording, sweep, truth, _joint_names(score, truth))
        for name, values in found.pop("joints", {}).items():
            metrics["joints"][name] |= values
        metrics |= found
    if score.intention is not None:
        from fesloop.experiment.metrics.intention import intention_metrics

        metrics |= intention_metrics(recording, score.intention)
    for name, times in recording.step_times_ns.items():
        if times.size:
            median, p99 = np.percentile(times, [50, 99]) / 1e3
            metrics.setdefault("step_us", {})[name] = {"median": float(median), "p99": float(p99)}
    give_reasons(metrics)
    return metrics


def _joint_metrics(recording: Recording, score: Score) -> dict[str, Any]:
    """Metrics of joint angles that the score's signals allow."""
    trials = range(recording.trials)
    truth = [_trace(recording, score.truth, trial, score.after_s, score.until_s) for trial in trials]
    references = [_trace(recording, score.reference, trial, 0.0) for trial in trials]
    metrics: dict[str, Any] = {}
    joints: dict[str, Any] = {name: {} for name in _joint_names(score, truth)}
    if score.truth and not (score.reference or score.estimate):
        _add_by_joint(joints, "range_deg", [range_deg(trace) for trace in truth])
    if score.truth and score.reference:
        pairs = list(zip(truth, references, strict=True))
        metrics["joint_rmse_deg"] = joint_rmse_deg(pairs)
        begun = [_trace(recording, score.truth, trial, 0.0)[1][:1] for trial in trials]
        metrics["unmoved_rmse_deg"] = unmoved_rmse_deg(pairs, [
            rows[0] if len(rows) else np.full(rows.shape[1:], np.nan) for rows in begun])
        _add_by_joint(joints, "joint_rmse_deg", [rmse_deg(*pair) for pair in pairs])
    if score.truth and score.estimate:
        pairs = [_seen(recording, score, trial) for trial in trials]
        metrics["tracker_rmse_deg"] = tracker_rmse_deg(pairs)
        unaligned = [never_aligned(recording, score.estimate, trial) for trial in trials]
        for trial, why in enumerate(unaligned):
            for path in _of_the_tracker(joints, score.reference is not None):
                note(metrics, path, trial, len(pairs), why)
        _add_by_joint(joints, "tracker_rmse_deg", [rmse_deg(*pair) for pair in pairs])
        del pairs
    if score.truth and score.estimate and score.reference:
        splits = [split_error(true, _measured(recording, score.estimate, trial), reference)
                  for trial, (true, reference) in enumerate(zip(truth, references, strict=True))]
        metrics["split_rmse_deg"] = {part: [float(np.sqrt(np.mean(getattr(split, part) ** 2)))
                                            for split in splits] for part in _SPLIT}
        metrics["split_from_s"] = [split.from_s for split in splits]
        for part in _SPLIT:
            _add_by_joint(joints, f"split_{part}_deg", [getattr(split, part) for split in splits])
    return metrics | ({"joints": joints} if joints else {})


def _joint_names(score: Score, truth: Sequence[Trace]) -> tuple[str, ...]:
    """Names in the score; else the hand's freedoms, if the truth has as many angles."""
    if score.joints or not truth:
        return score.joints
    freedoms = hand_tree(HandSize()).freedoms
    return freedoms if truth[0][1].shape[1:] == (len(freedoms),) else ()


def _add_by_joint(joints: dict[str, Any], metric: str, trials: list[NDArray[np.float64]]) -> None:
    for number, values in enumerate(joints.values()):
        values[metric] = [float(np.atleast_1d(trial)[number]) for trial in trials]


def _trace(recording: Recording, name: str | None, trial: int, after_s: float,
           until_s: float | None = None) -> Trace:
    """A signal between two instants; an empty trace if none is named."""
    if name is None:
        return np.empty(0, np.int64), np.empty((0, 0))
    until_ns = FOREVER if until_s is None else _ns(until_s)
    return recording.column(name, trial, _ns(after_s), until_ns)


def _ns(seconds: float) -> int:
    """Nearest instant, ns: 1.001 s is less than 1001 ms in floats."""
    return round(seconds * NS_PER_S)


def _seen(recording: Recording, score: Score, trial: int) -> tuple[Trace, Trace]:
    """The estimate, stamped with the newest capture of each value, and the whole truth."""
    assert score.estimate is not None
    signal = recording.signal(score.estimate, trial)
    counted = measuring(recording, score, score.estimate, signal, trial)
    captured = signal.newest_ns[counted]
    return (captured, signal.values[counted]), _trace(recording, score.truth, trial, 0.0)


def measuring(recording: Recording, score: Score, name: str, signal: Signal,
              trial: int = 0) -> NDArray[np.bool_]:
    """Rows of a tracker's output that count: from a capture, in the scored time, after alignment."""
    counted = (signal.newest_ns >= 0) & (signal.times_ns >= _ns(score.after_s))
    if score.until_s is not None:
        counted &= signal.times_ns <= _ns(score.until_s)
    return counted & _from_aligned(recording, name, signal, trial)


def _from_aligned(recording: Recording, name: str, signal: Signal, trial: int) -> NDArray[np.bool_]:
    """Rows that derive from a step at which their tracker was aligned.

    An output of the tracker itself is of the same step. One of a block behind it is of the newest step whose
    captures it has: it may be put out when the tracker is aligned, and come from before.
    """
    aligned = np.ones(signal.times_ns.size, bool)
    for flag in alignments(recording, name):
        flags = recording.signal(flag, trial)
        same = flag.partition(".")[0] == name.partition(".")[0]
        since, at = (flags.times_ns, signal.times_ns) if same else (flags.newest_ns, signal.newest_ns)
        aligned &= columns(held((since, flags.values), at))[:, 0] > 0.5
    return aligned


def alignments(recording: Recording, estimate: str) -> list[str]:
    """Outputs `aligned` of the trackers that an estimate derives from, up to blocks that stimulate."""
    units = recording.units
    stimulating = {name.partition(".")[0] for name, unit in units.items() if unit.startswith("A,s")}
    found, seen, ends = [], set(), [estimate.partition(".")[0]]
    while ends:
        node = ends.pop()
        if node in seen or node in stimulating:
            continue
        seen.add(node)
        if f"{node}.aligned" in units:
            found.append(f"{node}.aligned")
            continue
        ends += [wire["from"].partition(".")[0] for wire in recording.experiment["wires"]
                 if wire["to"].partition(".")[0] == node]
    return found


def never_aligned(recording: Recording, estimate: str, trial: int) -> str | None:
    """Reason why no row of an estimate counts in a trial without an initial pose; else None."""
    names = [name for name in alignments(recording, estimate)
             if not (recording.signal(name, trial).values > 0.5).any()]
    return (f"{names[0].partition('.')[0]} never took its initial pose, or learnt its joints' axes: what it "
            "put out is the pose that it was given, or zero" if names else None)


def _of_the_tracker(joints: Mapping[str, Any], split: bool) -> list[tuple[str, ...]]:
    """Paths of the metrics that use an estimate."""
    paths: list[tuple[str, ...]] = [("tracker_rmse_deg",)]
    paths += [("joints", name, "tracker_rmse_deg") for name in joints]
    if split:
        paths += [("split_from_s",), *(("split_rmse_deg", part) for part in _SPLIT)]
        paths += [("joints", name, f"split_{part}_deg") for name in joints for part in _SPLIT]
    return paths


def _measured(recording: Recording, name: str, trial: int) -> Trace:
    """Estimates as they arrive at the controller; NaN until one of an aligned tracker has arrived."""
    signal = recording.signal(name, trial)
    since = np.maximum.accumulate(_from_aligned(recording, name, signal, trial))
    if not since.all():
        values = np.array(signal.values)
        values[~since] = np.nan
        signal = replace(signal, values=values)
    return _arrived(recording, signal, trial)


def _arrived(recording: Recording, signal: Signal, trial: int) -> Trace:
    """A signal as it arrives at the end of its first wire."""
    table = next((wire for wire in recording.experiment["wires"] if wire["from"] == signal.name), None)
    if table is None:
        return signal.left_ns, signal.values
    ends = {"from": "source", "to": "target"}
    table = with_transport(table, recording.experiment)
    wire: Wire = make(Wire, {ends.get(key, key): value for key, value in table.items()}, {}, signal.name)
    return _through(wire, signal, recording.seed, trial)


def _through(wire: Wire, signal: Signal, seed: int, trial: int) -> Trace:
    """Arrivals over a wire, with the jitter and the losses that the run had."""
    link = Link(wire, seed, trial)
    if link.plain:
        return signal.left_ns + link.latency_ns, signal.values
    rows, arrivals = array("q"), array("q")
    held = Sample(0.0, NEVER, NEVER, NEVER)
    for row, (index, left) in enumerate(zip(signal.indices, signal.left_ns, strict=True)):
        # The number of the row replaces the value. Nothing sent from now on arrives before now.
        held = _deliver(link, int(left), held, rows, arrivals)
        link.send(int(index), float(row), NEVER, NEVER, int(left))
    _deliver(link, FOREVER, held, rows, arrivals)
    return np.array(arrivals, np.int64), signal.values[np.array(rows, np.int64)]


def _deliver(link: Link, before_ns: int, held: Sample, rows: array[int], arrivals: array[int]) -> Sample:
    """Add the messages that arrive before an instant to `rows` and `arrivals`; return the newest sample."""
    while link.queue and link.queue[0][3] < before_ns:
        taken = link.take(held)
        if taken is not held:
            held = taken
            rows.append(int(cast(float, held.value)))
            arrivals.append(held.arrived_ns)
    return held


def _fingertip_metrics(recording: Recording, score: Score, truth: str) -> dict[str, Any]:
    """Error of each tracker's fingertips, and the coverage of its 95 % intervals."""
    rmse: dict[str, Any] = {}
    covered: dict[str, Any] = {}
    for tracker in score.trackers:
        errors, shares = [], []
        for trial in range(recording.trials):
            true = recording.column(truth, trial)
            signal = recording.signal(f"{tracker}.fingertips", trial)
            counted = (signal.newest_ns >= 0) & (signal.times_ns >= _ns(score.after_s))
            error = fingertip_error((signal.newest_ns[counted], signal.values[counted]), true)
            errors.append(fingertip_rmse_mm(error))
            if f"{tracker}.fingertip_sd" in recording.signals:
                sd = recording.signal(f"{tracker}.fingertip_sd", trial).values[counted]
                shares.append(coverage(error, sd[len(sd) - len(error):]))
        names = score.tips or tuple(f"F{i + 1}" for i in range(len(errors[0]) if errors else 0))
        rmse[tracker] = by_tip(errors, names)
        if shares:
            covered[tracker] = by_tip(shares, names)
    return {"fingertip_rmse_mm": rmse} | ({"fingertip_coverage": covered} if covered else {})


def _orientation_metrics(recording: Recording, score: Score) -> dict[str, Any]:
    """The tracker's orientations against the reference of the recording that was played."""
    from fesloop.experiment.metrics.orientation import score_recording
    from fesloop.streams.blocks.replay import replay_of

    assert score.orientation is not None
    assert score.recording is not None
    played = replay_of(recording.experiment["blocks"][score.recording])
    signal = recording.signal(score.orientation)
    tracker = score.orientation.partition(".")[0]
    magnetic = any(wire["to"] == f"{tracker}.mag" for wire in recording.experiment["wires"])
    captured = signal.newest_ns >= 0
    # NaN, not left out: no orientation is interpolated across the time in which a tracker was not aligned.
    counted = measuring(recording, score, score.orientation, signal)[captured]
    orientation = np.where(counted[:, np.newaxis, np.newaxis], signal.values[captured], np.nan)
    scores: dict[str, Any] = score_recording(played.source, signal.newest_ns[captured] + played.start_ns,
                             orientation, "absolute" if magnetic else "relative")
    times_ns = signal.times_ns[captured]
    if scores and not counted[times_ns >= _ns(score.after_s)][0]:
        scores["orientation_from_s"] = float(times_ns[counted][0]) / NS_PER_S
    return scores | _angle_metrics(recording, score, played.source, tracker, played.start_ns)


def _angle_metrics(recording: Recording, score: Score, source: MotionRecording, tracker: str,
                   start_ns: int) -> dict[str, Any]:
    """Error of the angles of a tracker of pairs, and the share of rotation about their axis."""
    from fesloop.experiment.metrics.orientation import flexion_axis_share, flexion_rmse_deg

    table = recording.experiment["blocks"][tracker]
    pairs = [(int(p), int(c)) for p, c in table.get("pairs") or source.pairs]
    if table["kind"] not in _OF_PAIRS or not pairs:
        return {}
    signal = recording.signal(f"{tracker}.angles")
    counted = measuring(recording, score, f"{tracker}.angles", signal)
    captured, first = np.unique(signal.newest_ns[counted] + start_ns, return_index=True)
    if captured.size < 2:
        return {}
    found: dict[str, dict[str, float]] = {"joint_angle_rmse_deg": {}, "flexion_axis_share": {}}
    for number, pair in enumerate(pairs):
        name = source.pair_name(pair)
        if source.reference is not None and source.reference.sensor_frames:
            error = flexion_rmse_deg(captured, signal.values[counted][first, number], source.reference, pair)
            if np.isfinite(error):
                found["joint_angle_rmse_deg"][name] = error
        oriented = recording.signal(str(score.orientation))
        known = oriented.newest_ns >= 0
        ends = (oriented.values[known][:, end] for end in pair)
        share = flexion_axis_share(oriented.newest_ns[known], quaternion.relative(*ends))
        if share is not None:
            found["flexion_axis_share"][name] = share
    return {name: values for name, values in found.items() if values}

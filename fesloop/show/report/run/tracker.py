"""Section of a report on tracker quality: estimates against the truth, by joint and over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import columns, held
from fesloop.experiment.recording.reading import SignalTable
from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.parts import Bars, Chart, Line, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import Course, from_zero, thinned
from fesloop.show.report.run.words import joint_label, listed, rounded

Array = NDArray[np.float64]
_MOST_PCT = 98.0
"""Percentile of errors that sets the axis (chosen: errors before convergence would dwarf the rest)."""


def tracker_section(known: Known) -> Section | None:
    """Section on tracker quality; None if no tracker is scored."""
    parts = [*_joints(known), *_fingertips(known), *_orientations(known), *_step_times(known)]
    if not parts:
        return None
    about = Paragraph(text="Estimates are compared with the truth at the instant at which their newest "
                           "sample was captured, so that latency does not count as error.")
    return Section(key="tracker", title="Tracker quality", parts=[about, *parts])


def _joints(known: Known) -> Iterator[Part]:
    """Bars of the error by joint, and charts of the error over time."""
    joints: dict[str, Any] = known.metrics.get("joints") or {}
    errors = {name: each["tracker_rmse_deg"] for name, each in joints.items() if "tracker_rmse_deg" in each}
    for trial in known.trials if errors else ():
        if not any(math.isfinite(values[trial]) for values in errors.values()):
            continue
        yield Bars(key=f"tracker-joints-{trial}", title="Tracker's error by joint, RMS", x_label="error, deg",
                   names=[joint_label(name) for name in errors],
                   values={"estimate against truth": [values[trial] for values in errors.values()]},
                   roles={"estimate against truth": "tracker"}, stacked=False, trial=trial,
                   text=f"Error of the tracker at each joint in trial {trial}.")
    estimate, truth = known.scored("estimate"), known.scored("truth")
    for trial in known.trials if estimate and truth else ():
        lines = _error_lines(known, estimate, truth, trial)
        if any(np.isfinite(line.y).any() for line in lines):
            high, cut = _most(lines)
            yield Chart(key=f"tracker-course-{trial}",
                        title=f"Tracker's error over time, RMS over joints{cut}", x_label="time, s",
                        y_label="error, deg", lines=lines, marks=known.scored_while(), trial=trial,
                        timed=True, limits=(0.0, high),
                        text=f"Distance of the estimate from the truth in trial {trial}.")


def _error_lines(known: Known, estimate: str, truth: str, trial: int) -> list[Line]:
    """Lines of the error and, if the tracker reports it, of its standard deviation."""
    wanted = known.recording.column(truth, trial)
    (table,) = known.recording.tables([estimate], trial)
    found = thinned(((captured, _rms_deg(columns(values) - columns(held(wanted, captured))))
                     for captured, values in _derived(table)), table.count)
    lines = [] if found is None else [found.line("estimate against truth", "tracker")]
    deviation = _deviation(known, estimate)
    if deviation and lines:
        (table,) = known.recording.tables([deviation], trial)
        told_of = thinned(((captured, _rms_deg(values)) for captured, values in _derived(table)), table.count)
        if told_of is not None:
            name = "standard deviation reported by the tracker"
            lines.append(told_of.line(name, "estimate", style="dashed"))
    return lines


def _derived(table: SignalTable) -> Iterator[tuple[NDArray[np.int64], Array]]:
    """Captures, ns, and values of the rows that derive from one."""
    for piece in table.pieces():
        there = piece.newest_ns >= 0
        yield piece.newest_ns[there], piece.values[0][there]


def _most(lines: list[Line]) -> tuple[float, str]:
    """Upper end of the axis, above all or most values, and a remark for the title if peaks are cut off."""
    values = np.concatenate([line.y if line.high is None else line.high for line in lines])
    known = values[np.isfinite(values)]
    if not known.size:
        return 1.0, ""
    most, greatest = 1.5 * float(np.percentile(known, _MOST_PCT)), 1.05 * float(known.max())
    return (most, f" (peaks up to {rounded(float(known.max()))} deg cut off)") if 0.0 < most < greatest \
        else (greatest or 1.0, "")


def _rms_deg(values: Array) -> Array:
    """RMS over the joints, (n,), deg."""
    return np.asarray(np.degrees(np.sqrt(np.mean(np.square(values.reshape(len(values), -1)), axis=1))))


def _deviation(known: Known, estimate: str) -> str:
    """Name of the signal with a tracker's standard deviation; empty if none is recorded."""
    node, _, port = estimate.partition(".")
    names = (f"{node}.{port.removesuffix('s')}_sd", f"{node}.sd")
    return next((name for name in names if name in known.signals), "")


def _fingertips(known: Known) -> Iterator[Part]:
    """Bars of the fingertip errors by tracker, and charts over time."""
    errors = known.metrics.get("fingertip_rmse_mm")
    if not isinstance(errors, dict) or not errors:
        return
    roles = {tracker: f"series-{number % 8}" for number, tracker in enumerate(errors)}
    tips = list(next(iter(errors.values())))
    for trial in known.trials:
        sizes = {tracker: [values[trial] for values in each.values()] for tracker, each in errors.items()}
        if any(math.isfinite(size) for each in sizes.values() for size in each):
            yield Bars(key=f"tracker-tips-{trial}", title="Error of the fingertips, RMS", x_label="error, mm",
                       names=tips, values=sizes, roles=roles, stacked=False, trial=trial,
                       text=f"Error of each fingertip by tracker in trial {trial}.")
        lines = [found.line(tracker, roles[tracker]) for tracker in errors
                 if (found := tip_course(known, tracker, trial)) is not None]
        if lines:
            yield Chart(key=f"tracker-tips-course-{trial}", x_label="time, s", y_label="error, mm",
                        lines=lines,
                        title="Error of the fingertips over time, RMS over them", trial=trial, timed=True,
                        limits=from_zero(lines),
                        text=f"Distance of {listed(list(errors))} from the truth in trial {trial}.")
    covered = known.metrics.get("fingertip_coverage")
    if isinstance(covered, dict):
        yield Table(title="Share of the truth inside the tracker's 95 % interval, last trial, %",
                    columns=["tracker", *tips],
                    rows=[[tracker, *(rounded(100.0 * values[-1]) for values in each.values())]
                          for tracker, each in covered.items()])


def tip_course(known: Known, tracker: str, trial: int) -> Course | None:
    """Distance between estimated and true fingertips over a trial, mm, RMS over the five."""
    name, truth = f"{tracker}.fingertips", known.scored("fingertips")
    if name not in known.signals or not truth:
        return None
    wanted = known.recording.column(truth, trial)
    after_ns = (known.score.get("after_s") or 0.0) * NS_PER_S
    (table,) = known.recording.tables([name], trial)

    def distances(times: NDArray[np.int64], captured: NDArray[np.int64], values: Array) -> Array:
        apart = np.square(values - held(wanted, captured)).sum(axis=2).mean(axis=1)
        return np.where((captured >= 0) & (times >= after_ns), 1e3 * np.sqrt(apart), np.nan)

    return thinned(((piece.times_ns, distances(piece.times_ns, piece.newest_ns, piece.values[0]))
                    for piece in table.pieces()), table.count)


def _orientations(known: Known) -> Iterator[Part]:
    """Tables of errors against the reference of a replayed recording."""
    for name, title in (("orientation_rmse_deg", "Error of orientations, RMS, deg"),
                        ("relative_angle_rmse_deg", "Error of the angle between two orientations, RMS, deg"),
                        ("joint_angle_rmse_deg", "Error of joint angles at the controller, RMS, deg"),
                        ("flexion_axis_share", "Share of the turning that is about the axis of the angle")):
        errors = known.metrics.get(name)
        if not isinstance(errors, dict) or not errors:
            continue
        tables = [each for each in errors.values() if isinstance(each, dict)]
        columns = list(dict.fromkeys(key for each in tables for key in each))
        rows = [[what, *((rounded(each.get(column)) for column in columns) if isinstance(each, dict)
                         else (rounded(each),))] for what, each in errors.items()]
        yield Table(title=title, columns=["of", *(columns or ["error"])], rows=rows)


def _step_times(known: Known) -> Iterator[Part]:
    times = known.metrics.get("step_us")
    if isinstance(times, dict) and times:
        yield Table(title="Execution time of a step on this machine, µs", columns=["block", "median", "99 %"],
                    rows=[[block, rounded(each["median"]), rounded(each["p99"])]
                          for block, each in times.items()])

"""Section of a report on tracking by joint: reference, truth and estimate over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.show.report.parts import Chart, Fold, Line, Mark, Paragraph, Part, Section
from fesloop.show.report.run.known import Known, row_names
from fesloop.show.report.run.thinning import FEWER_POINTS, POINTS, Course, course
from fesloop.show.report.run.words import joint_label, rounded

Array = NDArray[np.float64]
_DEG = float(np.degrees(1.0))
_MOVES_DEG = 1.0
"""Least range of a joint that counts as moving; others are folded (chosen)."""
_MOST_SHOWN = 8
"""Most charts per trial outside folds (chosen)."""


@dataclass(frozen=True, slots=True)
class _Angles:
    """Names of signals of the same joints, each empty if there is none, and a key for them."""

    reference: str
    truth: str
    estimate: str
    key: str


def tracking_section(known: Known) -> Section | None:
    """Section on tracking by joint; None for a run without joint angles."""
    scored = _Angles(known.scored("reference"), known.scored("truth"), known.scored("estimate"), "scored")
    whole = _whole_hand(known)
    every = [angles for angles in (scored, whole) if angles is not None and (angles.truth or angles.estimate)]
    parts = [part for angles in every for part in _parts(known, angles, first=angles is every[0])]
    if not parts:
        return None
    parts.insert(0, Paragraph(text="Values are shown at the instant at which their block put them out: "
                              "estimates lag by the latency of their samples."))
    return Section(key="tracking", title="Tracking by joint", parts=parts)


def _whole_hand(known: Known) -> _Angles | None:
    """Angles of the hand and of the first tracker, unless they are scored anyway."""
    cast = known.cast
    if cast is None or (cast.hand is None and not cast.trackers):
        return None
    truth = f"{cast.hand.name}.angles" if cast.hand is not None else ""
    estimates = [f"{tracker.name}.angles" for tracker in cast.trackers]
    truth = truth if truth in known.signals else ""
    if truth and truth == known.score.get("truth"):
        return None
    return _Angles("", truth, next((name for name in estimates if name in known.signals), ""), "hand")


def _parts(known: Known, angles: _Angles, first: bool) -> Iterator[Part]:
    """Charts of the shown trials: the most relevant first, the others folded."""
    folded: list[Part] = []
    for trial in known.trials:
        charts = _charts(known, angles, trial, POINTS if first else FEWER_POINTS)
        shown = charts[:_MOST_SHOWN] if first else []
        yield from (chart for _, chart in shown)
        folded += [chart for _, chart in charts[len(shown):]]
    if folded:
        title = "The other joints" if first else "Every joint of the hand"
        yield Fold(title=title, parts=folded)


def _charts(known: Known, angles: _Angles, trial: int, points: int) -> list[tuple[float, Chart]]:
    """Chart and range, deg, of each joint; without a reference, joints that move come first."""
    names = {"reference": angles.reference, "truth": angles.truth, "estimate": angles.estimate}
    found = {role: each for role, name in names.items()
             if name and (each := course(known.recording, name, trial, points)) is not None}
    flat = {role: each.columns() for role, each in found.items() if each.mean.ndim <= 2}
    if not flat:
        return []
    count = min(each.mean.shape[1] for each in flat.values())
    told_names = known.joints(count) if angles.key == "scored" else row_names(count)
    ways = [_way_deg(flat, joint) for joint in range(count)]
    order = list(range(count))
    if "reference" not in flat:
        order.sort(key=lambda joint: ways[joint] < _MOVES_DEG)
    return [(ways[joint], _chart(known, angles, trial, flat, joint, told_names[joint])) for joint in order]


def _way_deg(found: dict[str, Course], joint: int) -> float:
    """Range of the true angle, or of the estimate if there is no truth, deg."""
    values = found.get("truth", next(iter(found.values()))).mean[:, joint]
    finite = values[np.isfinite(values)]
    return float(_DEG * np.ptp(finite)) if finite.size else 0.0


def _chart(known: Known, angles: _Angles, trial: int, found: dict[str, Course], joint: int,
           name: str) -> Chart:
    styles = {"reference": "dashed", "truth": "line", "estimate": "line"}
    lines = [each.line(role, role, joint, _DEG, styles[role]) for role, each in found.items()]
    marks: Sequence[Mark] = known.scored_while() if angles.key == "scored" else ()
    limits = _limits(lines)
    return Chart(key=f"tracking-{angles.key}-{joint}-{trial}", x_label="time, s",
                 title=f"{joint_label(name)}{_cut_off(lines, limits)}",
                 y_label="angle, deg", lines=lines, marks=marks, trial=trial, timed=True, limits=limits,
                 text=f"{joint_label(name)} in trial {trial}: {', '.join(line.name for line in lines)}.")


def _limits(lines: Sequence[Line]) -> tuple[float, float] | None:
    """Limits of the axis: all of reference and truth, and the 2nd to 98th percentile of an estimate."""
    ends: list[float] = []
    for line in lines:
        finite = _reached(line)
        if finite.size:
            ends += (np.percentile(finite, [2.0, 98.0]).tolist() if line.role == "estimate"
                     else [float(finite.min()), float(finite.max())])
    if not ends:
        return None
    middle, half = 0.5 * (min(ends) + max(ends)), max(2.0, 0.56 * (max(ends) - min(ends)))
    return middle - half, middle + half


def _reached(line: Line) -> Array:
    """Finite values of a line, or its extremes if samples are merged."""
    values = line.y if line.low is None or line.high is None else np.concatenate([line.low, line.high])
    return np.asarray(values[np.isfinite(values)])


def _cut_off(lines: Sequence[Line], limits: tuple[float, float] | None) -> str:
    """Remark for the title on an estimate that exceeds the axis; empty otherwise."""
    if limits is None:
        return ""
    values = np.concatenate([_reached(line) for line in lines])
    low, high = float(values.min()), float(values.max())
    beyond = [*([f"down to {rounded(low)}"] if low < limits[0] else []),
              *([f"up to {rounded(high)}"] if high > limits[1] else [])]
    return f" (estimate {' and '.join(beyond)} deg, cut off)" if beyond else ""

"""All pictures of a recording, written as PNG files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.files.patients import describe
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.show.best_trial import best_trial
from fesloop.show.picture.arm import arm_figure, arm_of
from fesloop.show.picture.arrays import arrays_figure, stimulation_at
from fesloop.show.picture.cast import Cast, cast_of
from fesloop.show.picture.courses import courses_figure, scored_signals
from fesloop.show.picture.hand import Estimate, hand_figure
from fesloop.show.picture.posture import Posture, estimated_posture, true_posture
from fesloop.show.picture.scene import solids_of
from fesloop.show.picture.signals import first_recorded, span_ns, values_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
CANDIDATES, SHOWN = 240, 4
"""Evenly spaced instants to choose from by default, and most that are chosen (chosen: a strip of four)."""
BETWEEN = 20
"""Drawn instants are apart by at least the recording's length divided by this (chosen: else a hand that
springs to rest at the start is drawn twice, and its later motion once)."""
APART_M, APART_SHARE = 0.005, 0.05
"""Differences, root mean square, below which two postures count as one (chosen); and likewise shares of
muscles."""


def requested_instants(at_s: Sequence[float], last_ns: int, trial: int) -> Instants:
    """The instants of the command line, ns; raises InputError for one outside of what is recorded."""
    for second in at_s:
        if not 0.0 <= second <= last_ns / NS_PER_S:
            raise InputError(f"--at {second:g}", f"is not in what is recorded of trial {trial}",
                             f"0 to {last_ns / NS_PER_S:g} s")
    return np.array(list(dict.fromkeys(round(second * NS_PER_S) for second in at_s)), dtype=np.int64)


def candidates(first_ns: int, last_ns: int) -> Instants:
    """Instants to choose among, in whole milliseconds."""
    return np.unique(np.linspace(first_ns, last_ns, CANDIDATES).astype(np.int64) // NS_PER_MS * NS_PER_MS)


def most_different(values: Array, apart_by: float, shown: int = SHOWN) -> list[int]:
    """Rows of values (t, n, k) that differ most: the first, and again and again what is farthest.

    Rows that are not finite are passed over, and those next to a chosen one (`BETWEEN`). In order of time;
    fewer where the rest are much the same, nearer than `apart_by`, root mean square over the n.
    """
    rows = np.flatnonzero(np.isfinite(values).all(axis=(1, 2)))
    if not rows.size:
        return []
    flat = values[rows].reshape(len(rows), -1)
    chosen: list[int] = []
    apart = np.full(len(rows), np.inf)
    while len(chosen) < shown and apart.max() > apart_by:
        chosen.append(int(apart.argmax()))
        near = np.abs(rows - rows[chosen[-1]]) < len(values) / BETWEEN
        distance = _distance(flat, flat[chosen[-1]], values.shape[1])
        apart = np.minimum(apart, np.where(near, 0.0, distance))
    return [int(rows[each]) for each in sorted(chosen)]


def spread_out(first_ns: int, last_ns: int) -> Instants:
    """Start, middle and end."""
    return np.unique(np.array([first_ns, (first_ns + last_ns) // 2, last_ns], dtype=np.int64))


def _distance(flat: Array, row: Array, count: int) -> Array:
    """Root mean square distance of `count` points from where they are in one row."""
    return np.asarray(np.sqrt(np.square(flat - row).sum(axis=1) / count))


Progress = Callable[[float], None]


@dataclass(slots=True)
class Drawn:
    """Result of drawing a recording.

    Attributes
    ----------
    pictures: files, in the order in which they were drawn.
    instants_s: instants in the pictures. chosen: reason for these instants.
    notes: what could not be drawn, and why. trial: number of the trial in the pictures.
    """

    pictures: list[Path] = field(default_factory=list)
    instants_s: list[float] = field(default_factory=list)
    chosen: str = "as given"
    notes: list[str] = field(default_factory=list)
    trial: int = 0


def draw(
    recording: Recording, folder: Path, at_s: Sequence[float] = (), trial: int | None = None,
    progress: Progress = lambda fraction: None,
) -> Drawn:
    """Draw the hand, the arrays at every instant, and time courses, or an arm, as far as they are recorded.

    Without any of them, time courses of what the score compares.

    `trial`: which; None: the best (`fesloop.show.best_trial`).

    Raises
    ------
    InputError: for a recording with neither hand, arrays, arm nor scored signals or without rows, a trial or
        an instant that is not in it, and where matplotlib is not installed or a file cannot be written.
    """
    _require_matplotlib()
    cast = cast_of(recording)
    arm = arm_of(recording)
    seen = cast.hand is not None or cast.electrodes is not None
    scored = [] if seen or arm else scored_signals(recording)
    if not seen and not arm and not scored:
        raise InputError(str(recording.path), "has neither hand, electrode arrays nor arm to draw, nor "
                         "scored signals over time", "a recording with one of these",
                         f"`fesloop report {recording.path}` draws what else there is")
    if not recording.trials:
        raise InputError(str(recording.path), f"holds no row of any trial (run {recording.status})",
                         "a recording with something to draw")
    trial = best_trial(recording) if trial is None else trial
    if not 0 <= trial < recording.trials:
        raise InputError(f"--trial {trial}", "is not in the recording", f"0 to {recording.trials - 1}")
    nodes = [player.name for player in (cast.hand, cast.electrodes) if player is not None] or [
        arm or scored[0].partition(".")[0]]
    span = _recorded(recording, nodes, trial)
    drawn = Drawn(trial=trial)
    _write(folder, lambda: folder.mkdir(parents=True, exist_ok=True))
    at_ns = (_instants(recording, cast, trial, span, at_s, drawn) if seen
             else requested_instants(at_s, span[1], trial))
    drawn.instants_s = [float(now) / NS_PER_S for now in at_ns]
    title = title_of(recording, cast, trial)
    stem = recording.path.stem if recording.trials == 1 else f"{recording.path.stem}_trial{trial}"
    figures: list[tuple[str, Figure]] = []
    if arm:
        figures.append(("arm", arm_figure(recording, arm, trial, at_ns, span[1], title)))
    if seen:
        figure = _hand(recording, cast, trial, at_ns, title, drawn)
        figures += [("hand", figure)] if figure is not None else []
        progress(0.6)
        figures += _arrays(recording, cast, trial, at_ns, title, drawn)
    if seen or scored:
        courses, notes = courses_figure(recording, cast, trial, at_ns, span[1], title)
        drawn.notes += notes
        figures.append(("courses", courses))
    for number, (name, each) in enumerate(figures):
        path = folder / f"{stem}_{name}.png"
        _write(folder, partial(each.savefig, path))
        drawn.pictures.append(path)
        progress(0.7 + 0.3 * (number + 1) / len(figures))
    drawn.notes = list(dict.fromkeys(drawn.notes))
    return drawn


def _write(folder: Path, act: Callable[[], Any]) -> None:
    try:
        act()
    except OSError as fault:
        raise InputError(f"--out {folder}", f"cannot be written: {fault.strerror}",
                         "a folder that can be written") from None


def _require_matplotlib() -> None:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: F401
    except ImportError:
        raise InputError("pictures", "matplotlib is not installed", "matplotlib 3.8 or later",
                         "pip install matplotlib") from None


def title_of(recording: Recording, cast: Cast, trial: int) -> str:
    """Title of all pictures of a trial: run, patient and hand."""
    parts = [recording.name, *([f"trial {trial}"] if recording.trials > 1 else []), f"seed {recording.seed}"]
    patient = recording.experiment.get("patient")
    if patient:
        parts.append(describe({**patient, "file": Path(patient["file"]).stem}))
    if cast.hand is not None:
        size = cast.hand.hand_size
        parts.append(f"{size.side} hand of {size.hand_mm:.0f} mm")
    return ", ".join(parts) + ("" if recording.status == "done" else f" (run {recording.status})")


def _recorded(recording: Recording, nodes: Sequence[str], trial: int) -> tuple[int, int]:
    """First and last recorded instant of nodes."""
    spans = [found for name in recording.signals if name.partition(".")[0] in nodes
             if (found := span_ns(recording, name, trial)) is not None]
    if not spans:
        raise InputError(str(recording.path), f"nothing of {', '.join(nodes)} was recorded in trial {trial}",
                         remedy="take their signals out of record.leave_out")
    return min(first for first, _ in spans), max(last for _, last in spans)


def _instants(
    recording: Recording, cast: Cast, trial: int, span: tuple[int, int], at_s: Sequence[float], drawn: Drawn
) -> Instants:
    """Requested instants, or those at which postures or activations differ most, or evenly spread ones."""
    if at_s:
        return requested_instants(at_s, span[1], trial)
    every = candidates(*span)
    posture = true_posture(recording, cast.hand, trial, every) if cast.hand is not None else None
    rows: list[int] = []
    if posture is not None:
        place = posture.poses.position
        rows = most_different(place[:, 1:] - place[:, :1], APART_M)
        drawn.chosen = "postures differ most"
    if len(rows) < 2 and cast.electrodes is not None:
        names = f"{cast.muscles}.activation", f"{cast.electrodes.name}.recruitment"
        name = first_recorded(recording, names)
        shares = values_at(recording, name, trial, every) if name else None
        if shares is not None:
            rows = most_different(shares[..., np.newaxis], APART_SHARE)
            drawn.chosen = f"{name} differs most"
    if len(rows) < 2:
        drawn.chosen = "start, middle and end: little differs"
        return spread_out(*span)
    return every[rows]


def _hand(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, title: str, drawn: Drawn
) -> Figure | None:
    if cast.hand is None:
        drawn.notes.append("the hand is not drawn: the recording has none")
        return None
    truth = true_posture(recording, cast.hand, trial, at_ns)
    if truth is None or not truth.finite.any():
        lack = "is not recorded" if truth is None else "is not finite at any of the instants"
        drawn.notes.append(f"the hand is not drawn: {cast.hand.name}.angles {lack}")
        return None
    drawn.notes += [f"the hand at {now / NS_PER_S:g} s is not drawn: its posture is not finite"
                    for now, fine in zip(at_ns, truth.finite, strict=True) if not fine]
    name = f"{cast.hand.name}.site_orientation"
    if name not in recording.signals and getattr(cast.hand.part, "forearm_moves", True):
        drawn.notes.append(f"the forearm is drawn as it was at the start: {name} is not recorded")
    solids, notes = solids_of(recording, cast.hand, trial, at_ns)
    drawn.notes += notes
    return hand_figure(truth, at_ns, solids, _estimate(recording, cast, trial, at_ns, truth, drawn), title)


def _estimate(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, truth: Posture, drawn: Drawn
) -> Estimate | None:
    """Estimate of the first tracker that has one."""
    for tracker in cast.trackers:
        found = estimated_posture(recording, tracker, trial, at_ns, truth)
        if found is not None:
            others = [each.name for each in cast.trackers if each is not tracker]
            if others:
                drawn.notes.append(f"of the trackers only {tracker.name} is drawn, not {', '.join(others)}")
            return Estimate(found[0], tracker.name, found[1])
    return None


def _arrays(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, title: str, drawn: Drawn
) -> list[tuple[str, Figure]]:
    """One picture an instant, in one scale of colours."""
    if cast.electrodes is None:
        drawn.notes.append("the arrays are not drawn: the recording has no electrodes")
        return []
    if cast.rotation:
        drawn.notes.append(f"motor points are drawn as in a neutral forearm: {cast.rotation} turns them")
    stimulation, notes = stimulation_at(recording, cast, trial, at_ns)
    drawn.notes += notes
    signals = {"recruitment": f"{cast.electrodes.name}.recruitment",
               "activation": f"{cast.muscles}.activation", "fitness": f"{cast.muscles}.fitness"}
    values = {key: values_at(recording, name, trial, at_ns) if name in recording.signals else None
              for key, name in signals.items()}
    drawn.notes += [f"{key} is not drawn: {signals[key]} is not recorded"
                    for key in ("recruitment", "activation") if values[key] is None]
    highest = float(stimulation.charge.max()) if stimulation.charge is not None else 0.0

    def row(array: Any, i: int) -> Any:
        return None if array is None else array[i]

    return [(f"arrays_{now / NS_PER_S:.3f}s", arrays_figure(
        cast.electrodes.part, row(stimulation.charge, i), highest, row(stimulation.shares, i),
        row(stimulation.commands, i), {key: row(value, i) for key, value in values.items()},
        f"{title}, {now / NS_PER_S:.2f} s")) for i, now in enumerate(at_ns)]

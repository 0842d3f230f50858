"""Pictures of recordings of stimulated muscle: torque over posture, recruitment, drift, force."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from fesloop.errors import InputError
from fesloop.show.picture.palette import BLUE, FAINT, ORANGE, VERMILION, channel_colour, tidy
from fesloop.streams.stimulation.features import (
    CLEAR,
    baselines,
    by_repeat,
    recruitment_curve,
    shown_joint,
)
from fesloop.streams.stimulation.recording import ForceCourse, SteadyTrials, StimulationRecording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_COURSES, _MOST_FORCES = 12, 6
_LETTERS_AN_INCH = 11
"""Letters of a title to an inch of picture at 10 points (measured; less a margin)."""
_SHOWN_LENGTHS = (0.5, 99.5)
"""Percentiles of a muscle's length that its axis shows (chosen: servomotors are reset within recordings)."""


def draw_stimulation(recording: StimulationRecording, folder: Path) -> list[Path]:
    """Draw every picture that a recording has data for into `folder`, as NAME.png; return the files.

    Raises InputError where there is nothing to draw, or a file cannot be written.
    """
    figures = {name: figure for name, draw in _FIGURES.items() if (figure := draw(recording)) is not None}
    if not figures:
        raise InputError(recording.person, "holds no isometric trials, ramps or forces",
                         "one of them", "fesloop report lists movements")
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(path, dpi=120)
        except OSError as fault:
            raise InputError(str(path), f"cannot be written: {fault.strerror}",
                             "a folder that can be written") from None
        paths.append(path)
    return paths


def _figure(width: float, height: float, title: str) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(fill(title, int(_LETTERS_AN_INCH * width)), fontsize=10, x=0.01, ha="left")
    return figure


def joint_label(joint: str) -> str:
    """Name of a joint in words."""
    return joint.replace("_", " ")


def muscles_of(trials: SteadyTrials) -> list[int]:
    """Numbers of the muscles that were stimulated."""
    return [int(m) for m in np.unique(trials.muscle[trials.stimulated])]


def torque_over_posture(recording: StimulationRecording) -> Figure | None:
    """Evoked torque of each muscle (row) at each joint (column) in every posture: repeats, and their mean."""
    trials = recording.steady
    if trials is None or not trials.stimulated.any():
        return None
    muscles, joints = muscles_of(trials), recording.joints
    codes = np.unique(trials.posture)
    evoked, cells, sd = trials.evoked_nm, trials.cells(), trials.repeatability().sd_nm
    figure = _figure(max(5.0, 3.3 * len(joints)), 1.2 + 1.35 * len(muscles),
                     f"{recording.person}: evoked torque over posture, N m; dots: repeats, line: their mean, "
                     "band: sd of a repeat")
    axes = figure.subplots(len(muscles), len(joints), sharex=True, sharey="col", squeeze=False)
    groups = [k - 0.5 for k in range(1, len(codes)) if codes[k][:1] != codes[k - 1][:1]]
    for row, muscle in enumerate(muscles):
        for j, joint in enumerate(joints):
            here = axes[row, j]
            tidy(here, title=joint_label(joint) if row == 0 else "")
            if j == 0:
                here.set_ylabel(recording.muscles[muscle].replace(" ", "\n"), fontsize=8)
            if np.isfinite(sd[j]):
                here.axhspan(-sd[j], sd[j], color="0.92", zorder=0)
            here.axhline(0.0, color="0.7", linewidth=0.6)
            for at in groups:
                here.axvline(at, color="0.8", linewidth=0.6)
            mean = np.full(len(codes), np.nan)
            for k, code in enumerate(codes):
                rows = cells.get((muscle, str(code)))
                if rows is not None:
                    mean[k] = evoked[rows, j].mean()
                    here.plot([k] * len(rows), evoked[rows, j], ".", color=FAINT, markersize=3)
            here.plot(np.arange(len(codes)), mean, "-", color=BLUE, linewidth=1.2)
            here.set_xticks(np.arange(len(codes)), codes, rotation=90, fontsize=6)
            if row == len(muscles) - 1:
                here.set_xlabel("posture: rank of each joint's angle", fontsize=8)
    return figure


def recruitment(recording: StimulationRecording) -> Figure | None:
    """Torque over pulse width in ramps, at the joint that the muscle turns most."""
    curves = [(course, curve) for course in recording.courses
              if (curve := recruitment_curve(course)) is not None][:_MOST_COURSES]
    if not curves:
        return None
    across = min(4, len(curves))
    down = -(-len(curves) // across)
    figure = _figure(3.2 * across, 0.6 + 2.5 * down,
                     f"{recording.person}: torque over pulse width, mean of ramps; delay and friction of the "
                     "device part rising and falling width")
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for here, (course, curve) in zip(axes, curves, strict=False):
        j = shown_joint(recording, course, curve)
        us = 1e6 * curve.width_s
        here.plot(us, curve.up_nm[:, j], "-", color=BLUE, label="rising")
        here.plot(us, curve.down_nm[:, j], "--", color=VERMILION, label="falling")
        here.axhline(0.0, color="0.7", linewidth=0.6)
        tidy(here, x="pulse width, µs", y=f"{joint_label(recording.joints[j])}, N m",
             title=f"{recording.muscles[course.muscle]}, {1e3 * course.current_a:g} mA")
        here.legend(frameon=False, fontsize=7)
    for here in axes[len(curves):]:
        here.set_axis_off()
    return figure


def drift(recording: StimulationRecording) -> Figure | None:
    """Torque of each muscle by repeat, and the device's torque at rest over the session."""
    trials = recording.steady
    if trials is None or not trials.stimulated.any() or trials.repeat.max() < 1:
        return None
    figure = _figure(12.0, 4.0, f"{recording.person}: change over the session")
    left, right = figure.subplots(1, 2)
    shown = [(muscle, found) for muscle in muscles_of(trials) if (found := by_repeat(trials, muscle)).clear]
    for number, (muscle, found) in enumerate(shown):
        left.plot(np.arange(1, len(found.mean_nm) + 1), found.mean_nm / found.mean_nm.mean(), "o-",
                  color=channel_colour(number), markersize=4, linewidth=1.2,
                  label=f"{recording.muscles[muscle]}: {joint_label(recording.joints[found.joint])}")
    tidy(left, x="visit of the same postures", y="torque over its mean",
         title=f"mean torque of muscles beyond {CLEAR:g} standard errors")
    left.axhline(1.0, color="0.7", linewidth=0.6)
    left.xaxis.get_major_locator().set_params(integer=True)
    if shown:
        left.legend(frameon=False, fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    found_rest = baselines(trials)
    timed = bool(np.isfinite(found_rest.time_s).all())
    x = found_rest.time_s / 60.0 if timed else found_rest.visit
    for j, joint in enumerate(recording.joints):
        known = np.isfinite(found_rest.change_nm[:, j])
        right.plot(x, found_rest.change_nm[:, j], ".", color=channel_colour(j), markersize=4, alpha=0.6)
        if known.sum() > 2:
            line = np.polynomial.Polynomial.fit(x[known], found_rest.change_nm[known, j], 1)
            right.plot(*line.linspace(2), color=channel_colour(j), linewidth=1.4, label=joint_label(joint))
    tidy(right, x="min" if timed else "visit", y="N m",
         title="median device torque of a visit, less its posture's mean")
    right.axhline(0.0, color="0.7", linewidth=0.6)
    right.legend(frameon=False, fontsize=7)
    return figure


def chosen_forces(recording: StimulationRecording) -> list[ForceCourse]:
    """Courses of force to show: of each kind the first, then further ones."""
    kinds: dict[str, list[ForceCourse]] = {}
    for course in recording.forces:
        kinds.setdefault(course.kind, []).append(course)
    turns = [course for depth in range(_MOST_FORCES) for group in kinds.values()
             for course in group[depth:depth + 1]]
    return turns[:_MOST_FORCES]


def force(recording: StimulationRecording) -> Figure | None:
    """Force and length over time, with the instants of pulses, of a few courses of each kind."""
    chosen = chosen_forces(recording)
    if not chosen:
        return None
    across = min(3, len(chosen))
    down = -(-len(chosen) // across)
    known = any(np.isfinite(course.length_m).any() for course in chosen)
    figure = _figure(3.8 * across, 0.6 + 2.5 * down, f"{recording.person}: force (line), "
                     + ("length (dashed), " if known else "")
                     + f"pulses (ticks); {len(chosen)} of {len(recording.forces)} recordings")
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for here, course in zip(axes, chosen, strict=False):
        here.plot(course.time_s, course.force_n, color=BLUE, linewidth=1.2)
        here.plot(course.pulses_s, np.zeros_like(course.pulses_s), "|", color=VERMILION, markersize=5)
        tidy(here, x="s", y="N", title=course.name)
        if np.isfinite(course.length_m).any():
            other = here.twinx()
            mm = 1e3 * course.length_m
            other.plot(course.time_s, mm, "--", color=ORANGE, linewidth=0.9)
            low, high = np.nanpercentile(mm, _SHOWN_LENGTHS)
            other.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
            other.set_ylabel("mm", fontsize=9)
            other.tick_params(labelsize=8)
            other.spines["top"].set_visible(False)
    for here in axes[len(chosen):]:
        here.set_axis_off()
    return figure


_FIGURES: dict[str, Callable[[StimulationRecording], Figure | None]] = {
    "torque_over_posture": torque_over_posture, "recruitment": recruitment, "drift": drift, "force": force}

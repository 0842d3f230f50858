"""Picture of signals over time: stimulation, muscles, joints, contact, object."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.hand.anthropometry import FINGERS
from fesloop.hand.grip import by_digit, places_of
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.cast import Cast
from fesloop.show.picture.palette import (
    BLACK,
    BLUE,
    CHANNELS,
    FINGER_COLOURS,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    VERMILION,
    channel_colour,
    tidy,
)
from fesloop.show.picture.signals import Described, curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
Draw = Callable[["Axes"], None]
_MOST_ACTIVE = 7
_OUT_OF_REACH_MM = 300.0
"""Chosen: longer than a hand. An object that misses its table falls some 100 m in 5 s."""
_MOTION_COLOURS = {"mcp": BLUE, "pip": GREEN, "dip": ORANGE, "cmc": BLACK, "ip": ORANGE, "wrist": BLUE}
_SCORED = {"truth": (BLUE, "-", 1.6), "reference": (BLACK, "--", 1.1), "estimate": (ORANGE, "-", 0.7)}
"""Colour, style and width of the lines of what the score compares, by its key."""
DIGITS = {"wrist": "wrist", "F1": "F1, thumb", "F2": "F2, index", "F3": "F3, middle", "F4": "F4, ring",
           "F5": "F5, little"}
"""Parts of the hand by the beginning of their joints' names, in words."""


def courses_figure(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, until_ns: int, title: str
) -> tuple[Figure, list[str]]:
    """Figure of all time courses, the instants of the other pictures marked; and notes on missing signals."""
    from matplotlib.figure import Figure

    left, notes = _events(recording, cast, trial, until_ns)
    right, more = _joints(recording, cast, trial, until_ns)
    figure = Figure(figsize=(13.33, max(7.5, 1.55 * max(len(left), len(right)))), dpi=150)
    figure.text(0.015, 1.0 - 0.15 / figure.get_figheight(), title, va="top", fontsize=12, color=INK)
    columns = [column for column in (left, right) if column]
    grid = figure.add_gridspec(1, max(1, len(columns)), left=0.06, right=0.985, bottom=0.07,
                               top=1.0 - 0.75 / figure.get_figheight(), wspace=0.14)
    for number, column in enumerate(columns):
        _stack(figure, grid[number], column, at_ns, until_ns)
    return figure, notes + more


def _stack(figure: Figure, place: object, draws: list[Draw], at_ns: Instants, until_ns: int) -> None:
    """Draw time courses one above the other over one axis of time."""
    rows = place.subgridspec(len(draws), 1, hspace=0.42)  # type: ignore[attr-defined]
    for row, draw in enumerate(draws):
        axes = figure.add_subplot(rows[row])
        draw(axes)
        axes.set_xlim(0.0, until_ns / NS_PER_S)
        for now in at_ns:
            axes.axvline(now / NS_PER_S, color="0.75", linewidth=0.8, zorder=0)
        if row < len(draws) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("s", fontsize=9)


def _events(recording: Recording, cast: Cast, trial: int, until_ns: int) -> tuple[list[Draw], list[str]]:
    """Stimulation, muscles, contact and object, as far as they are there."""
    draws: list[Draw] = []
    hand = cast.hand.name if cast.hand is not None else ""
    courses: list[tuple[str, bool, list[Callable[[Axes, Array, Array], None]]]] = [
        (cast.stimulation, bool(cast.stimulation), [partial(_channels, 0), partial(_channels, 1)]),
        (f"{cast.muscles}.activation", bool(cast.muscles),
         [partial(_most_active, _muscles(recording, cast, trial))]),
        (f"{hand}.contact_force", cast.hand is not None and cast.stimulation != "", [_contact]),
        (f"{hand}.object_position", getattr(getattr(cast.hand, "part", None), "object", None) is not None,
         [draw_height])]
    notes: list[str] = []
    for name, there, pictures in courses:
        if not there:
            continue
        if name not in recording.signals:
            notes.append(f"time courses lack {name}: it is not recorded")
            continue
        seconds, values = curve(recording, name, trial, until_ns)
        if len(seconds):
            draws += [partial(_drawn, picture, seconds, values) for picture in pictures]
    return draws, notes


def _drawn(picture: Callable[[Axes, Array, Array], None], seconds: Array, values: Array, axes: Axes) -> None:
    picture(axes, seconds, values)


def _channels(which: int, axes: Axes, seconds: Array, values: Array) -> None:
    """Current (0) or pulse width (1) of every channel; widths only while there is a current."""
    shown = np.where(values[..., 0] > 0.0, values[..., 1], np.nan) if which else values[..., 0]
    scale = 1e6 if which else 1e3
    for channel in range(values.shape[1]):
        # Channels that are given the same pulses stay apart by the length of their dashes.
        axes.plot(seconds, scale * shown[:, channel], color=channel_colour(channel), linewidth=1.4,
                  drawstyle="steps-post", label=f"channel {channel}", dashes=_dashes(channel, which))
    tidy(axes, y="µs" if which else "mA", title="pulse width" if which else "current")
    axes.set_ylim(bottom=0.0)
    if not which:
        _key(axes, min(len(CHANNELS), 4))


def _dashes(channel: int, which: int) -> tuple[float, float]:
    return (1.0, 0.0) if not which or channel == 0 else (6.0 / channel, 2.0)


def _muscles(recording: Recording, cast: Cast, trial: int) -> tuple[str, ...]:
    """Names of muscles in the order of activation: those of the hand model, or those that a port states."""
    if cast.hand is not None or cast.electrodes is not None:
        return MUSCLES
    name = f"{cast.muscles}.activation"
    if name not in recording.signals:
        return ()
    count = recording.column(name, trial)[1].shape[-1]
    return recording.signal(name, trial).rows or tuple(f"muscle {number}" for number in range(count))


def _most_active(names: tuple[str, ...], axes: Axes, seconds: Array, values: Array) -> None:
    """The muscles that are active most, each named."""
    highest = np.nan_to_num(values).max(axis=0)
    chosen = [int(i) for i in np.argsort(-highest, kind="stable")[:_MOST_ACTIVE] if highest[i] > 0.0]
    for number, i in enumerate(chosen):
        colour = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, BLACK, "0.5")[number]
        axes.plot(seconds, values[:, i], color=colour, linewidth=1.3, label=names[i])
    tidy(axes, y="1", title="activation of the most active muscles")
    axes.set_ylim(bottom=0.0)
    if chosen:
        _key(axes, 4)


def _contact(axes: Axes, seconds: Array, values: Array) -> None:
    """Force on each digit and on the palm."""
    colours = dict(zip((*FINGERS, "palm"), (*FINGER_COLOURS, VERMILION), strict=True))
    for name, force in by_digit(values, places_of(values)).items():
        axes.plot(seconds, force, color=colours[name], linewidth=1.2, label=name)
    tidy(axes, y="N", title="contact force on digits and palm")
    axes.set_ylim(bottom=0.0)
    _key(axes, 6)


def draw_height(axes: Axes, seconds: Array, values: Array) -> None:
    """Height of the object over the wrist, down to where no hand reaches: what falls further is cut."""
    height = 1e3 * values[:, 2]
    fell = bool((height < -_OUT_OF_REACH_MM).any())
    axes.plot(seconds, height, color=BLUE, linewidth=1.4)
    what = "height of the object's centre over the wrist's"
    tidy(axes, y="mm", title=f"{what}, until it fell" if fell else what)
    if fell:
        axes.set_ylim(-_OUT_OF_REACH_MM, max(50.0, 1.1 * float(np.nanmax(height))))


def _joints(recording: Recording, cast: Cast, trial: int, until_ns: int) -> tuple[list[Draw], list[str]]:
    """Angles of wrist and digits, and beside them those of the first tracker that has them all."""
    if cast.hand is None:
        return _scored(recording, trial, until_ns), []
    name = f"{cast.hand.name}.angles"
    if name not in recording.signals:
        return [], [f"time courses lack {name}: it is not recorded"]
    seconds, values = curve(recording, name, trial, until_ns)
    if not len(seconds):
        return [], []
    estimate, thin = None, ""
    for tracker in cast.trackers:
        angles = f"{tracker.name}.angles"
        if recording.column(angles, trial)[1].shape[1:] == values.shape[1:]:
            estimate, thin = curve(recording, angles, trial, until_ns), f"; thin lines: {tracker.name}"
            break
    freedoms = hand_tree(cast.hand.hand_size).freedoms
    return [partial(_digit, part, f"{about}{thin if part == 'wrist' else ''}", freedoms, (seconds, values),
                    estimate) for part, about in DIGITS.items()], []


def scored_signals(recording: Described) -> list[str]:
    """Recorded signals that the score compares: truth, reference and estimate, as far as they are there."""
    score = recording.experiment.get("score", {})
    return [name for key in _SCORED if (name := score.get(key)) in recording.signals]


def _scored(recording: Recording, trial: int, until_ns: int) -> list[Draw]:
    """Signals that the score compares, one axes a joint: truth, reference dashed, and estimate thin."""
    score = recording.experiment.get("score", {})
    courses = {key: curve(recording, score[key], trial, until_ns) for key in _SCORED
               if score.get(key) in recording.signals}
    courses = {key: (seconds, values.reshape(len(seconds), -1)) for key, (seconds, values) in courses.items()}
    joints = min((values.shape[1] for _, values in courses.values()), default=0)
    stated = next((rows for key in courses if (rows := recording.signal(score[key], trial).rows)), ())
    names = score.get("joints") or stated or [f"joint {number + 1}" for number in range(joints)]
    in_deg = all(recording.units[score[key]] == "rad" for key in courses)
    unit = "deg" if in_deg else recording.units[score["truth"]] if "truth" in courses else ""

    def draw(joint: int, axes: Axes) -> None:
        for key, (seconds, values) in courses.items():
            shown = np.degrees(values[:, joint]) if in_deg else values[:, joint]
            colour, style, width = _SCORED[key]
            # A noisy estimate lies behind the others.
            axes.plot(seconds, shown, style, color=colour, linewidth=width, label=key,
                      zorder=1.5 if key == "estimate" else 2)
        tidy(axes, y=unit, title=names[joint])
        if joint == 0:
            _key(axes, len(_SCORED), 2.6)

    return [partial(draw, joint) for joint in range(joints)]


def _digit(
    part: str, title: str, freedoms: tuple[str, ...], truth: tuple[Array, Array],
    estimate: tuple[Array, Array] | None, axes: Axes,
) -> None:
    """Flexion and abduction of a digit's joints, each in its colour, the tracker's thin and dashed."""
    for i, freedom in enumerate(freedoms):
        if not freedom.startswith(part):
            continue
        joint, _, motion = freedom.rpartition("_")
        joint = joint.removeprefix(f"{part}_")
        style = {"flexion": "-", "abduction": ":", "pronation": "-."}[motion]
        label = motion if part == "wrist" else f"{joint.upper()} {motion}".removesuffix(" flexion")
        colour = _MOTION_COLOURS.get(joint, BLUE)
        axes.plot(truth[0], np.degrees(truth[1][:, i]), style, color=colour, linewidth=1.4, label=label)
        if estimate is not None:
            axes.plot(estimate[0], np.degrees(estimate[1][:, i]), style, color=colour, linewidth=0.7,
                      alpha=0.45)
    tidy(axes, y="deg", title=title)
    mine = np.array([freedom.startswith(part) for freedom in freedoms])
    axes.set_ylim(*_limits(truth[1][:, mine], estimate[1][:, mine] if estimate is not None else None))
    _key(axes, 5, 2.6)


def _limits(truth: Array, estimate: Array | None) -> tuple[float, float]:
    """Limits of an axis of degrees: all of the truth, and the 5th to 95th percentile of an estimate."""
    known = np.degrees(truth[np.isfinite(truth)])
    ends = [known.min(initial=0.0), known.max(initial=0.0)]
    if estimate is not None and np.isfinite(estimate).any():
        ends += list(np.nanpercentile(np.degrees(estimate), [5.0, 95.0]))
    middle, half = 0.5 * (min(ends) + max(ends)), max(10.0, 0.56 * (max(ends) - min(ends)))
    return middle - half, middle + half


def _key(axes: Axes, columns: int, handle: float = 1.4) -> None:
    """Key above the axes; `handle`: length of its lines, in letters, 2.6 where dashes tell lines apart."""
    axes.legend(frameon=False, fontsize=7, ncols=columns, loc="lower right", bbox_to_anchor=(1.0, 0.97),
                borderaxespad=0.0, handlelength=handle, columnspacing=1.0, labelspacing=0.2)

"""Picture of the arrays: unrolled skin of the forearm with elements and motor points; their stimulation."""


from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.hand.movements import EXTRINSIC, MUSCLES, muscle
from fesloop.show.picture.cast import Cast
from fesloop.show.picture.palette import BLUE, FAINT, INK, SKY, channel_colour, tidy
from fesloop.show.picture.signals import first_recorded, values_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Array = NDArray[np.float64]


def draw_muscles(axes: Axes, muscles: dict[str, Array | None]) -> None:
    """One row a muscle; `recruitment`, `activation`, `fitness` (29,) each or None."""
    rows = np.arange(len(MUSCLES))
    recruitment, activation, fitness = (muscles[key] for key in ("recruitment", "activation", "fitness"))
    if recruitment is not None:
        axes.barh(rows, recruitment, 0.8, color=SKY, alpha=0.55, label="recruited share")
    if activation is not None:
        axes.barh(rows, activation, 0.38, color=BLUE, label="activation")
    if fitness is not None and (fitness < 0.995).any():
        axes.plot(fitness, rows, "|", color=INK, markersize=7, label="fitness")
    axes.set_yticks(rows, MUSCLES)
    axes.set_ylim(len(MUSCLES) - 0.4, -0.6)
    axes.axhline(len(EXTRINSIC) - 0.5, color=FAINT, linewidth=0.6)
    axes.set_xlim(0.0, 1.0)
    axes.grid(axis="x", color="0.9", linewidth=0.7)
    axes.set_axisbelow(True)
    tidy(axes, "share of the muscle")
    axes.tick_params(axis="y", labelsize=7.5, length=0)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3,
                    borderaxespad=0.2, handlelength=1.2, columnspacing=1.2)
    else:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color=FAINT)


_LETTER_MM, _HEIGHT_MM = 1.62, 3.4
"""Width of a letter and height of a line of a label, mm of skin."""
_WAYS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))
"""Directions of labels: right, left, below, above, and between."""


def placed_labels(
    points: Mapping[str, Array], texts: Mapping[str, str], radius_mm: float, taken: Sequence[Array] = ()
) -> dict[str, Array]:
    """Middle (2,) of each point's label, mm, chosen one after the other against points and earlier labels.

    `taken`: low and high corner, (2, 2) each, of what else is not to be covered.
    """
    obstacles = [*taken, *(_box(place, 2.0 * radius_mm, 2.0 * radius_mm) for place in points.values())]
    spots: dict[str, Array] = {}
    for name, place in points.items():
        wide = _LETTER_MM * len(texts[name])
        options = [place + np.array([x * (radius_mm + 0.5 * wide + 0.6 if not y else 0.42 * wide + radius_mm),
                                     y * (radius_mm + 0.5 * _HEIGHT_MM)]) for x, y in _WAYS]
        hidden = [sum(_overlap(_box(spot, wide, _HEIGHT_MM), box) for box in obstacles) for spot in options]
        best = int(np.argmin(hidden))
        spots[name] = options[best]
        obstacles.append(_box(options[best], wide, _HEIGHT_MM))
    return spots


def numbers_of(places: Array, points: Mapping[str, Array], radius_mm: float) -> Array:
    """Middles (elements, 2) of the numbers of elements, mm: below, above or at the middle of each pad.

    The first of these that no point covers counts, or else the one that is covered least.
    """
    discs = [_box(place, 2.0 * radius_mm, 2.0 * radius_mm) for place in points.values()]
    ways = np.array([[0.0, 0.58], [0.0, -0.58], [0.0, 0.0]])
    options = places[:, np.newaxis, :2] + ways * places[:, 2, np.newaxis, np.newaxis]
    hidden = [[sum(_overlap(_number_box(spot), disc) for disc in discs) for spot in each] for each in options]
    found: Array = options[np.arange(len(places)), np.argmin(hidden, axis=1)]
    return found


def _number_box(middle: Array) -> Array:
    return _box(middle, 2.0 * _LETTER_MM, _HEIGHT_MM)


def _box(middle: Array, wide: float, high: float) -> Array:
    """Low and high corner, (2, 2)."""
    half = 0.5 * np.array([wide, high])
    return np.stack([middle - half, middle + half])


def _overlap(a: Array, b: Array) -> float:
    """Area that two boxes share."""
    return float(np.prod(np.clip(np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]), 0.0, None)))


CUT_DEG = -90.0
"""Angle at which the skin is cut open: ulnar, so that the dorsal and volar halves stay whole."""


def unrolled(places: Array, radius_mm: float) -> Array:
    """Places (n, 2 or more), around and along, mm, with the former wrapped to one turn from the cut."""
    turn = 2.0 * np.pi * radius_mm
    first = np.deg2rad(CUT_DEG) * radius_mm
    found = np.array(places, dtype=np.float64)
    found[:, 0] = first + np.mod(found[:, 0] - first, turn)
    return found


def motor_points(electrodes: Any) -> dict[str, Array]:
    """Place (2,) of each muscle's motor point on the unrolled skin, mm; empty without motor points."""
    points = getattr(electrodes, "motor_points", ())
    if not points:
        return {}
    found = unrolled(np.array([[np.deg2rad(point.around_deg) * electrodes.radius_mm, point.along_mm]
                               for point in points]), electrodes.radius_mm)
    return {point.muscle: place for point, place in zip(points, found, strict=True)}


_DORSAL, _VOLAR = "#f8efe6", "#f1e3d6"
_EMPTY = "#fffdfa"
_POINT_MM, _AROUND_MM = 2.4, 14.0
"""Radius of a motor point's sign, and the skin shown beyond elements and motor points."""


def arrays_figure(
    electrodes: Any, charge: Array | None, highest: float, shares: Array | None, commands: Array | None,
    muscles: dict[str, Array | None], title: str,
) -> Figure:
    """The arrays at one instant, and beside them the muscles.

    Parameters
    ----------
    electrodes: the block; its `places` (elements, 3): around, along, radius, mm; its `radius_mm`; and where
        it has them its `motor_points` (muscle, around_deg, along_mm).
    charge: (elements,), C a phase; highest: that of the colour bar's end. shares: (channels, elements).
    commands: (channels, 2), A and s. muscles: `recruitment`, `activation`, `fitness`, (29,) each. None
        means not recorded.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.33, 7.5), dpi=150)
    grid = figure.add_gridspec(1, 2, width_ratios=(2.55, 1.0), left=0.05, right=0.985, top=0.9, bottom=0.16,
                               wspace=0.16)
    skin, bars = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
    figure.text(0.015, 0.975, title, ha="left", va="top", fontsize=12, color=INK)
    places, points = unrolled(electrodes.places, electrodes.radius_mm), motor_points(electrodes)
    draw_skin(skin, electrodes.radius_mm, places, points)
    if shares is not None:
        draw_channels(skin, places, shares)
    numbers = numbers_of(places, points, _POINT_MM)
    draw_elements(skin, places, charge, highest, numbers)
    draw_motor_points(skin, points, numbers, muscles["recruitment"])
    _channel_key(figure, shares, commands)
    if charge is not None and highest > 0.0:
        _colour_bar(figure, highest)
    draw_muscles(bars, muscles)
    return figure


def draw_skin(axes: Axes, radius_mm: float, places: Array, points: dict[str, Array]) -> None:
    """The skin between the elbow, at the top, and the wrist, as far as something is on it or under it."""
    per_deg = np.deg2rad(1.0) * radius_mm
    along = np.concatenate([places[:, 1], [place[1] for place in points.values()]])
    low, high = along.min() - _AROUND_MM, along.max() + _AROUND_MM
    for first, colour, name in ((-90.0, _DORSAL, "DORSAL"), (90.0, _VOLAR, "VOLAR")):
        axes.axvspan(first * per_deg, (first + 180.0) * per_deg, color=colour, zorder=0, linewidth=0)
        axes.text((first + 3.0) * per_deg, low + 2.0, name, ha="left", va="top", fontsize=11, color=FAINT,
                  fontweight="bold", zorder=1)
    axes.set_xlim(CUT_DEG * per_deg, (CUT_DEG + 360.0) * per_deg)
    axes.set_ylim(high, low)
    axes.set_aspect("equal")
    degrees = np.arange(-90, 271, 45)
    names = {-90: "ulnar", 0: "mid-line", 90: "radial", 180: "mid-line", 270: "ulnar"}
    axes.set_xticks(degrees * per_deg, [f"{each}°\n{names.get(int(each), '')}" for each in degrees])
    tidy(axes, "around the forearm", "from the elbow, mm")
    for y, text in ((0.97, "to the elbow ↑"), (0.03, "to the wrist ↓")):
        axes.text(0.985, y, text, transform=axes.transAxes, fontsize=8, color=FAINT, ha="right", va="center")


def draw_channels(axes: Axes, places: Array, shares: Array) -> None:
    """Virtual electrodes: a ring about each element of a channel, rings joined."""
    from matplotlib.patches import Circle

    rings = np.zeros(len(places))
    for channel, row in enumerate(shares):
        members, colour = np.flatnonzero(row > 0.0), channel_colour(channel)
        for i, j in _joined(places[members, :2]):
            first, second = places[members[i]], places[members[j]]
            axes.plot([first[0], second[0]], [first[1], second[1]], color=colour, linewidth=9, alpha=0.35,
                      solid_capstyle="round", zorder=2)
        for element in members:
            x, y, size = places[element]
            rings[element] += 1.0
            axes.add_patch(Circle((x, y), size + 0.9 * rings[element], fill=False, edgecolor=colour,
                                  linewidth=2.4, zorder=5))


def _joined(points: Array) -> list[tuple[int, int]]:
    """Pairs of points that join all of them by the shortest ways (a minimum spanning tree)."""
    pairs: list[tuple[int, int]] = []
    reached, left = [0] if len(points) else [], list(range(1, len(points)))
    while left:
        apart = np.linalg.norm(points[reached][:, np.newaxis] - points[left], axis=-1)
        i, j = np.unravel_index(int(apart.argmin()), apart.shape)
        pairs.append((reached[int(i)], left[int(j)]))
        reached.append(left.pop(int(j)))
    return pairs


def _colours(charge: Array, highest: float) -> Array:
    """Colours (n, 4) of elements by their charge."""
    from matplotlib import colormaps

    # The darkest end of the map would hide an element's number.
    return np.asarray(colormaps["YlGnBu"](0.08 + 0.82 * np.clip(charge / max(highest, 1e-30), 0.0, 1.0)))


def draw_elements(axes: Axes, places: Array, charge: Array | None, highest: float, numbers: Array) -> None:
    """Draw every element as a pad, coloured by its charge if it has any, its number above all markers."""
    from matplotlib.patches import Circle

    colours = [_EMPTY] * len(places) if charge is None else list(_colours(charge, highest))
    for element, (x, y, size) in enumerate(places):
        idle = charge is None or charge[element] <= 0.0
        axes.add_patch(Circle((x, y), size, facecolor=_EMPTY if idle else colours[element], edgecolor="0.55",
                              linewidth=0.7, zorder=3))
        dark = not idle and charge is not None and charge[element] > 0.55 * highest
        axes.text(numbers[element, 0], numbers[element, 1], f"{element}", ha="center", va="center",
                  fontsize=6.5, zorder=9, gid=f"element {element}", color="white" if dark else "0.45")


def draw_motor_points(
    axes: Axes, points: dict[str, Array], numbers: Array, recruitment: Array | None
) -> None:
    """Motor points, each a disc filled by the share of its axons that is recruited.

    Labels keep off the `numbers` of elements, middles (elements, 2), mm.
    """
    from matplotlib.patches import Circle, Wedge
    from matplotlib.patheffects import withStroke

    def share_of(name: str) -> float:
        return 0.0 if recruitment is None else float(recruitment[muscle(name)])

    texts = {name: f"{name} {100.0 * share_of(name):.0f} %" if share_of(name) >= 0.005 else name
             for name in points}
    spots = placed_labels(points, texts, _POINT_MM, [_number_box(middle) for middle in numbers])
    for name, (x, y) in points.items():
        share = share_of(name)
        axes.add_patch(Circle((x, y), _POINT_MM, facecolor="white", edgecolor=INK, linewidth=0.9, zorder=6))
        if share > 0.0:
            axes.add_patch(Wedge((x, y), _POINT_MM, -90.0, -90.0 + 360.0 * share, color=INK, zorder=7))
        label_x, label_y = spots[name]
        axes.text(label_x, label_y, texts[name], ha="center", va="center", fontsize=6.8, zorder=8, color=INK,
                  fontweight="bold" if share >= 0.005 else "normal", gid=f"motor point {name}",
                  path_effects=[withStroke(linewidth=1.8, foreground="white")])


def _channel_key(figure: Figure, shares: Array | None, commands: Array | None) -> None:
    """Key of channels with their current and pulse width."""
    count = max(0 if each is None else len(each) for each in (shares, commands))
    for channel in range(count):
        text = f"channel {channel}"
        if commands is not None and channel < len(commands):
            current, width = commands[channel]
            text += f": {1e3 * current:.1f} mA, {1e6 * width:.0f} µs" if current > 0.0 else ": off"
        column, row = channel % 4, channel // 4
        figure.text(0.05 + 0.16 * column, 0.075 - 0.03 * row, f"● {text}", fontsize=9,
                    color=channel_colour(channel))


def _colour_bar(figure: Figure, highest: float) -> None:
    axes = figure.add_axes((0.46, 0.9, 0.2, 0.016))
    scale = np.linspace(0.0, highest, 128)
    axes.imshow(_colours(scale, highest)[np.newaxis], extent=(0.0, max(1e6 * highest, 1e-9), 0.0, 1.0),
                aspect="auto")
    axes.set_yticks([])
    axes.tick_params(labelsize=7)
    axes.set_title("charge a phase, µC", fontsize=8, loc="left", color=INK, pad=3)


Instants = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Stimulation:
    """Stimulation at some instants t; None for signals that were not recorded.

    Attributes
    ----------
    charge: (t, elements), C a phase, of each element's newest pulse.
    shares: (t, channels, elements), of each channel's current that each element has.
    commands: (t, channels, 2), A and s.
    """

    charge: Array | None
    shares: Array | None
    commands: Array | None


def stimulation_at(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants
) -> tuple[Stimulation, list[str]]:
    """Stimulation at instants, and notes on missing signals."""
    commands = values_at(recording, cast.stimulation, trial, at_ns) if cast.stimulation else None
    shares = _shares(recording, cast, trial, at_ns, commands)
    charge = None
    if cast.stimulator is not None:
        name = cast.stimulator.name
        recorded = first_recorded(recording, (f"{name}.element_charge", f"{name}.charge"))
        charge = values_at(recording, recorded, trial, at_ns) if recorded else None
        if charge is not None and recorded.endswith(".charge"):
            charge = None if shares is None else np.einsum("tc,tce->te", charge, shares)
    notes = []
    if shares is None:
        notes.append("virtual electrodes are not outlined: neither the multiplexing is recorded nor does the "
                     "stimulator have `shares`")
    if charge is None:
        notes.append("elements have no colour: the stimulator's charges are not recorded")
    return Stimulation(charge, shares, commands), notes


def _shares(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, commands: Array | None
) -> Array | None:
    """Shares from the recorded multiplexing, or else from the stimulator's virtual electrodes."""
    if cast.multiplexing in recording.signals:
        return values_at(recording, cast.multiplexing, trial, at_ns)
    if cast.multiplexing or cast.stimulator is None or not hasattr(type(cast.stimulator.part), "shares"):
        return None
    part = cast.stimulator.part
    if hasattr(part, "resolve") and commands is not None:
        part = part.resolve({"stimulation": commands.shape[1:]})
    own: Array = part.shares
    return np.broadcast_to(own, (len(at_ns), *own.shape))

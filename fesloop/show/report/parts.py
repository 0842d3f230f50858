"""Parts of a report: a page has sections, a section has parts. They are independent of HTML.

Colours are roles, not values, so that a page is legible on light, on dark and on paper: `reference`, `truth`,
`estimate`, `controller`, `tracker`, `theory`, `plain`, and `channel-0` to `channel-7`, `series-0` to
`series-7` for the rest.
"""


from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.show.picture.hand_mesh import Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Figure3d:
    """Moving hand: true and estimated.

    Attributes
    ----------
    trials: frames by trial.
    shapes: of each hand ("truth", "estimate"): a mesh a segment, in the segment's frame, m.
    objects: other solids: an object that moves with a pose of its own, or a table that does not.
    view: (3,), first direction of view, into the scene; global (east, north, up), of any length.
    text: one sentence as alternative text.
    """

    key: str
    trials: Mapping[int, Frames]
    shapes: Mapping[str, Sequence[Mesh]]
    objects: Sequence[Solid] = ()
    view: tuple[float, float, float] = (0.6, 0.6, -0.5)
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """Solid in the scene: `kind` cylinder, sphere, box or plane, with half sizes (3,), m.

    `role`: of its colour. `moves`: whether its pose is in the frames (`objects`, in order) or is `pose`.
    """

    kind: str
    half_sizes: tuple[float, float, float]
    role: str
    moves: bool
    pose: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frames:
    """Poses at evenly spaced instants of one trial; pages interpolate between them.

    Attributes
    ----------
    start_s, step_s: instant of the first, and between two.
    hands: by name ("truth", "estimate"): orientation (w, x, y, z) and position of each segment, global,
        (frames, segments, 7), m; NaN where it is not known.
    objects: (frames, objects that move, 7).
    """

    start_s: float
    step_s: float
    hands: Mapping[str, Array]
    objects: Array = field(default_factory=lambda: np.empty((0, 0, 7)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """Series of a chart.

    Attributes
    ----------
    name: in the key. role: of its colour.
    x, y: (n,); NaN in y is a gap. low, high: (n,), a band around the line (an interval, or the extremes of
        the samples merged into one point), or a bar at each point; None without one.
    style: "line", "dashed", "steps" (held until the next point) or "points".
    thinned: most samples that a point stands for; `thinned_in_words` explains y.
    """

    name: str
    role: str
    x: Array
    y: Array
    low: Array | None = None
    high: Array | None = None
    style: str = "line"
    thinned: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """Named instant or interval of the x axis, such as an event; of an instant `until` equals `at`."""

    text: str
    at: float
    until: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart:
    """Lines over a common x.

    Attributes
    ----------
    key: unique within the page. title: heading; units are in the labels ("error, deg").
    trial: trial with which it is shown; None for all.
    timed: x is the time in the trial, s: the chart shows the play head of the hand, and a click moves it.
    limits: (low, high) of y; None to fit the lines.
    x_levels: texts at x = 0, 1, 2, ..., where x counts kinds; empty where it is a number.
    x_log: numbers of x are spaced by their ratios.
    text: one sentence for those who cannot see it.
    """

    key: str
    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    marks: Sequence[Mark] = ()
    trial: int | None = None
    timed: bool = False
    limits: tuple[float, float] | None = None
    x_levels: Sequence[str] = ()
    x_log: bool = False
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strips:
    """Lines in strips below each other, over a common x.

    They suit lines that would cover each other in one chart, as channels of a stimulator do. Other attributes
    are those of a chart.

    Attributes
    ----------
    lines: one per strip, under its name.
    limits: (low, high) of y in every strip; None to fit the lines.
    """

    key: str
    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    trial: int | None = None
    timed: bool = False
    limits: tuple[float, float] | None = None
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bars:
    """Horizontal bars by name, side by side or stacked.

    Attributes
    ----------
    names: of the bars. values: by series (name in the key, in stacking order), one per bar; NaN if missing.
        roles: of the series. stacked: whether the series add up.
    """

    key: str
    title: str
    x_label: str
    names: Sequence[str]
    values: Mapping[str, Sequence[float]]
    roles: Mapping[str, str]
    stacked: bool = True
    trial: int | None = None
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeatMap:
    """Values in the cells of a grid.

    Attributes
    ----------
    x_levels, y_levels: texts of columns and, from below, rows. values: (rows, columns), NaN if missing.
        cells: text of each cell. told: tooltip of each cell.
    contours: curves over it, with x and y in columns and rows counted from 0, such as a bound from theory.
    low, high: ends of the colour scale; if they are not finite, cells have no colour. better: the good end,
        "low" or "high".
    """

    key: str
    title: str
    x_label: str
    y_label: str
    x_levels: Sequence[str]
    y_levels: Sequence[str]
    values: Array
    cells: Sequence[Sequence[str]]
    told: Sequence[Sequence[str]]
    value_label: str
    low: float
    high: float
    better: str = "low"
    contours: Sequence[Line] = ()
    text: str = ""

    @property
    def lack(self) -> str:
        """Sentence on why no cell has a colour; empty if cells have colours."""
        if not np.isfinite(self.values).any():
            return "No cell has a value."
        if not np.isfinite([self.low, self.high]).all():
            return "Cells have no colours: between which values these would lie is not known."
        return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Table of texts; columns of numbers are aligned to the right. `trial` is that of a chart.

    about: definitions of headings and of first cells, shown where a pointer rests on them.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    trial: int | None = None
    about: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """Static picture: one `<svg>` element with a viewBox.

    Its colours are classes of the page's style: `ink`, `faint`, `paper` and, for roles, `fill-ROLE` and
    `stroke-ROLE`. It holds no script and no address.
    """

    key: str
    title: str
    svg: str
    text: str
    trial: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """Plain text; text between backquotes is code."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """Notice of something that cannot be shown, and why."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Fold:
    """Parts that are hidden until their title is opened."""

    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Code:
    """Literal text, such as TOML or a command."""

    text: str


Part = (Chart | Strips | Bars | HeatMap | Table | Drawing | Paragraph | Notice | Fold | Code | Figure3d)


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """Heading with parts; `key` is its address in the page."""

    key: str
    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """A report.

    Attributes
    ----------
    title: of the page. sentence: summary. facts: under the title (experiment, seed, versions).
    trials: trials that can be chosen; empty if there is no choice.
    shown: trial that is chosen at first. at_s: its instant at which the hand is shown until it is played;
        None: the first.
    """

    title: str
    sentence: str
    facts: Sequence[tuple[str, str]]
    sections: Sequence[Section]
    trials: Sequence[int] = ()
    shown: int = 0
    at_s: float | None = None

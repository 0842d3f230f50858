"""What a report is made of: a page has sections, a section has parts. Nothing here knows HTML.

Colours are roles, not values, so that a page is right on light, on dark and on paper: `reference`, `truth`,
`estimate`, `controller`, `tracker`, `theory`, `plain`, and `channel-0` to `channel-7`, `series-0` to
`series-7` for what has no role of its own.
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
    """A hand in motion: as it was, and as the tracker had it.

    Attributes
    ----------
    trials: frames by trial.
    shapes: of each hand ("truth", "estimate"): a mesh a segment, in the segment's frame, m.
    objects: what else stands there: an object that moves with a pose of its own, or a table that does not.
    view: (3,), from where it is first looked at, into the scene; global (east, north, up), of any length.
    text: one sentence for those who cannot see it.
    """

    key: str
    trials: Mapping[int, Frames]
    shapes: Mapping[str, Sequence[Mesh]]
    objects: Sequence[Solid] = ()
    view: tuple[float, float, float] = (0.6, 0.6, -0.5)
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """Something else to be seen: `kind` cylinder, sphere, box or plane, with its half sizes (3,), m.

    `role` of its colour; `moves`: its pose is in each frame under `objects`, in their order; else `pose`.
    """

    kind: str
    half_sizes: tuple[float, float, float]
    role: str
    moves: bool
    pose: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frames:
    """Poses at evenly spaced instants of one trial; between them a page turns and moves smoothly.

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
    """A series of a chart.

    Attributes
    ----------
    name: in the key. role: of its colour.
    x, y: (n,); NaN in y is a gap. low, high: (n,), a band about it (an interval, or the extremes of what was
        drawn together into one point), of points a bar each; None where there is none.
    style: "line", "dashed", "steps" (held until the next point) or "points".
    thinned: how many samples a point stands for, at most; what y is of them, `thinned_in_words` says.
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
    """A moment or a stretch of the x axis that has a name: an event, a phase. `until` is `at` of a moment."""

    text: str
    at: float
    until: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart:
    """Lines over a common x.

    Attributes
    ----------
    key: names it within its page. title: what a reader sees in it; units stand in the labels ("error, deg").
    trial: the trial it is of, shown when that is chosen; None where it is of all.
    timed: x is the time in the trial in s: the play head of the hand stands in it, a click moves that there.
    limits: (low, high) of y; None where the lines say.
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
    """Lines below each other, each in a strip of its own over a common x.

    For those that in one frame would lie on each other, as channels of a stimulator do. What is not told here
    is as of a chart.

    Attributes
    ----------
    lines: one a strip, whose name stands over it.
    limits: (low, high) of y, in every strip, so that they compare; None where the lines say.
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
    """Shares or sizes by name, side by side or stacked; horizontal.

    Attributes
    ----------
    names: of the bars. values: by series (name in the key, in the order in which they are stacked), one a
        bar; NaN where there is none. roles: of the series. stacked: whether they add up.
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
    """A value in each cell of a grid.

    Attributes
    ----------
    x_levels, y_levels: texts of the columns and, from below, the rows. values: (rows, columns); NaN where
        there is none. cells: what stands in each cell, and what is told of it when pointed at.
    contours: curves over it, x and y in columns and rows counted from 0 (theory's bound, say).
    low, high: ends of the colour scale; without numbers there no cell has a colour. better: "low" or "high",
        which end is the good one.
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
        """Why no cell has a colour, a sentence; empty where that is not so."""
        if not np.isfinite(self.values).any():
            return "No cell has a value."
        if not np.isfinite([self.low, self.high]).all():
            return "Cells have no colours: between which values these would lie is not known."
        return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Texts in rows; a column of numbers is aligned to the right. `trial` as of a chart."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    trial: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """A picture that is drawn ready: one `<svg>` element with a viewBox.

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
    """Plain text; what stands between backquotes is code."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """What could not be shown, and why."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Fold:
    """Parts behind a title that is opened by whoever wants to see them."""

    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Code:
    """Text as it is: an experiment in TOML, a command."""

    text: str


Part = (Chart | Strips | Bars | HeatMap | Table | Drawing | Paragraph | Notice | Fold | Code | Figure3d)


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A heading and what stands under it; `key` is its address in the page."""

    key: str
    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """A report.

    Attributes
    ----------
    title: of the page. sentence: its result. facts: small print under the title (experiment, seed, versions).
    trials: numbers of the trials that can be chosen; empty where there is nothing to choose.
    shown: the trial that is chosen at first.
    """

    title: str
    sentence: str
    facts: Sequence[tuple[str, str]]
    sections: Sequence[Section]
    trials: Sequence[int] = ()
    shown: int = 0

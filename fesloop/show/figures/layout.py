"""Layout of figures: title, panels, key and caption."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fesloop.show.figures.content import Content
from fesloop.show.picture.palette import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_MOST_ABREAST = 4
_TITLE_IN, _CAPTION_IN, _KEY_IN, _EDGE_IN = 0.2, 0.15, 0.22, 0.08
"""Heights of a line of title, caption and key, and the room about them, inches."""
_TITLE_LETTERS, _CAPTION_LETTERS, _KEY_LETTERS = 10.5, 17.0, 14.0
"""Letters per inch."""
_HANDLE_IN = 0.6
"""Width of a handle in a key with the room around it, inches."""


def columns_of(count: int) -> int:
    """Panels abreast, rows as even as can be."""
    rows = -(-count // _MOST_ABREAST)
    return -(-count // rows)


def lay_out(count: int, size: tuple[float, float], title: str, caption: str, key: Sequence[str],
            key_at: Literal["above", "beside"]) -> tuple[Drawing, list[Axes]]:
    """A drawing of so many panels of a size, inches, with room for a key of these labels; its panels.

    Panels share their scales.
    """
    from matplotlib.figure import Figure as Drawing

    columns = columns_of(count)
    rows = -(-count // columns)
    beside = _HANDLE_IN + max(map(len, key)) / _KEY_LETTERS if key and key_at == "beside" else 0.0
    wide = columns * size[0] + beside
    head, foot = (textwrap.wrap(text, int(letters * wide))
                  for text, letters in ((title, _TITLE_LETTERS), (caption, _CAPTION_LETTERS)))
    below = _CAPTION_IN * len(foot) + _EDGE_IN
    above = _TITLE_IN * len(head) + _EDGE_IN + (_KEY_IN if key and key_at == "above" else 0.0)
    high = rows * size[1] + above + below
    drawing = Drawing(figsize=(wide, high), dpi=150, layout="constrained")
    layout: Any = drawing.get_layout_engine()
    layout.set(rect=(0.0, below / high, 1.0 - beside / wide, 1.0 - (above + below) / high))
    drawing.text(_EDGE_IN / wide, 1.0 - _EDGE_IN / high, "\n".join(head), ha="left", va="top", fontsize=11,
                 color=INK, gid="title")
    drawing.text(_EDGE_IN / wide, (below - 0.3 * _EDGE_IN) / high, "\n".join(foot), ha="left", va="top",
                 fontsize=7.5, color="0.35", gid="caption")
    every = drawing.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel().tolist()
    for spare in every[count:]:
        spare.set_visible(False)
    for axes in every[max(0, count - columns):count]:
        axes.tick_params(labelbottom=True)
    return drawing, every[:count]


def is_lowest(number: int, count: int) -> bool:
    """Return whether a panel is in the lowest row of its column."""
    return number + columns_of(count) >= count


def is_leftmost(number: int, count: int) -> bool:
    """Return whether a panel is in the leftmost column."""
    return number % columns_of(count) == 0


def add_key(
    drawing: Drawing, handles: dict[str, Any], at: Literal["above", "beside"], name: str = ""
) -> None:
    """The key, in the room that `lay_out` left for it: nothing is hidden by it."""
    if not handles:
        return
    layout: Any = drawing.get_layout_engine()
    _, bottom, width, height = layout.get()["rect"]
    beside: dict[str, Any] = {"bbox_to_anchor": (width, bottom + height), "title": name or None}
    above: dict[str, Any] = {"bbox_to_anchor": (_EDGE_IN / drawing.get_figwidth(), bottom + height),
             "ncols": len(handles), "borderpad": 0.1}
    look: dict[str, Any] = {"frameon": False, "fontsize": 8, "title_fontsize": 8, "alignment": "left",
                            "borderaxespad": 0.2, **(beside if at == "beside" else above)}
    drawing.legend(handles.values(), handles, loc="upper left" if at == "beside" else "lower left", **look)


def rewrite_caption(drawing: Drawing, caption: str) -> None:
    """Replace the caption by another one, which must not need more room."""
    for text in drawing.texts:
        if text.get_gid() == "caption":
            text.set_text("\n".join(textwrap.wrap(caption, int(_CAPTION_LETTERS * drawing.get_figwidth()))))


_ROOM = 0.06
"""Room above the data, as a share of the range of values."""


def curve_ends(content: Content) -> tuple[float, float]:
    """Limits of the metric in all panels: from 0 if no value is negative; shares to 100 %.

    Intervals and theory may reach far out, as intervals of two replicates do, or theory where a loop is about
    to become unstable: they are cut where they exceed the values by more than the span of the values.
    """
    values = content.factor * np.array([cell.value for cell in content.cells if np.isfinite(cell.value)])
    least, most = float(values.min(initial=0.0)), float(values.max(initial=0.0))
    span = most - least if most > least else 1.0
    beyond = [content.factor * cell.high for cell in content.cells]
    beyond += [float(y) for overlay in content.overlays for y in overlay.y]
    above = max((each for each in beyond if np.isfinite(each)), default=most)
    below = min((content.factor * cell.low for cell in content.cells if np.isfinite(cell.low)), default=least)
    high = 102.0 if content.share else float(np.clip(above, most, most + span)) + _ROOM * span
    low = 0.0 if least >= 0.0 else float(np.clip(below, least - span, least)) - _ROOM * span
    figure = content.figure
    low = low if figure.low is None else content.factor * figure.low
    high = high if figure.high is None else content.factor * figure.high
    return low, high


def colour_ends(content: Content) -> tuple[float, float]:
    """Ends of the colour scale in all panels: the figure's own, or those of its values; shares to 100 %."""
    known = [cell.value for cell in content.cells if np.isfinite(cell.value)]
    ends = (0.0, 1.0) if content.share or not known else (min(known), max(known))
    low, high = (own if own is not None else found
                 for own, found in zip((content.figure.low, content.figure.high), ends, strict=True))
    return content.factor * low, content.factor * (high if high > low else low + 1.0)

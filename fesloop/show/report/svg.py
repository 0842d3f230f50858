"""SVG elements of drawings in reports, as text."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

_HEAD = 7.0
"""Length of an arrowhead."""
_NO_LETTERS = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 does not allow (W3C Recommendation, fifth edition, production 2)."""
Point = tuple[float, float]


def drawing(width: float, height: float, pieces: Iterable[str]) -> str:
    """The `<svg>` element with these pieces; its natural width is `width` pixels."""
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_n(width)} {_n(height)}" '
            f'width="{_n(width)}" height="{_n(height)}">{"".join(pieces)}</svg>')


def text(x: float, y: float, words: str, *, kind: str = "ink", size: float = 12.0, anchor: str = "start",
         bold: bool = False) -> str:
    """Text whose baseline passes through (x, y)."""
    weight = ' font-weight="600"' if bold else ""
    return (f'<text x="{_n(x)}" y="{_n(y)}" class="{kind}" font-size="{_n(size)}" '
            f'text-anchor="{anchor}"{weight}>{_escaped(words)}</text>')


def rect(x: float, y: float, width: float, height: float, kind: str, *, radius: float = 0.0,
         opacity: float = 1.0, tooltip: str = "") -> str:
    """Rectangle, with a tooltip if one is given."""
    return (f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(width)}" height="{_n(height)}" rx="{_n(radius)}" '
            f'class="{kind}"{_opacity(opacity)}>{_title(tooltip)}</rect>')


def circle(x: float, y: float, radius: float, kind: str, *, opacity: float = 1.0, width: float = 1.0,
           tooltip: str = "") -> str:
    """Disc or, by its classes, ring; `opacity` is that of its inside."""
    return (f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(radius)}" class="{kind}" stroke-width="{_n(width)}"'
            f"{_opacity(opacity)}>{_title(tooltip)}</circle>")


def line(start: Point, end: Point, kind: str, *, width: float = 1.0, dashed: bool = False) -> str:
    """Straight line."""
    dashes = ' stroke-dasharray="4 3"' if dashed else ""
    return (f'<line x1="{_n(start[0])}" y1="{_n(start[1])}" x2="{_n(end[0])}" y2="{_n(end[1])}" '
            f'class="{kind}" stroke-width="{_n(width)}"{dashes}/>')


def polyline(points: Iterable[Point], kind: str, *, width: float = 1.0, tooltip: str = "") -> str:
    """Open line through points, with rounded corners."""
    way = " L".join(f"{_n(x)} {_n(y)}" for x, y in points)
    return (f'<path d="M{way}" class="{kind}" fill="none" stroke-width="{_n(width)}" '
            f'stroke-linejoin="round">{_title(tooltip)}</path>')


def arrow_head(before: Point, tip: Point, kind: str) -> str:
    """Triangle at the end of a line that comes from `before`."""
    angle = math.atan2(tip[1] - before[1], tip[0] - before[0])
    corners = [tip, *((tip[0] - _HEAD * math.cos(angle + turn), tip[1] - _HEAD * math.sin(angle + turn))
                      for turn in (0.42, -0.42))]
    points = " ".join(f"{_n(x)},{_n(y)}" for x, y in corners)
    return f'<polygon points="{points}" class="{kind}"/>'


def _title(tooltip: str) -> str:
    return f"<title>{_escaped(tooltip)}</title>" if tooltip else ""


def _escaped(words: str) -> str:
    """Escaped text, with characters that XML does not allow replaced."""
    return escape(_NO_LETTERS.sub("\N{REPLACEMENT CHARACTER}", words))


def _opacity(opacity: float) -> str:
    return "" if opacity >= 1.0 else f' fill-opacity={quoteattr(f"{opacity:.2f}")}'


def _n(value: float) -> str:
    """Coordinate rounded to a tenth."""
    return f"{value:.1f}".removesuffix(".0")

"""What a point search asked, on the arrays: how good each virtual electrode was, and in what order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.search import Asked
from fesloop.show.picture.unrolled import CUT_DEG, unrolled
from fesloop.show.report.run import svg

Array = NDArray[np.float64]
Electrode = tuple[int, ...]
_SCALE = 2.6
"""Pixels a mm, where the page is as wide as the drawing."""
_AROUND_MM = 17.0
_PALEST, _DEEPEST = 0.12, 0.7
"""Opacities of quality 0 and of the best: numbers stay readable on the deepest (chosen)."""
_STOP = 10.0
"""Radius of a stop of the path, pixels."""
_GOOD, _POOR = "series-0", "series-1"
"""Roles of qualities above 0 and below."""
MOST_STEPS = 150
"""Ways from electrode to electrode that are drawn: more of them is a scribble (chosen)."""


def qualities_of(asked: Sequence[Asked]) -> dict[Electrode, float]:
    """Best true quality of every virtual electrode that was asked, in order of its first query."""
    best: dict[Electrode, float] = {}
    for one in asked:
        best[one.elements] = max(one.verdict.quality, best.get(one.elements, -np.inf))
    return best


def quality_svg(electrodes: Any, qualities: Mapping[Electrode, float], found: Electrode | None) -> str:
    """Elements and joined elements, deeper the better they were; what was found has a ring.

    `electrodes`: the block; its `places` (elements, 3): around, along, radius, mm; its `radius_mm`.
    """
    skin = _Skin(electrodes)
    scale = max((abs(quality) for quality in qualities.values()), default=0.0)
    pieces = [*skin.boxes(), *_rings(skin, found or ()), *skin.pads()]
    # Joined elements lie below single ones, and good ones above poor ones.
    for electrode, quality in sorted(qualities.items(), key=lambda item: (-len(item[0]), item[1])):
        pieces += _electrode(skin, electrode, quality, scale)
    pieces += [*skin.numbers(), *_key(skin, min(qualities.values(), default=0.0), scale)]
    return svg.drawing(skin.wide, skin.high + 52.0, pieces)


def path_svg(electrodes: Any, asked: Sequence[Asked]) -> str:
    """The way from electrode to electrode, numbered in the order of their first queries."""
    skin = _Skin(electrodes)
    way = [one.elements for one in asked]
    stops = [way[0], *(other for one, other in pairwise(way) if other != one)] if way else []
    points = [skin.middle(electrode) for electrode in stops]
    pieces = [*skin.boxes(), *skin.pads()]
    if len(points) <= MOST_STEPS:
        pieces += [svg.line(start, end, "stroke-plain", width=0.4 + 0.8 * number / len(points))
                   for number, (start, end) in enumerate(pairwise(points))]
    for number, electrode in reversed(list(enumerate(dict.fromkeys(stops)))):
        x, y = skin.middle(electrode)
        late = number / max(1, len(set(stops)) - 1)
        pieces.append(svg.circle(x, y, _STOP, "paper stroke-plain", width=1.0))
        pieces.append(svg.circle(x, y, _STOP, f"fill-{_GOOD}", opacity=0.06 + 0.6 * late,
                                 told=f"{number + 1}: {_told(electrode)}"))
        pieces.append(svg.text(x, y + 3.7, str(number + 1), size=10.5, anchor="middle", bold=number == 0))
    return svg.drawing(skin.wide, skin.high + 20.0, pieces)


class _Skin:
    """The forearm's skin unrolled, in pixels."""

    def __init__(self, electrodes: Any) -> None:
        places = unrolled(electrodes.places, electrodes.radius_mm)
        first = np.deg2rad(CUT_DEG) * electrodes.radius_mm
        corner = np.array([first, places[:, 1].min() - _AROUND_MM])
        self.wide = _SCALE * 2.0 * np.pi * electrodes.radius_mm
        self.high = _SCALE * float(np.ptp(places[:, 1]) + 2.0 * _AROUND_MM)
        self.places: Array = np.column_stack((_SCALE * (places[:, :2] - corner), _SCALE * places[:, 2]))

    def middle(self, electrode: Electrode) -> tuple[float, float]:
        """Of its elements."""
        x, y = self.places[list(electrode), :2].mean(axis=0).tolist()
        return x, y

    def boxes(self) -> Iterator[str]:
        """Back and front, and what lies where."""
        for x, name in ((0.0, "back"), (0.5 * self.wide, "front")):
            yield svg.rect(x + 0.5, 0.5, 0.5 * self.wide - 1.0, self.high - 1.0, "paper stroke-plain",
                           radius=4.0)
            yield svg.text(x + 8.0, 16.0, f"{name} of the forearm", kind="faint", size=12.0)
        yield svg.text(self.wide - 8.0, 16.0, "elbow ↑", kind="faint", size=12.0, anchor="end")
        yield svg.text(self.wide - 8.0, self.high - 6.0, "wrist ↓", kind="faint", size=12.0, anchor="end")
        for share, name, anchor in ((0.0, "ulnar", "start"), (0.5, "radial", "middle"),
                                    (1.0, "ulnar", "end")):
            yield svg.text(share * self.wide, self.high + 15.0, name, kind="faint", size=12.0, anchor=anchor)

    def pads(self) -> Iterator[str]:
        """Every element, empty."""
        for x, y, radius in self.places.tolist():
            yield svg.circle(x, y, radius, "paper stroke-plain", width=0.8)

    def numbers(self) -> Iterator[str]:
        """Of the elements."""
        for element, (x, y, radius) in enumerate(self.places.tolist()):
            yield svg.text(x, y + 0.4 * radius, str(element), size=9.5, anchor="middle")


def _rings(skin: _Skin, found: Electrode) -> Iterator[str]:
    """About the elements that were found; pads are laid over them."""
    for element in found:
        x, y, radius = skin.places[element].tolist()
        yield svg.circle(x, y, radius + 4.0, "fill-theory", told=f"found: {_told(found)}")


def _key(skin: _Skin, lowest: float, scale: float) -> Iterator[str]:
    """What colours say."""
    yield svg.text(0.0, skin.high + 42.0, "quality", kind="faint", size=12.0)
    for number, share in enumerate((-1.0, -0.5, 0.0, 0.5, 1.0) if lowest < 0.0 else (0.0, 0.5, 1.0)):
        x, y = 64.0 + 82.0 * number, skin.high + 38.0
        role = _GOOD if share >= 0.0 else _POOR
        yield svg.circle(x, y, 9.0, "paper stroke-plain", width=0.8)
        yield svg.circle(x, y, 9.0, f"fill-{role}", opacity=_opacity(share))
        yield svg.text(x + 14.0, y + 4.0, f"{share * scale:.2f}", size=12.0)


def _opacity(share: float) -> float:
    """Of a quality that is such a share of the best."""
    return _PALEST + (_DEEPEST - _PALEST) * abs(share)


def _electrode(skin: _Skin, electrode: Electrode, quality: float, scale: float) -> Iterator[str]:
    """A disc; of joined elements a disc at each and in the middle between them."""
    share = quality / scale if scale else 0.0
    role = f"fill-{_GOOD if quality >= 0.0 else _POOR}"
    told = f"{_told(electrode)}: quality {quality:.2f}"
    opacity = _opacity(share)
    if len(electrode) == 1:
        x, y, radius = skin.places[electrode[0]].tolist()
        yield svg.circle(x, y, radius, role, opacity=opacity, told=told)
        return
    x, y = skin.middle(electrode)
    for element in electrode:
        yield svg.line((x, y), skin.middle((element,)), "stroke-plain", width=1.0)
    size = 0.55 * float(skin.places[list(electrode), 2].mean())
    yield svg.circle(x, y, size, "paper stroke-plain", width=0.6)
    yield svg.circle(x, y, size, role, opacity=opacity, told=told)


def _told(electrode: Electrode) -> str:
    what = "element" if len(electrode) == 1 else "elements"
    return f"{what} {' and '.join(map(str, electrode))}"

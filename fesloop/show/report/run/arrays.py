"""The arrays drawn: the forearm's skin unrolled, its elements by their charge, and the motor points below."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.muscles import muscle
from fesloop.show.picture.labels import placed_labels
from fesloop.show.picture.unrolled import CUT_DEG, motor_points, unrolled
from fesloop.show.report.run import svg
from fesloop.show.report.run.words import told

Array = NDArray[np.float64]
_SCALE = 2.6
"""Pixels a mm, where the page is as wide as the drawing."""
_AROUND_MM, _POINT_MM = 12.0, 2.0
_LARGER = 1.7
"""Letters are so much larger than those of the printed picture, whose labels keep out of each other's way."""
_LETTER, _HEIGHT = 7.2, 13.0
_ACTIVE = 0.05
"""Muscles below this activation are not named (chosen): there are more than there is room for."""


def arrays_svg(electrodes: Any, charge: Array | None, highest: float, shares: Array | None,
               strongest: Array | None) -> str:
    """The drawing.

    Parameters
    ----------
    electrodes: the block; its `places` (elements, 3): around, along, radius, mm; its `radius_mm`; and where
        it has them its `motor_points` (muscle, around_deg, along_mm).
    charge: (elements,), C. highest: that of the deepest colour. shares: (channels, elements), C, of each
        channel. strongest: (29,), greatest activation of each muscle. None for what is not known.
    """
    places, points = unrolled(electrodes.places, electrodes.radius_mm), motor_points(electrodes)
    along = np.concatenate([places[:, 1], [place[1] for place in points.values()]])
    turn = 2.0 * np.pi * electrodes.radius_mm
    corner = np.array([np.deg2rad(CUT_DEG) * electrodes.radius_mm, along.min() - _AROUND_MM])
    size = np.array([turn, along.max() + _AROUND_MM - corner[1]])
    places = np.column_stack((_SCALE * (places[:, :2] - corner), _SCALE * places[:, 2]))
    spots = {name: _SCALE * (place - corner) for name, place in points.items()}
    wide, high = (_SCALE * size).tolist()
    pieces = [*_skin(wide, high), *_elements(places, charge, highest, shares),
              *_points(spots, strongest)]
    return svg.drawing(wide, high + 20.0, pieces)


def _skin(wide: float, high: float) -> Iterator[str]:
    """Back and front, each half of a turn, and what lies where."""
    for x, name in ((0.0, "back"), (0.5 * wide, "front")):
        yield svg.rect(x + 0.5, 0.5, 0.5 * wide - 1.0, high - 1.0, "paper stroke-plain", radius=4.0)
        yield svg.text(x + 8.0, 16.0, f"{name} of the forearm", kind="faint", size=12.0)
    yield svg.text(wide - 8.0, 16.0, "elbow ↑", kind="faint", size=12.0, anchor="end")
    yield svg.text(wide - 8.0, high - 6.0, "wrist ↓", kind="faint", size=12.0, anchor="end")
    for share, name, anchor in ((0.0, "ulnar", "start"), (0.5, "radial", "middle"), (1.0, "ulnar", "end")):
        yield svg.text(share * wide, high + 15.0, name, kind="faint", size=12.0, anchor=anchor)


def _elements(places: Array, charge: Array | None, highest: float, shares: Array | None) -> Iterator[str]:
    """Pads, filled in the colour of the channel that gave most, the deeper the more."""
    for element, (x, y, radius) in enumerate(places.tolist()):
        given = 0.0 if charge is None else float(charge[element])
        words = f"element {element}"
        if charge is not None:
            words += f": {told(1e6 * given) if given else 0} µC"
        yield svg.circle(x, y, radius, "paper stroke-plain", width=0.8, told=words)
        if given > 0.0 and highest > 0.0:
            role = "plain"
            if shares is not None:
                channel = int(np.argmax(shares[:, element]))
                role, words = f"channel-{channel % 8}", f"{words}, channel {channel}"
            yield svg.circle(x, y, radius, f"fill-{role}", opacity=0.2 + 0.8 * given / highest, told=words)
        yield svg.text(x, y + 0.85 * radius, str(element), kind="faint", size=9.0, anchor="middle")


def _points(spots: dict[str, Array], strongest: Array | None) -> Iterator[str]:
    """Motor points, filled where the muscle was active, whose name then stands there."""
    active = {name: float(strongest[muscle(name)]) for name in spots
              if strongest is not None and strongest[muscle(name)] >= _ACTIVE}
    for name, (x, y) in spots.items():
        share = active.get(name)
        words = f"motor point of {name}" + (f", activated to {100.0 * share:.0f} %" if share else "")
        kind = "fill-plain" if share else "paper stroke-plain"
        yield svg.circle(x, y, _SCALE * _POINT_MM, kind, told=words)
    shrunk = {name: spots[name] / (_SCALE * _LARGER) for name in active}
    for name, place in placed_labels(shrunk, {name: name for name in active}, _POINT_MM / _LARGER).items():
        x, y = (_SCALE * _LARGER * place).tolist()
        wide = _LETTER * len(name)
        yield svg.rect(x - 0.5 * wide, y - 0.5 * _HEIGHT, wide, _HEIGHT, "paper", radius=3.0, opacity=0.75)
        yield svg.text(x, y + 4.0, name, size=11.5, anchor="middle", bold=True)

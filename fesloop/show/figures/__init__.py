"""Figures of a study: heat maps and curves, with theory over them."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from fesloop.show.figures.content import Overlay
    from fesloop.show.figures.drawing import draw

__all__ = ["Overlay", "draw"]

__getattr__ = found_in(__name__, {"Overlay": "content", "draw": "drawing"})

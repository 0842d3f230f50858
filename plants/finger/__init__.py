"""An index finger moved by four stimulated muscles, exact at any instant."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.finger.plant import Finger

__all__ = ["Finger"]

__getattr__ = found_in(__name__, {"Finger": "plant"})

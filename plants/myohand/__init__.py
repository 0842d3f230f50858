"""MyoHand, a hand made by others, in the place of `hand`."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.myohand.plant import MyoHand

__all__ = ["MyoHand"]

__getattr__ = found_in(__name__, {"MyoHand": "plant"})

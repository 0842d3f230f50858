"""A hand that follows a script exactly, and the scripts."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.moving_hand.plant import MovingHand

__all__ = ["MovingHand"]

__getattr__ = found_in(__name__, {"MovingHand": "plant"})

"""A whole hand in MuJoCo, moved by 29 muscles, that can grasp."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.hand.plant import Hand

__all__ = ["Hand"]

__getattr__ = found_in(__name__, {"Hand": "plant"})

"""A person's attempts to move, and the surface EMG of their muscles."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.intention.block import Intention

__all__ = ["Intention"]

__getattr__ = found_in(__name__, {"Intention": "block"})

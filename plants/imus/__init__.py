"""Inertial and magnetic sensors, and what disturbs them."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.imus.block import Imus
    from plants.imus.finger_imus import FingerImus

__all__ = ["FingerImus", "Imus"]

__getattr__ = found_in(__name__, {"FingerImus": "finger_imus", "Imus": "block"})

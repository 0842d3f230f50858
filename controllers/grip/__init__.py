"""Control of the force on a held object."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.grip.block import GripForce

__all__ = ["GripForce"]

__getattr__ = found_in(__name__, {"GripForce": "block"})

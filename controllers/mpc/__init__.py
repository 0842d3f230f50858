"""Linear model predictive control through recruitment."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.mpc.block import Mpc

__all__ = ["Mpc"]

__getattr__ = found_in(__name__, {"Mpc": "block"})

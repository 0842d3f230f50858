"""Linear plants, with or without a static nonlinearity before them."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.linear.state_space import StateSpace

__all__ = ["StateSpace"]

__getattr__ = found_in(__name__, {"StateSpace": "state_space"})

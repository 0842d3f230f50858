"""Tracker without magnetometers that uses the constraints of joints."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.constrained.block import ConstrainedTracker

__all__ = ["ConstrainedTracker"]

__getattr__ = found_in(__name__, {"ConstrainedTracker": "block"})

"""The tracker of Kortier et al. 2014."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.kortier.block import KortierTracker

__all__ = ["KortierTracker"]

__getattr__ = found_in(__name__, {"KortierTracker": "block"})

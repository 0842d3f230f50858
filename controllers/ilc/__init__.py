"""Iterative learning control."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.ilc.block import Ilc

__all__ = ["Ilc"]

__getattr__ = found_in(__name__, {"Ilc": "block"})

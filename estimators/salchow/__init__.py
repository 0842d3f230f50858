"""The trackers of Salchow-Hoemmen et al. 2019: B, M1, M2."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.salchow.block import SalchowB, SalchowM1, SalchowM2

__all__ = ["SalchowB", "SalchowM1", "SalchowM2"]

__getattr__ = found_in(__name__, {"SalchowB": "block", "SalchowM1": "block", "SalchowM2": "block"})

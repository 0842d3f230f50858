"""Functional mock-up units (FMUs) as plants, and the export of the finger as one."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.fmu.plant import Fmu
    from plants.fmu.ports import FmuPort

__all__ = ["Fmu", "FmuPort"]

__getattr__ = found_in(__name__, {"Fmu": "plant", "FmuPort": "ports"})

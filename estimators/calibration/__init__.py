"""Calibration of sensors, joints, frames and clocks."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.calibration.block import SegmentCalibration

__all__ = ["SegmentCalibration"]

__getattr__ = found_in(__name__, {"SegmentCalibration": "block"})

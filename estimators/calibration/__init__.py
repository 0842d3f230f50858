"""From sensors' frames to segments' frames, and between frames and clocks of systems."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.calibration.block import SegmentCalibration

__all__ = ["SegmentCalibration"]

__getattr__ = found_in(__name__, {"SegmentCalibration": "block"})

"""Fusion of single inertial sensors, and trackers that chain their orientations."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from estimators.fusion.trackers import SeelRuppinTracker, Vqf9Tracker, VqfTracker

__all__ = ["SeelRuppinTracker", "Vqf9Tracker", "VqfTracker"]

__getattr__ = found_in(__name__, dict.fromkeys(__all__, "trackers"))

"""References for joint angles and fingertips."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.reference.cyclic import Cyclic
    from controllers.reference.fingertips import FingertipPath
    from controllers.reference.minimum_jerk import MinimumJerk
    from controllers.reference.phases import GraspPhases
    from controllers.reference.recorded import Recorded

__all__ = ["Cyclic", "FingertipPath", "GraspPhases", "MinimumJerk", "Recorded"]

__getattr__ = found_in(__name__, {"Cyclic": "cyclic", "FingertipPath": "fingertips", "GraspPhases": "phases",
                                  "MinimumJerk": "minimum_jerk", "Recorded": "recorded"})

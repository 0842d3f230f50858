"""References for joint angles and fingertips."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.reference.cyclic import Cyclic
    from controllers.reference.fingertips import FingertipPath
    from controllers.reference.minimum_jerk import MinimumJerk
    from controllers.reference.phases import GraspPhases
    from controllers.reference.proportional import ProportionalPosture
    from controllers.reference.recorded import Recorded
    from controllers.reference.triggered import TriggeredPhases

__all__ = ["Cyclic", "FingertipPath", "GraspPhases", "MinimumJerk", "ProportionalPosture", "Recorded",
           "TriggeredPhases"]

__getattr__ = found_in(__name__, {"Cyclic": "cyclic", "FingertipPath": "fingertips", "GraspPhases": "phases",
                                  "MinimumJerk": "minimum_jerk", "ProportionalPosture": "proportional",
                                  "Recorded": "recorded", "TriggeredPhases": "triggered"})

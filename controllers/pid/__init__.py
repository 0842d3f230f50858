"""PID control: gains by hand, or by a patient's model."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.pid.block import Pid
    from controllers.pid.tuned import TunedPid

__all__ = ["Pid", "TunedPid"]

__getattr__ = found_in(__name__, {"Pid": "block", "TunedPid": "tuned"})

"""A stimulated arm that a device holds at elbow, forearm and wrist, exact at any instant."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.arm.plant import Arm

__all__ = ["Arm"]

__getattr__ = found_in(__name__, {"Arm": "plant"})

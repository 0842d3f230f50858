"""Which segments a Kortier tracker follows: chains of sensors that share their bases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fesloop.errors import InputError

JointKind = Literal["hinge", "saddle", "ball"]
FORBIDDEN: dict[JointKind, int] = {"ball": 0, "saddle": 1, "hinge": 2}
"""Rotations that each kind of joint forbids: pronation, then abduction."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Segments one after the other, such as hand, proximal, middle and distal of a finger.

    Attributes
    ----------
    sensors: their numbers, from the base to the tip; the base may be in several chains.
    joints: between each and the next: hinge (flexes about z), saddle (abducts about x as well) or ball.
    initial_angles_deg: flexion of each joint at the start; empty: straight.
    """

    sensors: tuple[int, ...]
    joints: tuple[JointKind, ...]
    initial_angles_deg: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.sensors) < 2 or len(set(self.sensors)) < len(self.sensors) or min(self.sensors) < 0:
            raise InputError("chains.sensors", f"{self.sensors}", "two or more different sensors, from 0 on")
        if len(self.joints) != len(self.sensors) - 1 or not set(self.joints) <= FORBIDDEN.keys():
            raise InputError("chains.joints", f"{self.joints} for {len(self.sensors)} sensors",
                             f"{len(self.sensors) - 1} of {', '.join(FORBIDDEN)}")
        angles = self.initial_angles_deg
        if (angles and len(angles) != len(self.joints)) or not all(-180.0 <= a <= 180.0 for a in angles):
            raise InputError("chains.initial_angles_deg", f"{angles}",
                             f"{len(self.joints)} angles from -180 to 180 deg, or none")


_FINGER: tuple[JointKind, ...] = ("saddle", "hinge", "hinge")
HAND = (Chain(sensors=(0, 1, 2, 3), joints=("ball", "hinge", "hinge")),
        *(Chain(sensors=(0, k, k + 1, k + 2), joints=_FINGER) for k in (4, 7, 10, 13)))
"""Back of the hand (0), metacarpal, proximal, distal of the thumb, proximal, middle, distal of F2 to F5."""


def require_tree(chains: tuple[Chain, ...], sensors: int) -> None:
    """Raise InputError unless the chains form one tree of `sensors` sensors, bases before their chains."""
    placed = {chains[0].sensors[0]}
    for number, chain in enumerate(chains):
        where = f"chains[{number}].sensors"
        base, *rest = chain.sensors
        if base not in placed:
            raise InputError(where, f"base {base} is in no chain before", "one of " + _listed(placed))
        if max(chain.sensors) >= sensors:
            raise InputError(where, f"{max(chain.sensors)}", f"0 to {sensors - 1}, as wired in")
        if placed & set(rest):
            raise InputError(where, f"{_listed(placed & set(rest))} given twice",
                             "each sensor once, bases aside")
        placed |= set(rest)
    if len(placed) < sensors:
        left = _listed(set(range(sensors)) - placed)
        raise InputError("chains", f"{left} of {sensors} sensors in no chain", "every sensor in one",
                         "select the sensors, or give their chains")


def _listed(numbers: set[int]) -> str:
    return ", ".join(str(number) for number in sorted(numbers))

"""What the hand meets: an object to grasp, and a table that can be lowered away from under it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from plants.checks import require_not_negative, require_positive
from plants.hand_bodies import OBJECT, SKIN_SOLIMP, SKIN_SOLREF, TABLE, TOUCHES

Shape = Literal["cylinder", "block", "ball", "card"]
SIZES: dict[Shape, tuple[str, ...]] = {
    "cylinder": ("diameter", "height"), "block": ("x", "y", "z"), "ball": ("diameter",),
    "card": ("width", "length", "thickness")}
"""What `size_mm` lists of each shape."""
_GEOMS = {"cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER, "block": mujoco.mjtGeom.mjGEOM_BOX,
          "ball": mujoco.mjtGeom.mjGEOM_SPHERE, "card": mujoco.mjtGeom.mjGEOM_BOX}
TORSIONAL_M, ROLLING_M = 0.005, 0.0001
"""Friction against twisting and rolling over that against sliding, m: chosen, a fingertip's patch of contact
is some 5 mm wide; MuJoCo's default for rolling."""
HARD_SOLREF = [0.005, 1.0]
"""Of object and table: back from each other within 5 ms, critically damped (chosen: five steps of 1 ms)."""
OVERLAP_M = 0.001
"""Chosen: object, skin and table may be pressed this far into each other at the start."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspObject:
    """A rigid object that lies, stands or floats free at the start.

    Attributes
    ----------
    shape: of it. size_mm: as `SIZES` lists it: cylinder (diameter, height), along its z; block (x, y, z);
        ball (diameter,); card (width, length, thickness), along its x, y, z.
    mass_kg: spread evenly.
    friction: coefficient against skin and table (skin on plastics .5 to 1; chosen).
    position_m: of its centre from the wrist's, global (ENU).
    orientation: (w, x, y, z), of its axes to the global ones.
    """

    shape: Shape = "cylinder"
    size_mm: tuple[float, ...] = (60.0, 120.0)
    mass_kg: float = 0.2
    friction: float = 0.8
    position_m: tuple[float, float, float] = (0.0, 0.1, -0.06)
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.shape not in SIZES:
            raise InputError("object.shape", f"{self.shape!r}", ", ".join(SIZES))
        if len(self.size_mm) != len(SIZES[self.shape]):
            raise InputError("object.size_mm", f"{self.size_mm}", f"{', '.join(SIZES[self.shape])}, mm")
        require_positive("object", self, "size_mm", "mass_kg")
        require_not_negative("object", self, "friction")
        if not np.isfinite(self.position_m).all():
            raise InputError("object.position_m", f"{self.position_m}", "three finite numbers, m")
        if not abs(math.hypot(*self.orientation) - 1.0) <= 1e-6:
            raise InputError("object.orientation", f"{self.orientation}",
                             "a quaternion (w, x, y, z) of length 1")

    @property
    def half_sizes(self) -> list[float]:
        """As MuJoCo wants them, m."""
        sizes = [5e-4 * each for each in self.size_mm]
        return sizes + [0.0] * (3 - len(sizes))


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A level table top, 10 mm thick.

    Attributes
    ----------
    height_m: of its surface over the wrist's centre, negative below.
    centre_m: of the top from the wrist's centre, east and north. half_m: half its sides.
    friction: coefficient against skin; against an object that of the object counts.
    lowered_at_s: when it starts to sink; negative: never. lowering_m: how far, lowering_m_s: how fast.
    """

    height_m: float = -0.1
    centre_m: tuple[float, float] = (0.0, 0.1)
    half_m: tuple[float, float] = (0.3, 0.3)
    friction: float = 0.5
    lowered_at_s: float = -1.0
    lowering_m: float = 0.2
    lowering_m_s: float = 0.1

    def __post_init__(self) -> None:
        require_positive("table", self, "half_m", "lowering_m", "lowering_m_s")
        require_not_negative("table", self, "friction")
        if not np.isfinite((self.height_m, *self.centre_m, self.lowered_at_s)).all():
            raise InputError("table", "a place or time that is not finite", "finite numbers")

    def drop(self, time_ns: int) -> float:
        """How far it has sunk, m."""
        since = time_ns / NS_PER_S - self.lowered_at_s
        if self.lowered_at_s < 0.0 or since <= 0.0:
            return 0.0
        return min(self.lowering_m, since * self.lowering_m_s)


def add_object(spec: mujoco.MjSpec, thing: GraspObject) -> None:
    """Add the object, its body and geom named `object`, behind all that is there."""
    body = spec.worldbody.add_body(name="object", pos=thing.position_m, quat=thing.orientation)
    body.add_freejoint(name="object")
    # condim 4: a contact also resists twisting.
    body.add_geom(name="object", type=_GEOMS[thing.shape], size=thing.half_sizes, mass=thing.mass_kg,
                  condim=4, priority=1, friction=[thing.friction, thing.friction * TORSIONAL_M, ROLLING_M],
                  solref=SKIN_SOLREF, solimp=SKIN_SOLIMP, contype=OBJECT, conaffinity=TOUCHES[OBJECT])


def add_table(spec: mujoco.MjSpec, table: Table) -> None:
    """Add the table, moved by `mocap_pos` alone, behind the object, if there is one."""
    body = spec.worldbody.add_body(name="table", mocap=True, pos=[*table.centre_m, table.height_m - 0.005])
    body.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[*table.half_m, 0.005],
                  friction=[table.friction, TORSIONAL_M * table.friction, ROLLING_M], contype=TABLE,
                  conaffinity=TOUCHES[TABLE])
    thing = spec.geom("object")
    if thing is not None:
        # Between the two there is no skin.
        slide, twist, roll = thing.friction
        spec.add_pair(geomname1="object", geomname2="table", condim=4, solref=HARD_SOLREF,
                      friction=[slide, slide, twist, roll, roll])


def require_apart(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise InputError for an object that is inside the hand or the table, or a table inside the hand."""
    mujoco.mj_forward(model, data)
    for contact in sorted(data.contact, key=lambda each: float(each.dist)):
        names = [model.geom(geom).name for geom in contact.geom]
        if contact.dist < -OVERLAP_M and not {"object", "table"}.isdisjoint(names):
            thing = "object" if "object" in names else "table"
            other, depth_mm = names[1 - names.index(thing)], -1e3 * contact.dist
            raise InputError(f"hand.{thing}", f"reaches {depth_mm:.1f} mm into {other} at the start",
                             f"{1e3 * OVERLAP_M:g} mm at most", "move it, or the hand")

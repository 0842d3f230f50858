"""Surroundings of a hand: a rigid object to grasp and a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.loop.clock import NS_PER_S
from plants.hand.model import OBJECT, SKIN_SOLIMP, SKIN_SOLREF, TABLE, TOUCHES

Array = NDArray[np.float64]
Shape = Literal["cylinder", "block", "ball", "card", "mug"]
SIZES: dict[Shape, tuple[str, ...]] = {
    "cylinder": ("diameter", "height"), "block": ("x", "y", "z"), "ball": ("diameter",),
    "card": ("width", "length", "thickness"), "mug": ("diameter", "height", "wall", "handle")}
"""Meaning of `size_mm` by shape."""
_GEOMS = {"cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER, "block": mujoco.mjtGeom.mjGEOM_BOX,
          "ball": mujoco.mjtGeom.mjGEOM_SPHERE, "card": mujoco.mjtGeom.mjGEOM_BOX}
TORSIONAL_M, ROLLING_M = 0.005, 0.0001
"""Ratio of torsional and of rolling to sliding friction, m: chosen, as a fingertip's contact patch is some
5 mm wide; MuJoCo's default for rolling."""
HARD_SOLREF = [0.005, 1.0]
"""Contact of object and table: apart again within 5 ms, critically damped (chosen: five steps of 1 ms)."""
_BODY = mujoco.mjtObj.mjOBJ_BODY
LEAST_WALL_MM = 2.0
"""Least thickness of a mug's wall (chosen: skin under 20 N lies 1 mm deep in what it touches)."""
OVERLAP_M = 0.001
"""Chosen: greatest penetration of object, skin and table at the start."""


def _offsets(step_m: float, reach_m: float) -> Array:
    """Grid of horizontal offsets within a reach, (n, 3), m, nearest first."""
    side = np.arange(-reach_m, reach_m + 0.5 * step_m, step_m)
    grid = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((side.size, side.size))], axis=-1)
    places = grid.reshape(-1, 3)
    far = np.linalg.norm(places, axis=1)
    near = places[np.argsort(far, kind="stable")]
    return np.asarray(near[np.sort(far) <= reach_m + 1e-9])


_OFFSETS = _offsets(0.004, 0.02)
"""Offsets at which an object is tried when it is given (chosen: steps of 4 mm, up to 2 cm)."""


_SURELY_M = 2.0 * OVERLAP_M
"""Overlap of two geoms by `mj_geomDistance` that is more than `OVERLAP_M` by `mj_collision` (which differ by
0.01 mm in 28 mm of a cylinder and a capsule)."""


class Contact(NamedTuple):
    """A contact: its distance, m, negative when penetrating, and the names of both geoms."""

    distance_m: float
    geoms: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspObject:
    """A free rigid object; without support it falls to the table, or to a floor 100 m below the wrist.

    Attributes
    ----------
    shape: its shape. size_mm: by shape: cylinder (diameter, height), along its z; block (x, y, z);
        ball (diameter,); card (width, length, thickness), along its x, y, z; mug (outer diameter, height,
        thickness of wall and floor, how far the handle reaches beyond the wall), along its z with the handle
        along its x (`fesloop.hand.mug`).
    mass_kg: mass, of uniform density.
    friction: coefficient against skin and table (skin on plastics .5 to 1; chosen).
    friction_stiffness: ratio of the stiffness of friction to that of normal force (MuJoCo's `impratio`). What
        friction holds creeps, at a speed inversely proportional to it, until it slides out of the hand
        (chosen: in 14 s a cylinder of .2 kg that is held with twice the least force moves by 37 mm with 10,
        11 with 40, 6.4 with 100, and 4.4 with 400).
    position_m: position of its centre from the wrist's centre, global (ENU).
    orientation: (w, x, y, z), from its axes to the global ones.
    given_at_s: instant at which it is put to `position_m`; before, it is held at the offset `waits_m`. If the
        hand is in the way, it is put to the nearest free place at the same height, at most 2 cm off, as soon
        as there is one, and the table under it.
    waits_m: offset of its waiting place from `position_m` (chosen: in front of the fingers, out of reach).
    """

    shape: Shape = "cylinder"
    size_mm: tuple[float, ...] = (60.0, 120.0)
    mass_kg: float = 0.2
    friction: float = 0.8
    friction_stiffness: float = 100.0
    position_m: tuple[float, float, float] = (0.0, 0.1, -0.06)
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    given_at_s: float = 0.0
    waits_m: tuple[float, float, float] = (0.0, 0.25, 0.0)

    def __post_init__(self) -> None:
        if self.shape not in SIZES:
            raise InputError("object.shape", f"{self.shape!r}", ", ".join(SIZES))
        if len(self.size_mm) != len(SIZES[self.shape]):
            raise InputError("object.size_mm", f"{self.size_mm}", f"{', '.join(SIZES[self.shape])}, mm")
        require_positive("object", self, "size_mm", "mass_kg", "friction_stiffness")
        require_not_negative("object", self, "friction", "given_at_s")
        if self.shape == "mug":
            self._require_a_mug()
        for key in ("position_m", "waits_m"):
            if not np.isfinite(getattr(self, key)).all():
                raise InputError(f"object.{key}", f"{getattr(self, key)}", "three finite numbers, m")
        if not abs(math.hypot(*self.orientation) - 1.0) <= 1e-6:
            raise InputError("object.orientation", f"{self.orientation}",
                             "a quaternion (w, x, y, z) of length 1")

    def _require_a_mug(self) -> None:
        diameter, height, wall, _ = self.size_mm
        most_mm = 0.5 * min(diameter, height)
        if not LEAST_WALL_MM <= wall <= most_mm:
            raise InputError("object.size_mm", f"a wall of {wall:g} mm",
                             f"{LEAST_WALL_MM:g} to {most_mm:g} mm",
                             "make it thicker, as skin presses through, or thinner, so that it is hollow")

    @property
    def start_m(self) -> list[float]:
        """Position at the start, m."""
        off = self.waits_m if self.given_at_s > 0.0 else (0.0, 0.0, 0.0)
        return [at + by for at, by in zip(self.position_m, off, strict=True)]

    @property
    def half_sizes(self) -> list[float]:
        """Half sizes for MuJoCo's geom, m."""
        sizes = [5e-4 * each for each in self.size_mm]
        return sizes + [0.0] * (3 - len(sizes))


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A level table top, 10 mm thick.

    Attributes
    ----------
    height_m: height of its surface above the wrist's centre, negative below.
    centre_m: centre of the top from the wrist's centre, east and north. half_m: half its sides.
    friction: coefficient against skin; against an object, the object's applies.
    raised_at_s: instant at which it starts to rise to its height, out of the way before; negative: it is
        there from the start. lowered_at_s: instant at which it starts to sink; negative: never.
    lowering_m, lowering_m_s: distance and speed of both.
    """

    height_m: float = -0.1
    centre_m: tuple[float, float] = (0.0, 0.1)
    half_m: tuple[float, float] = (0.3, 0.3)
    friction: float = 0.5
    raised_at_s: float = -1.0
    lowered_at_s: float = -1.0
    lowering_m: float = 0.2
    lowering_m_s: float = 0.1

    def __post_init__(self) -> None:
        require_positive("table", self, "half_m", "lowering_m", "lowering_m_s")
        require_not_negative("table", self, "friction")
        if not np.isfinite((self.height_m, *self.centre_m, self.raised_at_s, self.lowered_at_s)).all():
            raise InputError("table", "a place or time that is not finite", "finite numbers")

    def drop(self, time_ns: int) -> float:
        """Distance below its height at an instant, m."""
        time_s, below = time_ns / NS_PER_S, 0.0
        if self.raised_at_s >= 0.0:
            below = self.lowering_m - self._moved(time_s - self.raised_at_s)
        if self.lowered_at_s >= 0.0:
            below = max(below, self._moved(time_s - self.lowered_at_s))
        return below

    def _moved(self, since_s: float) -> float:
        """Distance of a motion that began this long ago, m."""
        return min(self.lowering_m, max(0.0, since_s) * self.lowering_m_s)


def add_object(spec: mujoco.MjSpec, thing: GraspObject) -> None:
    """Add the object as the last body, and its stiffness of friction.

    Body and geom are named `object`; further geoms of a mug have names that begin so.
    """
    spec.option.impratio = thing.friction_stiffness
    body = spec.worldbody.add_body(name="object", pos=thing.start_m, quat=thing.orientation)
    body.add_freejoint(name="object")
    # condim 4: a contact also resists twisting.
    surface = {"condim": 4, "priority": 1, "solref": SKIN_SOLREF, "solimp": SKIN_SOLIMP, "contype": OBJECT,
               "friction": [thing.friction, thing.friction * TORSIONAL_M, ROLLING_M],
               "conaffinity": TOUCHES[OBJECT]}
    if thing.shape == "cylinder":
        from plants.hand import side_contact  # a while to load, for hands that grasp one

        side_contact.install()
        surface["userdata"] = [side_contact.MARK]
    if thing.shape == "mug":
        _add_mug(body, thing, surface)
    else:
        body.add_geom(name="object", type=_GEOMS[thing.shape], size=thing.half_sizes, mass=thing.mass_kg,
                      **surface)


def _add_mug(body: Any, thing: GraspObject, surface: dict[str, Any]) -> None:
    """Add the parts of a mug, the floor first, and the inertia of the round mug."""
    from fesloop.hand.mug import Mug, inertia_of, parts_of

    mug = Mug.of(thing.size_mm)
    kinds = {"box": mujoco.mjtGeom.mjGEOM_BOX, "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
             "rod": mujoco.mjtGeom.mjGEOM_CAPSULE}
    for number, part in enumerate(parts_of(mug)):
        body.add_geom(name=f"object {number}" if number else "object", type=kinds[part.kind], size=part.half,
                      pos=part.centre, quat=part.orientation, **surface)
    body.mass, (body.ipos, inertia) = thing.mass_kg, inertia_of(mug, thing.mass_kg)
    body.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    body.explicitinertial = True


def add_table(spec: mujoco.MjSpec, table: Table) -> None:
    """Add the table, which only `mocap_pos` moves, after the object, if any."""
    below = 0.005 + table.drop(0)
    body = spec.worldbody.add_body(name="table", mocap=True, pos=[*table.centre_m, table.height_m - below])
    body.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[*table.half_m, 0.005],
                  friction=[table.friction, TORSIONAL_M * table.friction, ROLLING_M], contype=TABLE,
                  conaffinity=TOUCHES[TABLE])
    thing = spec.body("object")
    for geom in thing.geoms if thing is not None else ():
        # No skin is between the two.
        slide, twist, roll = geom.friction
        spec.add_pair(geomname1=geom.name, geomname2="table", condim=4, solref=HARD_SOLREF,
                      friction=[slide, slide, twist, roll, roll])


def deepest(model: mujoco.MjModel, data: mujoco.MjData, names: Sequence[str]) -> Contact:
    """Deepest contact of the geoms of named bodies; of infinite distance if they touch nothing."""
    bodies = [mujoco.mj_name2id(model, _BODY, name) for name in names]
    known = set(np.flatnonzero(np.isin(model.geom_bodyid, bodies)).tolist())
    theirs = [contact for contact in zip(data.contact.dist.tolist(), data.contact.geom.tolist(), strict=True)
              if not known.isdisjoint(contact[1])]
    if not theirs:
        return Contact(math.inf, ())
    distance, geoms = min(theirs, key=itemgetter(0))
    return Contact(distance, tuple(model.geom(geom).name for geom in geoms))


def give(model: mujoco.MjModel, thing: GraspObject, data: mujoco.MjData) -> bool:
    """Put the object, MuJoCo's last joint, to where it is to be grasped; False if the hand leaves no room.

    The table, if any, is put under it: an object beside a small table would fall at once.
    """
    before = data.qpos[-7:].copy(), data.qvel[-6:].copy(), data.mocap_pos.copy()
    data.qvel[-6:] = 0.0
    tables = [model.body("table").mocapid[0]] if mujoco.mj_name2id(model, _BODY, "table") >= 0 else []
    in_the_way: tuple[int, ...] = ()
    for offset in _OFFSETS:
        data.qpos[-7:] = (*(np.array(thing.position_m) + offset), *thing.orientation)
        data.mocap_pos[tables] = before[2][tables] + offset
        mujoco.mj_kinematics(model, data)
        if in_the_way and mujoco.mj_geomDistance(model, data, *in_the_way, 0.0, None) < -_SURELY_M:
            continue  # what kept the object from the last place most often does from the next one
        mujoco.mj_collision(model, data)
        contact = deepest(model, data, ("object", "table"))
        if contact.distance_m >= -OVERLAP_M:
            return True
        in_the_way = tuple(model.geom(name).id for name in contact.geoms)
    data.qpos[-7:], data.qvel[-6:], data.mocap_pos[:] = before
    return False


def require_apart(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise InputError if the object is inside the hand or the table, or the table inside the hand."""
    mujoco.mj_forward(model, data)
    contact = deepest(model, data, ("object", "table"))
    if contact.distance_m < -OVERLAP_M:
        things = [geom.split()[0] for geom in contact.geoms]
        thing = "object" if "object" in things else "table"
        other = contact.geoms[1 - things.index(thing)]
        raise InputError(f"hand.{thing}", f"reaches {-1e3 * contact.distance_m:.1f} mm into {other} at the "
                         "start", f"{1e3 * OVERLAP_M:g} mm at most", "move it, or the hand")

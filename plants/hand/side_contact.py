"""Contact of bones, which are capsules, with the side of a cylinder: a bracket in place of a search in space.

MuJoCo finds the closest points of a capsule and a cylinder as those of any two convex bodies (GJK; Gilbert,
Johnson and Keerthi 1988, doi 10.1109/56.2083), which takes a third of a grasp's time. The distance of a
point from a convex body is a convex function of the point (Boyd and Vandenberghe 2004, section 3.2.5), so its
least value along the capsule's axis lies where its slope changes sign. The contact is MuJoCo's, within the
tolerance of its search.

The function stands in MuJoCo's table of such functions (`mjCOLLISIONFUNC`), which the process shares. It
passes on, to the one that stood there before, all but the sides of cylinders whose geoms have `MARK` as user
data: other models, and the ends of these cylinders, collide as without it.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import mujoco
from llvmlite import ir
from llvmlite.binding import add_symbol
from numba import types
from numba.extending import intrinsic, register_jitable

from fesloop.compiled import compiled_callback
from plants.hand.model import mujoco_library

Vector = tuple[float, float, float]
MARK = 8.70225e5
"""User data of a cylinder whose side is handled here (chosen: a number that nobody else has there)."""
_KINDS = int(mujoco.mjtGeom.mjNGEOMTYPES)
_PLACE = int(mujoco.mjtGeom.mjGEOM_CAPSULE) * _KINDS + int(mujoco.mjtGeom.mjGEOM_CYLINDER)
"""Place of the pair in the table."""
_UNIQUE = 4711
"""Number of user data of a geom, which no other size of a small model is."""
_HALVINGS = 50
"""Most times that a bracket is halved: it is then shorter than rounding."""
_ENOUGH_M = 1e-15
"""How much less than what is found the least distance may be (chosen: the place is then within some nm)."""


def _offset_of(wanted: int, kind: Any, struct: int) -> int:
    """Offset of a number in one of MuJoCo's structs, whose members differ between its versions."""
    offset = 0
    while kind.from_address(struct + offset).value != wanted:
        offset += ctypes.sizeof(kind)
    return offset


def _layout() -> tuple[int, ...]:
    """Offsets of nuser_geom, geom_size and geom_user in a model, and of geom_xpos and geom_xmat in data.

    An array without content has the address of the next one, so the model has what comes before these.
    """
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1.0, 0.0, 0.0], userdata=[0.0] * _UNIQUE)
    model = spec.compile()
    data = mujoco.MjData(model)
    arrays = ((model, "geom_size"), (model, "geom_user"), (data, "geom_xpos"), (data, "geom_xmat"))
    return (_offset_of(_UNIQUE, ctypes.c_int32, model._address),
            *(_offset_of(getattr(owner, name).ctypes.data, ctypes.c_uint64, owner._address)
              for owner, name in arrays))


_N_USER, _SIZES, _USER, _POSITIONS, _TURNS = compiled_for = _layout()


_pointer: Any = types.CPointer


def _to_numbers(typing: Any, address: Any) -> Any:
    """The numbers at an address."""
    def codegen(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.inttoptr(given[0], ir.DoubleType().as_pointer())
    return _pointer(types.float64)(types.intp), codegen


def _to_integers(typing: Any, address: Any) -> Any:
    """The integers of the size of an address that are at an address."""
    def codegen(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.inttoptr(given[0], ir.IntType(8 * ctypes.sizeof(ctypes.c_void_p)).as_pointer())
    return _pointer(types.intp)(types.intp), codegen


_numbers: Any = intrinsic(_to_numbers)
_integers: Any = intrinsic(_to_integers)


@register_jitable
def _side(along: float, foot: Vector, axis: Vector, radius: float, half: float) -> tuple[float, float]:
    """Distance of the point `along` an axis through `foot` from a cylinder, negative inside; its slope."""
    x, y, z = foot[0] + along * axis[0], foot[1] + along * axis[1], foot[2] + along * axis[2]
    out = math.hypot(x, y)
    rise = (x * axis[0] + y * axis[1]) / out if out > 0.0 else math.hypot(axis[0], axis[1])
    beside, beyond = out - radius, abs(z) - half
    climb = axis[2] if z >= 0.0 else -axis[2]
    if beyond <= 0.0 and (beside > 0.0 or beside > beyond):
        return beside, rise
    if beside <= 0.0:
        return beyond, climb
    far = math.hypot(beside, beyond)
    return far, (beside * rise + beyond * climb) / far


@register_jitable
def _nearest(foot: Vector, axis: Vector, length: float, radius: float, half: float, reach: float) -> float:
    """Place along an axis, from -length to length, nearest to a cylinder; NaN if that is beyond reach.

    Tangents at both ends of a bracket meet below the least distance, and mostly near its place.
    """
    low, high = -length, length
    low_far, low_slope = _side(low, foot, axis, radius, half)
    high_far, high_slope = _side(high, foot, axis, radius, half)
    if low_slope >= 0.0:
        return low if low_far <= reach else math.nan
    if high_slope <= 0.0:
        return high if high_far <= reach else math.nan
    along = 0.0
    for turn in range(2 * _HALVINGS):
        meet = (high_far - low_far + low_slope * low - high_slope * high) / (low_slope - high_slope)
        least = low_far + low_slope * (meet - low)
        if least > reach:
            return math.nan
        along = meet if turn % 2 == 0 and low < meet < high else 0.5 * (low + high)
        far, slope = _side(along, foot, axis, radius, half)
        if far - least <= _ENOUGH_M:
            return along if far <= reach else math.nan
        if slope > 0.0:
            high, high_far, high_slope = along, far, slope
        else:
            low, low_far, low_slope = along, far, slope
    return along


_signature: Any = types.int32(types.intp, types.intp, types.intp, types.int32, types.int32, types.float64)
_table: Any = (ctypes.c_void_p * (_KINDS * _KINDS)).in_dll(
    ctypes.CDLL(str(mujoco_library())), "mjCOLLISIONFUNC")
_BEFORE = "fesloop_capsule_on_cylinder_before"
add_symbol(_BEFORE, _table[_PLACE])
_before: Any = types.ExternalFunction(_BEFORE, _signature)


@compiled_callback(_signature)
def collide(model: int, data: int, contact: int, capsule: int, cylinder: int, margin: float) -> Any:
    """Number of contacts of two geoms closer than `margin`, m; written to `contact`, an `mjPreContact`.

    `model`, `data` and `contact` are addresses. The normal points from the capsule to the cylinder, and the
    place is midway between both surfaces.
    """
    count = _integers(model + _N_USER)[0] & 0xFFFFFFFF
    if count == 0 or _numbers(_integers(model + _USER)[0])[cylinder * count] != MARK:
        return _before(model, data, contact, capsule, cylinder, margin)
    sizes = _numbers(_integers(model + _SIZES)[0])
    places, turns = _numbers(_integers(data + _POSITIONS)[0]), _numbers(_integers(data + _TURNS)[0])
    bone, thing = 9 * capsule, 9 * cylinder
    x, y, z = (places[3 * capsule] - places[3 * cylinder], places[3 * capsule + 1] - places[3 * cylinder + 1],
               places[3 * capsule + 2] - places[3 * cylinder + 2])
    u, v, w = turns[bone + 2], turns[bone + 5], turns[bone + 8]
    foot = (turns[thing] * x + turns[thing + 3] * y + turns[thing + 6] * z,
            turns[thing + 1] * x + turns[thing + 4] * y + turns[thing + 7] * z,
            turns[thing + 2] * x + turns[thing + 5] * y + turns[thing + 8] * z)
    axis = (turns[thing] * u + turns[thing + 3] * v + turns[thing + 6] * w,
            turns[thing + 1] * u + turns[thing + 4] * v + turns[thing + 7] * w,
            turns[thing + 2] * u + turns[thing + 5] * v + turns[thing + 8] * w)
    skin, radius, half = sizes[3 * capsule], sizes[3 * cylinder], sizes[3 * cylinder + 1]
    along = _nearest(foot, axis, sizes[3 * capsule + 1], radius, half, skin + margin)
    if math.isnan(along):
        return 0
    east, north = foot[0] + along * axis[0], foot[1] + along * axis[1]
    height, out = foot[2] + along * axis[2], math.hypot(east, north)
    if abs(height) > half or out <= radius:
        return _before(model, data, contact, capsule, cylinder, margin)
    east, north, distance = east / out, north / out, out - radius - skin
    middle = out - skin - 0.5 * distance
    told = _numbers(contact)
    told[0] = distance
    for k in range(3):
        outward = turns[thing + 3 * k] * east + turns[thing + 3 * k + 1] * north
        told[1 + k] = places[3 * cylinder + k] + middle * outward + height * turns[thing + 3 * k + 2]
        told[4 + k] = -outward
        told[7 + k] = 0.0  # a tangent that is 0 is chosen by MuJoCo
    return 1


def install() -> None:
    """Have MuJoCo, in this process, find such contacts with `collide`."""
    _table[_PLACE] = collide.address

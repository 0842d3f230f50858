"""The magnetic field that hand-worn sensors meet: the Earth's, and that of magnets and iron nearby.

Global frame ENU; its y axis points to magnetic north unless a declination is given. Kernels take sources as
rows (7,): position (3,), m, moment (3,), A m^2, radius, m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.kinematics_kernels import turned
from plants.checks import require_not_negative, require_positive, require_shape

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
_MU_0_OVER_4_PI = 1e-7
"""T m/A: mu_0 / (4 pi), exact to 6e-10 (CODATA 2018)."""


@compiled
def add_sources(sources: Array, points: Array, field: Array) -> None:
    """Add to `field` (n, 3), T, at `points` (n, 3) what `sources` (k, 7) give there."""
    for source in sources:
        mx, my, mz, radius = source[3], source[4], source[5], source[6]
        for i in range(points.shape[0]):
            x, y, z = points[i, 0] - source[0], points[i, 1] - source[1], points[i, 2] - source[2]
            square = x * x + y * y + z * z
            # Inside a uniformly magnetised sphere the field is 2/3 mu_0 M, everywhere alike.
            along, across = 0.0, -2.0 / (radius * radius * radius)
            if square >= radius * radius:
                across = 1.0 / (square * math.sqrt(square))
                along = 3.0 * across / square * (mx * x + my * y + mz * z)
            field[i, 0] += _MU_0_OVER_4_PI * (along * x - across * mx)
            field[i, 1] += _MU_0_OVER_4_PI * (along * y - across * my)
            field[i, 2] += _MU_0_OVER_4_PI * (along * z - across * mz)


@compiled
def place_carried(
    carried: Array, carriers: NDArray[np.int64], orientation: Array, position: Array, sources: Array
) -> None:
    """Fill `sources` (c, 7) with sources (c, 7) fixed in the frames of the sites that `carriers` (c,) number.

    `orientation` (s, 4) and `position` (s, 3), m: from each site's frame to the global one.
    """
    for i in range(carriers.size):
        site = carriers[i]
        q = (orientation[site, 0], orientation[site, 1], orientation[site, 2], orientation[site, 3])
        x, y, z = turned(q, carried[i, 0], carried[i, 1], carried[i, 2])
        sources[i, 0] = position[site, 0] + x
        sources[i, 1] = position[site, 1] + y
        sources[i, 2] = position[site, 2] + z
        sources[i, 3], sources[i, 4], sources[i, 5] = turned(q, carried[i, 3], carried[i, 4], carried[i, 5])
        sources[i, 6] = carried[i, 6]


@dataclass(frozen=True, slots=True, kw_only=True)
class Dipole:
    """A magnet, or iron magnetised for good, as a sphere: outside it, the field is that of a dipole.

        B(r) = mu_0 / (4 pi r^3) (3 (m . e) e - m),   e = r / |r|        (Griffiths, eq. 5.89)

    Attributes
    ----------
    position: of the centre, m: in the global frame, or in that of the site that carries it.
    moment: A m^2, in the same frame (a neodymium cube of 10 mm has about 1).
    radius_m: of the sphere, inside which the field is uniform.
    carrier: name of the site that it moves with; empty: fixed in the room.
    """

    position: Vector
    moment: Vector
    radius_m: float = 0.005
    carrier: str = ""

    def __post_init__(self) -> None:
        require_shape("dipole", self, (3,), "x, y, z", "position", "moment")
        require_positive("dipole", self, "radius_m")

    @property
    def row(self) -> Array:
        """As the kernels take it, (7,)."""
        return np.array([*self.position, *self.moment, self.radius_m])


@dataclass(frozen=True, slots=True, kw_only=True)
class MagneticField:
    """The Earth's field, homogeneous, and that of dipoles in the room and on the hand.

    Attributes
    ----------
    strength_ut, inclination_deg: of the Earth's field, uT, and downwards from the horizontal (Berlin in
        2019, rounded from the IGRF-13 model, doi 10.1186/s40623-020-01288-x).
    declination_deg: of its horizontal part from the global y axis towards east; 0: y is magnetic north, as
        trackers take it (from true north it is about 4 in Berlin).
    dipoles: fixed in the room or carried.
    """

    strength_ut: float = 49.7
    inclination_deg: float = 67.9
    declination_deg: float = 0.0
    dipoles: tuple[Dipole, ...] = ()

    def __post_init__(self) -> None:
        require_not_negative("magnetic_field", self, "strength_ut")
        for key, most in (("inclination_deg", 90.0), ("declination_deg", 180.0)):
            value = getattr(self, key)
            if not abs(value) <= most:
                raise InputError(f"magnetic_field.{key}", f"{value}", f"from -{most:g} to {most:g}")

    @property
    def earth(self) -> Array:
        """The Earth's field, (3,), T, global (east, north, up)."""
        down, east = math.radians(self.inclination_deg), math.radians(self.declination_deg)
        level = math.cos(down)
        return 1e-6 * self.strength_ut * np.array(
            [level * math.sin(east), level * math.cos(east), -math.sin(down)])

    @property
    def fixed(self) -> Array:
        """Rows (k, 7) of the dipoles fixed in the room."""
        return _rows([dipole for dipole in self.dipoles if not dipole.carrier])

    @property
    def carried(self) -> Array:
        """Rows (c, 7) of the carried dipoles, each in its carrier's frame."""
        return _rows([dipole for dipole in self.dipoles if dipole.carrier])

    @property
    def carriers(self) -> tuple[str, ...]:
        """Names of the sites that carry them, (c,)."""
        return tuple(dipole.carrier for dipole in self.dipoles if dipole.carrier)

    def in_room(self, points: ArrayLike) -> Array:
        """Field (..., 3), T, at points (..., 3), m, of everything that is not carried; all global."""
        where = np.asarray(points, dtype=np.float64)
        field = np.broadcast_to(self.earth, where.shape).copy()
        add_sources(self.fixed, np.ascontiguousarray(where).reshape(-1, 3), field.reshape(-1, 3))
        return field


def _rows(dipoles: list[Dipole]) -> Array:
    return np.array([dipole.row for dipole in dipoles]).reshape(-1, 7)

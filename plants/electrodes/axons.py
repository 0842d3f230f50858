"""Axons of the muscles of a cylindrical forearm, around their motor points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive, require_shape
from fesloop.hand.movements import EXTRINSIC, muscle
from fesloop.loop.noise import NoiseStream, stream_key

Array = NDArray[np.float64]


AROUND, ALONG, DEPTH, THRESHOLD, TURN = range(5)
"""Columns of axons: around the forearm, along it, depth, mm, threshold, mA, and movement around, mm, per rad
of forearm rotation. Places of elements have the first two, and SIZE."""
SIZE = 2
MOST_AXONS = 50_000
"""Most axons of a muscle (chosen: the field of 59 elements at those of all muscles then takes .6 GB)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorPoint:
    """Point at which the nerve enters a muscle.

    Attributes
    ----------
    muscle: a muscle of the forearm (`fesloop.hand.movements.EXTRINSIC`).
    around_deg: angle from the dorsal mid-line towards the radial side, in neutral forearm rotation.
    along_mm: distance from the elbow.
    depth_mm: depth under the skin.
    """

    muscle: str
    around_deg: float
    along_mm: float
    depth_mm: float

    def __post_init__(self) -> None:
        where = f"motor_point {self.muscle}"
        if muscle(self.muscle) >= len(EXTRINSIC):
            raise InputError(where, "is a muscle of the hand, out of reach of arrays on the forearm",
                             ", ".join(EXTRINSIC))
        require_shape(where, self, (), "a number", "around_deg")
        require_positive(where, self, "along_mm", "depth_mm")


_PLACES = {
    "ECRL": (55.0, 55.0, 9.0), "ECRB": (38.0, 80.0, 10.0), "EDC2": (14.0, 105.0, 9.0),
    "EDC3": (8.0, 90.0, 9.0), "EDC4": (-2.0, 85.0, 9.0), "EDC5": (-12.0, 95.0, 9.0),
    "EDM": (-24.0, 95.0, 9.0), "ECU": (-45.0, 85.0, 9.0), "EIP": (-8.0, 160.0, 14.0),
    "EPL": (6.0, 150.0, 13.0), "APL": (30.0, 150.0, 12.0),
    # (chosen: EPB arises distal to APL, along its ulnar border)
    "EPB": (24.0, 165.0, 12.0),
    "FCR": (150.0, 75.0, 9.0), "PL": (175.0, 80.0, 8.0), "FCU": (-130.0, 80.0, 9.0),
    "FDS2": (168.0, 145.0, 13.0), "FDS3": (165.0, 95.0, 12.0), "FDS4": (-172.0, 95.0, 12.0),
    "FDS5": (-160.0, 145.0, 13.0), "FDP2": (-176.0, 115.0, 18.0), "FDP3": (-168.0, 110.0, 18.0),
    "FDP4": (-152.0, 105.0, 16.0), "FDP5": (-142.0, 105.0, 15.0), "FPL": (152.0, 145.0, 17.0)}
MOTOR_POINTS = tuple(MotorPoint(muscle=name, around_deg=around, along_mm=along, depth_mm=depth)
                     for name, (around, along, depth) in _PLACES.items())
"""Motor points of all muscles of the forearm (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorBranch:
    """Axons of a muscle that lie close together at its motor point, where the nerve enters it.

    They are excited first, all within a small range of current: the steep recruitment of a small force that
    five people show at comfortable currents (docs/models/people.md), before the rest of the muscle responds.
    Share and threshold are chosen such that people's torques are met; spread: fitted to their courses.

    Attributes
    ----------
    share: of the muscle's force. count: axons, each with an equal part of it.
    around_mm, along_mm, depth_mm, threshold_ma, spread: as in `AxonScatter`.
    """

    share: float = 0.07
    count: int = 16
    around_mm: float = 3.0
    along_mm: float = 5.0
    depth_mm: float = 1.0
    threshold_ma: float = 1.8
    spread: float = 0.18

    def __post_init__(self) -> None:
        require_positive("axons.branch", self, "share", "count", "threshold_ma")
        require_not_negative("axons.branch", self, "around_mm", "along_mm", "depth_mm", "spread")
        if self.share >= 1.0:
            raise InputError("axons.branch.share", f"{self.share:g}", "less than 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxonScatter:
    """Distribution of a muscle's axons around its motor point, and of their thresholds.

    Attributes
    ----------
    count: axons of a muscle, each with an equal share of its force.
    around_mm, along_mm, depth_mm: standard deviations from the motor point (depth chosen here; no axon is
        nearer to the skin than `least_depth_mm`).
    threshold_ma: median effective current that excites an axon in a field of 1, mA.
    spread: standard deviation of its logarithm.
    branch: further axons at the motor point, which take their share of the force; None: no such axons.
    """

    count: int = 64
    around_mm: float = 6.0
    along_mm: float = 12.0
    depth_mm: float = 2.0
    least_depth_mm: float = 3.0
    threshold_ma: float = 5.6
    spread: float = 0.25
    branch: MotorBranch | None = field(default_factory=MotorBranch)

    def __post_init__(self) -> None:
        require_positive("axons", self, "count", "threshold_ma", "least_depth_mm")
        if self.total > MOST_AXONS:
            raise InputError("axons.count", f"{self.total}", f"at most {MOST_AXONS}, a branch included")
        require_not_negative("axons", self, "around_mm", "along_mm", "depth_mm", "spread")

    @property
    def total(self) -> int:
        """Number of axons of a muscle: scattered ones, then those of the branch."""
        return self.count + (self.branch.count if self.branch is not None else 0)

    @property
    def shares(self) -> Array:
        """Share (total,) of each axon in the muscle's force."""
        branch = 0.0 if self.branch is None else self.branch.share
        of_branch = np.full(self.total - self.count, branch / max(self.total - self.count, 1))
        return np.concatenate([np.full(self.count, (1.0 - branch) / self.count), of_branch])

    def draw(self, points: Sequence[MotorPoint], radius_mm: float, seed: int, name: str) -> Array:
        """Random axons of each point's muscle, (points, total, 4): around, along, depth, mm, threshold, mA.

        They depend on the seed, the block's name and the muscle alone, and are the same in every trial. A
        greater `count` keeps the first axons.
        """
        axons = np.empty((len(points), self.total, 4))
        for point, rows in zip(points, axons, strict=True):
            self._fill(rows[:self.count], self, point, radius_mm, seed, f"{name}/axons/{point.muscle}")
            if self.branch is not None:
                self._fill(rows[self.count:], self.branch, point, radius_mm, seed,
                           f"{name}/branch/{point.muscle}")
        axons[..., DEPTH] = np.maximum(axons[..., DEPTH], self.least_depth_mm)
        return axons

    @staticmethod
    def _fill(rows: Array, of: AxonScatter | MotorBranch, point: MotorPoint, radius_mm: float, seed: int,
              name: str) -> None:
        stream = NoiseStream(stream_key(seed, name, 0), 4)
        spread = np.array([of.around_mm, of.along_mm, of.depth_mm, of.spread])
        around, along, depth, threshold = (
            spread * np.stack([stream.row(axon) for axon in range(len(rows))])).T
        rows[:, AROUND] = math.radians(point.around_deg) * radius_mm + around
        rows[:, ALONG] = point.along_mm + along
        rows[:, DEPTH] = point.depth_mm + depth
        rows[:, THRESHOLD] = of.threshold_ma * np.exp(threshold)

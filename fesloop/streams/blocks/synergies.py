"""`synergies`: the few quantities of a whole hand's posture that stimulation through the skin can set."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless, uncovered

Array = NDArray[np.float64]
_FINGERS = ("F2", "F3", "F4", "F5")


def _mean(*freedoms: str) -> dict[str, float]:
    return dict.fromkeys(freedoms, 1.0 / len(freedoms))


READY: dict[str, dict[str, float]] = {
    "wrist_extension": {"wrist_flexion": -1.0},
    "wrist_deviation": {"wrist_abduction": 1.0},
    "finger_flexion": _mean(*(f"{f}_{joint}_flexion" for f in _FINGERS for joint in ("mcp", "pip"))),
    "mcp_flexion": _mean(*(f"{f}_mcp_flexion" for f in _FINGERS)),
    "pip_flexion": _mean(*(f"{f}_pip_flexion" for f in _FINGERS)),
    **{f"{f}_flexion": _mean(f"{f}_mcp_flexion", f"{f}_pip_flexion") for f in _FINGERS},
    "thumb_flexion": _mean("F1_mcp_flexion", "F1_ip_flexion"),
    "thumb_abduction": {"F1_cmc_abduction": 1.0},
}
"""Rows by name, weights on the hand's freedoms (chosen: the terms of therapists; long flexors and
extensors move MCP and PIP of a finger together, and DIP follows PIP)."""
GRIP_APERTURE = "grip_aperture"
"""Row that is no sum: grip aperture (Jeannerod 1984, doi 10.1080/00222895.1984.10735319), here the distance
of the thumb's tip from the midpoint of the tips of index and middle finger (chosen: they oppose the thumb).
It is an angle in name only, 1 deg for each mm, so that controllers and references of angles take it."""
RAD_PER_M = math.radians(1e3)
"""Angle that stands for an aperture of 1 m: 1 deg for each mm."""
_WIDEST_M = 0.2
"""Greatest aperture (chosen: longer than most hands)."""
_THUMB, _OPPOSED = FINGERS.index("F1"), (FINGERS.index("F2"), FINGERS.index("F3"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Synergies(BlockToControl):
    """Weighted sums of joint angles, y = C angles + c, and the grip aperture: controlled outputs of a hand.

    Inputs: `angles` (f,), rad; optional `angle_sd` (f,), rad; for the row `grip_aperture` also `fingertips`
    (5, 3), m, in any frame, and optional `fingertip_sd` (5, 3), m. Outputs: `synergies` (m,), rad, in the
    order of `rows`, and `sd` (m,), rad, as of independent angles and tips; 0 without `angle_sd` and
    `fingertip_sd`.

    Attributes
    ----------
    rows: names of the sums: those of `weights`, a freedom's for that angle itself, those of `READY`, or
        `grip_aperture`, the distance of the thumb's tip from the midpoint of index and middle finger's, 1 deg
        for each mm.
    weights: further sums: by name, weights on named freedoms; they replace others of the same name.
    offset_deg: c of some rows.
    freedoms: names of the angles; empty: all 23 of the hand.
    """

    rows: tuple[str, ...] = ("wrist_extension", "finger_flexion", "thumb_flexion")
    weights: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    offset_deg: Mapping[str, float] = field(default_factory=dict)
    freedoms: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.freedoms:
            object.__setattr__(self, "freedoms", hand_tree(HandSize()).freedoms)
        known = self._known()
        if not self.rows or len(set(self.rows)) < len(self.rows):
            raise InputError("rows", f"{self.rows}", "one or more names, each once")
        for name in self.rows:
            if name not in known:
                raise InputError("rows", f"{name!r}", ", ".join(known), did_you_mean(name, known))
            if name != GRIP_APERTURE or name in self.weights:
                _require_weights(name, known[name], self.freedoms)
        for name, offset in self.offset_deg.items():
            if name not in self.rows or not math.isfinite(offset):
                raise InputError("offset_deg", f"{name} = {offset}", "finite, of " + ", ".join(self.rows))

    def _known(self) -> dict[str, Mapping[str, float]]:
        """Sums that rows may name; the aperture has no weights."""
        themselves = {freedom: {freedom: 1.0} for freedom in self.freedoms}
        return {**READY, GRIP_APERTURE: {}, **themselves, **self.weights}

    @property
    def aperture(self) -> int | None:
        """Number of the row `grip_aperture`; None without one."""
        weighed = GRIP_APERTURE in self.weights or GRIP_APERTURE not in self.rows
        return None if weighed else self.rows.index(GRIP_APERTURE)

    @property
    def matrix(self) -> Array:
        """C, (m, f); no weights for the aperture."""
        known = self._known()
        return np.array([[known[name].get(freedom, 0.0) for freedom in self.freedoms] for name in self.rows])

    @property
    def offset(self) -> Array:
        """c, (m,), rad."""
        return np.deg2rad([self.offset_deg.get(name, 0.0) for name in self.rows])

    @property
    def ranges(self) -> Array:
        """Least and greatest sums that the joints' ranges of motion allow, (m, 2), rad.

        Angles that are none of the hand's have a whole turn, the aperture 0 to 200 mm.
        """
        tree = hand_tree(HandSize())
        known = dict(zip(tree.freedoms, tree.ranges, strict=True))
        limits = np.array([known.get(freedom, (-math.pi, math.pi)) for freedom in self.freedoms])
        ends = self.matrix[:, :, np.newaxis] * limits
        lowest, highest = ends.min(axis=-1).sum(axis=-1), ends.max(axis=-1).sum(axis=-1)
        if self.aperture is not None:
            highest[self.aperture] = RAD_PER_M * _WIDEST_M
        return np.stack([lowest, highest], axis=-1) + self.offset[:, np.newaxis]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`angles`, `angle_sd`; with the aperture `fingertips`, `fingertip_sd`."""
        size, tips = (len(self.freedoms),), (len(FINGERS), 3)
        angles = Port("angles", size, "rad"), Port("angle_sd", size, "rad", optional=True)
        if self.aperture is None:
            return angles
        return *angles, Port("fingertips", tips, "m"), Port("fingertip_sd", tips, "m", optional=True)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`synergies`, `sd`."""
        size = (len(self.rows),)
        return Port("synergies", size, "rad", rows=self.rows), Port("sd", size, "rad", rows=self.rows)

    def linear_form(self, context: Context) -> SampledForm:
        """The sums; `sd` has none. Raises InputError for the aperture, which is not linear."""
        if self.aperture is not None:
            raise uncovered("rows", GRIP_APERTURE, "sums of angles")
        return replace(memoryless(("angles",), "synergies", self.matrix), offset=self.offset)

    def init(self, context: Context) -> tuple[Array, Array]:
        """C and c: constants."""
        return self.matrix, self.offset

    def step(self, state: tuple[Array, Array], inputs: Sequence[Sample],
             tick: Tick) -> tuple[Value, ...]:
        """Rows of the newest angles and fingertips; no output before the first of each."""
        if not all(sample.present for sample in inputs[::2]):
            return ()
        weights, offset = state
        angles, angle_sd, *tips = (cast(Array, sample.value) for sample in inputs)
        values, variance = weights @ angles, weights**2 @ angle_sd**2
        if self.aperture is not None:
            values[self.aperture], variance[self.aperture] = _aperture(*tips)
        return values + offset, np.sqrt(variance)


def _aperture(fingertips: Array, sd: Array) -> tuple[float, float]:
    """Aperture, rad, and its variance, rad^2, of tips (5, 3), m, with independent errors."""
    opposed = list(_OPPOSED)
    apart = fingertips[opposed].mean(axis=0) - fingertips[_THUMB]
    distance = float(np.linalg.norm(apart))
    along = apart / distance if distance > 0.0 else np.zeros(3)
    variance = along**2 @ (sd[_THUMB]**2 + (sd[opposed]**2).sum(axis=0) / len(opposed)**2)
    return RAD_PER_M * distance, RAD_PER_M**2 * float(variance)


def _require_weights(name: str, weights: Mapping[str, float], freedoms: Sequence[str]) -> None:
    """Raise InputError unless these are finite weights, not all zero, on known freedoms."""
    where = f"weights.{name}"
    for freedom, weight in weights.items():
        if freedom not in freedoms:
            raise InputError(where, f"freedom {freedom!r}", ", ".join(freedoms),
                             did_you_mean(freedom, freedoms))
        if not math.isfinite(weight):
            raise InputError(where, f"{freedom} = {weight}", "finite weights")
    if not any(weights.values()):
        raise InputError(where, "no weight above or below 0", "one or more")

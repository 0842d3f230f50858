"""`synergies`: the few quantities of a whole hand's posture that stimulation through the skin can set."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Synergies(BlockToControl):
    """Weighted sums of joint angles, y = C angles + c: what a controller of the whole hand controls.

    Inputs: `angles` (f,), rad; optional `angle_sd` (f,), rad. Outputs: `synergies` (m,), rad, in the order of
    `rows`, and `sd` (m,), rad, as of independent angles; 0 without `angle_sd`.

    Attributes
    ----------
    rows: names of the sums: those of `weights`, a freedom's for that angle itself, or those of `READY`.
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
            _require_weights(name, known[name], self.freedoms)
        for name, offset in self.offset_deg.items():
            if name not in self.rows or not math.isfinite(offset):
                raise InputError("offset_deg", f"{name} = {offset}", "finite, of " + ", ".join(self.rows))

    def _known(self) -> dict[str, Mapping[str, float]]:
        """Sums that rows may name."""
        return {**READY, **{freedom: {freedom: 1.0} for freedom in self.freedoms}, **self.weights}

    @property
    def matrix(self) -> Array:
        """C, (m, f)."""
        known = self._known()
        return np.array([[known[name].get(freedom, 0.0) for freedom in self.freedoms] for name in self.rows])

    @property
    def offset(self) -> Array:
        """c, (m,), rad."""
        return np.deg2rad([self.offset_deg.get(name, 0.0) for name in self.rows])

    @property
    def ranges(self) -> Array:
        """Least and greatest sums that the joints' ranges of motion allow, (m, 2), rad.

        Angles that are none of the hand's have a whole turn.
        """
        tree = hand_tree(HandSize())
        known = dict(zip(tree.freedoms, tree.ranges, strict=True))
        limits = np.array([known.get(freedom, (-math.pi, math.pi)) for freedom in self.freedoms])
        ends = self.matrix[:, :, np.newaxis] * limits
        lowest, highest = ends.min(axis=-1).sum(axis=-1), ends.max(axis=-1).sum(axis=-1)
        return np.stack([lowest, highest], axis=-1) + self.offset[:, np.newaxis]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`angles`, `angle_sd`."""
        size = (len(self.freedoms),)
        return Port("angles", size, "rad"), Port("angle_sd", size, "rad", optional=True)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`synergies`, `sd`."""
        size = (len(self.rows),)
        return Port("synergies", size, "rad"), Port("sd", size, "rad")

    def linear_form(self, context: Context) -> SampledForm:
        """The sums; `sd` has none."""
        return replace(memoryless(("angles",), "synergies", self.matrix), offset=self.offset)

    def init(self, context: Context) -> tuple[Array, Array]:
        """C and c: constants."""
        return self.matrix, self.offset

    def step(self, state: tuple[Array, Array], inputs: Sequence[Sample],
             tick: Tick) -> tuple[Value, ...]:
        """The sums of the newest angles; no output before the first."""
        if not inputs[0].present:
            return ()
        weights, offset = state
        angles, angle_sd = (cast(Array, sample.value) for sample in inputs)
        return weights @ angles + offset, np.sqrt(weights**2 @ angle_sd**2)


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

"""How well each joint is known, told when it changes: "unsure" and "sure", "unseen" and "seen"."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.body.joint_constraints import JointTable
from fesloop.compiled import compiled
from fesloop.loop.block import Tick

SURE, UNSURE, UNSEEN = range(3)
_SURE_AGAIN = 0.8
"""Share of the limit below which a joint is sure again; in between nothing is reported (chosen)."""


@compiled
def stand(worst: Any, limit: float, standing: Any) -> bool:
    """Whether any joint stands otherwise than `standing` (joints,) says.

    `worst` (joints,), rad, is the largest sd of its angles, infinite where nothing is known; `limit` the
    sd from which on it is unsure.
    """
    changed = False
    for j in range(worst.size):
        changed |= stands(worst[j], limit, standing[j]) != standing[j]
    return changed


@compiled
def stands(worst: float, limit: float, before: int) -> int:
    """SURE, UNSURE or UNSEEN, of a joint that stood at `before`."""
    if worst == math.inf:
        return UNSEEN
    return UNSURE if worst > (_SURE_AGAIN * limit if before == UNSURE else limit) else SURE


def report(
    worst: NDArray[np.float64], limit: float, standing: NDArray[np.int64], table: JointTable, first: bool,
    tick: Tick
) -> None:
    """Report what has changed, and bring `standing` up to date; at `first` the joints without sensors too."""
    now = np.array([stands(sd, limit, before) for sd, before in zip(worst, standing, strict=True)],
                   dtype=np.int64)
    changed = now != standing
    for status, chosen, more in (
            ("unseen", changed & (now == UNSEEN), table.unsensed if first else ()),
            ("seen", changed & (standing == UNSEEN), ()),
            ("unsure", changed & (now == UNSURE), ()),
            ("sure", changed & (standing == UNSURE) & (now == SURE), ())):
        names = (*more, *(table.names[j] for j in np.flatnonzero(chosen)))
        if names:
            tick.report(status, "joint " + ", ".join(names))
    standing[:] = now

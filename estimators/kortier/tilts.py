"""Tilts of hinges' axes in the sensors' frames, and the scale of the misalignment's variance that they show.

The offsets of forbidden angles (`estimators.kortier.chain`) are poor evidence: each innovation is shared
between a joint's rotation and its offset, and their correlation is neglected, so that an offset counts as
known while much of it is in the rotation. Here neighbouring accelerometers are compared along a hinge's axis
a, where the hinge's rotation does not matter (Olsson et al. 2020, doi 10.3390/s20123534). With u the tilt
that parent and child share, w the child's tilt less the parent's, and f specific force:

    (a + u - w / 2) . f_p = (a + u + w / 2) . f_c + noise

u and w have two components across a each, with the variances that `estimators.body.misalignment` states.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.misalignment import Misalignment, evidence_scale
from estimators.kortier.chain import Gates, comparable
from estimators.kortier.error_state import absorb
from estimators.kortier.samples import Moment, Trust, repeats
from estimators.kortier.tree import Chains
from fesloop.compiled import compiled

Array = NDArray[np.float64]
HINGE = 1
"""Number of freedoms of a hinge."""


class Tilts(NamedTuple):
    """Tilts of the axes of hinges; the rows of other joints are not used.

    Attributes
    ----------
    mean: (joints, 4), u and w, rad. covariance: (joints, 4, 4).
    """

    mean: Array
    covariance: Array


def new_tilts(chains: Chains, wrong: Misalignment) -> Tilts:
    """Create the tilts before any motion."""
    stated = [np.diag(np.repeat(_stated(wrong, segment), 2)) for segment in chains.segments]
    return Tilts(np.zeros((len(stated), 4)), np.array(stated).reshape(-1, 4, 4))


@compiled
def _stated(wrong: Misalignment, segment: int) -> Any:
    """Stated variances of a component of u and of w of a segment's joint, rad^2."""
    mounting = wrong.pair[segment] - wrong.fused
    return wrong.growing[segment] + 0.25 * mounting, mounting


@compiled
def compare_along_hinges(
    chains: Chains, seen: Any, moment: Moment, elapsed_s: float, spacing_s: float, trust: Trust, gates: Gates,
    tilts: Tilts
) -> None:
    """Update the tilts of hinges whose accelerations are new and pass the gates.

    Parameters
    ----------
    seen: (joints,), as in Filters.
    elapsed_s: time since the samples before these, spacing_s: since those that were compared last.
    """
    row, image, gain = np.empty(4), np.empty(4), np.empty(4)
    again, counted = repeats(gates.error_time_s, spacing_s), repeats(gates.error_time_s, elapsed_s)
    for chain in range(chains.first.size - 1):
        for k in range(chains.first[chain], chains.first[chain + 1]):
            parent, child = chains.sensors[k + chain], chains.sensors[k + chain + 1]
            f_p, f_c = moment.acc[parent], moment.acc[child]
            variance = moment.acc_variance[parent] + moment.acc_variance[child]
            if chains.freedoms[k] != HINGE or not seen[k] or not comparable(
                    f_p, f_c, variance, moment.rates[parent], moment.rates[child], gates):
                continue
            for i in range(2):
                p, c = _along(chains.axes[k, 1 + i], f_p), _along(chains.axes[k, 1 + i], f_c)
                row[i], row[2 + i] = p - c, -0.5 * (p + c)
            difference = _along(chains.axes[k, 0], f_c) - _along(chains.axes[k, 0], f_p)
            noise = 2.0 * trust.acc_sd ** 2
            lasting = (variance - noise) / counted + gates.constraint_sd ** 2 * _along(f_p, f_p)
            absorb(tilts.covariance[k], tilts.mean[k], row, 0, 4, difference, noise + again * lasting, image,
                   gain)


@compiled(inline="always")
def _along(a: Any, b: Any) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def mounting_scale(chains: Chains, wrong: Misalignment, tilts: Tilts) -> float:
    """Scale of the misalignment's variance that the tilts show (`evidence_scale`)."""
    squares, seen = 0.0, 0.0
    for k in range(chains.segments.size):
        if chains.freedoms[k] == HINGE:
            shared, between = _stated(wrong, chains.segments[k])
            for i in range(4):
                before = shared if i < 2 else between
                squares += tilts.mean[k, i] ** 2 / before
                seen += 1.0 - tilts.covariance[k, i, i] / before
    return evidence_scale(squares, seen)

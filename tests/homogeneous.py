"""Forward kinematics by homogeneous matrices (doi 10.1186/1743-0003-11-70, eq. 1-2).

Slower than dual quaternions, and shares no formula with them: each checks the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]


def translation(vector: ArrayLike) -> Array:
    """Matrix (4, 4) of a displacement (3,), m."""
    matrix = np.eye(4)
    matrix[:3, 3] = vector
    return matrix


def rotation(axis: Array, angle: Array) -> Array:
    """Matrices (..., 4, 4) of rotations by `angle` (...), rad, about a unit vector (3,) (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(angle)[..., np.newaxis, np.newaxis], np.cos(angle)[..., np.newaxis, np.newaxis]
    matrix = np.zeros((*angle.shape, 4, 4))
    matrix[..., :3, :3] = np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
    matrix[..., 3, 3] = 1.0
    return matrix


def segment_matrices(tree: SegmentTree, angles: ArrayLike, root: ArrayLike | None = None) -> Array:
    """Matrices (..., n, 4, 4) from each segment's frame to the frame in which the root's pose is given.

    Parameters
    ----------
    angles: (..., d), rad.
    root: (..., 4, 4), pose of the root; the identity if None.
    """
    angle = np.asarray(angles, dtype=np.float64)
    first = np.broadcast_to(np.eye(4) if root is None else np.asarray(root, dtype=np.float64),
                            (*angle.shape[:-1], 4, 4))
    chain: list[Array] = []
    for (parent, freedoms, start), geometry in zip(tree.layout, tree.geometry, strict=True):
        if parent < 0:
            chain.append(first)
            continue
        matrix = chain[parent] @ translation(geometry[3])
        for i in range(freedoms):
            matrix = matrix @ rotation(geometry[i], angle[..., start + i])
        chain.append(matrix @ translation(geometry[4]))
    return np.stack(chain, axis=-3)

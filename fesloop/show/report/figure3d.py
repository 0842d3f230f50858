"""A hand in motion, as a report or a view shows it: its shape, its poses, what else stands there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.show.picture.hand_mesh import Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Figure3d:
    """A hand in motion: as it was, and as the tracker had it.

    Attributes
    ----------
    trials: frames by trial.
    shapes: of each hand ("truth", "estimate"): a mesh a segment, in the segment's frame, m.
    objects: what else stands there: an object that moves with a pose of its own, or a table that does not.
    view: (3,), from where it is first looked at, into the scene; global (east, north, up), of any length.
    text: one sentence for those who cannot see it.
    """

    key: str
    trials: Mapping[int, Frames]
    shapes: Mapping[str, Sequence[Mesh]]
    objects: Sequence[Solid] = ()
    view: tuple[float, float, float] = (0.6, 0.6, -0.5)
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """Something else to be seen: `kind` cylinder, sphere, box or plane, with its half sizes (3,), m.

    `role` of its colour; `moves`: its pose is in each frame under `objects`, in their order; else `pose`.
    """

    kind: str
    half_sizes: tuple[float, float, float]
    role: str
    moves: bool
    pose: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frames:
    """Poses at evenly spaced instants of one trial; between them a page turns and moves smoothly.

    Attributes
    ----------
    start_s, step_s: instant of the first, and between two.
    hands: by name ("truth", "estimate"): orientation (w, x, y, z) and position of each segment, global,
        (frames, segments, 7), m; NaN where it is not known.
    objects: (frames, objects that move, 7).
    """

    start_s: float
    step_s: float
    hands: Mapping[str, Array]
    objects: Array = field(default_factory=lambda: np.empty((0, 0, 7)))

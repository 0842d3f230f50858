"""Pictures of flesh and solids: traced, lit, contoured, as arrays of colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.show.picture.camera import Camera
from fesloop.show.picture.distance_kernels import bounding_balls
from fesloop.show.picture.flesh import Flesh
from fesloop.show.picture.ray_kernels import trace

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Colour = tuple[float, float, float]
_LAMP = np.array([-0.45, 0.75, -0.55])
"""Towards the lamp in the camera's right, up, along (chosen: over the viewer's left shoulder)."""
_CREASE_M = 0.004
"""A step in depth from which a contour is drawn (chosen)."""
_SKY = np.array([1.0, 0.97, 0.95])
"""Light from all round: a little warm, so that shadows on skin don't look grey."""
_LINE = np.array([0.16, 0.15, 0.17])
AROUND_M = 0.5
"""Rays begin and end this far from what is framed, m: farther than a hand and what it holds reach."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Something beside the hand.

    Attributes
    ----------
    kind: of `distance_kernels`: BOX, CYLINDER (about its z), BALL.
    position, orientation: (3,) m and (4,), global.
    half: (3,), m: a box's half sides; of a cylinder radius and half height; of a ball its radius.
    colour: of it.
    fades: whether only what is near the hand is shown of it, as of a table.
    """

    kind: int
    position: Array
    orientation: Array
    half: Array
    colour: Colour
    fades: bool = False

    @property
    def row(self) -> Array:
        """As the kernels take it, (16,)."""
        turn = quaternion.to_matrix(self.orientation).ravel()
        return np.concatenate([[self.kind], self.position, turn, self.half])


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What a picture shows.

    Attributes
    ----------
    camera: from where. low, high: (2,), m: its corners in the camera's right and up.
    pixel_m: size of a pixel.
    """

    camera: Camera
    low: Array
    high: Array
    pixel_m: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        width, height = np.maximum(np.ceil((self.high - self.low) / self.pixel_m), 1).astype(int)
        return int(height), int(width)

    def points(self, depth: Array) -> Array:
        """Where rays that go `depth` (rows, columns), m, from the near side end, (rows, columns, 3)."""
        rows, columns = self.shape
        x = self.low[0] + self.pixel_m * (np.arange(columns) + 0.5)
        y = self.high[1] - self.pixel_m * (np.arange(rows) + 0.5)
        far = np.where(np.isfinite(depth), depth, 0.0) - AROUND_M
        flat = x[:, np.newaxis] * self.camera.right + y[:, np.newaxis, np.newaxis] * self.camera.up
        return np.asarray(flat + far[..., np.newaxis] * self.camera.along)


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """What the rays of a frame met: (rows, columns, ...), see `ray_kernels.trace`."""

    depth: Array
    normal: Array
    ambient: Array
    lit: Array
    surface: Numbers
    bar: Numbers


def traced(frame: Frame, flesh: Flesh, solids: Sequence[Solid], shading: bool = True) -> Traced:
    """Trace a scene that lies around the origin; without `shading` only distances and surfaces."""
    camera, (rows, columns) = frame.camera, frame.shape
    seen, surfaces = np.zeros((rows, columns, 6)), np.empty((rows, columns, 2), dtype=np.int64)
    right, down = frame.pixel_m * camera.right, -frame.pixel_m * camera.up
    origin = (frame.low[0] * camera.right + frame.high[1] * camera.up - AROUND_M * camera.along
              + 0.5 * (right + down))
    light = _LAMP[0] * camera.right + _LAMP[1] * camera.up + _LAMP[2] * camera.along
    rows_of = np.array([solid.row for solid in solids]).reshape(-1, 16)
    trace(origin, right, down, camera.along, light / np.linalg.norm(light), 2.0 * AROUND_M, flesh.bars,
          flesh.groups, flesh.blends, bounding_balls(flesh.bars), rows_of, shading, seen, surfaces)
    met = np.where(surfaces[..., 0] >= 0, seen[..., 0], np.inf)
    return Traced(met, seen[..., 1:4], seen[..., 4], seen[..., 5], surfaces[..., 0], surfaces[..., 1])


def shaded(found: Traced, camera: Camera, base: Array) -> Array:
    """Colours (rows, columns, 4) of a scene, transparent where there is none.

    `base` (rows, columns, 3), of the surfaces before they are lit.
    """
    light = np.array([*_LAMP]) / np.linalg.norm(_LAMP)
    normal = camera.seen(found.normal)
    facing = np.clip(normal @ light, 0.0, 1.0) * found.lit
    rim = 1.0 - np.clip(-normal[..., 2], 0.0, 1.0)
    sky = 0.5 + 0.5 * normal[..., 1]
    round_about = (0.35 + 0.65 * found.ambient) * (0.56 + 0.2 * sky - 0.08 * rim**2)
    half = light + np.array([0.0, 0.0, -1.0])
    shine = np.clip(normal @ (half / np.linalg.norm(half)), 0.0, 1.0) ** 30 * found.lit
    tinted = base * (round_about[..., np.newaxis] * _SKY + 0.38 * facing[..., np.newaxis])
    tinted += 0.08 * shine[..., np.newaxis]
    picture = np.concatenate([np.clip(tinted, 0.0, 1.0), (found.surface >= 0)[..., np.newaxis]], axis=-1)
    line = contours(found)[..., np.newaxis]
    picture[..., :3] = picture[..., :3] * (1.0 - 0.8 * line) + 0.8 * line * _LINE
    return np.asarray(picture)


def contours(found: Traced) -> Array:
    """How much of a line each pixel has, (rows, columns), 0 to 1: where depth steps or surfaces change."""
    depth = np.where(np.isfinite(found.depth), found.depth, 10.0)
    line = np.zeros(depth.shape)
    for axis in (0, 1):
        for way in (-2, -1, 1, 2):
            # Only the nearer side of a step has the line.
            step = np.roll(depth, way, axis) - depth
            line = np.maximum(line, np.clip(step / _CREASE_M - 0.5, 0.0, 1.0))
    line[[0, 1, -2, -1]] = line[:, [0, 1, -2, -1]] = 0.0
    return np.where(found.surface >= 0, line, 0.0)


def over(picture: Array, found: Traced, ghost: Traced, colour: Colour, alpha: float) -> Array:
    """A picture with a second, translucent hand laid over it, fainter where the first has or hides it."""
    there = ghost.surface >= 0
    with np.errstate(invalid="ignore"):
        ahead = np.where(there, np.clip((found.depth - ghost.depth) / _CREASE_M, 0.0, 1.0), 0.0)
    cover = np.where(there, alpha * (0.3 + 0.7 * ahead), 0.0)
    cover = np.maximum(cover, contours(ghost) * (0.6 + 0.35 * ahead))[..., np.newaxis]
    whole = cover + picture[..., 3:] * (1.0 - cover)
    mixed = cover * np.array(colour) + picture[..., 3:] * picture[..., :3] * (1.0 - cover)
    return np.concatenate([mixed / np.maximum(whole, 1e-9), whole], axis=-1)


def vignetted(picture: Array, pixels: int) -> Array:
    """The picture fading into nothing over its outermost pixels."""
    rows, columns = (np.minimum(np.arange(size) + 0.5, size - 0.5 - np.arange(size))
                     for size in picture.shape[:2])
    share = np.clip(np.minimum(rows[:, np.newaxis], columns) / pixels, 0.0, 1.0)
    faded = picture.copy()
    faded[..., 3] *= share
    return faded


def smaller(picture: Array, factor: int) -> Array:
    """The picture with `factor` times fewer rows and columns, each the mean of its pixels."""
    rows, columns = picture.shape[0] // factor, picture.shape[1] // factor
    cut = picture[:rows * factor, :columns * factor].reshape(rows, factor, columns, factor, 4)
    alpha = cut[..., 3:].mean(axis=(1, 3))
    colour = (cut[..., :3] * cut[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.asarray(np.clip(np.concatenate([colour, alpha], axis=-1), 0.0, 1.0))

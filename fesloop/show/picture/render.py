"""Camera, and shaded meshes of hands and solids that matplotlib draws from it.

Light is computed at vertices: ambient light and shadows follow from signed distances to the scene. matplotlib
fills the triangles, the farthest first, with the colours of their corners interpolated (Gouraud shading).
"""


from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.hand import quaternion

Array = NDArray[np.float64]
_ELEVATIONS_DEG = np.array([12.0, 22.0, 32.0, 45.0])
_AZIMUTHS_DEG = np.arange(0.0, 360.0, 10.0)


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """Parallel projection.

    Attributes
    ----------
    along: (3,), unit vector of the view, from the camera into the scene.
    right, up: (3,), unit vectors of the picture.
    """

    along: Array
    right: Array
    up: Array

    @classmethod
    def towards(cls, along: ArrayLike) -> Camera:
        """The view along a direction that is not vertical, the picture's sides upright."""
        way = np.asarray(along, dtype=np.float64) / np.linalg.norm(along)
        right = np.cross(way, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return cls(way, right, np.cross(right, way))

    def seen(self, points: Array) -> Array:
        """Points (..., 3) in the camera's axes right, up and along, m."""
        return points @ np.stack([self.right, self.up, self.along], axis=-1)


def _directions() -> Array:
    """Views from above the horizon, (n, 3)."""
    elevation, azimuth = (each.ravel() for each in np.meshgrid(
        np.deg2rad(_ELEVATIONS_DEG), np.deg2rad(_AZIMUTHS_DEG), indexing="ij"))
    flat = np.cos(elevation)
    return -np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def best_view(points: Array, moving: Array, liked: Array) -> Camera:
    """The view that shows the most of a hand's postures and of its motion.

    Parameters
    ----------
    points: (instants, n, 3), of the hand at each instant, m. moving: (instants, m, 3), those of them whose
        motion is to be seen, such as fingertips.
    liked: (3,), direction, from the hand, that a view prefers to come from; of a length of about 1.
    """
    ways = _directions()
    spread = _seen_spread(points - points.mean(axis=1, keepdims=True), ways)
    travel = _seen_spread(moving - moving.mean(axis=0), ways)
    return Camera.towards(ways[int(np.argmax(spread + 0.6 * travel - 0.25 * ways @ liked))])


def _seen_spread(centred: Array, ways: Array) -> Array:
    """Share of points' mean square distance that each view shows, (n,); 1 where there is none."""
    square = np.square(centred).sum(axis=-1).mean()
    if square < 1e-8:
        return np.ones(len(ways))
    hidden = np.square(centred @ ways.T).mean(axis=(0, 1))
    return np.asarray(1.0 - hidden / square)


Numbers = NDArray[np.int64]
Colour = tuple[float, float, float]
Kind = Literal["box", "cylinder", "sphere"]
Distances = Callable[[Array], Array]
"""Function from points (n, 3) to signed distances (n,) from the scene, m."""
_LAMP = np.array([-0.45, 0.75, -0.55]) / np.linalg.norm([-0.45, 0.75, -0.55])
"""Direction to the lamp in the camera's right, up, along (chosen: over the viewer's left shoulder)."""
_SKY = np.array([1.0, 0.97, 0.95])
"""Colour of ambient light (chosen: warm, so that shadows on skin are not grey)."""
_LINE: Colour = (0.16, 0.15, 0.17)
_LINE_M, _LINE_ALPHA = 5e-4, 0.8
"""Width of an outline, and its opacity on an opaque surface (chosen)."""
BIAS_M = 0.003
"""Difference in depth below which triangles may be sorted wrongly: about the length of their sides."""
_SHADE_M = 0.02
"""Distance within which flesh takes ambient light (chosen)."""
_SHADOW_STEPS, _LONGEST_STEP_M = 24, 0.06
_SOFTNESS = 14.0
"""Ratio of distance to gap above which a passing light is complete (chosen: a large lamp)."""
_CELL_M = 0.004
"""Distance between vertices of solids, on which shadows are sampled (chosen)."""
_AROUND = 65
"""Vertices around a cylinder or sphere."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Object beside the hand.

    Attributes
    ----------
    kind: box, cylinder (about its z) or sphere.
    position, orientation: (3,) m and (4,), global.
    half: (3,), m: half sides of a box; radius and half height of a cylinder; radius of a sphere.
    colour: red, green, blue. fades: whether only the part near the hand is shown, as of a table.
    """

    kind: Kind
    position: Array
    orientation: Array
    half: Array
    colour: Colour
    fades: bool = False

    def distances(self, points: Array) -> Array:
        """Signed distances (n,) from points (n, 3), m."""
        own = quaternion.rotate(quaternion.conjugate(self.orientation), points - self.position)
        if self.kind == "sphere":
            return np.asarray(np.linalg.norm(own, axis=1) - self.half[0])
        if self.kind == "cylinder":
            beyond = np.stack([np.hypot(own[:, 0], own[:, 1]), np.abs(own[:, 2])], axis=-1) - self.half[:2]
        else:
            beyond = np.abs(own) - self.half
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Mesh to draw: vertices (v, 3), m, unit normals (v, 3), faces (f, 3), colours and opacity (v, 4)."""

    vertices: Array
    normals: Array
    faces: Numbers
    colours: Array

    def facing(self, camera: Camera) -> Surface:
        """Surface without the faces that are turned away from the camera."""
        return replace(self, faces=self.faces[self._turned(camera) < 0.0])

    def _turned(self, camera: Camera) -> Array:
        """Component (f,) of each face's normal along the view."""
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return np.asarray(np.cross(b - a, c - a) @ camera.along)

    def lit(self, camera: Camera, distances: Distances) -> Surface:
        """Surface with its colours lit by the lamp and ambient light in a scene."""
        normal = camera.seen(self.normals)
        direct = np.clip(normal @ _LAMP, 0.0, 1.0)
        direct *= lamp_share(self.vertices, self.normals, camera, distances)
        ambient = ambient_share(self.vertices, self.normals, distances)
        rim = 1.0 - np.clip(-normal[:, 2], 0.0, 1.0)
        around = (0.35 + 0.65 * ambient) * (0.56 + 0.1 * (1.0 + normal[:, 1]) - 0.08 * rim**2)
        half = _LAMP + np.array([0.0, 0.0, -1.0])
        shine = np.clip(normal @ (half / np.linalg.norm(half)), 0.0, 1.0) ** 30 * (direct > 0.0)
        light = around[:, np.newaxis] * _SKY + 0.38 * direct[:, np.newaxis]
        colours = self.colours.copy()
        colours[:, :3] = np.clip(colours[:, :3] * light + 0.08 * shine[:, np.newaxis], 0.0, 1.0)
        return replace(self, colours=colours)

    def outline(self, camera: Camera, colour: Colour = _LINE, alpha: float = _LINE_ALPHA) -> Surface:
        """Narrow strips along the edges between faces turned towards the camera and away from it."""
        # Patches of solids have vertices of their own at the edges that they share.
        _, first, same = np.unique(np.round(self.vertices, 7), axis=0, return_index=True, return_inverse=True)
        edges = np.sort(first[same.ravel()][self.faces][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        order = np.lexsort(edges.T)
        edges, towards = edges[order], np.repeat(self._turned(camera) < 0.0, 3)[order]
        shared = (edges[1:] == edges[:-1]).all(axis=1) & (towards[1:] != towards[:-1])
        start, end = edges[1:][shared].T
        a, b = self.vertices[start], self.vertices[end]
        way = camera.seen(b - a)
        length = np.maximum(np.linalg.norm(way[:, :2], axis=1, keepdims=True), 1e-12)
        beside = 0.5 * _LINE_M * (way[:, :1] * camera.up - way[:, 1:2] * camera.right) / length
        corners = np.stack([a - beside, a + beside, b + beside, b - beside], axis=1).reshape(-1, 3)
        first = 4 * np.arange(len(a))[:, np.newaxis]
        faces = np.concatenate([first + np.array(each) for each in ((0, 1, 2), (0, 2, 3))])
        seen = np.repeat(alpha * self.colours[start, 3], 4)
        colours = np.column_stack([np.broadcast_to(colour, (len(corners), 3)), seen])
        return Surface(corners, np.zeros_like(corners), faces, colours).moved(-BIAS_M * camera.along)

    def moved(self, by: Array) -> Surface:
        """Surface moved by (3,), m."""
        return replace(self, vertices=self.vertices + by)


def ambient_share(points: Array, normals: Array, distances: Distances) -> Array:
    """Share (n,) of ambient light that reaches points of surfaces: less in creases."""
    taken = np.zeros(len(points))
    for i in range(1, 5):
        out = 0.25 * i * _SHADE_M
        taken += (out - distances(points + out * normals)) / out * 0.5**i
    return np.clip(1.0 - 1.1 * taken, 0.0, 1.0)


def lamp_share(points: Array, normals: Array, camera: Camera, distances: Distances) -> Array:
    """Share (n,) of a large lamp's light that reaches points, by the gaps along the way to it."""
    lamp = _LAMP @ np.stack([camera.right, camera.up, camera.along])
    share, far = np.ones(len(points)), np.full(len(points), 2e-3)
    start = points + 1e-3 * normals
    for _ in range(_SHADOW_STEPS):
        gap = distances(start + far[:, np.newaxis] * lamp)
        share = np.minimum(share, 0.5 + 0.5 * _SOFTNESS * gap / far)
        far += np.clip(gap, 4e-3, _LONGEST_STEP_M)
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def solid_surface(solid: Solid) -> Surface:
    """Surface of a solid, unlit."""
    patches = _box(solid.half) if solid.kind == "box" else _round(solid)
    vertices, normals, faces = [], [], []
    count = 0
    for points, normal in patches:
        number = count + np.arange(points[..., 0].size).reshape(points.shape[:2])
        a, b, c, d = (each.ravel() for each in
                      (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
        faces.append(np.concatenate([[a, b, c], [a, c, d]], axis=1).T)
        vertices.append(points.reshape(-1, 3))
        normals.append(np.broadcast_to(normal, points.shape).reshape(-1, 3))
        count += number.size
    whole, outwards, corners = np.concatenate(vertices), np.concatenate(normals), np.concatenate(faces)
    first, second, third = (whole[corners[:, i]] for i in range(3))
    leans = (np.cross(second - first, third - first) * outwards[corners[:, 0]]).sum(axis=1)
    corners[leans < 0.0] = corners[leans < 0.0, ::-1]
    corners = corners[np.abs(leans) > 1e-12]
    return Surface(solid.position + quaternion.rotate(solid.orientation, whole),
                   quaternion.rotate(solid.orientation, outwards), corners,
                   np.tile([*solid.colour, 1.0], (count, 1)))


Patch = tuple[Array, Array]
"""Grid of points (u, v, 3) and their normals, (u, v, 3) or (3,)."""


def _steps(low: float, high: float) -> Array:
    return np.linspace(low, high, max(2, round((high - low) / _CELL_M) + 1))


def _box(half: Array) -> list[Patch]:
    patches: list[Patch] = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        u, v = np.meshgrid(*(_steps(-half[each], half[each]) for each in (first, second)), indexing="ij")
        for side in (-1.0, 1.0):
            points = np.empty((*u.shape, 3))
            points[..., first], points[..., second], points[..., axis] = u, v, side * half[axis]
            patches.append((points, side * np.eye(3)[axis]))
    return patches


def _round(solid: Solid) -> list[Patch]:
    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND)[:, np.newaxis]
    radius, half = solid.half[0], solid.half[1]
    if solid.kind == "sphere":
        up = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _AROUND // 2)
        normal = _stacked(np.cos(turn) * np.cos(up), np.sin(turn) * np.cos(up), np.sin(up))
        return [(radius * normal, normal)]
    height, out = _steps(-half, half), _steps(0.0, radius)
    around = _stacked(np.cos(turn), np.sin(turn), 0.0 * height)
    patches = [(radius * around + _stacked(0.0 * turn, 0.0, height), around)]
    for side in (-1.0, 1.0):
        cap = _stacked(out * np.cos(turn), out * np.sin(turn), side * half)
        patches.append((cap, np.array([0.0, 0.0, side])))
    return patches


def _stacked(*components: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(*components), axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """View of a picture.

    Attributes
    ----------
    camera: parallel projection. low, high: (2,), corners in the camera's right and up, m.
    pixel_m: size of a pixel, m.
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


def painted(frame: Frame, surfaces: Sequence[Surface]) -> Array:
    """Picture (rows, columns, 4) of surfaces, transparent where they are and where there is none."""
    vertices = np.concatenate([each.vertices for each in surfaces])
    firsts = np.cumsum([0, *(len(each.vertices) for each in surfaces)])
    faces = np.concatenate([each.faces + first for each, first in zip(surfaces, firsts, strict=False)])
    colours = np.concatenate([each.colours for each in surfaces])
    seen = frame.camera.seen(vertices)
    faces = faces[(colours[faces, 3] > 0.0).any(axis=1)]
    faces = faces[np.argsort(-seen[faces, 2].mean(axis=1), kind="stable")]
    # Translucent triangles would show the seams between them: opacity is painted as a grey of its own.
    opacity = np.repeat(colours[:, 3:], 3, axis=1)
    picture, grey = (_filled(frame, seen, faces, each) for each in (colours[:, :3], opacity))
    picture[..., 3] *= grey[..., 0]
    return picture


def _filled(frame: Frame, seen: Array, faces: Numbers, colours: Array) -> Array:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import TriMesh
    from matplotlib.figure import Figure
    from matplotlib.tri import Triangulation

    rows, columns = frame.shape
    figure = Figure(figsize=(columns / 100, rows / 100), dpi=100, facecolor=(1.0, 1.0, 1.0, 0.0))
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(frame.low[0], frame.high[0])
    axes.set_ylim(frame.low[1], frame.high[1])
    if len(faces):
        triangles = TriMesh(Triangulation(seen[:, 0], seen[:, 1], faces))
        opaque: Any = np.column_stack([colours, np.ones(len(colours))])
        triangles.set_facecolor(opaque)
        axes.add_collection(triangles)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba(), dtype=np.float64) / 255.0  # type: ignore[no-untyped-call]


def over(picture: Array, ghost: Array) -> Array:
    """Overlay a picture with a second one."""
    cover = ghost[..., 3:]
    whole = cover + picture[..., 3:] * (1.0 - cover)
    mixed = cover * ghost[..., :3] + picture[..., 3:] * picture[..., :3] * (1.0 - cover)
    return np.concatenate([mixed / np.maximum(whole, 1e-9), whole], axis=-1)


def vignetted(picture: Array, pixels: int) -> Array:
    """Picture that fades out over its outermost pixels."""
    rows, columns = (np.minimum(np.arange(size) + 0.5, size - 0.5 - np.arange(size))
                     for size in picture.shape[:2])
    faded = picture.copy()
    faded[..., 3] *= np.clip(np.minimum(rows[:, np.newaxis], columns) / pixels, 0.0, 1.0)
    return faded

"""Picture of the hand: a strip of recorded postures, overlaid with the tracker's estimate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.flesh import Flesh, flesh, flesh_distances, nearest_segments
from fesloop.show.picture.hand_mesh import hand_surface, slope
from fesloop.show.picture.posture import Posture
from fesloop.show.picture.render import (
    BIAS_M,
    Camera,
    Colour,
    Frame,
    Solid,
    Surface,
    best_view,
    over,
    painted,
    solid_surface,
    vignetted,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
_SKIN: Colour = (0.93, 0.80, 0.71)
_NAIL: Colour = (0.97, 0.88, 0.84)
_FIRST_M, _LAST_M = 0.08, 0.15
"""Distances from the hand between which a table fades out, m."""
_FADED = 0.55
"""Share of the shown forearm beyond which it fades."""
_CELL_M, _SLOPE_M = 0.003, 2e-4
"""Distance between vertices of the hand, and half the base over which normals are taken (chosen)."""
_HIDDEN = 0.4
"""Opacity of the estimate behind the scene relative to that in front of it (chosen)."""


def hand_surface_of(shape: Flesh, poses: Poses, size: HandSize, forearm_m: float) -> Surface:
    """Skin with nails, unlit; the forearm fades out towards `forearm_m` from the wrist."""
    mesh = hand_surface(shape, _CELL_M)
    points = mesh.vertices
    normals = slope(lambda each: flesh_distances(each, shape), points, _SLOPE_M)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    segments = nearest_segments(points, shape)
    colours = np.tile([*_SKIN, 1.0], (len(points), 1))
    for i, segment in enumerate(range(4, 17, 3)):
        there = segments == segment
        own = _in_segment(points[there], poses, segment)
        nail = _on_nail(own * size.outwards, size.tips[i])
        colours[there, :3] = np.where(nail[:, np.newaxis], _NAIL, _SKIN)
    there = segments == 0
    share = np.abs(_in_segment(points[there], poses, 0)[:, 1]) / forearm_m
    colours[there, 3] = np.clip((1.0 - share) / (1.0 - _FADED), 0.0, 1.0)
    return Surface(points, normals, mesh.faces.astype(np.int64), colours)


def _in_segment(points: Array, poses: Poses, segment: int) -> Array:
    """Points (n, 3) in the frame of a segment."""
    back = quaternion.conjugate(poses.orientation[segment])
    return quaternion.rotate(back, points - poses.position[segment])


def _on_nail(own: Array, tip: Array) -> NDArray[np.bool_]:
    """Mask of the points (n, 3), dorsal, distal, ulnar from the bone's end, that belong to the nail.

    `tip`: soft tissue, thickness, width.
    """
    tissue, thick, _ = tip
    middle = tissue - 0.5 * thick
    long, wide = 0.48 * thick, 0.36 * thick
    inside = ((own[:, 1] - middle) / long) ** 4 + (own[:, 2] / wide) ** 4 < 1.0
    return np.asarray(inside & (own[:, 0] > 0.0))


def _faded(surface: Surface, near: Array) -> Surface:
    """Table that is opaque about a point `near` (3,), seen from above, and fades out around it."""
    far = np.linalg.norm((surface.vertices - near)[:, :2], axis=1)
    colours = surface.colours.copy()
    colours[:, 3] = np.clip((_LAST_M - far) / (_LAST_M - _FIRST_M), 0.0, 1.0)
    return replace(surface, colours=colours)


Instants = NDArray[np.int64]
ESTIMATE: Colour = (0.835, 0.369, 0.0)
"""Colour of estimates in every figure (Okabe and Ito's vermilion)."""
_ESTIMATE_ALPHA = 0.38
_TIPS = [4, 7, 10, 13, 16]
_FOREARM_SHOWN, _MARGIN_M, _EDGE_M = 0.4, 0.024, 0.008
"""Share of the forearm that is shown; margin for the flesh about the bones; width of the fading edge, m."""
_NEAR = 1.4
"""Distance from the wrist, in hand lengths, beyond which a dropped object is left out of the frame."""
_PANEL_PX, _FINER, _DPI = 500, 2, 200
"""Longer side of a panel, pixels; samples per side of a pixel; pixels per inch."""
_LONGEST_ROW = 5
_LETTER_IN, _LINE_IN = 0.083, 0.17
"""Width of a letter and height of a line of the heading at 10 points, inches."""


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Hand as a tracker estimates it: posture, name of the tracker, segment aligned with the truth."""

    posture: Posture
    tracker: str
    laid_at: str

    @property
    def caption(self) -> str:
        """Entry of the picture's key."""
        return f"■ estimate of {self.tracker}, aligned with the true {self.laid_at}"


def hand_figure(
    truth: Posture, at_ns: Instants, solids: Sequence[Sequence[Solid]], estimate: Estimate | None, title: str
) -> Figure:
    """Figure of the hand at several instants, side by side, from one camera and in one scale."""
    from matplotlib.figure import Figure

    camera = view_of(truth, any(not solid.fades for each in solids for solid in each))
    low, high = framed(truth, camera, solids)
    pixel = float((high - low).max()) / _PANEL_PX
    rows = -(-len(at_ns) // _LONGEST_ROW)
    columns = -(-len(at_ns) // rows)
    width, height = (high - low) / pixel / _DPI
    lines = head_lines(title, "" if estimate is None else estimate.caption, columns * width)
    head, foot = 0.43 + _LINE_IN * len(lines), 0.12
    figure = Figure(figsize=(columns * width + 0.2, rows * (height + 0.25) + head + foot), dpi=_DPI)
    grid = figure.subplots(rows, columns, squeeze=False, gridspec_kw={
        "left": 0.1 / figure.get_figwidth(), "right": 1.0 - 0.1 / figure.get_figwidth(),
        "bottom": foot / figure.get_figheight(), "top": 1.0 - head / figure.get_figheight(),
        "wspace": 0.0, "hspace": 0.25 / height})
    for axes in grid.flat:
        axes.set_axis_off()
    for i, (axes, now) in enumerate(zip(grid.flat, at_ns, strict=False)):
        picture = panel(truth, i, Frame(camera, low, high, pixel / _FINER), solids[i], estimate)
        axes.imshow(picture, extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased")
        axes.text(0.5, 1.0, f"{now / NS_PER_S:.2f} s", transform=axes.transAxes, ha="center", va="bottom",
                  fontsize=11)
    _scale_bar(grid[-1, 0], low)
    for number, (line, is_title) in enumerate(lines):
        top = 1.0 - (0.1 + _LINE_IN * number) / figure.get_figheight()
        figure.text(0.1 / figure.get_figwidth(), top, line, va="top",
                    fontsize=10 if is_title else 9, color="0.15" if is_title else ESTIMATE)
    return figure


def head_lines(title: str, caption: str, width_in: float) -> list[tuple[str, bool]]:
    """Lines of the heading, wrapped to a width in inches, with whether each belongs to the title."""
    room = int(width_in / _LETTER_IN)
    return [(line, True) for line in wrap(title, room)] + [(line, False) for line in wrap(caption, room)]


def view_of(truth: Posture, holding: bool) -> Camera:
    """Camera for all instants: from the back of the hand, or from the palm if the hand may hold an object."""
    poses, out = truth.poses, truth.size.outwards
    finite = truth.finite
    points = (poses.position - poses.position[:, :1])[finite]
    palm = poses.orientation[finite][:, 1]
    dorsal, radial = (quaternion.rotate(palm, axis).mean(axis=0)
                      for axis in ((out, 0.0, 0.0), (0.0, 0.0, -out)))
    liked = 0.8 * radial + (-0.6 if holding else 0.6) * dorsal
    return best_view(points, points[:, _TIPS], liked)


def framed(truth: Posture, camera: Camera, solids: Sequence[Sequence[Solid]]) -> tuple[Array, Array]:
    """Corners (2,), m, relative to the wrist, of a frame around hand and nearby objects at all instants."""
    place = truth.poses.position[truth.finite]
    wrist = place[:, :1]
    seen = [camera.seen(place - wrist)[..., :2].reshape(-1, 2)]
    elbow = quaternion.rotate(truth.poses.orientation[truth.finite][:, 0],
                              [0.0, -truth.size.outwards * _FOREARM_SHOWN * truth.size.forearm, 0.0])
    seen.append(camera.seen(elbow)[:, :2])
    reach = 1e-3 * truth.size.hand_mm
    for each in solids:
        for solid in each:
            if not solid.fades and np.linalg.norm(solid.position) < _NEAR * reach:
                corner = np.abs(quaternion.to_matrix(solid.orientation)) @ solid.half
                about = np.stack([solid.position - corner, solid.position + corner])
                seen.append(camera.seen(about)[:, :2])
    every = np.concatenate(seen)
    return every.min(axis=0) - _MARGIN_M, every.max(axis=0) + _MARGIN_M


def panel(truth: Posture, i: int, frame: Frame, solids: Sequence[Solid], estimate: Estimate | None) -> Array:
    """Picture (rows, columns, 4) of one instant; empty where its posture is not finite."""
    if not truth.finite[i]:
        return np.zeros((1, 1, 4))
    poses, camera = truth.at(i), frame.camera
    wrist = poses.position[0]
    local = poses._replace(position=poses.position - wrist)
    shape = flesh(truth.size, local)
    middle = local.position[[1, 10]].mean(axis=0)

    def distances(points: Array) -> Array:
        found = [flesh_distances(points, shape), *(solid.distances(points) for solid in solids)]
        return np.asarray(np.min(found, axis=0))

    skin = hand_surface_of(shape, local, truth.size, _FOREARM_SHOWN * truth.size.forearm)
    scene = [skin, *(_faded(solid_surface(each), middle) if each.fades else solid_surface(each)
                     for each in solids)]
    lines = [each.outline(camera) for each in scene]
    scene = [each.facing(camera).lit(camera, distances) for each in scene]
    picture = painted(frame, [*scene, *lines])
    if estimate is not None and estimate.posture.finite[i]:
        picture = over(picture, _ghost(estimate.posture, i, wrist, frame, scene))
    return vignetted(picture, round(_EDGE_M / frame.pixel_m))


def _ghost(posture: Posture, i: int, wrist: Array, frame: Frame, scene: Sequence[Surface]) -> Array:
    """Translucent picture of an estimated hand, fainter where the scene hides it."""
    poses = posture.at(i)
    shape = flesh(posture.size, poses._replace(position=poses.position - wrist), forearm=False)
    mesh = hand_surface(shape, _CELL_M)
    colours = np.tile([*ESTIMATE, 1.0], (len(mesh.vertices), 1))
    hand = Surface(mesh.vertices, np.zeros_like(mesh.vertices), mesh.faces.astype(np.int64), colours)
    # Where both hands coincide the true one is in front: otherwise sorting would mix their triangles.
    hand = hand.moved(2.0 * BIAS_M * frame.camera.along)
    parts = [(hand.facing(frame.camera), _ESTIMATE_ALPHA), (hand.outline(frame.camera, ESTIMATE, 1.0), 1.0)]
    found = np.zeros((*frame.shape, 4))
    found[..., :3] = ESTIMATE
    for surface, alpha in parts:
        whole = painted(frame, [surface])[..., 3]
        hidden = [replace(each, colours=each.colours * (0.0, 0.0, 0.0, 1.0)) for each in scene]
        white = replace(surface, colours=np.ones_like(surface.colours))
        ahead = painted(frame, [*hidden, white])
        cover = alpha * whole * (_HIDDEN + (1.0 - _HIDDEN) * ahead[..., 0])
        found[..., 3] = np.maximum(found[..., 3], cover)
    return found


def _scale_bar(axes: Axes, low: Array) -> None:
    """Draw a scale bar of 5 cm."""
    x, y = low + 0.006
    axes.plot([x, x + 0.05], [y, y], color="0.15", linewidth=2.0, solid_capstyle="butt", clip_on=False)
    axes.text(x + 0.025, y + 0.002, "5 cm", ha="center", va="bottom", fontsize=8, color="0.15")

"""The picture of the hand: a strip of postures as recorded, the tracker's estimate laid over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.camera import Camera, best_view
from fesloop.show.picture.flesh import Flesh, flesh
from fesloop.show.picture.posture import Posture
from fesloop.show.picture.render import Colour, Frame, Solid, Traced, over, shaded, smaller, traced, vignetted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
_SKIN: Colour = (0.93, 0.80, 0.71)
_NAIL: Colour = (0.97, 0.88, 0.84)
_FIRST_M, _LAST_M = 0.08, 0.15
"""From where to where a table fades, m from the hand."""
_FADED = 0.55
"""Share of the shown forearm from which it fades."""


def skin_colours(
    found: Traced, frame: Frame, flesh: Flesh, poses: Poses, size: HandSize, others: Sequence[Colour]
) -> Array:
    """Colour of each pixel's surface before it is lit, (rows, columns, 3)."""
    table = np.array([_SKIN, *others])
    colours = table[np.clip(found.surface, 0, None)]
    points = frame.points(found.depth)
    for i, segment in enumerate(range(4, 17, 3)):
        there = (found.surface == 0) & (flesh.segments[found.bar] == segment)
        own = quaternion.rotate(quaternion.conjugate(poses.orientation[segment]),
                                points[there] - poses.position[segment])
        colours[there] = np.where(_on_nail(own * size.outwards, size.tips[i])[:, np.newaxis], _NAIL,
                                  colours[there])
    return colours


def _on_nail(own: Array, tip: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3), dorsal, distal, ulnar from the bone's end, are under the nail.

    `tip`: soft tissue, thickness, width.
    """
    tissue, thick, _ = tip
    middle = tissue - 0.5 * thick
    long, wide = 0.48 * thick, 0.36 * thick
    inside = ((own[:, 1] - middle) / long) ** 4 + (own[:, 2] / wide) ** 4 < 1.0
    return np.asarray(inside & (own[:, 0] > 0.0))


def faded_solids(picture: Array, found: Traced, frame: Frame, solids: Sequence[Solid], near: Array) -> Array:
    """The picture with solids that fade drawn only about a point `near` (3,), seen from above."""
    faded = picture.copy()
    for number, solid in enumerate(solids):
        if solid.fades:
            there = found.surface == number + 1
            far = np.linalg.norm((frame.points(found.depth)[there] - near)[:, :2], axis=1)
            faded[there, 3] *= np.clip((_LAST_M - far) / (_LAST_M - _FIRST_M), 0.0, 1.0)
    return faded


def faded_forearm(
    picture: Array, found: Traced, frame: Frame, flesh: Flesh, poses: Poses, shown_m: float
) -> Array:
    """The picture with the forearm fading into nothing towards `shown_m` from the wrist."""
    there = (found.surface == 0) & (flesh.segments[found.bar] == 0)
    own = quaternion.rotate(quaternion.conjugate(poses.orientation[0]),
                            frame.points(found.depth)[there] - poses.position[0])
    share = np.abs(own[:, 1]) / shown_m
    faded = picture.copy()
    faded[there, 3] *= np.clip((1.0 - share) / (1.0 - _FADED), 0.0, 1.0)
    return faded


Instants = NDArray[np.int64]
ESTIMATE: Colour = (0.835, 0.369, 0.0)
"""The trackers' in every figure (Okabe and Ito's vermilion)."""
_ESTIMATE_ALPHA = 0.38
_TIPS = [4, 7, 10, 13, 16]
_FOREARM_SHOWN, _MARGIN_M, _EDGE_M = 0.4, 0.024, 0.008
"""Share of the forearm that is shown; room about the bones for the flesh; where the picture's edge fades."""
_NEAR = 1.4
"""What is farther from the wrist than this, in hand lengths, has been dropped and is not kept in sight."""
_PANEL_PX, _FINER, _DPI = 500, 2, 200
"""Longer side of a panel; rays a pixel's side; pixels an inch."""
_LONGEST_ROW = 5
_LETTER_IN, _LINE_IN = 0.083, 0.17
"""Room that a letter and a line of the head take, inches (of 10 points: a letter is some 0.6 as wide)."""


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A tracker's hand: its posture, the tracker's name, and the segment at which it is laid on."""

    posture: Posture
    tracker: str
    laid_at: str

    @property
    def caption(self) -> str:
        """What of the picture it is, in words."""
        return f"■ estimate of {self.tracker}, laid onto the true {self.laid_at}"


def hand_figure(
    truth: Posture, at_ns: Instants, solids: Sequence[Sequence[Solid]], estimate: Estimate | None, title: str
) -> Figure:
    """The hand at some instants side by side, from one camera, in one scale."""
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
    """Lines over the pictures, with whether each is the title's: as many as the width, inches, asks for."""
    room = int(width_in / _LETTER_IN)
    return [(line, True) for line in wrap(title, room)] + [(line, False) for line in wrap(caption, room)]


def view_of(truth: Posture, holding: bool) -> Camera:
    """One camera for all instants: from the back of the hand, or from the palm if it may hold something."""
    poses, out = truth.poses, truth.size.outwards
    finite = truth.finite
    points = (poses.position - poses.position[:, :1])[finite]
    palm = poses.orientation[finite][:, 1]
    dorsal, radial = (quaternion.rotate(palm, axis).mean(axis=0)
                      for axis in ((out, 0.0, 0.0), (0.0, 0.0, -out)))
    liked = 0.8 * radial + (-0.6 if holding else 0.6) * dorsal
    return best_view(points, points[:, _TIPS], liked)


def framed(truth: Posture, camera: Camera, solids: Sequence[Sequence[Solid]]) -> tuple[Array, Array]:
    """Corners (2,) and (2,), m, from the wrist, that hold the hand at all instants, and what is near it."""
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
    """One instant, (rows, columns, 4); nothing where its posture is not finite."""
    if not truth.finite[i]:
        return np.zeros((1, 1, 4))
    poses = truth.at(i)
    wrist = poses.position[0]
    local = poses._replace(position=poses.position - wrist)
    body = flesh(truth.size, local)
    found = traced(frame, body, solids)
    colours = skin_colours(found, frame, body, local, truth.size, [solid.colour for solid in solids])
    picture = shaded(found, frame.camera, colours)
    if estimate is not None and estimate.posture.finite[i]:
        ghost = _ghost(estimate.posture, i, wrist, frame)
        picture = over(picture, found, ghost, ESTIMATE, _ESTIMATE_ALPHA)
    middle = local.position[[1, 10]].mean(axis=0)
    picture = faded_solids(picture, found, frame, solids, middle)
    shown = faded_forearm(picture, found, frame, body, local, _FOREARM_SHOWN * truth.size.forearm)
    return smaller(vignetted(shown, round(_EDGE_M / frame.pixel_m)), _FINER)


def _ghost(posture: Posture, i: int, wrist: Array, frame: Frame) -> Traced:
    poses = posture.at(i)
    body: Flesh = flesh(posture.size, poses._replace(position=poses.position - wrist), forearm=False)
    return traced(frame, body, (), shading=False)


def _scale_bar(axes: Axes, low: Array) -> None:
    """Five centimetres."""
    x, y = low + 0.006
    axes.plot([x, x + 0.05], [y, y], color="0.15", linewidth=2.0, solid_capstyle="butt", clip_on=False)
    axes.text(x + 0.025, y + 0.002, "5 cm", ha="center", va="bottom", fontsize=8, color="0.15")

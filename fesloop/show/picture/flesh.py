"""Shape of the hand in pictures: tapered round bars about the bones, and distances of points to their skin.

The shape is for display only. Thicknesses follow the contact skin of the `hand` plant, so that a fingertip
that touches in the picture touches in the simulation. Bars blend by Quilez's quadratic smooth minimum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.hand.skeleton import hand_tree

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_KNUCKLES = (4.0 / 3.0, 7.0 / 6.0, 1.0, 0.9)
"""Radius of a digit at each of its joints, relative to half the thickness of its tip: as in the `hand` plant,
the last a little less (chosen)."""
_THENAR, _HYPOTHENAR, _PALM, _CARPUS, _ELBOW = 0.085, 0.068, 0.066, 0.098, 0.2
"""Radii relative to hand length: thenar, hypothenar, palm, wrist, forearm's belly (chosen by eye and the
proportions of the `hand` plant's palm)."""
_PALM_DEPTH = 0.032
"""Palmar distance of the palm's middle from its bones, relative to hand length: half the palm's thickness
less the tissue over the bones."""
_BELLY = 0.62
"""Position of the thickest part of the forearm, as a share of the way to the elbow (chosen)."""
_FINGER_BLEND, _PALM_BLEND = 0.004, 0.016
"""Distance within which surfaces blend, m: along a finger, and in the palm (chosen)."""


class Flesh(NamedTuple):
    """Shape of a hand in space.

    Attributes
    ----------
    bars: (n, 8), m: both ends of each round bar, then the radii at its ends.
    groups: (n,), ascending: bars of one group blend, bars of different groups intersect.
    blends: distance within which the bars of each group blend, m.
    segments: (n,), index of the segment that each bar belongs to, in the tree's order.
    """

    bars: Array
    groups: Numbers
    blends: Array
    segments: Numbers


def bone_ends(size: HandSize, poses: Poses) -> tuple[Array, Array]:
    """Proximal and distal ends (17, 3) of the bones in one posture; the forearm begins at the elbow."""
    offsets = hand_tree(size).geometry[:, 4].copy()
    offsets[0] = [0.0, size.outwards * size.forearm, 0.0]
    return poses.position - quaternion.rotate(poses.orientation, offsets), poses.position


def flesh(size: HandSize, poses: Poses, forearm: bool = True) -> Flesh:
    """Shape of a hand in one posture, from the poses (17,) of its segments, with or without its forearm."""
    palm = _palm_bars(size)
    groups = [(palm, _PALM_BLEND)]
    groups += [([palm[i], *_digit_bars(size, i)], _FINGER_BLEND) for i in range(5)]
    if forearm:
        groups.append(([*_forearm_bars(size), *palm[1:5]], _PALM_BLEND))
    rows = [bar for bars, _ in groups for bar in bars]
    segments = np.array([segment for segment, _, _ in rows])
    ends = np.array([(start, end) for _, start, end in rows])
    turned = quaternion.rotate(poses.orientation[segments, np.newaxis], ends[..., :3])
    placed = poses.position[segments, np.newaxis] + turned
    return Flesh(np.concatenate([placed.reshape(-1, 6), ends[..., 3]], axis=1),
                 np.repeat(np.arange(len(groups)), [len(bars) for bars, _ in groups]),
                 np.array([blend for _, blend in groups]), segments)


_End = tuple[float, float, float, float]
_Bar = tuple[int, _End, _End]
"""Index of a segment; both ends of a bar in the segment's frame, with the radii."""


def _in_frame(size: HandSize, dorsal: float, distal: float, ulnar: float, radius: float) -> _End:
    out = size.outwards
    return out * dorsal, out * distal, out * ulnar, radius


def _palm_bars(size: HandSize) -> list[_Bar]:
    """Bars of the thumb's metacarpal, the metacarpals of F2 to F5, and the hypothenar."""
    whole, centres = 1e-3 * size.hand_mm, size.first_joints
    palm, deep = float(centres[2, 0]), -_PALM_DEPTH * whole
    knuckle = _KNUCKLES[0] * 0.5 * size.tips[:, 1]
    thumb = float(size.segments[0, 0])
    bars: list[_Bar] = [(2, _in_frame(size, 0.0, 0.1 * thumb - thumb, 0.0, 0.8 * _THENAR * whole),
                         _in_frame(size, 0.0, 0.0, 0.0, float(knuckle[0])))]
    for i in range(1, 5):
        distal, ulnar = centres[i]
        bars.append((1, _in_frame(size, 0.4 * deep, 0.06 * whole - palm, 0.45 * ulnar, _PALM * whole),
                     _in_frame(size, 0.45 * deep, distal - palm, ulnar, 1.12 * float(knuckle[i]))))
    ulnar = float(centres[4, 1])
    bars.append((1, _in_frame(size, 1.1 * deep, 0.1 * palm - palm, 0.5 * ulnar, _HYPOTHENAR * whole),
                 _in_frame(size, 1.1 * deep, 0.6 * palm - palm, 0.9 * ulnar, 0.9 * _HYPOTHENAR * whole)))
    distal, ulnar = centres[0]
    bars.append((1, _in_frame(size, 1.2 * deep, distal - palm, 0.5 * ulnar, _HYPOTHENAR * whole),
                 _in_frame(size, 1.1 * deep, 0.75 * palm - palm, 0.7 * centres[1, 1], 0.6 * _THENAR * whole)))
    return bars


def _digit_bars(size: HandSize, i: int) -> list[_Bar]:
    """Bars of the free segments of finger `i`, counted from 0: the thumb has two, other fingers three."""
    half = 0.5 * float(size.tips[i, 1])
    tissue = float(size.tips[i, 0])
    bars: list[_Bar] = []
    for j in range(1 if i == 0 else 0, 3):
        length = float(size.segments[i, j])
        near, far = half * _KNUCKLES[j], half * _KNUCKLES[j + 1]
        # The skin ends beyond the bone by the thickness of the soft tissue.
        end = tissue - far if j == 2 else 0.0
        bars.append((2 + 3 * i + j, _in_frame(size, 0.0, -length, 0.0, near),
                     _in_frame(size, 0.0, end, 0.0, far)))
    return bars


def _forearm_bars(size: HandSize) -> list[_Bar]:
    """Bars of both forearm bones: from the wrist to the belly, and from the belly to the elbow."""
    whole, length = 1e-3 * size.hand_mm, size.forearm
    deep = -0.4 * _PALM_DEPTH * whole
    bars: list[_Bar] = []
    for side in (-1.0, 1.0):
        wrist = _in_frame(size, deep, 0.0, side * 0.055 * whole, _CARPUS * whole)
        belly = _in_frame(size, deep, -_BELLY * length, side * 0.06 * whole, 0.9 * _ELBOW * whole)
        elbow = _in_frame(size, deep, -length, side * 0.06 * whole, 0.8 * _ELBOW * whole)
        bars += [(0, wrist, belly), (0, belly, elbow)]
    return bars


Point = tuple[float, float, float]
_FAR_M = 1e3


@compiled
def _bar_distance(p: Point, bar: Array) -> float:
    """Signed distance from a point to a bar's skin, m, negative inside."""
    ax, ay, az = p[0] - bar[0], p[1] - bar[1], p[2] - bar[2]
    bx, by, bz = bar[3] - bar[0], bar[4] - bar[1], bar[5] - bar[2]
    square = bx * bx + by * by + bz * bz
    share = min(1.0, max(0.0, (ax * bx + ay * by + az * bz) / square)) if square > 0.0 else 0.0
    x, y, z = ax - share * bx, ay - share * by, az - share * bz
    return float(math.sqrt(x * x + y * y + z * z) - bar[6] - share * (bar[7] - bar[6]))


@compiled
def blended(a: float, b: float, reach: float) -> float:
    """Smooth minimum of two distances; the plain minimum where they differ by more than `reach`."""
    overlap = max(reach - abs(a - b), 0.0) / reach
    return min(a, b) - 0.25 * reach * overlap * overlap


@compiled
def _flesh_distances(points: Array, bars: Array, groups: Numbers, blends: Array) -> Array:
    """Signed distances (n,) from points (n, 3) to the skin, m."""
    distances = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        p = (points[i, 0], points[i, 1], points[i, 2])
        least, of_group, group = _FAR_M, _FAR_M, -1
        for bar in range(bars.shape[0]):
            distance = _bar_distance(p, bars[bar])
            if groups[bar] == group:
                of_group = blended(of_group, distance, blends[group])
            else:
                least = min(least, of_group)
                group, of_group = groups[bar], distance
        distances[i] = min(least, of_group)
    return distances


@compiled
def _nearest_bars(points: Array, bars: Array) -> Numbers:
    """Index (n,) of the bar nearest to each point (n, 3)."""
    found = np.zeros(points.shape[0], dtype=np.int64)
    for i in range(points.shape[0]):
        p = (points[i, 0], points[i, 1], points[i, 2])
        least = _FAR_M
        for bar in range(bars.shape[0]):
            distance = _bar_distance(p, bars[bar])
            if distance < least:
                least, found[i] = distance, bar
    return found


def flesh_distances(points: Array, shape: Flesh) -> Array:
    """Signed distances (n,) from points (n, 3) to the skin, m, negative inside."""
    distances: Array = _flesh_distances(points, shape.bars, shape.groups, shape.blends)
    return distances


def nearest_segments(points: Array, shape: Flesh) -> Numbers:
    """Index (n,) of the segment whose flesh is nearest to each point (n, 3)."""
    return np.asarray(shape.segments[_nearest_bars(points, shape.bars)])

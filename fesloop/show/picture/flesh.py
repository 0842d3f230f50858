"""The shape of a drawn hand: tapered round bars about the bones, blended where flesh is one.

A picture's shape and no more: nothing is computed from it. Thicknesses follow the skin that the `hand` plant
touches with, so that what is drawn to touch did touch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.hand.skeleton import hand_tree

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_KNUCKLES = (4.0 / 3.0, 7.0 / 6.0, 1.0, 0.9)
"""Radius of a digit at its joints from the first on over half the thickness of its tip; the `hand` plant's,
and at the end a little less (chosen)."""
_THENAR, _HYPOTHENAR, _PALM, _CARPUS, _ELBOW = 0.085, 0.068, 0.066, 0.098, 0.2
"""Radii over hand length: of the balls of thumb and little finger, the palm, the wrist, the forearm's belly
(chosen by eye and the proportions of the `hand` plant's palm)."""
_PALM_DEPTH = 0.032
"""How far the palm's middle lies on the palmar side of its bones, over hand length: half its thickness less
what covers the bones."""
_BELLY = 0.62
"""Where the forearm is thickest, of the way to the elbow (chosen)."""
_FINGER_BLEND, _PALM_BLEND = 0.004, 0.016
"""How far apart surfaces begin to flow into one another, m: along a finger, and in the palm (chosen)."""


class Flesh(NamedTuple):
    """A drawn hand in space.

    Attributes
    ----------
    bars: (n, 8), m: both ends and the radii there, of the round bars.
    groups: (n,), increasing: bars of one group blend, those of different groups only meet.
    blends: how far apart the bars of each group begin to blend, m.
    segments: (n,), the segment that each bar is the flesh of, in the tree's order.
    """

    bars: Array
    groups: Numbers
    blends: Array
    segments: Numbers


def bone_ends(size: HandSize, poses: Poses) -> tuple[Array, Array]:
    """Proximal and distal ends (17, 3) of the bones at one posture; the forearm's from the elbow."""
    offsets = hand_tree(size).geometry[:, 4].copy()
    offsets[0] = [0.0, size.outwards * size.forearm, 0.0]
    return poses.position - quaternion.rotate(poses.orientation, offsets), poses.position


def flesh(size: HandSize, poses: Poses, forearm: bool = True) -> Flesh:
    """The hand at one posture, poses (17,) of its segments; without its forearm where that is not wanted."""
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
"""Segment, and in its frame both ends and the radii there."""


def _in_frame(size: HandSize, dorsal: float, distal: float, ulnar: float, radius: float) -> _End:
    out = size.outwards
    return out * dorsal, out * distal, out * ulnar, radius


def _palm_bars(size: HandSize) -> list[_Bar]:
    """The thumb's metacarpal, those of F2 to F5, and the ball of the little finger."""
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
    """The free segments of finger `i` from 0 on: of the thumb two, of the others three."""
    half = 0.5 * float(size.tips[i, 1])
    tissue = float(size.tips[i, 0])
    bars: list[_Bar] = []
    for j in range(1 if i == 0 else 0, 3):
        length = float(size.segments[i, j])
        near, far = half * _KNUCKLES[j], half * _KNUCKLES[j + 1]
        # The skin of the tip ends as far beyond the bone as soft tissue is thick.
        end = tissue - far if j == 2 else 0.0
        bars.append((2 + 3 * i + j, _in_frame(size, 0.0, -length, 0.0, near),
                     _in_frame(size, 0.0, end, 0.0, far)))
    return bars


def _forearm_bars(size: HandSize) -> list[_Bar]:
    """Both bones from the wrist to the forearm's belly, and from there to the elbow."""
    whole, length = 1e-3 * size.hand_mm, size.forearm
    deep = -0.4 * _PALM_DEPTH * whole
    bars: list[_Bar] = []
    for side in (-1.0, 1.0):
        wrist = _in_frame(size, deep, 0.0, side * 0.055 * whole, _CARPUS * whole)
        belly = _in_frame(size, deep, -_BELLY * length, side * 0.06 * whole, 0.9 * _ELBOW * whole)
        elbow = _in_frame(size, deep, -length, side * 0.06 * whole, 0.8 * _ELBOW * whole)
        bars += [(0, wrist, belly), (0, belly, elbow)]
    return bars

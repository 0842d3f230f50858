"""The hand as a segment tree: 17 segments, 23 degrees of freedom (doi 10.3390/s19010208, section 2.2).

Frames after the ISB (doi 10.1016/j.jbiomech.2004.05.042), on both sides + for flexion about z, ulnar
deviation about x and pronation about y: left x dorsal, y distal, z ulnar; right x palmar, y proximal,
z radial, so that bones lie along -y. The reference frame of a forearm left at its place is the wrist
coordinate system (WCS): origin at the wrist's centre, y along the middle finger when the wrist is neutral.
A forearm bone that is not quite parallel to it is a matter of how its sensor is mounted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.segments import AXES, FREEDOMS, JointKind, Segment, SegmentTree, Vector

SALCHOW = "Salchow-Hoemmen 2019, doi 10.3390/s19010208, section 2.4.3: from anatomy texts, with tolerance"
TEXTBOOK = "Electronic Textbook of Hand Surgery, e-hand.com: typical range of motion"
CHOSEN_DEVIATION = ("20 of abduction (clinical norm, gpnotebook.com) and a chosen tolerance of 15, by which "
                    "fingers at rest lie off the palm's middle line (An and Cooney 1991)")
CHOSEN_THUMB = ("chosen: 45 of palmar and 60 of radial abduction (e-hand.com) with a tolerance of 15; "
                "pronation 22 beyond the 88 in which Sancho-Bru 2012 has the thumb at rest")


class Range(NamedTuple):
    """Lowest and highest angle, degrees, and where they come from."""

    low_deg: float
    high_deg: float
    source: str


RANGES: dict[str, tuple[Range, ...]] = {
    "wrist": (Range(-70.0, 75.0, TEXTBOOK), Range(-20.0, 35.0, TEXTBOOK)),
    "thumb_cmc": (Range(-25.0, 60.0, CHOSEN_THUMB), Range(-75.0, 15.0, CHOSEN_THUMB),
                  Range(-30.0, 110.0, CHOSEN_THUMB)),
    "thumb_mcp": (Range(-10.0, 55.0, TEXTBOOK),),
    "thumb_ip": (Range(-15.0, 80.0, TEXTBOOK),),
    "mcp": (Range(-45.0, 90.0, TEXTBOOK), Range(-35.0, 35.0, CHOSEN_DEVIATION)),
    "pip": (Range(-20.0, 100.0, SALCHOW),),
    "dip": (Range(-20.0, 100.0, SALCHOW),),
}
"""By joint: flexion, then abduction, then pronation, as far as the joint has them."""


def radians(joint: str) -> tuple[tuple[float, float], ...]:
    """Ranges of a joint of the table, rad."""
    return tuple((float(np.deg2rad(row.low_deg)), float(np.deg2rad(row.high_deg))) for row in RANGES[joint])


Array = NDArray[np.float64]
_Chain = tuple[tuple[str, str, JointKind, str], ...]

_THUMB: _Chain = (("m", "cmc", "ball", "thumb_cmc"), ("p", "mcp", "hinge", "thumb_mcp"),
                  ("d", "ip", "hinge", "thumb_ip"))
_FINGER: _Chain = (("p", "mcp", "saddle", "mcp"), ("m", "pip", "hinge", "pip"), ("d", "dip", "hinge", "dip"))
"""Segment, joint, its kind, its row in the table of ranges."""
CONTACTS = ("tip", "bottom", "top", "left", "right", "distal")
"""Points on a fingertip: the bone's end, and on the skin the palmar, dorsal, left, right and distal one."""


def hand_tree(size: HandSize) -> SegmentTree:
    """Forearm, hand, then F1m F1p F1d and F2p F2m F2d to F5d, each frame at the segment's distal end."""
    sign = size.outwards
    centres, lengths = size.first_joints, size.segments
    palm = float(centres[2, 0])
    segments = [
        Segment(name="forearm"),
        Segment(
            name="hand", parent="forearm", joint="saddle", joint_name="wrist",
            offset=(0.0, sign * palm, 0.0), axes=_tilted(size, "hand", "saddle"), ranges=radians("wrist")),
    ]
    shifts = np.zeros((5, 3)) if size.joints_mm is None else 1e-3 * np.array(size.joints_mm)
    for i, finger in enumerate(FINGERS):
        # The hand's frame is at the middle finger's MCP joint.
        place = shifts[i] + [0.0, centres[i, 0] - palm, centres[i, 1]]
        base = vector_of(sign * place + 0.0)
        parent = "hand"
        for length, (letter, joint, kind, row) in zip(lengths[i], _THUMB if i == 0 else _FINGER, strict=True):
            name = f"{finger}{letter}"
            segments.append(Segment(
                name=name, parent=parent, joint=kind, joint_name=f"{finger}_{joint}", base=base,
                offset=(0.0, sign * float(length), 0.0), axes=_tilted(size, name, kind),
                ranges=radians(row)))
            parent, base = name, (0.0, 0.0, 0.0)
    return SegmentTree(tuple(segments))


def _tilted(size: HandSize, name: str, joint: JointKind) -> tuple[Vector, ...]:
    """Axes of a segment's joint, tilted as `size` says; empty: the usual ones."""
    tilt = np.deg2rad(size.axes_deg.get(name, (0.0, 0.0, 0.0)))
    angle = float(np.linalg.norm(tilt))
    if angle == 0.0:
        return ()
    turn = quaternion.from_axis_angle(tilt / angle, angle)
    return tuple(vector_of(row) for row in quaternion.rotate(turn, np.array(AXES[:FREEDOMS[joint]])))


def vector_of(row: Array) -> Vector:
    """A vector as three plain numbers."""
    x, y, z = (float(each) for each in row)
    return x, y, z


def pairs_of_names(names: Sequence[str]) -> tuple[tuple[int, int], ...]:
    """(parent, child) of sensors that are all named after segments of the hand; none of others."""
    tree = hand_tree(HandSize())
    if not all(name in tree.names for name in names):
        return ()
    parents = {segment.name: segment.parent for segment in tree.segments}
    pairs = []
    for child, name in enumerate(names):
        parent = parents[name]
        while parent is not None and parent not in names:
            parent = parents[parent]
        if parent is not None:
            pairs.append((names.index(parent), child))
    return tuple(pairs)


def contact_points(size: HandSize) -> Array:
    """Points (5, 6, 3), m, listed by `CONTACTS`, of fingers F1 to F5 in the frames of their distal segments.

    As in figure 10 of doi 10.3390/s19010208: half the thickness below and above the bone's end, half the
    width beside it, soft tissue beyond it. Left and right are those of one who looks at the back of the hand
    with the fingers pointing away.
    """
    tissue, thick, wide = size.tips.T
    dorsal, distal, ulnar = size.outwards * np.eye(3)
    # On the back of the left hand the little finger is on the left.
    left = np.outer(0.5 * wide, ulnar if size.side == "left" else -ulnar)
    top = np.outer(0.5 * thick, dorsal)
    return np.stack([np.zeros((5, 3)), -top, top, left, -left, np.outer(tissue, distal)], axis=1)


def dorsal_points(size: HandSize) -> Array:
    """Mounting points of sensors (17, 3), m, on the back of each segment's middle, in its own frame.

    The skin is half a fingertip's thickness above the bone, of forearm and hand as of the middle finger
    (chosen). The sensor of the forearm sits halfway to the elbow (chosen).
    """
    tree, back = hand_tree(size), np.array([size.outwards, 0.0, 0.0])
    halfway = 0.5 * tree.geometry[:, 4]
    halfway[0, 1] = 0.5 * size.outwards * size.forearm
    thick = size.tips[:, 1]
    above = np.concatenate([np.repeat(thick[2], 2), np.repeat(thick, 3)])
    return np.asarray(0.5 * above[:, np.newaxis] * back - halfway)


def contact_point(size: HandSize, finger: str, contact: str) -> Array:
    """One of these points, (3,), m; raises InputError for a name that does not exist."""
    for name, known, what in ((finger, FINGERS, "finger"), (contact, CONTACTS, "point of contact")):
        if name not in known:
            raise InputError(what, f"{name!r}", ", ".join(known), did_you_mean(name, known))
    point: Array = contact_points(size)[FINGERS.index(finger), CONTACTS.index(contact)]
    return point


FINGER_RESTS_DEG = {"F2": (25.0, 35.0, 15.0), "F3": (30.0, 38.0, 15.0), "F4": (33.0, 40.0, 15.0),
                    "F5": (35.0, 40.0, 15.0)}
"""MCP, PIP, DIP. Chosen: the usual cascade, more flexed towards the little finger."""
RESTING_DEG: dict[str, float] = {
    "wrist_flexion": 0.0, "wrist_abduction": 0.0,
    "F1_cmc_flexion": 40.0, "F1_cmc_abduction": -25.0, "F1_cmc_pronation": 70.0,
    "F1_mcp_flexion": 15.0, "F1_ip_flexion": 20.0,
    **{f"{finger}_{joint}": angle for finger, (mcp, pip, dip) in FINGER_RESTS_DEG.items()
       for joint, angle in (("mcp_flexion", mcp), ("mcp_abduction", 0.0), ("pip_flexion", pip),
                            ("dip_flexion", dip))},
}
"""By freedom, in the order of the hand's. Thumb: chosen, beside the index finger, its nail half turned."""

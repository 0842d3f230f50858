"""Axes of sensors compared with those of the hand segments that they are named after.

Only a layout or a calibration says how a sensor is rotated against its segment; without either its axes count
as the segment's. On both sides of a hinge the parts of the rates across its axis are equally large
(Olsson, Kok, Seel and Halvorsen 2020, doi 10.3390/s20123534), in whatever motion. Here all pairs of
directions are tried for that axis. Where none near the segments' own explains the rates, but others do, the
sensors' axes are not the segments'.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.pace import pace_of
from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]
_STEP_S = 0.025
"""Step over which rates are averaged (chosen: a finger turns little in it)."""
_MOST_STEPS = 4000
_LEAST_STEPS = 200
_BLOCKS = 10
_DIRECTIONS = 400
"""Directions of half a sphere, 7 deg apart."""
_NEAR = np.cos(np.radians(30.0))
"""Cosine of the angle within which a sensor's axis is taken for its segment's (chosen: three times the error
of mounting by eye, doi 10.3390/s19010208, section 4)."""
_SD_RAD_S, _SD_SHARE = 0.05, 0.15
"""Standard deviation of the difference of two rates: noise and bias, and a share of both for tissue and delay
(chosen)."""
_WRONG = 0.4
"""Mean squared residual, in variances, above which axes do not explain the rates (chosen)."""
_BETTER = 4.0
"""Least ratio of the residual to that of other axes that count as better (chosen)."""
_SHARE = 0.8
"""Least share of informative blocks that support the other axes (chosen)."""
_MOST_NAMED = 4


class HingeSeen(NamedTuple):
    """Axis of a hinge, estimated from the rates of its two sensors.

    Attributes
    ----------
    wrong: whether no axis near those of the segments explains the rates, and another one does.
    parent, child: (3,), unit vectors in the frames of the two sensors; the sign of the axis is not
        determined.
    """

    wrong: bool
    parent: Array
    child: Array


def _directions() -> Array:
    """Directions of half a sphere, evenly spread (a Fibonacci lattice), and the axes themselves."""
    number = np.arange(_DIRECTIONS) + 0.5
    z = 1.0 - number / _DIRECTIONS
    turn, across = np.pi * (1.0 + np.sqrt(5.0)) * number, np.sqrt(1.0 - z * z)
    return np.vstack([np.eye(3), np.column_stack([across * np.cos(turn), across * np.sin(turn), z])])


def hinge_seen(parent: Array, child: Array, axis: Array) -> HingeSeen:
    """The axis of a hinge whose segments both have it along `axis` (3,).

    Parameters
    ----------
    parent, child: (n, 3), rad/s, of the two sensors at the same instants, each in its own frame; no NaN.
    """
    directions = _directions()
    speed = np.linalg.norm(parent, axis=1) + np.linalg.norm(child, axis=1)
    weight = 1.0 / np.hypot(_SD_RAD_S, _SD_SHARE * speed)
    across = [np.linalg.norm(np.cross(rates[:, np.newaxis], directions), axis=2) * weight[:, np.newaxis]
              for rates in (parent, child)]
    cost = np.array([np.sum(a * a, axis=0)[:, np.newaxis] + np.sum(b * b, axis=0) - 2.0 * a.T @ b
                     for a, b in zip(*(np.array_split(each, _BLOCKS) for each in across), strict=True)])
    total = cost.sum(axis=0)
    near = np.flatnonzero(np.abs(directions @ axis) >= _NEAR)
    best = np.unravel_index(int(np.argmin(total)), total.shape)
    among = total[np.ix_(near, near)]
    own = near[list(np.unravel_index(int(np.argmin(among)), among.shape))]
    named, other = cost[:, own[0], own[1]], cost[:, best[0], best[1]]
    informative = named + other > _WRONG * len(parent) / _BLOCKS
    wrong = bool(named.sum() > _WRONG * len(parent) and named.sum() > _BETTER * other.sum()
                 and np.mean(named[informative] > other[informative]) >= _SHARE)
    return HingeSeen(wrong, directions[best[0]], directions[best[1]])


def mounting_text(recording: MotionRecording, first: int = 0, stop: int | None = None) -> str:
    """Text on hinges whose sensors have other axes than their segments, with a remedy; empty for none.

    Empty, too, where a sensor is not named after a segment of the hand.
    """
    if not set(recording.sensors) <= set(hand_tree(HandSize()).names):
        return ""
    gyr = _steps(recording, first, stop)
    hinges, names = [], []
    for parent, child, axis in _hinges(recording.sensors):
        rates = gyr[:, [parent, child]]
        rates = rates[np.isfinite(rates).all(axis=(1, 2))]
        rates = rates[::max(1, -(-len(rates) // _MOST_STEPS))]
        if len(rates) < _LEAST_STEPS:
            continue
        seen = hinge_seen(rates[:, 0], rates[:, 1], axis)
        if seen.wrong:
            pair = recording.sensors[parent], recording.sensors[child]
            names += [name for name in pair if name not in names]
            hinges.append(f"{pair[0]}-{pair[1]} turns about {_named(seen.parent)} of {pair[0]} and "
                          f"{_named(seen.child)} of {pair[1]}")
    if not hinges:
        return ""
    more = f" and {len(hinges) - _MOST_NAMED} joints more" if len(hinges) > _MOST_NAMED else ""
    which = ", ".join(names[:_MOST_NAMED]) + (" and others" if len(names) > _MOST_NAMED else "")
    return (f"axes of sensors are not those of their segments, which flex about z: "
            f"{', '.join(hinges[:_MOST_NAMED])}{more}: state which axes of {which} are the segment's x, y "
            "and z (`sensors.NAME.axes` in the layout), or calibrate (block `segment_calibration`)")


def _hinges(sensors: tuple[str, ...]) -> list[tuple[int, int, Array]]:
    """Parent, child and axis of each hinge of the hand that has a sensor on both sides."""
    return [(sensors.index(segment.parent), sensors.index(segment.name), segment.frame[0])
            for segment in hand_tree(HandSize()).segments
            if segment.joint == "hinge" and segment.name in sensors and segment.parent in sensors]


def _steps(recording: MotionRecording, first: int, stop: int | None) -> Array:
    """Rates averaged over short steps, (n, sensors, 3); NaN where a sample of a step is lost."""
    gyr = recording.gyr[first:stop]
    period_s = pace_of(recording.stamps_ns / NS_PER_S).period_s
    together = max(1, round(_STEP_S / period_s)) if period_s > 0.0 else 1
    count = len(gyr) // together
    return np.asarray(gyr[:count * together].reshape(count, together, -1, 3).mean(axis=1))


def _named(direction: Array) -> str:
    """The axis that a direction is near to, or its components."""
    largest = int(np.argmax(np.abs(direction)))
    if abs(direction[largest]) >= _NEAR:
        return "xyz"[largest]
    return "(" + ", ".join(f"{part:.1f}" for part in direction) + ")"

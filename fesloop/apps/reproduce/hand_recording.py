"""Reading of a moving hand's recording: times of phases, true and estimated poses."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment import registry
from fesloop.experiment.metrics.joints import held
from fesloop.experiment.recording.reading import Recording
from fesloop.forms.schema import build, make
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.kinematics import Poses, placed, segment_poses
from fesloop.hand.skeleton import contact_point, hand_tree
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
HAND = "hand"
"""Node of the plant in the shipped experiments."""


class Seen(NamedTuple):
    """Output of a tracker (n, ...) at its capture times, s, and the truth (n, ...) at the same times."""

    times_s: Array
    estimate: Array
    truth: Array


def plant_of(recording: Recording) -> Any:
    """Plant of the hand that moved."""
    return _plant(json.dumps(recording.experiment["blocks"][HAND], sort_keys=True))


@lru_cache(maxsize=8)
def _plant(block: str) -> Any:
    table = json.loads(block)
    return make(registry.find(table.pop("kind")), table, {}, f"blocks.{HAND}")


def size_of(recording: Recording, tracker: str) -> HandSize:
    """Size of the hand as given to a tracker."""
    return _size(json.dumps(recording.experiment["blocks"][tracker].get("hand", {}), sort_keys=True))


@lru_cache(maxsize=8)
def _size(table: str) -> HandSize:
    size: HandSize = build(HandSize, json.loads(table), {}, "hand")
    return size


def spans(recording: Recording, name: str) -> list[tuple[float, float]]:
    """Beginnings and ends of the phases with a name, s."""
    return [(float(start), float(stop)) for each, start, stop in plant_of(recording).spans if each == name]


def seen(recording: Recording, signal: str, truth: str, trial: int = 0) -> Seen:
    """Read a tracker's signal and the plant's at the same times."""
    told = recording.signal(signal, trial)
    known = told.newest_ns >= 0
    captured = told.newest_ns[known]
    true = held(recording.column(truth, trial), captured)
    return Seen(captured / NS_PER_S, told.values[known], true)


def within(rows: Seen, span: tuple[float, float]) -> Seen:
    """Select the part within a span of time."""
    inside = (rows.times_s >= span[0]) & (rows.times_s <= span[1])
    return Seen(*(column[inside] for column in rows))


def contact_points_of(size: HandSize, poses: Poses, contacts: tuple[str, ...]) -> Array:
    """Positions (n, contacts, 3), m, of points such as "F1 bottom" on a hand in poses (n, 17)."""
    tree = hand_tree(size)
    places = []
    for text in contacts:
        finger, _, point = text.partition(" ")
        k = tree.index(f"{FINGERS[FINGERS.index(finger)]}d")
        offset = contact_point(size, finger, point)
        places.append(poses.position[..., k, :] + quaternion.rotate(poses.orientation[..., k, :], offset))
    return np.stack(places, axis=-2)


def poses_by_angles(size: HandSize, angles: Array) -> Poses:
    """Poses (n, 17) of a hand by its joint angles (n, 23), in the wrist coordinate system."""
    return segment_poses(hand_tree(size), angles)


def poses_by_orientations(size: HandSize, orientation: Array) -> Poses:
    """Poses (n, 17) of a hand by its segments' orientations to earth (n, 17, 4), relative to the forearm."""
    forearm = orientation[:, :1]
    return placed(hand_tree(size), quaternion.relative(forearm, orientation))


def each_trial(recording: Recording) -> Iterator[int]:
    """Indices of the trials."""
    return iter(range(recording.trials))

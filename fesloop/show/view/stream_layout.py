"""What the channels of a live stream say of a hand: joint angles, or orientations of its segments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses, placed
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.show.picture.posture import posture_of_angles
from fesloop.streams.labels import factor
from fesloop.streams.live.description import Channel

Array = NDArray[np.float64]
_PosesOf = Callable[[Array], Poses]
_FINGER = {"MCP": "F2_mcp_flexion", "PIP": "F2_pip_flexion", "DIP": "F2_dip_flexion"}
_PARTS = "wxyz"
ALLOWED = ("channels named after the hand's freedoms (F2_mcp_flexion), MCP, PIP, DIP, or its segments "
           "(F2p w, F2p x, F2p y, F2p z); without names 23 angles, 3 of a finger, or 17 times w, x, y, z")


@dataclass(frozen=True, slots=True)
class StreamLayout:
    """How a sample becomes a hand.

    Attributes
    ----------
    poses_of: poses (17,) of a sample of all channels; NaN where that knows nothing.
    turns: whether the whole hand turns, or only its joints.
    """

    poses_of: _PosesOf
    turns: bool


def layout_of(channels: Sequence[Channel], count: int, size: HandSize, where: str) -> StreamLayout:
    """What a stream's channels are.

    Parameters
    ----------
    channels: as the stream describes them; () where it does not. Angles are rad where no unit is stated.
    count: how many there are.
    size: of the hand. where: the stream, for messages.

    Raises InputError for channels that are neither angles nor orientations of a hand.
    """
    freedoms, names = hand_tree(size).freedoms, hand_tree(size).names
    labels = [channel.label for channel in channels]
    if not any(label in freedoms or label in _FINGER or _segment(label) in names for label in labels):
        labels = _unnamed(count, size, where)
    labels = [_FINGER.get(label, label) for label in labels]
    _require_apart([label for label in labels if label in freedoms or _segment(label) in names], where)
    angles = {name: number for number, name in enumerate(labels) if name in freedoms}
    if angles:
        units = [channels[number].unit if channels else "" for number in angles.values()]
        factors = np.array([factor("angle", unit or "rad", f"{where}: unit") for unit in units])
        return StreamLayout(_of_angles(size, list(angles), np.array(list(angles.values())), factors), False)
    parts = {name: [labels.index(f"{name} {part}") if f"{name} {part}" in labels else -1 for part in _PARTS]
             for name in names}
    lacking = [name for name, numbers in parts.items() if min(numbers) < 0 <= max(numbers)]
    if lacking:
        raise InputError(where, f"lacks a part of the orientation of {lacking[0]}", "w, x, y, z of each")
    known = {name: numbers for name, numbers in parts.items() if min(numbers) >= 0}
    return StreamLayout(_of_orientations(size, known), True)


def _require_apart(labels: Sequence[str], where: str) -> None:
    """Raise InputError where two channels are the same part of a hand."""
    twice = [label for number, label in enumerate(labels) if label in labels[:number]]
    if twice:
        raise InputError(where, f"has {labels.count(twice[0])} channels of {twice[0]}", "one",
                         "give each a label of its own at the sender")


def _segment(label: str) -> str:
    """The segment whose orientation a channel is of; empty for another channel."""
    name, _, part = label.rpartition(" ")
    return name if len(part) == 1 and part in _PARTS else ""


def _unnamed(count: int, size: HandSize, where: str) -> list[str]:
    """Names by the number of channels."""
    tree = hand_tree(size)
    known = {len(tree.freedoms): list(tree.freedoms), len(_FINGER): list(_FINGER),
             4 * len(tree.names): [f"{name} {part}" for name in tree.names for part in _PARTS]}
    if count not in known:
        raise InputError(where, f"its {count} channels are not known to be of a hand", ALLOWED)
    return known[count]


def _of_angles(size: HandSize, names: Sequence[str], numbers: NDArray[np.int64], factors: Array) -> _PosesOf:
    """Other freedoms rest."""
    tree = hand_tree(size)
    resting = np.deg2rad([RESTING_DEG[name] for name in tree.freedoms])
    columns = [tree.freedom(name) for name in names]

    def poses(sample: Array) -> Poses:
        angles = resting.copy()
        angles[columns] = sample[numbers] * factors
        at = posture_of_angles(size, angles[np.newaxis]).poses
        return Poses(at.orientation[0], at.position[0])

    return poses


def _of_orientations(size: HandSize, numbers: dict[str, list[int]]) -> _PosesOf:
    """Segments without an orientation of their own turn with the one that they hang on."""
    tree = hand_tree(size)

    def poses(sample: Array) -> Poses:
        turns = np.empty((len(tree.names), 4))
        for k, (name, parent) in enumerate(zip(tree.names, tree.layout[:, 0], strict=True)):
            own = sample[numbers[name]] if name in numbers else None
            turns[k] = own if own is not None else turns[parent] if parent >= 0 else _root(sample, numbers)
        return placed(tree, quaternion.normalized(turns))

    return poses


def _root(sample: Array, numbers: dict[str, list[int]]) -> Array:
    """A forearm that is not told of turns with the first segment that is."""
    return np.asarray(sample[next(iter(numbers.values()))])

"""Source of postures from a live stream (Lab Streaming Layer), and the layout of its channels."""


from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from threading import Event, Lock, Thread
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses, placed
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.hand_mesh import segment_meshes
from fesloop.show.picture.posture import posture_of_angles
from fesloop.show.report.motion import view_into
from fesloop.show.report.parts import Figure3d, Frames
from fesloop.show.report.recorded_hand import ESTIMATE
from fesloop.show.view.readout import Readout
from fesloop.show.view.shown import Play, Shown, Span, Start
from fesloop.streams.labels import factor
from fesloop.streams.live.description import Channel, channels_of
from fesloop.streams.live.library import Network
from fesloop.streams.live.query import StreamQuery, find
from fesloop.streams.live.source import LslSource, Pulled, StreamLost

Array = NDArray[np.float64]
_PosesOf = Callable[[Array], Poses]
_FINGER = {"MCP": "F2_mcp_flexion", "PIP": "F2_pip_flexion", "DIP": "F2_dip_flexion"}
_PARTS = "wxyz"
ALLOWED = ("channels named after the hand's freedoms (F2_mcp_flexion), MCP, PIP, DIP, or its segments "
           "(F2p w, F2p x, F2p y, F2p z); without names 23 angles, 3 of a finger, or 17 times w, x, y, z")


@dataclass(frozen=True, slots=True)
class StreamLayout:
    """Conversion of a sample to the poses of a hand.

    Attributes
    ----------
    poses_of: poses (17,) of a sample of all channels; NaN where the sample has no information.
    turns: whether the whole hand turns, or only its joints.
    """

    poses_of: _PosesOf
    turns: bool


def layout_of(channels: Sequence[Channel], count: int, size: HandSize, where: str) -> StreamLayout:
    """Layout of a stream's channels.

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
    """Function from samples of angles to poses; other freedoms rest."""
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
    """Orientation of a forearm that the stream lacks: that of the first segment in the stream."""
    return np.asarray(sample[next(iter(numbers.values()))])


_WAIT_S = 0.2
_SILENT_NS = NS_PER_S


class PostureStream:
    """The newest sample of a stream.

    Parameters
    ----------
    name: of the stream. side: of the hand. network: this machine, or as liblsl is set up.

    Raises InputError where pylsl is missing, no such stream answers, or it holds no posture.
    """

    def __init__(self, name: str, side: Literal["left", "right"] = "right",
                 network: Network = "loopback") -> None:
        query = StreamQuery(name=name, network=network)
        self._source = LslSource(query, find(query))
        size = HandSize(side=side)
        try:
            info = self._source.info
            self._layout = layout_of(channels_of(info), info.channel_count(), size, str(query))
        except BaseException:
            self._source.close()
            raise
        self.title = f"stream {name}"
        self.spans: Mapping[int, Span] = {}
        self.notices: Sequence[str] = ()
        self.shown, self.readout = 0, Readout()
        self.figure = _figure(size, name, turns=self._layout.turns)
        self._began_ns = time.monotonic_ns()
        self._newest: Pulled | None = None
        self._said = "no sample has come yet"
        self._lock, self._over = Lock(), Event()
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        """Take every sample and keep the newest."""
        while not self._over.is_set():
            try:
                pulled = self._source.pull(_WAIT_S)
            except StreamLost:
                self._find_again()
                continue
            if pulled is not None:
                with self._lock:
                    self._newest, self._said = pulled, ""

    def _find_again(self) -> None:
        with self._lock:
            self._said = "the stream is gone; it is looked for"
        try:
            self._source.reopen()
        except StreamLost:
            self._over.wait(_WAIT_S)

    def play(self, start: Start) -> Play:
        """Begin to show the newest samples; `start` is ignored."""
        before: Pulled | None = None
        noted = ""

        def at(elapsed_s: float) -> Shown | None:
            nonlocal before, noted
            with self._lock:
                pulled, said = self._newest, self._said
            note = said or _age(pulled)
            if pulled is before and note == noted:
                return None
            before, noted = pulled, note
            return self._frame(pulled, note)

        return at

    def _frame(self, pulled: Pulled | None, note: str) -> Shown:
        hands: dict[str, Array] = {}
        time_s = 0.0
        if pulled is not None:
            time_s = (pulled.stamp_ns - self._began_ns) / NS_PER_S
            orientation, position = self._layout.poses_of(pulled.values)
            hands[ESTIMATE] = np.concatenate([orientation, position], axis=-1)
        return Shown(trial=0, time_s=time_s, hands=hands, objects=np.empty((0, 7)), note=note)

    def close(self) -> None:
        """Close the stream."""
        self._over.set()
        self._reader.join()
        self._source.close()


def _age(pulled: Pulled | None) -> str:
    """Age of a sample in words, by its sender's stamp."""
    if pulled is None:
        return ""
    age_ns = time.monotonic_ns() - pulled.stamp_ns
    if age_ns > _SILENT_NS:
        return f"the newest sample is {age_ns // NS_PER_S} s old"
    return f"captured less than {max(1, -(-age_ns // (NS_PER_S // 10)))}00 ms ago"


def _figure(size: HandSize, name: str, *, turns: bool) -> Figure3d:
    """Figure of the straight hand, by which the camera is placed; in four headings where the hand `turns`."""
    headings = np.deg2rad([0.0, 90.0, 180.0, 270.0] if turns else [0.0])
    straight = posture_of_angles(size, np.zeros((len(headings), 23)))
    about_up = quaternion.about_z(headings)[:, np.newaxis]
    rows = np.concatenate([quaternion.multiply(about_up, straight.poses.orientation),
                           quaternion.rotate(about_up, straight.poses.position)], axis=-1)
    frames = Frames(start_s=0.0, step_s=1.0, hands={ESTIMATE: rows}, objects=np.empty((len(rows), 0, 7)))
    figure = Figure3d(key="hand", trials={0: frames}, shapes={ESTIMATE: segment_meshes(size)},
                      text=f"A {size.side} hand of {size.hand_mm:.0f} mm as the stream {name} has it.")
    view = view_into({ESTIMATE: straight}, holding=False)
    return figure if view is None else replace(figure, view=view)

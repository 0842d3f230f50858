"""A live stream of postures (Lab Streaming Layer), shown as it comes."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from threading import Event, Lock, Thread
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.hand_mesh import segment_meshes
from fesloop.show.picture.posture import posture_of_angles
from fesloop.show.report.figure3d import Figure3d, Frames
from fesloop.show.report.motion import view_into
from fesloop.show.report.recorded_hand import ESTIMATE
from fesloop.show.view.shown import Play, Shown, Span, Start
from fesloop.show.view.stream_layout import layout_of
from fesloop.streams.live.description import channels_of
from fesloop.streams.live.library import Network
from fesloop.streams.live.query import StreamQuery, find
from fesloop.streams.live.source import LslSource, Pulled, StreamLost

Array = NDArray[np.float64]
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
        """From now on; where somebody wants to start does not matter."""
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
        """Let the stream go."""
        self._over.set()
        self._reader.join()
        self._source.close()


def _age(pulled: Pulled | None) -> str:
    """How old a sample is, by its sender's stamp."""
    if pulled is None:
        return ""
    age_ns = time.monotonic_ns() - pulled.stamp_ns
    if age_ns > _SILENT_NS:
        return f"the newest sample is {age_ns // NS_PER_S} s old"
    return f"captured less than {max(1, -(-age_ns // (NS_PER_S // 10)))}00 ms ago"


def _figure(size: HandSize, name: str, *, turns: bool) -> Figure3d:
    """The straight hand, about which the camera stands; in all directions where it turns."""
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

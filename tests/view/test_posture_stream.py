"""A live stream of postures through liblsl on this machine, and without it."""

import sys
import time

import numpy as np
import pytest
from view_parts import events, serving

from fesloop.errors import InputError
from fesloop.show.view.posture_stream import PostureStream
from fesloop.show.view.shown import Start
from fesloop.streams.live.library import open_library

pytest.importorskip("pylsl")
NAME = "postures of a test"


@pytest.fixture
def outlet():
    pylsl = open_library()
    info = pylsl.StreamInfo(NAME, "fesloop", 3, 100.0, "double64", "postures of a test")
    described = info.desc().append_child("channels")
    for label in ("MCP", "PIP", "DIP"):
        channel = described.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", "deg")
    return pylsl.StreamOutlet(info, chunk_size=1)


def bent_deg(poses):
    """The true angle between an index finger's proximal and middle segment."""
    return np.rad2deg(2.0 * np.arccos(min(1.0, abs(float(np.dot(poses[5][:4], poses[6][:4]))))))


def test_the_newest_sample_is_shown(outlet):
    stream = PostureStream(NAME)
    try:
        with serving(stream) as server, events(server.server_port) as frames:
            assert next(frames)["note"] == "no sample has come yet"
            for angle in (10.0, 50.0, 90.0):
                until, bent = time.monotonic() + 120.0, -1.0
                while abs(bent - angle) > 0.05 and time.monotonic() < until:
                    outlet.push_sample([0.0, angle, 0.0])
                    bent = bent_deg(next(frames)["hands"].get("estimate", [[1.0] * 7] * 17))
                assert bent == pytest.approx(angle, abs=0.05)
    finally:
        stream.close()


@pytest.mark.slow
def test_it_says_how_old_the_newest_sample_is(outlet):
    stream = PostureStream(NAME)
    try:
        play, note, until = stream.play(Start()), "", time.monotonic() + 120.0
        outlet.push_sample([0.0, 1.0, 2.0])
        while "s old" not in note and time.monotonic() < until:
            shown = play(0.0)
            note = note if shown is None else shown.note
            time.sleep(0.02)
        assert note.startswith("the newest sample is ")
    finally:
        stream.close()


@pytest.mark.slow
def test_a_stream_that_is_not_there_is_refused(monkeypatch):
    monkeypatch.setattr("fesloop.streams.live.source.StreamQuery.search", lambda *_: [])
    with pytest.raises(InputError, match="does not answer"):
        PostureStream("of nobody")


def test_without_pylsl_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("fesloop.streams.live.library._opened", {})
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(InputError, match=r"pip install 'fesloop\[lsl\]'"):
        PostureStream(NAME)

"""A recording that is followed while it is being written, against what stands in it afterwards."""

import itertools
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from view_parts import events, serving

from fesloop import Recording
from fesloop.show.view.followed import FollowedRecording
from fesloop.show.view.played import PlayedRecording
from fesloop.show.view.shown import Start
from fesloop.show.view.sources import open_recording

pytestmark = pytest.mark.realtime

SCRIPT = ["finger_control", "--realtime", "--set", "experiment.duration_s=120"]


@pytest.fixture
def running(tmp_path):
    """A loop that is under way, and its file."""
    process = subprocess.Popen([sys.executable, "-m", "fesloop", "run", *SCRIPT, "--out", str(tmp_path)],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60.0
    while not (found := list(tmp_path.glob("finger_control-*.h5"))):
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.05)
    yield process, found[0]
    process.kill()
    process.wait()


def bent_deg(frame):
    """How far the true index finger's middle joint is bent in a frame."""
    proximal, middle = (np.array(frame["hands"]["truth"][k][:4]) for k in (5, 6))
    return np.rad2deg(2.0 * np.arccos(min(1.0, abs(float(proximal @ middle)))))


@pytest.mark.slow
def test_frames_go_on_with_the_loop_and_are_what_it_recorded(running):
    process, path = running
    source = open_recording(path)
    assert isinstance(source, FollowedRecording)
    with serving(source) as server, events(server.server_port) as frames:
        began = time.monotonic()
        seen = list(itertools.takewhile(lambda frame: time.monotonic() - began < 6.0, frames))
        process.send_signal(signal.SIGINT)
        process.wait(30.0)
    source.close()
    times = [frame["time_s"] for frame in seen]
    assert all(before <= after for before, after in itertools.pairwise(times))
    # As fast as the clock, but for what the machine held back.
    assert 3.0 < times[-1] - times[0] < 8.0
    behind = [float(frame["note"].split()[0]) for frame in seen if frame["note"].endswith("behind the loop")]
    assert len(behind) > 0.8 * len(seen)
    assert max(behind) < 4.0
    with Recording(path) as recording:
        told = recording.signal("patient.angles")
    for frame in seen:
        row = told.values[told.times_ns <= round(frame["time_s"] * 1e9)][-1]
        assert bent_deg(frame) == pytest.approx(abs(np.rad2deg(row[1])), abs=0.15)


@pytest.mark.slow
def test_it_says_that_the_run_has_ended_or_that_nothing_comes(running):
    process, path = running
    source = open_recording(path)
    play = source.play(Start())
    play(0.0)
    process.send_signal(signal.SIGINT)
    process.wait(30.0)
    until, note = time.monotonic() + 20.0, ""
    while "interrupted" not in note and time.monotonic() < until:
        shown = play(0.0)
        note = note if shown is None else shown.note
        time.sleep(0.05)
    assert note == "the run has ended: interrupted"
    source.close()


@pytest.mark.slow
def test_a_killed_run_is_played_once_its_file_is_old(running):
    process, path = running
    open_recording(path).close()
    process.kill()
    process.wait()
    old = time.time() - 60.0
    os.utime(path, (old, old))
    source = open_recording(path)
    assert isinstance(source, PlayedRecording)
    assert source.play(Start())(0.0).hands["truth"].shape == (17, 7)
    source.close()


@pytest.mark.slow
def test_a_run_that_is_not_in_real_time_says_where_it_is(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "fesloop", "run", "finger_control", "--set", "experiment.duration_s=50000",
         "--out", str(tmp_path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until = time.monotonic() + 60.0
        while not (found := list(Path(tmp_path).glob("finger_control-*.h5"))):
            assert time.monotonic() < until
            time.sleep(0.05)
        source = open_recording(found[0])
        play, notes = source.play(Start()), set()
        until = time.monotonic() + 4.0
        while time.monotonic() < until:
            shown = play(0.0)
            notes |= {shown.note} if shown is not None else set()
            time.sleep(0.05)
        source.close()
    finally:
        process.kill()
        process.wait()
    assert any("not in real time" in note for note in notes)

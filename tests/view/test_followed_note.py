"""What a viewer says of how far behind a run it is, against clocks that are told to it."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from fesloop import Recording
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.form import ORIGINS
from fesloop.experiment.running import run
from fesloop.show.view.followed import FollowedRecording
from fesloop.show.view.shown import Start

S, MS = 10**9, 10**6
ORIGIN_NS = 1234 * S
"""When t = 0 was by the monotonic clock."""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Three seconds of a finger, twice."""
    settings = ["experiment.duration_s=3", "experiment.trials=2", "score.after_s=0"]
    return Path(run(load("finger_control", settings), tmp_path_factory.mktemp("runs")).recording)


@pytest.fixture
def follow(recorded, tmp_path):
    """The recording as a loop left it a moment ago, followed by a clock that stands at `late_ns` after that.

    `origins`: of trials, ns; a run without is not in real time. Gives the source, a clock that can be set,
    and the last instant of what is written.
    """
    sources = []

    def made(late_ns, origins=((1, ORIGIN_NS),), status=b"running"):
        path = tmp_path / "run.h5"
        shutil.copy(recorded, path)
        with h5py.File(path, "r+") as file:
            del file["status"]
            file["status"] = np.array(status, "S16")
            if origins:
                rows = np.array([(trial, at_ns, 0) for trial, at_ns in origins], ORIGINS)
                file["wall"].create_dataset("origins", data=rows, maxshape=(None,), chunks=(8,))
        with Recording(path) as recording:
            last = min(int(recording.signal(name, 1).times_ns[-1])
                       for name in ("patient.angles", "tracker.angles"))
        now = [ORIGIN_NS + last + late_ns]
        source = FollowedRecording(Recording(path), lambda: now[0])
        sources.append(source)
        return source, now, last

    yield made
    for source in sources:
        source.close()


def note(source):
    return source.play(Start())(0.0).note


@pytest.mark.parametrize(("late_ns", "said"), [
    (0, ""), (1900 * MS, ""), (2 * S, ""), (2100 * MS, "; the loop itself is 2 s late"),
    (3400 * MS, "; the loop itself is 3 s late"), (75 * S, "; the loop itself is 75 s late")])
def test_a_loop_that_is_late_by_itself_is_told_apart_from_the_viewer(follow, late_ns, said):
    """It begins .9 s behind what is written: so far is the viewer behind, however late the loop is."""
    source, _, _ = follow(late_ns)
    assert note(source) == f"0.9 s behind the loop{said}"


def test_a_loop_that_is_ahead_of_its_clock_is_not_late(follow):
    source, _, _ = follow(-50 * MS)
    assert note(source) in ("0.8 s behind the loop", "0.9 s behind the loop")


def test_while_nothing_comes_the_viewer_falls_behind_and_not_the_loop(follow):
    source, now, _ = follow(3400 * MS)
    note(source)
    now[0] += 900 * MS
    assert note(source) == "0.9 s behind the loop; the loop itself is 3 s late"
    now[0] += 600 * MS
    assert note(source) == "1.5 s behind the loop; the loop itself is 3 s late"
    now[0] += 600 * MS
    assert note(source) == "nothing was written for 2 s"


@pytest.mark.parametrize("status", [b"done", b"failed", b"interrupted"])
def test_a_run_that_ends_is_said_to_have_ended(follow, status):
    source, now, _ = follow(0, status=status)
    now[0] += 2100 * MS
    assert note(source) == f"the run has ended: {status.decode()}"


@pytest.mark.parametrize("origins", [(), ((0, ORIGIN_NS),)])
def test_without_a_clock_of_the_trial_it_is_said_where_the_run_is(follow, origins):
    source, _, last = follow(0, origins)
    assert note(source) == f"the run is at {last / S:.1f} s of trial 1, not in real time"


def test_the_clock_is_that_of_the_trial(follow):
    source, _, _ = follow(2600 * MS, ((0, ORIGIN_NS - 100 * S), (1, ORIGIN_NS)))
    assert note(source) == "0.9 s behind the loop; the loop itself is 3 s late"

"""A recording of a run that broke off: killed, interrupted, or with a disk that fills up; about 30 s."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import h5py
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop import InputError, Recording
from fesloop.experiment.running import run
from fesloop.experiment.trouble import troubles
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.sentence import sentence_of

SMALL = Path(__file__).parents[1] / "small.toml"
KILLS = 3 if os.environ.get("CI") else 20
LONG = ["experiment.duration_s=60", "experiment.trials=1"]


def start(folder):
    """A run in real time in a process of its own."""
    command = [sys.executable, "-m", "fesloop", "run", str(SMALL), "--realtime", "--json"]
    command += ["--out", str(folder)]
    for setting in LONG:
        command += ["--set", setting]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def simulated_s(path):
    """How far the recording of a run that is under way, or was killed, has come."""
    with Recording(path) as recording:
        times = recording.signal("finger.angles").times_ns
        assert recording.status == "running"
        return times[-1] / 1e9 if times.size else 0.0


def wait_for_rows(folder, until):
    """(wall instant, simulated time) of the first rows seen in the folder's recording, None by `until`."""
    while time.monotonic() < until:
        paths = list(folder.glob("small-*.h5"))
        if paths and (far := simulated_s(paths[0])) > 0.0:
            return time.monotonic(), far
        time.sleep(0.02)
    return None


@pytest.mark.realtime
@pytest.mark.parametrize("number", range(KILLS))
def test_a_killed_run_opens_and_misses_a_second_at_most(tmp_path, number):
    """At a moment while it starts or runs, or, each second time, of its running alone."""
    process = start(tmp_path)
    if number % 2:
        moment = time.monotonic() + random.Random(number).uniform(0.5, 6.0)
        seen = wait_for_rows(tmp_path, moment)
    else:
        seen = wait_for_rows(tmp_path, time.monotonic() + 60.0)
        assert seen is not None
        moment = seen[0] + random.Random(number).uniform(0.0, 4.0)
    time.sleep(max(0.0, moment - time.monotonic()))
    killed = time.monotonic()
    process.kill()
    process.communicate()
    for path in tmp_path.glob("small-*.h5"):
        with h5py.File(path, "r", swmr=True) as file:
            assert file["status"][()] == b"running"
        reached = simulated_s(path)
        if seen is not None:
            assert reached >= seen[1] + (killed - seen[0]) - 1.0
    assert seen is None or len(list(tmp_path.iterdir())) == 1


@pytest.mark.slow
def test_a_running_recording_can_be_read(tmp_path):
    process = start(tmp_path)
    try:
        first = wait_for_rows(tmp_path, time.monotonic() + 120)
        time.sleep(1.0)
        assert simulated_s(next(iter(tmp_path.glob("small-*.h5")))) > first[1]
    finally:
        process.kill()
        process.communicate()


@pytest.mark.slow
def test_ctrl_c_keeps_a_readable_recording(tmp_path):
    process = start(tmp_path)
    assert wait_for_rows(tmp_path, time.monotonic() + 120) is not None
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert json.loads(out)["status"] == "interrupted"
    path = tmp_path / "small-1.h5"
    with Recording(path) as recording:
        assert recording.status == "interrupted"
        assert recording.signal("finger.angles").times_ns.size
    h5py.File(path, "r").close()


class AskedLater:
    """A request to stop that comes after a number of looks."""

    def __init__(self, looks):
        self.looks = looks

    @property
    def asked(self):
        self.looks -= 1
        return self.looks < 0


@given(st.integers(1, 3), st.integers(1, 80))
@settings(max_examples=10, deadline=None)
def test_summary_and_report_say_how_far_a_run_got_that_was_interrupted(tmp_path_factory, trials, looks):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fesloop.experiment.running.interruptible", lambda: nullcontext(AskedLater(looks)))
        patch.setattr("fesloop.experiment.running._LONGEST_STRETCH_NS", 10**8)
        spec = fesloop.load(SMALL, ["experiment.duration_s=2", f"experiment.trials={trials}"])
        result = run(spec, tmp_path_factory.mktemp("asked"))
    with Recording(result.recording) as recording:
        last = recording.trials - 1
        until_s = recording.signal("finger.angles", last).times_ns[-1] / 1e9
        found = [each.text for each in troubles(recording, result.metrics)]
        told = sentence_of(Known(recording, recording.trials, (last,), None, result.metrics, {}, (),
                                 frozenset()))
    assert ("The run was interrupted" in told) == (result.status == "interrupted")
    if result.status == "interrupted":
        which = f" in trial {last} (of 0 to {trials - 1})" if trials > 1 else ""
        place = f"he run was interrupted at {until_s:.3g} of 2 s{which}"
        assert found[0] == f"t{place}: numbers are of what was recorded until then"
        assert told.startswith(f"T{place}; recorded until then: ")


def test_a_disk_that_fills_up_ends_the_run_and_leaves_a_whole_recording(tmp_path, monkeypatch):
    """HDF5 crashes on a write that fails, so none may."""
    free = iter([10**12] * 6)
    monkeypatch.setattr("fesloop.experiment.running._FLUSH_WALL_S", 0.0)
    monkeypatch.setattr("fesloop.experiment.recording.writing.free_bytes", lambda path: next(free, 10**6))
    result = run(fesloop.load(SMALL), tmp_path)
    assert result.status == "failed"
    assert "the disk is full, 1 MB are left" in result.cause
    with Recording(result.recording) as recording:
        assert recording.status == "failed"
        assert 0 < recording.signal("finger.angles").times_ns.size < 1000


WRITES_TOO_MUCH = """
import resource, sys
import fesloop
from fesloop.experiment.recording import writing as recording
from fesloop.experiment import running
from fesloop.errors import RunError
running._FLUSH_WALL_S = 0.0
lengthen = recording.lengthen

def with_room(path):
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    lengthen(path)

recording.lengthen = with_room
experiment = fesloop.load(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, resource.RLIM_INFINITY))
try:
    experiment.run(sys.argv[2])
except RunError as fault:
    print(fault)
"""


@pytest.mark.slow
def test_a_write_that_is_refused_is_told_in_one_line_and_what_was_written_can_be_read(tmp_path):
    """As by a quota, which no look at the disk foretells: a hole at the end of a file takes no room."""
    told = subprocess.run([sys.executable, "-c", WRITES_TOO_MUCH, str(SMALL), str(tmp_path)],
                          capture_output=True, text=True, check=False).stdout
    assert told == f"{tmp_path / 'small-1.h5'}: cannot be written: File too large\n"
    with Recording(tmp_path / "small-1.h5") as recording:
        assert recording.signal("finger.angles").times_ns.size


def test_a_full_disk_is_found_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr("fesloop.experiment.recording.writing.free_bytes", lambda path: 10**6)
    with pytest.raises(InputError, match=r"--out .*the disk is full, 1 MB"):
        fesloop.load(SMALL).run(tmp_path / "runs")
    assert list(tmp_path.iterdir()) == []

"""A recording holds what happened, is the same for the same experiment, and survives the end of its run."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import fesloop
from fesloop import Experiment, InputError, Recording
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.running.trial import run
from fesloop.loop.signals import Port

SMALL = Path(__file__).parent / "small.toml"
KILLS = 3 if os.environ.get("CI") else 20


@dataclass(frozen=True)
class OddlyNamed:
    """A block whose output has the name of a stamp."""

    inputs = ()
    outputs = (Port("time_ns"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (0.0,)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return fesloop.load(SMALL).run(tmp_path_factory.mktemp("runs"))


def test_every_tick_of_every_trial_is_there_at_its_instant(recorded):
    with Recording(recorded.recording) as recording:
        assert recording.status == "done"
        assert recording.trials == 2
        for trial in range(2):
            stimulation = recording.signal("pid.stimulation", trial)
            assert stimulation.unit == "A,s"
            assert stimulation.values.shape == (50, 4, 2)
            np.testing.assert_array_equal(stimulation.times_ns, np.arange(50) * 20_000_000)
            angles = recording.signal("finger.angles", trial)
            np.testing.assert_array_equal(angles.times_ns, np.arange(1000) * 1_000_000)


def test_the_plant_input_is_what_the_controller_sent_one_wire_earlier(recorded):
    with Recording(recorded.recording) as recording:
        sent = recording.signal("pid.stimulation", 1)
        acting = recording.signal("finger.stimulation", 1)
        arrived = acting.times_ns[:, None] == sent.times_ns + 5_000_000
        assert arrived.any(axis=1).all()
        np.testing.assert_array_equal(acting.values, sent.values[arrived.argmax(axis=1)])


def test_stamps_are_those_of_the_capture_behind_the_value(recorded):
    """The first tick has the reference alone; from the second on the angles are the older."""
    with Recording(recorded.recording) as recording:
        late = recording.signal("pid.stimulation", 0)
        age_ms = (late.times_ns - late.oldest_ns)[1:] / 1e6
        assert (age_ms >= 15).all()
        assert (age_ms <= 40).all()


def test_the_experiment_can_be_made_from_its_recording(recorded):
    with Recording(recorded.recording) as recording:
        again = from_document(recording.experiment)
        assert again == fesloop.load(SMALL)
        assert again.fingerprint() == recording.fingerprint
        assert recording.seed == 3
        assert recording.versions["numpy"] == np.__version__


def test_messages_are_counted_by_trial(recorded):
    with Recording(recorded.recording) as recording:
        counts = recording.messages
    assert [trial["finger.angles->pid.measured"]["sent"] for trial in counts] == [50, 50]


def test_an_unknown_signal_is_refused_with_those_that_exist(recorded):
    with Recording(recorded.recording) as recording, pytest.raises(InputError, match=r"finger\.angles"):
        recording.signal("finger.angle")


def digest_of(path):
    with Recording(path) as recording:
        return recording.digest()


def test_the_digest_is_the_same_in_another_process_and_in_step_with_the_wall_clock(recorded, tmp_path):
    code = f"import fesloop; print(fesloop.load({str(SMALL)!r}).run({str(tmp_path)!r}).recording)"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert digest_of(other.stdout.strip()) == digest_of(recorded.recording)
    paced = fesloop.load(SMALL, ["experiment.duration_s=1"]).run(tmp_path, realtime=True)
    assert paced.deadlines == 100
    assert paced.wall_s > 1.9
    assert digest_of(paced.recording) == digest_of(recorded.recording)


@pytest.mark.parametrize("setting", [
    "experiment.seed=4", "wires.1.latency_ms=15.000001", "blocks.pid.kp.0=0.4"])
def test_the_digest_tells_experiments_apart(recorded, tmp_path, setting):
    changed = fesloop.load(SMALL, [setting]).run(tmp_path)
    assert digest_of(changed.recording) != digest_of(recorded.recording)


def test_runs_never_overwrite_each_other_and_leave_nothing_else(tmp_path):
    experiment = fesloop.load(SMALL, ["experiment.duration_s=0.1"])
    first, second = experiment.run(tmp_path), experiment.run(tmp_path)
    assert sorted(tmp_path.iterdir()) == [first.recording, second.recording]
    assert first.recording.name == "small-1.h5"


def test_a_run_with_measured_execution_times_is_repeated_exactly(tmp_path):
    """Scaled so that steps take ms of simulated time: some ticks are skipped, differently in each run."""
    execution = ["blocks.pid.execution.kind=measured", "blocks.pid.execution.scale=1000"]
    first = fesloop.load(SMALL, execution).run(tmp_path)
    again = fesloop.load(first.recording).run(tmp_path)
    with Recording(first.recording) as one, Recording(again.recording) as other:
        for trial in range(2):
            steps = [each.signal("pid.stimulation", trial) for each in (one, other)]
            assert (steps[0].left_ns > steps[0].times_ns).all()
            np.testing.assert_array_equal(steps[0].left_ns, steps[1].left_ns)
            angles = [each.signal("finger.angles", trial).values for each in (one, other)]
            np.testing.assert_array_equal(*angles)


def test_a_run_that_cannot_be_recorded_leaves_no_file(tmp_path):
    experiment = fesloop.load(SMALL)
    node = replace(experiment.nodes[0], part=OddlyNamed())
    odd = Experiment(name="odd", nodes=(node,), duration_s=1)
    with pytest.raises(InputError, match="time_ns"):
        odd.run(tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [None, b"", b"no hdf5", b"\x89HDF\r\n\x1a\n" + bytes(200)])
def test_what_is_no_recording_is_refused(tmp_path, content):
    path = tmp_path / "x.h5"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"x\.h5"):
        Recording(path)


def test_hdf5_of_others_and_truncated_files_are_refused(recorded, tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    (tmp_path / "cut.h5").write_bytes(recorded.recording.read_bytes()[:20000])
    for name in ("other.h5", "cut.h5"):
        with pytest.raises(InputError, match=name):
            Recording(tmp_path / name)


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


@pytest.mark.parametrize("number", range(KILLS))
def test_a_killed_run_opens_and_misses_a_second_at_most(tmp_path, number):
    process = start(tmp_path)
    moment = time.monotonic() + random.Random(number).uniform(0.5, 6.0)
    seen = wait_for_rows(tmp_path, moment)
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


def test_a_running_recording_can_be_read(tmp_path):
    process = start(tmp_path)
    try:
        first = wait_for_rows(tmp_path, time.monotonic() + 30)
        time.sleep(1.0)
        assert simulated_s(next(iter(tmp_path.glob("small-*.h5")))) > first[1]
    finally:
        process.kill()
        process.communicate()


def test_ctrl_c_keeps_a_readable_recording(tmp_path):
    process = start(tmp_path)
    assert wait_for_rows(tmp_path, time.monotonic() + 30) is not None
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=10)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert json.loads(out)["status"] == "interrupted"
    path = tmp_path / "small-1.h5"
    with Recording(path) as recording:
        assert recording.status == "interrupted"
        assert recording.signal("finger.angles").times_ns.size
    h5py.File(path, "r").close()


def test_a_disk_that_fills_up_ends_the_run_and_leaves_a_whole_recording(tmp_path, monkeypatch):
    """HDF5 crashes on a write that fails, so none may."""
    free = iter([10**12] * 6)
    monkeypatch.setattr("fesloop.experiment.running.under_way._FLUSH_WALL_S", 0.0)
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
from fesloop.experiment.running import under_way
from fesloop.errors import RunError
under_way._FLUSH_WALL_S = 0.0
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


def test_a_write_that_is_refused_is_told_in_one_line_and_what_was_written_can_be_read(tmp_path):
    """As by a quota, which no look at the disk foretells: a hole at the end of a file takes no room."""
    told = subprocess.run([sys.executable, "-c", WRITES_TOO_MUCH, str(SMALL), str(tmp_path)],
                          capture_output=True, text=True, check=False).stdout
    assert told == f"{tmp_path / 'small-1.h5'}: cannot be written: File too large\n"
    with Recording(tmp_path / "small-1.h5") as recording:
        assert recording.signal("finger.angles").times_ns.size


def test_a_full_disk_is_found_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr("fesloop.experiment.recording.file.free_bytes", lambda path: 10**6)
    with pytest.raises(InputError, match=r"--out .*the disk is full, 1 MB"):
        fesloop.load(SMALL).run(tmp_path / "runs")
    assert list(tmp_path.iterdir()) == []

"""A recording holds what happened, and is the same for the same experiment."""

import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import fesloop
from fesloop import Experiment, InputError, Recording
from fesloop.experiment.files.parse import from_document
from fesloop.loop.signals import Port

SMALL = Path(__file__).parents[1] / "small.toml"


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


@pytest.mark.parametrize("trial", [-1, 2])
def test_a_trial_that_was_not_begun_is_refused(recorded, trial):
    with Recording(recorded.recording) as recording:
        for read in (recording.signal, recording.column):
            with pytest.raises(InputError, match=rf"trial: {trial}; allowed: 0 to 1"):
                read("finger.angles", trial)


@pytest.mark.slow
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


def test_a_recording_is_repeated_with_its_blocks_in_the_order_of_the_file(tmp_path):
    """By that order ties are broken: here, whose status of the first instant comes first."""
    document = fesloop.load(SMALL, ["experiment.trials=1"]).document()
    document["blocks"] |= {name: {"kind": "finger_imus", "rate": "100"} for name in "bca"}
    document["wires"] += [{"from": f"finger.{port}", "to": f"{name}.{port}", "latency_ms": 5}
                          for name in "bca" for port in ("angles", "rates", "accelerations")]
    first = from_document(document).run(tmp_path)
    again = fesloop.load(first.recording).run(tmp_path)
    with Recording(first.recording) as one, Recording(again.recording) as other:
        assert one.digest() == other.digest()
        assert [event.where for event in one.events if event.status == "waiting"] == list("bca")


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

"""Replay: a recording's samples at a recording's stamps, through the loop."""

from types import SimpleNamespace

import numpy as np
import pytest
import xdf_files
from recording_files import CONTENTS, write

from fesloop.analysis.tracker_error.measured_errors import measured_errors
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Tick
from fesloop.loop.clock import FOREVER
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.replay import Replay


def played(replay, until_ns):
    recorder = Recorder()
    Loop(Wiring([Node("replay", replay)], []), recorder=recorder).run_until(until_ns)
    rows = recorder.blocks["replay"]
    ports = zip(*(row[5] for row in rows), strict=True)
    return np.array([row[1] for row in rows]), [np.array(port) for port in ports]


@pytest.mark.parametrize("kind", list(CONTENTS))
def test_every_sample_leaves_once_at_its_stamp(tmp_path, kind):
    replay = Replay(recording=str(write(tmp_path, kind)))
    times, ports = played(replay, 10**12)
    source = replay.source
    np.testing.assert_array_equal(times, source.stamps_ns)
    np.testing.assert_array_equal(ports[0], source.gyr)
    np.testing.assert_array_equal(ports[1], source.acc)
    assert [port.name for port in replay.outputs] == ["gyr", "acc"] + ["mag"] * (source.mag is not None)
    if source.mag is not None:
        np.testing.assert_array_equal(ports[2], source.mag)


def test_files_of_the_field_are_played_directly(tmp_path):
    (tmp_path / "lab.xdf").write_bytes(xdf_files.motion_file())
    labelled = Replay(recording=str(tmp_path / "lab.xdf"))
    times, ports = played(labelled, 10**12)
    np.testing.assert_array_equal(times, labelled.source.stamps_ns)
    np.testing.assert_array_equal(ports[0], labelled.source.gyr)
    (tmp_path / "bare.xdf").write_bytes(xdf_files.motion_file(units=[""] * 9))
    layout = tmp_path / "layout.toml"
    layout.write_text('time = "imu"\n[units]\ngyr = "deg/s"\nacc = "g"\nmag = "uT"\n[sensors.imu]\n'
                      "gyr = [1, 2, 3]\nacc = [4, 5, 6]\nmag = [7, 8, 9]\n")
    described = Replay(recording=str(tmp_path / "bare.xdf"), layout=str(layout))
    np.testing.assert_array_equal(described.source.gyr, labelled.source.gyr)
    np.testing.assert_array_equal(described.source.mag, labelled.source.mag)


def test_uneven_stamps_are_played_unevenly(tmp_path):
    content = CONTENTS["body16"]()
    content["t"][7] += 0.004
    times, _ = played(Replay(recording=str(write(tmp_path, "body16", content))), 10**12)
    assert times[6:9].tolist() == [60_000_000, 74_000_000, 80_000_000]


def test_a_part_starts_at_zero_and_ends_in_time(tmp_path):
    replay = Replay(recording=str(write(tmp_path, "body16")), start_s=0.095, duration_s=0.1)
    assert replay.start_ns == 100_000_000
    times, ports = played(replay, 10**12)
    assert times.tolist() == [k * 10_000_000 for k in range(11)]
    np.testing.assert_array_equal(ports[0], replay.source.gyr[10:21])
    assert replay.clock.tick(11) == FOREVER


def test_nothing_to_play_and_bad_files_are_refused(tmp_path):
    path = str(write(tmp_path, "body16"))
    with pytest.raises(InputError, match=r"start_s: 9\.0 is past the last sample"):
        Replay(recording=path, start_s=9.0)
    with pytest.raises(InputError, match="duration_s"):
        Replay(recording=path, duration_s=-1.0)
    with pytest.raises(InputError, match="duration_s: 0 plays nothing"):
        Replay(recording=path, duration_s=0.0)
    with pytest.raises(InputError, match="no such file"):
        Replay(recording=path + ".gone")


def test_samples_cannot_be_written_to(tmp_path):
    replay = Replay(recording=str(write(tmp_path, "broad")))
    tick = Tick()
    for value in replay.step(None, (), tick):
        with pytest.raises(ValueError, match="read-only"):
            value[0, 0] = 1.0


def test_a_sample_that_the_recording_lost_is_lost_of_that_sensor_alone(tmp_path):
    content = CONTENTS["body16"]()
    content["hand_left"]["gyr"][7] = np.nan
    content["hand_left"]["acc"][9, 1] = np.nan
    replay = Replay(recording=str(write(tmp_path, "body16", content)))
    _, (gyr, acc) = played(replay, 10**12)
    np.testing.assert_array_equal(np.argwhere(np.isnan(gyr).any(axis=2)), [[7, 1]])
    np.testing.assert_array_equal(np.argwhere(np.isnan(acc).any(axis=2)), [[9, 1]])
    np.testing.assert_array_equal(gyr, replay.source.gyr)
    assert np.all(gyr[:, 0] != 0.0)


LAYOUT = """
rate = 100
pairs = [["a", "b"]]
[text]
header = 0
[sensors.a]
gyr = [1, 2, 3]
acc = [4, 5, 6]
orientation = [7, 8, 9, 10]
[sensors.b]
gyr = [11, 12, 13]
acc = [14, 15, 16]
orientation = [7, 8, 9, 10]
"""


@pytest.fixture
def described(tmp_path):
    """The tables of an experiment that plays two sensors at rest, of a table that a layout describes."""
    rows = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81, 1.0, 0.0, 0.0, 0.0], (300, 1))
    rows[:, :6] += np.random.default_rng(0).normal(0.0, 1e-3, (300, 6))
    rows = np.hstack([rows, rows[:, :6]])
    np.savetxt(tmp_path / "lab.csv", rows, delimiter=",")
    (tmp_path / "layout.toml").write_text(LAYOUT)
    recording = {"kind": "replay", "recording": str(tmp_path / "lab.csv"),
                 "layout": str(tmp_path / "layout.toml"), "start_s": 0.5}
    return {"experiment": {"name": "described"},
            "blocks": {"recording": recording, "tracker": {"kind": "vqf", "clock": "recording"}},
            "wires": [{"from": f"recording.{kind}", "to": f"tracker.{kind}"} for kind in ("gyr", "acc")],
            "score": {"orientation": "tracker.orientation", "recording": "recording"}}


def test_a_tracker_is_scored_against_a_reference_that_a_layout_describes(tmp_path, described):
    result = from_document(described).run(tmp_path / "runs")
    assert set(result.metrics["orientation_rmse_deg"]) == {"a", "b", "a-b"}
    assert result.metrics["orientation_rmse_deg"]["a"]["inclination"] < 0.1
    with Recording(result.recording) as recording:
        errors = measured_errors(recording)
    assert [record.name for record in errors.records] == ["a-b.x", "a-b.y", "a-b.z"]
    assert errors.records[0].times_s[[0, -1]] == pytest.approx([0.0, 2.49])


def test_errors_of_a_tracker_that_told_nothing_are_refused(tmp_path, described):
    """Of a run that failed at its first tick."""
    never = np.empty(0, np.int64)
    nothing = SimpleNamespace(newest_ns=never, times_ns=never, values=np.empty((0, 2, 4)))
    recording = SimpleNamespace(path="run.h5", experiment=described, signal=lambda name, trial=0: nothing,
                                signals=["tracker.orientation"], units={})
    with pytest.raises(InputError, match="has no estimate captured during the reference"):
        measured_errors(recording)

"""A gap in a recording stays a gap, whatever file it is in: from the import to the angles."""

import json
from types import SimpleNamespace

import bids_files
import numpy as np
import pytest
import xdf_files as xdf
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Tick
from fesloop.streams.blocks.replay import Replay
from fesloop.streams.doubts import missing_text
from fesloop.streams.files import open_recording
from fesloop.streams.live.sender import inertial
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.pace import Gap

SENSORS = ("hand", "finger")
LABELS = [f"{sensor}_{kind}_{axis}" for sensor in SENSORS for kind in ("gyr", "acc") for axis in "xyz"]
UNITS = (["rad/s"] * 3 + ["m/s^2"] * 3) * 2
LAYOUT = 'time = "t"\n' + "".join(
    f"[sensors.{sensor}]\n" + "".join(
        f"{kind} = {json.dumps([f'{sensor}_{kind}_{axis}' for axis in 'xyz'])}\n" for kind in ("gyr", "acc"))
    for sensor in SENSORS)


def hinge(times_s, angle_rad, rate_rad_s):
    """Samples of two sensors beside a hinge whose axis is level, (n, 12)."""
    zero, g = np.zeros_like(times_s), 9.80665
    rows = np.column_stack([zero, zero, zero, zero, g + zero, zero, zero, zero, rate_rad_s,
                            g * np.sin(angle_rad), g * np.cos(angle_rad), zero])
    noise = np.random.default_rng(1).standard_normal(rows.shape)
    return rows + noise * np.tile([1e-3] * 3 + [2e-2] * 3, 2)


def as_xdf(folder, times_s, rows, rate):
    path = folder / "lab.xdf"
    path.write_bytes(xdf.file_of(xdf.header(1, labels=LABELS, units=UNITS, rate=rate, form="double64"),
                                 xdf.samples(1, 1000.0 + times_s, rows)))
    return Replay(recording=str(path))


def as_table(folder, times_s, rows, _):
    (folder / "layout.toml").write_text(LAYOUT)
    np.savetxt(folder / "lab.csv", np.column_stack([times_s, rows]), delimiter=",", comments="", fmt="%.12g",
               header=",".join(["t", *LABELS]))
    return Replay(recording=str(folder / "lab.csv"), layout=str(folder / "layout.toml"))


def as_bids(folder, times_s, rows, rate):
    kinds = {"gyr": ("GYRO", "rad/s"), "acc": ("ACCEL", "m/s^2")}
    channels = [(label, label[-1], *(kinds[label.split("_")[1]][0], label.split("_")[0]),
                 kinds[label.split("_")[1]][1]) for label in LABELS]
    path = bids_files.write_system(folder, "imu", channels, list(rows.T), rate, times_s)
    return Replay(recording=str(path))


def as_structures(folder, times_s, rows, _):
    content = {"t": times_s}
    for number, sensor in enumerate(SENSORS):
        own = rows[:, 6 * number:6 * number + 6]
        content[sensor] = {"gyr": own[:, :3], "acc": own[:, 3:]}
    savemat(folder / "lab.mat", content)
    return Replay(recording=str(folder / "lab.mat"))


def as_motion_file(folder, *samples):
    path = folder / "motion.h5"
    path.unlink(missing_ok=True)
    write_motion_file(as_xdf(folder, *samples).source, path)
    return Replay(recording=str(path))


FORMS = (as_xdf, as_table, as_bids, as_structures, as_motion_file)


def put_out(replay):
    """(stamps s, gyr of both sensors, statuses) of every tick."""
    tick, values, told = Tick(), [], []
    for index, stamp in enumerate(replay.clock.stamps_ns):
        tick.index, tick.time_ns, tick.reports = index, int(stamp), []
        values.append(replay.step(None, (), tick)[0])
        told += [status for status, _ in tick.reports]
    return replay.clock.stamps_ns * 1e-9, np.array(values), told


@pytest.mark.slow
@given(form=st.sampled_from(FORMS), rate=st.floats(20.0, 250.0),
       lost=st.lists(st.tuples(st.integers(25, 120), st.floats(2.0, 300.0)), max_size=3))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_format_plays_its_gaps_as_missing_samples_at_the_pace_of_the_others(tmp_path, form, rate, lost):
    folder = tmp_path / form.__name__
    folder.mkdir(exist_ok=True)
    steps = np.ones(40 + sum(count for count, _ in lost))
    starts = np.cumsum([count for count, _ in lost], dtype=np.int64)
    steps[starts] = [periods for _, periods in lost]
    times = np.concatenate([[0.0], np.cumsum(steps[1:])]) / rate
    rows = hinge(times, 0.0 * times, 0.0 * times)
    stamps, gyr, told = put_out(form(folder, times, rows, rate))
    missing = np.isnan(gyr).all(axis=(1, 2))
    np.testing.assert_allclose(stamps[~missing], times, rtol=0, atol=2e-6)
    np.testing.assert_allclose(gyr[~missing, 0], rows[:, :3], rtol=1e-9)
    assert (np.diff(stamps) > 0.0).all()
    assert np.abs(np.diff(stamps) * rate - 1.0).max() <= 0.51
    assert abs(missing.sum() - sum(periods - 1.0 for _, periods in lost)) <= 0.5 * len(lost) + 1e-3
    assert told.count("gap") == len(lost)
    assert told.count("recording_incomplete") == bool(lost)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("gap_s", [0.26, 1.5, 4.003])
def test_angles_after_a_gap_are_those_of_their_instants(tmp_path, capsys, form, gap_s):
    """The hinge is at rest while samples are missing, so that no tracker needs to guess."""
    rate, times = 60.0, np.arange(60 * 24) / 60.0
    moving = np.where(times < 8.0, times, np.maximum(times - 4.3, 8.0))
    moves = (times < 8.0) | (times > 12.3)
    angle = np.radians(20.0) * (1.0 - np.cos(np.pi * 0.5 * moving))
    rows = hinge(times, angle, moves * np.radians(20.0) * np.pi * 0.5 * np.sin(np.pi * 0.5 * moving))
    late = times >= 8.1
    kept = ~late | (times >= 8.1 + gap_s)
    replay = form(tmp_path, times[kept], rows[kept], rate)
    settings_given = [f"recording={replay.recording}"]
    settings_given += [f"blocks.recording.layout={replay.layout}"] * bool(replay.layout)
    result = load("hil_replay", settings_given).run(tmp_path / "runs")
    with Recording(result.recording) as run:
        seen = run.signal("tracker.angles")
        told = {event.status: event.detail for event in run.events}
    true = np.degrees(np.interp(seen.newest_ns * 1e-9, times, angle))
    error = np.degrees(seen.values[:, 0]) - true
    assert np.sqrt(np.mean(np.square(error))) < 1.0
    assert np.abs(error).max() < 3.0
    assert int(seen.newest_ns[-1]) == pytest.approx(times[-1] * 1e9, abs=1e6)
    assert {"gap", "recording_incomplete", "lost_sample", "samples_valid"} <= set(told)
    assert "1 gap" in told["recording_incomplete"]


def test_what_is_missing_is_told_by_import_check_run_and_report(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    times = np.arange(600) / 60.0
    kept = (times < 4.0) | (times >= 5.5)
    rows = hinge(times, 0.0 * times, 0.0 * times)
    rows[100:110, 6] = np.nan
    as_xdf(tmp_path, times[kept], rows[kept], 60.0)
    assert main(["import", "lab.xdf", "motion.h5", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    words = ("1 gap, 1.5 s without samples (90 of 600 missing): 3.983 to 5.5 s; lost samples: "
             "finger 10 of 510")
    assert words in err
    assert told["rate"] is None
    assert told["rate_between_gaps_hz"] == pytest.approx(60.0)
    assert told["gaps"][0]["missing"] == 90
    assert told["lost_samples"] == {"hand": 0, "finger": 10}
    for command, where in ((["check"], 0), (["run"], 1)):
        assert main([*command, "hil_replay", "--set", "recording=motion.h5"]) == 0
        assert words.replace(" ", "") in capsys.readouterr()[where].replace(" ", "").replace("\n", "")
    assert main(["report", "runs/hil_replay-1.h5"]) == 0
    assert f"he recording played by `recording` lacks samples: {words}" in capsys.readouterr().err


def test_a_part_may_begin_after_a_gap_and_end_in_one(tmp_path):
    times = np.arange(1000) / 100.0
    kept = ((times < 2.0) | (times >= 3.0)) & ((times < 6.0) | (times >= 8.0))
    as_table(tmp_path, times[kept], hinge(times, 0.0 * times, 0.0 * times)[kept], 100.0)
    given_ = {"recording": str(tmp_path / "lab.csv"), "layout": str(tmp_path / "layout.toml")}
    replay = Replay(**given_, start_s=2.5, duration_s=4.0)
    stamps, gyr, told = put_out(replay)
    assert replay.start_ns == 3_000_000_000
    assert stamps[-1] == pytest.approx(4.0)
    assert np.isnan(gyr).all(axis=(1, 2)).sum() == 101
    assert told == ["recording_incomplete", "gap"]
    stamps, gyr, told = put_out(Replay(**given_, duration_s=1.5))
    assert told == []
    assert not np.isnan(gyr).any()


def test_a_gap_beyond_all_measure_is_refused_by_what_would_play_it(tmp_path):
    times = np.arange(200) / 100.0
    times[100:] += 1e6
    with pytest.raises(InputError, match=r"has a gap of 1e\+06 s after 0.99 s.*start_s and duration_s"):
        as_table(tmp_path, times, hinge(times, 0.0 * times, 0.0 * times), 100.0)


def test_a_stream_of_a_recording_keeps_its_gaps(tmp_path):
    times = np.arange(400) / 50.0
    kept = (times < 3.0) | (times >= 5.0)
    source = as_table(tmp_path, times[kept], hinge(times, 0.0 * times, 0.0 * times)[kept], 50.0).source
    played = inertial(source)
    assert played.rate_hz == pytest.approx(50.0, rel=1e-6)
    np.testing.assert_array_equal(np.isnan(played.rows).all(axis=1), ~kept)


def test_streams_of_which_one_has_a_gap_are_not_put_beside_each_other(tmp_path):
    times = np.arange(300) / 100.0
    rows = hinge(times, 0.0 * times, 0.0 * times)
    kept = (times < 1.0) | (times >= 1.4)
    path = tmp_path / "lab.xdf"
    path.write_bytes(xdf.file_of(
        xdf.header(1, "gyr", labels=LABELS[:3], units=UNITS[:3], form="double64"),
        xdf.header(2, "acc", labels=LABELS[3:6], units=UNITS[3:6], form="double64"),
        xdf.samples(1, times, rows[:, :3]), xdf.samples(2, times[kept], rows[kept, 3:6])))
    with pytest.raises(InputError, match=r"other instants than stream gyr; .*gyr \(300 samples .*\(260"):
        open_recording(path)


def test_the_time_without_samples_is_that_of_those_that_are_missing():
    recording = SimpleNamespace(sensors=(), gyr=np.zeros((8, 0, 3)), acc=np.zeros((8, 0, 3)), mag=None)
    gaps = [Gap(0.03, 0.06, 2), Gap(0.07, 0.09, 1)]
    assert "2 gaps, 0.03 s without samples (3 of 11 missing)" in missing_text(recording, 0, 8, gaps)

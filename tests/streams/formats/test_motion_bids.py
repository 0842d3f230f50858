"""Motion-BIDS: a dataset that the official validator passes, read to the last bit, and faults by name."""

import json
import subprocess
import sys
from pathlib import Path

import bids_files
import numpy as np
import pytest
from recording_files import SAMPLES

from fesloop.errors import InputError
from fesloop.streams.files import open_recording
from fesloop.streams.timebase import require_stated_rate

VALIDATOR = Path(sys.executable).with_name("bids-validator-deno")


def refused(path, *words, sensor_set=None):
    with pytest.raises(InputError) as caught:
        open_recording(path, sensor_set)
    text = str(caught.value)
    assert "\n" not in text
    for word in words:
        assert word in text, text


@pytest.mark.skipif(not VALIDATOR.exists(), reason="bids-validator-deno is not installed")
def test_what_is_read_here_is_motion_bids(tmp_path):
    bids_files.write_dataset(tmp_path / "set", latency=True)
    done = subprocess.run([VALIDATOR, tmp_path / "set", "--format", "json", "--ignoreWarnings"],
                          capture_output=True, text=True, check=False, timeout=120)
    issues = json.loads(done.stdout)["issues"]["issues"]
    assert [issue for issue in issues if issue["severity"] == "error"] == []


@pytest.mark.parametrize("latency", [False, True])
def test_samples_come_out_in_si_to_the_last_bit(tmp_path, latency):
    path = bids_files.write_dataset(tmp_path, latency)
    recording = open_recording(path)
    assert recording.sensors == bids_files.POINTS
    assert recording.rate == 100
    assert recording.stamps_ns.tolist() == [k * 10_000_000 for k in range(SAMPLES)]
    assert recording.reference is None
    assert recording.source_units == {"gyr": "deg/s", "acc": "m/s^2", "mag": "uT"}
    for number, (gyr, acc, mag) in enumerate(bids_files.samples().values()):
        np.testing.assert_array_equal(recording.gyr[:, number], gyr * (np.pi / 180.0))
        np.testing.assert_array_equal(recording.acc[:, number], acc)
        np.testing.assert_array_equal(recording.mag[:, number], mag * 1e-6)
    assert np.isnan(recording.gyr[4, 1]).all()


def test_a_folder_and_a_table_are_the_same_recording(tmp_path):
    path = bids_files.write_dataset(tmp_path)
    np.testing.assert_array_equal(open_recording(tmp_path, "imu").gyr, open_recording(path).gyr)
    refused(tmp_path, "'imus'", "imu, optical", sensor_set="imus")
    refused(tmp_path, "no channel of an inertial sensor", sensor_set="optical")


def test_orientations_of_another_system_are_the_reference_when_asked_for(tmp_path):
    bids_files.write_dataset(tmp_path, latency=True)
    reference = open_recording(tmp_path, "imu/optical").reference
    wanted = bids_files.quaternions()
    kept = slice(8, None)  # the first sample of the sensors is at 0.25 s, the optical system's at 0.1 s
    assert reference.stamps_ns[:2].tolist() == [10_000_000, 30_000_000]
    for number, point in enumerate(bids_files.POINTS):
        np.testing.assert_allclose(reference.orientation[:, number], wanted[point][kept], atol=1e-15)
    refused(tmp_path, "ORNT", sensor_set="imu/imu")


def test_descriptions_above_hold_for_files_below(tmp_path):
    path = bids_files.write_dataset(tmp_path)
    for suffix in ("channels.tsv", "motion.json"):
        below = path.with_name(path.name.replace("motion.tsv", suffix))
        below.rename(tmp_path / f"task-grasp_tracksys-imu_{suffix}")
    assert open_recording(path).rate == 100


def change(path, suffix, old, new):
    beside = path.with_name(path.name.replace("motion.tsv", suffix))
    text = beside.read_text()
    assert old in text
    beside.write_text(text.replace(old, new, 1))


FAULTS = [
    ("channels.tsv", "deg/s", "V", ("forearm: gyr", "'V'")),
    ("channels.tsv", "units", "unit", ("channels.tsv: units: is no column",)),
    ("channels.tsv", "forearm_gyr_x\tx\tGYRO", "forearm_gyr_x\ty\tGYRO", ("two channels of gyr y",)),
    ("channels.tsv", "forearm_gyr_x\tx\t", "forearm_gyr_x\tquat_x\t", ("component 'quat_x' of GYRO",)),
    ("channels.tsv", "hand_mag_z\tz\tMAGN\thand\tuT\n", "", ("18 columns, its channels are 17",)),
    ("motion.json", '"SamplingFrequencyEffective": 100', '"SamplingFrequencyEffective": 0',
     ("sampling rate",)),
    ("motion.json", "{", "[", ("motion.json: is no JSON",)),
    ("channels.tsv", "tracked_point\tunits", "units\tunits", ("channels.tsv: tracked_point: is no column",)),
    ("channels.tsv", "name\tcomponent", "name\tname", ("channels.tsv: name: is a column twice",)),
    ("motion.tsv", "n/a", "lost", ("line 5: column", "'lost' is no number")),
    ("motion.tsv", "\t", "\t\t", ("line 1: column 2", "'' is no number")),
]


@pytest.mark.parametrize(("suffix", "old", "new", "words"), FAULTS)
def test_faults_are_named_with_file_and_place(tmp_path, suffix, old, new, words):
    path = bids_files.write_dataset(tmp_path)
    change(path, suffix, old, new)
    refused(path, "sub-01", *words)


def test_a_table_has_one_channel_of_instants_at_most(tmp_path):
    path = bids_files.write_dataset(tmp_path, latency=True)
    change(path, "channels.tsv", "forearm_gyr_x\tx\tGYRO", "forearm_gyr_x\tx\tLATENCY")
    refused(path, "has 2 channels LATENCY")


def with_frequencies(path, numbers):
    """Write a column sampling_frequency beside the channels', of these numbers again and again."""
    beside = path.with_name(path.name.replace("motion.tsv", "channels.tsv"))
    header, *rows = beside.read_text().splitlines()
    each = [numbers[k % len(numbers)] for k in range(len(rows))]
    beside.write_text("\n".join([f"{header}\tsampling_frequency", *(
        f"{row}\t{number}" for row, number in zip(rows, each, strict=True))]) + "\n")


@pytest.mark.parametrize(("key", "other", "left"), [
    ("SamplingFrequencyEffective", "SamplingFrequency", "40"),
    ("SamplingFrequency", "SamplingFrequencyEffective", '"n/a"')])
def test_a_rate_that_is_not_that_of_the_stamps_is_refused(tmp_path, key, other, left):
    """The stamps are at 100 Hz; of two rates that are stated the effective one counts."""
    path = bids_files.write_dataset(tmp_path, latency=True)
    change(path, "motion.json", f'"{other}": 100', f'"{other}": {left}')
    beside = path.with_name(path.name.replace("motion.tsv", "motion.json"))
    text = beside.read_text()
    for stated, taken in ((95.5, True), (104.5, True), (50, False), (0.1, False), (0, True)):
        beside.write_text(text.replace(f'"{key}": 100', f'"{key}": {stated}'))
        if taken:
            assert open_recording(path).rate == 100
        else:
            refused(path, f"{beside}: {key}: states {stated} Hz, the stamps are at 100 Hz", "within 5 %")


@pytest.mark.parametrize("latency", [True, False])
@pytest.mark.parametrize(("numbers", "words"), [
    (("100", "50", "n/a"), ()), (("n/a",), ()), (("50", "60"), ("states 60 Hz", "at 100 Hz")),
    (("100", "fast"), ("line 3: sampling_frequency: 'fast' is no rate",)), (("-1",), ("'-1' is no rate",)),
    (("nan",), ("'nan' is no rate",))])
def test_the_channels_own_rates_are_held_against_the_stamps(tmp_path, latency, numbers, words):
    path = bids_files.write_dataset(tmp_path, latency)
    with_frequencies(path, numbers)
    if words:
        refused(path, "channels.tsv", *words)
    else:
        assert open_recording(path).rate == 100


def test_gaps_and_bursts_are_no_other_rate(tmp_path):
    """A third of the samples lost, or handed on two by two: 100 Hz is stated, and true."""
    even = 0.01 * np.arange(SAMPLES)
    lossy = 0.01 * np.flatnonzero(np.arange(2 * SAMPLES) % 8 < 5)[:SAMPLES]
    bursts = even - np.where(np.arange(SAMPLES) % 2, 0.0099, 0.0)
    for times in (lossy, bursts):
        require_stated_rate(100.0, times, "file")
        with pytest.raises(InputError, match="file: states 200 Hz, the stamps are at"):
            require_stated_rate(200.0, times, "file")


def test_a_folder_that_changes_while_it_is_searched_is_refused(tmp_path, monkeypatch):
    def gone(self, pattern):
        raise FileNotFoundError(2, "No such file or directory", f"{self}/gone")
        yield

    monkeypatch.setattr(Path, "rglob", gone)
    refused(tmp_path, "cannot be searched", "gone: No such file")


def test_recordings_of_a_folder_are_told_apart(tmp_path):
    path = bids_files.write_dataset(tmp_path)
    for file in list(path.parent.iterdir()):
        (path.parent / file.name.replace("task-grasp", "task-point")).write_bytes(file.read_bytes())
    refused(tmp_path, "holds 2 recordings", "path of one")
    assert open_recording(path).samples == SAMPLES
    refused(tmp_path / "none", "no such file")
    (tmp_path / "empty").mkdir()
    refused(tmp_path / "empty", "without a Motion-BIDS recording")


def with_status(path, marked, status="bad", why="n/a"):
    """Add the optional columns of a channel's status: `status` where its name begins with `marked`."""
    beside = path.with_name(path.name.replace("motion.tsv", "channels.tsv"))
    first, *rows = beside.read_text().splitlines()
    told = [f"{row}\t{status}\t{why}" if row.startswith(marked) else f"{row}\tgood\tn/a" for row in rows]
    beside.write_text("\n".join([f"{first}\tstatus\tstatus_description", *told]) + "\n")


@pytest.mark.parametrize(("system", "marked", "sensor_set"), [
    ("imu", "forearm_gyr_x", None), ("imu", "hand_mag_z", None), ("imu", "latency", None),
    ("optical", "forearm_qy", "imu/optical")])
def test_a_bad_channel_is_refused_where_it_is_read(tmp_path, system, marked, sensor_set):
    path = bids_files.write_dataset(tmp_path, latency=True)
    other = path.with_name(path.name.replace("tracksys-imu", f"tracksys-{system}"))
    names = other.with_name(other.name.replace("motion.tsv", "channels.tsv")).read_text()
    assert marked in names
    with_status(other, marked, why="cable broke")
    refused(tmp_path, f"channel {marked}", "status bad (cable broke)", "sensor_set", sensor_set=sensor_set)
    if system == "optical":
        assert open_recording(tmp_path, "imu").sensors == bids_files.POINTS


def test_good_channels_are_read_and_a_status_that_bids_does_not_know_is_refused(tmp_path):
    path = bids_files.write_dataset(tmp_path)
    with_status(path, "forearm_gyr_x", status="n/a")
    assert open_recording(path).sensors == bids_files.POINTS
    change(path, "channels.tsv", "\tgood\t", "\tBAD\t")
    refused(path, "status: 'BAD' is no status", "good, bad or n/a")

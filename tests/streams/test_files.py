"""Readers: what a sound file gives, and that every fault of a file is one line that names it."""

import os
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recording_files import CONTENTS, SAMPLES, write

from fesloop.errors import InputError
from fesloop.streams.files import open_recording

KINDS = list(CONTENTS)
shared = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=60)


def refused(path, *words, sensor_set=None):
    """The file is refused in one line that holds the words."""
    with pytest.raises(InputError) as caught:
        open_recording(path, sensor_set)
    text = str(caught.value)
    assert "\n" not in text
    for word in words:
        assert word in text
    return text


@pytest.mark.parametrize("kind", KINDS)
def test_a_sound_file_is_known_by_its_content(tmp_path, kind):
    recording = open_recording(write(tmp_path, kind))
    assert recording.source_format == kind
    assert recording.samples == SAMPLES
    assert recording.gyr.shape == recording.acc.shape == (SAMPLES, len(recording.sensors), 3)
    assert not recording.gyr.flags.writeable
    assert np.median(np.linalg.norm(recording.acc, axis=-1)) == pytest.approx(9.81, rel=0.02)


def test_units_rates_and_reference_of_broad(tmp_path):
    recording = open_recording(write(tmp_path, "broad"))
    assert recording.rate == Fraction(2000, 7)
    assert recording.stamps_ns[:3].tolist() == [0, 3_500_000, 7_000_000]
    assert np.median(np.linalg.norm(recording.mag, axis=-1)) == pytest.approx(44.7e-6, rel=0.02)
    assert np.isnan(recording.reference.orientation[5]).all()
    assert recording.reference.north


def test_evenly_spaced_times_give_an_exact_rate(tmp_path):
    recording = open_recording(write(tmp_path, "body16"))
    assert recording.rate == 100
    assert recording.stamps_ns.tolist() == [k * 10_000_000 for k in range(SAMPLES)]
    assert recording.pairs == ((0, 1),)
    assert recording.reference is None


def test_uneven_times_are_kept_as_they_are(tmp_path):
    content = CONTENTS["body16"]()
    content["t"] = content["t"].copy()
    content["t"][7] += 0.004
    recording = open_recording(write(tmp_path, "body16", content))
    assert recording.rate is None
    assert recording.stamps_ns[7] == 74_000_000


@pytest.mark.parametrize("name", ["rigid", "nonrigid"])
def test_chain5_offers_two_sensor_sets(tmp_path, name):
    recording = open_recording(write(tmp_path, "chain5"), name)
    assert recording.sensor_set == name
    expected = CONTENTS["chain5"]()[f"imu_{name}"][:, 3:6]
    np.testing.assert_array_equal(recording.gyr[:, 0], expected.astype(float))
    assert recording.reference.stamps_ns.size == 30


def test_columns_are_found_by_name(tmp_path):
    content = CONTENTS["wrist"]()
    order = [3, 4, 5, 0, 1, 2]
    content["imu_cols"] = content["imu_cols"][order]
    for segment in ("carpus", "radius"):
        content[f"imu_{segment}"] = content[f"imu_{segment}"][:, order]
    recording = open_recording(write(tmp_path, "wrist", content))
    np.testing.assert_array_equal(recording.acc, open_recording(write(tmp_path, "wrist", name="plain")).acc)


@pytest.mark.parametrize("kind", KINDS)
def test_an_unknown_sensor_set_is_refused(tmp_path, kind):
    refused(write(tmp_path, kind), "sensor_set", "'foam'", sensor_set="foam")


def test_what_is_no_file_or_no_recording_is_refused(tmp_path):
    refused(tmp_path / "absent.mat", "absent.mat", "no such file")
    refused(tmp_path, "is a folder")
    os.mkfifo(tmp_path / "pipe")
    refused(tmp_path / "pipe", "is no file")
    for name, content, word in (("empty", b"", "empty"), ("text", b"time,gyr\n0,1\n", "with a layout"),
                                ("hdf5", b"\x89HDF\r\n\x1a\n" + bytes(200), "damaged"),
                                ("zip", b"PK\x03\x04" + bytes(200), "corrupt"),
                                ("xdfz", b"\x1f\x8b\x08" + bytes(20), "gunzip")):
        path = tmp_path / name
        path.write_bytes(content)
        refused(path, name, word)
    np.savez(tmp_path / "other.npz", speed=np.ones(3))
    refused(tmp_path / "other.npz", "no recording of a known format", "speed")


def test_pickled_objects_are_refused(tmp_path):
    content = CONTENTS["wrist"]()
    content["imu_carpus"] = np.array([{"code": 1}], dtype=object)
    refused(write(tmp_path, "wrist", content), "imu_carpus", "pickled")


def changed(key, change):
    return lambda content: content.__setitem__(key, change(np.array(content[key])))


def with_infinity(array):
    array = array.astype(float)
    array[[3, 9], 0] = -np.inf
    return array


def backwards(array):
    array[5] = array[4] - 0.001
    return array


FAULTS = [
    ("broad", changed("imu_gyr", with_infinity), ("imu_gyr", "infinite in sample 3", "NaN where")),
    ("broad", changed("imu_mag", lambda a: np.nan * a), ("imu_mag", "no sample at all")),
    ("broad", changed("imu_gyr", lambda a: np.rad2deg(300 * a)), ("imu_gyr", "rad/s", "deg/s")),
    ("broad", changed("imu_acc", lambda a: a / 9.81), ("imu_acc", "m/s^2", "gravity")),
    ("broad", changed("imu_mag", lambda a: 1e-6 * a), ("imu_mag", "uT")),
    ("broad", changed("imu_acc", lambda a: a[:-1]), ("imu_acc", "39 samples", "imu_gyr has 40")),
    ("broad", changed("imu_acc", lambda a: a[:, :2]), ("imu_acc", "(40, 2)", "(any, 3)")),
    ("broad", changed("imu_acc", lambda a: a.astype(complex)), ("imu_acc", "complex128")),
    ("broad", changed("opt_quat", lambda a: 3 * a), ("opt_quat", "not of length 1", "row 0")),
    ("broad", changed("opt_quat", lambda a: np.nan * a), ("opt_quat", "no orientation")),
    ("broad", changed("movement", lambda a: 0 * a), ("movement",)),
    ("broad", changed("sampling_rate", lambda a: -a), ("sampling_rate", "sampling rate")),
    ("broad", changed("sampling_rate", lambda a: a * np.nan), ("sampling_rate",)),
    ("body16", changed("t", backwards), ("t", "sample 5", "increasing")),
    ("body16", changed("t", lambda a: a[:1]), ("t", "shape ()")),
    ("body16", changed("t", lambda a: 1e6 * a), ("t", "sampling rate")),
    ("body16", lambda c: c["hand_left"].pop("gyr"), ("hand_left: gyr", "missing")),
    ("body16", lambda c: c.__setitem__("note", "a word"), ("note", "not a sensor")),
    ("chain5", changed("imu_rigid", lambda a: a[:, :44]), ("imu_rigid", "44 columns", "45")),
    ("chain5", changed("omc_cols", lambda a: np.char.replace(a, "3_quat_w", "w")), ("omc_cols", "3_quat_w")),
    ("chain5", changed("imu_rigid_hz", lambda a: 0 * a), ("imu_rigid_hz", "sampling rate")),
    ("wrist", changed("gt_radius", lambda a: a[:-1]), ("gt_", "39")),
    ("wrist", changed("gt_radius", lambda a: a + np.eye(5)[0]), ("gt_carpus", "other times")),
    ("wrist", changed("imu_cols", lambda a: a[:5]), ("imu_cols", "gyr_z")),
]


@pytest.mark.parametrize(("kind", "spoil", "words"), FAULTS)
def test_each_fault_is_named_with_file_and_key(tmp_path, kind, spoil, words):
    content = CONTENTS[kind]()
    spoil(content)
    path = write(tmp_path, kind, content)
    refused(path, str(path), *words)


@pytest.mark.parametrize("kind", KINDS)
def test_a_missing_key_is_named(tmp_path, kind):
    for key in CONTENTS[kind]():
        if (kind == "body16" and key != "t") or "nonrigid" in key:
            continue  # a file with fewer sensors is a sound file
        content = CONTENTS[kind]()
        del content[key]
        assert key in refused(write(tmp_path, kind, content))


@pytest.mark.parametrize("kind", KINDS)
@given(share=st.floats(0.0, 0.999))
@shared
def test_a_truncated_file_is_refused_in_one_line(tmp_path, kind, share):
    whole = write(tmp_path, kind).read_bytes()
    path = tmp_path / "cut"
    path.write_bytes(whole[:int(share * len(whole))])
    refused(path, "cut")


@pytest.mark.parametrize("kind", KINDS)
@given(at=st.floats(0.0, 0.999), bits=st.integers(1, 255), width=st.integers(1, 16))
@shared
def test_a_corrupt_file_is_read_or_refused_but_never_a_crash(tmp_path, kind, at, bits, width):
    content = bytearray(write(tmp_path, kind).read_bytes())
    start = int(at * len(content))
    for i in range(start, min(start + width, len(content))):
        content[i] ^= bits
    path = tmp_path / "spoilt"
    path.write_bytes(bytes(content))
    try:
        recording = open_recording(path)
    except InputError:
        return
    assert np.isfinite(recording.gyr).all()

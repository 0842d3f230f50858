"""The motion file: what is written comes back bit for bit, and what is damaged is named."""

import json
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording_files import CONTENTS, write

from fesloop.errors import InputError
from fesloop.streams.files import import_recording, open_recording
from fesloop.streams.motion_file import read_motion_file, write_motion_file
from fesloop.streams.recording import MotionRecording, Reference

DOUBLES = st.floats(allow_nan=True, allow_infinity=False)


def same(one, other):
    """All that two recordings hold is equal bit for bit."""
    for name in ("source_format", "sensor_set", "sensors", "rate", "pairs", "source_units"):
        assert getattr(one, name) == getattr(other, name), name
    for name in ("stamps_ns", "gyr", "acc", "mag"):
        first, second = getattr(one, name), getattr(other, name)
        assert (first is None) == (second is None)
        assert first is None or (first.dtype, first.shape, first.tobytes()) == (
            second.dtype, second.shape, second.tobytes()), name
    if one.reference is None:
        assert other.reference is None
        return
    for name in ("stamps_ns", "orientation", "scored"):
        assert getattr(one.reference, name).tobytes() == getattr(other.reference, name).tobytes()
    assert (one.reference.sensor_frames, one.reference.north) == (
        other.reference.sensor_frames, other.reference.north)


@pytest.mark.parametrize("kind", list(CONTENTS))
def test_what_is_written_comes_back_bit_for_bit(tmp_path, kind):
    recording = open_recording(write(tmp_path, kind))
    write_motion_file(recording, tmp_path / "motion.h5")
    again = open_recording(tmp_path / "motion.h5")
    same(recording, again)
    assert again.source == "trial.dat"
    with h5py.File(tmp_path / "motion.h5") as file:
        assert file.attrs["format"] == "fesloop motion 1"
        np.testing.assert_array_equal(file["gyr"][:], recording.gyr)
        assert json.loads(file.attrs["sensors"]) == list(recording.sensors)


def test_a_motion_file_that_is_imported_keeps_its_first_source(tmp_path):
    import_recording(write(tmp_path, next(iter(CONTENTS))), tmp_path / "first.h5")
    import_recording(tmp_path / "first.h5", tmp_path / "second.h5")
    assert open_recording(tmp_path / "second.h5").source == "trial.dat"


@given(values=st.lists(DOUBLES, min_size=12, max_size=12), steps=st.lists(st.integers(1, 2**40), max_size=3),
       rate=st.none() | st.fractions(min_value=1, max_value=1000))
@settings(max_examples=25, deadline=None)
def test_every_double_every_stamp_and_every_rate_survives(tmp_path_factory, values, steps, rate):
    folder = tmp_path_factory.mktemp("motion")
    stamps = np.cumsum([0, *steps])
    samples = np.resize(np.array(values), (stamps.size, 2, 3))
    reference = Reference(stamps_ns=stamps, orientation=np.tile([1.0, 0, 0, 0], (stamps.size, 2, 1)),
                          scored=stamps > 5, sensor_frames=False, north=True)
    recording = MotionRecording(
        path=Path("x"), source_format="made", sensor_set="a set", sensors=("höher", "b"), rate=rate,
        stamps_ns=stamps, gyr=samples, acc=-samples, mag=None, reference=reference, pairs=((1, 0),),
        source_units={"gyr": "°/s"})
    write_motion_file(recording, folder / "m.h5")
    same(recording, read_motion_file(folder / "m.h5"))


def test_nothing_is_written_over_and_no_draft_is_left(tmp_path):
    recording = open_recording(write(tmp_path, "broad"))
    (tmp_path / "there").write_text("mine")
    with pytest.raises(InputError, match="exists"):
        write_motion_file(recording, tmp_path / "there")
    assert (tmp_path / "there").read_text() == "mine"
    with pytest.raises(InputError, match="cannot be written"):
        write_motion_file(recording, tmp_path / "there" / "below")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there", "trial.dat"]


@pytest.mark.parametrize("place", [".", "/"])
def test_a_folder_without_a_name_is_no_target(place, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="exists; allowed: a new name"):
        write_motion_file(open_recording(write(tmp_path, "broad")), Path(place))


def test_a_source_may_have_any_bytes_for_a_name(tmp_path):
    source = write(tmp_path, "broad", name="caf\udce9")
    write_motion_file(open_recording(source), tmp_path / "m.h5")
    assert open_recording(tmp_path / "m.h5").source == "caf?.dat"


FAULTS = [
    (lambda f: f.attrs.create("source", b"a\x80b", dtype=h5py.string_dtype()), "source: is no text"),
    (lambda f: f.attrs.__setitem__("rate", "1/0"), "rate: '1/0'"),
    (lambda f: f.attrs.__setitem__("rate", "1e999999999"), "rate: '1e999999999'"),
    (lambda f: f.attrs.__setitem__("sensors", "[1]"), "sensors: does not hold names"),
    (lambda f: f.attrs.__setitem__("sensors", "{"), "sensors: is no JSON"),
    (lambda f: f.attrs.__setitem__("sensors", '["a", "a"]'), "sensors: 2 names"),
    (lambda f: f.__delitem__("gyr"), "gyr: is missing"),
    (lambda f: f.__setitem__("mag", np.zeros((3, 1, 3))), r"mag: is of float64 with shape \(3, 1, 3\)"),
    (lambda f: f.__setitem__("mag", h5py.ExternalLink("other.h5", "mag")), "mag: is a link"),
    (lambda f: f.create_dataset("pairs", data=np.array([[0, 7]])), "names a sensor that does not exist"),
    (lambda f: f["reference"].attrs.__delitem__("north"), "reference: north: is missing"),
    (lambda f: f["reference/scored"].resize((3,)), "scored"),
]


@pytest.mark.parametrize(("spoil", "words"), FAULTS)
def test_what_is_not_of_the_form_is_named(tmp_path, spoil, words):
    write_motion_file(open_recording(write(tmp_path, "broad")), tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5", "a") as file:
        for name in ("mag", "pairs"):
            del file[name]
        if "scored" in words:
            del file["reference/scored"]
            file["reference/scored"] = np.ones(3, np.uint8)
        else:
            spoil(file)
        if "pairs" not in file:
            file["pairs"] = np.zeros((0, 2), np.int64)
    with pytest.raises(InputError, match=words) as caught:
        open_recording(tmp_path / "m.h5")
    assert str(tmp_path / "m.h5") in str(caught.value)


def test_a_bit_that_a_disk_turned_is_seen(tmp_path):
    path = tmp_path / "m.h5"
    write_motion_file(open_recording(write(tmp_path, "broad")), path)
    with h5py.File(path) as file:
        chunk = file["gyr"].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 4
    path.write_bytes(bytes(content))
    with pytest.raises(InputError, match="gyr: cannot be read"):
        open_recording(path)


def test_a_rate_is_exact(tmp_path):
    write_motion_file(open_recording(write(tmp_path, "broad")), tmp_path / "m.h5")
    assert open_recording(tmp_path / "m.h5").rate == Fraction(2000, 7)

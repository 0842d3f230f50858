"""The file of stimulated muscle: what is written comes back bit for bit, and what is damaged is named."""

import json

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from stimulation_parts import recording, recordings_of_all_kinds, require_same

from fesloop.errors import InputError
from fesloop.streams.files import open_recording
from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.stored import write_stimulation

IN_A_FOLDER = settings(max_examples=40, deadline=None,
                       suppress_health_check=[HealthCheck.function_scoped_fixture])


@given(made=recordings_of_all_kinds())
@IN_A_FOLDER
def test_what_is_written_comes_back_bit_for_bit(tmp_path, made):
    path = tmp_path / "person.h5"
    path.unlink(missing_ok=True)
    write_stimulation(made, path)
    require_same(open_stimulation(path), made)


def test_it_is_no_recording_of_motion(tmp_path):
    write_stimulation(recording(np.random.default_rng(1)), tmp_path / "person.h5")
    with pytest.raises(InputError, match="is a recording of stimulated muscle"):
        open_recording(tmp_path / "person.h5")


def test_no_file_is_written_over(tmp_path):
    made = recording(np.random.default_rng(1))
    write_stimulation(made, tmp_path / "person.h5")
    with pytest.raises(InputError, match="exists"):
        write_stimulation(made, tmp_path / "person.h5")
    assert [path.name for path in tmp_path.iterdir()] == ["person.h5"]


def _without(name):
    def change(file):
        del file[name]
    return change


def _attribute(place, name, value):
    def change(file):
        (file[place] if place else file).attrs[name] = value
    return change


def _replaced(name, values):
    def change(file):
        del file[name]
        file[name] = values
    return change


@pytest.mark.parametrize(("change", "fault"), [
    (_without("steady/angle_rad"), "steady: angle_rad: is missing"),
    (_without("zero_rad"), "zero_rad: is missing"),
    (_without("courses"), "courses: is missing"),
    (_without("forces/0/pulses_s"), "forces: 0: pulses_s: is missing"),
    (_replaced("steady/current_a", np.zeros(3)), "current_a: has 3 trials, others have 12"),
    (_replaced("steady/current_a", np.zeros(12, np.float32)), "current_a: is of float32"),
    (_replaced("steady/visit", np.zeros(12)), "visit: is of float64"),
    (_replaced("steady/posture", np.full(12, 2)), "posture_codes: do not fit"),
    (_attribute("steady", "posture_codes", "{"), "posture_codes: do not fit"),
    (_attribute("steady", "baseline", json.dumps("mean")), "baseline: is not of its form"),
    (_attribute("", "muscles", json.dumps(["biceps", "biceps"])), "'biceps' is listed twice"),
    (_attribute("", "muscles", json.dumps(["biceps", 1])), "muscles: is not of its form"),
    (_attribute("", "joints", json.dumps(["elbow", "wrist"])), "does not say which way is positive"),
    (_attribute("", "frequency_hz", "0.0"), "frequency_hz: 0.0"),
    (_attribute("", "format", "fesloop stimulation 9"), "has the format 'fesloop stimulation 9'"),
    (_attribute("courses/0", "period_s", "-1.0"), "period_s: -1.0"),
    (_attribute("courses/0", "muscle", "7"), "courses: ramp: muscle: 7"),
])
def test_what_is_wrong_is_named_in_one_line(tmp_path, change, fault):
    path = tmp_path / "person.h5"
    write_stimulation(recording(np.random.default_rng(1)), path)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InputError) as caught:
        open_stimulation(path)
    assert fault in str(caught.value)
    assert str(caught.value).startswith(str(path))


@given(where=st.integers(0, 10**6), byte=st.integers(0, 255), cut=st.booleans())
@settings(IN_A_FOLDER, max_examples=25)
def test_a_damaged_file_is_refused_or_read_as_it_was(tmp_path, where, byte, cut):
    path, made = tmp_path / "person.h5", recording(np.random.default_rng(1))
    path.unlink(missing_ok=True)
    write_stimulation(made, path)
    content = bytearray(path.read_bytes())
    where %= len(content)
    path.write_bytes(content[:where] if cut else content[:where] + bytes([byte]) + content[where + 1:])
    try:
        found = open_stimulation(path)
    except InputError as fault:
        assert "\n" not in str(fault)  # noqa: PT017
    else:  # a byte that nothing reads, or that is in a text
        assert len(found.steady) == len(made.steady)

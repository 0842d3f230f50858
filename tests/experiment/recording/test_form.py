"""Recordings that a disk damaged, or that are not of the form, are refused in one line; about 15 s."""

import json
from contextlib import suppress

import h5py
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.form import undamaged
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """A short run's file."""
    experiment = load("finger_pid_latency", ["experiment.duration_s=0.6"])
    return run(experiment, tmp_path_factory.mktemp("run")).recording


def read_all(path):
    with Recording(path) as recording:
        read = [recording.status, recording.wall, recording.events, recording.messages, recording.digest(),
                recording.step_times_ns, recording.trials]
        for name in recording.signals:
            signal = recording.signal(name)
            list(recording.tables([name])[0].pieces())
            read.append(signal.values.shape)
    return read


def rewrite(file, name, **changes):
    """A dataset anew, with other rows or another attribute."""
    rows, told = file[name][()], dict(file[name].attrs)
    del file[name]
    made = file.create_dataset(name, data=changes.get("rows", lambda rows: rows)(rows))
    made.attrs.update(told | changes.get("told", {}))


def without(rows, field):
    return rows[[name for name in rows.dtype.names if name != field]].copy()


def in_trial(number):
    def change(rows):
        rows["trial"][-1] = number
        return rows
    return change


TRACKER = "blocks/tracker"
FAULTS = {
    "experiment: is missing": lambda f: f.__delitem__("experiment"),
    "experiment: is damaged": lambda f: f["experiment"].__setitem__((), "{"),
    "events: is missing": lambda f: f.__delitem__("events"),
    "seed: is missing": lambda f: f.attrs.__delitem__("seed"),
    "versions: is damaged": lambda f: f.attrs.__setitem__("versions", "[]"),
    "wires: is damaged": lambda f: f.attrs.__setitem__("wires", "{"),
    "events: has rows of": lambda f: rewrite(f, "events", rows=lambda rows: without(rows, "where")),
    "blocks/tracker: has rows of": lambda f: rewrite(f, TRACKER, rows=lambda rows: without(rows, "left_ns")),
    "blocks/tracker: units: is damaged": lambda f: rewrite(f, TRACKER, told={"units": "["}),
    "blocks/tracker: has rows": lambda f: rewrite(f, TRACKER, told={"units": json.dumps({"x": "1"})}),
    "trials in fewer rows": lambda f: rewrite(f, TRACKER, rows=in_trial(2**30)),
    "blocks: is no group": lambda f: (f.__delitem__("blocks"), f.__setitem__("blocks", 1)),
    "blocks: tracker: is a link": lambda f: (f.__delitem__("blocks/tracker"), f.__setitem__(
        "blocks/tracker", h5py.ExternalLink("other.h5", "x"))),
    "bytes more than the file": lambda f: f["events"].resize((10**7,)),
}


@pytest.mark.parametrize("words", list(FAULTS))
def test_what_is_not_of_the_form_is_named(tmp_path, sound, words):
    path = tmp_path / "run.h5"
    with h5py.File(sound) as old, h5py.File(path, "w", libver="latest") as new:
        for name in old:
            old.copy(name, new)
        new.attrs.update(dict(old.attrs))
    assert read_all(path) == read_all(sound)
    with h5py.File(path, "a") as file:
        FAULTS[words](file)
    with pytest.raises(InputError) as caught:
        read_all(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@given(at=st.floats(0.0, 0.9999), bits=st.integers(1, 255), width=st.integers(1, 16))
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_damaged_recording_is_read_or_refused(tmp_path, sound, at, bits, width):
    content = bytearray(sound.read_bytes())
    start = int(at * len(content))
    for i in range(start, min(start + width, len(content))):
        content[i] ^= bits
    path = tmp_path / "run.h5"
    path.write_bytes(bytes(content))
    with suppress(InputError):
        read_all(path)


def test_a_fault_of_ones_own_is_not_taken_for_damage():
    with pytest.raises(InputError, match=r"^mine"), undamaged("file"):
        raise InputError("mine", "found")
    with pytest.raises(ZeroDivisionError), undamaged("file"):
        _ = 1 // 0
    with pytest.raises(InputError, match="file: is damaged: no chunk"), undamaged("file"):
        raise OSError("no\nchunk")

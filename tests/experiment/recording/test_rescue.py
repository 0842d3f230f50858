"""What is left of a recording that was cut short is as it was."""

import h5py
import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.rescue import rescued
from fesloop.experiment.running import run

STREAMS = ("blocks/controller", "blocks/tracker", "plants/patient", "inputs/patient/stimulation", "events")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(load("finger_ilc", ["trials=3"]), tmp_path_factory.mktemp("runs")).recording


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_rows_that_are_left_are_the_first_ones_unchanged(whole, tmp_path, share):
    path = tmp_path / "cut.h5"
    path.write_bytes(whole.read_bytes()[:int(share * whole.stat().st_size)])
    with rescued(path) as found, h5py.File(found.path) as left, h5py.File(whole) as every:
        lost = 0
        for name in STREAMS:
            rows = left[name][:]
            assert np.array_equal(rows, every[name][:len(rows)])
            lost += len(every[name]) - len(rows)
        assert lost
        assert 0 < len(left["plants/patient"]) < len(every["plants/patient"])
    assert not found.path.exists()


def behind(path, names):
    """Where in a file the chunks of some datasets end, bytes."""
    ends = []
    with h5py.File(path) as file:
        for name in names:
            file[name].id.chunk_iter(lambda chunk: ends.append(chunk.byte_offset + chunk.size))
    return max(ends)


def test_what_is_said_to_be_lost_is_what_is_missing(whole, tmp_path):
    """Cut where the table of messages, which every trial adds to, is there and the last trial is not."""
    path, size = tmp_path / "cut.h5", behind(whole, ["messages", "events"])
    path.write_bytes(whole.read_bytes()[:size])
    with rescued(path) as found, h5py.File(found.path) as left, h5py.File(whole) as every:
        nodes = [f"{kind}/{name}" for kind in ("blocks", "plants") for name in every[kind]]
        begun = 1 + max(left[name]["trial"][-1] for name in nodes if len(left[name]))
        assert begun < every["messages"]["trial"][-1] + 1
        for name in ("messages", "events"):
            assert np.array_equal(left[name][:], every[name][every[name]["trial"] < begun])
        short = [f"The file was cut short: {size:,} of {whole.stat().st_size:,} bytes are there."]
        short += [f"Of `{name}` {len(left[name]):,} of {len(every[name]):,} rows are left."
                  for name in (*nodes, "inputs/patient/stimulation") if len(left[name]) < len(every[name])]
        short += [f"Of trials from {begun} on nothing but `{name}` is left, which is not shown."
                  for name in ("messages", "events")]
        assert sorted(found.losses) == sorted(short)


def test_a_stream_that_is_whole_is_not_said_to_be_lost(whole, tmp_path):
    path = tmp_path / "cut.h5"
    path.write_bytes(whole.read_bytes()[:-40_000])
    with rescued(path) as found, h5py.File(found.path) as left, h5py.File(whole) as every:
        assert len(left["blocks/reference"]) == len(every["blocks/reference"])
        assert not any("reference" in text for text in found.losses)
        assert {name: item[()] for name, item in left["wall"].items()} == {
            name: item[()] for name, item in every["wall"].items()}


def test_it_is_a_recording_of_its_own(whole, tmp_path):
    path = tmp_path / "cut.h5"
    path.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
    with rescued(path) as found, Recording(found.path) as left, Recording(whole) as every:
        assert left.status == "damaged"
        assert left.experiment == every.experiment
        assert 1 <= left.trials <= every.trials
        assert len(left.messages) <= left.trials


@pytest.mark.parametrize("name", ["padded.h5", "whole.h5"])
def test_a_file_may_have_any_name(whole, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
    with rescued(path) as found, Recording(found.path) as left:
        assert found.path.name == name
        assert left.trials


def test_a_file_that_has_lost_its_beginning_is_refused(whole, tmp_path):
    path = tmp_path / "late.h5"
    path.write_bytes(whole.read_bytes()[1000:])
    with pytest.raises(InputError, match="does not begin"), rescued(path):
        pass

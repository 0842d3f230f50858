"""What is left of a recording that was cut short is as it was."""

import h5py
import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.rescue import rescued
from fesloop.experiment.running.trial import run

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
        assert len(found.losses) > 1
    assert not found.path.exists()


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

"""Opening a file at any moment of its writer's work."""

from pathlib import Path

import pytest

import fesloop
from fesloop import InputError
from fesloop.experiment.recording import reading as opening

SMALL = Path(__file__).parents[1] / "small.toml"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return fesloop.load(SMALL).run(tmp_path_factory.mktemp("runs")).recording.read_bytes()


@pytest.fixture
def waits(monkeypatch):
    """Instead of waiting, the next of these is done."""
    due = []
    monkeypatch.setattr(opening.time, "sleep", lambda seconds: due.pop(0)())
    return due


def test_a_file_that_its_writer_is_about_to_lengthen(recorded, tmp_path, waits):
    path = tmp_path / "short.h5"
    path.write_bytes(recorded[:-1000])
    waits += [lambda: None, lambda: path.write_bytes(recorded)]
    with opening.open_file(path) as file:
        assert file["status"][()] == b"done"
    assert not waits


def test_a_file_that_stays_too_short(recorded, tmp_path, waits):
    path = tmp_path / "short.h5"
    path.write_bytes(recorded[:-1000])
    waits += [lambda: None] * 3
    with pytest.raises(InputError, match="truncated file"):
        opening.open_file(path)
    assert not waits


def test_what_is_no_file_of_hdf5_is_not_waited_for(tmp_path, waits):
    path = tmp_path / "text.h5"
    path.write_text("no recording")
    with pytest.raises(InputError, match="is no HDF5 file"):
        opening.open_file(path)
    assert not waits

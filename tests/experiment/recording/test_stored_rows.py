"""Rows of a dataset, kept or read from the file, are those that were written."""

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.experiment.recording import stored_rows
from fesloop.experiment.recording.stored_rows import Column, StoredRows

TYPE = np.dtype([("trial", "<i4"), ("time_ns", "<i8"), ("angles", "<f8", (3,)), ("force", "<f8")])
WRITTEN = np.zeros(100, TYPE)
WRITTEN["trial"] = np.repeat([0, 1, 1, 3], 25)
WRITTEN["time_ns"] = np.arange(100)
WRITTEN["angles"] = np.random.default_rng(1).normal(size=(100, 3))
WRITTEN["force"] = np.arange(100) ** 0.5


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    with h5py.File(tmp_path_factory.mktemp("rows") / "rows.h5", "w") as file:
        yield file.create_dataset("rows", data=WRITTEN, maxshape=(None,), chunks=(7,))


@pytest.mark.parametrize("room", [0, WRITTEN.nbytes - 1, WRITTEN.nbytes])
@pytest.mark.parametrize("a_read", [3, 65536])
def test_fields_are_those_written(dataset, monkeypatch, room, a_read):
    monkeypatch.setattr(stored_rows, "_ROWS_A_READ", a_read)
    rows = StoredRows(dataset, room)
    assert rows.kept_bytes == (WRITTEN.nbytes if room >= WRITTEN.nbytes else 0)

    @given(st.sampled_from(TYPE.names), st.integers(0, 100), st.integers(0, 100))
    @settings(max_examples=30, deadline=None)
    def check(field, one, other):
        first, stop = sorted((one, other))
        found = rows.read(field, first, stop)
        assert found.dtype == TYPE[field].base
        assert found.flags.c_contiguous
        assert np.array_equal(found, WRITTEN[field][first:stop])
        found[...] = -1  # the caller's own: whoever reads next finds what was written
        assert np.array_equal(rows.read(field, first, stop), WRITTEN[field][first:stop])

    check()


@pytest.mark.parametrize("room", [0, WRITTEN.nbytes])
def test_trials_are_spans_of_rows(dataset, room):
    rows = StoredRows(dataset, room)
    assert [rows.span(trial) for trial in range(5)] == [(0, 25), (25, 75), (75, 75), (75, 100), (100, 100)]


@pytest.mark.parametrize("room", [0, WRITTEN.nbytes])
def test_a_column_gives_slices_of_its_span(dataset, room):
    column = Column(StoredRows(dataset, room), "angles", 25, 75)
    assert column.shape == (50, 3)
    for rows in (slice(None), slice(10, 20), slice(45, 80), slice(7, 7), slice(-5, None)):
        assert np.array_equal(column[rows], WRITTEN["angles"][25:75][rows])

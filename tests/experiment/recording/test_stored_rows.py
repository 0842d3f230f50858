"""Rows of a dataset, kept or read from the file, are those that were written."""

import h5py
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fesloop.experiment.recording import reading as stored_rows
from fesloop.experiment.recording.reading import Column, StoredRows

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
def test_a_dataset_without_rows_has_trials_and_columns_without_rows(tmp_path, room):
    with h5py.File(tmp_path / "empty.h5", "w") as file:
        rows = StoredRows(file.create_dataset("rows", shape=(0,), dtype=TYPE, maxshape=(None,)), room)
        assert [rows.span(trial) for trial in range(3)] == [(0, 0)] * 3
        column = Column(rows, "angles", 0, 0)
        assert [column[part].shape for part in (slice(None), slice(3, 5), slice(5, 3))] == [(0, 3)] * 3


ENDS = st.none() | st.integers(-120, 120)


@pytest.mark.parametrize("room", [0, WRITTEN.nbytes])
@given(st.tuples(st.integers(0, 100), st.integers(0, 100)).map(sorted), ENDS, ENDS)
@example([25, 75], 30, 10)
@example([25, 75], None, None)
@settings(max_examples=50, deadline=None)
def test_a_column_is_sliced_like_the_array_of_its_span(dataset, room, span, start, stop):
    """Empty stretches, and ends that come before their start, too."""
    column = Column(StoredRows(dataset, room), "angles", *span)
    written = WRITTEN["angles"][slice(*span)]
    assert column.shape == written.shape
    found = column[start:stop]
    assert found.shape == written[start:stop].shape
    assert np.array_equal(found, written[start:stop])

"""The newest rows of a stream that grows are there once each, and no more than can be shown."""

import h5py
import numpy as np
import pytest

from fesloop.show.view.followed import GrowingStream


@pytest.fixture
def dataset(tmp_path):
    with h5py.File(tmp_path / "rows.h5", "w", libver="latest") as file:
        made = file.create_dataset("rows", (0,), dtype="i8", maxshape=(None,), chunks=(64,))
        file.swmr_mode = True
        yield made


def grow(dataset, count):
    """Add rows that count on."""
    first = len(dataset)
    dataset.resize(first + count, axis=0)
    dataset[first:] = np.arange(first, first + count)
    dataset.flush()


def test_rows_are_forgotten_from_the_front(dataset):
    stream = GrowingStream(dataset)
    assert not stream.refresh()
    for count in (10, 3990, 1, 2500, 9000):
        grow(dataset, count)
        assert stream.refresh()
        assert not stream.refresh()
        last = len(dataset)
        assert stream.rows.tolist() == list(range(max(0, last - 4000), last))


def test_what_was_written_long_before_is_not_read(dataset):
    grow(dataset, 9000)
    stream = GrowingStream(dataset)
    stream.refresh()
    assert stream.rows.tolist() == list(range(5000, 9000))

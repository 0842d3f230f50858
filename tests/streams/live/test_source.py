"""Opening, losing and finding a stream again, and its clock, on a library that a test plays."""

import time

import numpy as np
import pytest
from lsl_parts import AHEAD_S, Info, Library

from fesloop.errors import InputError
from fesloop.streams.live import source as source_module
from fesloop.streams.live.query import StreamQuery, find
from fesloop.streams.live.source import LslSource, StreamLost, monotonic_offset_ns


@pytest.fixture
def library(monkeypatch):
    made = Library()
    for module in ("source", "query"):
        monkeypatch.setattr(f"fesloop.streams.live.{module}.open_library", lambda network: made)
    return made


def opened(library):
    query = StreamQuery(name="imus", type="IMU")
    return LslSource(query, find(query))


def test_the_clocks_are_brought_together():
    offset = monotonic_offset_ns(lambda: time.monotonic() + AHEAD_S)
    assert offset == pytest.approx(-AHEAD_S * 1e9, abs=100_000)


def test_a_stamp_is_brought_to_our_clock_with_the_senders_offset(library):
    library.correction_s = -100.0
    stream = opened(library)
    now = time.monotonic()
    library.pulls = [(np.array([1.0, 2.0], dtype=np.float32), now + AHEAD_S + 100.0)]
    values, stamp_ns = stream.pull(0.0)
    assert values.tolist() == [1.0, 2.0]
    assert values.dtype == np.float64
    assert stamp_ns == pytest.approx(now * 1e9, abs=200_000)
    assert stream.pull(0.0) is None
    assert library.predicate == "name='imus' and type='IMU'"


def test_the_offset_is_asked_for_anew_now_and_then(library, monkeypatch):
    stream = opened(library)
    library.correction_s = 7.0
    sample = (np.zeros(2), 50.0)
    library.pulls = [sample, sample, sample]
    before = stream.pull(0.0).stamp_ns
    monkeypatch.setattr(source_module, "_CLOCK_EVERY_NS", 0)
    after = stream.pull(0.0).stamp_ns
    assert after - before == pytest.approx(7e9, abs=200_000)


@pytest.mark.parametrize("stamp", [np.nan, np.inf, -np.inf, 1e300])
def test_a_stamp_that_is_no_time_lies_before_everything(library, stamp):
    stream = opened(library)
    library.pulls = [(np.zeros(2), stamp)]
    assert stream.pull(0.0).stamp_ns == -1


def test_a_loss_lasts_until_the_same_stream_is_open_again(library):
    stream = opened(library)
    library.pulls = [RuntimeError("lost")]
    for _ in range(2):
        with pytest.raises(StreamLost):
            stream.pull(0.0)
    library.found = []
    with pytest.raises(StreamLost, match=r"^$"):
        stream.reopen()
    library.found = [Info(channels=5)]
    for _ in range(2):
        with pytest.raises(StreamLost, match=r"5 channels.*not those of before"):
            stream.reopen()
    library.found = [Info(), Info()]
    with pytest.raises(StreamLost, match=r"'imus'.*, 'imus'"):
        stream.reopen()
    library.found, library.opens = [Info()], False
    with pytest.raises(StreamLost, match=r"^$"):
        stream.reopen()
    library.opens = True
    stream.reopen()
    assert stream.pull(0.0) is None


@pytest.mark.parametrize(("found", "opens", "named"), [
    ([Info(text=True)], True, "holds text"), ([Info()], False, "answers and does not open")])
def test_what_cannot_be_opened_is_refused(library, found, opens, named):
    library.found, library.opens = found, opens
    with pytest.raises(InputError, match=named):
        opened(library)

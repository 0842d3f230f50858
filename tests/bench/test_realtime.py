"""The bench of runs in real time: its arithmetic on made-up stamps, and a few seconds of it; about 12 s."""

import os
import time
from multiprocessing import active_children

import numpy as np
import pytest

from fesloop.apps.bench import realtime
from fesloop.apps.bench.realtime import beside, slept
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S

pytestmark = pytest.mark.realtime

MS = 1_000_000


def sleeper(late_ms):
    """Deadlines at every ms, and how late the sleeper woke."""
    deadlines = MS * np.arange(1000)
    late = [round(late_ms.get(k, 0.1) * MS) for k in range(1000)]
    return np.stack([np.zeros(1000, np.int64), deadlines, late], axis=1)


@pytest.mark.parametrize(("late_ms", "excused"), [
    ({}, False), ({500: 9.6}, True), ({500: 9.4}, False), ({490: 30}, True), ({511: 12}, True),
    ({515: 12}, True), ({489: 90}, False), ({516: 12}, False)])
def test_a_miss_is_the_systems_where_the_sleeper_would_have_missed_it_too(late_ms, excused):
    """An instant at 500 ms whose work of .5 ms ended 15 ms later: the sleeper's from 490 to 515 ms count."""
    at, ends = np.array([500 * MS]), np.array([15 * MS])
    told = realtime._slept_through(at, ends, sleeper(late_ms), round(9.5 * MS))
    assert told.tolist() == [excused]


def test_sleepers_miss_deadlines_that_are_a_period_apart():
    stall = {k: 25.0 - (k - 503) for k in range(503, 528)}
    assert realtime._missed_by_core(sleeper(stall)) == {"0": 1}, "the one at 510 ms, 18 ms late"


def test_the_worst_are_told_with_what_the_sleeper_did():
    instants, ends = np.array([200, 500, 700]) * MS, np.array([12, 30, 20]) * MS
    alone = np.array([True, True, False])
    told = realtime._worst(instants, ends, alone, sleeper({510: 7.0, 900: 60.0}))
    assert told == [{"at_s": 0.3, "ended_after": 30.0, "sleeper": 7.0},
                    {"at_s": 0.0, "ended_after": 12.0, "sleeper": 0.1}]


def test_memory_is_a_line_through_what_was_seen():
    told = realtime._memory([(float(k), 200.0 + k / 60 + (50.0 if k < 2 else 0.0)) for k in range(100)])
    assert told == pytest.approx({"start": 200.0 + 10 / 60, "end": 200.0 + 99 / 60, "slope_per_minute": 1.0})


@pytest.mark.slow
def test_processes_beside_start_and_end_with_it(tmp_path):
    with beside(tmp_path, 10 * MS) as origin:
        others = active_children()
        cores = sorted(os.sched_getaffinity(0))
        assert len(others) == 1 + len(cores)
        until = time.monotonic() + 120.0
        while any(len(os.sched_getaffinity(other.pid)) > 1 for other in others):  # they are still importing
            assert time.monotonic() < until
            time.sleep(0.01)
        told = time.monotonic_ns()
        origin.tell(told)
        time.sleep(2.0)
    assert not any(other.is_alive() for other in others)
    every = slept(tmp_path)
    assert np.unique(every[:, 0]).tolist() == cores
    assert (np.diff(every[:, 1]) >= 0).all()
    for core in cores:
        rows = every[every[:, 0] == core, 1:]
        assert 20 < len(rows) < 205
        np.testing.assert_array_equal(np.diff(rows[:, 0]), 10 * MS)
        assert rows[0, 0] == told
        assert (rows[:, 1] >= 0).all()
        assert np.median(rows[:, 1]) < 0.2 * NS_PER_S


def test_a_few_seconds_in_the_shape_of_every_bench(recordings, monkeypatch):
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(recordings))
    result = realtime.run(seconds=4.0)
    assert list(result) == ["bench", "rows", "missed", "alone_ms", "memory_mb", "stood_still_ms", "asked_for"]
    late, took = result["rows"]
    common = ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median", "ratio"]
    assert [list(row)[:7] for row in (late, took)] == [common] * 2
    assert late["ratio"] == pytest.approx(late["us_median"] / late["reference_us_median"])
    assert took["reference"] is None
    assert 0.0 < late["us_median"] <= late["us_p99"] <= late["us_worst"]
    missed = result["missed"]
    assert missed["deadlines"] == 4 * 120, "100 Hz, and every other tick of 40 Hz lies between"
    assert 0 <= missed["alone"] <= missed["loop"] <= missed["deadlines"]
    assert len(result["alone_ms"]) == min(10, missed["alone"])
    assert 20.0 < result["memory_mb"]["start"] < 1000.0


def test_without_recordings_it_says_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path))
    with pytest.raises(InputError, match=f"FESLOOP_RECORDINGS: there is no recording in .*{os.sep}body16"):
        realtime.run(short=True)

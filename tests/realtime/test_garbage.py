"""The collector during a run in real time: off, asked at leisure, and afterwards as it was."""

import gc
import weakref
from contextlib import suppress

import pytest

from fesloop.errors import RunError
from fesloop.loop import machine as garbage
from fesloop.loop.machine import Garbage

LEISURE = 10**9


class Node:
    """Part of a cycle."""

    def __init__(self):
        self.me = self


def cycle():
    return weakref.ref(Node())


@pytest.fixture
def nothing_frozen():
    """What the tests' own set-up has frozen is released for the time of a test."""
    gc.unfreeze()
    yield
    gc.freeze()


@pytest.fixture
def at_once(monkeypatch):
    """It is always time to collect."""
    monkeypatch.setattr(garbage, "_OFTEN_NS", 0)


@pytest.mark.slow
@pytest.mark.parametrize("enabled", [True, False])
def test_everything_is_afterwards_as_before(enabled, nothing_frozen):
    was = gc.isenabled()
    (gc.enable if enabled else gc.disable)()
    try:
        with suppress(RunError), Garbage():
            during = gc.isenabled(), gc.get_freeze_count() > 0
            raise RunError("a run that fails")
        assert during == (False, True)
        assert gc.isenabled() == enabled
        assert gc.get_freeze_count() == 0
    finally:
        (gc.enable if was else gc.disable)()


def test_what_somebody_else_has_frozen_stays_frozen():
    gc.freeze()
    try:
        with Garbage():
            pass
        assert gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()


def test_cycles_wait_for_leisure_and_are_collected_then(at_once):
    before = cycle()
    with Garbage() as kept_back:
        assert before() is None, "collected before the run"
        made = [cycle() for _ in range(3000)]
        kept_back.collect_in(100_000)
        assert all(ref() is not None for ref in made)
        assert kept_back.collections == 0
        kept_back.collect_in(LEISURE)
        assert all(ref() is None for ref in made)
        assert kept_back.collections == 1
        assert kept_back.worst_ns > 0


class Stopwatch:
    """Wall clock and working time that a test moves; a collection takes `works_ns`."""

    def __init__(self):
        self.now_ns = self.worked_ns = self.works_ns = 0

    def monotonic_ns(self):
        return self.now_ns

    def thread_time_ns(self):
        return self.worked_ns

    def collect(self):
        self.now_ns += self.works_ns
        self.worked_ns += self.works_ns


def test_leisure_is_twice_the_longest_that_a_collection_has_ever_worked(at_once, monkeypatch):
    watch = Stopwatch()
    monkeypatch.setattr(garbage, "time", watch)
    with Garbage() as kept_back:
        monkeypatch.setattr(garbage.gc, "collect", watch.collect)
        watch.works_ns = 5_000_000
        kept_back.collect_in(LEISURE)
        watch.works_ns = 1_000_000
        kept_back.collect_in(LEISURE)
        kept_back.collect_in(9_999_999)
        assert kept_back.collections == 2
        kept_back.collect_in(10_000_000)
        assert (kept_back.collections, kept_back.worst_ns) == (3, 5_000_000)


def test_without_leisure_they_are_collected_in_the_end(at_once, monkeypatch):
    with Garbage() as kept_back:
        made = cycle()
        monkeypatch.setattr(garbage, "_AT_LAST_NS", 0)
        kept_back.collect_in(-5)
        assert made() is None


@pytest.mark.slow
def test_a_second_passes_between_two_collections():
    with Garbage() as kept_back:
        for _ in range(5):
            kept_back.collect_in(LEISURE)
        assert kept_back.collections == 0

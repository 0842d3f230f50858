"""Whole runs that hear a stream: a thread that sends while the loop runs; about 3 s."""

import os
import sys
import threading
import time
from dataclasses import dataclass, field

import numpy as np
import pytest
from live_parts import StandIn
from loop_parts import Sink

import fesloop
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacing
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire

pytestmark = pytest.mark.realtime

MS = 1_000_000
EVERY_MS, DURATION_S = 20, 0.6


class Line:
    """A thread that sends numbers from when it is attached until it is closed."""

    def __init__(self):
        self.queue, self.over, self.attached = [], threading.Event(), 0

    def attach(self, present):
        self.attached += 1
        self.present = present
        threading.Thread(target=self.send, daemon=True).start()

    def send(self):
        number = 0
        while not self.over.wait(EVERY_MS / 1e3):
            self.queue.append((time.monotonic_ns() - self.present.origin_ns, float(number)))
            number += 1
            self.present.bell.set()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Glove:
    """Hears a line; a sample was captured 3 ms before it came."""

    clock: RateClock = field(default_factory=lambda: RateClock.from_rate(1000 // EVERY_MS, arrivals="glove"))
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return Line()

    def attach(self, state, present):
        state.attach(present)

    def waiting(self, state):
        return state.queue[0][0] if state.queue else None

    def step(self, state, inputs, tick):
        arrived, number = state.queue.pop(0)
        tick.captured_ns = max(0, arrived - 3 * MS)
        return (number,)

    def stand_in(self):
        return StandIn(clock=RateClock.from_rate(1000 // EVERY_MS))

    def close(self, state):
        state.over.set()


def experiment(trials=2):
    nodes = (Node("glove", Glove()), Node("tracker", Sink(), Glove().clock), Node("watch", Sink(), "100"))
    wires = (Wire("glove.y", "tracker.u"), Wire("glove.y", "watch.u"))
    return Experiment(name="live", nodes=nodes, wires=wires, duration_s=DURATION_S, trials=trials)


@pytest.mark.slow
def test_every_message_of_every_trial_is_recorded_as_it_came(tmp_path):
    result = experiment().run(tmp_path, realtime=True)
    assert result.status == "done"
    with Recording(result.recording) as recording:
        origins = recording.origins
        assert origins["trial"].tolist() == [0, 1]
        assert np.diff(origins["monotonic_ns"]) >= DURATION_S * 1e9
        np.testing.assert_allclose(np.diff(origins["utc_ns"]), np.diff(origins["monotonic_ns"]), rtol=0.1)
        for trial in (0, 1):
            signal = recording.signal("glove.y", trial)
            np.testing.assert_array_equal(signal.values, np.arange(len(signal.values)))
            np.testing.assert_array_equal(signal.indices, np.arange(len(signal.values)))
            assert 10 < len(signal.values) <= DURATION_S * 1000 / EVERY_MS
            assert (np.diff(signal.times_ns) > 0).all()
            assert signal.times_ns[0] > 0.8 * EVERY_MS * MS
            np.testing.assert_array_equal(signal.oldest_ns, signal.newest_ns)
            ages = signal.times_ns - signal.oldest_ns
            assert (ages >= 3 * MS).all()
            assert np.median(ages) < 3.5 * MS, "taken the moment that it came, but for what else is due"
            rows = recording.instants[recording.instants["trial"] == trial]
            assert set(signal.times_ns) <= set(rows["time_ns"])
            assert set(np.arange(60) * 10 * MS) <= set(rows["time_ns"])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reader:
    """Puts out the scheduling class of a thread that it has started in `init`, then of one from before."""

    earlier: int
    inputs = ()
    outputs = (Port("classes", (2,)),)

    def init(self, context):
        over = threading.Event()
        thread = threading.Thread(target=over.wait, daemon=True)
        thread.start()
        return thread, over

    def attach(self, state, present):
        pass

    def step(self, state, inputs, tick):
        classes = [os.sched_getscheduler(thread) for thread in (state[0].native_id, self.earlier)]
        return (np.array([policy & ~os.SCHED_RESET_ON_FORK for policy in classes], dtype=float),)

    def close(self, state):
        state[1].set()


@pytest.mark.skipif(sys.platform != "linux", reason="of Linux")
def test_threads_that_read_have_the_priority_of_the_loop(tmp_path):
    over = threading.Event()
    earlier = threading.Thread(target=over.wait, daemon=True)
    earlier.start()
    reader = Node("reader", Reader(earlier=earlier.native_id), "50")
    result = Experiment(name="live", nodes=(reader,), wires=(), duration_s=0.2).run(
        tmp_path, realtime=Pacing(priority=5))
    over.set()
    with Recording(result.recording) as recording:
        read, other = np.asarray(recording.signal("reader.classes").values).T
    told = result.realtime["scheduling"]
    granted = told == "SCHED_FIFO, priority 5, with 1 thread beside the loop's"
    assert granted or told.startswith("refused: ")
    assert set(read) == {float(os.SCHED_FIFO if granted else os.SCHED_OTHER)}
    assert set(other) == {float(os.SCHED_OTHER)}, "what was there before is no part of the run"


def test_a_loop_whose_stream_is_silent_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(Line, "send", lambda self: None)
    result = experiment(trials=1).run(tmp_path, realtime=True)
    with Recording(result.recording) as recording:
        assert recording.signal("glove.y").values.size == 0
        assert recording.instants["time_ns"].tolist() == [k * 10 * MS for k in range(60)]


def test_a_stream_that_fails_ends_the_run_with_its_cause(tmp_path, monkeypatch):
    def fail(self, present):
        raise fesloop.RunError("there is no glove")

    closed = []
    monkeypatch.setattr(Line, "attach", fail)
    monkeypatch.setattr(Glove, "close", lambda self, state: closed.append(state))
    with pytest.raises(fesloop.RunError, match="there is no glove"):
        experiment().run(tmp_path, realtime=True)
    assert len(closed) == 1
    with Recording(tmp_path / "live-1.h5") as recording:
        assert recording.status == "failed"

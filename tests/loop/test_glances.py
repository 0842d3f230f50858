"""A fixed-step plant that gives some outputs at a glance is read only where someone wants the others."""

from dataclasses import dataclass

import numpy as np
import pytest
from loop_parts import Memory, Sink

from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Counter:
    """Counts its steps; the square takes a reading, which it counts too."""

    feedthrough = False
    inputs = ()
    outputs = (Port("steps"), Port("square"))
    grid = RateClock.from_rate("1000")

    def init(self, context):
        return Memory(x=[0, 0])

    def advance(self, state, inputs, start_ns, stop_ns):
        state.x[0] += 1

    def read(self, state, inputs):
        state.x[1] += 1
        return float(state.x[0]), float(state.x[0] ** 2)

    def glance(self, state):
        return {0: float(state.x[0])}


def looped(port, plant_rate=None):
    """A loop of 100 ms, and its recorder."""
    nodes = [Node("counter", Counter()), Node("sink", Sink(), rate="200")]
    recorder = Recorder(plant_rate)
    loop = Loop(Wiring(nodes, [Wire(f"counter.{port}", "sink.u")]), recorder=recorder)
    loop.run_until(100 * NS_PER_MS)
    return loop, recorder


@pytest.mark.parametrize(("port", "readings"), [("steps", 2), ("square", 21)])
def test_what_a_glance_gives_takes_no_reading(port, readings):
    loop, _ = looped(port)
    states = loop.states()
    seen = [float(sample.value) for _, sample in states["sink"].log]
    power = 1 if port == "steps" else 2
    assert seen == [float(k) ** power for k in range(0, 101, 5)]
    # The first reading is that of the check of shapes, the last that of the loop as it comes to rest.
    assert states["counter"].x == [100, readings]


def test_the_record_has_all_outputs_whoever_glances():
    _, recorder = looped("steps", "1000")
    squares = np.concatenate([row[2][1] for row in recorder.plants["counter"]])
    np.testing.assert_array_equal(squares, np.arange(101.0) ** 2)

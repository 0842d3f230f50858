"""Rules that show in the order of things, in what is refused and in what is let through."""

from itertools import permutations

import numpy as np
import pytest
from eager_loop import Adder
from loop_parts import Sink, Source

from fesloop.errors import InputError
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import is_finite
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


class Reporting(Source):
    def step(self, state, inputs, tick):
        tick.report("here")
        return super().step(state, inputs, tick)


@pytest.mark.parametrize("names", list(permutations("abc")))
def test_blocks_that_owe_each_other_nothing_step_as_declared(names):
    recorder = Recorder()
    nodes = [Node(name, Reporting(), rate="10") for name in names]
    Loop(Wiring(nodes, []), recorder=recorder).run_until(0)
    assert [name for _, name, _, _ in recorder.events] == list(names)


def coupled(latency_ms, feedthrough):
    nodes = [Node("a", Adder(takes=0, gives=1, salt=1)),
             Node("b", Adder(takes=1, gives=1, salt=1, feedthrough=feedthrough))]
    return Wiring(nodes, [Wire("a.y0", "b.u0", latency_ms=latency_ms, rate="100")])


def test_a_coupling_into_a_feedthrough_takes_time():
    coupled(0, feedthrough=False)
    coupled(1e-6, feedthrough=True)
    with pytest.raises(InputError, match="zero latency into plant 'b'"):
        coupled(0, feedthrough=True)


@pytest.mark.parametrize("value", [1e200, -1e308, np.array([1e200, 1.0]), np.full((2, 2), -1e308)])
def test_large_is_not_infinite(value):
    assert is_finite(value)
    with np.errstate(over="ignore"):
        assert not is_finite(value * 1e200 * 1e200)


def test_a_large_output_travels():
    class Large(Source):
        def step(self, state, inputs, tick):
            return (1e300,)

    recorder = Recorder()
    nodes = [Node("large", Large(), rate="10"), Node("sink", Sink(), rate="10")]
    loop = Loop(Wiring(nodes, [Wire("large.y", "sink.u")]), recorder=recorder)
    loop.run_until(0)
    assert recorder.events == []
    assert loop.states()["sink"].log[0][1].value == 1e300

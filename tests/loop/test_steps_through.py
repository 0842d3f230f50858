"""A block that does several ticks in one call: how many it is handed, and what it may not put out."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from loop_parts import Memory

from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Command:
    """Puts out the number of its tick."""

    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (float(tick.index),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Quick:
    """Puts out what it reads, and a vector; notes how many ticks each call has."""

    spoil: Any = None
    inputs = (Port("u"),)
    outputs = (Port("y"), Port("v", (2,)))

    def init(self, context):
        return Memory(x=[])

    def step(self, state, inputs, tick):
        state.x.append(1)
        return inputs[0].value, np.array([inputs[0].value, tick.index])

    def steps_through(self, state, inputs, ticks):
        state.x.append(len(ticks))
        values = [sample.value for sample in inputs[0]]
        stacks = values, np.array([[value, tick.index] for value, tick in zip(values, ticks, strict=True)])
        return stacks if self.spoil is None else self.spoil(*stacks)


def looped(latency_ms=0.0, **parameters):
    """A loop with commands at 50 Hz for a block at 400 Hz, and its recorder."""
    nodes = [Node("command", Command(), rate="50"), Node("quick", Quick(**parameters), rate="400")]
    recorder = Recorder(None)
    return Loop(Wiring(nodes, [Wire("command.y", "quick.u", latency_ms)]), recorder=recorder), recorder


@pytest.mark.parametrize(("latency_ms", "counts"), [(0, [8, 8, 8, 8, 8]), (5, [10, 8, 8, 8, 6])])
def test_ticks_up_to_the_next_command_are_handed_over_at_once(latency_ms, counts):
    loop, recorder = looped(latency_ms)
    loop.run_until(100 * NS_PER_MS - 1)
    assert loop.states()["quick"].x == counts
    sent = [row[-1][0] for row in recorder.blocks["quick"]]
    late = latency_ms * 2 // 5
    assert sent == [0.0] * late + [float(k // 8) for k in range(40 - late)]


def test_no_tick_beyond_what_is_asked_for_is_run():
    loop, recorder = looped()
    loop.run_until(12 * NS_PER_MS)
    assert loop.states()["quick"].x == [5]
    assert recorder.blocks["quick"][-1][1] == 10 * NS_PER_MS


@pytest.mark.parametrize(("spoil", "message"), [
    (lambda y, v: ([*y, 0.0], v), ".y: put out 9 values for 8 ticks, declared is a list of 8 floats"),
    (lambda y, v: (y, v[:-1]), ".v: put out float64 (7, 2) for 8 ticks, declared is float64 (8, 2)"),
    (lambda y, v: (np.array(y), v),
     ".y: put out float64 (8,) for 8 ticks, declared is a list of 8 floats"),
    (lambda y, v: (y, v.tolist()), ".v: put out 8 values for 8 ticks, declared is float64 (8, 2)"),
    (lambda y, v: (y,),
     ": put out 1 stacks for 8 ticks, declared is a tuple of 2, a stack for each output port"),
    (lambda y, v: None,
     ": put out NoneType for 8 ticks, declared is a tuple of 2, a stack for each output port")])
def test_stacks_that_are_not_those_of_the_ticks_end_the_run_in_one_line(spoil, message):
    loop, recorder = looped(spoil=spoil)
    with pytest.raises(RunError) as fault:
        loop.run_until(100 * NS_PER_MS)
    assert str(fault.value) == f"quick{message}"
    assert recorder.blocks["quick"] == []


def test_a_value_that_is_not_finite_is_made_safe_in_its_tick_alone():
    def spoil(y, v):
        v[3, 0] = np.nan
        return y, v

    loop, recorder = looped(spoil=spoil)
    loop.run_until(19 * NS_PER_MS)
    assert [(time, where, status) for time, where, status, _ in recorder.events] == [
        (7_500_000, "quick", "non_finite")]
    assert [row[-1][1].tolist() for row in recorder.blocks["quick"]] == [
        [0.0, 0.0] if k == 3 else [0.0, float(k)] for k in range(8)]

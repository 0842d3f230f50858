"""Sizes that wires decide, of blocks with inputs that may be left without one."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, kw_only=True)
class Source:
    """Puts out n numbers."""

    size: int

    inputs = ()

    @property
    def outputs(self):
        return (Port("values", (self.size,)),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.ones(self.size),)


@dataclass(frozen=True, kw_only=True)
class Sum:
    """Adds what is wired to it."""

    size: int = 0

    @property
    def inputs(self):
        return Port("first", (self.size or None,)), Port("second", (self.size or None,), optional=True)

    @property
    def outputs(self):
        return (Port("sum", ()),)

    def resolve(self, shapes):
        return replace(self, size=shapes["first"][0])

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (float(inputs[0].value.sum() + inputs[1].value.sum()),)


def summed(*wires):
    nodes = Node("a", Source(size=3), "10"), Node("b", Source(size=3), "10"), Node("s", Sum(), "10")
    wiring = Wiring(nodes, wires)
    assert wiring.node("s").part.size == 3
    recorder = Recorder()
    Loop(wiring, recorder=recorder).run_until(10**8)
    return float(recorder.blocks["s"][-1][-1][0])


def test_an_optional_input_without_a_wire_takes_the_size_of_those_that_have_one():
    assert summed(Wire("a.values", "s.first")) == 3.0
    assert summed(Wire("a.values", "s.first"), Wire("b.values", "s.second")) == 6.0


def test_an_input_that_must_have_a_wire_still_must():
    with pytest.raises(InputError, match="no wire"):
        summed(Wire("a.values", "s.second"))

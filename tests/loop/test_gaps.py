"""A port that declares gaps lets lost samples through as NaN; any other puts out its safe value."""

import math

import numpy as np
import pytest
from loop_parts import Memory

from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wiring import Wiring


class Spoilt:
    """Puts out one vector twice, in a port with gaps and in one without."""

    inputs = ()
    outputs = (Port("open", (2, 3), gaps=True), Port("closed", (2, 3), initial=9.0))

    def __init__(self, number):
        self.number = number

    def init(self, context):
        return Memory()

    def step(self, state, inputs, tick):
        value = np.ones((2, 3))
        value[1] = self.number
        return value, value


@pytest.mark.parametrize(("number", "stays"), [(math.nan, True), (math.inf, False), (2.0, True)])
def test_nan_passes_where_gaps_are_declared_and_nowhere_else(number, stays):
    recorder = Recorder()
    Loop(Wiring([Node("spoilt", Spoilt(number), rate="100")], []), recorder=recorder).run_until(NS_PER_MS)
    (*_, (opened, closed)), = recorder.blocks["spoilt"]
    expected = np.ones((2, 3))
    expected[1] = number
    np.testing.assert_array_equal(opened, expected if stays else np.zeros((2, 3)))
    np.testing.assert_array_equal(closed, expected if math.isfinite(number) else np.full((2, 3), 9.0))
    assert len(recorder.events) == (0 if math.isfinite(number) else 1 + (not stays))

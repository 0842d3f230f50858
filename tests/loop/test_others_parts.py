"""Blocks and plants of others: what they write to, or give away, changes nothing but themselves."""

from dataclasses import dataclass

import numpy as np
import pytest

from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Puts out its tick's number, twice."""

    inputs = ()
    outputs = (Port("values", (2,)),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.full(2, float(tick.index)),)


@dataclass(frozen=True, slots=True, kw_only=True)
class InPlace:
    """Changes its input, from the second tick on, as if it were its own."""

    start: int = 1
    inputs = (Port("values", (2,)),)
    outputs = (Port("values", (2,)),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        value = inputs[0].value
        if tick.index >= self.start:
            value -= 5.0
        return (value,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Integrator:
    """Gives the array of its state away, and changes the input that it is given if `rough`."""

    rough: bool = False
    inputs = (Port("rate", (2,)),)
    outputs = (Port("place", (2,)),)
    grid = None
    feedthrough = False

    def init(self, context):
        return np.zeros(2)

    def advance(self, state, inputs, start_ns, stop_ns):
        if self.rough:
            inputs[0][:] *= 2.0
        state += inputs[0] * (stop_ns - start_ns) * 1e-9

    def read(self, state, inputs):
        return (state,)


def _loop(block, plant=None, rate="100"):
    nodes = [Node("source", Source(), rate), Node("block", block, rate)]
    wires = [Wire("source.values", "block.values")]
    if plant is not None:
        nodes += [Node("plant", plant), Node("sink", InPlace(start=1_000_000), rate)]
        wires += [Wire("source.values", "plant.rate", latency_ms=1.0),
                  Wire("plant.place", "sink.values", rate=rate)]
    recorder = Recorder(None if plant is None else "100")
    return Loop(Wiring(nodes, wires, 1), recorder=recorder), recorder


def test_an_input_cannot_be_written_to_and_the_record_stays_as_it_was_sent():
    loop, recorder = _loop(InPlace())
    with pytest.raises(ValueError, match="read-only") as caught:
        loop.run_until(50_000_000)
    assert caught.value.__notes__ == ["fesloop: in block at 10 ms, or in a plant that it reads"]
    assert [row[5][0].tolist() for row in recorder.blocks["source"]] == [[0.0, 0.0], [1.0, 1.0]]


def test_an_input_that_is_put_out_again_is_no_longer_the_senders():
    loop, recorder = _loop(InPlace(start=1_000_000))
    loop.run_until(50_000_000)
    sent, passed = (np.array([row[5][0] for row in recorder.blocks[name]]) for name in ("source", "block"))
    assert np.array_equal(sent, passed)


def test_inputs_of_a_plant_cannot_be_written_to():
    loop, _ = _loop(InPlace(start=1_000_000), Integrator(rough=True))
    with pytest.raises(ValueError, match="read-only"):
        loop.run_until(50_000_000)


def test_what_a_plant_gives_away_of_its_state_stays_as_it_was_read():
    loop, recorder = _loop(InPlace(start=1_000_000), Integrator())
    loop.run_until(50_000_000)
    # Rates of 0, 1, 2, ... arrive 1 ms after each 10 ms: by 50 ms they are 0 x 10 + 1 x 10 + ... + 4 x 9 ms.
    places = np.array([row[5][0][0] for row in recorder.blocks["sink"]])
    np.testing.assert_allclose(places, [0.0, 0.0, 0.009, 0.028, 0.057, 0.096], atol=1e-12)
    loop_places = np.vstack([row[2][0] for row in recorder.plants["plant"]])[:, 0]
    np.testing.assert_allclose(loop_places, places, atol=1e-12)

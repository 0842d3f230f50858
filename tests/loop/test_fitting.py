"""Ends of wires that do not fit."""

from dataclasses import dataclass

import pytest
from loop_parts import ImpulseProbe, Pass, Sink

from fesloop.errors import InputError
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Counter(Sink):
    """Misses no message."""

    unit: str = "1"
    shape: tuple[int, ...] = ()

    @property
    def inputs(self):
        return (Port("u", self.shape, self.unit, every=True),)


def wired(source, rate, counter, read):
    nodes = [Node("source", source, rate=rate), Node("counter", counter, rate=read)]
    wire_rate = read if rate is None else None
    return Wiring(nodes, [Wire("source.y", "counter.u", rate=wire_rate),
                          Wire("source.y", "source.u", latency_ms=50.0, rate=wire_rate)])


@pytest.mark.parametrize(("rate", "read"), [
    ("320", "320"), ("320", "1000"), ("1000/3", "1000/3"), (None, "50")])
def test_a_reader_as_fast_as_its_source_reads_every_message(rate, read):
    source = ImpulseProbe() if rate is None else Pass()
    loop = Loop(wired(source, rate, Counter(), read))
    loop.run_until(100_000_000)
    arrived = [sample.arrived_ns for _, sample in loop.states()["counter"].log]
    assert len(set(arrived)) == loop.message_counts()["source.y->counter.u"]["sent"]


def test_a_reader_that_would_miss_messages_is_refused():
    with pytest.raises(InputError, match=r"at 40 Hz, and 'source\.y' puts out 320 .* raise counter\.rate"):
        wired(Pass(), "320", Counter(), "40")


def test_a_block_without_a_rate_is_told_that_it_may_go_by_another_ones_clock():
    with pytest.raises(InputError, match=r"counter\.rate: is missing; .* the clock of another block"):
        Node("counter", Counter())


@pytest.mark.parametrize(("counter", "told"), [
    (Counter(unit="rad"), r"'source\.y' is in '1'; allowed: 'rad'"),
    (Counter(shape=(3,)), r"'source\.y' has shape \(\); allowed: \(3,\)")])
def test_other_units_and_shapes_are_refused(counter, told):
    with pytest.raises(InputError, match=told):
        wired(Pass(), "100", counter, "100")

"""Blocks that keep something open: each is let go exactly once, whatever ends it."""

from dataclasses import dataclass, field

import pytest
from loop_parts import Sink

from fesloop.errors import RunError, SnapshotError
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


class Handle:
    """State of a Device; pickling it opens another."""

    def __init__(self, device, ticks=0):
        self.device, self.ticks, self.open = device, ticks, True
        device.handles.append(self)

    def __reduce__(self):
        if not self.device.saves:
            raise SnapshotError("dev: this device cannot save its state")
        return again, (self.device.number, self.ticks)


DEVICES = {}


def again(number, ticks):
    return Handle(DEVICES[number], ticks)


@dataclass(frozen=True, kw_only=True, eq=False)
class Device:
    """Counts its ticks outside; every handle ever opened is kept for the test to see."""

    number: int
    saves: bool = True
    refuses: bool = False
    fails_to_close: type[BaseException] | None = None
    refuses_trial: int = -1
    handles: list = field(default_factory=list)
    inputs = ()
    outputs = (Port("y"),)

    def __post_init__(self):
        DEVICES[self.number] = self

    def init(self, context):
        if self.refuses or context.trial == self.refuses_trial:
            raise RunError("dev: not there")
        return Handle(self)

    def step(self, state, inputs, tick):
        assert state.open
        state.ticks += 1
        return (float(state.ticks),)

    def close(self, state):
        state.open = False
        if self.fails_to_close is not None:
            raise self.fails_to_close(f"dev{self.number}: would not close")

    def open(self):
        return [handle.open for handle in self.handles]


def loop_of(*devices):
    nodes = [Node(f"dev{d.number}", d, rate="100") for d in devices] + [Node("sink", Sink(), rate="100")]
    return Loop(Wiring(nodes, [Wire("dev0.y", "sink.u")]))


def test_the_next_trial_lets_go_and_opens_anew():
    device = Device(number=0)
    loop = loop_of(device)
    loop.run_until(50 * NS_PER_MS)
    loop.next_trial()
    assert device.open() == [False, True]
    loop.close()
    assert device.open() == [False, False]


def test_a_restored_snapshot_lets_go_of_what_it_replaces():
    device = Device(number=0)
    loop = loop_of(device)
    loop.run_until(50 * NS_PER_MS)
    snapshot = loop.snapshot()
    loop.run_until(100 * NS_PER_MS)
    loop.restore(snapshot)
    assert device.open() == [False, True]
    loop.run_until(60 * NS_PER_MS)
    assert loop.states()["sink"].log[-1][1].value == 7.0
    loop.close()
    assert device.open() == [False, False]


def test_a_device_that_cannot_save_refuses_the_snapshot_and_the_run_goes_on():
    loop = loop_of(Device(number=0, saves=False))
    loop.run_until(50 * NS_PER_MS)
    with pytest.raises(SnapshotError, match="dev: this device cannot save"):
        loop.snapshot()
    loop.run_until(100 * NS_PER_MS)
    assert loop.states()["sink"].log[-1][1].value == 11.0


def test_one_that_will_not_open_or_close_does_not_keep_the_others_open():
    first, last = Device(number=0), Device(number=1, refuses=True)
    with pytest.raises(RunError, match="not there"):
        loop_of(first, last)
    assert first.open() == [False]


@pytest.mark.parametrize("fault", [RunError, ValueError, KeyboardInterrupt])
def test_one_that_fails_to_close_does_not_keep_the_others_open(fault):
    stuck, other = Device(number=0, fails_to_close=fault), Device(number=1)
    loop = loop_of(stuck, other)
    with pytest.raises(fault, match="dev0: would not close"):
        loop.close()
    assert other.open() == [False]


def test_what_was_opened_for_a_trial_that_cannot_begin_is_let_go():
    first, second, last = Device(number=0), Device(number=1, refuses_trial=1), Device(number=2)
    loop = loop_of(first, second, last)
    loop.run_until(50 * NS_PER_MS)
    with pytest.raises(RunError, match="not there"):
        loop.next_trial()
    loop.close()
    assert [device.open() for device in (first, second, last)] == [[False, False], [False], [False]]


def test_a_block_that_breaks_is_recorded_as_why_the_run_ended():
    recorder = Recorder()
    device = Device(number=0)
    loop = Loop(Wiring([Node("dev", device, rate="100")], []), recorder=recorder)
    loop.states()["dev"].ticks = "no number"
    with pytest.raises(TypeError):
        loop.run_until(0)
    (event,) = recorder.events
    assert event[1:3] == ("loop", "failed")
    assert event[3].startswith("TypeError: ")

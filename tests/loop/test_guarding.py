"""What must stand directly before a device cannot be left out, and nothing gets between."""

from dataclasses import dataclass
from typing import ClassVar

import pytest
from loop_parts import Pass, Source

from fesloop.errors import InputError
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Guard(Pass):
    """Passes on, and says that it guards."""

    guards: ClassVar[bool] = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Device(Pass):
    """A device whose input must be guarded."""

    guarded: ClassVar[tuple[str, ...]] = ("u",)


def wired(*, wire=None, execution=None, device_rate="50", through="guard.y"):
    """A source, a guard, a device; what is wired into the device is to be chosen."""
    guard = Node("guard", Guard(), "50", **({"execution": execution} if execution else {}))
    nodes = [Node("source", Source(), "50"), guard, Node("between", Pass(), "50"),
             Node("device", Device(), device_rate)]
    return Wiring(nodes, [Wire("source.y", "guard.u"), Wire("guard.y", "between.u"),
                          Wire(through, "device.u", **(wire or {}))])


def test_a_guard_directly_before_the_device_is_accepted():
    assert wired().node("device").part.guarded == ("u",)


def test_a_guard_stands_before_one_device_only():
    nodes = [Node("source", Source(), "50"), Node("guard", Guard(), "50"), Node("device", Device(), "50"),
             Node("second", Device(), "50")]
    wires = [Wire("source.y", "guard.u"), Wire("guard.y", "device.u"), Wire("guard.y", "second.u")]
    with pytest.raises(InputError, match=r"wire guard\.y->second\.u: 'guard' already guards 'device'"):
        Wiring(nodes, wires)


@pytest.mark.parametrize("through", ["source.y", "between.y"])
def test_a_device_without_its_guard_is_refused(through):
    with pytest.raises(InputError, match="safety block directly before a device"):
        wired(through=through)


def test_a_device_to_which_nothing_leads_is_refused():
    with pytest.raises(InputError, match=r"device\.u"):
        Wiring([Node("guard", Guard(names=()), "50"), Node("device", Device(), "50")], [])


@pytest.mark.parametrize("wire", [{"latency_ms": 1.0}, {"loss": 0.1},
                                  {"jitter": Duration(kind="uniform", low_ms=0.0, high_ms=1.0)}])
def test_nothing_lies_between_guard_and_device(wire):
    with pytest.raises(InputError, match="no latency, jitter or loss"):
        wired(wire=wire)


def test_a_guard_takes_no_time():
    with pytest.raises(InputError, match=r"guard\.execution"):
        wired(execution=Duration(kind="fixed", ms=1.0))


@pytest.mark.parametrize("rate", ["100", "25"])
def test_guard_and_device_tick_together(rate):
    with pytest.raises(InputError, match="ticks with its safety block"):
        wired(device_rate=rate)


def test_other_blocks_need_no_guard():
    Wiring([Node("source", Source(), "50"), Node("pass", Pass(), "25")],
           [Wire("source.y", "pass.u", latency_ms=3.0)])

"""Nothing is stimulated before each tracker that needs a still initial pose has taken it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Memory

from controllers.safety import Safety
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.join import Join

PULSES = Port("pulses", (1, 2), "A,s")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pulses:
    """Stimulates from the first tick on, or adds nothing to what comes in."""

    source: bool = True

    @property
    def inputs(self):
        return () if self.source else (Port("stimulation", (1, 2), "A,s"),)

    outputs = (PULSES,)

    def init(self, context: Context):
        return Memory()

    def step(self, state, inputs, tick):
        return (np.array([[10e-3, 200e-6]]) if self.source else inputs[0].value,)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arm:
    """A plant that remembers when it was stimulated, and shows whether it was."""

    inputs = (Port("stimulation", (1, 2), "A,s"),)
    outputs = (Port("moved"),)
    grid = None
    feedthrough = False

    def init(self, context: Context):
        return Memory(x=0.0)

    def advance(self, state, inputs, start_ns, stop_ns):
        if stop_ns > start_ns and inputs[0].any():
            state.log.append(start_ns)
            state.x = 1.0

    def read(self, state, inputs):
        return (state.x,)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Still:
    """A tracker that is aligned after so many ticks, and is wrong if anything moved before."""

    ticks: int
    needs_stillness: str = "aligned"
    inputs = (Port("moved"),)
    outputs = (Port("angle"), Port("aligned", (1,)))

    def init(self, context: Context):
        return Memory(x=False)

    def step(self, state, inputs, tick):
        aligned = tick.index >= self.ticks
        state.x = state.x or (not aligned and inputs[0].value > 0.0)
        return 0.0, np.array([float(aligned)])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bare(Pulses):
    """A guard of somebody else's that has no interlock."""

    source: bool = False
    guards: ClassVar[bool] = True


CHAINS = st.lists(st.sampled_from(["guard", "pass"]), max_size=3)
TRACKERS = st.lists(st.tuples(st.integers(0, 8), st.booleans()), min_size=1, max_size=3)


def wired(chain, trackers, heard, latency_ms, through_join):
    """Pulses through a chain into an arm; `heard`: the trackers wired to the guard that comes last."""
    nodes = [Node("source", Pulses(), "40"), Node("arm", Arm())]
    wires, end, last = [], "source.pulses", ""
    for k, kind in enumerate(chain):
        name = f"{kind}{k}"
        part = Safety(ramp_ms=0.0) if kind == "guard" else Pulses(source=False)
        last = name if kind == "guard" else last
        nodes.append(Node(name, part, "40"))
        wires.append(Wire(end, f"{name}.stimulation"))
        end = f"{name}.stimulation" if kind == "guard" else f"{name}.pulses"
    wires.append(Wire(end, "arm.stimulation", latency_ms=latency_ms))
    for k, (ticks, needs) in enumerate(trackers):
        part = Still(ticks=ticks, needs_stillness="aligned" if needs else "")
        nodes.append(Node(f"tracker{k}", part, "100"))
        wires.append(Wire("arm.moved", f"tracker{k}.moved"))
    if last and heard:
        if len(heard) > 1 or through_join:
            ends = [heard[0], *heard] if len(heard) == 1 else heard
            nodes.append(Node("join", Join(unit="1", sources=len(ends), columns=0), "100"))
            wires += [Wire(f"tracker{k}.aligned", f"join.{name}", latency_ms=latency_ms)
                      for k, name in zip(ends, ("first", "second", "third"), strict=False)]
            wires.append(Wire("join.joined", f"{last}.aligned"))
        else:
            wires.append(Wire(f"tracker{heard[0]}.aligned", f"{last}.aligned", latency_ms=latency_ms))
    return nodes, wires, last


@pytest.mark.slow
@settings(deadline=None, max_examples=150)
@given(CHAINS, TRACKERS, st.sets(st.integers(0, 2)), st.sampled_from([0, 1, 10, 25]), st.booleans())
def test_a_wiring_is_refused_or_keeps_the_pose_still(chain, trackers, chosen, latency_ms, through_join):
    heard = sorted(k for k in chosen if k < len(trackers))
    needing = {k for k, (_, needs) in enumerate(trackers) if needs}
    nodes, wires, last = wired(chain, trackers, heard, latency_ms, through_join)
    if needing and not (last and needing <= set(heard)):
        with pytest.raises(InputError, match="initial pose"):
            Wiring(nodes, wires)
        return
    loop = Loop(Wiring(nodes, wires))
    loop.run_until(400_000_000)
    states = loop.states()
    for k in needing:
        assert not states[f"tracker{k}"].x
    waits = [trackers[k][0] for k in heard if last]
    assert states["arm"].log[0] >= 10_000_000 * max(waits, default=0)


def test_the_message_names_the_wire_that_is_missing():
    nodes, wires, _ = wired(["guard"], [(5, True)], [], 0, False)
    with pytest.raises(InputError, match=r'add a wire from "tracker0.aligned" to "guard0.aligned"'):
        Wiring(nodes, wires)


def test_a_guard_without_an_interlock_does_not_count():
    nodes, wires, _ = wired(["pass"], [(5, True)], [], 0, False)
    nodes[2] = Node("pass0", Bare(), "40")
    with pytest.raises(InputError, match="an interlock of the guard's"):
        Wiring(nodes, wires)


def test_another_output_of_the_tracker_is_no_interlock():
    nodes, wires, _ = wired(["guard"], [(5, True), (2, False)], [1], 0, False)
    with pytest.raises(InputError, match="'tracker0'"):
        Wiring(nodes, wires)


def test_a_tracker_that_watches_beside_the_loop_is_kept_still_too():
    """Two trackers, one of which nobody reads: stimulation would spoil its pose all the same."""
    nodes, wires, _ = wired(["guard"], [(5, True), (8, True)], [0], 0, False)
    with pytest.raises(InputError, match="'tracker1'"):
        Wiring(nodes, wires)

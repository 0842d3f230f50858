"""Inputs that are always older than a block allows are named before a run, as old as the run has them."""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Memory, Pass, Source

from controllers.grip import GripForce
from controllers.mpc import Mpc
from controllers.pid import TunedPid
from controllers.safety import Safety
from fesloop.apps.cli import main
from fesloop.experiment import registry
from fesloop.loop.abilities import AgeLimit
from fesloop.loop.cautions import always_too_old, too_old
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

rates = st.sampled_from(["20", "40", "60", "100", "1000/3"])
milliseconds = st.one_of(st.just(0.0), st.integers(0, 300).map(float))


@dataclass(frozen=True, kw_only=True, eq=False)
class Watch:
    """Remembers, of each tick, when it was and the stamps of its input."""

    limit_ms: float
    since: str
    inputs = (Port("u"),)
    outputs = (Port("y"),)

    def age_limits(self):
        return (AgeLimit(port="u", limit_ms=self.limit_ms, since=self.since, then="nothing happens"),)

    def init(self, context):
        return Memory()

    def step(self, state, inputs, tick):
        state.log.append((tick.time_ns, inputs[0].oldest_ns, inputs[0].newest_ns))
        return (0.0,)


@dataclass(frozen=True, kw_only=True, eq=False)
class Still:
    """A plant that does nothing, with or without a grid."""

    grid: RateClock | None = None
    inputs = (Port("u", optional=True),)
    outputs = (Port("y"),)
    feedthrough = False

    def init(self, context):
        return Memory()

    def advance(self, state, inputs, start_ns, stop_ns):
        pass

    def read(self, state, inputs):
        return (0.0,)


@st.composite
def watched(draw):
    """Plants and sources behind blocks of two inputs, joined, with or without a way back, and a watch."""
    jitter = st.one_of(st.just(ZERO), st.floats(0, 40).map(
        lambda ms: Duration(kind="uniform", low_ms=0.0, high_ms=ms)))

    def wire(source, target):
        return Wire(source, target, latency_ms=draw(milliseconds), jitter=draw(jitter),
                    loss=draw(st.sampled_from([0.0, 0.0, 0.3])))

    def node(name, part):
        return Node(name, part, draw(rates), draw(milliseconds), draw(st.sampled_from(
            [ZERO, Duration(kind="fixed", ms=4.0), Duration(kind="uniform", low_ms=0.0, high_ms=30.0)])))

    grid = draw(st.sampled_from([None, "1000", "50"]))
    back = draw(st.booleans())
    watch = Watch(limit_ms=draw(st.sampled_from([50.0, 150.0, 300.0, 500.0])),
                  since=draw(st.sampled_from(["oldest", "newest"])))
    names = ("a", "b", "c") if back else ("a", "b")
    nodes = [Node("plant", Still(grid=RateClock.from_rate(grid) if grid else None)), node("source", Source()),
             node("first", Pass()), node("joined", Pass(names=names)), node("watch", watch)]
    wires = [wire("plant.y", "first.u"), wire("first.y", "joined.a"), wire("source.y", "joined.b"),
             wire("joined.y", "watch.u"), Wire("watch.y", "plant.u")]
    if back:
        wires.append(replace(wire("joined.y", "joined.c"), latency_ms=5.0))
    return Wiring(nodes, wires, seed=draw(st.integers(0, 9)))


@settings(deadline=None, max_examples=80)
@given(watched(), st.sampled_from([0.2, 1.0, 2.0]))
def test_an_input_is_named_where_no_tick_of_the_run_reads_it_young_enough(wiring, duration_s):
    duration_ns = round(duration_s * NS_PER_S)
    loop = Loop(wiring)
    loop.run_until(duration_ns - 1)
    watch = wiring.node("watch").part
    log = np.array(loop.states()["watch"].log, dtype=np.int64).reshape(-1, 3)
    log = log[log[:, 0] > watch.limit_ms * NS_PER_MS]
    stamps = log[:, 1 if watch.since == "oldest" else 2]
    old = (stamps < 0) | (log[:, 0] - stamps > watch.limit_ms * NS_PER_MS)
    found = always_too_old(wiring, duration_ns)
    assert [node for node, *_ in found] == (["watch"] if old.size and old.all() else [])
    often = [(node, detail) for node, status, detail in too_old(wiring, duration_ns)
             if status == "often_too_old"]
    assert bool(often) == (not found and old.size > 0 and old.mean() > 0.01)
    if often:
        assert often[0][0] == "watch"
        assert f"at {100.0 * old.mean():.2g} % of the ticks" in often[0][1]
        assert often[0][1].startswith(("plant.y, from", "source.y, from", "first.y", "joined.y"))
    ages = (log[:, 0] - stamps)[stamps > 0]
    if found and ages.size:
        assert f"at least {ages.min() / NS_PER_MS:.9g} ms old" in found[0][2]
        assert f"to {-(-ages.max() // NS_PER_MS)} or more" in found[0][2]
    elif found:
        assert "nothing that was captured after the trial began" in found[0][2]


def test_a_ring_without_a_plant_makes_what_it_puts_out_as_old_as_the_trial():
    nodes = [Node("source", Source(), "100"), Node("joined", Pass(names=("a", "b")), "100"),
             Node("watch", Watch(limit_ms=500.0, since="oldest"), "100")]
    wires = [Wire("source.y", "joined.a"), Wire("joined.y", "joined.b", latency_ms=10.0),
             Wire("joined.y", "watch.u")]
    ((node, status, detail),) = always_too_old(Wiring(nodes, wires), 2 * NS_PER_S)
    assert (node, status) == ("watch", "always_too_old")
    assert "derives, up to 2 s, from nothing that was captured after the trial began" in detail


@given(seldom=st.sampled_from(["reference", "measured"]), rate=st.sampled_from(["0.5", "1", "1.6"]))
@settings(deadline=None, max_examples=6)
def test_the_source_that_ticks_too_seldom_is_named_wherever_it_is(seldom, rate):
    rate_of = {"reference": "50", "measured": "50"} | {seldom: rate}
    nodes = [*(Node(name, Source(), each) for name, each in rate_of.items()),
             Node("joined", Pass(names=("a", "b")), "50"),
             Node("watch", Watch(limit_ms=500.0, since="oldest"), "50")]
    wires = [Wire("reference.y", "joined.a"), Wire("measured.y", "joined.b", latency_ms=40.0),
             Wire("joined.y", "watch.u")]
    ((node, status, detail),) = too_old(Wiring(nodes, wires), 10 * NS_PER_S)
    assert (node, status) == ("watch", "often_too_old")
    assert detail.startswith(f"{seldom}.y, from which `u` derives, is older than 500 ms (max_age_ms) at ")
    assert f"the rate of {seldom} ({rate} Hz)" in detail


def test_every_kind_with_a_greatest_age_declares_it():
    kinds = [registry.find(kind) for kind in registry.kinds()]
    aged = {kind for kind in kinds if "max_age_ms" in {each.name for each in fields(kind)}}
    assert {Safety, Mpc, TunedPid, GripForce} <= aged
    assert [kind.__name__ for kind in aged if not hasattr(kind, "age_limits")] == []


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(("latency_ms", "max_age_ms", "told"), [(600, 500, True), (600, 700, False),
                                                                 (20, 500, False), (120, 100, True)])
def test_latency_beyond_what_safety_lets_through_is_a_caution_in_one_line(
        command, latency_ms, max_age_ms, told, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = ["--json"] if command == "check" else ["--out", str(tmp_path / "runs")]
    assert main([command, "finger_pid_latency", "--set", f"latency_ms={latency_ms}", "--set",
                 f"blocks.safety.max_age_ms={max_age_ms}", *out]) == 0
    said = capsys.readouterr()
    lines = [line for line in (said.out + said.err).splitlines() if "all stimulation is withheld" in line]
    assert len(lines) == told
    if told:
        assert f"max_age_ms is {max_age_ms} ms, and `stimulation` is at least {latency_ms}" in lines[0]
        assert f"wire tracker.angles->controller.measured: {latency_ms} ms" in lines[0]
        assert "raise blocks.safety.max_age_ms to" in lines[0]
        if command == "run":
            assert lines[0].startswith("fesloop: caution: safety: ")

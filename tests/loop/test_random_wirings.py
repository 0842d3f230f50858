"""Random wirings against the loop's rules written down plainly, in one go, in stretches and from snapshots.

Several plants, exact and of fixed steps, coupled, in rings and with themselves, with and without feedthrough,
gone through many instants at once, looked at ahead and at a glance; blocks at rates, offsets and stamps, some
of which are run ahead;
latency, jitter, loss, both ways of being late; execution times that skip ticks; several trials.
"""

import random
from contextlib import suppress
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from eager_loop import (
    Adder,
    AheadAdder,
    AheadDrifter,
    AheadMixer,
    Drifter,
    EagerLoop,
    ForeseenDrifter,
    GlancingAdder,
    Mixer,
    ReportingAheadMixer,
    ReportingMixer,
    SteppingAdder,
    SteppingGlancer,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from live_parts import Wall

from fesloop.errors import InputError, RunError
from fesloop.loop.clock import NS_PER_MS, RateClock, StampClock
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacer, Pacing
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

EXACT = (Adder, AheadAdder, Drifter, AheadDrifter, ForeseenDrifter)
RATES = ("7", "60", "285.714", "1000", "2000/7", "50", "100", "1000/3", "250", "20")
UNTIL_NS = 300 * NS_PER_MS
seeds = st.integers(0, 2**32)
rates = st.sampled_from(["1000", "7", "285.714"])


def duration(draw, zero, low_ms=0.0):
    """A duration of any kind, zero with a given chance."""
    if draw.random() < zero:
        return ZERO
    return draw.choice([
        Duration(kind="fixed", ms=draw.choice([0, 1e-6, 1, 2.5, 10, 37.123457])),
        Duration(kind="uniform", low_ms=low_ms, high_ms=draw.choice([0.0, 3, 40])),
        Duration(kind="uniform", low_ms=low_ms, high_ms=low_ms + 2e-6),
        Duration(kind="normal", mean_ms=1, sd_ms=3, low_ms=low_ms, high_ms=9),
        Duration(kind="exponential", mean_ms=4, high_ms=30)])


def plant(draw, name):
    grid = RateClock.from_rate(draw.choice(RATES)) if draw.random() < 0.3 else None
    kind = draw.choice(EXACT if grid is None else (Adder, GlancingAdder, SteppingAdder, SteppingGlancer))
    return Node(name, kind(takes=draw.randint(1, 2), gives=draw.randint(1, 2), salt=draw.randint(1, 99),
                           feedthrough=draw.random() < 0.15, grid=grid))


def block(draw, name):
    size = {"takes": draw.randint(0, 3), "gives": draw.randint(0, 2), "salt": draw.randint(1, 99)}
    kind = draw.choice((Mixer, AheadMixer))
    if draw.random() < 0.2:
        steps = [draw.choice([1, 1000, 5_000_000, 20_000_000]) for _ in range(draw.randint(1, 30))]
        stamps = StampClock(np.cumsum(steps) - 1)
        return Node(name, kind(**size, clock=stamps), execution=duration(draw, 0.6))
    return Node(name, kind(**size), draw.choice(RATES), draw.choice([0, 0, 1, 3.3, 12.345678]),
                duration(draw, 0.6))


def wire(draw, source, end, target, port):
    latency = draw.choice([0, 0, 0, 1, 5, 10, 30, 1e-6, 12.345678, 100])
    sampled = source.is_plant and (target.is_plant or draw.random() < 0.4)
    return Wire(end, f"{target.name}.{port}", latency, duration(draw, 0.6, draw.choice([0, -latency])),
                draw.choice([0, 0, 0, 0.2, 0.7]), draw.choice(["keep-newest", "in-order"]),
                draw.choice(RATES) if sampled else None, draw.choice([0, 0, 2, 7.7]) if sampled else 0,
                draw.choice([0, 0, 2.5, 10]))


def source(draw, target, ends):
    """Any output; that of a plant, and of the target itself, more often where it is to go to a plant."""
    near = [end for end in ends if end[0].is_plant and (draw.random() < 0.5 or end[0] is target)]
    return draw.choice(near if target.is_plant and near and draw.random() < 0.4 else ends)


def random_wiring(seed):
    """A wiring; one that is refused is no example."""
    draw = random.Random(seed)
    nodes = [plant(draw, f"p{i}") for i in range(draw.randint(1, 3))]
    nodes += [block(draw, f"b{i}") for i in range(draw.randint(1, 5))]
    draw.shuffle(nodes)
    ends = [(node, f"{node.name}.{port.name}") for node in nodes for port in node.part.outputs]
    try:
        wires = [wire(draw, *source(draw, node, ends), node, port.name)
                 for node in nodes for port in node.part.inputs if draw.random() < 0.85]
        draw.shuffle(wires)
        return Wiring(nodes, wires, seed)
    except InputError:
        assume(False)


def states(loop):
    """What every node remembers."""
    return {name: state.x for name, state in loop.states().items()}


def by_instant(recorder):
    """What was recorded of the plants, an instant a row."""
    return {name: [(time, captured, [float(stack[i]) for stack in stacks]) for times, instants, stacks in rows
                   for i, (time, captured) in enumerate(zip(times, instants, strict=True))]
            for name, rows in recorder.plants.items()}


@pytest.mark.slow
@given(seeds, st.integers(0, 3), rates)
@settings(max_examples=150, deadline=None)
def test_the_loop_keeps_its_rules_to_the_bit(seed, trial, rate):
    wiring = random_wiring(seed)
    recorder = Recorder(rate)
    expected = EagerLoop(wiring, UNTIL_NS, trial, recorder.plant_clock)
    loop = Loop(wiring, trial, recorder)
    loop.run_until(UNTIL_NS)
    compare(loop, recorder, expected)


def with_blocks(wiring, kind):
    """The wiring with every block of a kind."""
    nodes = [node if node.is_plant else replace(node, part=kind(**{
        field.name: getattr(node.block, field.name) for field in fields(node.block)}))
        for node in wiring.nodes]
    return Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed)


@given(seeds, st.lists(st.integers(0, UNTIL_NS), max_size=3))
@settings(max_examples=80, deadline=None)
def test_reports_of_ticks_that_are_run_ahead_keep_their_order(seed, stops_ns):
    wiring, seen = random_wiring(seed), []
    for kind in (ReportingMixer, ReportingAheadMixer):
        recorder = Recorder(None)
        loop = Loop(with_blocks(wiring, kind), recorder=recorder)
        for stop_ns in [*sorted(stops_ns), UNTIL_NS]:
            loop.run_until(stop_ns)
            assert all(time <= stop_ns for time, *_ in recorder.events)
        seen.append((recorder.events, recorder.blocks))
    assert seen[0] == seen[1]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Failing(Adder):
    """A plant that fails after some steps."""

    fails_ns: int

    def advance(self, state, inputs, start_ns, stop_ns):
        if stop_ns > self.fails_ns:
            raise RunError(f"fails at {stop_ns} ns")
        Adder.advance(self, state, inputs, start_ns, stop_ns)


@given(seeds, st.integers(0, UNTIL_NS))
@settings(max_examples=80, deadline=None)
def test_a_run_that_fails_has_recorded_the_same_ticks(seed, fails_ns):
    wiring, seen = random_wiring(seed), []
    plants = {"takes": 2, "gives": 2, "salt": 3, "grid": RateClock.from_rate("250"), "fails_ns": fails_ns}
    nodes = [replace(node, part=Failing(**plants)) if node.is_plant else node for node in wiring.nodes]
    try:
        wiring = Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed)
    except InputError:
        assume(False)
    for kind in (ReportingMixer, ReportingAheadMixer):
        recorder = Recorder(None)
        loop = Loop(with_blocks(wiring, kind), recorder=recorder)
        with suppress(RunError):
            loop.run_until(UNTIL_NS)
        seen.append((recorder.events, recorder.blocks, recorder.inputs))
    assert seen[0] == seen[1]


@given(seeds, rates)
@settings(max_examples=40, deadline=None)
def test_a_trial_begins_with_what_the_end_of_the_one_before_left(seed, rate):
    wiring, draw = random_wiring(seed), random.Random(seed)
    recorder, before = Recorder(rate), None
    loop = Loop(wiring, recorder=recorder)
    for trial in range(3):
        if trial:
            loop.next_trial()
        end_ns = draw.choice([NS_PER_MS // 2, 33_333_333, 100 * NS_PER_MS])
        expected = EagerLoop(wiring, end_ns, trial, recorder.plant_clock, before)
        loop.run_until(draw.randint(0, end_ns))
        loop.run_until(end_ns)
        compare(loop, recorder, expected)
        recorder.drain()
        before = expected.states


def compare(loop, recorder, expected):
    """A loop and what it recorded since t = 0 against the rules, to the bit."""
    assert recorder.blocks == expected.blocks
    assert by_instant(recorder) == expected.plants
    assert {name: sorted(rows) for name, rows in recorder.inputs.items()} == {
        name: sorted(rows) for name, rows in expected.inputs.items()}
    skipped = [(time, name, int(detail.split()[1][:-1])) for time, name, _, detail in recorder.events]
    assert sorted(skipped) == sorted(expected.skipped)
    for name, counts in loop.message_counts().items():
        assert {key: counts[key] for key in ("sent", "lost")} == expected.counts[name]


@pytest.mark.slow
@given(seeds, rates)
@settings(max_examples=80, deadline=None)
def test_stretches_and_snapshots_change_nothing(seed, rate):
    wiring, draw = random_wiring(seed), random.Random(seed)
    whole, parts = Recorder(rate), Recorder(rate)
    Loop(wiring, recorder=whole).run_until(UNTIL_NS)
    unseen = Loop(wiring)
    unseen.run_until(UNTIL_NS)
    loop, now, snapshots = Loop(wiring, recorder=parts), -1, []
    while now < UNTIL_NS:
        now = min(UNTIL_NS, now + draw.choice([1, 999, NS_PER_MS, 333_333, 20 * NS_PER_MS, 77_777_777]))
        loop.run_until(now)
        snapshots.append(loop.snapshot())
    assert parts.blocks == whole.blocks
    assert parts.inputs == whole.inputs
    assert parts.events == whole.events
    assert by_instant(parts) == by_instant(whole)
    assert states(loop) == states(unseen)

    saved = draw.choice(snapshots)
    again = Recorder(rate)
    other = Loop(wiring, recorder=again)
    other.run_until(draw.randint(0, UNTIL_NS))
    again.drain()
    other.restore(saved)
    other.run_until(UNTIL_NS)
    assert again.blocks == {name: [row for row in rows if row[1] > saved.time_ns]
                            for name, rows in whole.blocks.items()}
    assert by_instant(again) == {name: [row for row in rows if row[0] > saved.time_ns]
                                 for name, rows in by_instant(whole).items()}
    assert other.message_counts() == loop.message_counts()
    assert states(other) == states(loop)


@given(seeds, rates)
@settings(max_examples=50, deadline=None)
def test_whoever_looks_on_changes_nothing(seed, rate):
    """Blocks from which no way leads back to a plant."""
    wiring, draw = random_wiring(seed), random.Random(seed + 1)
    watchers = [block(draw, f"w{i}") for i in range(3)]
    ends = [(node, f"{node.name}.{port.name}") for node in [*wiring.nodes, *watchers]
            for port in node.part.outputs]
    try:
        wires = [wire(draw, *draw.choice(ends), node, port.name)
                 for node in watchers for port in node.part.inputs]
        watched = Wiring([*wiring.nodes, *watchers], [*(c.wire for c in wiring.connections), *wires], seed)
    except InputError:
        assume(False)
    alone, together = Recorder(rate), Recorder(rate)
    Loop(wiring, recorder=alone).run_until(UNTIL_NS)
    Loop(watched, recorder=together).run_until(UNTIL_NS)
    assert {name: together.blocks[name] for name in alone.blocks} == alone.blocks
    assert {name: sorted(rows) for name, rows in together.inputs.items()} == {
        name: sorted(rows) for name, rows in alone.inputs.items()}
    assert by_instant(together) == by_instant(alone)


@given(seeds, rates, st.lists(st.integers(0, 30 * NS_PER_MS), min_size=1, max_size=5))
@settings(max_examples=60, deadline=None)
def test_keeping_step_with_the_wall_clock_changes_nothing(seed, rate, oversleeps_ns):
    """However late a sleeper wakes, where every late tick is caught up with."""
    wiring, wall = random_wiring(seed), Wall(oversleeps_ns)
    whole, paced = Recorder(rate), Recorder(rate)
    Loop(wiring, recorder=whole).run_until(UNTIL_NS)
    pacer = Pacer(Loop(wiring, recorder=paced), Pacing(), wall.clock, wall.sleep)
    pacer.begin_trial()
    while pacer.advance(UNTIL_NS + 1) <= UNTIL_NS:
        pass
    assert paced.blocks == whole.blocks
    assert paced.inputs == whole.inputs
    assert paced.events == whole.events
    assert by_instant(paced) == by_instant(whole)


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_a_snapshot_of_a_later_trial_goes_on_identically(seed):
    wiring = random_wiring(seed)
    recorder = Recorder("285.714")
    loop = Loop(wiring, recorder=recorder)
    loop.run_until(UNTIL_NS)
    first = dict(recorder.drain()[0])
    loop.next_trial()
    loop.run_until(UNTIL_NS // 2)
    recorder.drain()
    saved = loop.snapshot()
    loop.run_until(UNTIL_NS)
    through = recorder.drain()[0]
    loop.restore(saved)
    loop.run_until(UNTIL_NS)
    assert recorder.drain()[0] == through
    assert first.keys() == through.keys()


@given(st.lists(st.lists(st.integers(0, 40), min_size=1, max_size=200), min_size=2, max_size=2),
       st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_recorded_durations_are_taken_in_their_order_trial_by_trial(durations_ms, snapshot_ms):
    """A step takes what is written for it, also after a snapshot and in the second trial."""
    padded = tuple(tuple(ms * NS_PER_MS for ms in (trial * 151)[:151]) for trial in durations_ms)
    node = Node("b", Mixer(takes=0, gives=1, salt=1), "1000",
                execution=Duration(kind="recorded", recorded_ns=padded))
    recorder = Recorder()
    loop = Loop(Wiring([node], []), recorder=recorder)
    for trial in range(2):
        if trial:
            loop.next_trial()
        loop.run_until(snapshot_ms * NS_PER_MS)
        saved = loop.snapshot()
        loop.run_until(150 * NS_PER_MS)
        recorder.drain()
        loop.restore(saved)
        loop.run_until(99 * NS_PER_MS)
        expected, busy_until, steps = [], 0, iter(padded[trial])
        for now in range(0, 100 * NS_PER_MS, NS_PER_MS):
            if now >= busy_until:
                busy_until = now + next(steps)
                expected.append((now, busy_until))
        found = [(row[1], row[2]) for row in recorder.drain()[0]["b"]]
        assert found == [step for step in expected if step[0] > saved.time_ns]

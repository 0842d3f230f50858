"""The contract of blocks and plants, held by every registered kind."""

import copy
import json
import os
import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace
from importlib.metadata import entry_points
from pathlib import Path

import conformance_parts as parts
import numpy as np
import pytest

from fesloop.errors import RunError
from fesloop.loop.abilities import (
    OF_BLOCKS,
    OF_PLANTS,
    AdvancesSteps,
    AdvancesThrough,
    AgeLimit,
    Captures,
    Delays,
    Designs,
    ExplainsInputs,
    Glances,
    Guarded,
    HasClock,
    Ignores,
    Interlocks,
    Learns,
    LimitsAge,
    NeedsStillness,
    Observes,
    Passage,
    Reports,
    Resolves,
    StepsThrough,
    Warns,
    contract_faults,
    offers,
)
from fesloop.loop.assembly import empty_sample
from fesloop.loop.block import Tick, is_plant
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.signals import check_shapes, require_stacks
from plants.stimulator import Stimulator

KINDS = sorted({e.name for e in entry_points(group="fesloop.blocks")} - parts.NOT_WITHOUT_FILES)
TICKS = 40


@pytest.fixture(scope="module")
def specimens():
    return parts.specimens()


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


@pytest.fixture
def block(specimens, kind):
    return specimens[kind]


def run(kind, block, feeds=None):
    return parts.step_through(kind, block, block.init(parts.context(kind)), feeds or parts.feed(block, TICKS))


@pytest.mark.slow
def test_parameters_are_frozen_and_documented(block):
    assert is_dataclass(block)
    name = next((f.name for f in fields(block) if f.init), None)
    if name is not None:
        with pytest.raises((FrozenInstanceError, AttributeError)):
            setattr(block, name, None)
    assert block.__doc__
    assert not block.__doc__.startswith(type(block).__name__ + "(")


@pytest.mark.slow
def test_the_same_inputs_give_the_same_bits(kind, block):
    assert parts.flat(run(kind, block)) == parts.flat(run(kind, block))


def test_declared_ports_are_kept(kind, block):
    for outputs, _ in run(kind, block):
        check_shapes(kind, block.outputs, outputs)


def test_the_class_keeps_the_contract_and_every_protocol_that_it_claims(block):
    assert list(contract_faults(type(block))) == []


def test_what_no_sample_has_said_is_not_put_out_without_a_word(kind, block):
    if is_plant(block) or not block.inputs:
        pytest.skip("a plant or a source")
    if kind in ("stimulator", "electrodes", "point_search", "element_sweep"):
        pytest.skip("nothing commanded is no stimulation, a search or sweep begins by itself")
    tick = Tick()
    outputs = block.step(block.init(parts.context(kind)), [empty_sample(port) for port in block.inputs], tick)
    assert tick.reports or outputs == (), "values of a measurement that nobody made"


@pytest.mark.slow
def test_something_comes_out_that_depends_on_what_goes_in(kind, block):
    if not block.inputs:
        pytest.skip("a source")
    assert two_trials(kind, block, seed=1) != two_trials(kind, block, seed=2)


def two_trials(kind, block, seed):
    """What comes out of two trials: a block that learns shows what went in in the second only."""
    feeds, state = parts.feed(block, TICKS, seed), block.init(parts.context(kind))
    seen = parts.flat(parts.step_through(kind, block, state, feeds))
    if offers(block, Learns):
        state = block.next_trial(state, replace(parts.context(kind), trial=1))
        seen += parts.flat(parts.step_through(kind, block, state, feeds))
    return seen


@pytest.mark.slow
@pytest.mark.parametrize("at", [0, 1, 17])
def test_save_restore_continue_equals_uninterrupted(kind, block, at):
    feeds = parts.feed(block, TICKS)
    whole = parts.flat(run(kind, block, feeds))
    state = block.init(parts.context(kind))
    first = parts.step_through(kind, block, state, feeds[:at])
    saved = pickle.dumps(state)
    parts.step_through(kind, block, state, feeds[at:], at)  # going on must not reach into what was saved
    rest = parts.step_through(kind, block, pickle.loads(saved), feeds[at:], at)
    assert parts.flat(first + rest) == whole


def test_inputs_and_past_outputs_are_left_alone(kind, block):
    feeds = parts.feed(block, TICKS)
    before = copy.deepcopy(feeds)
    state = block.init(parts.context(kind))
    seen, copies = [], []
    for k, samples in enumerate(feeds):
        (result,) = parts.step_through(kind, block, state, [samples], k)
        seen.append(result[0])
        copies.append(copy.deepcopy(result[0]))
    for given, kept in zip(feeds, before, strict=True):
        assert all(np.array_equal(a.value, b.value) for a, b in zip(given, kept, strict=True))
    for outputs, kept in zip(seen, copies, strict=True):
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(outputs, kept, strict=True))


def test_a_plant_is_observed_as_a_copy_would_be_and_untouched(kind, block):
    if not offers(block, Observes):
        pytest.skip("no observe")
    feeds = parts.feed(block, 3)
    state = block.init(parts.context(kind))
    parts.step_through(kind, block, state, feeds)
    inputs, now = [s.value for s in feeds[1]], 30 * NS_PER_MS
    times = [now, now + 1, now + 7 * NS_PER_MS, now + 35 * NS_PER_MS]
    before = pickle.dumps(state)
    stacks = block.observe(state, inputs, now, times)
    assert pickle.dumps(state) == before
    for i, instant in enumerate(times):
        ahead = pickle.loads(before)
        if instant > now:
            block.advance(ahead, inputs, now, instant)
        for stack, expected in zip(stacks, block.read(ahead, inputs), strict=True):
            assert np.allclose(stack[i], expected, rtol=0, atol=1e-12)
        # What is seen may not depend on what else is asked for, for that depends on how a run is cut.
        for stack, alone in zip(stacks, block.observe(state, inputs, now, [instant]), strict=True):
            assert stack[i].tobytes() == alone[0].tobytes()
    for stack, expected in zip(stacks, block.read(state, inputs), strict=True):
        assert np.array_equal(stack[0], expected)


def needs_stillness(kind, block):
    output = block.needs_stillness
    assert not output or {port.name: port.shape for port in block.outputs}[output] == (1,)


def designs(kind, block):
    """Steps leave the coefficients as they are."""
    context = parts.context(kind)
    before, state = pickle.dumps(block.design(context)), block.init(context)
    parts.step_through(kind, block, state, parts.feed(block, 5))
    assert pickle.dumps(block.design(context)) == before


def learns(kind, block):
    state = block.init(parts.context(kind))
    parts.step_through(kind, block, state, parts.feed(block, 5))
    after = block.next_trial(state, replace(parts.context(kind), trial=1))
    parts.step_through(kind, block, after, parts.feed(block, 5))


def resolves(kind, block):
    """A resolved block keeps its sizes."""
    again = block.resolve({port.name: port.shape for port in block.inputs})
    assert [port.shape for port in again.inputs] == [port.shape for port in block.inputs]
    assert all(port.resolved for port in again.inputs)


def explains_inputs(kind, block):
    assert isinstance(block.for_open_inputs, str)


def warns(kind, block):
    assert all(status.isidentifier() and detail for status, detail in block.cautions(parts.context(kind)))


def has_clock(kind, block):
    assert block.clock is None or block.clock.tick(1) > block.clock.tick(0) >= 0


def names(ports):
    return {port.name for port in ports}


def delays(kind, block):
    found = block.passages(parts.context(kind))
    assert all(isinstance(each, Passage) and each.delay_ns >= 0 for each in found)
    if block.inputs:  # parameters may leave out a port
        assert {name for each in found for name in each.inputs} <= names(block.inputs)
    assert {name for each in found for name in each.outputs} <= names(block.outputs)


def limits_age(kind, block):
    found = block.age_limits()
    assert all(isinstance(each, AgeLimit) and each.limit_ms > 0 for each in found)
    assert {each.port for each in found} <= names(block.inputs)


def guarded(kind, block):
    assert set(block.guarded) <= names(block.inputs)


def captures(kind, block):
    """What it says of its stamps is so."""
    tick = Tick()
    tick.time_ns = 10 * NS_PER_MS
    block.step(block.init(parts.context(kind)), parts.feed(block, 1)[0], tick)
    assert (tick.captured_ns == tick.time_ns) == block.captures


def interlocks(kind, block):
    assert block.interlock in names(block.inputs)


def ignores(kind, block):
    assert set(block.ignores) <= {port.name for port in block.inputs if port.optional}


def advances_through(kind, block):
    """Outputs of several instants at once are, to the bit, those of one instant after the other."""
    feeds = [[sample.value for sample in samples] for samples in parts.feed(block, 4)]
    times = [k * NS_PER_MS for k in (1, 2, 7, 9)]
    changes = [(0, feeds[0]), (2 * NS_PER_MS, feeds[1]), (3 * NS_PER_MS, feeds[2]), (8 * NS_PER_MS, feeds[3])]
    at_once = block.advance_through(block.init(parts.context(kind)), changes, times)
    state, now = block.init(parts.context(kind)), 0
    for stop in sorted({instant for instant, _ in changes[1:]} | set(times)):
        inputs = next(values for instant, values in reversed(changes) if instant < stop)
        block.advance(state, inputs, now, stop)
        now = stop
        if stop in times:
            for stack, value in zip(at_once, block.read(state, inputs), strict=True):
                assert np.asarray(stack[times.index(stop)]).tobytes() == np.asarray(value).tobytes()


def advances_steps(kind, block):
    """Several steps in one call leave, to the bit, what one after the other do, or nothing has changed."""
    period = block.grid.tick(1)
    feeds = [sample.value for samples in parts.feed(block, 8) for sample in samples]
    columns = [feeds[i::len(block.inputs)] for i in range(len(block.inputs))]
    stepped, at_once = (block.init(parts.context(kind)) for _ in range(2))
    for first, stop in ((0, 3), (3, 8)):
        times = [(k + 1) * period for k in range(first, stop)]
        before = [np.asarray(value).tobytes() for value in block.read(at_once, [c[first] for c in columns])]
        if not block.advance_steps(at_once, [c[first:stop] for c in columns], first * period, times):
            after = block.read(at_once, [c[first] for c in columns])
            assert [np.asarray(value).tobytes() for value in after] == before
            return
        for k in range(first, stop):
            block.advance(stepped, [c[k] for c in columns], k * period, (k + 1) * period)
            if k + 1 < stop:
                continue
            values = [block.read(state, [c[k] for c in columns]) for state in (stepped, at_once)]
            for one, other in zip(*values, strict=True):
                assert np.asarray(one).tobytes() == np.asarray(other).tobytes()


def steps_through(kind, block):
    """Ticks in one call give, to the bit, what one after the other give: outputs, reports and state."""
    feeds = parts.feed(block, TICKS)
    feeds[9:12] = [feeds[8]] * 3  # ticks without a new message
    feeds[14] = [sample._replace(value=-np.asarray(sample.value)) if sample.value is not None else sample
                 for sample in feeds[14]]  # bad input
    stepped, at_once = (block.init(parts.context(kind)) for _ in range(2))
    expected = parts.step_through(kind, block, stepped, feeds)
    done = 0
    for count in (1, 7, 2, 10, 20):
        ticks = [Tick() for _ in range(count)]
        for k, tick in enumerate(ticks, done):
            tick.index, tick.time_ns = k, k * 10 * NS_PER_MS
        columns = [list(column) for column in zip(*feeds[done:done + count], strict=True)]
        stacks = block.steps_through(at_once, columns, ticks)
        require_stacks(kind, block.outputs, stacks, count)
        for k, tick in enumerate(ticks):
            values, reports = expected[done + k]
            assert tick.reports == reports
            for stack, value in zip(stacks, values, strict=True):
                assert np.asarray(stack[k]).tobytes() == np.asarray(value).tobytes()
        done += count
    assert done == TICKS
    assert pickle.dumps(at_once) == pickle.dumps(stepped)


def reports(kind, block):
    assert all(status.isidentifier() for status, _ in block.reports(block.init(parts.context(kind))))


def glances(kind, block):
    """What is read at a glance is, to the bit, what `read` gives."""
    state = block.init(parts.context(kind))
    read = block.read(state, [port.initial_value() for port in block.inputs])
    for number, value in block.glance(state).items():
        assert np.asarray(value).tobytes() == np.asarray(read[number]).tobytes()


CHECKS = {NeedsStillness: needs_stillness, Designs: designs, Learns: learns, Resolves: resolves,
          ExplainsInputs: explains_inputs, Warns: warns, HasClock: has_clock,
          Delays: delays, LimitsAge: limits_age, Captures: captures, Guarded: guarded,
          Interlocks: interlocks, Ignores: ignores, AdvancesThrough: advances_through,
          AdvancesSteps: advances_steps, StepsThrough: steps_through, Reports: reports, Glances: glances}
CHECKED_ELSEWHERE = {
    "Observes": "above", "Linear": "tests/models/test_linear_form.py", "Closes": "tests/loop/test_devices.py",
    "UsesSensors": "tests/streams/blocks/test_join.py", "ChecksPlace": "tests/loop/test_surroundings.py",
    "WarnsInPlace": "tests/controllers/test_delay_in_place.py", "Attaches": "tests/realtime",
    "AwaitsArrivals": "tests/loop/test_arrivals.py", "Listens": "tests/realtime",
    "HasStandIn": "tests/realtime", "Seeks": "tests/realtime", "ChecksGuard": "tests/loop/test_guarding.py",
    "Guards": "tests/loop/test_guarding.py", "KeepsOwnTime": "tests/loop/test_latency.py"}
"""Protocols that need a loop, a device or another block."""


def test_every_protocol_is_checked_somewhere():
    named = {each.__name__ for each in CHECKS} | CHECKED_ELSEWHERE.keys()
    assert named == {each.__name__ for each in (*OF_BLOCKS, *OF_PLANTS)}


def test_a_block_keeps_what_its_protocols_promise(kind, block):
    for ability in OF_PLANTS if is_plant(block) else OF_BLOCKS:
        if ability in CHECKS and offers(block, ability):
            CHECKS[ability](kind, block)


class Wrong:
    """A block whose optional members have other parameters than their Protocols."""

    inputs = outputs = ()

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return ()

    def passages(self):
        return ()

    def guarded(self):
        return ()


class OneTooMany(Stimulator):
    """Puts out one tick too many."""

    def steps_through(self, state, inputs, ticks):
        stacks = super().steps_through(state, inputs, ticks)
        return tuple(np.concatenate((stack, stack[-1:])) for stack in stacks)


class Foreseeing(Stimulator):
    """Reads what the last tick reads in all of them."""

    def steps_through(self, state, inputs, ticks):
        return super().steps_through(state, [[column[-1]] * len(ticks) for column in inputs], ticks)


@pytest.mark.parametrize(("wrong", "fault"), [(OneTooMany, RunError), (Foreseeing, AssertionError)])
def test_ticks_in_one_call_that_are_not_those_of_steps_are_caught(wrong, fault):
    with pytest.raises(fault):
        steps_through("stimulator", wrong(channels=4))


def test_a_member_with_another_signature_is_named():
    assert list(contract_faults(Wrong)) == [
        "`passages()` is not the member `passages(context)` of Delays",
        "`guarded()` is not the member `guarded` of Guarded"]


def test_a_missing_member_is_named():
    found = list(contract_faults(type("Empty", (), {"init": Wrong.init, "outputs": (), "inputs": ()})))
    assert found == ["`step(state, inputs, tick)` is missing, which every block has"]


@pytest.mark.slow
def test_compiled_kernels_equal_plain_python():
    script = Path(parts.__file__)
    results = []
    for disabled in ("0", "1"):
        env = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
        done = subprocess.run([sys.executable, script], env=env, capture_output=True, text=True,
                              check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        results.append(json.loads(done.stdout))
    compiled, plain = results
    assert compiled.keys() == plain.keys() == set(KINDS)
    for kind in KINDS:
        for (a, told), (b, told_plain) in zip(compiled[kind], plain[kind], strict=True):
            assert told == told_plain, kind
            for x, y in zip(a, b, strict=True):
                x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
                assert np.allclose(x, y, rtol=1e-9, atol=1e-9, equal_nan=True), kind

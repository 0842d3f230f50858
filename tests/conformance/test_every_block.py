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

from fesloop.loop.assembly import empty_sample
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.guard import check_shapes

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


def test_what_needs_stillness_says_with_which_output_it_ends(kind, block):
    output = getattr(block, "needs_stillness", "")
    assert not output or {port.name: port.shape for port in block.outputs}[output] == (1,)


def test_what_no_sample_has_said_is_not_put_out_without_a_word(kind, block):
    if hasattr(block, "advance") or not block.inputs:
        pytest.skip("a plant or a source")
    if kind in ("stimulator", "electrodes", "point_search"):
        pytest.skip("nothing commanded is no stimulation, and a search begins by itself")
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
    if hasattr(block, "next_trial"):
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
    if not hasattr(block, "observe"):
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


@pytest.mark.slow
def test_compiled_kernels_equal_plain_python():
    script = Path(parts.__file__)
    results = []
    for disabled in ("0", "1"):
        env = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
        done = subprocess.run([sys.executable, script], env=env, capture_output=True, text=True, check=True,
                              timeout=300)
        results.append(json.loads(done.stdout))
    compiled, plain = results
    assert compiled.keys() == plain.keys() == set(KINDS)
    for kind in KINDS:
        for (a, told), (b, told_plain) in zip(compiled[kind], plain[kind], strict=True):
            assert told == told_plain, kind
            for x, y in zip(a, b, strict=True):
                x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
                assert np.allclose(x, y, rtol=1e-9, atol=1e-9, equal_nan=True), kind

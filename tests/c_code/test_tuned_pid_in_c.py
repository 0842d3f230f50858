"""The tuned PID in C equals the block."""

from __future__ import annotations

import numpy as np
import pytest
from c_code_parts import QUICK, STRICT, build, needs_gcc, record_type, run, stepped
from c_controller_parts import RATE, closed_loop, tuned_pid, tuned_pid_program
from hypothesis import given, settings
from hypothesis import strategies as st

pytestmark = needs_gcc
LONGEST_S = 500e-6


@pytest.mark.parametrize("steps", [3000, pytest.param(180_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("wired", [(), ("reference_preview",)])
@pytest.mark.parametrize("changes", [{}, {"rule": "amigo", "begin_s": 3.01}, {"feedforward": False}])
def test_a_run_is_the_blocks_to_the_last_digits(tmp_path, wired, changes, steps):
    block = tuned_pid(**changes)
    exported = tuned_pid_program(block, *wired)
    records = closed_loop(block, record_type(exported), steps, 1)
    ours = run(build(exported, tmp_path, STRICT if steps < 10_000 else QUICK), exported, records)
    theirs = stepped(block, exported, RATE, records)
    assert np.ptp(theirs) > 1e-4
    print(np.abs(ours[:, 1:] - theirs).max())
    # Drives of equal effect differ by a weight of 1e-6: rounding counts a million times.
    assert np.abs(ours[:, 1:] - theirs).max() < 1e-8 * LONGEST_S
    names = list(exported.statuses)
    assert {names[int(status)] for status in ours[:, 0]} >= {"OK", "NO_INPUT", "STALE_INPUT", "NON_FINITE"}


@settings(max_examples=8, deadline=None)
@given(rule=st.sampled_from(["simc", "amigo"]), closed_loop_ms=st.floats(0.0, 500.0),
       delay_ms=st.floats(0.0, 60.0), feedforward=st.booleans(), rise=st.floats(0.01, 20.0),
       width=st.floats(100.0, 500.0), wired=st.booleans(), seed=st.integers(0, 99))
def test_any_parameters_give_the_blocks_outputs(tmp_path_factory, rule, closed_loop_ms, delay_ms, feedforward,
                                                rise, width, wired, seed):
    block = tuned_pid(rule=rule, closed_loop_ms=closed_loop_ms, delay_ms=delay_ms, feedforward=feedforward,
                      charge_rise_uc=rise, width_max_us=width)
    exported = tuned_pid_program(block, *(["reference_preview"] if wired else []))
    records = closed_loop(block, record_type(exported), 500, seed)
    ours = run(build(exported, tmp_path_factory.mktemp("pid"), QUICK), exported, records)[:, 1:]
    theirs = stepped(block, exported, RATE, records)
    # Some of these loops are unstable, and amplify the rounding of either programme.
    assert np.abs(ours - theirs).max() < 1e-7 * LONGEST_S

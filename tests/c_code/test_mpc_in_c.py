"""Predictive control in C equals the block: its observer, its programme and its safe outputs."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from c_code_parts import NEXT_TRIAL, QUICK, STRICT, build, needs_gcc, record_type, run, stepped
from c_controller_parts import (
    GRASP_RATE,
    RATE,
    closed_loop,
    grasping,
    grasping_program,
    mpc,
    mpc_program,
    one_trial,
    remembering,
)
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from controllers.grip import Contact
from controllers.mpc.block import Mpc
from controllers.mpc.memory import Memory
from controllers.mpc.strength_adaptation import StrengthAdaptation
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock

BOXED = {"angle_max_deg": (45.0, 60.0, 90.0)}


def farthest(
    exported, block: Mpc, records: np.ndarray, binary, rate: str = RATE
) -> tuple[float, set[float]]:
    """Greatest difference of currents in A and of pulses as shares of the longest, and the statuses."""
    theirs, ours = stepped(block, exported, rate, records), run(binary, exported, records)
    assert np.ptp(theirs) > 1e-4
    far = np.abs(ours[:, 1:] - theirs)
    far[:, 1::2] /= 1e-6 * block.width_max_us
    return float(far.max()), set(ours[:, 0])


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("changes", [{}, BOXED], ids=["drives", "boxes"])
def test_an_hour_is_the_blocks_to_the_last_digits(tmp_path, changes):
    block = mpc(**changes)
    exported = mpc_program(block, "reference_preview")
    records = closed_loop(block, record_type(exported), 3600 * 50, 1)
    far, statuses = farthest(exported, block, records, build(exported, tmp_path, QUICK))
    print(f"greatest difference {far:.2g}")
    assert far < 1e-8  # 5e-12 s: with boxes the block itself moves by 3e-9 where its inputs change by one bit
    assert statuses >= {0.0, 1.0, 3.0, 4.0}


@needs_gcc
@pytest.mark.parametrize("wired", ["reference_preview", "reference"])
def test_a_minute_under_sanitizers_is_the_blocks(tmp_path, wired):
    block = mpc(**BOXED, horizon=12, begin_s=0.3, compensate_age=False)
    exported = mpc_program(block, wired)
    records = closed_loop(block, record_type(exported), 1500, 2)
    assert farthest(exported, block, records, build(exported, tmp_path, STRICT))[0] < 1e-9


@needs_gcc
@pytest.mark.slow
def test_an_hour_of_contact_on_and_off_is_the_blocks(tmp_path):
    block, context = grasping(), Context("block", clock=RateClock.from_rate(GRASP_RATE))
    exported = grasping_program(block)
    records, theirs = one_trial(block, block.init(context), record_type(exported), 3600 * 40,
                                np.random.default_rng(1), context.clock)
    ours = run(build(exported, tmp_path, QUICK), exported, records)
    far = np.abs(ours[:, 1:] - theirs)
    far[:, 1::2] /= 1e-6 * block.width_max_us
    print(f"greatest difference {far.max():.2g}")
    assert far.max() < 1e-9
    statuses = set(ours[:, 0])
    assert statuses >= {0.0, 1.0, 3.0, 4.0, list(exported.statuses).index("NO_FORCE")}


@needs_gcc
@pytest.mark.parametrize(
    "changes",
    [{}, {"grasping_channels": (), "horizon": 12},
     {"contact_places": ("palm", "F2d"), "contact": Contact(lasts_ms=75.0), "horizon": 12},
     BOXED | {"grasping_outputs": (), "horizon": 12}], ids=["shipped", "gain", "places", "boxes"])
def test_contact_under_sanitizers_is_the_blocks(tmp_path, changes):
    """Contact decides: without its forces the block gives other pulses."""
    block = grasping(**changes)
    exported = grasping_program(block)
    records = closed_loop(block, record_type(exported), 600, 2, GRASP_RATE)
    binary = build(exported, tmp_path, STRICT)
    assert farthest(exported, block, records, binary, GRASP_RATE)[0] < 1e-9
    unfelt = records.copy()
    unfelt["force_newest_ns"] = -1
    assert np.abs(run(binary, exported, unfelt)[:, 1:] - run(binary, exported, records)[:, 1:]).max() > 1e-5


@needs_gcc
@pytest.mark.parametrize(
    ("changes", "trials", "strength"),
    [({}, 4, 1.4), ({"grasping_outputs": (), "memory": Memory(share=1.0, stop_after=1)}, 6, 4.0),
     ({"begin_s": 0.0, "output_weight": (1.0, 0.2, 0.0), "memory": Memory(max_gap_ms=60.0)}, 4, 1.4)],
    ids=["shipped", "stops", "gaps"])
def test_what_trials_have_in_common_is_expected_as_by_the_block(tmp_path, changes, trials, strength):
    """Trials differ in their length, samples and contacts; without learning the pulses are others."""
    block = grasping(**{"memory": Memory(), "horizon": 12, "begin_s": 0.5} | changes)
    exported = grasping_program(block, 300)
    records, stopped = remembering(block, record_type(exported), 300, 1, trials, strength)
    assert stopped == (strength > 2.0)
    binary = build(exported, tmp_path, STRICT)
    assert farthest(exported, block, records, binary, GRASP_RATE)[0] < 1e-9
    ours = run(binary, exported, records)
    first, second = np.flatnonzero(records["time_ns"] == NEXT_TRIAL)[:2]
    before = np.concatenate([records[[first]], records])  # a trial that never was teaches nothing
    np.testing.assert_array_equal(run(binary, exported, before), ours)
    unlearnt = run(binary, exported, records[first + 1:second])
    assert np.abs(unlearnt - ours[first:second - 1])[:, 1:].max() > 1e-5


def test_memory_of_trials_of_no_length_is_refused():
    with pytest.raises(fesloop.InputError, match=r"control.memory: learns from trials of 1 ticks"):
        grasping_program(grasping(memory=Memory()), 1)


@needs_gcc
def test_where_the_programme_is_not_solved_in_time_the_last_solution_goes_on(tmp_path, monkeypatch):
    import controllers.c_export.mpc as in_c
    import controllers.mpc.design as design

    monkeypatch.setattr(design, "Qp", partial(design.Qp, max_iterations=6))
    monkeypatch.setattr(in_c, "DEFAULT_ITERATIONS", 6)
    block = mpc(horizon=14)
    exported = mpc_program(block, "reference_preview")
    records = closed_loop(block, record_type(exported), 600, 3)
    far, statuses = farthest(exported, block, records, build(exported, tmp_path, STRICT))
    assert far < 1e-9
    assert list(exported.statuses).index("ITERATION_LIMIT") in statuses


@needs_gcc
@settings(max_examples=6, deadline=None)
@given(
    horizon=st.integers(9, 16),
    slew=st.floats(0.02, 1.0),
    drive_max=st.floats(0.2, 1.0),
    move=st.floats(0.1, 2.0),
    delay_ms=st.floats(0.0, 60.0),
    rise_uc=st.floats(1.0, 20.0),
    seed=st.integers(0, 99),
)
def test_any_parameters_give_the_blocks_outputs(
    tmp_path_factory, horizon, slew, drive_max, move, delay_ms, rise_uc, seed
):
    block = mpc(
        horizon=horizon,
        slew=slew,
        drive_max=drive_max,
        move_weight=move,
        actuation_delay_ms=delay_ms,
        charge_rise_uc=rise_uc,
    )
    exported = mpc_program(block, "reference")
    records = closed_loop(block, record_type(exported), 300, seed)
    binary = build(exported, tmp_path_factory.mktemp("mpc"), QUICK)
    assert farthest(exported, block, records, binary)[0] < 1e-9


@pytest.mark.parametrize(
    ("changes", "wired", "where"),
    [
        ({"adaptation": StrengthAdaptation()}, (), "control.adaptation"),
        ({"horizon_charge_max_uc": 500.0}, (), "control.horizon_charge_max_uc"),
        ({"solver": "osqp"}, (), "control.solver"),
    ],
)
def test_what_c_lacks_is_refused(changes, wired, where):
    with pytest.raises(fesloop.InputError, match=f"{where}.* is .*not available in C"):
        mpc_program(mpc(**changes), *wired)

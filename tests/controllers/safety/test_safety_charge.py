"""Charge against a ledger kept outside the block, and limits that hold to the last bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.safety import Safety
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

MS = 1_000_000
CONTEXT = Context("safety", clock=RateClock.from_rate("40"))
WIDE = {"current_max_ma": 100.0, "width_max_us": 1000.0, "charge_max_uc": 100.0, "energy_max_mj": 300.0,
        "charge_rise_uc": 100.0, "charge_per_s_max_uc": 1e6, "charge_total_max_mc": 1e6}


def stepped(safety, state, index, now_ns, stimulation, tick=None):
    """Pulses of one tick with nothing but `stimulation` wired in."""
    tick = tick or Tick()
    tick.index, tick.time_ns = index, now_ns
    inputs = [Sample(stimulation, *[now_ns] * 3) if port.name == "stimulation" else
              Sample(np.zeros(tuple(size or 0 for size in port.shape)) if port.shape else 0.0, *[NEVER] * 3)
              for port in safety.inputs]
    return safety.step(state, inputs, tick)[0]


TICK = st.tuples(st.sampled_from([1, 1, 1, 1, 2, 45]), st.sampled_from([0, 0, 0, -1, 1, 8, 50, 700]),
                 st.lists(st.floats(0.0, 20.0), min_size=2, max_size=2),
                 st.sampled_from([False] * 9 + [True]))


@settings(deadline=None, max_examples=150)
@given(st.lists(TICK, min_size=5, max_size=60), st.sampled_from([20.0, 40.0, 50.0]))
def test_what_is_let_through_is_what_a_ledger_of_the_devices_pulses_has_left(rows, frequency_hz):
    """The device repeats a message until the next: q f for as long, a period at least, late ticks and all.

    Of what is wanted, exactly what is left of the budgets passes: no more, and no less.
    """
    second_uc, run_uc = 120.0, 400.0
    safety = Safety(channels=2, frequency_hz=frequency_hz,
                    **WIDE | {"charge_per_s_max_uc": second_uc, "charge_total_max_mc": 1e-3 * run_uc})
    state, index, now_ns = safety.init(CONTEXT), -1, 0
    ledger, before_uc = [], np.zeros(2)  # (tick, uC a phase, s) of this trial; uC of the trials before
    for ticks, late_ms, wanted_uc, ends in rows:
        index += ticks
        earlier_ns, now_ns = now_ns, now_ns + (25 * ticks + late_ms) * MS
        if ledger:
            ledger[-1][2] = max(0.025, 1e-9 * (now_ns - earlier_ns))
        pulses = stepped(safety, state, index, now_ns,
                         np.stack([np.full(2, 50e-3), np.array(wanted_uc) * 1e-6 / 50e-3], axis=1))
        charge_uc = 1e6 * pulses[:, 0] * pulses[:, 1]
        assert not pulses[charge_uc == 0.0].any()  # no pulse has no current either
        in_all = before_uc + sum((q * frequency_hz * s for _, q, s in ledger), np.zeros(2))
        in_second = sum((q * frequency_hz * s for k, q, s in ledger if k > index - 40), np.zeros(2))
        left_uc = np.maximum(np.minimum(run_uc - in_all, second_uc - in_second), 0.0)
        expected_uc = np.minimum(wanted_uc, left_uc / (0.025 * frequency_hz))
        np.testing.assert_allclose(charge_uc, expected_uc, rtol=1e-9, atol=1e-7)
        ledger.append([index, charge_uc, 0.025])
        if ends:
            before_uc = before_uc + sum((q * frequency_hz * s for _, q, s in ledger), np.zeros(2))
            state, index, ledger = safety.next_trial(state, CONTEXT), -1, []


LIMITS = ("charge_max_uc", "energy_max_mj", "charge_rise_uc", "charge_per_s_max_uc", "charge_total_max_mc")


@pytest.mark.parametrize("key", LIMITS)
def test_what_is_cut_to_a_limit_is_not_a_bit_above_it_and_hardly_below(key):
    """Of 5000 channels, each with limit and current of its own: their quotient, the width, is rounded."""
    rng = np.random.default_rng(3)
    limit = rng.uniform(0.1, 3.0, 5000) * (1e-3 if key == "charge_total_max_mc" else 1.0)
    safety = Safety(channels=5000, **WIDE | {key: tuple(limit.tolist())})
    current_ma = rng.uniform(60.0, 100.0, 5000)
    wanted = np.stack([1e-3 * current_ma, np.full(5000, 9e-4)], axis=1)
    pulses = stepped(safety, safety.init(CONTEXT), 0, 0, wanted)
    current, width = pulses.T
    np.testing.assert_array_equal(current, 1e-3 * current_ma)
    if key == "energy_max_mj":
        given, most = 2.0 * 500.0 * current * current * width, 1e-3 * limit
    else:
        given, most = current * width, (1e-3 if key == "charge_total_max_mc" else 1e-6) * limit
    assert (given <= most).all()
    assert (given >= most * (1.0 - 1e-11)).all()


def test_a_ramp_that_a_budget_has_cut_stays_below_the_cut_to_the_bit():
    """The budget of a second frees in mid-ramp, when the first pulse is a second old."""
    rng = np.random.default_rng(4)
    first, last = rng.uniform(10.0, 20.0, 5000), rng.uniform(1.0, 10.0, 5000)
    safety = Safety(channels=5000, ramp_ms=500.0,
                    **WIDE | {"charge_per_s_max_uc": tuple((first + 1.5 * last).tolist())})
    state, current, charges = safety.init(CONTEXT), rng.uniform(0.05, 0.1, 5000), []
    for k in range(41):
        charge = first if k == 0 else last if k == 38 else np.full(5000, np.nan if k > 38 else 0.0)
        pulses = stepped(safety, state, k, 25 * k * MS, np.stack([current, 1e-6 * charge / current], axis=1))
        charges.append(pulses[:, 0] * pulses[:, 1])
    np.testing.assert_allclose(charges[39], 0.5e-6 * last, rtol=1e-9)
    assert (charges[40] <= charges[39]).all()
    np.testing.assert_allclose(charges[40], charges[39], rtol=1e-14)


def test_each_fault_has_a_ramp_of_its_own_and_is_reported_anew():
    """The first of them, at t = 0, has nothing to ramp down."""
    safety, tick = Safety(channels=1, **WIDE, ramp_ms=100.0), Tick()
    state, widths = safety.init(CONTEXT), []
    for k, sound in enumerate((0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0)):
        wanted = np.array([[0.02, 4e-4 if sound else np.nan]])
        widths.append(1e6 * stepped(safety, state, k, 25 * k * MS, wanted, tick)[0, 1])
    np.testing.assert_allclose(widths, [0, 400, 400, 300, 400, 400, 400, 300, 200, 100, 0], atol=1e-6)
    assert [status for status, _ in tick.reports] == ["non_finite"] * 3


@pytest.mark.parametrize("wish", [(0.02, 0.0), (0.0, 3e-4), (-0.02, 3e-4), (0.02, -3e-4), (-0.02, -3e-4)])
def test_what_is_no_pulse_has_neither_current_nor_width(wish):
    safety = Safety(channels=2, **WIDE)
    pulses = stepped(safety, safety.init(CONTEXT), 0, 0, np.array([wish, (0.01, 2e-4)]))
    np.testing.assert_array_equal(pulses, [(0.0, 0.0), (0.01, 2e-4)])

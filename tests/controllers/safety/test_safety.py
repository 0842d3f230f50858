import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.safety import Safety, Watchdog
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

MS = 1_000_000
GENTLE = {"channels": 1, "current_max_ma": 40.0, "width_max_us": 400.0, "charge_max_uc": 8.0,
          "charge_rise_uc": 2.0, "max_age_ms": 100.0, "ramp_ms": 50.0}
ABSENT = Sample(0.0, NEVER, NEVER, NEVER)
CONTEXT = Context("safety", clock=RateClock.from_rate("40"))


def run(safety, values, ages_ms=None, period_ms=25):
    """Pulses (ticks, channels, 2) and reports for one input a tick."""
    state, tick, pulses = safety.init(CONTEXT), Tick(), []
    for k, value in enumerate(values):
        now = tick.time_ns = k * period_ms * MS
        tick.index = k
        age = 0 if ages_ms is None else ages_ms[k] * MS
        sample = Sample(np.array(value, dtype=float), now - age, now, now)
        pulses.append(safety.step(state, (sample, ABSENT, ABSENT, ABSENT, ABSENT), tick)[0])
    return np.array(pulses), tick.reports


def test_what_is_within_the_limits_passes_unchanged():
    values = [[[10e-3, 190e-6]], [[20e-3, 190e-6]], [[0.0, 0.0]]]
    pulses, reports = run(Safety(**GENTLE), values)
    np.testing.assert_array_equal(pulses, values)
    assert reports == []


def test_charge_rises_by_the_limit_and_falls_at_once():
    pulses, reports = run(Safety(**GENTLE), [[[20e-3, 399e-6]]] * 5 + [[[20e-3, 50e-6]]])
    charges = pulses[:, 0, 1] * 20e-3
    np.testing.assert_allclose(charges, [2e-6, 4e-6, 6e-6, 7.98e-6, 7.98e-6, 1e-6], rtol=1e-12)
    assert [status for status, _ in reports] == ["slew_limited"]


@pytest.mark.parametrize(("ages_ms", "bad", "status"), [
    ([0, 0, 120, 130, 140, 0], {}, "stale_input"),
    (None, {2: math.nan, 3: math.inf, 4: math.nan}, "non_finite"),
])
def test_bad_input_ramps_to_zero_is_told_once_and_ends(ages_ms, bad, status):
    values = [[[19e-3, bad.get(k, 100e-6)]] for k in range(6)]
    pulses, reports = run(Safety(**GENTLE), values, ages_ms)
    np.testing.assert_allclose(pulses[:, 0, 1], [100e-6, 100e-6, 100e-6, 50e-6, 0.0, 100e-6])
    assert [told for told, _ in reports] == [status]


def test_nothing_passes_before_the_first_input():
    safety, tick = Safety(**GENTLE), Tick()
    state = safety.init(CONTEXT)
    absent = Sample(np.full((1, 2), 0.01), NEVER, NEVER, NEVER)
    assert not safety.step(state, (absent, ABSENT, ABSENT, ABSENT, ABSENT), tick)[0].any()
    assert [status for status, _ in tick.reports] == ["no_input"]


@pytest.mark.parametrize(("wanted", "status"), [
    ((40e-3, 40e-6), "current_limited"), ((4e-3, 400e-6), "width_limited"), ((20e-3, 100e-6), "slew_limited"),
    ((32e-3, 250e-6), "charge_limited"), ((40e-3, 125e-6), "energy_limited")])
def test_a_limit_is_cut_to_right_where_it_is_passed(wanted, status):
    """1 in 1000 above a limit is within it afterwards; at the limit itself nothing happens."""
    safety = Safety(**GENTLE | {"energy_max_mj": 200.0 if status != "energy_limited" else 0.2,
                                "charge_rise_uc": 2.0 if status == "slew_limited" else 8.0})
    at_limit, told = run(safety, [[wanted]])
    np.testing.assert_allclose(at_limit[0, 0], wanted, rtol=1e-12)
    above, told = run(safety, [[np.multiply(wanted, 1.001)]])
    assert status in [each for each, _ in told]
    assert (above[0, 0] <= np.multiply(wanted, 1.001)).all()
    assert np.prod(above[0, 0]) < 1.0011 * np.prod(wanted)
    if status != "current_limited":
        assert above[0, 0, 1] < 1.0005 * wanted[1]


def test_charge_does_not_rise_again_in_a_ramp_when_the_budget_of_a_second_frees():
    """18 uC in ticks 1 to 5 and 35 to 39 are all of 36; the ramp begins with nothing left, then some is."""
    wanted = [[[20e-3, 200e-6 if 1 <= k <= 5 or k >= 35 else 0.0]] for k in range(46)]
    safety = Safety(**GENTLE | {"charge_per_s_max_uc": 36.0, "ramp_ms": 200.0})
    pulses, _ = run(safety, wanted, [0] * 40 + [500] * 6)
    charges = 1e6 * pulses[:, 0, 0] * pulses[:, 0, 1]
    assert charges[39] == pytest.approx(4.0)
    assert charges[40:].max() < 1e-6


def test_limits_of_single_channels():
    safety = Safety(**GENTLE | {"channels": 2, "current_max_ma": (40.0, 5.0)})
    pulses, _ = run(safety, [[[10e-3, 100e-6]] * 2])
    np.testing.assert_array_equal(pulses[0, :, 0], [10e-3, 5e-3])


def test_a_second_holds_its_budget_and_the_next_has_its_own():
    """1 uC a phase, 40 of them a second: a budget of 10 uC is used up by ten messages."""
    safety = Safety(**GENTLE | {"charge_per_s_max_uc": 10.0})
    pulses, reports = run(safety, [[[10e-3, 100e-6]]] * 55)
    charges = pulses[:, 0, 0] * pulses[:, 0, 1]
    np.testing.assert_allclose(charges[:10], 1e-6)
    assert charges[10:40].max() < 1e-15
    np.testing.assert_allclose(charges[40:50], 1e-6)
    assert [status for status, _ in reports] == ["charge_rate_limited"] * 2


def test_the_budget_of_a_run_is_spent_once_over_all_trials():
    safety = Safety(**GENTLE | {"charge_total_max_mc": 15e-3})
    wanted, tick = Sample(np.array([[10e-3, 100e-6]]), 0, 0, 0), Tick()
    state, given = safety.init(CONTEXT), []
    for _ in range(3):
        for tick.index in range(10):
            pulses = safety.step(state, (wanted, ABSENT, ABSENT, ABSENT, ABSENT), tick)[0]
            given.append(pulses[0, 0] * pulses[0, 1])
        state = safety.next_trial(state, CONTEXT)
    assert sum(given) == pytest.approx(15e-6)
    assert sum(given[16:]) == 0.0
    assert "charge_exhausted" in [status for status, _ in tick.reports]


def test_nothing_passes_before_every_tracker_is_aligned_and_a_lost_one_ramps_to_zero():
    safety, tick = Safety(**GENTLE, trackers=2), Tick()
    state, wanted = safety.init(CONTEXT), np.array([[19e-3, 100e-6]])
    widths = []
    flags_by_tick = [None, (0, 0), (1, 0), (1, math.nan), (1, 1), (1, 1), (0, 1), (0, 1), (0, 1)]
    for k, aligned in enumerate(flags_by_tick):
        tick.index, tick.time_ns = k, k * 25 * MS
        stamped = (k * 25 * MS,) * 3
        flags = ABSENT if aligned is None else Sample(np.array(aligned, dtype=float), *stamped)
        pulses, = safety.step(state, (Sample(wanted, *stamped), ABSENT, ABSENT, ABSENT, flags), tick)
        widths.append(1e6 * pulses[0, 1])
    np.testing.assert_allclose(widths, [0, 0, 0, 0, 100, 100, 100, 50, 0])
    assert [status for status, _ in tick.reports] == ["not_aligned", "not_aligned"]


def test_nothing_passes_until_the_hand_has_been_aligned_for_as_long_as_it_takes_to_relax():
    safety, tick = Safety(**GENTLE, trackers=1, wait_s=0.05), Tick()
    state, wanted, widths = safety.init(CONTEXT), np.array([[19e-3, 100e-6]]), []
    for k, aligned in enumerate([0, 1, 1, 1, 1, 0, 0, 1, 1, 1]):
        tick.index, tick.time_ns = k, k * 25 * MS
        stamped = (k * 25 * MS,) * 3
        flags = Sample(np.array([float(aligned)]), *stamped)
        pulses, = safety.step(state, (Sample(wanted, *stamped), ABSENT, ABSENT, ABSENT, flags), tick)
        widths.append(1e6 * pulses[0, 1])
    np.testing.assert_allclose(widths, [0, 0, 0, 100, 100, 100, 50, 0, 0, 100])
    assert [status for status, _ in tick.reports] == ["not_aligned", "waiting"] * 2


@pytest.mark.parametrize("value", [1.0, math.nan, math.inf])
def test_the_emergency_stop_cuts_at_once_and_for_good(value):
    safety, tick = Safety(**GENTLE), Tick()
    state, wanted = safety.init(CONTEXT), Sample(np.array([[10e-3, 100e-6]]), 0, 0, 0)
    seen = []
    for k, stop in enumerate((0.0, value, 0.0, 0.0)):
        tick.index = k
        inputs = (wanted, ABSENT, ABSENT, Sample(stop, 0, 0, 0), ABSENT)
        seen.append(safety.step(state, inputs, tick)[0].any())
        if k == 2:
            state = safety.next_trial(state, CONTEXT)
    assert seen == [True, False, False, False]
    assert {status for status, _ in tick.reports} == {"emergency_stop"}


def test_takes_sizes_from_the_wires():
    open_ended = Safety()
    assert open_ended.inputs[0].shape == (None, 2)
    assert open_ended.resolve({"stimulation": (3, 2)}).outputs[0].shape == (3, 2)
    assert open_ended.resolve({"stimulation": (3, 2)}).joints == 0
    assert open_ended.resolve({"stimulation": (3, 2), "posture": (23,)}).joints == 23
    with pytest.raises(InputError, match="posture"):
        open_ended.resolve({"stimulation": (3, 2), "posture": (23,), "posture_sd": (3,)})
    assert open_ended.resolve({"stimulation": (3, 2), "aligned": (2,)}).trackers == 2
    with pytest.raises(InputError, match="aligned"):
        open_ended.resolve({"stimulation": (3, 2), "aligned": ()})


@pytest.mark.parametrize(("key", "value"), [
    ("current_max_ma", 0.0), ("charge_max_uc", math.nan), ("energy_max_mj", 301.0), ("max_age_ms", -1.0),
    ("channels", -1), ("width_max_us", (100.0, 200.0)), ("charge_per_s_max_uc", 0.0),
    ("charge_total_max_mc", math.inf), ("frequency_hz", -1.0)])
def test_names_the_faulty_key(key, value):
    with pytest.raises(InputError, match=key):
        Safety(**{"channels": 3, key: value})


@pytest.mark.parametrize(("key", "value"), [
    ("silence_ms", 0.0), ("frozen_ms", -1.0), ("rate_max_deg_s", math.nan), ("jump_deg", -1.0),
    ("sd_max_deg", 0.0), ("recover_s", -1.0)])
def test_names_the_faulty_key_of_the_watchdog(key, value):
    with pytest.raises(InputError, match=f"watchdog.{key}"):
        Watchdog(**{key: value})


STIMULATION = st.floats() | st.sampled_from([0.02, 3e-4, 1e-3, -0.01, 0.04, 4e-4])
ANGLE = st.floats() | st.sampled_from([0.5, 0.51, 0.52, 0.5000001])
STAMP = st.integers(-50, 300)
TICKS = st.lists(st.tuples(
    st.lists(STIMULATION, min_size=4, max_size=4), STAMP,
    st.lists(ANGLE, min_size=2, max_size=2), STAMP, ANGLE, STAMP,
    st.sampled_from([0.0] * 12 + [1.0, math.nan, -5.0]), st.sampled_from([1, 1, 1, 2, 60]), st.booleans(),
    st.sampled_from([None] + [(1.0, 1.0)] * 6 + [(1.0, 0.0), (math.nan, 1.0)])),
    min_size=1, max_size=25)
STRICT = Safety(channels=2, joints=2, trackers=2, current_max_ma=(40.0, 30.0), width_max_us=400.0,
                charge_max_uc=8.0, energy_max_mj=2.0, charge_rise_uc=2.0, charge_per_s_max_uc=25.0,
                charge_total_max_mc=0.06, max_age_ms=100.0, ramp_ms=60.0, watchdog=Watchdog(recover_s=0.05))


@settings(deadline=None, max_examples=400)
@given(TICKS)
def test_no_output_ever_leaves_the_stated_set(rows):
    """Any values, ages, gaps between ticks, stops and ends of trials; the six rules of the docstring."""
    state, tick, index = STRICT.init(CONTEXT), Tick(), 0
    before, dose, total = np.zeros(2), {}, np.zeros(2)
    stopped, unsound_ns = False, None
    for pulses, age, posture, posture_age, sd, sd_age, stop, ticks, ends, aligned in rows:
        index += ticks
        tick.index, now = index, index * 25 * MS
        tick.time_ns = now

        def sample(value, age_ms, at=now):
            stamp = max(NEVER, at - max(age_ms, 0) * MS) if age_ms >= -25 else NEVER
            return Sample(value, stamp, stamp, stamp)

        stimulation = sample(np.array(pulses).reshape(2, 2), age)
        given_posture = sample(np.array(posture), posture_age)
        out = STRICT.step(state, (stimulation, given_posture, sample(np.array([sd, 0.1]), sd_age),
                                  Sample(stop, now, now, now),
                                  ABSENT if aligned is None else sample(np.array(aligned), 0)), tick)[0]
        current, width = out.T
        charge = current * width
        assert np.isfinite(out).all()
        assert (out >= 0.0).all()
        assert (current <= [40e-3, 30e-3]).all()
        assert (width <= 400e-6).all()
        assert (charge <= 8e-6).all()
        assert (1000.0 * current**2 * width <= 2e-3).all()
        assert (charge - before <= 2e-6 * (1.0 + 1e-12)).all()
        dose[index] = charge
        total += charge
        assert (sum(q for k, q in dose.items() if k > index - 40) <= 25e-6 * (1.0 + 1e-12)).all()
        assert (total <= 60e-6 * (1.0 + 1e-12)).all()
        stopped = stopped or not stop <= 0.5
        assert not (stopped and out.any())
        if _unsound(stimulation, given_posture, now) or aligned != (1.0, 1.0):
            assert (charge <= before).all()
            unsound_ns = now if unsound_ns is None else unsound_ns
            assert now - unsound_ns < 60 * MS or not out.any()
        else:
            unsound_ns = None
        before = charge
        if ends:
            state, before, dose = STRICT.next_trial(state, CONTEXT), np.zeros(2), {}
            unsound_ns, index = None, 0


def _unsound(stimulation, posture, now):
    """What surely is: absent, old or not finite."""
    return any(not sample.present or now - sample.oldest_ns > 100 * MS or not np.isfinite(sample.value).all()
               for sample in (stimulation, posture))


@pytest.mark.parametrize("late_ms", [75, 33, 26])
def test_pulses_that_the_device_repeats_until_a_late_tick_count(late_ms):
    """Of a live stream's clock, nominally of 25 ms: of 7.6 uC, 40 Hz give 304 uC in a second."""
    safety = Safety(**GENTLE, charge_per_s_max_uc=100.0)
    pulses, _ = run(safety, [[[20e-3, 380e-6]]] * 200, period_ms=late_ms)
    given = 1e6 * pulses[:, 0, 0] * pulses[:, 0, 1] * 40.0 * late_ms / 1e3
    a_second = math.ceil(1000 / late_ms)
    sums = np.convolve(given, np.ones(a_second), "valid")
    assert sums.max() < 100.0 + 7.6 * late_ms / 25  # one tick is known to be late when it is over
    assert sums.max() > 50.0

"""The tuned PID in loops whose answers are known: lags, antagonists, limits, weak and strong plants."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from controllers.pid import TunedPid
from controllers.pid.tuning import gain_at_rest
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.linear_model import LinearModel, Recruitment

CONTEXT = Context("pid", clock=RateClock.from_rate("40"))
PERIOD_NS, MS = 25_000_000, 1_000_000
LAG_S = np.array([0.15, 0.2, 0.25])
GAIN = np.array([[1.2, 0.3, -0.9, -0.2, 0.1, 0.0, 0.2, -0.1],
                 [0.2, 1.0, -0.1, -0.8, 0.3, -0.3, 0.0, 0.1],
                 [0.0, 0.1, 0.1, -0.1, 0.9, -0.8, 0.4, -0.3]])
CURVES = Recruitment(threshold_ma=(8.0,) * 8, spread=(0.3,) * 8)
OFFSET = np.array([0.1, 0.2, 0.0])


def hand(strength=1.0, recruitment=CURVES):
    """Eight channels, three outputs, 40 ms late."""
    return LinearModel(a=-np.diag(1.0 / LAG_S), b=strength * GAIN / LAG_S[:, np.newaxis], c=np.eye(3),
                       offset=OFFSET, delay_ns=40 * MS, recruitment=recruitment)


def controller(**changes):
    return TunedPid(**{"model": hand(), "current_ma": (30.0,) * 8, "delay_ms": 0.0,
                       "charge_rise_uc": 15.0} | changes)


def sample(value, time_ns):
    return Sample(np.asarray(value, dtype=float), time_ns, time_ns, time_ns)


def closed_loop(pid, plant, reference, seconds=6.0, period_s=0.025):
    """Outputs (ticks, 3), drives (ticks, 8) and reports of a loop with the plant behind its recruitment."""
    model = plant.sampled(PERIOD_NS)
    state, tick, x = pid.init(CONTEXT), Tick(), np.zeros(model.a.shape[0])
    rows, drives = [], []
    for k in range(int(seconds * 40)):
        tick.index, tick.time_ns = k, k * PERIOD_NS
        y = model.c @ x + model.offset
        inputs = [sample(reference(k * period_s), tick.time_ns), sample(y, tick.time_ns)]
        if pid.preview:
            coming = [reference((k + 1 + n) * period_s) for n in range(pid.preview)]
            inputs.append(sample(coming, tick.time_ns))
        (pulses,) = pid.step(state, inputs, tick)
        drives.append(CURVES.fraction(pulses))
        x = model.a @ x + model.b @ drives[-1]
        rows.append(y)
    return np.array(rows), np.array(drives), tick.reports


TARGET = OFFSET + GAIN @ np.array([0.4, 0.0, 0.0, 0.2, 0.3, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("rule", ["simc", "amigo"])
@pytest.mark.parametrize("strength", [0.7, 1.0, 1.3])
def test_steps_settle_where_asked_with_30_percent_more_and_less_strength(rule, strength):
    for target in (TARGET, 2.0 * OFFSET - TARGET):
        reached, drives, reports = closed_loop(controller(rule=rule, feedforward=False), hand(strength),
                                               lambda t, target=target: target)
        way = target - OFFSET
        assert np.abs(np.degrees(reached[-40:] - target)).max() < 0.2
        beyond = np.sign(way) * (reached - target)
        assert beyond.max() < 0.3 * np.abs(way).max()
        assert drives.min() >= 0.0
        assert not reports


@pytest.mark.parametrize("strength", [0.7, 1.0, 1.3])
def test_feedforward_that_sees_ahead_lowers_the_error_of_a_smooth_move(strength):
    def reference(t):
        s = np.clip((t - 0.5) / 1.5, 0.0, 1.0)
        return OFFSET + s**3 * (10.0 + s * (6.0 * s - 15.0)) * (TARGET - OFFSET)

    def rmse_deg(**feedforward):
        reached, _, _ = closed_loop(controller(**feedforward), hand(strength), reference, 4.0)
        wanted = np.array([reference(k / 40) for k in range(160)])
        return np.degrees(np.sqrt(np.mean((reached - wanted) ** 2)))

    assert rmse_deg(preview=20) < 0.7 * rmse_deg(feedforward=False)


def test_feedforward_of_the_very_plant_leaves_feedback_nothing_to_do():
    """A step arrives as the lag and the delay of each output let it, without overshoot."""
    reached, _, _ = closed_loop(controller(charge_rise_uc=1e6), hand(), lambda t: TARGET, 3.0)
    times = np.arange(len(reached)) * 0.025
    way = 1.0 - np.exp(-np.maximum(times[:, np.newaxis] - 0.04, 0.0) / LAG_S)
    assert np.abs(np.degrees(reached - OFFSET - way * (TARGET - OFFSET))).max() < 2.0


def test_feedforward_is_the_inverse_at_rest_within_the_boxes():
    """A first tick without error has the feedforward alone; drives are those of a bounded least squares."""
    pid = controller(charge_rise_uc=1e6)
    for target in (TARGET, OFFSET + np.array((3.0, -1.0, 0.5))):
        state, tick = pid.init(CONTEXT), Tick()
        (pulses,) = pid.step(state, (sample(target, 0), sample(target, 0)), tick)
        wanted = lsq_linear(gain_at_rest(pid.model), target - OFFSET, (0.0, pid.allocation().reach()),
                            tol=1e-12)
        told = gain_at_rest(pid.model) @ CURVES.fraction(pulses)
        np.testing.assert_allclose(told, gain_at_rest(pid.model) @ wanted.x, atol=1e-3)


def test_a_stated_delay_adds_to_the_models_own_and_to_half_a_period():
    found = [tuning.lag.delay_s for tuning in controller(delay_ms=40.0).tuning(0.025)]
    np.testing.assert_allclose(found, [tuning.lag.delay_s + 0.04 for tuning in controller().tuning(0.025)])


def test_without_feedforward_the_integral_brings_it_there_all_the_same():
    reached, _, _ = closed_loop(controller(feedforward=False), hand(), lambda t: TARGET, seconds=10.0)
    assert np.abs(np.degrees(reached[-1] - TARGET)).max() < 0.2


def test_before_it_begins_nothing_is_commanded_and_nothing_learnt():
    """Two seconds on a hand that is held at rest, and one that was never held, from then on."""
    held, free = controller(begin_s=2.0), controller()
    state, other, tick, late = held.init(CONTEXT), free.init(CONTEXT), Tick(), Tick()
    for k in range(200):
        tick.index, tick.time_ns = k, k * PERIOD_NS
        inputs = [sample(TARGET, tick.time_ns), sample(OFFSET, tick.time_ns)]
        (pulses,) = held.step(state, inputs, tick)
        if k < 80:
            assert not pulses[:, 1].any()
            assert not state.integral.any()
        else:
            late.index, late.time_ns = k, tick.time_ns
            np.testing.assert_array_equal(pulses, free.step(other, inputs, late)[0])
    assert pulses[:, 1].any()
    assert not tick.reports


def test_what_cannot_be_reached_is_approached_and_left_without_delay():
    """The integral does not wind up on what no drive gives: and comes back as soon as from rest."""
    far = OFFSET + np.array((5.0, 0.0, 0.0))
    reached, drives, _ = closed_loop(controller(), hand(), lambda t: far if t < 8.0 else TARGET, seconds=11.0)
    never, _, _ = closed_loop(controller(), hand(), lambda t: TARGET, seconds=3.0)
    reach = controller().allocation().reach()
    kp = controller().gains(0.025)[:, 0]
    best = lsq_linear(np.sqrt(kp)[:, np.newaxis] * GAIN, np.sqrt(kp) * (far - OFFSET), (0.0, reach))
    np.testing.assert_allclose(reached[8 * 40 - 1] - OFFSET, GAIN @ best.x, atol=0.02)

    def settled(rows):
        return np.flatnonzero(np.abs(np.degrees(rows - TARGET)).max(axis=1) > 5.0)[-1] / 40

    assert settled(reached[8 * 40:]) < settled(never) + 0.5
    assert drives.max() <= reach.max() + 1e-9


@pytest.mark.slow
@given(data=st.data())
@settings(max_examples=15, deadline=None)
def test_pulses_stay_in_their_limits_whatever_comes_in(data):
    values = st.floats(allow_nan=True, allow_infinity=True)
    pid = controller(charge_rise_uc=3.0)
    state, tick, charges = pid.init(CONTEXT), Tick(), np.zeros(8)
    for k in range(12):
        tick.index, tick.time_ns = k, k * PERIOD_NS
        reference, measured = (data.draw(st.lists(values, min_size=3, max_size=3)) for _ in range(2))
        (pulses,) = pid.step(state, (sample(reference, tick.time_ns), sample(measured, tick.time_ns)), tick)
        assert np.isfinite(pulses).all()
        assert (pulses >= 0.0).all()
        assert (pulses[:, 1] <= 500e-6).all()
        charge = pulses[:, 0] * pulses[:, 1]
        assert (charge <= charges + 3.0e-6 + 1e-12).all()
        charges = charge


def test_trouble_is_told_once_and_means_no_stimulation():
    pid = controller()
    state, tick = pid.init(CONTEXT), Tick()
    nothing = Sample(np.zeros(3), NEVER, NEVER, NEVER)
    for k, inputs in enumerate([(nothing, nothing), (nothing, nothing),
                                (sample(TARGET, 0), sample(OFFSET, 0)),
                                (sample(TARGET, 0), sample([np.nan] * 3, 0)),
                                (sample(TARGET, 0), sample(OFFSET, 0))]):
        tick.index, tick.time_ns = k, k * PERIOD_NS
        (pulses,) = pid.step(state, inputs, tick)
        assert (pulses.any()) == (k in (2, 4))
    tick.time_ns = 500 * MS
    assert not pid.step(state, (sample(TARGET, 0), sample(OFFSET, 0)), tick)[0].any()
    assert [status for status, _ in tick.reports] == ["no_input", "non_finite", "stale_input"]


def test_saved_and_restored_it_goes_on_bit_for_bit():
    pid, tick = controller(), Tick()
    state = pid.init(CONTEXT)
    states = [state]
    for k in range(20):
        if k == 7:
            states.append(pickle.loads(pickle.dumps(state)))
        tick.index, tick.time_ns = k, k * PERIOD_NS
        y = OFFSET + 0.01 * np.sin(k + np.arange(3))
        told = [pid.step(each, (sample(TARGET, tick.time_ns), sample(y, tick.time_ns)), tick)[0]
                for each in states]
        assert all((each == told[0]).all() for each in told)


@pytest.mark.parametrize(("changes", "where"), [
    ({"current_ma": (30.0,)}, "current_ma"), ({"rule": "ziegler"}, "rule"), ({"delay_ms": -1.0}, "delay_ms"),
    ({"charge_rise_uc": 0.0}, "charge_rise_uc"), ({"preview": -1}, "preview"),
    ({"begin_s": -1.0}, "begin_s")])
def test_parameters_that_cannot_be_are_named(changes, where):
    with pytest.raises(InputError) as fault:
        controller(**changes)
    assert fault.value.where == where


def test_a_preview_that_ends_too_soon_is_named():
    with pytest.raises(InputError, match="12 or more"):
        controller(preview=5).init(CONTEXT)

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import dlsim, lfilter

from controllers.pid import Pid
from controllers.pid.block import can_follow
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.linear_model import Recruitment

CONTEXT = Context("pid", clock=RateClock.from_rate("40"))
PERIOD = 1 / 40
MIXING = ((1.0, 0.2), (-0.8, 0.1), (0.0, 0.5))
LINEAR = {"kp": (0.7, 1.1), "ki": (2.0, 3.0), "kd": (0.05, 0.02), "mixing": MIXING,
          "current_ma": (20.0, 20.0, 20.0), "bias": (0.1, 0.2, 0.3), "recruitment_curve": "linear",
          "full_scale_us": 400.0, "derivative_filter_ms": 15.0}
CURVES = Recruitment(threshold_ma=(12.0, 10.0, 8.0), spread=(0.35, 0.35, 0.35))
LIMITED = LINEAR | {"recruitment_curve": "lognormal", "recruitment": CURVES}


def sample(value, time_ns=0):
    return Sample(np.asarray(value, dtype=float), time_ns, time_ns, time_ns)


def run(pid, references, measurements):
    """Pulses (ticks, muscles, 2), the final state and all reports."""
    state, tick, pulses = pid.init(CONTEXT), Tick(), []
    for k, (reference, measured) in enumerate(zip(references, measurements, strict=True)):
        tick.index, tick.time_ns = k, CONTEXT.clock.tick(k)
        pulses.append(pid.step(state, (sample(reference), sample(measured)), tick)[0])
    return np.array(pulses), state, tick.reports


def signals(ticks=60, seed=1):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((ticks, 2)), rng.standard_normal((ticks, 2)).cumsum(axis=0) * 0.1


def test_equals_its_transfer_function_with_linear_recruitment():
    references, measured = signals()
    pulses, _, _ = run(Pid(**LINEAR), references, measured)
    command = np.zeros((60, 2))
    for j in range(2):
        error = references[:, j] - measured[:, j]
        integral = lfilter([0.0, LINEAR["ki"][j] * PERIOD], [1.0, -1.0], error)
        pole, rate = 0.015 / (0.015 + PERIOD), LINEAR["kd"][j] / (0.015 + PERIOD)
        moved = measured[:, j] - measured[0, j]
        derivative = -lfilter([rate, -rate], [1.0, -pole], moved)
        command[:, j] = LINEAR["kp"][j] * error + integral + derivative
    drive = np.array(LINEAR["bias"]) + command @ np.array(MIXING).T
    np.testing.assert_allclose(pulses[:, :, 1], drive * 400e-6, atol=1e-15)


def test_sampled_matrices_equal_the_block():
    references, measured = signals()
    measured -= measured[0]
    pid = Pid(**LINEAR)
    pulses, _, _ = run(pid, references, measured)
    _, drive, _ = dlsim((*pid.sampled(PERIOD), PERIOD), np.hstack([references, measured]))
    np.testing.assert_allclose(pulses[:, :, 1] / 400e-6 - np.array(LINEAR["bias"]), drive, atol=1e-12)


def test_wound_up_command_comes_back_at_once():
    pid = Pid(**LIMITED | {"kd": (0.0, 0.0)})
    push, back = [[40.0, 40.0]] * 400, [[-0.5, -0.5]] * 3
    pulses, _, reports = run(pid, push + back, np.zeros((403, 2)))
    assert pulses[399, 0, 1] == pytest.approx(500e-6)
    assert pulses[402, 0, 1] < 400e-6
    assert reports == [("saturated", "a channel is at its longest pulse")]


def test_integral_goes_on_while_an_antagonist_is_released():
    pid = Pid(**LIMITED | {"kp": (0.0, 0.0), "kd": (0.0, 0.0), "ki": (1.0, 0.0)})
    pulses, state, _ = run(pid, [[0.5, 0.0]] * 40, np.zeros((40, 2)))
    assert pulses[-1, 1, 1] == 0.0
    np.testing.assert_allclose(state.memory[0], [0.5 * 40 * PERIOD, 0.0])


def test_no_stimulation_before_the_first_measurement():
    pid, tick = Pid(**LIMITED), Tick()
    state = pid.init(CONTEXT)
    absent = Sample(np.zeros(2), NEVER, NEVER, NEVER)
    for _ in range(3):
        (pulses,) = pid.step(state, (sample([1.0, 1.0]), absent), tick)
        assert not pulses.any()
    assert [status for status, _ in tick.reports] == ["no_input"]


def test_no_stimulation_on_non_finite_input_and_no_trace_of_it_after():
    references, measured = signals(20)
    clean, _, _ = run(Pid(**LIMITED), np.delete(references, 10, 0), np.delete(measured, 10, 0))
    broken = measured.copy()
    broken[10, 1] = np.nan
    pulses, _, reports = run(Pid(**LIMITED), references, broken)
    assert not pulses[10].any()
    np.testing.assert_array_equal(np.delete(pulses, 10, 0), clean)
    assert [status for status, _ in reports].count("non_finite") == 1


@settings(deadline=None, max_examples=50)
@given(st.lists(st.tuples(*[st.floats(-1e300, 1e300)] * 4), min_size=1, max_size=10))
def test_pulses_stay_within_reach_whatever_comes_in(rows):
    table = np.array(rows)
    pulses, _, _ = run(Pid(**LIMITED), table[:, :2], table[:, 2:])
    assert np.isfinite(pulses).all()
    assert pulses[:, :, 1].min() >= 0.0
    assert pulses[:, :, 1].max() <= 500e-6


def test_state_pickles_and_goes_on_alike():
    pid = Pid(**LIMITED)
    references, measured = signals(5)
    _, state, _ = run(pid, references, measured)
    twin = pickle.loads(pickle.dumps(state))
    now = sample([0.3, 0.2]), sample([0.1, 0.4])
    np.testing.assert_array_equal(pid.step(state, now, Tick())[0], pid.step(twin, now, Tick())[0])


@pytest.mark.parametrize(("faulty", "key"), [
    ({"ki": (1.0,)}, "ki"), ({"kp": (), "ki": (), "kd": ()}, "kp"), ({"mixing": ((1.0, 0.0),)}, "mixing"),
    ({"bias": (0.1,)}, "bias"), ({"recruitment": None}, "recruitment"),
    ({"derivative_filter_ms": -1.0}, "derivative_filter_ms"), ({"kd": (float("inf"), 0.0)}, "kd"),
])
def test_names_the_faulty_key(faulty, key):
    with pytest.raises(InputError, match=key):
        Pid(**LIMITED | faulty)


@pytest.mark.parametrize(("weights", "follows"), [
    ((1.0, 0.1), True), ((1.0, 0.0), False), ((-1.0, 0.0), True), ((0.0, -0.1), True)])
def test_an_integral_grows_where_a_muscle_follows_it_however_weakly(weights, follows):
    """The first muscle is at its most, the second within its range."""
    channels = np.array([[0.0, 0.0, 1.0]] * 2)
    assert can_follow(np.array(weights), channels, np.array([2.0, 0.5]), 1.0) is follows

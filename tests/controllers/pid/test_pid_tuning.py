"""Tuning rules against the margins that their authors print, and fits against what they were made from."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from controllers.pid.tuning import Gains, Lag, amigo, dominant_drives, fitted_lag, gain_at_rest, simc, tuned
from fesloop.errors import InputError
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger

MS = 1_000_000
OMEGA = np.geomspace(1e-2, 300.0, 2001)


def margins(gains, lag):
    """Gain margin, phase margin in deg and greatest sensitivity, by python-control, the delay exact."""
    s = 1j * OMEGA
    loop = gains.kp * (1.0 + 1.0 / (gains.integral_s * s) + gains.derivative_s * s) \
        * lag.gain * np.exp(-lag.delay_s * s) / (1.0 + lag.lag_s * s)
    # Above the band of interest the phase of a delay turns on and on.
    kept = OMEGA * lag.delay_s < 4.0
    gain_margin, phase_margin, *_ = control.margin(control.frd(loop[kept], OMEGA[kept]))
    return gain_margin, phase_margin, np.abs(1.0 / (1.0 + loop)).max()


def lagging(gain=2.0, lag_s=0.3, delay_ms=0.0):
    return LinearModel(a=np.array([[-1.0 / lag_s]]), b=np.array([[gain / lag_s]]), c=np.array([[1.0]]),
                       offset=np.zeros(1), delay_ns=round(delay_ms * MS))


@pytest.mark.parametrize(("lag", "published"), [
    (Lag(2.0, 0.3, 0.1), (3.14, 61.4, 1.59)), (Lag(0.5, 20.0, 0.1), (2.96, 46.9, 1.70))])
def test_simc_has_the_margins_of_table_1(lag, published):
    gain_margin, phase_margin, sensitivity = margins(simc(lag, lag.delay_s), lag)
    assert gain_margin == pytest.approx(published[0], abs=0.02)
    assert phase_margin == pytest.approx(published[1], abs=1.0)
    assert sensitivity == pytest.approx(published[2], abs=0.02)


@pytest.mark.slow
@given(ratio=st.floats(0.1, 5.0), gain=st.floats(0.1, 10.0), delay=st.floats(0.01, 0.3))
@settings(max_examples=25, deadline=None)
def test_amigo_keeps_its_robustness_and_both_rules_withstand_30_percent(ratio, gain, delay):
    """Designed for a greatest sensitivity of 1.4 over a batch of processes; on a pure lag it is near that."""
    lag = Lag(gain, ratio * delay, delay)
    for gains, bound in ((amigo(lag), 1.75), (simc(lag, delay), 1.75)):
        gain_margin, _, sensitivity = margins(gains, lag)
        assert sensitivity < bound
        assert gain_margin > 1.3 * 1.3


@given(gain=st.floats(0.1, 3.0), lag_s=st.floats(0.05, 0.2), delay_ms=st.integers(0, 200))
@settings(max_examples=25, deadline=None)
def test_the_fit_of_a_lag_behind_a_delay_is_that_lag(gain, lag_s, delay_ms):
    fitted = fitted_lag(lagging(gain, lag_s, delay_ms), np.ones(1), 0, 1.0)
    assert fitted == pytest.approx((gain, lag_s, 1e-3 * delay_ms), rel=1e-3, abs=1e-4)


def test_two_lags_fit_as_their_step_response_says():
    """Of 1 / (0.2 s + 1)^2 the times to 28.3 % and 63.2 % solve 1 - (1 + x) exp(-x)."""
    model = LinearModel(a=np.array([[-5.0, 0.0], [5.0, -5.0]]), b=np.array([[5.0], [0.0]]),
                        c=np.array([[0.0, 1.0]]), offset=np.zeros(1))
    time, response = control.step_response(control.tf([1.0], [0.04, 0.4, 1.0]), T=np.linspace(0, 3, 30001))
    early, late = np.interp([1 - np.exp(-1 / 3), 1 - np.exp(-1)], response, time)
    fitted = fitted_lag(model, np.ones(1), 0, 1.0)
    assert fitted.lag_s == pytest.approx(1.5 * (late - early), rel=1e-3)
    assert fitted.delay_s == pytest.approx(late - 1.5 * (late - early), rel=1e-2)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_way_is_the_least_of_those_that_pull_only(sense):
    gain = np.array([1.0, -0.5, 0.2, -0.3])
    found = dominant_drives(gain, sense)
    best = minimize(lambda v: v @ v, np.ones(4), bounds=[(0, None)] * 4, tol=1e-14,
                    constraints={"type": "eq", "fun": lambda v: gain @ v - sense})
    np.testing.assert_allclose(found, best.x, atol=1e-6)
    assert not dominant_drives(np.array([0.2, 0.04]), -1.0).any()


def test_gain_at_rest_is_that_of_python_control_after_2_s():
    model = Finger().linear_model()
    system = control.ss(model.a, model.b, model.c, np.zeros((model.outputs, model.inputs)))
    risen = control.step_response(system, T=np.linspace(0.0, 2.0, 2001), squeeze=False).outputs
    np.testing.assert_allclose(gain_at_rest(model), risen[:, :, -1], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(gain_at_rest(model), control.dcgain(system), rtol=1e-2, atol=1e-6)


@given(lag_s=st.floats(0.05, 0.2), drift_s=st.floats(8.0, 100.0), drift=st.floats(-3.0, 3.0))
@settings(max_examples=25, deadline=None)
def test_drift_that_a_model_has_learnt_does_not_turn_the_gains(lag_s, drift_s, drift):
    """Up to three times the movement, either way, over 8 to 100 s."""
    model = LinearModel(a=np.diag([-1.0 / lag_s, -1.0 / drift_s]),
                        b=np.array([[1.0 / lag_s], [drift / drift_s]]),
                        c=np.ones((1, 2)), offset=np.zeros(1))
    assert gain_at_rest(model)[0, 0] == pytest.approx(1.0, abs=abs(drift) * 2.0 / drift_s + 1e-3)
    ((_, lag),) = tuned(model, "simc", extra_delay_s=0.05, closed_loop_s=0.0)
    assert lag.gain == pytest.approx(1.0, rel=1e-6)
    assert lag.delay_s + lag.lag_s < 1.2


def test_the_weaker_of_both_senses_counts_and_delay_of_the_loop_is_in():
    quick, slow = lagging(1.0, 0.1), lagging(1.0, 0.3)
    model = LinearModel(a=np.diag([-10.0, -10.0 / 3.0]), b=np.diag([10.0, -10.0 / 3.0]), c=np.ones((1, 2)),
                        offset=np.zeros(1))
    for each, expected_s in ((quick, 0.1), (slow, 0.3), (model, 0.1)):
        ((gains, lag),) = tuned(each, "simc", extra_delay_s=0.05, closed_loop_s=0.0)
        assert lag == pytest.approx(Lag(1.0, expected_s, 0.05), rel=5e-3)
        assert gains == pytest.approx(Gains(expected_s / 0.1, min(expected_s, 0.4), 0.0), rel=5e-3)
    ((slower, _),) = tuned(quick, "simc", extra_delay_s=0.05, closed_loop_s=0.45)
    assert slower.kp == pytest.approx(0.1 / 0.5, rel=5e-3)


def test_models_that_allow_no_tuning_are_named():
    with pytest.raises(InputError, match="it is not stable"):
        tuned(LinearModel(a=np.zeros((1, 1)), b=np.ones((1, 1)), c=np.ones((1, 1)), offset=np.zeros(1)),
              "simc", extra_delay_s=0.05, closed_loop_s=0.0)
    dead = LinearModel(a=-np.eye(2), b=np.array([[1.0], [0.0]]), c=np.eye(2), offset=np.zeros(2))
    with pytest.raises(InputError, match="no drive moves output 1"):
        tuned(dead, "simc", extra_delay_s=0.05, closed_loop_s=0.0)

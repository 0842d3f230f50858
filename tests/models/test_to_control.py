"""Systems of python-control from parts of a loop, and parts from its systems, against analytic results."""

import control
import numpy as np
import pytest

from controllers.pid import Pid, TunedPid
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger
from plants.linear import StateSpace

OMEGA = np.logspace(-1, 1.5, 9)
LAG = LinearModel(a=[[-4.0]], b=[[4.0]], c=[[1.0]], offset=[0.2], delay_ns=30_000_000)


def test_a_delay_is_exact_in_discrete_time_and_approximated_in_continuous_time():
    z = np.exp(1j * OMEGA * 0.01)
    held = (1.0 - np.exp(-0.04)) / (z - np.exp(-0.04)) * z**-3  # 30 ms are three periods
    np.testing.assert_allclose(LAG.to_control(rate=100)(z), held, rtol=1e-9)
    s = 1j * OMEGA
    late = 4.0 / (s + 4.0) * np.exp(-0.03 * s)
    np.testing.assert_allclose(LAG.to_control(pade_order=4)(s), late, rtol=1e-4)
    with pytest.raises(InputError, match="no form in continuous time"):
        LAG.to_control()


def test_a_model_comes_back():
    system = control.ss([[-4.0]], [[4.0]], [[1.0]], 0)
    model = LinearModel.from_control(system, offset=[0.2], delay_ns=30_000_000)
    for name in ("a", "b", "c", "offset"):
        np.testing.assert_array_equal(getattr(model, name), getattr(LAG, name))
    with pytest.raises(InputError, match="direct feedthrough"):
        LinearModel.from_control(control.ss([[-4.0]], [[4.0]], [[1.0]], 1))
    with pytest.raises(InputError, match="discrete-time"):
        LinearModel.from_control(control.ss([[0.5]], [[1.0]], [[1.0]], 0, 0.1))


def test_plants():
    system = control.ss([[0.0, 1.0], [-25.0, -4.0]], [[0.0], [25.0]], [[1.0, 0.0]], 0)
    again = StateSpace.from_control(system).to_control("y")
    np.testing.assert_allclose(again(1j * OMEGA), system(1j * OMEGA), rtol=1e-12)
    finger = Finger(recruitment_curve="linear", delay_ms=0.0)
    model = finger.linear_model()
    np.testing.assert_allclose(control.dcgain(finger.to_control("angles")),
                               -model.c @ np.linalg.solve(model.a, model.b) * 1e6 / finger.full_scale_us)


def test_a_pid_is_its_transfer_function():
    s = control.tf("s")
    given = [2.0 + 3.0 / s + 0.1 * s / (0.02 * s + 1.0), 1.5 + 0.5 / s]
    pid = Pid.from_control(given, mixing=((1.0, 0.0), (0.0, 1.0)), current_ma=(30.0, 30.0),
                           recruitment_curve="linear", full_scale_us=1e6)
    np.testing.assert_allclose((*pid.kp, *pid.ki, *pid.kd), (2.0, 1.5, 3.0, 0.5, 0.1, 0.0), atol=1e-12)
    assert pid.derivative_filter_ms == pytest.approx(20.0)
    # From the reference there is no derivative; at a high rate the rest is kp + ki / s.
    found = pid.to_control(rate=100_000)(np.exp(1j * OMEGA * 1e-5))
    np.testing.assert_allclose(found[0, 0], 2.0 + 3.0 / (1j * OMEGA), rtol=1e-3)
    np.testing.assert_allclose(found[1, 3], -(1.5 + 0.5 / (1j * OMEGA)), rtol=1e-3)
    with pytest.raises(InputError, match=r"controllers\[0\]: .*; allowed: kp \+ ki/s"):
        Pid.from_control([1.0 / (s + 1.0) ** 2], mixing=((1.0,),), current_ma=(30.0,))
    with pytest.raises(InputError, match="filter times"):
        Pid.from_control([s / (0.02 * s + 1.0), s / (0.03 * s + 1.0)], mixing=((1.0, 0.0),),
                         current_ma=(30.0,))


@pytest.mark.parametrize("feedforward", [True, False])
@pytest.mark.parametrize("rule", ["simc", "amigo"])
def test_a_tuned_pid_follows_its_law_between_its_limits(feedforward, rule):
    pid = TunedPid(model=LAG, current_ma=(30.0,), rule=rule, feedforward=feedforward, charge_max_uc=1e3,
                   width_max_us=1e4)
    clock = RateClock.from_rate(50)
    state, tick, drives = pid.init(Context("pid", clock=clock)), Tick(), []
    rise = 0.05 * (1.0 - np.exp(-np.arange(40) / 8.0))
    given = np.stack([rise, rise * 0.05])
    for k, (reference, measured) in enumerate(given.T):
        tick.index, tick.time_ns = k, clock.tick(k)
        samples = [Sample(np.array([0.2 + each]), *[tick.time_ns] * 3) for each in (reference, measured)]
        drives.append(pid.step(state, samples, tick)[0][0, 1] * 1e6 / pid.full_scale_us)
    assert 0.0 < min(drives[1:]) < max(drives) < 1.0
    found = control.forced_response(pid.to_control(rate=50), U=given).outputs
    np.testing.assert_allclose(np.ravel(found), drives, atol=1e-5)


def test_a_tracker_is_its_gain():
    tracker = IdealTracker(joints=2)
    np.testing.assert_array_equal(tracker.to_control(rate=100).D, np.eye(2))

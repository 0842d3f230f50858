"""Tests of plain figures and fits of courses: made-up courses whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from fesloop.analysis.people.courses import fit_course, fits_of, step_responses
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS
from fesloop.models.arm_responses import CHAIN_S, ArmResponses
from fesloop.streams.stimulation import TorqueCourse, open_stimulation
from plants.arm import Arm

PERIOD = 0.005
STEPS = (1.0, 7.0, 9.0, 11.0, 13.0)


def commanded(time, low=19.0, high=31.0):
    """Pulse width, us: a step, four trains, four ramps up and down."""
    for start, lasts in zip(STEPS, (1.0, 0.2, 0.2, 0.2, 0.2), strict=True):
        if start <= time < start + lasts:
            return high
    for start in (15.0, 21.0, 27.0, 33.0):
        if start <= time < start + 4.0:
            return low + (high - low) * (1.0 - abs(time - start - 2.0) / 2.0)
    return low


def course(width_us, torque, **changed):
    samples = len(width_us)
    return TorqueCourse(**{
        "name": "made up", "muscle": 0, "current_a": 0.065, "period_s": PERIOD,
        "pulse_width_s": 1e-6 * width_us,
        "reference_rad": np.zeros(4), "stiffness_nm_rad": np.full(4, np.nan),
        "angle_rad": np.zeros((samples, 4)), "device_torque_nm": -torque, **changed})


@settings(max_examples=30, deadline=None)
@given(delay=st.floats(0.15, 0.2), omega=st.floats(12.0, 40.0), size=st.sampled_from([-3.0, 1.0, 2.0]),
       joint=st.integers(0, 3), offset=st.floats(-1.0, 1.0))
def test_responses_are_those_of_a_known_second_order(delay, omega, size, joint, offset):
    time = np.arange(0.0, 16.5, PERIOD)
    width = np.array([commanded(t) for t in time])

    def risen(t):
        t = np.maximum(t, 0.0)
        return 1.0 - (1.0 + omega * t) * np.exp(-omega * t)

    torque = np.full((len(time), 4), offset)
    for start, lasts in zip(STEPS, (1.0, 0.2, 0.2, 0.2, 0.2), strict=True):
        torque[:, joint] += size * (risen(time - start - delay) - risen(time - start - lasts - delay))
    found = step_responses(course(width, torque))
    assert [each.step for each in found] == [True] + [False] * 4
    assert {each.joint for each in found} == {joint}
    at = {level: brentq(lambda t, level=level: risen(t) - level, 0.0, 2.0) for level in (0.05, 0.1, 0.9)}
    assert found[0].delay_s == pytest.approx(delay + at[0.05], abs=0.003)
    assert found[0].rise_s == pytest.approx(at[0.9] - at[0.1], abs=0.005)
    assert found[0].left == pytest.approx(0.0, abs=0.01)


def test_ramps_and_silence_have_no_step():
    time = np.arange(0.0, 38.0, PERIOD)
    width = np.array([commanded(t) if t > 14.5 else 19.0 for t in time])
    torque = np.repeat(0.2 * (width - 19.0)[:, np.newaxis], 4, axis=1)
    assert step_responses(course(width, torque)) == []
    assert step_responses(course(np.full(len(time), 20.0), torque)) == []


def simulated(arm, noise, rng):
    """Course of the protocol: widths reach the arm after the chain's mean delay."""
    state, now, rows = arm.init(Context("arm")), 0, []
    reference = np.deg2rad(arm.posture_deg)
    time = np.arange(0.0, 38.0, PERIOD)
    inputs = [np.zeros((1, 3)), reference]
    for k, t in enumerate(time):
        instant = k * 5 * NS_PER_MS
        arm.advance(state, inputs, now, instant)
        now = instant
        rows.append(arm.read(state, inputs)[1])
        if k % 5 == 0:
            width = commanded(t - (CHAIN_S - 0.0125))
            inputs = [np.array([[0.065, 1e-6 * width, 40.0]]), reference]
        else:
            inputs = [np.zeros((1, 3)), reference]
    torque = -np.array(rows) + noise * rng.normal(size=(len(time), 4))
    return course(np.array([commanded(t) for t in time]), torque)


@pytest.mark.slow
@pytest.mark.parametrize(("delay_ms", "omega", "spread", "highest"),
                         [(45.0, 18.0, 0.2, 0.5), (60.0, 26.0, 0.12, 1.2)])
def test_a_fit_finds_the_arm_that_made_the_course(delay_ms, omega, spread, highest):
    effective = 65.0 / (1.0 + 97.0 / 31.0)
    arm = Arm(electrodes=("biceps",), delay_ms=delay_ms, activation_rad_s=omega, spread=(spread,),
              threshold_ma=(effective * np.exp(-spread * highest),), chronaxie_us=(97.0,), highest=(0.7,),
              strength=3.0)
    fit = fit_course(simulated(arm, 0.005, np.random.default_rng(1)), 0, "made up", "biceps")
    assert fit.explained > 0.97
    assert fit.response.delay_s == pytest.approx(1e-3 * delay_ms, abs=0.012)
    assert fit.response.frequency_rad_s == pytest.approx(omega, rel=0.2)
    assert fit.response.spread == pytest.approx(spread, rel=0.35)
    assert fit.response.highest == pytest.approx(highest, abs=0.6)
    assert fit.friction_nm == pytest.approx(0.36, rel=0.3)


def test_a_course_without_a_clear_torque_has_no_fit():
    time = np.arange(0.0, 38.0, PERIOD)
    width = np.array([commanded(t) for t in time])
    silent = course(width, np.zeros((len(time), 4)))
    assert fit_course(silent, 0, "made up", "biceps") is None
    same = course(np.full(len(time), 20.0), np.ones((len(time), 4)))
    assert fit_course(same, 0, "made up", "biceps") is None


@pytest.mark.slow
def test_the_shipped_responses_are_those_of_the_recordings(recordings):
    """Of one person, as all seven take a minute."""
    person = open_stimulation(recordings / "fes_exo" / "S9007.npz")
    shipped = ArmResponses.shipped()
    expected = [each for each in shipped.estimates if each.response.person == "S9007"]
    found = fits_of(person)
    assert [fit.response.electrode for fit in found] == [each.response.electrode for each in expected]
    for fit, each in zip(found, expected, strict=True):
        assert fit.response[2:] == pytest.approx(each.response[2:], rel=0.02)


def test_courses_of_some_of_the_joints_are_fitted_there(recordings):
    person = open_stimulation(recordings / "fes_exo" / "S9004.npz")
    course = next(each for each in person.courses
                  if person.muscles[each.muscle] == "flexor carpi radialis")
    wrist = [person.joints.index("wrist_radial_deviation"), person.joints.index("wrist_flexion")]
    part = replace(course, angle_rad=course.angle_rad[:, wrist], reference_rad=course.reference_rad[wrist],
                   stiffness_nm_rad=course.stiffness_nm_rad[wrist],
                   device_torque_nm=course.device_torque_nm[:, wrist])
    (whole,), (found,) = (fits_of(each) for each in (
        replace(person, courses=(course,)),
        replace(person, joints=tuple(person.joints[j] for j in wrist), zero_rad=person.zero_rad[wrist],
                friction_nm=person.friction_nm[wrist], steady=None, movements=(), courses=(part,))))
    assert found.response == whole.response
    with pytest.raises(InputError, match="knee_flexion"):
        fits_of(replace(person, joints=("knee_flexion", *person.joints[1:]), courses=()))

"""Features of recordings of stimulated muscle: those of made-up trials and ramps whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stimulation_parts import trials

from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.features import (
    baselines,
    by_repeat,
    principal_joint,
    recruitment_curve,
    shown_joint,
)
from fesloop.streams.stimulation.recording import TorqueCourse

PERIOD = 0.005


def course(width_us, torque, **changed):
    """Course of two joints: torque of the muscle at the first is a function of pulse width, us, at once."""
    given = {
        "name": "ramps", "muscle": 0, "current_a": 0.05, "period_s": PERIOD, "pulse_width_s": 1e-6 * width_us,
        "reference_rad": np.zeros(2), "stiffness_nm_rad": np.full(2, np.nan),
        "angle_rad": np.zeros((len(width_us), 2)),
        "device_torque_nm": np.stack([0.7 - torque, np.full(len(width_us), -0.2)], axis=1)}
    return TorqueCourse(**{**given, **changed})


def protocol(low, high, ramps, whole):
    """A step, trains, and ramps up and down of 2 s, of whole microseconds or of any, us."""
    n = round(2.0 / PERIOD)
    up = np.linspace(low, high, n)
    rest, step = np.full(200, float(low)), np.full(100, float(high))
    parts = [rest, step, rest, step[:40], rest]
    for _ in range(ramps):
        parts += [up, up[::-1], rest]
    width = np.concatenate(parts)
    return np.floor(width + 1e-9) if whole else width


@given(low=st.integers(0, 20), span=st.integers(5, 40), ramps=st.integers(1, 4), whole=st.booleans(),
       half=st.floats(0.3, 0.7), steep=st.floats(1.0, 10.0))
@settings(max_examples=40, deadline=None)
def test_ramps_give_the_recruitment_that_made_them(low, span, ramps, whole, half, steep):
    def torque(us):
        return 2.0 / (1.0 + np.exp(-steep * ((us - low) / span - half)))

    width = protocol(low, low + span, ramps, whole)
    curve = recruitment_curve(course(width, torque(width)))
    assert curve.ramps == ramps
    assert curve.principal_joint == 0
    assert len(curve.width_s) == (span + 1 if whole and span < 20 else 20)
    expected = torque(1e6 * curve.width_s) - torque(np.array(float(low)))
    # a level's torque is the mean over its bin: exact for whole widths that each have a level of their own
    allowed = 1e-9 if whole and span < 20 else 2.0 * steep / 4.0 / 19.0
    for found in (curve.up_nm, curve.down_nm):
        known = np.isfinite(found[:, 0])
        assert known.sum() >= len(known) - 2
        np.testing.assert_allclose(found[known, 0], expected[known], atol=allowed)
        np.testing.assert_allclose(found[known, 1], 0.0, atol=1e-12)


@pytest.mark.parametrize("width", [np.full(500, 20.0), np.repeat([10.0, 30.0, 10.0, 30.0, 10.0], 100),
                                   np.linspace(30.0, 10.0, 500)])
def test_courses_without_a_rising_ramp_have_no_curve(width):
    assert recruitment_curve(course(width, 0.1 * width)) is None


def test_four_ramps_are_found_in_the_published_recordings(recordings):
    for person, count in (("S9004", 2), ("S9006", 8)):
        curves = [recruitment_curve(each)
                  for each in open_stimulation(recordings / "fes_exo" / f"{person}.npz").courses]
        assert [curve.ramps for curve in curves] == [4] * count


def session(strength, growth, noise, seed=1):
    """Trials of two muscles, one at each of two joints, over six visits of two postures."""
    rng = np.random.default_rng(seed)
    made = trials(rng, visits=6, baseline="passive")
    evoked = np.zeros((len(made), 2))
    for muscle in (0, 1):
        here = made.muscle == muscle
        evoked[here, muscle] = strength[muscle] * (1.0 + growth * made.repeat[here])
    rest = np.array([0.5, -0.1]) + 0.02 * made.visit[:, None]
    return replace(made, device_torque_nm=rest - evoked + rng.normal(0.0, noise, evoked.shape))


def test_growth_by_repeat_and_drift_of_the_baseline_are_found():
    made = session((1.0, -0.3), 0.5, 1e-3)
    for muscle, strength in enumerate((1.0, -0.3)):
        found = by_repeat(made, muscle)
        assert (found.joint, found.clear) == (muscle, True)
        np.testing.assert_allclose(found.mean_nm, strength * np.array([1.0, 1.5, 2.0]), atol=0.01)
    rest = baselines(made)
    np.testing.assert_array_equal(rest.visit, np.arange(6))
    still = baselines(session((0.0, 0.0), 0.0, 0.0))
    expected = 0.02 * np.array([-2.0, -2.0, 0.0, 0.0, 2.0, 2.0])
    np.testing.assert_allclose(still.change_nm, np.stack([expected, expected], axis=1), atol=1e-12)


def test_a_muscle_without_torque_is_not_clear():
    made = session((1.0, 0.0), 0.0, 0.1)
    assert by_repeat(made, 0).clear
    assert not by_repeat(made, 1).clear
    assert principal_joint(made, 0) == 0


def test_a_ramp_is_shown_at_the_joint_that_the_muscle_moves_in_isometric_trials(recordings):
    """Friction hides the elbow in the ramps of this biceps, and its hold on the device moves the wrist."""
    person = open_stimulation(recordings / "fes_exo" / "S9007.npz")
    course = next(each for each in person.courses if person.muscles[each.muscle] == "biceps")
    curve = recruitment_curve(course)
    assert person.joints[curve.principal_joint] == "wrist_radial_deviation"
    assert person.joints[shown_joint(person, course, curve)] == "elbow_flexion"
    assert shown_joint(replace(person, steady=None), course, curve) == curve.principal_joint

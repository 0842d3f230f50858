"""A muscle with a tendon that yields: against an adaptive integrator, and limits that physiology knows."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fesloop.errors import InputError
from fesloop.models.hill_muscle import (
    HillMuscle,
    excess,
    force_length,
    force_velocity,
    passive_force,
    stage_rate,
)

STEP_S = 1e-3
MUSCLES = st.builds(
    HillMuscle, force_n=st.floats(1.0, 500.0), fibre_mm=st.floats(8.0, 120.0),
    slack_mm=st.floats(20.0, 300.0), strain=st.floats(0.02, 0.15), fastest=st.floats(4.0, 15.0),
    passive=st.floats(0.0, 1.0), calcium_ms=st.floats(15.0, 100.0), half=st.floats(0.2, 1.0),
    sensitivity=st.floats(0.0, 3.0))


def active(x):
    return sum(h * math.exp(-0.5 * (x - c) ** 2 / (w + g * x) ** 2) for h, c, w, g in (
        (0.815, 1.055, 0.162, 0.063), (0.433, 0.717, -0.03, 0.2), (0.1, 1.0, 0.354, 0.0)))


def spring(x):
    return (math.exp(4.0 * (x - 1.0) / 0.6) - 1.0) / (math.exp(4.0) - 1.0) if x > 1.0 else 0.0


def exact(muscle, times, lengths, drive):
    """Force (n,) by equations written anew, their velocity by Brent's method, and an adaptive integrator."""
    tendon = 1e-3 * muscle.slack_mm

    def pull(whole, x):
        strain = (whole - 1e-3 * muscle.fibre_mm * x - tendon) / tendon
        return (max(strain, 0.0) / muscle.strain) ** 2

    def lacking(v, x, c, whole):
        state = 0.0
        if c > 0.0:
            state = (1.0 + muscle.half**3) * c**3 / (
                c**3 + (muscle.half * math.exp(-muscle.sensitivity * (x - 1.0))) ** 3)
        speed = -0.318 * math.log((-8.149 * v - 0.374) + math.sqrt((-8.149 * v - 0.374) ** 2 + 1.0)) + 0.886
        return pull(whole, x) - state * active(x) * speed - muscle.passive * spring(x) - muscle.damping * v

    slack = (lengths[0] - tendon) / (1e-3 * muscle.fibre_mm)
    low = min(slack, 1.0)
    start = brentq(lambda x: pull(lengths[0], x) - muscle.passive * spring(x), low, slack,
                   xtol=1e-13) if slack > 1.0 + 1e-9 and muscle.passive > 1e-9 else slack
    forces, state = [pull(lengths[0], start)], np.array([start, 0.0])
    kinks = np.flatnonzero((np.abs(np.diff(lengths, 2, prepend=lengths[0], append=0.0)) > 1e-12)
                           | (np.diff(drive, prepend=-1.0) != 0.0))
    kinks = np.unique([0, *kinks, len(times) - 1])
    for a, b in pairwise(kinks):
        def slope(t, y, a=a, b=b):
            whole = np.interp(t, times[[a, b]], lengths[[a, b]])
            return [muscle.fastest * brentq(lacking, -1e3, 1e3, (y[0], y[1], whole), xtol=1e-13),
                    (drive[a] - y[1]) / (1e-3 * muscle.calcium_ms)]

        found = solve_ivp(slope, times[[a, b]], state, "LSODA", t_eval=times[a + 1:b + 1], rtol=1e-9,
                          atol=1e-10)
        forces += [pull(whole, x) for whole, x in zip(lengths[a + 1:b + 1], found.y[0], strict=True)]
        state = found.y[:, -1]
    return muscle.force_n * np.array(forces)


@st.composite
def experiments(draw):
    """A muscle and 120 ms of it: three ramps below the fastest shortening; drive that switches twice."""
    muscle = draw(MUSCLES)
    least = max(muscle.slack_mm, 0.1 * muscle.fibre_mm / muscle.strain)
    muscle = replace(muscle, slack_mm=least)
    times = STEP_S * np.arange(121)
    on = draw(st.integers(0, 60))
    off = draw(st.integers(on + 1, 120))
    drive = np.where((np.arange(121) >= on) & (np.arange(121) < off), draw(st.floats(0.05, 1.0)), 0.0)
    places = [0, *sorted(draw(st.lists(st.integers(5, 115), min_size=2, max_size=2, unique=True))), 120]
    fibres = [draw(st.floats(0.8, 1.3))]
    for a, b in pairwise(places):
        furthest = min(0.5, muscle.fastest * STEP_S * (b - a))
        fibres.append(float(np.clip(fibres[-1] + draw(st.floats(-1.0, 1.0)) * furthest, 0.6, 1.5)))
    lengths = 1e-3 * (muscle.slack_mm + muscle.fibre_mm * np.interp(np.arange(121), places, fibres))
    return muscle, times, lengths, drive


@settings(max_examples=12)
@given(experiments())
def test_a_step_of_a_millisecond_is_within_the_stated_error_of_an_adaptive_integrator(experiment):
    muscle, times, lengths, drive = experiment
    error = (muscle.force(lengths, drive, STEP_S) - exact(muscle, times, lengths, drive)) / muscle.force_n
    assert np.abs(error).max() < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.001


def test_the_error_falls_with_the_square_of_the_step():
    muscle = HillMuscle()
    times = STEP_S * np.arange(301)
    lengths = 0.0445 + 0.002 * np.sin(2.0 * np.pi * 4.0 * times)
    drive = ((times > 0.05) & (times < 0.2)).astype(float)
    truth = muscle.force(lengths, drive, STEP_S, parts=256)
    errors = [np.sqrt(np.mean((muscle.force(lengths, drive, STEP_S, parts=parts) - truth) ** 2))
              for parts in (1, 2, 4)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.15)


@given(st.floats(0.0, 2.0), st.floats(-1.5, 1.5))
def test_slopes_are_those_of_the_curves(length, velocity):
    for curve, at, kinks in ((force_length, length, (0.0, 0.3)), (passive_force, length, (1.0,)),
                             (force_velocity, velocity, ())):
        if all(abs(at - kink) > 1e-5 for kink in kinks):
            slope = (curve(at + 1e-6)[0] - curve(at - 1e-6)[0]) / 2e-6
            assert curve(at)[1] == pytest.approx(slope, rel=1e-4, abs=1e-6)


STATES = {"muscle": MUSCLES, "start": st.floats(0.4, 1.8), "fibre": st.floats(0.4, 1.8),
          "calcium": st.floats(0.0, 1.0)}


def whole_of(muscle, fibre):
    return 1e-3 * (muscle.slack_mm + muscle.fibre_mm * fibre)


@given(**STATES, guess=st.floats(-1e4, 1e4))
@settings(max_examples=200)
def test_a_stage_ends_in_equilibrium_whatever_its_guess(muscle, start, fibre, calcium, guess):
    step = (start, 0.3 * STEP_S, whole_of(muscle, fibre), calcium, muscle.coefficients)
    rate = stage_rate(guess, *step)
    value, slope = excess(rate, *step)
    assert abs(value) <= 1e-9 * max(1.0, abs(slope * rate))


@given(**STATES, rate=st.floats(-100.0, 100.0))
def test_the_slope_of_a_stage_is_that_of_its_excess(muscle, start, fibre, calcium, rate):
    """The tolerance covers the kink where passive force begins."""
    step = (start, 0.3 * STEP_S, whole_of(muscle, fibre), calcium, muscle.coefficients)
    low, high = excess(rate - 1e-3, *step)[0], excess(rate + 1e-3, *step)[0]
    slope = excess(rate, *step)[1]
    assert (high - low) / 2e-3 == pytest.approx(slope, rel=1e-3, abs=1e-4)


@given(MUSCLES)
@settings(max_examples=30)
def test_full_drive_at_the_optimal_length_gives_the_largest_isometric_force(muscle):
    """At that length the fibres are optimal under `force_n`; the curves' values there are 1 within .003.

    A tendon that yields by more has a second equilibrium with long fibres, where the muscle starts.
    """
    muscle = replace(muscle, slack_mm=min(muscle.slack_mm, 0.3 * muscle.fibre_mm / muscle.strain))
    whole = 1e-3 * (muscle.slack_mm * (1.0 + muscle.strain) + muscle.fibre_mm)
    force = muscle.force(np.full(3000, whole), np.ones(3000), STEP_S)
    assert force[-1] == pytest.approx(muscle.force_n, rel=0.01)


@given(MUSCLES, st.floats(0.5, 1.6))
@settings(max_examples=30)
def test_a_muscle_without_drive_rests(muscle, fibre):
    lengths = np.full(200, 1e-3 * (muscle.slack_mm + muscle.fibre_mm * fibre))
    force = muscle.force(lengths, np.zeros(200), STEP_S)
    np.testing.assert_allclose(force, force[0], atol=1e-9 * muscle.force_n)
    assert force[0] <= muscle.force_n * muscle.passive * max(spring(fibre), 0.0) + 1e-9


@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(0.0, 1.0)), min_size=2, max_size=40), MUSCLES)
@settings(max_examples=50)
def test_force_stays_finite_and_pulls_whatever_the_course(course, muscle):
    """Jumps of length in one step, and muscles shorter than their tendon, included."""
    jumps, drive = np.array(course).T
    lengths = 1e-3 * (muscle.slack_mm + muscle.fibre_mm * (0.5 + jumps + 0.5 * np.abs(jumps)))
    force = muscle.force(lengths, drive, STEP_S)
    assert np.isfinite(force).all()
    assert (force >= 0.0).all()


def test_a_long_muscle_is_more_sensitive_to_calcium():
    """The optimum of a twitch lies at longer lengths than that of a tetanus (Rack and Westbury 1969)."""
    fibres = np.linspace(0.7, 1.4, 36)
    best = {}
    for name, pulse_s in (("twitch", 0.01), ("tetanus", 0.4)):
        forces = []
        for fibre in fibres:
            lengths = np.full(500, 1e-3 * (29.0 + 14.0 * fibre))
            drive = (np.arange(500) * STEP_S < pulse_s).astype(float)
            muscle = HillMuscle(passive=0.0)
            forces.append(muscle.force(lengths, drive, STEP_S).max())
        best[name] = fibres[int(np.argmax(forces))]
    assert best["twitch"] > best["tetanus"] + 0.03


@pytest.mark.parametrize(("change", "named"), [
    ({"force_n": 0.0}, "muscle.force_n"), ({"strain": -0.1}, "muscle.strain"),
    ({"passive": math.nan}, "muscle.passive"), ({"half": math.inf}, "muscle.half")])
def test_a_bad_parameter_is_named(change, named):
    with pytest.raises(InputError, match=named):
        HillMuscle(**change)


@pytest.mark.parametrize(("lengths", "drive"), [
    ([0.04, 0.04], [0.0]), ([0.04, math.nan], [0.0, 0.0]), ([0.04, 0.04], [0.0, 1.1]),
    ([0.04, 0.04], [math.nan, 0.0]), ([], [])])
def test_bad_courses_are_refused(lengths, drive):
    with pytest.raises(InputError):
        HillMuscle().force(np.array(lengths), np.array(drive), STEP_S)

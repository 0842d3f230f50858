"""Fatigue: against an adaptive integrator, and as the finger carries it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fesloop.errors import InputError
from fesloop.loop.block import Context
from plants.finger import Finger
from plants.muscles.lags import Fatigue


@given(start=st.floats(0.2, 1.0), recruited=st.floats(0.0, 1.0), duration_s=st.floats(0.0, 60.0))
@settings(max_examples=30, deadline=None)
def test_fitness_solves_its_equation(start: float, recruited: float, duration_s: float) -> None:
    fatigue = Fatigue()
    effort = recruited * (1 - 0.6 + 0.6 * 0.4**2)

    def slope(_, mu):
        return (0.2 - mu) * effort / 24.0 + (1 - mu) * (1 - effort) / 45.0

    expected = solve_ivp(slope, (0.0, duration_s), [start], "DOP853", rtol=1e-11, atol=1e-12).y[0, -1]
    found = fatigue.after(np.array([start]), np.array([recruited]), duration_s)
    assert found[0] == pytest.approx(expected, abs=1e-9)


def test_a_worked_finger_weakens_and_carries_it_to_the_next_trial() -> None:
    context = Context("finger")
    fatigue = Fatigue(rest_between_trials_s=0.0, fatigue_s=18.0)
    finger = Finger(fatigue=fatigue, delay_ms=0.0)
    state, pulses = finger.init(context), [np.tile([0.05, 4e-4], (4, 1))]
    finger.advance(state, pulses, 0, 20_000_000_001)
    expected = fatigue.after(np.ones(4), finger.recruited(pulses[0]), 20.0)
    np.testing.assert_allclose(state.fitness, expected, rtol=1e-12)
    activation = finger.read(state, pulses)[3]
    np.testing.assert_allclose(activation, expected * finger.recruited(pulses[0]), rtol=0.01)
    again = finger.next_trial(state, Context("finger", trial=1))
    np.testing.assert_array_equal(again.fitness, state.fitness)
    assert not again.z.any()
    rested = Finger(fatigue=Fatigue(rest_between_trials_s=600.0)).next_trial(state, context)
    np.testing.assert_allclose(rested.fitness, 1.0, atol=1e-5)
    assert (Finger().next_trial(state, context).fitness == 1.0).all()


@given(start=st.floats(0.2, 1.0), share=st.floats(-3.0, 4.0), duration_s=st.floats(0.0, 600.0))
@settings(max_examples=50, deadline=None)
def test_a_muscle_works_no_harder_than_with_all_its_fibres_and_no_less_than_at_rest(
    start: float, share: float, duration_s: float
) -> None:
    """A linear recruitment curve has no end: pulses beyond full scale, or below 0, tire like those at it."""
    finger = Finger(fatigue=Fatigue(), recruitment_curve="linear", full_scale_us=500.0, delay_ms=0.0)
    fitness = []
    for width in (share, min(max(share, 0.0), 1.0)):
        recruited = finger.recruited(np.tile([0.05, 500e-6 * width], (4, 1)))
        fitness.append(finger.fatigue.after(np.full(4, start), recruited, duration_s))
    np.testing.assert_allclose(*fitness, rtol=1e-12)
    assert (fitness[0] >= 0.2 * (1.0 - 1e-12)).all()
    assert (fitness[0] <= 1.0 + 1e-12).all()


@pytest.mark.parametrize("change", [{"floor": 1.5}, {"fatigue_s": 0.0}, {"recovery_s": -1.0},
                                    {"frequency_hz": 120.0}, {"rest_between_trials_s": -1.0}])
def test_bad_parameters_are_named(change: dict) -> None:
    with pytest.raises(InputError, match=rf"fatigue\.{next(iter(change))}"):
        Fatigue(**change)

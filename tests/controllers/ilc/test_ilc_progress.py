"""Learning that makes trials worse stops, and returns to the best trial."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.ilc import Ilc
from controllers.progress import Progress
from controllers.trajectories import response
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger

CONTEXT = Context("ilc", clock=RateClock.from_rate("40"))
PERIOD = 25_000_000
MODEL = Finger().linear_model()
SAMPLES = 81


def trial_errors(ilc, plant, trials, noise_deg=0.0, seed=0):
    """RMS error of each trial, deg, and the reports, on a linear plant that is measured at each tick."""
    sampled, rng = plant.sampled(PERIOD), np.random.default_rng(seed)
    rise = np.clip(np.arange(SAMPLES) / 40.0 - 0.5, 0.0, 1.0)[:, None]
    reference = MODEL.offset + np.radians([15.0, 20.0, 8.0]) * rise
    state, errors, reports = ilc.init(CONTEXT), [], []
    for _ in range(trials):
        reports += state.pending
        angles = response(sampled, state.drives) + plant.offset
        angles += np.radians(noise_deg) * rng.normal(size=angles.shape)
        for k in range(SAMPLES):
            state.seen.ticks_ns[k] = k * PERIOD
            state.seen.reference[k] = reference[k]
            state.seen.note(k, k * PERIOD, angles[k], np.zeros(3, dtype=bool))
        errors.append(math.degrees(math.sqrt(np.mean((reference - angles) ** 2))))
        state = ilc.next_trial(state, CONTEXT)
    return np.array(errors), reports


def learner(**changes):
    return Ilc(**{"model": replace(MODEL, recruitment=None), "current_ma": (40.0,) * 4, "duration_s": 2.0,
                  "law": "noilc", "change_weight": 0.001, **changes})


def mismatched(rng):
    """A plant with another strength and sign of each muscle, another speed and delay than the model."""
    strengths = np.exp(rng.normal(0.0, 0.7, 4)) * np.where(rng.uniform(size=4) < 0.25, -1.0, 1.0)
    speed = math.exp(rng.normal(0.0, 0.5))
    return LinearModel(a=speed * MODEL.a, b=speed * MODEL.b * strengths, c=MODEL.c, offset=MODEL.offset,
                       delay_ns=round(rng.uniform(0.0, 200.0)) * 1_000_000)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=30)
def test_divergence_is_never_carried_past_two_trials(seed):
    errors, reports = trial_errors(learner(), mismatched(np.random.default_rng(seed)), 9)
    stopped = [status for status, _ in reports].count("learning_stopped")
    assert stopped <= 1
    least = [math.inf, *np.minimum.accumulate(errors)[:-1]]
    worse = [k for k in range(1, 9)
             if errors[k] > (1.0 + 1e-9) * min(2.0 * least[k], max(1.5 * least[k], errors[k - 1]))]
    assert not any(k + 1 in worse and k + 2 in worse for k in worse)
    if stopped:
        assert errors[-1] <= errors.min() * (1.0 + 1e-6)


@pytest.mark.slow
def test_two_hundred_mismatches():
    lost = saved = 0
    for seed in range(200):
        plant = mismatched(np.random.default_rng(seed))
        errors, _ = trial_errors(learner(), plant, 9)
        without, _ = trial_errors(learner(stop_after=0), plant, 9)
        diverged = without[-1] > 2.0 * without.min()
        saved += diverged
        lost += errors[-1] > 2.0 * errors.min()
        if not diverged:
            np.testing.assert_array_equal(errors[:2], without[:2])
    print(f"of 200 plants learning makes {saved} worse, and {lost} with the stop")
    assert saved > 20
    assert lost <= 0.1 * saved


def test_a_plant_of_the_other_sign_ends_as_it_began():
    wrong = replace(MODEL, b=-MODEL.b, recruitment=None)
    errors, reports = trial_errors(learner(), wrong, 6)
    assert errors[3] == pytest.approx(errors[0])
    assert (errors[3:] == errors[3]).all()
    (detail,) = (detail for status, detail in reports if status == "learning_stopped")
    assert detail.endswith(f"the one with {errors[0]:.2g} deg are used")
    without, reports = trial_errors(learner(stop_after=0), wrong, 6)
    assert without[-1] > 2.0 * errors[-1]
    assert "learning_stopped" not in dict(reports)


def test_noise_does_not_stop_learning():
    for seed in range(20):
        _, reports = trial_errors(learner(), MODEL, 12, noise_deg=1.0, seed=seed)
        assert "learning_stopped" not in dict(reports)


@given(st.lists(st.floats(0.01, 10.0), min_size=1, max_size=30))
@settings(deadline=None)
def test_the_best_drives_are_those_of_the_least_error(errors):
    progress = Progress()
    for k, error in enumerate(errors):
        progress.note(error, np.full((1, 1), float(k)), 0, "drives")
    assert not progress.stopped
    assert progress.best[0, 0] == float(np.argmin(errors))


@pytest.mark.parametrize(("errors", "stops"), [
    ((1.0, 2.5, 2.4), True), ((1.0, 1.6, 1.7), True), ((1.0, 1.6, 1.55, 1.6), False),
    ((1.0, 1.4, 1.45), False), ((1.0, 2.5, 1.2, 2.5), False)])
def test_two_worse_trials_in_a_row_stop_learning(errors, stops):
    progress = Progress()
    reports = [progress.note(error, np.zeros((1, 1)), 2, "drives") for error in errors]
    assert bool(reports[-1]) == progress.stopped == stops
    assert not any(reports[:-1])


def test_a_state_may_begin_more_than_one_next_trial():
    ilc = learner()
    state = ilc.init(CONTEXT)
    for k in range(SAMPLES):
        state.seen.ticks_ns[k] = k * PERIOD
        state.seen.note(k, k * PERIOD, np.ones(3), np.zeros(3, dtype=bool))
    first, second = (ilc.next_trial(state, CONTEXT) for _ in range(2))
    np.testing.assert_array_equal(first.drives, second.drives)
    assert len(first.progress.errors) == len(second.progress.errors) == 1
    assert not state.progress.errors


def test_a_negative_number_of_trials_is_refused():
    with pytest.raises(InputError, match="stop_after: -1"):
        learner(stop_after=-1)

"""Strength of stimulated muscle from trial to trial: by seed and trial, mean 1, spread and correlation."""

import math

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st
from muscle_parts import COUNT, MODELS, MS, given, simulate, tiring
from scipy.stats import kstest

import fesloop
from fesloop.errors import InputError
from fesloop.loop.block import Context
from plants.muscles import Muscles
from plants.muscles.variation import Variation
from plants.patients.files import load, names

SDS = {"trial": 0.1, "muscle_trial": 0.2, "drift": 0.15, "muscle_drift": 0.25}
SEEDS = range(300)
numbers = st.integers(0, 2**31)
sds = st.floats(0.0, 1.0)
variations = st.builds(Variation, trial=sds, muscle_trial=st.floats(0.01, 1.0), drift=sds, muscle_drift=sds,
                       drift_s=st.floats(1.0, 1e4), scale=st.floats(0.01, 4.0))


def context(seed=3, trial=0):
    return Context("muscles", seed=seed, trial=trial)


def factors_of(variation, seed=3, trials=1, trial_s=20.0):
    """Factors of each trial (trials, muscles), of muscles that rest between trials of `trial_s`."""
    muscles = Muscles(variation=variation, rest_between_trials_s=trial_s - 5.0)
    state, found = muscles.init(context(seed)), []
    for trial in range(trials):
        if trial:
            muscles.advance(state, given(), 0, 5_000 * MS)
            state = muscles.next_trial(state, context(seed, trial))
        found.append(state.factors)
    return np.array(found)


@drawn(variation=variations, seed=numbers, trials=st.integers(2, 5))
@settings(deadline=None, max_examples=40)
def test_factors_follow_from_seed_and_trial(variation, seed, trials):
    found = factors_of(variation, seed, trials)
    np.testing.assert_array_equal(found, factors_of(variation, seed, trials))
    assert (found > 0.0).all()
    assert np.isfinite(found).all()
    for other in (factors_of(variation, seed + 1, trials), np.roll(found, 1, axis=0)):
        assert (found != other).any(axis=1).all()


def test_factors_have_mean_one_and_the_stated_spread_and_are_shared_as_stated():
    """Each trial of a session, so that the process is stationary."""
    variation = Variation(**SDS, drift_s=30.0)
    found = np.array([factors_of(variation, seed, trials=4) for seed in SEEDS])
    logs = np.log(found) + 0.5 * variation.spread**2
    shared = math.hypot(SDS["trial"], SDS["drift"]) ** 2 / variation.spread**2
    for trial in (0, 1, 3):
        np.testing.assert_allclose(found[:, trial].mean(), 1.0, atol=0.05)
        assert kstest(logs[:, trial, 7] / variation.spread, "norm").pvalue > 0.01
        assert np.corrcoef(logs[:, trial, :2].T)[0, 1] == pytest.approx(shared, abs=0.15)
    np.testing.assert_allclose(logs.std(), math.hypot(*SDS.values()), rtol=0.05)


@pytest.mark.parametrize("drift_s", [10.0, 60.0, 1e6])
def test_the_slow_part_is_remembered_for_its_time(drift_s):
    """Trials of 20 s, of which 5 are worked."""
    slow = Variation(muscle_drift=0.3, drift_s=drift_s)
    logs = np.log(np.array([factors_of(slow, seed, trials=4) for seed in SEEDS]))
    for lag in (1, 3):
        found = np.corrcoef(logs[:, 0].ravel(), logs[:, lag].ravel())[0, 1]
        assert found == pytest.approx(math.exp(-20.0 * lag / drift_s), abs=0.04)
    quick = np.log(np.array([factors_of(Variation(muscle_trial=0.3), seed, trials=2) for seed in SEEDS]))
    assert np.corrcoef(quick[:, 0].ravel(), quick[:, 1].ravel())[0, 1] == pytest.approx(0.0, abs=0.04)


@pytest.mark.parametrize("model", MODELS)
def test_factors_multiply_what_stimulation_activates_up_to_all_of_it(model):
    plain, varied = (tiring(model, **more) for more in ({}, {"variation": Variation(muscle_trial=0.5)}))
    factors = varied.init(context()).factors
    for recruited in (0.2, 1.0):
        schedule, stops = {0: given(recruited, 50.0)}, [100 * MS, 400 * MS]
        without, found = (simulate(each, schedule, stops) for each in (plain, varied))
        fitness = np.ones(COUNT) if model == "ding2003" else without[:, 1]
        fresh = np.minimum(factors * without[:, 0] / fitness, 1.0)
        np.testing.assert_allclose(found[:, 0], fresh * fitness, rtol=1e-12)
        np.testing.assert_array_equal(found[:, 1], without[:, 1])
    assert (factors * without[-1, 0] > 1.0).any()
    effort = {0: given(0.0, 0.0, 0.0, 0.4)}
    np.testing.assert_array_equal(*(simulate(each, effort, [300 * MS]) for each in (plain, varied)))


@pytest.mark.parametrize("model", MODELS)
def test_without_variation_no_bit_changes(model):
    schedule = {0: given(0.3, 40.0), 55 * MS: given(0.6, 40.0, 0.0, 0.2)}
    off = [tiring(model, variation=variation) for variation in (Variation(), Variation(**SDS, scale=0.0))]
    plain = simulate(tiring(model), schedule, [50 * MS, 200 * MS])
    for muscles in off:
        assert (muscles.init(context()).factors == 1.0).all()
        np.testing.assert_array_equal(simulate(muscles, schedule, [50 * MS, 200 * MS]), plain)


@pytest.mark.parametrize(("change", "named"), [
    ({"trial": -0.1}, r"variation\.trial"), ({"muscle_drift": 1.5}, r"variation\.muscle_drift"),
    ({"drift_s": 0.0}, r"variation\.drift_s"), ({"scale": math.nan}, r"variation\.scale")])
def test_bad_variations_are_named(change, named):
    with pytest.raises(InputError, match=named):
        Variation(**change)


@pytest.mark.parametrize("name", names())
def test_every_preset_varies_as_people_do(name):
    """Three repeats within 26 to 48 min, as in the recordings: sd over mean of the muscle's part, by person,
    and third over first repeat of six muscles."""
    variation = load(name).muscles()["variation"]
    found = np.array([factors_of(variation, seed, trials=3, trial_s=720.0) for seed in SEEDS])
    cv = found.std(axis=1, ddof=1).mean() / found.mean()
    assert 0.2 < cv < 0.43
    ratio = np.exp(np.mean(np.log(found[:, 2] / found[:, 0])[:, :6], axis=1))
    assert np.quantile(ratio, 0.05) > 0.6
    assert np.quantile(ratio, 0.95) < 1.7
    assert np.quantile(ratio, 0.9) > 1.1


@pytest.mark.parametrize("trial", [0, 3])
def test_trials_of_another_session_are_other_ones_with_the_same_seed(trial):
    variation = Variation(trial=0.1, muscle_trial=0.2, drift=0.1, muscle_drift=0.2)
    first, again, other = (Muscles(variation=variation, session=session).init(Context("muscles", 3, trial))
                           for session in (0, 0, 1))
    assert np.array_equal(first.factors, again.factors)
    assert not np.isclose(first.factors, other.factors).any()
    assert not np.isclose(first.slow, other.slow).any()


@pytest.mark.parametrize("name", ["sweep_grasp", "identify_grasp", "identify_key"])
def test_what_is_identified_is_of_another_trial_than_the_grasps(name):
    found, grasp = (fesloop.load(each) for each in (name, "grasp_mpc"))
    sessions = [each.wiring.node("muscles").part.session for each in (found, grasp)]
    assert (found.seed, sessions[0]) != (grasp.seed, sessions[1])


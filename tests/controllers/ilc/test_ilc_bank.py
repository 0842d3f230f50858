from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ilc_parts import MODEL, scalar

from controllers.ilc import Ilc
from controllers.trajectories import mixed, rescaled, response, shares_of
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.signals import NEVER
from fesloop.models.linear_model import Recruitment
from plants.finger import Finger

MODELS = [scalar(0.5, 1.0), scalar(0.9, 0.3), scalar(0.2, 2.0)]
DRIVES = np.random.default_rng(0).uniform(0.0, 1.0, (40, 1))
EVERYWHERE = np.ones((40, 1), dtype=bool)


@pytest.mark.parametrize("rule", ["best", "mixture"])
@pytest.mark.parametrize("which", range(3))
def test_the_true_model_is_found_whatever_the_offset(rule, which):
    posture = 3.0 + response(MODELS[which], DRIVES)
    shares, miss = shares_of(MODELS, [DRIVES] * 3, posture, EVERYWHERE, rule)
    np.testing.assert_allclose(shares, np.eye(3)[which], atol=1e-6)
    assert miss[which] == pytest.approx(0.0, abs=1e-12)
    assert mixed(MODELS, np.eye(3)[which]) is MODELS[which]


def test_a_mixture_is_found_again_and_responds_as_one():
    wanted = np.array([0.25, 0.0, 0.75])
    posture = sum(share * response(model, DRIVES) for share, model in zip(wanted, MODELS, strict=True))
    shares, _ = shares_of(MODELS, [DRIVES] * 3, posture, EVERYWHERE, "mixture")
    np.testing.assert_allclose(shares, wanted, atol=1e-6)
    np.testing.assert_allclose(response(mixed(MODELS, shares), DRIVES), posture, atol=1e-6)


def test_what_was_not_covered_does_not_count():
    posture, covered = response(MODELS[1], DRIVES), EVERYWHERE.copy()
    posture[25:], covered[25:] = 99.0, False
    assert shares_of(MODELS, [DRIVES] * 3, posture, covered, "best")[0][1] == 1.0


@pytest.mark.parametrize("rule", ["best", "mixture"])
def test_a_trial_at_rest_says_nothing_and_the_first_model_stays(rule):
    rest = np.zeros((40, 3))
    twin = [MODEL, MODEL]
    shares, _ = shares_of(twin, [rest] * 2, np.ones((40, 2)), np.ones((40, 2), dtype=bool), rule)
    np.testing.assert_array_equal(shares, [1.0, 0.0])


@given(st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3))
def test_a_model_in_proportional_drives_responds_alike(factors):
    drives = np.random.default_rng(1).uniform(0.0, 1.0, (40, 3))
    own = drives * np.array(factors)
    alike = response(rescaled(MODEL, own, drives), drives)
    np.testing.assert_allclose(alike, response(MODEL, own), atol=1e-9)


CONTEXT = Context("ilc", clock=RateClock.from_rate("40"))
NOMINAL = Finger().linear_model()


def person(factor, strength=1.0):
    """A finger of some strength, whose muscles have `factor` times the nominal thresholds."""
    curve = NOMINAL.recruitment
    return replace(NOMINAL, b=strength * NOMINAL.b, recruitment=Recruitment(
        threshold_ma=tuple(factor * each for each in curve.threshold_ma), spread=curve.spread,
        chronaxie_us=curve.chronaxie_us))


def responded(true, pulses):
    """Posture (samples, outputs) of a plant that is the model `true`, under pulses."""
    recruited = np.array([true.recruitment.fraction(each) for each in pulses])
    return true.offset + response(true.sampled(25 * NS_PER_MS), recruited)


def after_a_trial(ilc, true, goal):
    """State before the second trial, after one of a plant that is the model `true`, with reference `goal`."""
    state = ilc.init(CONTEXT)
    return after(ilc, state, responded(true, state.pulses), goal)


def after(ilc, state, measured, goal):
    """State of the trial after one with these measurements and this reference."""
    state.seen.measured[:], state.seen.reference[:] = measured, goal
    state.seen.ticks_ns[:] = state.seen.captured_ns[:] = 25 * NS_PER_MS * np.arange(len(state.drives))
    return ilc.next_trial(state, CONTEXT)


def learner(model, bank=(), drive=0.1, **changes):
    return Ilc(model=model, bank=bank, current_ma=(40.0,) * 4, duration_s=1.5, first_drive=(drive,) * 4,
               law="noilc", change_weight=1e-4, slew=1.0, **changes)


THRESHOLDS = st.lists(st.floats(0.6, 1.6), min_size=3, max_size=3, unique_by=lambda each: round(8 * each))


@settings(max_examples=20)
@given(factors=THRESHOLDS, which=st.integers(0, 2))
def test_persons_who_differ_in_thresholds_alone_are_told_apart(factors, which):
    models = [person(factor) for factor in factors]
    learnt = after_a_trial(learner(models[0], tuple(models[1:])), models[which], 0.5)
    status, detail = learnt.pending[0]
    assert status == "model_selected"
    assert f"model {which}: share 1.00, error 0.00 deg" in detail


@settings(max_examples=20)
@given(factors=THRESHOLDS)
def test_what_another_persons_pulses_reach_is_reached_at_once_by_that_persons_model(factors):
    true, *others = (person(factor) for factor in factors)
    goal = responded(true, learner(others[0], drive=0.12).init(CONTEXT).pulses)
    learnt = after_a_trial(learner(others[0], (others[1], true)), true, goal)
    before = responded(true, learner(others[0]).init(CONTEXT).pulses)
    assert np.linalg.norm(goal - responded(true, learnt.pulses)) < 0.01 * np.linalg.norm(goal - before)


@settings(max_examples=20)
@given(threshold=st.floats(0.7, 1.4), strength=st.floats(0.7, 1.5))
def test_a_person_between_two_of_the_bank_is_reached_by_their_mixture(threshold, strength):
    true, weak, strong = (person(threshold, each) for each in (strength, 0.6, 1.6))
    goal = responded(true, learner(weak, drive=0.12).init(CONTEXT).pulses)
    learnt = after_a_trial(learner(weak, (strong,), bank_rule="mixture"), true, goal)
    before = responded(true, learner(weak).init(CONTEXT).pulses)
    assert np.linalg.norm(goal - responded(true, learnt.pulses)) < 0.02 * np.linalg.norm(goal - before)


def test_learning_that_stops_goes_back_to_the_pulses_of_the_best_trial():
    ilc, true = learner(person(1.0), (person(1.4),), stop_after=1), person(1.4)
    goal = responded(true, learner(person(1.0), drive=0.12).init(CONTEXT).pulses)
    best = after_a_trial(ilc, true, goal)
    state = after(ilc, best, goal + 0.001, goal)
    state = after(ilc, state, goal + 1.0, goal)
    assert state.progress.stopped
    np.testing.assert_array_equal(state.pulses, best.pulses)
    np.testing.assert_array_equal(ilc.next_trial(state, CONTEXT).pulses, best.pulses)


@pytest.mark.parametrize("seen", [False, True])
def test_a_trial_without_a_usable_sample_repeats_the_pulses(seen):
    ilc = learner(person(1.0), (person(1.4),))
    state = after_a_trial(ilc, person(1.4), responded(person(1.4), learner(person(1.0), drive=0.12).init(
        CONTEXT).pulses))
    assert not np.array_equal(state.drives, ilc.allocation().drives(state.pulses))
    state.seen.captured_ns[:] = 25 * NS_PER_MS if seen else NEVER
    state.seen.doubtful[:] = seen
    np.testing.assert_array_equal(ilc.next_trial(state, CONTEXT).pulses, state.pulses)


@pytest.mark.parametrize("law", ["noilc_constrained", "newton"])
def test_drives_that_rise_faster_by_the_chosen_curves_do_not_end_learning(law):
    ilc = replace(learner(person(1.6), (person(0.6),)), law=law, slew=0.1, begin_s=0.5)
    state = ilc.init(CONTEXT)
    goal = responded(person(0.6), replace(learner(person(1.6), drive=0.12), begin_s=0.5).init(CONTEXT).pulses)
    learnt = after(ilc, state, responded(person(0.6), state.pulses), goal)
    assert [status for status, _ in learnt.pending] == ["model_selected"]
    assert learnt.drives[0].max() == 0.0
    left, before = (np.linalg.norm(goal - responded(person(0.6), trial.pulses)) for trial in (learnt, state))
    assert left < 0.2 * before


def test_a_model_whose_muscles_the_currents_do_not_reach_is_refused():
    with pytest.raises(InputError, match=r"^bank\[1\]: current_ma: .*recruits less than 0.01 of muscle 0"):
        learner(NOMINAL, (person(1.2), person(50.0)))

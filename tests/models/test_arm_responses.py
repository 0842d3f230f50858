"""Tests of responses of arms: pools of made-up estimates, and what the shipped population holds."""

import json

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import multivariate_normal

from fesloop.models.arm_responses import ArmResponses, Estimate, Response, Widths, effective_a, pooled
from fesloop.models.evoked_torque import UNDER_ELECTRODES


def test_a_pool_finds_the_spreads_of_made_up_people():
    rng = np.random.default_rng(3)
    names = np.repeat([f"p{k}" for k in range(60)], 6)
    sds = rng.uniform(0.1, 0.4, names.size)
    values = 2.0 + np.repeat(rng.normal(0.0, 0.3, 60), 6) + rng.normal(0.0, np.hypot(0.2, sds))
    found = pooled(values, sds, names.tolist(), np.tile(list("abcdef"), 60).tolist())
    assert found.mean == pytest.approx(2.0, abs=0.12)
    assert found.between == pytest.approx(0.3, abs=0.09)
    assert found.within == pytest.approx(0.2, abs=0.06)
    assert found.among < 0.06


def test_a_pool_has_the_greatest_posterior_density():
    values, sds = np.array([1.0, 1.4, 2.0, 2.1, 1.7]), np.full(5, 0.1)
    names, muscles = ["a", "a", "b", "b", "b"], ["m", "n", "m", "n", "n"]
    found = pooled(values, sds, names, muscles)
    person, muscle = np.equal.outer(names, names), np.equal.outer(muscles, muscles)

    def density(between, among, within):
        total = between**2 * person + among**2 * muscle + np.diag(within**2 + sds**2)
        mean = np.linalg.inv(total).sum(axis=0) @ values / np.linalg.inv(total).sum()
        restricted = -0.5 * np.log(np.linalg.inv(total).sum())
        return (multivariate_normal(np.full(5, mean), total).logpdf(values) + restricted
                - 0.5 * (between**2 + among**2 + within**2) / 0.25)

    sizes = np.array([found.between, found.among, found.within])
    best = density(*sizes)
    for k in range(3):
        for factor in (0.8, 1.25):
            assert density(*np.where(np.arange(3) == k, factor * sizes, sizes)) < best + 1e-3
    # what a muscle adds is the conditional mean of the joint normal distribution
    total = found.between**2 * person + found.among**2 * muscle + np.diag(found.within**2 + sds**2)
    own = found.among**2 * muscle[0]
    assert found.muscles["m"][0] == pytest.approx(own @ np.linalg.inv(total) @ (values - found.mean))


def made_up(people=("a", "b", "c")):
    rng = np.random.default_rng(1)
    return ArmResponses(
        [Estimate(Response(name, "biceps", 0.05, 20.0 * np.exp(0.1 * rng.normal()), 0.6, 0.2, 10.0),
                  (0.01, 0.1, 0.3, 0.2)) for name in people],
        [Widths(name, "biceps", 2.7 + 0.1 * k, 0.4) for k, name in enumerate(people)])


def test_leaving_people_out_is_the_population_of_the_others():
    assert made_up().without(["b"]).as_document() == ArmResponses(
        made_up().estimates[::2], made_up().widths[::2]).as_document()
    assert made_up().without(["b"]).people == ("a", "c")


def test_the_person_in_the_middle_has_the_means():
    responses = made_up()
    person = responses.middle(["biceps"])
    assert person.delay_s == pytest.approx(0.05)
    assert person.highest[0] == pytest.approx(ndtr(0.6))
    # the highest width, at which the effective current is that of the mean logarithm, recruits this share
    assert person.threshold_ma[0] * np.exp(0.6 * person.spread[0]) == pytest.approx(
        np.exp(2.8 + responses.widths_pool.mean))
    assert person.lowest[0] == pytest.approx(ndtr(0.6 - 0.4 / person.spread[0]))


def test_random_people_scatter_as_the_pools_say():
    responses, rng = ArmResponses.shipped(), np.random.default_rng(2)
    drawn = [responses.drawn(("biceps", "triceps"), rng) for _ in range(2000)]
    logs = np.log([each.frequency_rad_s for each in drawn])
    pool = responses.log_frequency
    means, unknown = np.array([pool.of(name) for name in ("biceps", "triceps")]).T
    assert logs.mean() == pytest.approx(means.mean(), abs=0.03)
    # the natural frequency is one for all muscles of a person: the mean of theirs
    own = np.sqrt((unknown**2 + pool.within**2).sum()) / 2.0
    assert logs.std() == pytest.approx(np.hypot(pool.between, own), rel=0.1)
    assert min(each.delay_s for each in drawn) >= 0.005


def test_effective_current_is_half_the_current_at_the_chronaxie():
    assert effective_a(0.02, np.array([1e-4, 0.0, 1e9]), 1e-4) == pytest.approx([0.01, 0.0, 0.02])


def test_shipped_people_are_those_of_the_recordings():
    responses = ArmResponses.shipped()
    assert responses.people == ("S9000", "S9001", "S9002", "S9003", "S9004", "S9006", "S9007")
    json.dumps(responses.as_document())
    person = responses.middle(tuple(UNDER_ELECTRODES))
    assert np.isfinite(person.threshold_ma).all()
    assert (person.lowest < person.highest).all()

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_scores import salchow

from fesloop.apps.reproduce import error_model, fit_error_model, salchow2019
from fesloop.apps.reproduce.cohort import Attempt, Job
from fesloop.apps.reproduce.error_model import (
    PRIORS,
    UNFITTED,
    Prior,
    VirtualPaper,
    person_settings,
    posterior,
    reference,
    room_settings,
    simulated,
    theta_at,
    with_model_error,
)
from fesloop.apps.reproduce.fit_error_model import Fit, Particle, sample
from fesloop.errors import RunError
from fesloop.experiment.files.parse import load

PAPER = "salchow2019"
MIDDLE = theta_at(PAPER, np.full(len(PRIORS[PAPER]), 0.5))


def parts(*more):
    return {node.name: node.part for node in load(PAPER, ["motion=P1", *more], 1).nodes}


@pytest.mark.parametrize("paper", PRIORS)
def test_shares_of_priors_are_quantiles_of_log_uniform_distributions(paper):
    size = len(PRIORS[paper])
    ends = [theta_at(paper, np.full(size, share)) for share in (0.0, 0.5, 1.0)]
    for name, prior in PRIORS[paper].items():
        assert ends[0][name] == pytest.approx(prior.low)
        assert ends[1][name] == pytest.approx(np.sqrt(prior.low * prior.high))
        assert ends[2][name] == pytest.approx(prior.high)
        assert prior.reason


def test_deviations_of_the_thumb_alone_are_scaled():
    usual, thumb = (parts(*person_settings(MIDDLE | {"thumb": factor}, 5, 6)) for factor in (1.0, 2.0))
    for table in (lambda each: each["imus"].mounting_deg, lambda each: each["hand"].hand.axes_deg):
        for name, turn in table(usual).items():
            factor = 2.0 if name.startswith("F1") else 1.0
            np.testing.assert_allclose(table(thumb)[name], factor * np.array(turn), rtol=1e-9)
    assert thumb["hand"].hand.segments_mm == usual["hand"].hand.segments_mm


def test_without_deviations_a_person_differs_in_size_alone():
    none = dict.fromkeys(MIDDLE, 0.0) | {"thumb": 1.0}
    found = parts(*person_settings(none, 5, 6))
    assert (found["hand"].hand.segments_mm, found["hand"].hand.axes_deg) == (None, {})
    assert not any(found["hand"].pose_error_deg.values())


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**31 - 1), st.sampled_from([None, 0.03, 0.4]))
def test_iron_lies_beside_or_below_the_hand_as_near_as_stated(seed, nearest):
    field = parts(*room_settings(0.2, nearest, seed, ("imus",)))["imus"].magnetic_field
    away = np.array([dipole.position for dipole in field.dipoles]) - [0.0, 0.09, 0.0]
    distances = np.linalg.norm(away, axis=1)
    assert (away[:, 2] <= 0.0).all()
    assert distances.min() >= 0.02 - 1e-9
    assert distances.max() <= 0.5 + 1e-9
    assert nearest is None or distances.min() == pytest.approx(nearest)
    np.testing.assert_allclose([np.linalg.norm(dipole.moment) for dipole in field.dipoles], 0.2)


def test_optical_references_have_the_stated_spread():
    found = [reference({"optical_deg": 3.0, "optical_mm": 2.0}, seed) for seed in range(500)]
    angles = 2.0 * np.degrees(np.arccos([each.turn[0] for each in found]))
    assert np.sqrt(np.mean(angles**2)) == pytest.approx(3.0, rel=0.1)
    shifts = 1e3 * np.array([each.shift for each in found])
    assert shifts.std() == pytest.approx(2.0 * np.sqrt(2.0), rel=0.05)
    # Half of the variance is the origin's, common to the fingers.
    assert np.corrcoef(shifts[:, 0, 0], shifts[:, 1, 0])[0, 1] == pytest.approx(0.5, abs=0.12)


class Broken(Job):
    """A job that fails."""

    def kept(self):
        raise RunError("out of reach")


def test_papers_with_a_failed_run_are_left_out():
    jobs = {1: Job, 2: Broken}
    papers = [VirtualPaper({}, (seed,)) for seed in (1, 2, 1)]
    attempt = Attempt((0,), Broken((0,), PAPER, (), 1, salchow2019.tip_traces))
    assert attempt.kept() == {"kept": None}

    def of(paper):
        return [jobs[paper.seeds[0]](("A-F2", 0), PAPER, (str(paper.seeds),), 1, salchow2019.tip_traces)]

    def run_jobs(attempts, workers, progress=None):
        assert len(attempts) == 2  # equal papers are simulated once
        return {each.key: {"kept": None if isinstance(each.job, Broken) else salchow("A-F2")}
                for each in attempts}

    original, error_model.run_jobs = error_model.run_jobs, run_jobs
    try:
        assert simulated(papers, of, 1) == [{("A-F2", 0): salchow("A-F2")}] * 2
    finally:
        error_model.run_jobs = original


class Line:
    """A simulator of one statistic: the share, and noise of sd 0.1 by the seed."""

    def __init__(self, fit, workers):
        pass

    def particles(self, points):
        noise = [np.random.default_rng(seeds).standard_normal() for _, seeds in points]
        return [Particle(shares, seeds, {"x": shares[0] + 0.1 * each})
                for (shares, seeds), each in zip(points, noise, strict=True)]


def test_the_sampler_finds_a_known_posterior(monkeypatch):
    """x = share + normal noise of sd 0.1, x = 0.4: the share is normal with mean 0.4 and sd 0.1."""
    prior = {"share": Prior(1.0, 2.0, "x"), "other": Prior(1.0, 2.0, "not in x")}
    blocks = ((("share", "other"), ()), ((), ()))
    fit = Fit("line", 1, lambda *given: [], lambda kept: {}, {"x": 0.4}, blocks, 0, 1)
    monkeypatch.setitem(fit_error_model.PRIORS, "line", prior)
    monkeypatch.setattr(fit_error_model, "Simulator", Line)
    monkeypatch.setattr(fit_error_model, "fit_of", lambda paper: fit)
    lines = []
    found = sample("line", 600, 6, 1, 1, lines.append)
    shares = np.array([each.shares for each in found])
    assert found[0].distance <= found[-1].distance < 0.1
    assert shares[:, 0].mean() == pytest.approx(0.4, abs=0.03)
    assert shares[:, 0].std() == pytest.approx(0.1, rel=0.25)
    # A hyperparameter that no statistic knows keeps its prior.
    assert shares[:, 1].mean() == pytest.approx(0.5, abs=0.06)
    assert shares[:, 1].std() == pytest.approx(np.sqrt(1.0 / 12.0), rel=0.2)
    assert any("accepted" in line for line in lines)


def test_the_fit_simulates_the_fitted_half_alone():
    halves = {"salchow2019": {"A-F1", "A-F2", "A-F3", "P1", "P3"}, "kortier2014": {"flexion", "flat"}}
    for paper, half in halves.items():
        fit = fit_error_model.fit_of(paper)
        theta = theta_at(paper, np.full(len(PRIORS[paper]), 0.5))
        assert {job.key[0] for job in fit.jobs(theta, range(fit.seeds))} == half


def test_papers_of_a_posterior_keep_what_was_fitted_and_sample_the_rest():
    papers = posterior("kortier2014", 40)
    assert posterior("kortier2014", 40) == papers
    fitted = [place for place in range(8) if place not in UNFITTED["kortier2014"]]
    half = len(papers) // 2
    for first, second in zip(papers[:half], papers[half:], strict=True):
        assert first.theta == second.theta
        assert [first.seeds[place] for place in fitted] == [second.seeds[place] for place in fitted]
    for place in UNFITTED["kortier2014"]:
        assert len({paper.seeds[place] for paper in papers}) == len(papers)


def test_the_models_error_is_that_of_the_frozen_posterior():
    figures = {key: np.full(4000, 3.0) for key in ("one", "two")}
    found = with_model_error("kortier2014", figures)
    logs = np.log([found["one"], found["two"]])
    assert logs.std(axis=1) == pytest.approx(0.2995, rel=0.05)
    assert logs.mean(axis=1) == pytest.approx(np.log(3.0), abs=0.02)
    assert abs(np.corrcoef(logs)[0, 1]) < 0.06
    # That of the other paper was frozen without one.
    assert with_model_error("salchow2019", figures)["one"].tolist() == figures["one"].tolist()


@pytest.mark.parametrize("paper", PRIORS)
def test_frozen_particles_lie_in_the_priors(paper):
    for each in posterior(paper, 40):
        for name, prior in PRIORS[paper].items():
            assert prior.low <= each.theta[name] <= prior.high

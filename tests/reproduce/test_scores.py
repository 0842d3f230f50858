"""Scores against analytic results: uniform transforms, normal densities, laws of sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from fesloop.apps.reproduce import kortier2014, salchow2019
from fesloop.apps.reproduce.comparison import FigureScores
from fesloop.apps.reproduce.published import Published
from fesloop.apps.reproduce.result import Reproduction, summary, summary_lines
from fesloop.apps.reproduce.scores import (
    Pattern,
    baseline,
    figure_rows,
    log_score,
    papers_of_subjects,
    pattern_rows,
    pit,
)
from fesloop.errors import InputError

SEEDS = st.integers(0, 2**32 - 1)
LOCATIONS, SCALES = st.floats(-2.0, 3.0), st.floats(0.05, 1.5)


def figure(name, value=2.0, n=1, spread=0.5, half="predicted"):
    return Published(table="T", row=name, value=value, unit="cm", n=n, of="subjects", spread=spread, each=(),
                     half=half)


def transforms(rng, location, scale, true_scale):
    """Transforms of 300 values, each under 200 replicates of its own."""
    return [pit(float(rng.lognormal(location, true_scale)), rng.lognormal(location, scale, 200))
            for _ in range(300)]


@settings(deadline=None, max_examples=20)
@given(seed=SEEDS, location=LOCATIONS, scale=SCALES)
def test_transforms_are_uniform_if_the_model_is_true_and_only_then(seed, location, scale):
    rng = np.random.default_rng(seed)
    assert stats.kstest(transforms(rng, location, scale, scale), "uniform").pvalue > 1e-5
    for factor in (0.4, 2.5):
        assert stats.kstest(transforms(rng, location, factor * scale, scale), "uniform").pvalue < 1e-5


@settings(deadline=None)
@given(value=st.floats(0.1, 50.0), replicates=st.lists(st.floats(0.1, 50.0), min_size=1, max_size=40))
def test_a_transform_is_the_mean_rank(value, replicates):
    """scipy's mean rank of the value among all, which is 1 to n + 1; never 0 or 1."""
    rank = stats.rankdata([value, *replicates])[0]
    assert pit(value, np.array(replicates)) == pytest.approx((rank - 0.5) / (len(replicates) + 1))


@settings(deadline=None, max_examples=30)
@given(seed=SEEDS, location=LOCATIONS, scale=SCALES, away=st.floats(-4.0, 4.0))
def test_the_log_score_is_the_normal_density_of_the_logarithm(seed, location, scale, away):
    """In the limit of many replicates; also far outside of them."""
    value = float(np.exp(location + away * scale))
    replicates = np.random.default_rng(seed).lognormal(location, scale, 200_000)
    exact = stats.lognorm.logpdf(value, scale, scale=np.exp(location)) + np.log(value)
    assert log_score(value, replicates) == pytest.approx(exact, abs=0.1)
    assert np.isfinite(log_score(1000.0 * value, replicates))


@settings(deadline=None)
@given(seed=SEEDS, unit=st.floats(0.001, 1000.0))
def test_the_log_score_has_no_unit(seed, unit):
    values = np.random.default_rng(seed).lognormal(size=30)
    assert log_score(unit * 2.0, unit * values) == pytest.approx(log_score(2.0, values), abs=1e-6)


@settings(deadline=None, max_examples=20)
@given(seed=SEEDS, location=LOCATIONS, scale=SCALES, shift=st.sampled_from([-1.0, 0.0, 1.0]),
       wider=st.sampled_from([0.5, 1.0, 2.0]))
def test_the_true_model_has_the_best_mean_log_score(seed, location, scale, shift, wider):
    rng = np.random.default_rng(seed)
    values = rng.lognormal(location, scale, 2000)
    true = rng.lognormal(location, scale, 20_000)
    other = rng.lognormal(location + shift * scale, wider * scale, 20_000)
    gain = np.mean([log_score(each, true) - log_score(each, other) for each in values[:300]])
    if (shift, wider) != (0.0, 1.0):
        assert gain > 0.0
    else:
        assert abs(gain) < 0.05


def test_equal_replicates_have_no_log_score():
    assert np.isnan(log_score(2.0, np.full(10, 2.0)))
    assert np.isnan(log_score(2.0, np.array([2.0])))


def test_replicates_of_subjects_follow_the_law_of_means():
    """Means of n drawn with replacement have the variance s^2 / n; one subject is the first of several."""
    one = np.random.default_rng(3).uniform(1.0, 3.0, 40)
    values = {"T: one": one, "T: four": one}
    figures = {key: figure(key[3:], n=n) for key, n in (("T: one", 1), ("T: four", 4))}
    found = papers_of_subjects(values, figures)
    for key, n in (("T: one", 1), ("T: four", 4)):
        assert found[key].mean() == pytest.approx(values[key].mean(), abs=0.1)
        assert found[key].var() == pytest.approx(values[key].var() / n, rel=0.1)
    # The covariance of a mean of four with one of them is a quarter of the variance: correlation a half.
    assert np.corrcoef(found["T: one"], found["T: four"])[0, 1] == pytest.approx(0.5, abs=0.05)
    assert np.array_equal(papers_of_subjects(values, figures)["T: four"], found["T: four"])


def test_a_row_has_the_scores_of_its_figure():
    replicates = {"T: a": np.arange(1.0, 102.0), "T: b": np.linspace(1.0, 2.0, 101)}
    before = {"T: a": np.linspace(3.0, 4.0, 101), "T: b": np.linspace(3.0, 4.0, 101)}
    a, b = figure_rows({"T: a": figure("a", 26.0), "T: b": figure("b", 3.5, spread=np.nan, half="fitted")},
                       replicates, before)
    assert (a.holds, b.holds) == (True, False)
    assert a.scores == FigureScores(
        half="predicted", pit=26.0 / 102.0, log_score=log_score(26.0, replicates["T: a"]),
        baseline_log_score=log_score(26.0, before["T: a"]), baseline_holds=False, band_over_sd=180.0)
    assert b.scores.half == "fitted"
    assert b.scores.baseline_holds
    assert np.isnan(b.scores.band_over_sd)
    assert a.as_table()["scores"]["half"] == "predicted"


@pytest.mark.parametrize(("replicates", "told"), [
    ({"T: a": np.ones(3)}, "replicates: missing or unknown: T: b"),
    ({"T: a": np.ones(3), "T: b": np.ones(3), "T: c": np.ones(3)}, "replicates: missing or unknown: T: c"),
    ({"T: a": np.ones(3), "T: b": np.ones(4)}, "replicates: figures differ in the number"),
    ({"T: a": np.ones(3), "T: b": np.array([1.0, np.nan, 1.0])}, "replicates, T: b: none, or not all"),
    ({"T: a": np.zeros(3), "T: b": np.ones(3)}, "replicates, T: a: none, or not all"),
    ({"T: a": np.ones(0), "T: b": np.ones(0)}, "replicates, T: a: none, or not all"),
])
def test_replicates_are_of_every_figure_and_positive(replicates, told):
    figures = {"T: a": figure("a"), "T: b": figure("b")}
    good = {key: np.ones(3) for key in figures}
    for ours, before in ((replicates, good), (good, replicates)):
        with pytest.raises(InputError, match=told):
            figure_rows(figures, ours, before)


def test_a_pattern_holds_if_it_occurs_in_half_of_the_papers():
    pattern = Pattern(table="T", statement="a above b", theirs="yes",
                      occurs=lambda found: found["a"] > found["b"])
    b = np.full(4, 2.0)
    (row,) = pattern_rows([pattern], {"a": np.array([1.0, 1.0, 3.0, 3.0]), "b": b},
                          {"a": np.array([1.0, 1.0, 1.0, 3.0]), "b": b})
    assert (row.holds, row.ours) == (True, "in 50 %")
    assert (row.scores.share, row.scores.baseline_share, row.scores.baseline_holds) == (0.5, 0.25, False)


def test_a_summary_tells_the_halves_apart():
    figures = {f"T: {name}": figure(name, value, half=half) for name, value, half in (
        ("a", 1.5, "fitted"), ("b", 1.5, "predicted"), ("c", 9.0, "predicted"))}
    ours = dict.fromkeys(figures, np.linspace(1.0, 2.0, 101))
    before = dict.fromkeys(figures, np.linspace(8.0, 10.0, 101))
    rows = figure_rows(figures, ours, before)
    found = summary(rows)
    fitted, predicted = found["fitted"], found["predicted"]
    assert (fitted["rows"], fitted["holding"], fitted["baseline_holding"]) == (1, 1, 0)
    assert (predicted["rows"], predicted["holding"], predicted["baseline_holding"]) == (2, 1, 1)
    assert predicted["log_score_better"] == 1
    assert predicted["log_score"] == np.mean([row.scores.log_score for row in rows[1:]])
    assert predicted["band_over_sd"] == pytest.approx(1.8)
    assert found["patterns"] == {"rows": 0, "holding": 0, "baseline_holding": 0}
    lines = summary_lines(Reproduction("it", 3, rows, baseline="abc", frozen="def").as_table())
    assert lines[1].startswith("predicted: 1 of 2 rows in the band, 1 in the baseline's; mean log score ")
    assert lines[-1] == "baseline: the model of abc; frozen before the predicted half was simulated: def"


@pytest.mark.parametrize("paper", [kortier2014, salchow2019], ids=["kortier2014", "salchow2019"])
def test_the_kept_baseline_has_every_figure(paper):
    kept = baseline(paper.EXPERIMENT)
    assert set(kept.values) == set(paper.FIGURES)
    assert len({values.size for values in kept.values.values()}) == 1
    assert len(kept.commit) >= 7
    figure_rows(paper.FIGURES, *2 * (papers_of_subjects(kept.values, paper.FIGURES),))

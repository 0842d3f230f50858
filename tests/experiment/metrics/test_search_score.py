"""What is scored of a search that has not come to anything."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fesloop.experiment.metrics.search import BASELINE, ENDED, MEASURE, SearchScore, asked_of, search_metrics

SCORE = SearchScore(search="search", truth="hand.angles", movement="finger_opening")


def test_a_search_that_never_stepped_asked_nothing():
    """Of a run that fails at its first tick, blocks before the search may have rows, and it has none."""
    shapes = {"stimulation": (1, 2), "best_stimulation": (1, 2), "multiplexing": (1, 59),
              "best_multiplexing": (59,), "angles": (23,)}

    def signal(name, trial):
        return SimpleNamespace(times_ns=np.empty(0, np.int64),
                               values=np.empty((0, *shapes.get(name.partition(".")[2], ()))))

    recording = SimpleNamespace(trials=1, signal=signal, signals=[])
    assert asked_of(recording, SCORE) == []
    metrics = search_metrics(recording, SCORE)
    assert metrics["queries"] == [0]
    assert np.isnan(metrics["minutes"]).all()
    assert metrics["element_quality"] == [[None] * 59]
    assert metrics["found_elements"] == [[]]


@pytest.mark.parametrize("sd", [None, 0.0, 0.07])
def test_what_is_found_stands_at_the_trial_in_which_it_was_found(sd):
    """The first trial ends before the response to its first query is there; the second has one."""
    share = np.zeros(59)
    share[17] = 1.0
    phases = {0: [BASELINE, MEASURE], 1: [BASELINE, MEASURE, ENDED]}
    given = np.array([0.01, 0.0])
    values = {"quality": 0.5, "stimulation": given[np.newaxis], "best_stimulation": given,
              "multiplexing": share[np.newaxis], "best_multiplexing": share, "query": 0.0,
              "best_quality": 0.4, "best_quality_sd": sd}

    def signal(name, trial):
        phase, port = phases[trial], name.partition(".")[2]
        held = {**values, "angles": np.zeros(23)}.get(port)
        rows = np.array(phase, float) if port == "phase" else np.stack([np.asarray(held)] * len(phase))
        return SimpleNamespace(times_ns=np.arange(len(phase)) * 1_000_000_000, values=rows)

    signals = [] if sd is None else ["search.best_quality", "search.best_quality_sd"]
    recording = SimpleNamespace(trials=2, signal=signal, signals=signals)
    metrics = search_metrics(recording, replace(SCORE, optimum=0.5))
    assert metrics["queries"] == [0, 1]
    assert metrics["found_elements"] == [[], [17]]
    assert np.isnan(metrics["found_ma"][0])
    assert metrics["found_ma"][1] == pytest.approx(10.0)
    for name in ("found_true_quality", "found_true_selectivity", "optimum_share"):
        assert np.isnan(metrics[name][0])
        assert len(metrics[name]) == 2
    assert metrics["found_measured_quality"][1] == 0.5
    for name, value in (("found_predicted_quality", 0.4), ("found_predicted_sd", sd)):
        assert metrics[name][1] == value if sd else np.isnan(metrics[name][1])

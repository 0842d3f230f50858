"""What is scored of a search that has not come to anything."""

from types import SimpleNamespace

import numpy as np

from fesloop.experiment.metrics.search import SearchScore, asked_of, search_metrics

SCORE = SearchScore(search="search", truth="hand.angles", movement="finger_opening")


def test_a_search_that_never_stepped_asked_nothing():
    """Of a run that fails at its first tick, blocks before the search may have rows, and it has none."""
    shapes = {"stimulation": (1, 2), "best_stimulation": (1, 2), "multiplexing": (1, 59),
              "best_multiplexing": (59,), "angles": (23,)}

    def signal(name, trial):
        return SimpleNamespace(times_ns=np.empty(0, np.int64),
                               values=np.empty((0, *shapes.get(name.partition(".")[2], ()))))

    recording = SimpleNamespace(trials=1, signal=signal)
    assert asked_of(recording, SCORE) == []
    metrics = search_metrics(recording, SCORE)
    assert metrics["queries"] == [0]
    assert np.isnan(metrics["minutes"]).all()
    assert metrics["element_quality"] == [[None] * 59]

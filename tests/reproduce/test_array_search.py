"""The claim of the point search, on made-up searches; truth and metrics against the whole loop (10 s)."""

import math

import numpy as np
import pytest

from fesloop import Recording
from fesloop.apps.reproduce import array_search
from fesloop.apps.reproduce.array_search import RestedHand
from fesloop.apps.reproduce.figures import draw
from fesloop.experiment.files.parse import load
from fesloop.experiment.metrics.search import SearchScore, asked_of, element_quality, search_metrics
from fesloop.hand.movements import movement_of

QUERIES = (((17,), 20.0), ((40, 46), 25.0), ((6,), 8.0), ((17, 18), 30.0))
SCORE = SearchScore(search="search", truth="hand.angles", movement="finger_opening", optimum=0.5)


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    """An exhaustive search of a few queries, in the loop."""
    elements = str([list(elements) for elements, _ in QUERIES])
    settings = ["strategy=listed", f"blocks.search.strategies.listed.elements={elements}", "duration_s=15",
                f"blocks.search.strategies.listed.current_ma={[current for _, current in QUERIES]}"]
    experiment = load("array_search_exhaustive", settings)
    return experiment, experiment.run(tmp_path_factory.mktemp("listed"))


@pytest.mark.slow
def test_metrics_tell_what_was_asked_and_found(listed):
    _, result = listed
    with Recording(result.recording) as recording:
        asked = asked_of(recording, SCORE)
        metrics = search_metrics(recording, SCORE)
        (found,) = [event for event in recording.events if event.status == "search_ended"]
    assert [(one.elements, pytest.approx(one.current_ma)) for one in asked] == list(QUERIES)
    # The search sees the hand's own angles here, so what it thinks is what is true.
    for one in asked:
        assert one.quality == pytest.approx(one.verdict.quality, abs=1e-3)
    best = max(asked, key=lambda one: one.verdict.quality)
    assert metrics["queries"] == [len(QUERIES)]
    assert metrics["minutes"] == [pytest.approx((2.0 + 2.8 * len(QUERIES)) / 60.0, abs=1e-3)]
    assert metrics["minutes"][0] * 60.0 == pytest.approx(found.time_ns * 1e-9)
    assert metrics["found_elements"] == [list(best.elements)]
    assert metrics["found_true_quality"] == [pytest.approx(best.verdict.quality)]
    assert metrics["optimum_share"] == [pytest.approx(best.verdict.quality / 0.5)]
    (elements,) = metrics["element_quality"]
    assert {k for k, quality in enumerate(elements) if quality is not None} == {6, 17, 18, 40, 46}
    assert elements[17] == max(asked[0].verdict.quality, asked[3].verdict.quality)
    assert elements == element_quality(asked, 59)


def test_the_rested_hand_does_what_the_hand_in_the_loop_does(listed):
    experiment, result = listed
    rested, judge = RestedHand(experiment), movement_of("finger_opening").judge
    truth = rested.responses(QUERIES)
    with Recording(result.recording) as recording:
        for one in asked_of(recording, SCORE):
            moved = truth[one.elements, round(one.current_ma, 6)]
            assert judge(moved).quality == pytest.approx(one.verdict.quality, abs=5e-3)
            np.testing.assert_allclose(moved, one.movement, atol=math.radians(1.0))
    assert max(np.abs(moved).max() for moved in truth.values()) > math.radians(20.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["array_search_gp", "array_search_magnets", "array_search_two_phase"])
def test_a_tracker_stands_between_the_hand_and_the_search(name, tmp_path):
    """Some queries of each; what the search thinks is near what is true, and never the same."""
    pytest.importorskip("sklearn")
    result = load(name, ["duration_s=8"]).run(tmp_path)
    with Recording(result.recording) as recording:
        asked = asked_of(recording, SCORE)
    assert result.status == "done"
    assert len(asked) >= 2
    off = np.array([one.quality - one.verdict.quality for one in asked])
    assert 0.0 < np.abs(off).max() < 0.2
    assert math.isnan(result.metrics["minutes"][0])


def searches(gp=12, two_phase=60, magnets=30, again=3):
    """A patient on whom each search gets to the optimum at that query; 0: never."""
    def one(at, total, minutes):
        worth = np.full(total, 0.2)
        worth[at - 1 if at else total:] = 0.48
        return {"worth": worth, "told_min": minutes * np.arange(1, total + 1) / total, "found": ((1,), 8.0),
                "minutes": minutes, "selectivity": 0.8, "asked": [((1,), 0.3), ((1, 2), 0.4)]}

    everything = {"everything": {((k % 59,), 8.0 + k): 0.5 * k / 999 for k in range(1000)},
                  "layouts": [(5, 7), (4, 6)]}
    return {"gp": one(gp, 50, 2.5) | everything | {"again": one(again, 20, 1.0) | everything},
            "magnets": one(magnets, 50, 2.5), "two_phase": one(two_phase, 80, 9.0)}


def held(patients):
    """Whether each row holds."""
    return [row.holds for row in array_search.compare(patients).rows]


@pytest.mark.slow
def test_a_search_as_claimed_holds_and_draws_its_figures(tmp_path):
    found = array_search.compare([searches(), searches(gp=18)])
    assert [row.holds for row in found.rows] == [True, True, True, True, True, False, True, True, True]
    (_, first), _ = found.sweeps["patients"].rows
    values = dict(zip(found.sweeps["patients"].columns, first, strict=True))
    assert values["gp: queries to 90 %"] == 12.0
    assert values["gp: min to 90 %"] == pytest.approx(2.5 * 12 / 50)
    assert {path.name for path in draw(found, tmp_path)} >= {"maps.png", "progress.png"}
    assert found.as_table()["subjects"] == 2


@pytest.mark.parametrize(("row", "patient"), [
    (0, searches(gp=0)), (3, searches(gp=0)), (4, searches(again=6)), (4, searches(again=0)),
    (8, searches(magnets=12))])
def test_a_claim_that_is_not_met_does_not_hold(row, patient):
    assert held([searches()])[row]
    assert not held([patient])[row]


def test_what_is_lost_again_was_not_reached():
    minutes = np.arange(1.0, 6.0)
    assert array_search.reached(np.array([0.1, 0.95, 0.5, 0.92, 0.91]), minutes) == (4.0, 4.0)
    assert array_search.reached(np.ones(5), minutes) == (1.0, 1.0)
    assert all(map(math.isnan, array_search.reached(np.array([1.0, 1.0, 1.0, 1.0, 0.8]), minutes)))


@pytest.mark.parametrize("name", [*array_search.SEARCHES.values(), "array_search_exhaustive"])
def test_the_searches_can_be_loaded(name):
    if name in ("array_search_gp", "array_search_magnets"):
        pytest.importorskip("sklearn", reason="the extra `search` is not installed")
    experiment = load(name, ("movement=pinch", "member=3"))
    search = next(node.part for node in experiment.nodes if node.name == "search")
    assert search.movement == experiment.score.search.movement == "pinch"
    assert search.space.zones

"""The contract, kept by every strategy whatever the hand does."""

import pickle
import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from controllers.point_search.block import PointSearch
from controllers.point_search.contract import Response
from controllers.point_search.earlier import EarlierResponse, EarlierSearch
from controllers.point_search.exhaustive import Exhaustive, Listed, Random, candidates
from controllers.point_search.gaussian_process import GaussianProcess, expected_improvement
from controllers.point_search.optuna_search import OptunaSearch
from controllers.point_search.prior_zones import ZONES, Zone, expectation
from controllers.point_search.semi_automatic import SemiAutomatic
from controllers.point_search.space import SearchSpace, joined
from controllers.point_search.strategies import TwoPhase
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.hand.movements import FREEDOMS
from fesloop.models.electrode_arrays import ArrayLayout

EXTRAS = {name: find_spec(package) is not None
          for name, package in (("gaussian_process", "sklearn"), ("optuna", "optuna"))}
KNOWN = {"exhaustive": Exhaustive(), "listed": Listed(elements=((2,), (3, 1)), current_ma=(4.0, 8.0)),
         "random": Random(queries=7), "two_phase": TwoPhase(step_uc=0.7, best=3),
         "semi_automatic": SemiAutomatic(step_ma=3.0, stairs=5),
         "gaussian_process": GaussianProcess(queries=4),
         "optuna": OptunaSearch(queries=6, first=3)}
NAMES = [name for name in KNOWN if EXTRAS.get(name, True)]


@st.composite
def spaces(draw):
    """Small arrays of any form."""
    layouts = draw(st.lists(st.builds(
        ArrayLayout, rows=st.integers(2, 3), columns=st.integers(2, 3),
        centre_deg=st.floats(-180.0, 180.0)), min_size=1, max_size=2))
    currents = draw(st.lists(st.floats(8.0, 40.0), min_size=1, max_size=3, unique=True))
    return SearchSpace(layouts=tuple(layouts), currents_ma=tuple(sorted(currents)), pairs=draw(st.booleans()),
                       width_us=draw(st.floats(100.0, 500.0)), zones=ZONES["finger_opening"])


def wayward(seed, query):
    """A response that is a function of the query alone, and otherwise anything."""
    rng = np.random.default_rng([seed, *query.elements, int(1e3 * query.current_ma)])
    return Response(float(rng.normal()), rng.normal(0.0, 0.5, len(FREEDOMS)))


def play(strategy, space, key, seed, most=2000):
    """All queries of a search."""
    state, queries = strategy.start(space, key), []
    while (query := strategy.ask(state)) is not None:
        queries.append(query)
        assert len(queries) < most
        strategy.tell(state, query, wayward(seed, query))
    return state, queries


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=15, deadline=None)
@given(space=spaces(), key=st.integers(0, 2**64 - 1), seed=st.integers(0, 2**32 - 1))
def test_a_search_ends_within_the_arrays_and_what_is_tolerated(name, space, key, seed):
    state, queries = play(KNOWN[name], space, key, seed)
    assert queries
    for query in queries:
        assert set(query.elements) <= set(space.usable)
        assert list(query.elements) == sorted(set(query.elements))
        assert 1 <= len(query.elements) <= space.most_elements
        assert 0.0 < query.current_ma <= space.current_max_ma
        assert query.width_us == space.width_us
    assert KNOWN[name].ask(state) is None
    found = KNOWN[name].recommend(state)
    assert found is None or found.query in queries
    assert queries[0].rested


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=8, deadline=None)
@given(space=spaces(), key=st.integers(0, 2**64 - 1), seed=st.integers(0, 2**32 - 1), cut=st.integers(0, 8))
def test_a_search_depends_on_its_key_alone_and_goes_on_from_a_snapshot(name, space, key, seed, cut):
    strategy = KNOWN[name]
    whole, queries = play(strategy, space, key, seed)
    state = strategy.start(space, key)
    for query in queries[:cut]:
        assert strategy.ask(state) == query == strategy.ask(state)
        strategy.tell(state, query, wayward(seed, query))
    state = pickle.loads(pickle.dumps(state))
    for query in queries[cut:]:
        assert strategy.ask(state) == query
        strategy.tell(state, query, wayward(seed, query))
    assert strategy.ask(state) is None
    assert strategy.recommend(state) == strategy.recommend(whole)


def test_the_exhaustive_search_asks_everything_once_and_finds_the_best():
    space = SearchSpace()
    state, queries = play(Exhaustive(), space, 0, 3)
    # 59 elements; 5 x 6 + 4 x 7 dorsal and 4 x 5 + 3 x 6 volar neighbours.
    assert len(space.electrodes) == 59 + 58 + 38
    assert len(set(queries)) == len(queries) == 155 * 6
    assert set(queries) == set(candidates(space))
    best = max(queries, key=lambda query: wayward(3, query).quality)
    assert Exhaustive().recommend(state).query == best


@pytest.mark.slow
def test_random_asks_nothing_twice():
    _, queries = play(Random(queries=10_000), SearchSpace(), 5, 1)
    assert len(set(queries)) == len(queries) == 930


def test_two_phases_climb_every_element_and_combine_the_best():
    space = SearchSpace(elements=(0, 1, 2, 3, 4, 5, 6), currents_ma=(30.0,), width_us=300.0)
    goodness = {element: 0.1 * element for element in space.usable}
    strategy, climbed = TwoPhase(), []
    state = strategy.start(space, 0)
    while (query := strategy.ask(state)) is not None:
        if query.rested:
            climbed.append(query.elements)
        quality = sum(goodness[element] for element in query.elements) * query.current_ma
        strategy.tell(state, query, Response(quality, np.zeros(len(FREEDOMS))))
    # 9 uC in steps of .2: 45 stairs, of which the last is the limit.
    assert strategy.stairs(space) == 45
    assert climbed[:7] == [(element,) for element in range(7)]
    assert sorted(climbed[7:]) == sorted((a, b) for a in range(2, 7) for b in range(a + 1, 7))
    found = strategy.recommend(state)
    assert (found.query.elements, found.query.current_ma) == ((5, 6), pytest.approx(30.0))


def test_the_therapist_holds_the_wrist_in_its_band_and_climbs_to_the_best_place():
    """The wrist follows current by a deg/mA, quality falls with the distance from element 10."""
    space = SearchSpace(zones=(Zone(around_deg=0.0, along_mm=90.0),))
    strategy, held = SemiAutomatic(), []
    state = strategy.start(space, 0)
    while (query := strategy.ask(state)) is not None:
        movement = np.zeros(len(FREEDOMS))
        movement[0] = np.radians(-query.current_ma)
        away = np.linalg.norm(space.position(query.elements) - space.position((10,)))
        if not query.stair:
            held.append(query)
            assert 10.0 <= query.current_ma <= 20.0
        strategy.tell(state, query, Response(-float(away), movement))
    assert strategy.recommend(state).query.elements == (10,)
    assert len(held) < 20


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
@pytest.mark.parametrize("acquisition", ["ucb", "ei"])
def test_the_gaussian_process_needs_a_fraction_of_a_random_search(acquisition):
    """One bump on the skin and over current, seen through noise."""
    space = SearchSpace()
    middle = space.position((17,))

    def quality(query, rng=None):
        away = np.linalg.norm(space.position(query.elements) - middle) / 20.0
        off = np.log(query.current_ma / 16.0) / 0.6
        noise = 0.02 * rng.standard_normal() if rng else 0.0
        return float(np.exp(-0.5 * (away**2 + off**2)) + noise)

    strategy, rng = GaussianProcess(acquisition=acquisition), np.random.default_rng(0)
    state, count = strategy.start(space, 0), 0
    while (query := strategy.ask(state)) is not None:
        strategy.tell(state, query, Response(quality(query, rng), np.zeros(len(FREEDOMS))))
        count += 1
    assert quality(strategy.recommend(state).query) > 0.95
    # A handful of 930 candidates has it.
    assert count < 150


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
@pytest.mark.parametrize("acquisition", ["ei", "ucb"])
@pytest.mark.parametrize("yesterday", [(), ((2, 0.5), (7, -0.4), (9, 0.1))])
def test_the_gaussian_process_is_that_of_the_formula(yesterday, acquisition):
    """Posterior mean and sd by the textbook's equations (Rasmussen and Williams, 2.25 and 2.26)."""
    space = SearchSpace(layouts=(ArrayLayout(rows=2, columns=2),), currents_ma=(10.0, 20.0))
    queries = candidates(space)
    responses = [EarlierResponse(elements=queries[k].elements, quality=quality,
                                 current_ma=queries[k].current_ma + 1e-12) for k, quality in yesterday]
    space = replace(space, earlier=EarlierSearch(movement="pinch", responses=tuple(responses)))
    strategy = GaussianProcess(zone_height=0.0, acquisition=acquisition, day_share=0.7)
    state = strategy.start(space, 0)
    told = [(0, 0.3), (5, -0.2), (9, 0.6)]
    for k, quality in told:
        strategy.tell(state, queries[k], Response(quality, np.zeros(len(FREEDOMS))))

    def covariance(one, other):
        (a, day), (b, other_day) = one, other
        a, b = queries[a], queries[b]
        place = np.sum((space.position(a.elements) - space.position(b.elements))**2) / strategy.place_mm**2
        current = ((a.current_ma - b.current_ma) / strategy.current_ma)**2
        number = ((len(a.elements) - len(b.elements)) / strategy.elements)**2
        r = np.sqrt(5.0 * (place + current + number))
        share = 1.0 if day == other_day else strategy.day_share
        return share * strategy.spread**2 * (1.0 + r + r * r / 3.0) * np.exp(-r)

    known = [(k, 0) for k, _ in yesterday] + [(k, 1) for k, _ in told]
    among = np.array([[covariance(a, b) for b in known] for a in known])
    among += strategy.noise**2 * np.eye(len(known))
    across = np.array([[covariance((k, 1), b) for b in known] for k in range(len(queries))])
    mean = across @ np.linalg.solve(among, [quality for _, quality in (*yesterday, *told)])
    sd = np.sqrt(strategy.spread**2 - np.sum(across * np.linalg.solve(among, across.T).T, axis=1))
    best = max(mean[[0, 5, 9]])
    u = (mean - best) / sd
    gain = (mean - best) * norm.cdf(u) + sd * norm.pdf(u)
    promise = gain if acquisition == "ei" else mean + strategy.kappa * sd
    left = [k for k in range(len(queries)) if k not in (0, 5, 9)]
    assert strategy.ask(state) == queries[max(left, key=lambda k: promise[k])]
    assert strategy.recommend(state).quality == pytest.approx(best, abs=1e-9)
    most = max(gain[k] for k in left)
    assert replace(strategy, least_gain=0.999 * most).ask(state) is not None
    assert replace(strategy, least_gain=1.001 * most).ask(state) is None


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
def test_a_second_day_begins_where_the_first_ended():
    """The arrays lie a little elsewhere: the first query is near the best, and few are needed."""
    space = SearchSpace()

    def search(space, middle, seed):
        rng = np.random.default_rng(seed)
        state, asked, found = GaussianProcess().start(space, 0), [], None
        while (query := GaussianProcess().ask(state)) is not None:
            away = np.linalg.norm(space.position(query.elements) - middle) / 20.0
            off = np.log(query.current_ma / 16.0) / 0.6
            quality = float(np.exp(-0.5 * (away**2 + off**2)) + 0.02 * rng.standard_normal())
            GaussianProcess().tell(state, query, Response(quality, np.zeros(len(FREEDOMS))))
            asked.append(EarlierResponse(elements=query.elements, current_ma=query.current_ma,
                                         quality=quality))
            found = GaussianProcess().recommend(state)
        return asked, found

    middle = space.position((43,))
    first, _ = search(space, middle, 1)
    moved = replace(space, earlier=EarlierSearch(movement="pinch", responses=tuple(first)))
    second, found = search(moved, middle + np.array([3.0, -3.0, 5.0]), 2)
    assert second[0].quality > 0.7
    assert len(second) < 0.5 * len(first)
    assert found.quality > 0.9


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
@given(spaces(), st.integers(1, 12))
@settings(max_examples=15, deadline=None)
def test_more_queries_than_candidates_are_refused(space, queries):
    strategy, count = GaussianProcess(queries=queries, least_gain=0.0), len(candidates(space))
    if queries > count:
        with pytest.raises(InputError, match=f"{queries}; allowed: 1 to {count}, the number of candidates"):
            strategy.start(space, 0)
    else:
        assert len(play(strategy, space, 0, 0)[1]) == queries
    assert GaussianProcess().start(space, 0)


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
def test_the_number_of_queries_has_a_short_name():
    search = load("array_search_gp", ["queries=20"]).document()["blocks"]["search"]["strategies"]
    assert search["gaussian_process"]["queries"] == search["optuna"]["queries"] == 20
    with pytest.raises(InputError, match=r"queries.*: 900000; allowed: 1 to \d+, the number of candidates"):
        load("array_search_gp", ["queries=900000"])


@pytest.mark.parametrize(("earlier", "strategy", "named"), [
    (("pinch", (3,)), "gaussian_process", "is a search for pinch"),
    (("finger_opening", (3,)), "random", "is not used by the strategy random"),
    (("finger_opening", (3, 58)), "gaussian_process", "tried no electrode")])
def test_an_earlier_search_of_no_use_is_refused(earlier, strategy, named):
    movement, elements = earlier
    response = EarlierResponse(elements=elements, current_ma=8.0, quality=0.1)
    with pytest.raises(InputError, match=named):
        PointSearch(strategy=strategy, earlier=EarlierSearch(movement=movement, responses=(response,)))


@pytest.mark.skipif(not EXTRAS["gaussian_process"], reason="needs scikit-learn")
def test_an_earlier_search_is_of_the_same_arrays():
    own = (ArrayLayout(rows=3, columns=4),)
    response = EarlierResponse(elements=(3,), current_ma=8.0, quality=0.1)
    for layouts, space, fits in ((None, SearchSpace(), True), (own, SearchSpace(layouts=own), True),
                                 (None, SearchSpace(layouts=own), False), (own, SearchSpace(), False)):
        earlier = EarlierSearch(movement="finger_opening", responses=(response,), layouts=layouts)
        if fits:
            PointSearch(strategy="gaussian_process", space=space, earlier=earlier)
            continue
        with pytest.raises(InputError, match="earlier: is a search of other arrays"):
            PointSearch(strategy="gaussian_process", space=space, earlier=earlier)


@pytest.mark.parametrize(("package", "strategy", "named"), [
    ("sklearn.gaussian_process", GaussianProcess(), "scikit-learn is not installed"),
    ("optuna", OptunaSearch(), "Optuna is not installed")])
def test_a_missing_extra_is_named_with_its_remedy(package, strategy, named, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=named) as refused:
        strategy.start(SearchSpace(), 0)
    assert "fesloop[search]" in refused.value.remedy


@pytest.mark.skipif(not EXTRAS["optuna"], reason="Optuna is not installed")
def test_a_quasi_random_search_of_optuna_goes_all_over_the_space():
    space = SearchSpace(currents_ma=(5.0, 10.0, 15.0, 20.0), pairs=False)
    queries = play(OptunaSearch(sampler="qmc", queries=17), space, 3, 0)[1][1:]
    # A Sobol sequence: of any 16 points from a multiple of 16 on, each quarter of a range has four.
    assert sorted(query.current_ma for query in queries) == sorted(4 * [5.0, 10.0, 15.0, 20.0])
    assert len({query.elements for query in queries}) > 8


@pytest.mark.skipif(not EXTRAS["optuna"], reason="Optuna is not installed")
def test_cma_es_without_its_package_is_refused_before_the_first_query(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match="cmaes") as refused:
        OptunaSearch(sampler="cmaes").start(SearchSpace(), 0)
    assert refused.value.remedy == "pip install cmaes"


@pytest.mark.skipif(not EXTRAS["optuna"] or find_spec("cmaes") is None, reason="cmaes is not installed")
def test_cma_es_narrows_down_on_what_is_best():
    space, key = SearchSpace(currents_ma=tuple(map(float, range(4, 25))), pairs=False), 5
    strategy = OptunaSearch(sampler="cmaes", queries=40)
    state = strategy.start(space, key)
    while (query := strategy.ask(state)) is not None:
        strategy.tell(state, query, Response(-abs(query.current_ma - 8.0), np.zeros(len(FREEDOMS))))
    off = np.array([abs(query.current_ma - 8.0) for query, _ in state.told])
    assert off[16:].mean() < 0.75 * off[:16].mean()


def test_expected_improvement_is_an_integral():
    rng = np.random.default_rng(2)
    for mean, sd, best in ((0.2, 0.3, 0.4), (0.5, 0.1, 0.4), (-1.0, 0.5, 0.0)):
        drawn = np.maximum(mean + sd * rng.standard_normal(400_000) - best, 0.0)
        found = expected_improvement(np.array([mean]), np.array([sd]), best)[0]
        assert found == pytest.approx(drawn.mean(), abs=4.0 * drawn.std() / 600.0)


def test_expectation_is_one_in_the_middle_of_a_zone_and_round_the_back_of_the_forearm():
    space = SearchSpace()
    zone = Zone(around_deg=180.0, along_mm=100.0, radius_mm=25.0)
    middle = np.array([[-space.radius_mm, 0.0, 100.0]])
    assert expectation((zone,), middle, space.radius_mm)[0] == pytest.approx(1.0)
    beside = middle + np.array([0.0, 0.0, 25.0])
    assert expectation((zone,), beside, space.radius_mm)[0] == pytest.approx(np.exp(-0.5))
    assert expectation((), middle, space.radius_mm)[0] == 0.0


def test_unions_are_made_once_and_stay_small():
    assert joined(((1,), (2,), (1, 2)), 4) == []
    assert joined(((1, 2), (2, 3), (4, 5)), 3) == [(1, 2, 3)]


@pytest.mark.parametrize(("make", "named"), [
    (lambda: SearchSpace(currents_ma=(10.0, 5.0)), "currents_ma"),
    (lambda: SearchSpace(elements=(59,)), "element 59"),
    (lambda: SearchSpace(layouts=()), "layouts"),
    (lambda: ArrayLayout(rows=0, columns=3), "rows"),
    (lambda: Listed(elements=((1,),), current_ma=()), "equally many"),
    (lambda: Listed(elements=((60,),), current_ma=(1.0,)).start(SearchSpace(), 0), "elements"),
    (lambda: Listed(elements=((6,),), current_ma=(31.0,)).start(SearchSpace(), 0), "current_ma"),
    (lambda: TwoPhase(step_uc=10.0).start(SearchSpace(), 0), "step_uc"),
    (lambda: SemiAutomatic(freedom="wrist"), "freedom"),
    (lambda: GaussianProcess(place_mm=0.0), "place_mm"),
    (lambda: GaussianProcess(current_ma=-1.0), "current_ma"),
    (lambda: OptunaSearch(sampler="tpee"), "tpe, random"),
    (lambda: replace(Zone(around_deg=0.0, along_mm=1.0), radius_mm=0.0), "radius_mm")])
def test_what_cannot_be_is_refused_by_name(make, named):
    with pytest.raises(InputError, match=named):
        make()

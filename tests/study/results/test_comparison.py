import math

import numpy as np
import pytest
import scipy.stats as st
from study_stores import change, write_cells, write_store

from fesloop.analysis.study import load
from fesloop.errors import InputError

PID, MPC = {"controller": "pid"}, {"controller": "mpc"}
CONTROLLERS = ["pid", "mpc"]
COMMON_SD, OWN_SD, GAP = 3.0, 0.4, 0.5
"""Of what the seed decides in all cells alike, of what it decides in each, and what pid is worse by."""
REPLICATES = 400


def noise(seed, what):
    """Of a run: the same for everything that has its seed, or its own."""
    return np.random.default_rng([seed, *map(ord, what)]).normal()


def with_common_noise(levels, replicate):
    own = OWN_SD * noise(replicate, levels["controller"])
    shift = GAP if levels["controller"] == "pid" else 0.0
    return {"error_deg": 10.0 + shift + COMMON_SD * noise(replicate, "common") + own}


@pytest.fixture(scope="module")
def common(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "study.sqlite"
    return load(write_store(path, {"controller": CONTROLLERS}, REPLICATES, with_common_noise))


def test_pairs_leave_out_what_the_seed_does_to_both(common):
    """Var(a - b) is 2 OWN_SD^2, where without pairs it would be 2 (COMMON_SD^2 + OWN_SD^2)."""
    found = common.compare("error_deg", PID, MPC)
    sampled = OWN_SD * math.sqrt(2.0) * np.sqrt(st.chi2.ppf([0.0005, 0.9995], REPLICATES - 1)
                                                / (REPLICATES - 1))
    assert sampled[0] < found.sd < sampled[1]
    half = 0.5 * (found.high - found.low)
    assert half == pytest.approx(st.t.ppf(0.975, REPLICATES - 1) * found.sd / math.sqrt(REPLICATES))
    assert found.low < GAP < found.high
    apart = common.cells("error_deg")
    unpaired = math.hypot(*(0.5 * (cell.high - cell.low) for cell in apart))
    assert unpaired / half == pytest.approx(math.hypot(COMMON_SD, OWN_SD) / OWN_SD, rel=0.2)


def test_a_comparison_says_what_it_is_of(common):
    found = common.compare("error_deg", PID, MPC)
    values = common.table()["error_deg"].reshape(2, -1)
    assert (found.first, found.second, found.metric) == (PID, MPC, "error_deg")
    assert (found.statistic, found.interval, found.test) == ("mean", "Student's t", "Wilcoxon signed rank")
    assert (found.first_value, found.second_value) == pytest.approx(tuple(values.mean(axis=1)))
    assert found.value == pytest.approx(found.first_value - found.second_value)
    assert found.p == pytest.approx(st.wilcoxon(values[0] - values[1], method="approx").pvalue)
    assert (found.pairs, found.units, found.dropped, found.unpaired) == (400, 400, {}, 0)


def test_the_other_way_round_it_is_the_opposite(common):
    one, other = common.compare("error_deg", PID, MPC), common.compare("error_deg", MPC, PID)
    assert (other.value, other.low, other.high) == pytest.approx((-one.value, -one.high, -one.low))
    assert other.p == one.p


def test_the_interval_holds_the_difference_at_its_rate(tmp_path):
    """150 studies of six replicates each, as levels of an axis at which the others are held."""
    def outcome(levels, replicate):
        return with_common_noise(levels, 6 * levels["law"] + replicate)

    axes = {"law": list(range(150)), "controller": CONTROLLERS}
    results = load(write_store(tmp_path / "a.sqlite", axes, 6, outcome))
    found = [results.compare("error_deg", PID, MPC, at={"law": law}, confidence=0.9) for law in range(150)]
    held = np.mean([each.low <= GAP <= each.high for each in found])
    assert held == pytest.approx(0.9, abs=4.0 * math.sqrt(0.09 / 150))
    assert found[7].first == {"controller": "pid", "law": 7}


def with_failures(levels, replicate):
    fails = {"pid": (0, 1), "mpc": (1, 2, 3)}[levels["controller"]]
    if replicate in fails:
        return "diverged"
    if replicate == 4 and levels["controller"] == "mpc":
        return None
    if replicate == 5:
        return {"error_deg": None}
    return {"error_deg": replicate + (1.0 if levels["controller"] == "pid" else 0.0)}


def test_pairs_of_which_one_failed_are_dropped_and_told_of(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"controller": CONTROLLERS}, 9, with_failures))
    found = results.compare("error_deg", PID, MPC)
    assert found.pairs == 3
    assert found.dropped == {"second failed": 2, "first failed": 1, "both failed": 1, "not over yet": 1,
                             "without a finite metric": 1}
    assert (found.value, found.sd) == (1.0, 0.0)


def test_where_no_pair_is_whole_there_is_no_difference(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"controller": CONTROLLERS}, 3,
                               lambda levels, replicate: "diverged"))
    found = results.compare("error_deg", PID, MPC)
    assert (found.pairs, found.units, found.dropped) == (0, 0, {"both failed": 3})
    assert math.isnan(found.value)
    assert math.isnan(found.low)
    assert found.p == 1.0


def test_pairs_are_of_everything_else(tmp_path):
    """Over chosen levels each replicate is one value, over patients each patient."""
    def outcome(levels, replicate):
        gap = 1.0 + levels["member"] if levels["controller"] == "pid" else 0.0
        return {"error_deg": gap + 0.1 * levels["latency_ms"] + replicate}

    axes = {"latency_ms": [0, 10, 50], "controller": CONTROLLERS,
            "member": {"levels": [0, 1, 2, 3], "cohort": {"patient": "sci_c6", "members": 4}}}
    results = load(write_store(tmp_path / "a.sqlite", axes, 2, outcome))
    found = results.compare("error_deg", PID, MPC)
    assert (found.pairs, found.units, found.value) == (24, 4, 2.5)
    assert found.sd == pytest.approx(np.std([1.0, 2.0, 3.0, 4.0], ddof=1))
    alone = results.compare("error_deg", PID, MPC, at={"member": 3, "latency_ms": 10})
    assert (alone.pairs, alone.units, alone.value) == (2, 2, 4.0)
    both = results.compare("error_deg", {"controller": "pid", "latency_ms": 0},
                           {"controller": "mpc", "latency_ms": 50})
    assert (both.pairs, both.value) == (8, -2.5)


def test_runs_of_other_seeds_are_no_pair(tmp_path):
    path = write_store(tmp_path / "a.sqlite", {"controller": CONTROLLERS}, 4,
                       lambda levels, replicate: {"error_deg": 1.0})
    change(path, "UPDATE runs SET seed = 99 WHERE cell = 0 AND replicate = 3")
    found = load(path).compare("error_deg", PID, MPC)
    assert (found.pairs, found.unpaired) == (3, 2)


def test_shares_differ_by_pairs_too(tmp_path):
    """36, 12, 2 and 0 pairs of which both hold, the first, the second, none: Newcombe's example."""
    kinds = np.repeat([0, 1, 2], [36, 12, 2])

    def outcome(levels, replicate):
        return {"held": kinds[replicate] in ((0, 1) if levels["controller"] == "pid" else (0, 2))}

    results = load(write_store(tmp_path / "a.sqlite", {"controller": CONTROLLERS}, 50, outcome, ("held",)))
    found = results.compare("held", PID, MPC)
    assert (found.first_value, found.second_value, found.value) == pytest.approx((0.96, 0.76, 0.2))
    assert (found.low, found.high) == pytest.approx((0.0569, 0.3404), abs=6e-5)
    assert found.p == pytest.approx(st.binomtest(2, 14).pvalue)
    assert found.test == "sign (McNemar)"


def test_a_median_of_differences_may_be_asked_for(common):
    found = common.compare("error_deg", PID, MPC, statistic="median")
    values = common.table()["error_deg"].reshape(2, -1)
    assert found.value == pytest.approx(np.median(values[0] - values[1]))
    assert found.p == pytest.approx(st.binomtest(int(np.sum(values[0] > values[1])), 400).pvalue)
    assert found.low < GAP < found.high


@pytest.mark.parametrize(("first", "second", "at", "fault"), [
    (PID, {"latency_ms": 0}, {}, "do not name the same axes"), ({}, {}, {}, "do not name the same axes"),
    (PID, PID, {}, "compared with itself"),
    (PID, {"controller": "lqr"}, {}, "controller = lqr: is not a level"),
    ({"law": 1}, {"law": 2}, {}, "law: is not an axis"), (PID, MPC, {"controller": "pid"}, "at.controller")])
def test_what_cannot_be_compared_is_refused(common, first, second, at, fault):
    with pytest.raises(InputError, match=fault):
        common.compare("error_deg", first, second, at)


def test_points_that_were_drawn_have_no_pairs(tmp_path):
    cells = [{"latency_ms": 3.0, "controller": "pid"}, {"latency_ms": 8.5, "controller": "mpc"}]
    document = {"study": {"design": "sobol", "metrics": {"error_deg": "x"}}, "axes": {}}
    results = load(write_cells(tmp_path / "a.sqlite", document, cells, 2,
                               lambda levels, replicate: {"error_deg": 1.0}))
    with pytest.raises(InputError, match="share no levels of the other axes"):
        results.compare("error_deg", PID, MPC)

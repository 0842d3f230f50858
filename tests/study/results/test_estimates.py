import math

import numpy as np
import pytest
import scipy.stats as st
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as some
from study_stores import write_cells, write_store

from fesloop.analysis.study import load
from fesloop.analysis.study.results.statistics import mean_interval
from fesloop.errors import InputError

AXES = {"latency_ms": [0, 20], "controller": ["pid", "mpc"]}
ERRORS = np.random.default_rng(3).normal(5.0, 1.0, (2, 2, 8))


def error(levels, replicate):
    return float(ERRORS[levels["latency_ms"] // 20, ["pid", "mpc"].index(levels["controller"]), replicate])


@pytest.fixture
def results(tmp_path):
    return load(write_store(tmp_path / "study.sqlite", AXES, 8,
                            lambda levels, replicate: {"error_deg": error(levels, replicate),
                                                       "held": replicate < 6}, ("error_deg", "held")))


def test_a_cell_has_the_mean_of_its_replicates(results):
    cells = results.cells("error_deg", confidence=0.9)
    assert [cell.levels for cell in cells] == [
        {"latency_ms": latency, "controller": controller} for latency in (0, 20)
        for controller in ("pid", "mpc")]
    cell, values = cells[3], ERRORS[1, 1]
    assert (cell.statistic, cell.interval, cell.units, cell.runs) == ("mean", "Student's t", 8, 8)
    assert (cell.value, cell.sd) == pytest.approx((values.mean(), values.std(ddof=1)))
    assert (cell.low, cell.high) == pytest.approx(st.t.interval(0.9, 7, values.mean(), st.sem(values)))


def test_over_chosen_levels_replicates_are_what_is_repeated(results):
    """They have their seeds in common, so that 16 runs are 8 values and no more."""
    (pid, mpc) = results.cells("error_deg", ["controller"])
    values = ERRORS[:, 0].mean(axis=0)
    assert (pid.runs, pid.units, mpc.units) == (16, 8, 8)
    assert (pid.value, pid.sd) == pytest.approx((values.mean(), values.std(ddof=1)))


def test_over_everything_there_is_one_estimate(results):
    (whole,) = results.cells("error_deg", [])
    assert whole.levels == {}
    assert (whole.runs, whole.units, whole.value) == (32, 8, pytest.approx(ERRORS.mean()))


def test_levels_may_be_held(results):
    (cell,) = results.cells("error_deg", [], at={"controller": "mpc", "latency_ms": 20})
    assert cell.levels == {"controller": "mpc", "latency_ms": 20}
    assert cell.value == pytest.approx(ERRORS[1, 1].mean())


def test_a_metric_of_switches_is_a_share(results):
    cell = results.cells("held")[0]
    expected = st.binomtest(6, 8).proportion_ci(0.95, method="wilson")
    assert (cell.statistic, cell.interval, cell.value) == ("share", "Wilson", 0.75)
    assert (cell.low, cell.high) == pytest.approx((expected.low, expected.high))


def test_a_metric_with_a_unit_is_no_share_though_it_be_0_or_1(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 2,
                               lambda levels, replicate: {"error_deg": float(replicate)}))
    assert {cell.statistic for cell in results.cells("error_deg")} == {"mean"}
    assert results.cells("error_deg", statistic="share")[0].value == 0.5


def test_a_median_may_be_asked_for(results):
    cell = results.cells("error_deg", statistic="median")[0]
    assert cell.value == pytest.approx(np.median(ERRORS[0, 0]))
    assert (cell.low, cell.high) == (ERRORS[0, 0].min(), ERRORS[0, 0].max())
    assert cell.interval == "binomial order statistics"


def test_members_of_a_cohort_are_what_is_repeated(tmp_path):
    """Replicates tell nothing of other patients: two of each are averaged before patients are counted."""
    members = {"levels": [0, 1, 2, 3], "cohort": {"patient": "sci_c6", "members": 4}}
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": [0, 20], "member": members}, 2,
                               lambda levels, replicate: {"error_deg": levels["member"] + 10.0 * replicate}))
    cells = results.cells("error_deg")
    assert [cell.levels for cell in cells] == [{"latency_ms": 0}, {"latency_ms": 20}]
    values = np.array([5.0, 6.0, 7.0, 8.0])
    assert (cells[0].runs, cells[0].units, cells[0].value) == (8, 4, 6.5)
    assert (cells[0].low, cells[0].high) == pytest.approx(st.t.interval(0.95, 3, 6.5, st.sem(values)))
    alone = results.cells("error_deg", ["latency_ms"], at={"member": 2})[0]
    assert (alone.units, alone.value) == (2, 7.0)
    each = results.cells("error_deg", ["member"])
    assert [(cell.levels, cell.units, cell.value) for cell in each] == [
        ({"member": member}, 2, 5.0 + member) for member in range(4)]


def test_points_that_were_drawn_are_what_is_repeated(tmp_path):
    cells = [{"latency_ms": latency, "controller": controller}
             for latency, controller in ((3.0, "pid"), (8.5, "mpc"), (9.0, "pid"), (17.0, "pid"))]
    document = {"study": {"design": "random", "metrics": {"error_deg": "x"}}, "axes": {}}
    results = load(write_cells(tmp_path / "a.sqlite", document, cells, 2,
                               lambda levels, replicate: {"error_deg": levels["latency_ms"] + replicate}))
    (pid, mpc) = results.cells("error_deg", ["controller"])
    assert (pid.units, pid.runs, pid.value) == (3, 6, pytest.approx(29.0 / 3.0 + 0.5))
    assert (mpc.units, mpc.runs, mpc.value) == (1, 2, 9.0)


def half_done(levels, replicate):
    if levels["controller"] == "mpc" and replicate < 2:
        return "the QP is infeasible"
    if replicate == 2:
        return None
    return {"error_deg": None if replicate == 3 else float(replicate)}


def test_runs_without_a_value_are_counted_and_are_no_part_of_it(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 6, half_done))
    pid, mpc = results.cells("error_deg", at={"latency_ms": 0})
    assert (pid.runs, pid.failed, pid.missing, pid.waiting, pid.planned) == (4, 0, 1, 1, 6)
    assert (mpc.runs, mpc.failed, mpc.missing, mpc.waiting, mpc.planned) == (2, 2, 1, 1, 6)
    assert (pid.value, mpc.value) == (2.5, 4.5)


def test_a_cell_without_any_value_has_none(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 2, lambda levels, replicate: "no patient"))
    cell = results.cells("error_deg")[0]
    assert (cell.failed, cell.runs, cell.units) == (2, 0, 0)
    assert all(math.isnan(each) for each in (cell.value, cell.sd, cell.low, cell.high))


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=some.lists(some.floats(0.0, 1e3), min_size=2, max_size=6), path=some.sampled_from([
    "joint_rmse_deg", "joints.MCP.joint_rmse_deg:mean", "split_rmse_deg.tracker?", "charge_uc",
    "wrist_extension_deg", "not.defined"]))
def test_an_interval_ends_at_zero_where_the_metric_cannot_be_negative(tmp_path_factory, values, path):
    """It is Student's, less what no true value can be in: it holds a true value of 0 or more as often."""
    store = tmp_path_factory.mktemp("stores") / "a.sqlite"
    study = {"study": {"name": "a", "design": "grid", "metrics": {"e": path}}}
    results = load(write_store(store, {"latency_ms": [0]}, len(values),
                               lambda levels, replicate: {"e": values[replicate]}, ("e",), study))
    (cell,) = results.cells("e", statistic="mean")
    student = mean_interval(values, 0.95)
    never_negative = path.split(".")[0] in ("joint_rmse_deg", "joints", "split_rmse_deg", "charge_uc")
    expected = (max(student[0], 0.0) if never_negative and student[0] < 0.0 else student[0], student[1])
    assert (cell.low, cell.high) == pytest.approx(expected, nan_ok=True)


def test_one_replicate_gives_a_value_and_no_interval(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 1, lambda levels, replicate: {"error_deg": 2.0}))
    cell = results.cells("error_deg")[0]
    assert cell.value == 2.0
    assert all(math.isnan(each) for each in (cell.sd, cell.low, cell.high))


def test_an_infinite_value_is_no_reason_to_warn(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 3, lambda levels, replicate: {
        "error_deg": math.inf if replicate == 0 else 1.0}))
    assert results.cells("error_deg")[0].value == math.inf
    assert results.cells("error_deg", statistic="median")[0].value == 1.0


@pytest.mark.parametrize(("asked", "fault"), [
    ({"metric": "error"}, "error: is not a metric.*did you mean 'error_deg'"),
    ({"by": ["latency"]}, "latency: is not an axis of the study.*did you mean 'latency_ms'"),
    ({"at": {"law": "p"}}, "law: is not an axis"),
    ({"at": {"latency_ms": 30}}, "latency_ms = 30: is not a level.*allowed: 0, 20"),
    ({"at": {"controller": "lqr"}}, "controller = lqr: is not a level"),
    ({"statistic": "mode"}, "statistic: 'mode'"), ({"statistic": "share"}, "error_deg: is not a share"),
    ({"confidence": 95}, "confidence: 95")])
def test_what_the_study_does_not_have_is_named(results, asked, fault):
    with pytest.raises(InputError, match=fault):
        results.cells(**{"metric": "error_deg", **asked})


def test_a_level_may_be_named_by_fewer_digits_or_as_text(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"rate": [100.0 / 3.0, 50.0]}, 1,
                               lambda levels, replicate: {"error_deg": levels["rate"]}))
    assert results.cells("error_deg", [], at={"rate": 33.333333})[0].value == 100.0 / 3.0
    assert results.cells("error_deg", [], at={"rate": "50"})[0].value == 50.0


def test_a_summary_has_a_row_a_cell_or_one_a_level(results):
    assert [row.levels for row in results.summary()] == [cell.levels for cell in results.cells("held")]
    rows = results.summary(most=3)
    assert [row.levels for row in rows] == [{"latency_ms": 0}, {"latency_ms": 20}, {"controller": "pid"},
                                            {"controller": "mpc"}]
    assert (rows[0].planned, rows[0].failed, rows[0].waiting) == (16, 0, 0)
    assert rows[3].metrics["error_deg"] == results.cells("error_deg", ["controller"])[1]


def of_patients(levels, replicate):
    """Patients differ by much, a patient's repetitions by little."""
    patient = np.random.default_rng([levels["study"], levels["member"]]).normal(0.0, 2.0)
    noise = np.random.default_rng([levels["study"], levels["member"], replicate, 1]).normal(0.0, 0.3)
    return {"error_deg": 5.0 + patient + noise}


def of_seeds(levels, replicate):
    """What a seed does, it does at every latency; latencies differ too, but they were chosen."""
    common = np.random.default_rng([levels["study"], replicate]).normal(0.0, 2.0)
    noise = np.random.default_rng([levels["study"], levels["member"], replicate, 1]).normal(0.0, 0.3)
    return {"error_deg": 5.0 + common + noise + 10.0 * (levels["member"] - 2.5)}


@pytest.mark.slow
@pytest.mark.parametrize(("cohort", "outcome", "units"), [
    ({"patient": "sci_c6", "members": 6}, of_patients, 6), (None, of_seeds, 4)])
def test_what_is_repeated_covers_the_truth_at_its_rate_and_runs_by_themselves_do_not(
    tmp_path, cohort, outcome, units
):
    """300 studies of six patients, or of six latencies, with four replicates each."""
    axes = {"study": list(range(300)), "member": {"levels": list(range(6)), "cohort": cohort}}
    results = load(write_store(tmp_path / "a.sqlite", axes, 4, outcome))
    cells = results.cells("error_deg", ["study"], confidence=0.9)
    assert {cell.units for cell in cells} == {units}
    held = np.mean([cell.low <= 5.0 <= cell.high for cell in cells])
    assert held == pytest.approx(0.9, abs=4.0 * math.sqrt(0.09 / 300))
    values = results.table()["error_deg"].reshape(300, 6, 4)
    if cohort is None:
        values = values - 10.0 * (np.arange(6) - 2.5)[:, np.newaxis]
    alone = [st.t.interval(0.9, 23, each.mean(), st.sem(each, axis=None)) for each in values]
    assert np.mean([low <= 5.0 <= high for low, high in alone]) < 0.75


def test_a_study_without_axes_is_one_cell(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {}, 3, lambda levels, replicate: {
        "error_deg": float(replicate)}))
    (cell,) = results.cells("error_deg")
    assert (cell.levels, cell.runs, cell.value) == ({}, 3, 1.0)
    assert [row.levels for row in results.summary()] == [{}]
    assert results.table()["error_deg"].tolist() == [0.0, 1.0, 2.0]


def test_a_study_that_is_not_planned_yet_has_nothing(tmp_path):
    document = {"study": {"metrics": {"error_deg": "x"}}}
    results = load(write_cells(tmp_path / "a.sqlite", document, [], 1, None))
    assert (results.planned, results.axes, results.cells("error_deg"), results.summary()) == (0, {}, [], [])


def test_bins_of_another_metric_hold_the_runs_between_their_edges(results):
    edges = [4.0, 5.0, 6.0]
    binned = results.binned("held", over="error_deg", edges=edges, at={"controller": "mpc"})
    assert [row.levels for row in binned] == [{"error_deg": "4 to 5"}, {"error_deg": "5 to 6"}]
    for row, low in zip(binned, edges, strict=False):
        inside = (ERRORS[:, 1] >= low) & (ERRORS[:, 1] < low + 1.0)
        held = np.arange(8) < 6
        assert row.runs == inside.sum()
        assert row.units == inside.any(axis=0).sum()
        assert row.value == pytest.approx(held[inside.any(axis=0)].mean())
        assert row.statistic == "share"


@pytest.mark.parametrize(("over", "edges", "match"), [
    ("error_deg", [1.0], "edges"), ("error_deg", [1.0, 1.0], "edges"), ("nothing", [0.0, 1.0], "nothing"),
    ("held", [0.0, 1.0], "the metric itself")])
def test_bins_that_cannot_be_are_named(results, over, edges, match):
    with pytest.raises(InputError, match=match):
        results.binned("held", over=over, edges=edges)

import csv
import math

import numpy as np
import pytest
from study_stores import change, write_store

from fesloop.analysis.study import load
from fesloop.errors import InputError

AXES = {"latency_ms": [40, 0, 20], "controller": ["pid", "mpc"]}


def outcome(levels, replicate):
    if levels["latency_ms"] == 40 and levels["controller"] == "pid" and replicate == 1:
        return "the QP is infeasible"
    if levels["latency_ms"] == 20 and replicate == 1:
        return None
    held = None if levels["latency_ms"] == 0 else True
    return {"error_deg": 0.1 * levels["latency_ms"] + replicate / 3.0, "held": held}


@pytest.fixture
def store(tmp_path):
    return write_store(tmp_path / "study.sqlite", AXES, 2, outcome, ("error_deg", "held"))


def test_a_table_has_one_row_for_each_run_that_is_over(store):
    results = load(store)
    assert (results.planned, results.finished) == (12, 10)
    table = results.table()
    assert list(table) == ["cell", "latency_ms", "controller", "replicate", "seed", "id", "status", "cause",
                           "error_deg", "held", "wall_s", "recording"]
    assert {len(column) for column in table.values()} == {10}
    first = {name: column[0] for name, column in table.items()}
    assert (first["latency_ms"], first["controller"], first["seed"]) == (40.0, "pid", 1)
    assert first["status"] == "done"
    assert (first["error_deg"], first["held"], first["wall_s"]) == (4.0, 1.0, 0.2)


def test_numbers_ascend_on_an_axis_and_text_keeps_its_order(store):
    assert load(store).axes == {"latency_ms": (0.0, 20.0, 40.0), "controller": ("pid", "mpc")}


def test_an_axis_of_switches_and_text_is_text(tmp_path):
    store = write_store(tmp_path / "a.sqlite", {"drift": [True, False], "law": ["p", 2]}, 1,
                        lambda levels, replicate: {"error_deg": 1})
    assert load(store).axes == {"drift": ("true", "false"), "law": ("p", "2")}


def test_a_folder_stands_for_its_store(store):
    assert load(store.parent).digest() == load(str(store)).digest()


def test_a_failed_run_is_a_row_with_its_cause_and_no_numbers(store):
    results = load(store)
    table = results.table()
    failed = table["status"] == "failed"
    assert table["cause"][failed].tolist() == ["the QP is infeasible"]
    assert np.isnan(table["error_deg"][failed]).all()
    assert results.failures() == {"the QP is infeasible": 1}


def test_a_metric_that_a_run_does_not_have_is_not_a_number(store):
    table = load(store).table()
    none = table["latency_ms"] == 0.0
    assert np.isnan(table["held"][none]).all()
    assert np.isfinite(table["error_deg"][none]).all()


def test_cells_may_share_a_run(store):
    change(store, "UPDATE runs SET id = 'run 0 0' WHERE cell = 2 AND replicate = 0")
    table = load(store).table()
    assert table["error_deg"][(table["latency_ms"] == 0.0) & (table["controller"] == "pid")].tolist() == [
        4.0, 1.0 / 3.0]


def test_a_study_of_which_nothing_is_over_is_empty(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 2, lambda levels, replicate: None))
    assert results.finished == 0
    assert results.metrics == ("error_deg",)
    assert all(len(column) == 0 for column in results.table().values())


def test_csv_reads_back_as_the_same_numbers(store, tmp_path):
    load(store).to_csv(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    table = load(store).table()
    assert len(rows) == 10
    assert rows[1]["error_deg"] == ""
    assert rows[1]["cause"] == "the QP is infeasible"
    read = [float(row["error_deg"] or "nan") for row in rows]
    assert np.array_equal(read, table["error_deg"], equal_nan=True)


def test_parquet_and_pandas_hold_the_same_table(store, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    load(store).to_parquet(tmp_path / "table.parquet")
    read = pandas.read_parquet(tmp_path / "table.parquet")
    frame = load(store).frame()
    pandas.testing.assert_frame_equal(read, frame, check_dtype=False)
    assert read["seed"].dtype == np.int64
    assert math.isnan(read["error_deg"][1])


@pytest.mark.parametrize(("module", "use"), [
    ("pandas", lambda results, path: results.frame()),
    ("pyarrow", lambda results, path: results.to_parquet(path / "table.parquet"))])
def test_what_needs_an_extra_names_it(store, tmp_path, monkeypatch, module, use):
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(InputError, match=rf"{module}: is not installed.*fesloop\[study\]"):
        use(load(store), tmp_path)


def test_a_table_that_cannot_be_written_is_refused(store, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        load(store).to_csv(tmp_path / "taken" / "table.csv")


def test_an_axis_may_not_have_the_name_of_a_metric(tmp_path):
    store = write_store(tmp_path / "a.sqlite", {"error_deg": [1, 2]}, 1,
                        lambda levels, replicate: {"error_deg": 1})
    with pytest.raises(InputError, match="two columns"):
        load(store).table()


def test_the_digest_knows_no_order_and_no_wall_clock(store, tmp_path):
    other = write_store(tmp_path / "other.sqlite", AXES, 2, outcome, ("error_deg", "held"),
                        order=lambda row: row[0][::-1])
    change(other, "UPDATE results SET wall_s = 9.0, worker = 'w7', finished = 'later', recording = 'a.h5'")
    change(other, "UPDATE about SET value = 'later' WHERE key = 'created'")
    assert load(other).digest() == load(store).digest()


@pytest.mark.parametrize("statement", [
    "UPDATE results SET metrics = '{\"error_deg\": 4.000000000000001, \"held\": true}' WHERE id = 'run 0 0'",
    "UPDATE results SET cause = 'else' WHERE status = 'failed'",
    "DELETE FROM results WHERE id = 'run 3 0'",
    "UPDATE runs SET id = 'run 0 0' WHERE cell = 1 AND replicate = 0"])
def test_the_digest_knows_everything_else(store, statement):
    before = load(store).digest()
    assert change(store, statement) == 1
    assert load(store).digest() != before

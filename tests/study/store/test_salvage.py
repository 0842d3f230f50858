"""What is left of a store: all of a whole one, and of a broken one what is not broken."""

import sqlite3
from contextlib import closing

import pytest
from study_stores import write_store

from fesloop.analysis.study import study_of
from fesloop.analysis.study.design.cells import cells_of
from fesloop.analysis.study.design.plan import PlannedCell, PlannedRun
from fesloop.analysis.study.store.reading import read_store
from fesloop.analysis.study.store.salvage import salvaged
from fesloop.analysis.study.store.writing import Store, StoredResult
from fesloop.errors import InputError

RUNS = 600


@pytest.fixture
def store(tmp_path):
    """A store by its own writer, of RUNS runs."""
    about = {"name": "s", "experiment": "linear_loop", "metrics": {"rms_deg": "joint_rmse_deg"},
             "replicates": 20}
    study = study_of({"study": about, "axes": {"latency_ms": {"values": list(range(RUNS // 20))}}})
    with Store(tmp_path, study) as opened:
        planned = [PlannedCell(cell, "{}", tuple(
            PlannedRun(cell.number, replicate, 1 + replicate, f"{cell.number:032d}{replicate:032d}")
            for replicate in range(20)), 1.0) for cell in cells_of(study)]
        opened.put_plan(planned)
        opened.put([StoredResult(id=run.id, status="done", cause="", metrics={"rms_deg": float(run.cell)},
                                 wall_s=0.1, worker="w0") for each in planned for run in each.runs])
        return opened.path


def test_of_a_whole_store_nothing_is_lost(store):
    found, whole = salvaged(store), read_store(store)
    assert found.lost == []
    assert (found.rows.about, found.rows.cells, found.rows.runs) == (whole.about, whole.cells, whole.runs)
    assert sorted(found.rows.results) == sorted(whole.results)


def test_results_beyond_a_page_that_is_gone_are_found(store):
    """Of the last table written one page in the middle is wiped: only what stood on it is lost."""
    content = bytearray(store.read_bytes())
    at = content.index(f"{15:032d}{0:032d}".encode(), len(content) // 2) // 4096 * 4096
    content[at:at + 4096] = bytes(4096)
    store.write_bytes(bytes(content))
    found = salvaged(store)
    ids = {row[0] for row in found.rows.results}
    assert f"{29:032d}{19:032d}" in ids
    assert RUNS - 40 < len(ids) < RUNS
    assert any("`results`" in text for text in found.lost)


def test_a_store_that_was_cut_keeps_its_beginning(store):
    content = store.read_bytes()
    store.write_bytes(content[:int(0.9 * len(content))])
    found = salvaged(store)
    assert found.rows.about["name"] == "s"
    assert len(found.rows.results) > RUNS // 4
    assert any("It was cut short" in text for text in found.lost)


def test_text_that_is_none_is_replaced(tmp_path):
    path = write_store(tmp_path / "a.sqlite", {"law": ["pid"]}, 1, lambda levels, replicate: "why")
    with closing(sqlite3.connect(path)) as opened, opened:
        opened.execute("UPDATE results SET cause = CAST(X'ff41' AS TEXT)")
    (result,) = salvaged(path).rows.results
    assert result[2] == "�A"


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0", b"text"])
def test_what_is_no_store_is_told_in_one_line(tmp_path, content):
    path = tmp_path / "a.sqlite"
    path.write_bytes(content)
    with pytest.raises(InputError) as fault:
        salvaged(path)
    assert "\n" not in str(fault.value)

"""Who made the results of a store."""

import json
import sqlite3
from contextlib import closing

import pytest
from study_stores import change, write_store

from fesloop.analysis.study.store.reading import provenance_of
from fesloop.errors import InputError


def write(path):
    path = write_store(path, {"law": ["pid", "mpc"]}, 3, lambda levels, replicate:
                       {"error_deg": 1.0} if replicate < 2 else None)
    change(path, "INSERT INTO versions VALUES (0, ?), (1, ?)", json.dumps({"fesloop": "0.1"}),
           json.dumps({"fesloop": "0.2", "numpy": "2.4"}))
    change(path, "UPDATE results SET worker = 'w1', finished = '2026-01-02', version = 0 "
                 "WHERE id = 'run 1 1'")
    return path


def test_versions_are_told_with_how_many_results_each_made(tmp_path):
    found = provenance_of(write(tmp_path / "a.sqlite"))
    assert found.versions == (({"fesloop": "0.1"}, 1), ({"fesloop": "0.2", "numpy": "2.4"}, 3))
    assert (found.first, found.last, found.workers) == ("2026-01-01", "2026-01-02", 2)


def test_a_store_in_which_nothing_has_come_yet(tmp_path):
    path = write_store(tmp_path / "a.sqlite", {"law": ["pid"]}, 1, lambda levels, replicate: None)
    found = provenance_of(path)
    assert (found.versions, found.first, found.last, found.workers) == ((), "", "", 0)


def test_tables_that_do_not_tell_are_said(tmp_path):
    path = write(tmp_path / "a.sqlite")
    with closing(sqlite3.connect(path)) as store, store:
        store.execute("DROP TABLE versions")
    with pytest.raises(InputError, match="which versions"):
        provenance_of(path)

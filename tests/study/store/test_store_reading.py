import contextlib
import json
import signal
import sqlite3
import subprocess
import sys
import threading
from contextlib import closing

import pytest
import study_stores
from study_stores import write_store

from fesloop.analysis.study import load
from fesloop.analysis.study.store import file as store_file
from fesloop.analysis.study.store import reading as store_reading
from fesloop.errors import InputError

AXES = {"latency_ms": [0, 20]}


def columns_of(tables):
    with closing(sqlite3.connect(":memory:")) as file:
        file.executescript(tables)
        return {name: [column[1:3] for column in file.execute(f"PRAGMA table_info({name})")]
                for name in ("about", "cells", "runs", "results")}


def test_made_up_stores_are_like_those_of_studies():
    made_up, written = columns_of(study_stores.TABLES), columns_of(store_file.TABLES)
    for name, columns in made_up.items():
        assert written[name][:len(columns)] == columns


@pytest.fixture
def store(tmp_path):
    return write_store(tmp_path / "study.sqlite", AXES, 2, lambda levels, replicate: {"error_deg": 1.0})


def test_what_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.sqlite: does not exist"):
        load(tmp_path / "none.sqlite")
    with pytest.raises(InputError, match=r"holds no study\.sqlite"):
        load(tmp_path)


def foreign(path):
    with closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE about_birds (name TEXT)")


def text(path):
    path.write_text("latency, error\n" * 100)


def shape_of_table(path):
    with closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE about (name TEXT)")


@pytest.mark.parametrize(("write", "fault"), [
    (foreign, "is an SQLite file, but not a study's store"), (text, "is not an SQLite file"),
    (lambda path: path.touch(), "is an SQLite file, but not a study's store"),
    (shape_of_table, "is damaged: no such column")])
def test_a_file_of_something_else_is_refused(tmp_path, write, fault):
    write(tmp_path / "a.sqlite")
    with pytest.raises(InputError, match=rf"a\.sqlite: {fault}"):
        load(tmp_path / "a.sqlite")


@pytest.mark.parametrize(("statement", "fault"), [
    ("UPDATE about SET value = 'fesloop study 9' WHERE key = 'format'",
     "is of the format 'fesloop study 9'; allowed: 'fesloop study 2'; read it with the version"),
    ("DELETE FROM about", "is of the format None"),
    ("UPDATE about SET value = '[1' WHERE key = 'study'", "does not say which study"),
    ("UPDATE about SET value = '[1]' WHERE key = 'study'", "does not say which study"),
    ("DELETE FROM about WHERE key = 'study'", "does not say which study"),
    ("UPDATE cells SET levels = '{}' WHERE cell = 1", "contradict each other"),
    ("UPDATE cells SET levels = '{\"lat' WHERE cell = 1", "contradict each other"),
    ("DELETE FROM cells WHERE cell = 1", "contradict each other"),
    ("UPDATE results SET status = 'perhaps'", "contradict each other.*perhaps"),
    ("UPDATE results SET metrics = '[1, 2]'", "contradict each other"),
    ("UPDATE results SET metrics = '{\"error_deg\": \"big\"}'", "contradict each other"),
    ("UPDATE runs SET seed = 'x' WHERE cell = 1", "contradict each other")])
def test_a_store_whose_rows_make_no_study_or_one_of_another_version_is_refused_in_one_line(
        store, statement, fault):
    study_stores.change(store, statement)
    with pytest.raises(InputError, match=fault) as raised:
        load(store)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("statement", [
    "DELETE FROM results WHERE id = 'run 0 1'", "DELETE FROM runs WHERE cell = 1", "DELETE FROM results",
    "UPDATE cells SET levels = '{\"latency_ms\": 30}' WHERE cell = 1", "DELETE FROM checksum",
    "UPDATE results SET metrics = '{\"error_deg\": 1.0000000000000002}' WHERE id = 'run 0 0'",
    "UPDATE results SET metrics = (SELECT metrics FROM results WHERE id = 'run 1 0') WHERE id = 'run 0 0'",
    "UPDATE runs SET id = 'run 0 0' WHERE cell = 1", "UPDATE runs SET seed = 7 WHERE cell = 1",
    "INSERT INTO results VALUES ('run 2 0', 'done', '', '{}', 0.1, 'w', '', 0, '')",
    "UPDATE results SET wall_s = 0.3 WHERE id = 'run 0 0'", "UPDATE checksum SET value = '00'"])
def test_a_row_that_was_changed_lost_or_added_is_one_line(store, statement):
    """Reading it all the same takes a word; what is then read is what stands there."""
    study_stores.change(store, "UPDATE results SET metrics = '{\"error_deg\": 2.0}' WHERE id = 'run 1 0'")
    load(store)
    with closing(sqlite3.connect(store)) as file, file:
        assert file.execute(statement).rowcount
    with pytest.raises(InputError, match="is damaged: its rows are not those that fesloop wrote") as raised:
        load(store)
    assert "\n" not in str(raised.value)
    assert load(store, check=False).axes.keys() == AXES.keys()


def test_a_store_without_one_of_its_tables_is_refused(store):
    with closing(sqlite3.connect(store)) as file, file:
        file.execute("DROP TABLE results")
    with pytest.raises(InputError, match="there is no table results"):
        load(store)


def test_a_schema_with_a_byte_that_is_no_text_is_refused_or_read(store):
    sound = store.read_bytes()
    first, last = sound.index(b"CREATE TABLE"), sound.rindex(b"CREATE TABLE") + 60
    for at in range(first, last, 3):
        store.write_bytes(sound[:at] + b"\x80" + sound[at + 1:])
        with contextlib.suppress(InputError):
            load(store)


def test_a_store_that_lacks_its_end_is_refused(store):
    store.write_bytes(store.read_bytes()[:4096])
    with pytest.raises(InputError, match="is damaged"):
        load(store)


def add_cell(file, number):
    """A cell, its run and its result in one commit."""
    file.execute("BEGIN IMMEDIATE")
    file.execute("INSERT INTO cells VALUES (?, ?, '', '[]')", (number, json.dumps({"latency_ms": number})))
    file.execute("INSERT INTO runs VALUES (?, 0, 1, ?)", (number, f"id {number}"))
    file.execute("INSERT INTO results VALUES (?, 'done', NULL, ?, 0, '', '', 1, NULL)",
                 (f"id {number}", json.dumps({"error_deg": number})))
    study_stores.seal(file)
    file.execute("COMMIT")


def test_what_is_written_between_two_tables_is_not_read(store, monkeypatch):
    class Disturbed(dict):
        def items(self):
            for number, item in enumerate(super().items()):
                yield item
                file = sqlite3.connect(store, timeout=0.0, isolation_level=None)
                with closing(file), contextlib.suppress(sqlite3.OperationalError):
                    file.execute(f"INSERT INTO versions VALUES ({number}, 'a{number}')")

    monkeypatch.setattr(store_file, "CHECKED", Disturbed(store_file.CHECKED))
    results = load(store)
    assert (results.planned, results.finished, results.axes) == (4, 4, {"latency_ms": (0, 20)})


def test_a_store_is_read_as_it_is_at_one_instant_while_it_is_written(tmp_path):
    """Every commit adds a cell, its run and its result at once: whoever reads sees all three or none."""
    path = write_store(tmp_path / "study.sqlite", {"latency_ms": [-1]}, 1, lambda *_: {"error_deg": -1.0})
    over, fault = threading.Event(), []

    def write():
        try:
            with closing(sqlite3.connect(path, timeout=30.0, isolation_level=None)) as file:
                for number in range(1, 40):
                    add_cell(file, number)
        except sqlite3.Error as found:
            fault.append(found)
        over.set()

    writer = threading.Thread(target=write)
    writer.start()
    seen = []
    while not over.is_set():
        results = load(path)
        table = results.table()
        assert results.finished == results.planned == len(results.axes["latency_ms"])
        assert table["latency_ms"].tolist() == table["error_deg"].tolist()
        seen.append(results.finished)
    writer.join()
    assert fault == []
    assert seen == sorted(seen)
    assert load(path).finished == 40


KILLED = """
import os, signal, sqlite3, sys
file = sqlite3.connect(sys.argv[1], isolation_level=None)
file.execute("PRAGMA cache_size = 1")
file.execute("BEGIN IMMEDIATE")
file.execute("UPDATE results SET cause = 'half a commit'")
file.executemany("INSERT INTO results VALUES (?, 'failed', ?, NULL, 0, '', '', 1, NULL)",
                 [(f"more {i}", "x" * 500) for i in range(2000)])
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def killed(store):
    """A store whose writer was killed after pages had gone to the file, before it committed."""
    before = store.read_bytes()
    done = subprocess.run([sys.executable, "-c", KILLED, str(store)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert store.with_name("study.sqlite-journal").stat().st_size > 0
    assert store.read_bytes() != before
    return store


def test_what_a_killed_writer_had_not_committed_is_rolled_back(killed):
    table = load(killed).table()
    assert len(table["cause"]) == 4
    assert set(table["cause"]) == {""}


def test_where_nothing_may_be_written_it_cannot_be_rolled_back_and_says_so(killed, monkeypatch):
    """As SQLite has it where it may not write: whoever reads the store opens it read-only, every time."""
    connect = sqlite3.connect
    monkeypatch.setattr(store_reading.sqlite3, "connect", lambda address, **given: connect(
        address.replace("mode=rw", "mode=ro"), **given))
    with pytest.raises(InputError, match=r"killed within a commit.*together with study\.sqlite-journal"):
        load(killed)


def test_a_store_that_stays_locked_is_refused(store, monkeypatch):
    monkeypatch.setattr(store_reading, "_BUSY_S", 0.1)
    with closing(sqlite3.connect(store, isolation_level=None)) as file:
        file.execute("BEGIN EXCLUSIVE")
        with pytest.raises(InputError, match="stayed locked"):
            load(store)

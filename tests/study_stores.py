"""Made-up stores of studies, written by plain SQL as the contract of the store says."""

import json
import sqlite3
from contextlib import closing
from itertools import product

from fesloop.analysis.study.store.file import FORMAT, checked_rows, checksum

TABLES = """
CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT);
CREATE TABLE cells (cell INTEGER PRIMARY KEY, levels TEXT, experiment TEXT, settings TEXT);
CREATE TABLE runs (cell INTEGER, replicate INTEGER, seed INTEGER, id TEXT, PRIMARY KEY (cell, replicate));
CREATE TABLE results (id TEXT PRIMARY KEY, status TEXT, cause TEXT, metrics TEXT, wall_s REAL, worker TEXT,
                      finished TEXT, version INTEGER, recording TEXT);
CREATE TABLE versions (version INTEGER PRIMARY KEY, text TEXT);
CREATE TABLE prepared (id TEXT PRIMARY KEY, key TEXT, status TEXT, cause TEXT, content TEXT);
CREATE TABLE checksum (value TEXT);
"""


def change(path, statement, *values):
    """Change a store as its writer would: its checksum is that of its rows. The number of changed rows."""
    with closing(sqlite3.connect(path)) as store, store:
        count = store.execute(statement, values).rowcount
        seal(store)
    return count


def seal(store):
    store.execute("DELETE FROM checksum")
    store.execute("INSERT INTO checksum VALUES (?)", (checksum(checked_rows(store)),))


def write_store(path, axes, replicates, outcome, metrics=("error_deg",), study=None, design="grid",
                order=None):
    """A store over the grid of `axes` (name: levels, or a table of a study file whose key `levels` is that).

    `outcome(levels, replicate)` gives the metrics of a run, a cause (text) for one that failed, None for one
    that is not over. `order` sorts the results as they are written.
    """
    tables = {name: given if isinstance(given, dict) else {"levels": given} for name, given in axes.items()}
    document = {"study": {"name": path.stem, "design": design, "metrics": dict.fromkeys(metrics, "x")},
                "axes": {name: {key: item for key, item in table.items() if key != "levels"}
                         for name, table in tables.items()}, **(study or {})}
    cells = [dict(zip(tables, levels, strict=True))
             for levels in product(*(table["levels"] for table in tables.values()))]
    return write_cells(path, document, cells, replicates, outcome, order)


def write_cells(path, document, cells, replicates, outcome, order=None):
    """A store of these cells (levels by axis)."""
    about = {"format": FORMAT, "name": path.stem, "form": "", "study": json.dumps(document),
             "created": "2026-01-01T00:00:00+00:00"}
    runs, results = [], []
    for cell, levels in enumerate(cells):
        for replicate in range(replicates):
            id_ = f"run {cell} {replicate}"
            runs.append((cell, replicate, 1 + replicate, id_))
            found = outcome(levels, replicate)
            if found is not None:
                done = isinstance(found, dict)
                results.append((id_, "done" if done else "failed", None if done else found,
                                json.dumps(found) if done else None, 0.2, "w0", "2026-01-01", 1, None))
    with closing(sqlite3.connect(path)) as store, store:
        store.executescript(TABLES)
        store.executemany("INSERT INTO about VALUES (?, ?)", about.items())
        store.executemany("INSERT INTO cells VALUES (?, ?, '', '[]')",
                          [(cell, json.dumps(levels)) for cell, levels in enumerate(cells)])
        store.executemany("INSERT INTO runs VALUES (?, ?, ?, ?)", runs)
        store.executemany("INSERT INTO results VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                          sorted(results, key=order) if order else results)
        seal(store)
    return path

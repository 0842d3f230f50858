"""Recordings made up from the form of the file alone, for tests of what is written from them."""

import json
import shutil
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from hypothesis import strategies as st

BLOCK, PLANT, INPUT = "blocks", "plants", "inputs"
_STAMPS = {BLOCK: ("index", "time_ns", "left_ns", "oldest_ns", "newest_ns"),
           PLANT: ("time_ns", "captured_ns"), INPUT: ("time_ns", "oldest_ns", "newest_ns")}
EVENT = np.dtype([("trial", "<i4"), ("time_ns", "<i8"), ("where", "S64"), ("status", "S32"),
                  ("detail", "S224")])

MESSAGES = np.dtype([("trial", "<i4"), ("wire", "<i4"), ("sent", "<i8"), ("lost", "<i8"), ("late", "<i8")])


@dataclass
class Node:
    """A node's rows: ports {name: (unit, shape)}; a stamp array and values {port: array} a trial."""

    name: str
    kind: str
    ports: dict
    trials: list = field(default_factory=list)

    def add(self, times_ns, values, **stamps):
        """Rows of the next trial; stamps not given are the times."""
        times = np.asarray(times_ns, np.int64)
        told = dict.fromkeys(_STAMPS[self.kind], times) | {"index": np.arange(len(times))} | stamps
        self.trials.append((told, values))
        return self


def write_run(path, nodes, events=(), parameters=None, name="made_up", killed=False):
    """A recording of these nodes; `killed`: as the file of a run that was killed lies on its disk."""
    path.parent.mkdir(parents=True, exist_ok=True)
    open_path = path.with_suffix(".open") if killed else path
    file = h5py.File(open_path, "w", libver="latest")
    blocks = {node.name: {"kind": "made_up"} for node in nodes}
    blocks |= {node: {"kind": "made_up"} | table for node, table in (parameters or {}).items()}
    file.attrs.update({"format": "fesloop recording 1", "name": name, "seed": 7, "fingerprint": "f" * 64,
                       "versions": json.dumps({"fesloop": "0.1.0"}), "wires": "[]"})
    file.create_dataset("experiment", data=json.dumps({
        "experiment": {"name": name, "description": "made up", "trials": 1, "seed": 7}, "blocks": blocks,
        "wires": []}))
    file.create_dataset("status", data=np.array(b"running" if killed else b"done", "S16"))
    wall = file.create_group("wall")
    wall.attrs["started"] = "2026-11-21T10:00:00+00:00"
    for kind in _STAMPS:
        file.create_group(kind)
    for node in nodes:
        _write_node(file, node)
    rows = np.array(list(events), EVENT) if events else np.empty(0, EVENT)
    file.create_dataset("events", data=rows, maxshape=(None,))
    file.create_dataset("messages", shape=(0,), maxshape=(None,), dtype=MESSAGES)
    if killed:
        file.swmr_mode = True
        file.flush()
        shutil.copy(open_path, path)
    file.close()
    return path


def _write_node(file, node):
    stamps = [("trial", "<i4"), *((name, "<i8") for name in _STAMPS[node.kind])]
    if node.kind == INPUT:
        ((port, (unit, shape)),) = node.ports.items()
        place, units, fields = f"{node.kind}/{node.name}/{port}", {"value": unit}, {port: "value"}
        dtype = np.dtype([*stamps, ("value", "<f8", shape)])
    else:
        place, fields = f"{node.kind}/{node.name}", {port: port for port in node.ports}
        units = {port: unit for port, (unit, _) in node.ports.items()}
        dtype = np.dtype([*stamps, *((port, "<f8", shape) for port, (_, shape) in node.ports.items())])
    tables = []
    for trial, (told, values) in enumerate(node.trials):
        table = np.zeros(len(told["time_ns"]), dtype)
        table["trial"] = trial
        for name in _STAMPS[node.kind]:
            table[name] = told[name]
        for port, array in values.items():
            table[fields[port]] = array
        tables.append(table)
    rows = np.concatenate(tables) if tables else np.zeros(0, dtype)
    dataset = file.create_dataset(place, data=rows, maxshape=(None,), chunks=(64,))
    dataset.attrs["units"] = json.dumps(units)


def times(rows, rate_hz=100.0):
    """Instants of a clock, ns."""
    return (np.arange(rows) * (1e9 / rate_hz)).astype(np.int64)


def any_floats(rng, shape, finite=False):
    """Numbers of every size, some of them NaN."""
    values = rng.integers(0, 2**64, shape, np.uint64, endpoint=False).view(np.float64)
    values = np.where(np.isinf(values), 0.0, values)
    return np.where(np.isnan(values), -0.0, values) if finite else values


NAMES = st.text(st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="./"), min_size=1,
                max_size=12).filter(lambda name: name.strip())
PORTS = st.text("abcdefgxyz_0123456789", min_size=1, max_size=8)
UNITS = st.sampled_from(("1", "rad", "rad/s", "m/s^2", "T", "m", "N", "A,s"))
SHAPES = st.sampled_from(((), (1,), (3,), (5,), (2, 2), (2, 3), (3, 4), (2, 2, 2)))


@st.composite
def runs(draw, kinds=(BLOCK, PLANT, INPUT), shapes=SHAPES, units=UNITS, ports=PORTS, finite=False):
    """Nodes of a made-up run, and its events."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    trials = draw(st.integers(1, 3))
    nodes = []
    names = draw(st.lists(NAMES, min_size=1, max_size=3, unique_by=str.casefold))
    for name in names:
        kind = draw(st.sampled_from(kinds))
        most = 1 if kind == INPUT else 3
        chosen = draw(st.lists(ports, min_size=1, max_size=most, unique=True))
        node = Node(name, kind, {port: (draw(units), draw(shapes)) for port in chosen})
        for _ in range(trials):
            rows = draw(st.integers(1 if name == names[0] else 0, 40))  # every trial has some row
            instants = np.cumsum(rng.integers(1, 10**rng.integers(1, 12), rows))
            stamps = {key: instants - rng.integers(0, 10**6, rows) for key in _STAMPS[kind][-2:]
                      if key != "time_ns"}
            stamps = {key: np.maximum(value, -1) for key, value in stamps.items()}
            if kind == BLOCK:
                stamps["left_ns"] = instants + rng.integers(0, 10**6, rows)
            node.add(instants, {port: any_floats(rng, (rows, *shape), finite)
                                for port, (_, shape) in node.ports.items()}, **stamps)
        nodes.append(node)
    text = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=20)
    events = [(draw(st.integers(0, trials - 1)), draw(st.integers(0, 2**40)), names[0][:2].encode(),
               b"status", draw(text).encode()) for _ in range(draw(st.integers(0, 3)))]
    return nodes, sorted(events, key=lambda event: event[:2])


def same(found, told):
    """Equal bit for bit, NaN for NaN."""
    found, told = np.asarray(found), np.asarray(told)
    assert found.shape == told.shape
    plain = ~np.isnan(told)
    np.testing.assert_array_equal(np.isnan(found), ~plain)
    np.testing.assert_array_equal(found[plain].view(np.uint64), told[plain].view(np.uint64))


def fresh(folder):
    """A name that is free in a folder, for one example of many."""
    return Path(folder) / f"{len(list(Path(folder).iterdir()))}"

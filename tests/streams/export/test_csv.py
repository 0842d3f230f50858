"""CSV tables, as Python's and NumPy's readers have them, hold every number and stamp of a run."""

import csv

import numpy as np
import pytest
from export_parts import BLOCK, Node, runs, same, times, write_run
from hypothesis import HealthCheck, given, settings

from fesloop import Recording
from fesloop.experiment.export import export
from fesloop.streams.formats.layout import read_layout

STAMPS = ["index", "time [s]", "left [s]", "oldest capture [s]", "newest capture [s]"]


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:5] == STAMPS
    assert len(set(header)) == len(header)
    return header[5:], np.array(rows, float).reshape(-1, len(header))


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=runs())
def test_every_run_reads_back_exactly(made, tmp_path_factory):
    nodes, events = made
    folder = tmp_path_factory.mktemp("run")
    run = write_run(folder / "run.h5", nodes, events)
    out = export(run, "csv", folder / "out").path
    with Recording(run) as recording:
        for trial in range(recording.trials):
            prefix = "" if recording.trials == 1 else f"trial-{trial}_"
            tables = [read(path) for path in out.glob(f"{prefix}*.csv")
                      if not path.name.endswith("events.csv") or len(path.name) > len(prefix + "events.csv")]
            for name in recording.signals + recording.inputs:
                signal = recording.signal(name, trial)
                rows = len(signal.times_ns)
                values = signal.values.reshape(rows, int(np.prod(signal.values.shape[1:])))
                stamps = np.stack([signal.indices, signal.times_ns, signal.left_ns, signal.oldest_ns,
                                   signal.newest_ns], 1)
                assert any(_holds(names, table, name.partition(".")[2], values, stamps)
                           for names, table in tables)
            with (out / f"{prefix}events.csv").open(encoding="utf-8", newline="") as file:
                told = list(csv.reader(file))[1:]
            mine = [event for event in recording.events if event.trial == trial]
            assert told == [[f"{event.time_ns // 10**9}.{event.time_ns % 10**9:09d}", event.where,
                             event.status, event.detail] for event in mine]


def _holds(names, table, port, values, stamps):
    """Whether a table has a port's values and their stamps."""
    mine = [number for number, name in enumerate(names)
            if name.startswith((f"{port} [", f"{port}."))]
    found = table[:, 5:][:, mine]
    if found.shape != values.shape or not np.array_equal(found, values, equal_nan=True):
        return False
    same(found, values)
    back = np.rint(np.nan_to_num(table[:, 1:5], nan=-1e-9) * 1e9)
    return np.array_equal(np.column_stack([table[:, 0], back]), stamps)


def test_the_header_names_columns_and_their_units(tmp_path):
    nodes = [Node("pid", BLOCK, {"stimulation": ("A,s", (2, 2)), "level": ("1", ())}),
             Node("tracker", BLOCK, {"angles": ("rad", (23,))})]
    nodes[0].add(times(2), {"stimulation": np.zeros((2, 2, 2)), "level": np.zeros(2)})
    nodes[1].add(times(2), {"angles": np.zeros((2, 23))})
    out = export(write_run(tmp_path / "run.h5", nodes), "csv", tmp_path / "out").path
    names, _ = read(out / "pid.csv")
    assert names == ["stimulation.0.current [A]", "stimulation.0.width [s]", "stimulation.1.current [A]",
                     "stimulation.1.width [s]", "level [1]"]
    names, _ = read(out / "tracker.csv")
    assert names[7] == "angles.F2_mcp_flexion [rad]"
    assert sorted(path.name for path in out.iterdir()) == ["events.csv", "pid.csv", "tracker.csv"]


def test_what_was_never_captured_has_no_instant(tmp_path):
    node = Node("pid", BLOCK, {"angles": ("rad", (1,))})
    node.add(times(2), {"angles": np.zeros((2, 1))}, oldest_ns=np.array([-1, 5]),
             newest_ns=np.array([-1, 10**7]))
    run = write_run(tmp_path / "run.h5", [node])
    table = (export(run, "csv", tmp_path / "csv").path / "pid.csv").read_text().splitlines()
    assert table[1:] == ["0,0.000000000,0.000000000,nan,nan,0.0",
                         "1,0.010000000,0.010000000,0.000000005,0.010000000,0.0"]
    (table,) = (export(run, "motion-bids", tmp_path / "bids").path / "sub-01/motion").glob("*_motion.tsv")
    assert table.read_text().splitlines()[0].split("\t")[3:5] == ["n/a", "n/a"]


def worn(tmp_path, rows=50):
    """Two sensors at rest, as a plant or replay puts them out; a sample is lost."""
    rng = np.random.default_rng(6)
    node = Node("imus", BLOCK, {"gyr": ("rad/s", (2, 3)), "acc": ("m/s^2", (2, 3)), "mag": ("T", (2, 3))})
    values = {"gyr": 0.1 * rng.normal(size=(rows, 2, 3)), "mag": 3e-5 + 1e-6 * rng.normal(size=(rows, 2, 3)),
              "acc": [0.0, 0.0, 9.8] + 0.1 * rng.normal(size=(rows, 2, 3))}
    values["gyr"][7, 1] = np.nan
    node.add(times(rows, 2000 / 7), values)
    run = write_run(tmp_path / "run.h5", [node], parameters={"imus": {"sites": ["hand", "F2p"]}})
    return run, values, node.trials[0][0]["time_ns"]


def test_numpy_reads_gaps(tmp_path):
    run, values, _ = worn(tmp_path)
    path = export(run, "csv", tmp_path / "out").path / "imus.csv"
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    same(table[:, 5:11].reshape(-1, 2, 3), values["gyr"])
    same(table[:, 17:].reshape(-1, 2, 3), values["mag"])


def test_the_layout_beside_a_table_says_where_sensors_stand(tmp_path):
    run, _, _ = worn(tmp_path)
    out = export(run, "csv", tmp_path / "out").path
    read_back = read_layout(out / "imus.layout.toml")
    names, _ = read(out / "imus.csv")
    assert list(read_back.sensors) == ["hand", "F2p"]
    assert read_back.rate == "2000/7"
    for sensor in read_back.sensors.values():
        for place in (sensor.gyr, sensor.acc, sensor.mag):
            assert set(place) <= set(names)


def test_the_layout_gives_a_rate_only_where_it_gives_every_instant(tmp_path):
    """Ticks 1, 2, 3 at 300 Hz are 3333333, 6666666, 10000000 ns: from the first on, those of no clock."""
    ports = {"gyr": ("rad/s", (1, 3)), "acc": ("m/s^2", (1, 3))}
    values = {port: np.ones((30, 1, 3)) for port in ports}
    stated = []
    for first in (0, 1):
        instants = np.array([tick * 10**9 // 300 for tick in range(first, first + 30)])
        run = write_run(tmp_path / f"{first}.h5", [Node("imus", BLOCK, ports).add(instants, values)])
        layout = read_layout(export(run, "csv", tmp_path / f"{first}").path / "imus.layout.toml")
        stated.append((layout.rate, layout.time))
    assert stated == [("300", None), (None, "time [s]")]

"""Motion-BIDS datasets pass the validator, and hold every number and stamp of a run."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from export_parts import BLOCK, INPUT, PLANT, Node, runs, same, times, write_run
from hypothesis import HealthCheck, given, settings

from fesloop import InputError, Recording
from fesloop.experiment.export import export

MOTION = ("latency", "index", "left", "oldest", "newest")


def rows_of(path):
    return [line.split("\t") for line in path.read_text(encoding="utf-8").split("\n")[:-1]]


def table_of(path):
    """Columns by name, from a table's file and that of its channels."""
    channels = rows_of(path.with_name(path.name.replace("_motion.tsv", "_channels.tsv")))
    names = [row[0] for row in channels[1:]]
    assert len(set(names)) == len(names)
    rows = [[np.nan if cell == "n/a" else float(cell) for cell in row] for row in rows_of(path)]
    return dict(zip(names, np.array(rows).reshape(-1, len(names)).T, strict=True)), channels


def faults(folder):
    """What the validator finds wrong; every row is looked at."""
    validator = Path(sys.executable).with_name("bids-validator-deno")
    if not validator.exists():
        pytest.skip("bids-validator-deno is not installed, which pip install 'fesloop[test]' does")
    done = subprocess.run([validator, folder, "--format", "json", "--max-rows", "-1"], capture_output=True,
                          text=True, check=False)
    found = json.loads(done.stdout)["issues"]["issues"]
    return [(issue["code"], issue.get("location")) for issue in found if issue["severity"] == "error"]


def worn(rows=30, trials=1):
    """A run with everything that is motion, and more."""
    rng = np.random.default_rng(3)
    ports = {"imus": {"gyr": ("rad/s", (2, 3)), "acc": ("m/s^2", (2, 3)), "mag": ("T", (2, 3))},
             "a tracker": {"orientation": ("1", (2, 4)), "angles": ("rad", (23,)), "angle_sd": ("rad", (23,)),
                           "fingertips": ("m", (5, 3)), "velocity": ("m/s", (3,))}}
    nodes = [Node(name, BLOCK, each) for name, each in ports.items()]
    nodes.append(Node("hand", PLANT, {"object_position": ("m", (3,)), "contact_force": ("N", (5,))}))
    nodes.append(Node("hand", INPUT, {"forearm": ("1", (4,))}))
    for node in nodes:
        for _ in range(trials):
            values = {port: rng.normal(size=(rows, *shape)) for port, (_, shape) in node.ports.items()}
            for array in values.values():
                array[rows // 2] = np.nan
            node.add(times(rows, 50.0), values)
    return nodes


@pytest.mark.slow
def test_the_validator_passes_a_run_of_several_trials(tmp_path):
    events = [(0, 12, b"imus", b"lost", b"sensor\t1\nof 2"), (1, 3 * 10**9, b"a tracker", b"untracked", b"")]
    nodes = worn(trials=2)
    nodes.append(Node("late", BLOCK, {"angles": ("rad", (2,))}).add([], {}).add(times(3), {"angles": 1.0}))
    run = write_run(tmp_path / "run.h5", nodes, events, name="made up: grüße")
    exported = export(run, "motion-bids", tmp_path / "dataset")
    assert exported.notes == ("late, trial 0: no row, so no file",)
    assert faults(exported.path) == []
    shutil.rmtree(tmp_path / "dataset/sub-01/motion")
    assert faults(exported.path) != []


def test_channels_say_what_they_are(tmp_path):
    run = write_run(tmp_path / "run.h5", worn(), parameters={"imus": {"sites": ["hand", "F2p"]}})
    folder = export(run, "motion-bids", tmp_path / "dataset").path / "sub-01/motion"
    systems = {path.name.split("tracksys-")[1].removesuffix("_motion.tsv"): path
               for path in folder.glob("*_motion.tsv")}
    assert set(systems) == {"imus", "aTracker", "hand"}
    columns, channels = table_of(systems["imus"])
    by_name = {row[0]: row[1:6] for row in channels}
    assert list(columns)[:5] == list(MOTION)
    assert by_name["latency"] == ["n/a", "LATENCY", "n/a", "s", "n/a"]
    assert by_name["gyr.F2p.y"] == ["y", "GYRO", "F2p", "rad/s", "sensor"]
    assert by_name["acc.hand.x"] == ["x", "ACCEL", "hand", "m/s^2", "sensor"]
    assert by_name["mag.F2p.z"] == ["z", "MAGN", "F2p", "T", "sensor"]
    _, channels = table_of(systems["aTracker"])
    by_name = {row[0]: row[1:6] for row in channels}
    assert by_name["orientation.1.w"] == ["quat_w", "ORNT", "1", "n/a", "earth"]
    assert by_name["angles.F2_mcp_flexion"] == ["n/a", "JNTANG", "F2_mcp_flexion", "rad", "joint"]
    assert by_name["fingertips.F3.z"] == ["z", "POS", "F3", "m", "root"]
    assert by_name["velocity.x"] == ["x", "VEL", "velocity", "m/s", "earth"]
    assert not any(name.startswith("angle_sd") for name in by_name)
    told = json.loads(Path(str(systems["imus"]).replace(".tsv", ".json")).read_text())
    assert (told["SamplingFrequency"], told["MotionChannelCount"], told["GYROChannelCount"],
            told["MISCChannelCount"], told["TrackedPointsCount"]) == (50.0, 18, 6, 4, 2)
    levels = json.loads(Path(str(systems["imus"]).replace("motion.tsv", "channels.json")).read_text())
    assert {row[5] for row in channels[1:]} <= {"n/a", *levels["reference_frame"]["Levels"]}


@pytest.mark.slow
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=runs())
def test_every_number_and_stamp_reads_back_exactly(made, tmp_path_factory):
    nodes, events = made
    folder = tmp_path_factory.mktemp("run")
    run = write_run(folder / "run.h5", nodes, events)
    with Recording(run) as recording:
        names = recording.signals + recording.inputs
        dataset = export(run, "motion-bids", folder / "out", signals=names).path
        scans = rows_of(dataset / "sub-01/sub-01_scans.tsv")[1:]
        found = {}
        for scan in scans:
            columns, _ = table_of(dataset / "sub-01" / scan[0])
            found[int(scan[2]), scan[0]] = columns
        for name in names:
            for trial in range(recording.trials):
                signal = recording.signal(name, trial)
                rows = len(signal.times_ns)
                if rows:
                    _require_held(found, trial, signal, rows)
        stems = {path.name for path in (dataset / "sub-01/motion").glob("*_events.tsv")}
        assert len(stems) == len({event.trial for event in recording.events})


def bits(values):
    """Bits of numbers, all NaN alike."""
    return np.where(np.isnan(values), np.nan, values).view(np.uint64)


def _require_held(found, trial, signal, rows):
    """One of the tables of a trial has these values side by side, with their stamps."""
    values = signal.values.reshape(rows, -1)
    for (of, _), columns in found.items():
        table = np.stack(list(columns.values()), axis=1)
        if of != trial or len(table) != rows:
            continue
        for first in range(len(MOTION), table.shape[1] - values.shape[1] + 1):
            if np.array_equal(bits(table[:, first:first + values.shape[1]]), bits(values)):
                for key, stamps in (("latency", signal.times_ns), ("left", signal.left_ns),
                                    ("oldest", signal.oldest_ns), ("newest", signal.newest_ns)):
                    back = np.rint(np.nan_to_num(columns[key], nan=-1e-9) * 1e9)
                    np.testing.assert_array_equal(back, stamps)
                np.testing.assert_array_equal(columns["index"], signal.indices)
                return
    raise AssertionError(f"{signal.name}, trial {trial}: not found")


def test_values_of_any_size_keep_every_bit(tmp_path):
    values = np.array([0.1, -0.0, 5e-324, 1.7976931348623157e308, np.pi, 1 / 3, np.nan])
    node = Node("n", BLOCK, {"angles": ("rad", (1,))}).add(times(7), {"angles": values[:, np.newaxis]})
    folder = export(write_run(tmp_path / "run.h5", [node]), "motion-bids", tmp_path / "d").path
    (path,) = folder.glob("sub-01/motion/*_motion.tsv")
    columns, _ = table_of(path)
    same(columns["angles.0"], values)
    assert rows_of(path)[-1][-1] == "n/a"


def test_a_run_without_motion_is_refused(tmp_path):
    node = Node("pid", BLOCK, {"stimulation": ("A,s", (1, 2))})
    node.add(times(2), {"stimulation": np.zeros((2, 1, 2))})
    with pytest.raises(InputError, match=r"records no motion.*recorded are pid\.stimulation"):
        export(write_run(tmp_path / "run.h5", [node]), "motion-bids", tmp_path / "d")


def test_runs_in_real_time_say_when_their_trials_began(tmp_path):
    run = write_run(tmp_path / "run.h5", worn(trials=2))
    with h5py.File(run, "r+") as file:
        rows = np.array([(0, 5, 1_763_719_200_123_456_789), (1, 6, 1_763_719_260_000_000_999)],
                        [("trial", "<i4"), ("monotonic_ns", "<i8"), ("utc_ns", "<i8")])
        file["wall"].create_dataset("origins", data=rows)
    dataset = export(run, "motion-bids", tmp_path / "dataset").path
    onsets = {(row[2], row[1]) for row in rows_of(dataset / "sub-01/sub-01_scans.tsv")[1:]}
    assert onsets == {("0", "2025-11-21T10:00:00.123456Z"), ("1", "2025-11-21T10:01:00.000000Z")}
    assert faults(dataset) == []
    plain = export(write_run(tmp_path / "plain.h5", worn(trials=2)), "motion-bids", tmp_path / "plain").path
    onsets = {(row[2], row[1]) for row in rows_of(plain / "sub-01/sub-01_scans.tsv")[1:]}
    assert onsets == {("0", "2026-11-21T10:00:00Z"), ("1", "n/a")}

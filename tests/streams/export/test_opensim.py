"""OpenSim files: as OpenSim's documentation has them, and as OpenSim itself reads them."""

import importlib.util
import json
import re
import subprocess
import sys

import numpy as np
import pytest
from export_parts import BLOCK, Node, any_floats, runs, same, times, write_run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fesloop import InputError, Recording
from fesloop.experiment.export import export
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree

FREEDOMS = hand_tree(HandSize()).freedoms


def read(path):
    """Header lines, labels, times and cells."""
    header, _, body = path.read_text(encoding="utf-8").partition("endheader\n")
    labels, *rows = [line.split("\t") for line in body.split("\n")[:-1]]
    assert labels[0] == "time"
    assert not any(re.search(r"\s", label) for label in labels)
    assert len(set(labels)) == len(labels)
    return header.split("\n")[:-1], labels[1:], [float(row[0]) for row in rows], [row[1:] for row in rows]


def hand_run(tmp_path, rows=40):
    """A hand's angles and orientations."""
    rng = np.random.default_rng(4)
    orientation = Rotation.random(rows * 17, random_state=4).as_quat(scalar_first=True).reshape(rows, 17, 4)
    node = Node("tracker", BLOCK, {"angles": ("rad", (23,)), "orientation": ("1", (17, 4))})
    node.add(times(rows), {"angles": rng.uniform(-2.0, 2.0, (rows, 23)), "orientation": orientation})
    return write_run(tmp_path / "run.h5", [node], parameters={"tracker": {"hand": {"side": "right"}}})


def test_a_motion_has_the_header_of_its_documentation(tmp_path):
    run = hand_run(tmp_path)
    header, labels, instants, cells = read(export(run, "mot", tmp_path / "angles.mot").path)
    assert header == ["tracker.angles", "version=1", "nRows=40", "nColumns=24", "inDegrees=yes", ""]
    assert tuple(labels) == FREEDOMS
    with Recording(run) as recording:
        signal = recording.signal("tracker.angles")
    np.testing.assert_array_equal(instants, signal.times_ns / 1e9)
    same(np.array(cells, float), np.rad2deg(signal.values))


def test_orientations_have_the_header_of_opensense(tmp_path):
    run = hand_run(tmp_path)
    header, labels, _, cells = read(export(run, "sto", tmp_path / "out.sto").path)
    assert header == ["DataRate=100.000000", "DataType=Quaternion", "version=3", "OpenSimVersion=4.1"]
    assert labels == [f"{name}_imu" for name in hand_tree(HandSize()).names]
    with Recording(run) as recording:
        signal = recording.signal("tracker.orientation")
    same(np.array([[cell.split(",") for cell in row] for row in cells], float), signal.values)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=runs(kinds=(BLOCK,), shapes=st.sampled_from(((1,), (3,), (5,))), units=st.just("rad"),
                 ports=st.just("angles"), finite=True))
def test_every_motion_reads_back_exactly(made, tmp_path_factory):
    nodes, events = made
    folder = tmp_path_factory.mktemp("run")
    run = write_run(folder / "run.h5", nodes, events)
    files = iter(export(run, "mot", folder / "out").files)
    with Recording(run) as recording:
        found = [read(path) for path in files]
        assert len(found) == recording.trials * len(recording.signals)
        for name in recording.signals:
            for trial in range(recording.trials):
                with np.errstate(over="ignore"):
                    degrees = np.rad2deg(recording.signal(name, trial).values)
                matching = [cells for header, _, _, cells in found
                            if header[0] == name and len(cells) == len(degrees)]
                assert any(np.array_equal(np.array(cells, float).reshape(degrees.shape), degrees)
                           for cells in matching)


BY_OPENSIM = """
import json, sys
import opensim

mot, sto = sys.argv[1:]
angles, turned = opensim.TimeSeriesTable(mot), opensim.TimeSeriesTableQuaternion(sto)
found = {"labels": angles.getColumnLabels(), "times": angles.getIndependentColumn(),
         "degrees": opensim.Storage(mot).isInDegrees(), "rate": turned.getTableMetaDataString("DataRate"),
         "sensors": turned.getColumnLabels(),
         "angles": [[angles.getRowAtIndex(row).getElt(0, column) for column in range(angles.getNumColumns())]
                    for row in range(angles.getNumRows())],
         "quaternions": [[[turned.getRowAtIndex(row).getElt(0, column).get(part) for part in range(4)]
                          for column in range(turned.getNumColumns())] for row in range(turned.getNumRows())]}
rotation = opensim.Rotation(turned.getRowAtIndex(7).getElt(0, 3))
found["matrix"] = [[rotation.asMat33().get(row, column) for column in range(3)] for row in range(3)]
json.dump(found, open("found.json", "w"))
"""


@pytest.mark.slow
def test_opensim_reads_both(tmp_path):
    """In a process and a folder of its own, as it writes a log where it is."""
    if importlib.util.find_spec("opensim") is None:
        pytest.skip("OpenSim is not installed, which pip install 'fesloop[dev]' does on Linux")
    run = hand_run(tmp_path)
    files = [export(run, kind, tmp_path / f"out.{kind}").path for kind in ("mot", "sto")]
    subprocess.run([sys.executable, "-c", BY_OPENSIM, *files], cwd=tmp_path, check=True, capture_output=True)
    found = json.loads((tmp_path / "found.json").read_text())
    with Recording(run) as recording:
        angles, orientation = (recording.signal(f"tracker.{port}") for port in ("angles", "orientation"))
    assert tuple(found["labels"]) == FREEDOMS
    assert found["degrees"]
    assert found["rate"] == "100.000000"
    same(np.array(found["angles"]), np.rad2deg(angles.values))
    np.testing.assert_array_equal(found["times"], angles.times_ns / 1e9)
    np.testing.assert_allclose(found["quaternions"], orientation.values, atol=3e-16)  # it makes them unit
    wanted = Rotation.from_quat(orientation.values[7, 3], scalar_first=True).as_matrix()
    np.testing.assert_allclose(found["matrix"], wanted, atol=1e-15)


def test_gaps_are_no_numbers_and_uneven_instants_are_told(tmp_path):
    values = any_floats(np.random.default_rng(5), (4, 2), finite=True)
    values[1, 0] = np.nan
    node = Node("ref", BLOCK, {"angles": ("rad", (2,))}).add([0, 10, 20, 50], {"angles": values})
    run = write_run(tmp_path / "run.h5", [node])
    exported = export(run, "mot", tmp_path / "a.mot")
    assert "ref.angles, trial 0: instants are not evenly spaced" in exported.notes[0]
    _, _, _, cells = read(exported.path)
    with np.errstate(over="ignore"):
        same(np.array(cells, float), np.rad2deg(values))


def test_a_signal_of_another_kind_and_a_run_without_any_are_refused(tmp_path):
    node = Node("pid", BLOCK, {"stimulation": ("A,s", (1, 2)), "level": ("rad", ())})
    node.add(times(2), {"stimulation": np.zeros((2, 1, 2)), "level": np.zeros(2)})
    run = write_run(tmp_path / "run.h5", [node])
    for kind, what in (("mot", "joint angles"), ("sto", "orientations")):
        with pytest.raises(InputError, match=f"records no {what}.*recorded are pid.stimulation, pid.level"):
            export(run, kind, tmp_path / "out")
        with pytest.raises(InputError, match=rf"pid\.stimulation: is A,s of shape \(1, 2\); allowed: {what}"):
            export(run, kind, tmp_path / "out", signals=["pid.stimulation"])
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]

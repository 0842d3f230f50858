"""MATLAB files, as scipy reads them, hold every number and stamp of a run."""

import re

import numpy as np
import pytest
from export_parts import BLOCK, Node, runs, same, times, write_run
from hypothesis import HealthCheck, given, settings
from scipy.io import loadmat, whosmat

from fesloop import InputError, Recording
from fesloop.experiment.export import export, mat
from fesloop.experiment.export.mat import variable_names
from fesloop.streams.reading import read_container


def read(path):
    """Variables by name."""
    content = loadmat(path, struct_as_record=True, chars_as_strings=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def field(structure, name):
    return structure[0, 0][name]


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=runs())
def test_every_run_reads_back_exactly(made, tmp_path_factory):
    nodes, events = made
    folder = tmp_path_factory.mktemp("run")
    run = write_run(folder / "run.h5", nodes, events)
    exported = export(run, "mat", folder / "out")
    with Recording(run) as recording:
        names = recording.signals + recording.inputs
        variables = dict(zip(names, variable_names(names), strict=True))
        for trial, path in enumerate(exported.files):
            content = read(path)
            assert set(read_container(path)) == set(content)
            assert set(content) == {*variables.values(), "run", "events"}
            for name, variable in variables.items():
                signal, structure = recording.signal(name, trial), content[variable]
                assert field(structure, "name").item() == re.sub("[^\0-\uffff]", "\ufffd", name)
                assert field(structure, "unit").item() == signal.unit
                values, rows = signal.values, len(signal.times_ns)
                same(field(structure, "values"), values.reshape(rows, 1) if values.ndim == 1 else values)
                for stamp, array in (("time_ns", signal.times_ns), ("left_ns", signal.left_ns),
                                     ("oldest_ns", signal.oldest_ns), ("newest_ns", signal.newest_ns),
                                     ("index", signal.indices)):
                    assert field(structure, stamp).dtype == np.int64
                    np.testing.assert_array_equal(field(structure, stamp).ravel(), array)
                np.testing.assert_array_equal(field(structure, "time").ravel(), signal.times_ns / 1e9)
                assert field(structure, "channels").size == max(1, values[:1].size or int(
                    np.prod(values.shape[1:])))
            mine = [event for event in recording.events if event.trial == trial]
            details = field(content["events"], "detail").ravel()
            assert [str(cell[0]) if cell.size else "" for cell in details] == [
                re.sub("[^\0-\uffff]", "\ufffd", event.detail) for event in mine]


def test_a_structure_says_what_its_columns_are(tmp_path):
    node = Node("tracker", BLOCK, {"angles": ("rad", (23,)), "orientation": ("1", (2, 4))})
    node.add(times(4), {"angles": np.arange(92.0).reshape(4, 23), "orientation": np.ones((4, 2, 4))})
    run = write_run(tmp_path / "run.h5", [node], parameters={"tracker": {"sensed": ["hand", "F2p"]}})
    content = read(export(run, "mat", tmp_path / "run.mat").path)
    angles, orientation = content["tracker_angles"], content["tracker_orientation"]
    labels = field(angles, "channels")
    assert labels.shape == (1, 23)
    assert labels[0, 0].item() == "wrist_flexion"
    assert [[cell.item() for cell in row] for row in field(orientation, "channels")[0:2]] == [
        [f"{segment}.{part}" for part in "wxyz"] for segment in ("hand", "F2p")]
    assert field(content["run"], "name").item() == "made_up"
    assert field(content["run"], "trial").item() == 0.0


def test_many_pieces_fill_a_cube_in_place(tmp_path):
    rows = 50_000
    values = np.random.default_rng(2).normal(size=(rows, 3, 4))
    node = Node("plant", BLOCK, {"poses": ("1", (3, 4))}).add(times(rows), {"poses": values})
    path = export(write_run(tmp_path / "run.h5", [node]), "mat", tmp_path / "run.mat").path
    same(field(read(path)["plant_poses"], "values"), values)
    assert {name: shape for name, shape, _ in whosmat(path)}["plant_poses"] == (1, 1)


def test_names_are_valid_and_different():
    names = ["finger.angles", "finger_angles.x", "1st.y", "end.", "for.ü", "run.", "a" * 80 + ".x",
             "a" * 80 + ".y", "finger.angleS", "finger_angles"]
    made = variable_names([*names, "events", "run", "end"])
    assert made[0] == "finger_angles"
    assert len({name.lower() for name in made}) == len(made)
    assert not {"run", "events", "end"} & set(made)
    for name in made:
        assert name.isascii()
        assert name.isidentifier()
        assert name[0].isalpha()
        assert len(name) <= 63


def test_what_matlab_5_cannot_hold_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(mat, "MOST_BYTES", 100_000)
    node = Node("n", BLOCK, {"small": ("1", ()), "big": ("1", (40,))})
    node.add(times(500), {"small": np.zeros(500), "big": np.zeros((500, 40))})
    run = write_run(tmp_path / "run.h5", [node])
    with pytest.raises(InputError, match=r"n\.big: takes .* GB; allowed: .* a variable; .*xdf or csv"):
        export(run, "mat", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]
    assert export(run, "mat", tmp_path / "out", signals=["n.small"]).files

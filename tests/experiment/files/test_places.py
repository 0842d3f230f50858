"""A path in a file starts from the file's folder, a path in a setting from the current folder."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop import InputError, load
from fesloop.analysis.study.design.plan import plan
from fesloop.analysis.study.design.study_file import read_study
from fesloop.experiment.files.source import placed, placed_value
from fesloop.models.patient_model import shipped_models

HERE, BESIDE, SAID = 201.0, 171.0, 151.0
"""Lengths of hands, mm, of patients whose files have one name in different folders."""
NAMES = st.from_regex(r"[a-z]{1,8}(/[a-z]{1,8})?\.toml", fullmatch=True)


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """The current folder, one of an experiment file, and one of the file that this extends."""
    for name, size in (("here", HERE), ("beside", BESIDE), ("base", SAID)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "who.toml").write_text(
            f'name = "who"\n[anthropometry]\nhand_mm = {size}\n[cohort]\n')
    (tmp_path / "base" / "rig.toml").write_text('extends = "open_close"\npatient.file = "who.toml"\n')
    (tmp_path / "beside" / "own.toml").write_text('extends = "open_close"\n[patient]\nfile = "who.toml"\n')
    (tmp_path / "beside" / "over.toml").write_text('extends = "../base/rig.toml"\n')
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path


def hand_mm(experiment):
    return experiment.document()["patient"]["drawn"]["anthropometry"]["hand_mm"]


@pytest.mark.parametrize(("file", "settings", "size"), [
    ("../beside/own.toml", [], BESIDE),
    ("../beside/over.toml", [], SAID),
    ("../beside/own.toml", ["patient=who.toml"], HERE),
    ("open_close", ["patient=who.toml"], HERE),
])
def test_whose_hand_it_is_does_not_depend_on_the_current_folder(folders, file, settings, size):
    assert hand_mm(load(file, settings)) == size


def test_a_patient_who_is_not_beside_the_file_is_refused_by_the_folder_that_was_searched(folders):
    (folders / "beside" / "who.toml").unlink()
    with pytest.raises(InputError, match=r"\.\./beside/who\.toml.* cannot be read"):
        load("../beside/own.toml")


@pytest.mark.parametrize("level", [
    'options.A = { settings = ["patient=who.toml"] }', 'key = "patient"\nvalues = ["who.toml"]',
    'cohort = { patient = "who.toml", members = 1 }'])
def test_the_patients_of_a_study_are_those_beside_it(folders, level):
    study = folders / "beside" / "study.toml"
    study.write_text('[study]\nname = "who"\nexperiment = "open_close"\n'
                     'metrics = { mcp = "joints.F2_mcp_flexion.range_deg" }\n'
                     f'[axes.whose]\n{level}\n')
    (cell,) = plan(read_study("../beside/study.toml"), lambda cell: ())
    assert f'"hand_mm":{BESIDE}' in cell.document.replace(" ", "")


def test_a_model_is_that_beside_the_file(folders):
    (folders / "beside" / "model.toml").write_text(
        'extends = "open_close_ilc"\nblocks.controller.model.file = "mine.toml"\n')
    with pytest.raises(InputError, match=r"\.\./beside/mine\.toml"):
        load("../beside/model.toml")


@given(NAMES, st.sampled_from([
    ("patient", "file"), ("blocks", "controller", "model", "file"), ("blocks", "tracker", "process", "file"),
    ("blocks", "recording", "recording"), ("blocks", "recording", "layout"), ("blocks", "finger", "path"),
    ("blocks", "reference", "file")]), st.booleans())
def test_every_path_of_a_file_starts_from_its_folder(name, path, in_variant):
    folder = Path("some") / "where"
    found = placed_value(path, name, folder)
    assert found == str(folder / name)
    assert placed_value(path, f"/{name}", folder) == f"/{name}"
    assert placed_value(path, name, None) == name
    document = name
    for key in reversed([*(("variants", "which", "this") if in_variant else ()), *path]):
        document = {key: document}
    made = placed(document, folder)
    while isinstance(made, dict):
        (made,) = made.values()
    assert made == found


@pytest.mark.parametrize(("path", "name"), [
    (("patient", "file"), "sci_c6"), (("blocks", "finger", "path"), "shipped:finger"),
    *((("blocks", "controller", "model", "file"), name) for name in shipped_models()),
    (("score", "recording"), "recording"), (("blocks", "a", "kind"), "file"),
    (("aliases", "file"), "blocks.a.file"), (("blocks", "imus", "sensor_names"), ["a.toml"]),
    (("record", "path"), "a.toml")])
def test_what_is_no_path_stays(path, name):
    assert placed_value(path, name, Path("some")) == name

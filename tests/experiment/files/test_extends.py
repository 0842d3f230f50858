"""A file that extends another is the same experiment as one that says all of it."""

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.analysis.study.design.study_file import read_study
from fesloop.errors import InputError
from fesloop.experiment.files.layout import json_schema
from fesloop.experiment.files.parse import load, read
from fesloop.experiment.files.source import shipped

BASE = """
[experiment]
name = "base"
duration_s = 1

[blocks.reference]
kind = "minimum_jerk"
rate = "50"
times_s = [0.0, 1.0]
angles_deg = [[0, 0, 0], [10, 20, 30]]

[blocks.finger]
kind = "finger"

[variants.goal.near]
blocks.reference.angles_deg = [[0, 0, 0], [1, 2, 3]]
[variants.goal.far]
description = "as the file says"
[variants.goal]
default = "far"
"""



def lay(tmp_path, name, text):
    path = tmp_path / f"{name}.toml"
    path.write_text(text)
    return path


def test_tables_are_merged_lists_replaced_and_the_rest_stays(tmp_path):
    lay(tmp_path, "base", BASE)
    mine = lay(tmp_path, "mine", 'extends = "base.toml"\n[experiment]\nname = "mine"\n'
                                 "[blocks.reference]\ntimes_s = [0.0, 0.5]\n"
                                 '[variants.goal]\ndefault = "near"\n')
    document = read(mine)[1]
    assert document["experiment"] == {"name": "mine", "duration_s": 1}
    assert document["blocks"]["reference"] == {
        "kind": "minimum_jerk", "rate": "50", "times_s": [0.0, 0.5], "angles_deg": [[0, 0, 0], [10, 20, 30]]}
    assert document["variants"]["goal"]["default"] == "near"
    assert set(document["variants"]["goal"]) == {"default", "near", "far"}
    assert "extends" not in document


def test_what_is_removed_is_gone_with_its_wires(tmp_path):
    mine = lay(tmp_path, "mine", 'extends = "grasp_mpc"\nremove = ["blocks.grip", "variants.scene"]\n'
                                 'wires = [{ from = "controller.stimulation", to = "safety.stimulation" }]\n')
    document = read(mine)[1]
    ends = [(wire["from"], wire["to"]) for wire in document["wires"]]
    assert not any("grip." in end for pair in ends for end in pair)
    assert ends[-1] == ("controller.stimulation", "safety.stimulation")
    assert "scene" not in document["variants"]
    assert "tracker" in document["variants"]


def test_paths_start_from_the_folder_of_the_file_that_names_them(tmp_path):
    folder = tmp_path / "lab" / "rigs"
    folder.mkdir(parents=True)
    (folder / "base.toml").write_text(BASE)
    (tmp_path / "lab" / "middle.toml").write_text('extends = "rigs/base.toml"\n[experiment]\nseed = 2\n')
    mine = lay(tmp_path, "mine", 'extends = "lab/middle.toml"\n[experiment]\nname = "mine"\n')
    assert read(mine)[1]["experiment"] == {"name": "mine", "duration_s": 1, "seed": 2}


@given(names=st.permutations(["a", "b", "c", "d"]))
@settings(max_examples=10, deadline=None)
def test_a_line_of_files_is_laid_over_each_other_in_turn(tmp_path_factory, names):
    """The last of a line that says a key counts; a key that only one says stays."""
    folder = tmp_path_factory.mktemp("line")
    (folder / "base.toml").write_text(BASE)
    below = "base"
    for number, name in enumerate(names):
        (folder / f"{name}.toml").write_text(
            f'extends = "{below}.toml"\n[experiment]\nseed = {number}\nnotes = ["{name}"]\n'
            f"[aliases]\n{name} = \"experiment.seed\"\n")
        below = name
    document = read(folder / f"{below}.toml")[1]
    assert document["experiment"]["seed"] == len(names) - 1
    assert document["experiment"]["notes"] == [names[-1]]
    assert set(document["aliases"]) == set(names)


def test_rigs_are_not_listed_and_cannot_be_run_by_name():
    assert "hand_rig" not in shipped()
    with pytest.raises(InputError, match="there is no shipped experiment of this name"):
        load("hand_rig")


@pytest.mark.parametrize(("text", "told"), [
    ('extends = "mine.toml"\n', "refers back to this file"),
    ("extends = 3\n", "3 is no text"),
    ('extends = "hand_rigg"\n', "did you mean 'hand_rig'"),
    ('extends = "nowhere.toml"\n', "cannot be read"),
    ('extends = "grasp_mpc"\nremove = ["blocks.gripp"]\n', "there is no 'blocks.gripp'"),
    ('extends = "grasp_mpc"\nremove = ["variants.trackr"]\n', "there is no 'variants.trackr'"),
    ('extends = "grasp_mpc"\nremove = "blocks.grip"\n', "a list of key paths"),
    ('extends = "grasp_mpc"\nblocks = 3\n', "cannot be merged with another file"),
    ('extends = "grasp_mpc"\n[blocks.controller]\nhorizn = 3\n', "horizn: unknown key"),
])
def test_what_cannot_be_extended_is_refused_in_a_line(tmp_path, text, told):
    mine = lay(tmp_path, "mine", text)
    with pytest.raises(InputError) as caught:
        load(mine)
    assert told in str(caught.value)
    assert len([line for line in str(caught.value).splitlines() if told in line]) == 1


def test_a_study_extends_a_study(tmp_path):
    mine = lay(tmp_path, "mine", 'extends = "linear_map"\n[study]\nname = "mine"\n')
    theirs = read_study("linear_map")
    study = read_study(mine)
    assert study.about.name == "mine"
    assert study.axes.keys() == theirs.axes.keys()
    assert study.about.experiment == theirs.about.experiment


def test_the_schema_takes_a_file_that_extends_another():
    document, schema = {"extends": "grasp_mpc", "blocks": {"hand": {"settle_s": 1.0}}}, json_schema()
    jsonschema.validate(document, schema)
    for wrong in ({**document, "extends": 3}, {key: document[key] for key in ("blocks",)}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema)


PID = """
extends = "finger_control"
[experiment]
name = "mygains"
[variants.control]
default = "pid"
"""


def test_no_variant_of_what_is_extended_overrules_the_file(tmp_path):
    """Gains of a file's own used to be lost to those of the option that it picks from the other file."""
    overruled = lay(tmp_path, "overruled", PID + "[blocks.controller]\nkp = [3.0, 3.0, 3.0]\n")
    with pytest.raises(InputError, match=r"blocks.controller.kp: is set by the file, and changed by "
                                         r"variants.control.pid of what it extends"):
        load(overruled)
    said = lay(tmp_path, "said", PID + "[variants.control.pid.blocks.controller]\nkp = [3.0, 3.0, 3.0]\n")
    assert load(said).document()["blocks"]["controller"]["kp"] == [3.0, 3.0, 3.0]
    both = lay(tmp_path, "both", PID + "[blocks.controller]\nkp = [3.0, 3.0, 3.0]\n"
                                       "[variants.control.pid.blocks.controller]\nkp = [3.0, 3.0, 3.0]\n")
    assert load(both).document()["blocks"]["controller"]["kp"] == [3.0, 3.0, 3.0]
    deeper = lay(tmp_path, "deeper", 'extends = "said.toml"\n[experiment]\nname = "deeper"\n'
                                     "[blocks.controller]\nkp = [2.0, 2.0, 2.0]\n")
    with pytest.raises(InputError, match=r"blocks.controller.kp: is set by the file"):
        load(deeper)


@given(kp=st.floats(0.1, 10.0), option=st.sampled_from(["mpc", "pid", "tuned_pid", "ilc"]),
       key=st.sampled_from(["kp", "move_weight", "delay_ms", "duration_s"]))
@settings(max_examples=30, deadline=None)
def test_what_a_file_says_is_what_runs_or_is_refused(tmp_path_factory, kp, option, key):
    value = [kp] * 3 if key == "kp" else kp
    folder = tmp_path_factory.mktemp("said")
    mine = lay(folder, "mine", f'extends = "finger_control"\n[variants.control]\ndefault = "{option}"\n'
                               f"[blocks.controller]\n{key} = {value}\n")
    try:
        runs = load(mine).document()["blocks"]["controller"]
    except InputError:
        return
    assert runs[key] == value


def test_a_description_and_a_guide_are_of_the_file_that_says_them(tmp_path):
    mine = lay(tmp_path, "mine", 'extends = "grasp_mpc"\n[experiment]\nname = "mine"\n')
    document = read(mine)[1]
    assert "description" not in document["experiment"]
    assert "guide" not in document
    assert load(mine).document()["experiment"]["name"] == "mine"

"""What is printed as `next:` can be typed: no placeholder is left, and names with blanks are quoted."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.apps.cli.parser import make_parser
from fesloop.experiment.files.layout import guide_of
from fesloop.experiment.files.parse import load, read
from fesloop.experiment.files.source import shipped

GUIDES = {name: guide_of(read(name)[1]) for name in shipped()}
LAYOUT = """rate = 50
pairs = [["a", "b"]]
[sensors.a]
gyr = [1, 2, 3]
acc = [4, 5, 6]
[sensors.b]
gyr = [7, 8, 9]
acc = [10, 11, 12]
"""


def next_lines(text):
    return [line.removeprefix("next:").strip() for line in text.splitlines() if line.startswith("next:")]


@given(name=st.sampled_from(sorted(GUIDES)), scored=st.booleans(),
       recording=st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), min_size=1),
       played=st.sampled_from(["lab.h5", "my lab/a b.csv", "it's.xdf", ""]),
       layout=st.sampled_from(["", "my lab/layout.toml"]))
@example(name="sweep_grasp", scored=True, recording="-a.h5", played="lab.h5", layout="")
@settings(max_examples=60, deadline=None)
def test_no_placeholder_is_printed_and_every_word_is_one(name, recording, played, layout, scored):
    given = [f"recording={played}"] * bool(played) + [f"blocks.recording.layout={layout}"] * bool(layout)
    for command in GUIDES[name].next_commands(recording, given, scored):
        words = shlex.split(command)
        assert not {"RUN.h5", "RECORDING", "recording=RECORDING"} & set(words)
        make_parser().parse_args(words[1:])
        if "RECORDING" in " ".join(GUIDES[name].try_next) and "recording=" in command:
            assert f"recording={played}" in words
            assert (f"blocks.recording.layout={layout}" in words) is bool(layout)


KEYS = st.from_regex(r"[a-z_]{1,8}(\.[a-z_]{1,8}){0,2}", fullmatch=True)
VALUES = st.text(st.characters(codec="ascii", exclude_categories=("Cc",)), max_size=8)


@given(name=st.sampled_from(sorted(GUIDES)), given=st.dictionaries(KEYS, VALUES, max_size=4),
       folder=st.sampled_from(["", "own files/"]), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_commands_on_the_same_experiment_keep_the_settings_of_the_run(name, given, folder, seed):
    typed = f"{folder}{name}.toml" if folder else name
    changed = [f"{key}={value}" for key, value in given.items()]
    for command in GUIDES[name].next_commands("a.h5", changed, True, typed, ["--seed", str(seed)]):
        words = shlex.split(command)
        args = make_parser().parse_args(words[1:])
        if words[1] not in ("run", "check") or args.experiment != typed:
            continue
        own = [each for guide in GUIDES[name].try_next if guide.startswith(f"fesloop {words[1]} {name} ")
               for each in make_parser().parse_args(shlex.split(guide)[1:]).settings]
        last = dict(each.split("=", 1) for each in args.settings)
        assert set(args.settings) <= {*changed, *own}
        assert set(given) <= set(last), "every setting of the run is there, or the command's own"
        assert all(last[key] == value or f"{key}={last[key]}" in own for key, value in given.items())
        assert args.seed == (seed if words[1] == "run" else None)


def test_commands_that_would_repeat_the_run_are_left_out():
    guide = GUIDES["grasp_ilc"]
    repeated = next(command for command in guide.try_next if command.endswith("--set law=gradient"))
    assert guide.next_commands("a.h5", ["trials=2"], True, "grasp_ilc") == [
        command.replace("grasp_ilc", "grasp_ilc --set trials=2") for command in guide.try_next]
    assert len(guide.next_commands("a.h5", ["law=gradient"], True, "grasp_ilc")) == len(guide.try_next) - 1
    assert repeated not in guide.next_commands("a.h5", ["law=gradient"], True, "grasp_ilc")


def test_commands_that_the_settings_of_the_run_break_are_not_printed(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = ["--set", "blocks.controller.move_weight=0.002", "--set", "experiment.duration_s=1"]
    assert main(["run", "finger_control", *given, "--out", "of mine"]) == 0
    commands = next_lines(capsys.readouterr().err)
    assert commands == ["fesloop run hil_twin --set 'recording=of mine/finger_control-1.h5'"]
    assert main(["check", *shlex.split(commands[0])[2:]]) == 0


@pytest.mark.parametrize(("name", "rows"), [
    ("sweep_grasp", ["F2_flexion", "F3_flexion", "F4_flexion", "F5_flexion"]),
    ("identify_grasp", ["finger_flexion"])])
def test_the_hand_of_others_is_opened_wider_by_what_its_run_suggests(name, rows):
    guide = GUIDES[name]
    identify, grasp = guide.next_commands("a.h5", ["member=3", "cohort=1", " plant = myohand"])
    assert ("--opened-deg 8" in identify) == (name == "sweep_grasp")
    given = make_parser().parse_args(shlex.split(grasp)[1:]).settings
    assert [each for each in given if each.endswith("=8")] == [
        f"blocks.reference.phases.open.deg.{row}=8" for row in rows]
    assert {"member=3", "cohort=1", " plant = myohand"} <= set(given)
    usual = guide.next_commands("a.h5", ["plant=hand"])
    assert len(usual) == 2
    assert not any("8" in command for command in usual)
    wider = [each for each in given if not each.startswith(("model=", "channels="))]
    document = load("grasp_mpc", [*wider, "any_patient=true", "plant=hand"]).document()
    opened = next(each for each in document["blocks"]["reference"]["phases"] if each["name"] == "open")
    assert all(opened["deg"][row] == 8 for row in rows)


@pytest.mark.slow
@pytest.mark.parametrize("given", [
    ["patient=sci_c6", "cohort=1", "member=3"], ["cohort=1", "member=3", "tracker=constrained"]])
def test_what_a_run_of_another_patient_suggests_runs_as_printed(given, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sets = [word for setting in given for word in ("--set", setting)]
    assert main(["run", "identify_grasp", *sets]) == 0
    for command in next_lines(capsys.readouterr().err):
        assert main(shlex.split(command)[1:]) == 0, command
    capsys.readouterr()
    few = ["any_patient=true", "trials=1"]
    assert main(["run", "grasp_ilc", *sets, *(word for each in few for word in ("--set", each))]) == 0
    commands = next_lines(capsys.readouterr().err)
    assert len(commands) == 2
    for command in commands:
        assert "member=3" in command
        assert main(shlex.split(command)[1:]) == 0, command


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ["hil_replay", "replay"])
@pytest.mark.parametrize("with_layout", [True, False])
def test_what_a_run_of_a_recording_suggests_runs_as_printed(experiment, with_layout, tmp_path, capsys,
                                                            monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my lab").mkdir()
    np.savetxt("my lab/a b.csv", np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (40, 2)), delimiter=",")
    Path("my lab/layout.toml").write_text(LAYOUT)
    given = ["recording=my lab/a b.csv", "blocks.recording.layout=my lab/layout.toml"]
    if not with_layout:
        assert main(["import", "my lab/a b.csv", "my lab/a b.h5", "--layout", "my lab/layout.toml"]) == 0
        given = ["recording=my lab/a b.h5"]
    capsys.readouterr()
    sets = [word for setting in given for word in ("--set", setting)]
    assert main(["run", experiment, *sets, "--out", "my runs"]) == 0
    commands = next_lines(capsys.readouterr().err)
    assert commands
    assert not any("fit-error" in command for command in commands), "there is no reference"
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0, command


def test_placeholders_are_known():
    for guide in GUIDES.values():
        for command in guide.try_next:
            assert set(re.findall(r"\b[A-Z]{3,}\b(?:\.h5)?", command)) <= {"RUN.h5", "RECORDING"}

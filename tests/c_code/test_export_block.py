"""`fesloop export --block` and `fesloop.export_block`: files, targets, and one line for each mistake."""

from __future__ import annotations

import json
import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from c_code_parts import needs_gcc
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop.apps.cli import main
from fesloop.c_code.program import Axis
from fesloop.errors import InputError
from fesloop.experiment.block_code import program_of
from fesloop.models.patient_model import load_patient_model
from plants.finger.plant import MUSCLES

PID = ["export", "finger_pid_latency", "--block", "controller"]


@needs_gcc
@pytest.mark.parametrize("flags", [(), ("-fsanitize=address,undefined",)])
def test_the_command_writes_sources_that_build_without_a_warning(tmp_path, capsys, flags):
    out = tmp_path / "pid"
    main([*PID, "--format", "c", "--out", str(out), "--json"])
    files = json.loads(capsys.readouterr().out)["files"]
    assert [file.rpartition("/")[2] for file in files] == [
        "controller.h",
        "controller_settings.h",
        "controller.c",
    ]
    subprocess.run(
        ["gcc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", *flags, "-c", "controller.c"],
        cwd=out,
        check=True,
    )
    text = "".join(
        (out / name).read_text() for name in ("controller.c", "controller.h", "controller_settings.h")
    )
    assert "malloc" not in text
    assert "Worst case of a step: 377 operations" in " ".join(text.split())
    assert "#define PERIOD_S (0.02) /* s, from tick to tick */" in text


def test_the_function_writes_the_same_bytes(tmp_path):
    main([*PID, "--format", "c", "--out", str(tmp_path / "a")])
    folder = fesloop.export_block("finger_pid_latency", "controller", out=tmp_path / "b")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {
        path.name: path.read_bytes() for path in (tmp_path / "a").iterdir()}


@needs_gcc
def test_settings_change_the_constants_and_an_fmu_has_its_name(tmp_path):
    path = fesloop.export_block("finger_control", "controller", "fmu", tmp_path / "m" / "own.fmu",
                                settings={"control": "pid"})
    assert path == tmp_path / "m" / "own.fmu"
    with pytest.raises(fesloop.InputError, match="exists"):
        fesloop.export_block("finger_control", "controller", "fmu", path)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*PID, "--format", "csv"], "--format csv: is a format of recordings"),
        ([*PID, "--format", "c", "--trial", "0"], "--trial: is given for a block"),
        (["export", "finger_control", "--format", "c"], "--format c: is given without --block"),
        (["export", "finger_control", "--block", "contoller", "--format", "c"], "did you mean 'controller'?"),
        (
            ["export", "finger_control", "--block", "tracker", "--format", "c"],
            "kind 'ideal', which is not available in C",
        ),
        (["export", "finger_control", "--block", "patient", "--format", "c"], "is no block"),
        (["export", "finger_ilc", "--block", "controller", "--format", "c"], "controller.law"),
        (["export", "finger_ilc", "--block", "controller", "--format", "fmu"],
         "block controller: learns between trials, for which an FMU has no call; allowed: format c"),
        (["export", "finger_mpc", "--block", "controller", "--format", "fmu"], "controller.adaptation"),
        (["export", "array_search_gp", "--block", "search", "--format", "fmu"], "not available in C"),
        (["export", "no_such", "--block", "controller", "--format", "c"], "no_such"),
        (["export", "run.h5", "--format", "csv", "--set", "a=1"], "--set: is given with a recording"),
    ],
)
def test_each_mistake_is_one_line(tmp_path, capsys, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main(arguments))
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_experiments_that_the_page_lists_export_as_they_are():
    page = (Path(__file__).parents[2] / "docs" / "howto" / "export_controller.md").read_text()
    listed = re.search(r"export as they are: `controller` of (.*?), and `posture` of `(\w+)`", page, re.S)
    assert listed is not None
    names = re.findall(r"`(\w+)`", listed[1])
    assert len(names) == 10
    for name, block in (*((name, "controller") for name in names), (listed[2], "posture")):
        assert program_of(fesloop.load(name), block).name == block


def test_a_full_folder_is_kept(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(fesloop.InputError, match="is not empty"):
        fesloop.export_block("finger_pid_latency", "controller", out=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_headers_name_joints_and_channels(tmp_path):
    """Truth: the order of the plant's muscles, and the virtual electrodes of the experiment's stimulator."""
    fesloop.export_block("finger_control", "controller", out=tmp_path / "finger")
    header = " ".join((tmp_path / "finger" / "controller.h").read_text().split())
    for said, kind, names in (("last index of reference_preview, measured", "ANGLE", ("MCP", "PIP", "DIP")),
                              ("first index of stimulation", "CHANNEL", MUSCLES)):
        unit = " /* rad */" if kind == "ANGLE" else ""
        constants = " ".join(f"CONTROLLER_{kind}_{name.upper()},{unit}" for name in names)
        assert f"/* {said} */ enum {{ {constants} CONTROLLER_{kind}S = {len(names)} }};" in header

    settings = {"law": "gradient"}
    fesloop.export_block("open_close_ilc", "controller", out=tmp_path / "hand", settings=settings)
    header = (tmp_path / "hand" / "controller.h").read_text()
    assert "CONTROLLER_ANGLE_WRIST_EXTENSION, /* rad */\n    CONTROLLER_ANGLE_FINGER_FLEXION," in header
    stimulator = fesloop.load("open_close_ilc").wiring.node("stimulator").part
    for channel, electrode in enumerate(stimulator.electrodes):
        elements = "+".join(map(str, electrode.elements))
        assert f"CONTROLLER_CHANNEL_{channel}, /* elements {elements} */" in header


def test_the_controller_of_a_grasp_is_exported_as_shipped():
    """Its header names patient and model, the unit of each row, and the places of the force sensors."""
    program = program_of(fesloop.load("grasp_mpc", ["follow=aperture"]), "controller")
    header = " ".join(re.sub(r"\n \*", " ", program.files()["controller.h"]).split())
    digest = load_patient_model(Path("grasp_sci_c6_aperture")).model.digest()
    assert f"Made of: experiment grasp_mpc; patient sci_c6; model with the SHA-256 {digest}" in header
    assert "CONTROLLER_ANGLE_WRIST_EXTENSION, /* rad */" in header
    places = fesloop.load("grasp_mpc").wiring.node("force").part.places
    constants = " ".join(f"CONTROLLER_PLACE_{place.upper()}," for place in places)
    assert f"/* first index of force */ enum {{ {constants} CONTROLLER_PLACES = {len(places)} }};" in header
    assert f"double force[{len(places)}]; /* N */ int64_t force_newest_ns;" in header
    per_mm = float(re.search(r"CONTROLLER_ANGLE_GRIP_APERTURE, /\* rad, (\S+) for each mm \*/", header)[1])
    assert per_mm == pytest.approx(math.radians(1.0), rel=1e-15)


def test_learning_control_in_contact_is_refused_with_a_setting_that_helps():
    law = "law=noilc"
    with pytest.raises(InputError, match="contact is not available in C") as refused:
        program_of(fesloop.load("grasp_ilc", [law]), "controller")
    setting = re.search(r"--set (\S+) does so", str(refused.value))[1]
    assert program_of(fesloop.load("grasp_ilc", [law, setting]), "controller").sizes["MUSCLES"] == 8


@given(st.integers(0, 2), st.floats(-1.0, 1.0), st.sampled_from(["a", "b", "c", "offset"]))
def test_the_digest_of_a_model_changes_with_each_of_its_numbers(place, value, key):
    model = load_patient_model(Path("grasp_sci_c6")).model
    changed = np.array(getattr(model, key))
    changed.flat[place] = value
    same = np.array_equal(changed, getattr(model, key))
    assert (replace(model, **{key: changed}).digest() == model.digest()) == same
    assert replace(model, delay_ns=model.delay_ns + 1).digest() != model.digest()
    assert replace(model, recruitment=None).digest() != model.digest()


@needs_gcc
@settings(max_examples=15, deadline=None)
@given(st.lists(st.one_of(st.text(max_size=12), st.sampled_from(["*/", "int", "MCP", "mcp", "a b", "3", ""])),
                min_size=3, max_size=3))
def test_any_names_give_headers_that_compile(tmp_path_factory, names):
    program = replace(program_of(fesloop.load("finger_pid_latency"), "controller"),
                      axes=(Axis("ANGLE", tuple(names), ("measured",), -1),))
    folder = tmp_path_factory.mktemp("names")
    for name, text in program.files().items():
        (folder / name).write_text(text, encoding="ascii")
    strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    subprocess.run(["gcc", *strict, "controller.c"], cwd=folder, check=True)

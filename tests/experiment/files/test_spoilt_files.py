"""Files that are spoilt in any way work, or are refused in lines of fesloop's own: no traceback, no warning.

Each number is a file, the same each time: a shipped one with values, keys, tables or text replaced.
"""

import contextlib
import json
import random
import re
import tomllib
import warnings
from pathlib import Path

import pytest
from toml_mutants import mutant, odd_setting

from fesloop import load
from fesloop.analysis.study.design.cells import cells_of
from fesloop.analysis.study.design.plan import Resolver
from fesloop.analysis.study.design.study_file import read_study, study_of
from fesloop.analysis.study.engine.preparing import meanwhile
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, read
from fesloop.forms.toml import toml_text

ROOT = Path(__file__).resolve().parents[3]
SLOW = {"finger_fmu", "finger_pid_latency", "linear_loop"}
"""An FMU is tried out in a process of its own; theory takes a second."""
EXPERIMENTS = sorted(path for path in (ROOT / "fesloop" / "experiment" / "shipped").glob("*.toml")
                     if path.stem not in SLOW and not path.stem.startswith("array_search"))
EXPERIMENTS += [ROOT / "tests" / "experiment" / name for name in ("small.toml", "whole_hand.toml")]
PATIENTS = sorted((ROOT / "plants" / "patients").glob("*.toml"))
MODELS = sorted((ROOT / "fesloop" / "models" / "shipped").glob("*.toml"))
STUDIES = sorted((ROOT / "fesloop" / "analysis" / "study" / "shipped").glob("*.toml"))


def checked(capsys, *arguments):
    """Standard error's lines of a command that ends as it should: with a result, or with lines for a user."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code = main(["--traceback", *arguments])
    captured = capsys.readouterr()
    lines = captured.err.splitlines()
    if code == 0:
        assert lines == []
    else:
        assert code == 2
        assert lines
        for line in lines:
            assert re.match(r"fesloop: \S", line), line
            assert line.isprintable(), line
            assert len(line) <= 3100, line
    return lines


def resolved(text):
    """An experiment file with every parameter that it leaves out, if it can be."""
    try:
        return toml_text(from_document(tomllib.loads(text)).document())
    except InputError:
        return text


@pytest.mark.slow
@pytest.mark.parametrize("number", range(140))
def test_a_spoilt_experiment(capsys, tmp_path, number):
    chance = random.Random(f"experiment-{number}")
    text = chance.choice(EXPERIMENTS).read_text()
    path = tmp_path / "spoilt.toml"
    path.write_bytes(mutant(chance.choice((text, resolved(text))), chance).encode("utf-8", "surrogatepass"))
    picked = [f"--set={variant}={chance.choice([each for each in table if each != 'default'])}"
              for variant, table in tomllib.loads(text).get("variants", {}).items()
              if chance.random() < 0.4 and set(table) != {"default"}]
    checked(capsys, "check", str(path), *picked)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(60))
def test_an_odd_setting(capsys, number):
    chance = random.Random(f"setting-{number}")
    path = chance.choice(EXPERIMENTS)
    checked(capsys, "check", str(path), f"--set={odd_setting(path.read_text(), chance)}")


@pytest.mark.parametrize("number", range(40))
def test_a_spoilt_patient(capsys, tmp_path, number):
    chance = random.Random(f"patient-{number}")
    path = tmp_path / "spoilt.toml"
    text = chance.choice(PATIENTS).read_text()
    path.write_bytes(mutant(text, chance).encode("utf-8", "surrogatepass"))
    checked(capsys, *chance.choice((("patient", str(path)), ("patient", str(path), "--member=2", "--day=1"),
                                    ("check", "grasp_cylinder", f"--set=patient.file={path}"))))


@pytest.mark.parametrize("number", range(20))
def test_a_spoilt_model(capsys, tmp_path, number):
    chance = random.Random(f"model-{number}")
    path = tmp_path / "spoilt.toml"
    text = chance.choice(MODELS).read_text()
    path.write_bytes(mutant(text, chance).encode("utf-8", "surrogatepass"))
    checked(capsys, "check", "grasp_mpc", f'--set=blocks.mpc.model={{file = "{path}"}}')


@pytest.mark.parametrize("number", range(40))
def test_a_spoilt_study(tmp_path, number):
    chance = random.Random(f"study-{number}")
    path = tmp_path / "spoilt.toml"
    text = chance.choice(STUDIES).read_text()
    path.write_bytes(mutant(text, chance).encode("utf-8", "surrogatepass"))
    with contextlib.suppress(InputError):
        study = read_study(path, chance.choice(("", "", "full")))
        cell = next(cells_of(study))
        settings = (*cell.settings, *meanwhile(study)(cell))
        Resolver(study).experiment(cell.experiment, settings, study.about.seed)


ODD_TYPES = ("3", "[1]", "{}", "{x = 1}", "2020-01-01", '""')


@pytest.mark.parametrize("value", ODD_TYPES)
@pytest.mark.parametrize("key", [
    "patient", "patient.file", "patient.member", "patient.drawn", "blocks", "blocks.hand", "blocks.hand.kind",
    "blocks.electrodes.arrays", "blocks.stimulator.electrodes", "blocks.mpc.model", "blocks.mpc.model.file",
    "blocks.mpc.current_ma", "blocks.coordinates.rows", "aliases.latency_ms", "variants.plant.default"])
def test_a_value_of_another_type_is_refused_or_works(key, value):
    document = read("grasp_mpc")[1]
    *above, last = key.split(".")
    here = document
    for part in above:
        here = here.setdefault(part, {})
    here[last] = tomllib.loads(f"value = {value}")["value"]
    with contextlib.suppress(InputError):
        from_document(document)


@pytest.mark.parametrize("number", ["inf", "-inf", "nan", "1e308", "1e-320", "1e154"])
@pytest.mark.parametrize("key", [
    "blocks.patient.speed", "blocks.patient.density", "blocks.patient.lengths_mm.0",
    "blocks.patient.stiffness.1", "blocks.patient.moment_arms_mm.0.0"])
def test_numbers_beyond_what_a_finger_is_computed_with_are_refused(capsys, tmp_path, key, number):
    path = tmp_path / "finger.toml"
    path.write_text(toml_text(load("finger_mpc").document()))
    checked(capsys, "check", str(path), f"--set={key}={number}")


@pytest.mark.parametrize("number", ["inf", "nan", "1e308", "1e154", "-1e308"])
@pytest.mark.parametrize("key", ["hand_mm", "breadth_mm", "side"])
def test_numbers_beyond_a_hand_are_refused(capsys, key, number):
    lines = checked(capsys, "check", "grasp_cylinder", f"--set=blocks.hand.hand.{key}={number}")
    assert lines


@pytest.mark.slow
@pytest.mark.parametrize("depth", [65, 400, 20_000])
@pytest.mark.parametrize("form", ["dotted", "lists", "tables", "setting"])
def test_tables_within_tables_without_end_are_refused_in_a_line(capsys, tmp_path, form, depth):
    text = (ROOT / "tests" / "experiment" / "small.toml").read_text()
    path, more = tmp_path / "deep.toml", []
    dotted = ".".join(["a"] * depth)
    if form == "setting":
        more = [f"--set=blocks.pid.{dotted}=1"]
    else:
        text = {"dotted": f"{dotted} = 1\n", "lists": f"a = {'[' * depth}{']' * depth}\n",
                "tables": f"a = {'{a = ' * depth}1{'}' * depth}\n"}[form] + text
    path.write_text(text)
    (line,) = checked(capsys, "check", str(path), *more)
    assert "nested too deeply" in line or "leads through" in line


@pytest.mark.parametrize("make", [from_document, study_of])
@pytest.mark.parametrize("value", [object(), None, {1, 2}, b"x", 1j])
def test_tables_that_are_not_of_toml_are_refused_in_python_too(make, value):
    with pytest.raises(InputError, match=r"experiment\.name: .* is no value of TOML"):
        make({"experiment": {"name": value}})


def test_tables_that_hold_themselves_are_refused_in_python_too():
    tables = {"experiment": {"name": "x"}}
    tables["blocks"] = tables
    for make in (from_document, study_of):
        with pytest.raises(InputError, match="nested too deeply"):
            make(tables)


@pytest.mark.parametrize(("settings", "place"), [
    (["experiment.duration_s=4e9"], "record.plant_rate"),
    (["blocks.pid.rate=1e9", "experiment.duration_s=20"], "blocks.pid.rate"),
    (["record.plant_rate=1e9", "experiment.trials=100"], "record.plant_rate"),
    (["experiment.trials=2000000000"], "record.plant_rate")])
def test_a_run_without_end_is_refused_with_the_limit(capsys, settings, place):
    small = str(ROOT / "tests" / "experiment" / "small.toml")
    (line,) = checked(capsys, "check", small, *(f"--set={each}" for each in settings))
    assert f"{place}: " in line
    assert "at most 1e+10 ticks" in line


def test_json_names_the_same_faults(capsys):
    small = str(ROOT / "tests" / "experiment" / "small.toml")
    assert main(["check", small, "--json", "--set", "experiment.name=\x1b[31m"]) == 2
    captured = capsys.readouterr()
    assert json.loads(captured.out)["faults"] == [captured.err.strip().removeprefix("fesloop: ")]
    assert "\\x1b" in captured.err

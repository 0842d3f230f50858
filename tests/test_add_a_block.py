"""The page on adding a block, followed to the letter, and its block held to the contract of every block."""

import importlib.util
import json
import os
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import conformance.test_every_block as contract
import conformance_parts as parts
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "howto" / "add_a_block.md"
RUNS = """import fesloop, json, sys
runs = [fesloop.load("smoothed.toml", [f"time_constant_ms={each}"]).run() for each in sys.argv[1:]]
print(json.dumps([run.metrics for run in runs]))
"""


def docs_runner():
    """The script that follows pages."""
    spec = importlib.util.spec_from_file_location("docs_runner", ROOT / ".ci" / "docs.py")
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / ".ci")
        spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The page's files, and beside them what an installer leaves, without an installer or a network."""
    runner, folder = docs_runner(), tmp_path_factory.mktemp("page")
    files = [step for step in runner.steps(PAGE) if step.file]
    assert {step.file for step in files} == {"low_pass.py", "pyproject.toml", "smoothed.toml",
                                             "test_low_pass.py"}
    for step in files:
        runner.write(step, folder)
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    about = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    about.mkdir()
    about.joinpath("METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    rows = [f"{kind} = {value}" for kind, value in project["entry-points"]["fesloop.blocks"].items()]
    about.joinpath("entry_points.txt").write_text("\n".join(["[fesloop.blocks]", *rows, ""]))
    return folder


def commands():
    """The page's commands, in order, without those of the installer."""
    blocks = [step.text for step in docs_runner().steps(PAGE) if step.language == "sh"]
    told = [shlex.split(line) for block in blocks for line in block.splitlines()]
    assert told[0][:4] == ["python", "-m", "pip", "install"]
    assert told[-1][:4] == ["python", "-m", "pip", "uninstall"]
    return told[1:-1]


def python(folder, *words):
    """What Python prints where the page's files are."""
    done = subprocess.run([sys.executable, *words], cwd=folder, env={**os.environ, "PYTHONPATH": str(folder)},
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def told_errors():
    """The page's table: {time constant, ms: (finger's error, filter's), deg}."""
    rows = [line.strip("| ").split(" | ") for line in PAGE.read_text().splitlines() if line.startswith("| ")]
    return {float(row[0]): (float(row[1]), float(row[2])) for row in rows if row[0].isdigit()}


@pytest.mark.slow
def test_every_command_of_the_page_runs(package):
    told = commands()
    assert [words[:2] for words in told] == [["python", "-m"], ["fesloop", "check"], ["fesloop", "run"],
                                             ["fesloop", "run"]]
    for words in told:
        python(package, *(["-m", "fesloop"] if words[0] == "fesloop" else []), *words[1:])


@pytest.mark.slow
def test_the_errors_are_those_that_the_page_tells(package):
    told = told_errors()
    metrics = json.loads(python(package, "-c", RUNS, *map(str, told)))
    found = [(each["joint_rmse_deg"][0], each["tracker_rmse_deg"][0]) for each in metrics]
    assert len(told) == 5
    assert np.allclose(found, list(told.values()), rtol=0, atol=0.02)


@pytest.fixture
def block(package, monkeypatch):
    monkeypatch.syspath_prepend(str(package))
    return importlib.import_module("low_pass").LowPass(time_constant_ms=30.0)


def test_its_parameters_are_frozen_and_documented(block):
    contract.test_parameters_are_frozen_and_documented(block)


@pytest.mark.parametrize("kept", [
    contract.test_the_same_inputs_give_the_same_bits, contract.test_declared_ports_are_kept,
    contract.test_something_comes_out_that_depends_on_what_goes_in,
    contract.test_inputs_and_past_outputs_are_left_alone])
def test_it_keeps_the_contract_of_every_block(kept, block):
    kept("low_pass", block)


@pytest.mark.parametrize("at", [0, 1, 17])
def test_saved_and_restored_it_goes_on_as_if_uninterrupted(block, at):
    contract.test_save_restore_continue_equals_uninterrupted("low_pass", block, at)


def test_a_trouble_is_told_once_and_the_output_held(block):
    state, feeds = block.init(parts.context("low_pass")), parts.feed(block, 4)
    feeds[2][0] = feeds[2][0]._replace(value=feeds[2][0].value * float("nan"))
    seen = parts.step_through("low_pass", block, state, feeds)
    assert [[status for status, _ in reports] for _, reports in seen] == [[], [], ["no_angles"], []]
    assert (seen[2][0][0] == seen[1][0][0]).all()

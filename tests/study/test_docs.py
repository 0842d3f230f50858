"""What docs/studies.md says is so."""

import re
import subprocess
import sys
import tomllib
from collections import deque
from pathlib import Path

import pytest

from fesloop.analysis.study import load, study_of
from fesloop.analysis.study.design.plan import plan
from fesloop.apps.cli.parser import make_parser

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "studies.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


def test_every_cell_of_the_study_file_that_is_shown_can_be_run():
    for form, runs in (("", 240), ("full", 2400)):
        study = study_of(tomllib.loads(blocks("toml")[0]), form)
        assert study.runs == runs
        deque(plan(study, lambda cell: ()), maxlen=0)


def test_the_cost_that_is_shown_names_the_runs_of_its_form():
    document = tomllib.loads(blocks("toml")[0])
    assert f"{study_of(document, 'full').runs} runs" in document["forms"]["full"]["cost"]


def test_commands_are_those_of_the_program():
    for line in "".join(blocks("sh")).splitlines():
        assert make_parser().parse_args(line.split()[1:]).command == "study"


@pytest.mark.slow
def test_the_study_in_python_runs_and_its_results_can_be_read(tmp_path):
    script = tmp_path / "three.py"
    script.write_text(blocks("python")[1])
    told = subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True, capture_output=True,
                          text=True)
    assert told.stdout == "3\n"
    results = load(tmp_path / "studies" / "three")
    assert [cell.levels for cell in results.cells("error_deg", by=["latency_ms"])] == [
        {"latency_ms": 0}, {"latency_ms": 50}, {"latency_ms": 100}]


@pytest.mark.slow
def test_without_the_line_that_guards_it_the_script_is_told_of_that_line(tmp_path):
    guard = 'if __name__ == "__main__":'
    script = tmp_path / "three.py"
    script.write_text(blocks("python")[1].replace(guard, "if True:"))
    told = subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=False, capture_output=True,
                          text=True)
    assert told.returncode == 1
    assert told.stdout == ""
    lines = [line for line in told.stderr.splitlines() if line.startswith("fesloop.errors.")]
    # The script's own, and that of each worker that got so far before the script ended them.
    assert 2 <= len(lines) <= 3
    assert "another fesloop study" not in told.stderr
    for line in lines:
        assert guard in line

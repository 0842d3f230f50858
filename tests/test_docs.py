"""What the pages of docs/ and the README show can be typed: commands, tables and links."""

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from fesloop.apps.cli.parser import make_parser
from fesloop.experiment.files.parse import from_document
from fesloop.models.evoked_torque import UNDER_ELECTRODES

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page, language):
    """Fenced blocks of a page in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


def command_lines(page):
    """Lines of commands: all of blocks that are run, and those behind `$ ` of blocks that are only shown."""
    shown = [line.removeprefix("$ ") for block in blocks(page, "console") for line in block.splitlines()
             if line.startswith("$ ")]
    return [line for block in blocks(page, "sh") for line in block.splitlines()] + shown


def arguments(line):
    """Of each command of fesloop in a line, without variables before and redirections behind it."""
    for command in line.split(" & "):
        words = shlex.split(command, comments=True)
        while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):
            del words[0]
        if words[:1] == ["fesloop"]:
            yield words[1:words.index(">")] if ">" in words else words[1:]


def test_commands_and_tables_are_found():
    assert sum(len(list(arguments(line))) for page in PAGES for line in command_lines(page)) > 100
    assert sum(len(blocks(page, "toml")) for page in PAGES) > 10


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_command_is_one_of_the_program(page):
    for line in command_lines(page):
        for given in arguments(line):
            make_parser().parse_args(given)


def test_no_file_is_a_patient_in_one_place_and_a_model_in_another():
    experiments = sorted((ROOT / "fesloop/experiment/shipped").rglob("*.toml"))
    text = "\n".join(path.read_text() for path in [*PAGES, *experiments])
    patients = re.findall(r"(?:patient=|--patient |fesloop patient \w+ > )(\w+\.toml)", text)
    models = re.findall(r"(?:\bmodel=|fesloop identify \S+\.h5 --out )(\w+\.toml)", text)
    assert {"own_patient.toml"} <= set(patients)
    assert {"own_model.toml"} <= set(models)
    assert not set(patients) & set(models)


def test_the_names_of_electrodes_are_listed_with_the_muscles_under_them():
    page = (ROOT / "docs/howto/stimulation_recordings.md").read_text()
    listed = re.findall(r"^\| `([\w ]+)` \| ([A-Z][\w, ]+) \| [-A-Z]+ \|$", page, re.MULTILINE)
    assert listed == [(name, ", ".join(muscles)) for name, muscles in UNDER_ELECTRODES.items()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_table_of_settings_is_toml(page):
    for block in blocks(page, "toml"):
        tomllib.loads(block)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_file_that_is_there(page):
    for target in re.findall(r"\]\(([^)#\s]+)", page.read_text()):
        assert target.startswith("https://") or (page.parent / target).exists(), target


def test_the_drawing_of_the_worked_example_is_the_one_that_the_loop_gives(tmp_path):
    target = tmp_path / "time_line.svg"
    subprocess.run([sys.executable, ROOT / "docs/_drawings/time_line.py", target], check=True, timeout=120)
    assert target.read_text() == (ROOT / "docs/time_line.svg").read_text()


def test_the_experiment_in_python_runs_and_is_the_one_in_toml(tmp_path, monkeypatch, capsys):
    page = ROOT / "docs/howto/own_experiment.md"
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(compile(blocks(page, "python")[0], page.name, "exec"), names)
    written, = (from_document(tables) for tables in map(tomllib.loads, blocks(page, "toml"))
                if "extends" not in tables)
    assert names["experiment"] == written
    error, = names["result"].metrics["joint_rmse_deg"]
    assert error < 5.0
    assert str([error]) in capsys.readouterr().out

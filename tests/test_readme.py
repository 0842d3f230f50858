"""What the README says is so."""

import re
import shlex
from pathlib import Path

import pytest

from fesloop.apps.cli.parser import make_parser
from fesloop.experiment.files.parse import load

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


COMMANDS = [command for block in blocks("sh") for line in block.splitlines() for command in line.split(" & ")]


def test_the_first_screen_has_a_command_that_runs_and_one_that_tests():
    first = TEXT.splitlines()[:24]
    assert any(line.endswith("fesloop run grasp_ilc") for line in first)
    assert any(line.endswith("-m pytest") for line in first)


@pytest.mark.parametrize("line", [line for line in COMMANDS if line.startswith("fesloop ")])
def test_every_command_is_one_that_the_program_knows(line):
    args = make_parser().parse_args(shlex.split(line.partition(" > ")[0])[1:])
    settings = [each for each in getattr(args, "settings", [])
                if "models/" not in each and each != "channels=model"]
    # A model that a command before it makes: here another's will do.
    settings = ["any_patient=true" if each in ("model=own_model.toml", "model=swept.toml") else each
                for each in settings]
    of_a_run = any(each.startswith("recording=runs/") for each in settings)
    if hasattr(args, "experiment") and not of_a_run:
        assert load(args.experiment, settings).name == args.experiment

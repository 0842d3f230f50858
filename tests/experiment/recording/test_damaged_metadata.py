"""Recordings whose description is damaged are refused in one line, by whatever command opens them."""

import json
import os
import shutil
from pathlib import Path

import h5py
import pytest
from toml_mutants import at

from fesloop import load
from fesloop.apps.cli import main
from fesloop.experiment.running import run

SMALL = Path(__file__).resolve().parents[1] / "small.toml"


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return run(load(SMALL), tmp_path_factory.mktemp("run")).recording


def refused(capsys, path, command):
    arguments = {"report": ("--out", f"{path}.html"), "fit-error": (f"{path}.toml",),
                 "picture": ("--out", f"{path}-pictures"), "identify": ("--out", f"{path}.toml"),
                 "export": ("--format", "xdf", "--out", f"{path}.xdf"), "check": (),
                 "run": ("--out", f"{path}-runs")}[command]
    # Of a file that is no sound recording, a report says why, and what is in it.
    assert main(["--traceback", command, str(path), *arguments]) == (0 if command == "report" else 2)
    line = capsys.readouterr().err.splitlines()[0]
    assert line.startswith("fesloop: ") or command == "report"
    assert str(path) in line or command == "report"
    assert line.isprintable()


COMMANDS = ["report", "fit-error", "picture", "identify", "export", "check", "run"]
VALUES = [None, 3, "\x1b[31m", [], {"x": 1}, [1.5]]
PLACES = [("experiment",), ("experiment", "name"), ("experiment", "trials"), ("blocks",), ("blocks", "pid"),
          ("blocks", "finger", "kind"), ("wires",), ("wires", 0), ("wires", 0, "from"), ("score",),
          ("score", "truth")]
RIGHT = {("experiment", "name"): ["\x1b[31m"], ("experiment", "trials"): [3], ("wires",): [[]],
         ("blocks", "finger", "kind"): ["\x1b[31m"], ("wires", 0, "from"): ["\x1b[31m"],
         ("score", "truth"): ["\x1b[31m"]}
"""Values that are of the right type there."""


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("path", PLACES, ids=lambda path: ".".join(map(str, path)))
def test_tables_of_another_type(capsys, tmp_path, sound, path, command):
    value = VALUES[(PLACES.index(path) + COMMANDS.index(command)) % len(VALUES)]
    if value in RIGHT.get(path, []):
        value = True
    file = tmp_path / "damaged.h5"
    shutil.copy(sound, file)
    with h5py.File(file, "r+") as opened:
        document = json.loads(opened["experiment"][()])
        at(document, path[:-1])[path[-1]] = value
        del opened["experiment"]
        opened["experiment"] = json.dumps(document)
    refused(capsys, file, command)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("where", "key", "text"), [
    ("/", "wires", "[1]"), ("/", "wires", '["a'), ("/", "versions", "[]"), ("/", "versions", '{"x": 1}'),
    ("/blocks/pid", "units", '{"stimulation": null}'), ("/plants/finger", "units", '{"angles": NaN}'),
    ("/blocks/pid", "units", "")])
def test_attributes_of_another_type(capsys, tmp_path, sound, where, key, text, command):
    file = tmp_path / "damaged.h5"
    shutil.copy(sound, file)
    with h5py.File(file, "r+") as opened:
        opened[where].attrs[key] = text
    refused(capsys, file, command)


def _group_for_rows(file):
    del file["blocks/pid"]
    file.create_group("blocks/pid")


def _wall_text(file):
    del file["wall/deadlines"]
    file["wall/deadlines"] = "many"


def _empty(file):
    del file["experiment"]
    file["experiment"] = h5py.Empty("f")


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("damage", [_group_for_rows, _wall_text, _empty])
def test_datasets_of_another_kind(capsys, tmp_path, sound, damage, command):
    if damage is _wall_text and command != "report":
        pytest.skip("looks at no wall-clock facts")
    file = tmp_path / "damaged.h5"
    shutil.copy(sound, file)
    with h5py.File(file, "r+") as opened:
        damage(opened)
    os.utime(file, (0, 0))
    refused(capsys, file, command)

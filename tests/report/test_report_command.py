"""`fesloop report`: where the page goes, what is printed, what is refused."""

import json
import shutil

import pytest

from fesloop.apps.cli import main
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return run(load("finger_control", ["experiment.duration_s=2"]), tmp_path_factory.mktemp("runs")).recording


@pytest.fixture
def copied(recording, tmp_path):
    return shutil.copy(recording, tmp_path / "finger-1.h5")


def test_the_page_lies_beside_the_recording(copied, tmp_path, capsys):
    assert main(["report", str(copied)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{tmp_path / 'finger-1.html'}\n"
    assert "The tracking error" in err
    assert (tmp_path / "finger-1.html").read_text().lstrip().startswith("<!doctype html>")


def test_json_is_one_object(copied, tmp_path, capsys):
    assert main(["report", str(copied), "--out", str(tmp_path / "a.html"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["report"] == str(tmp_path / "a.html")
    assert told["bytes"] == (tmp_path / "a.html").stat().st_size
    assert told["kind"] == "run"
    assert told["notes"] == []


@pytest.mark.parametrize("arguments", [
    ["{run}", "--out", "{run}"], ["{folder}/none.h5"], ["{folder}"],
    ["{run}", "--out", "{folder}/a/b/c.html"]])
def test_what_cannot_be_done_is_refused_in_one_line(copied, tmp_path, capsys, arguments):
    given = [each.format(run=copied, folder=tmp_path) for each in arguments]
    before = (tmp_path / "finger-1.h5").read_bytes()
    assert main(["report", *given]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert (tmp_path / "finger-1.h5").read_bytes() == before


def test_a_folder_of_recordings_is_told_what_it_is(copied, capsys):
    assert main(["report", str(copied.parent)]) == 2
    assert "is a folder of recordings" in capsys.readouterr().err


def test_several_runs_are_compared(copied, recording, tmp_path, capsys):
    assert main(["report", str(copied), str(recording), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["kind"] == "comparison"
    assert told["report"] == str(tmp_path / f"finger-1_and_{recording.stem}.html")


def test_of_several_runs_a_damaged_one_says_what_it_lost(copied, recording, tmp_path, capsys):
    cut = tmp_path / "cut.h5"
    cut.write_bytes(recording.read_bytes()[:recording.stat().st_size * 3 // 4])
    assert main(["report", str(copied), str(cut)]) == 0
    assert "cut.h5: The file was cut short" in capsys.readouterr().err

"""The programs that put pictures and results into docs/."""

import io
import json
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fesloop import InputError
from fesloop.experiment.files.source import shipped

DOCS = Path(__file__).resolve().parents[2] / "docs"


def program(name):
    spec = spec_from_file_location(f"docs_{name}", DOCS / f"{name}.py")
    module = sys.modules[spec.name] = module_from_spec(spec)  # its dataclasses look it up by its name
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def pictures():
    return program("pictures")


def test_pictures_are_of_shipped_experiments(pictures):
    assert set(pictures.SHOTS) <= set(shipped())
    assert {before for shot in pictures.SHOTS.values() for before in shot.after} <= set(pictures.SHOTS)


def test_a_wide_picture_is_kept_small_and_looks_the_same(pictures, tmp_path):
    x, y = np.meshgrid(np.linspace(0.0, 255.0, 2400), np.linspace(0.0, 255.0, 1000))
    Image.fromarray(np.stack([x, y, 0.0 * x], axis=2).astype(np.uint8)).save(tmp_path / "wide.png")
    pictures.keep(tmp_path / "wide.png", tmp_path / "kept.png")
    kept = Image.open(tmp_path / "kept.png").convert("RGB")
    assert (tmp_path / "kept.png").stat().st_size < pictures.MOST_BYTES
    assert kept.size == (1200, 500)
    np.testing.assert_allclose(kept.getpixel((900, 125)), (191, 64, 0), atol=24)


@pytest.mark.slow
def test_a_picture_that_cannot_be_small_is_refused(pictures, tmp_path):
    noise = np.random.default_rng(0).integers(0, 256, (900, 1200, 3), np.uint8)
    Image.fromarray(noise).save(tmp_path / "noise.png")
    with pytest.raises(InputError, match="draw less"):
        pictures.keep(tmp_path / "noise.png", tmp_path / "kept.png")


def test_a_result_is_kept_with_how_it_was_made(tmp_path, monkeypatch):
    keep_result = program("keep_result")
    monkeypatch.setattr(keep_result, "RESULTS", tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO('{"paper": "it", "rows": []}'))
    head = subprocess.CompletedProcess(["git"], 0, "abc\n")
    monkeypatch.setattr(subprocess, "run", lambda command, **_: head)
    assert keep_result.main(["fesloop", "reproduce", "it"]) == 0
    kept = json.loads((tmp_path / "it.json").read_text())
    assert kept["found"] == {"paper": "it", "rows": []}
    assert (kept["command"], kept["commit"]) == ("fesloop reproduce it", "abc")


def test_a_result_without_its_command_is_refused(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO('{"paper": "it"}'))
    assert program("keep_result").main([]) == 2
    assert "usage" in capsys.readouterr().err

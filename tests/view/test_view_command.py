"""`fesloop view`: what it refuses, and how it runs and ends."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest
from view_parts import ToldSource, events, serving

from controllers.reference import MinimumJerk
from fesloop import Experiment
from fesloop.apps.cli import main
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.loop.nodes import Node


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    settings = ["experiment.duration_s=1", "score.after_s=0"]
    return Path(run(load("finger_control", settings), tmp_path_factory.mktemp("runs")).recording)


@pytest.fixture
def niceness(monkeypatch):
    """What the command asks for; this process stays as it is."""
    asked = []
    monkeypatch.setattr(os, "nice", asked.append)
    return asked


def refused(capsys, *args):
    """The one line that the command ends with."""
    assert main(["view", *args]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    return lines[0]


def cut(path, target, share):
    """The first part of a file, as one that nobody writes to any more."""
    target.write_bytes(path.read_bytes()[:int(share * path.stat().st_size)])
    os.utime(target, (0, 0))
    return target


def first_row_at(path):
    """Where in a recording's file the first row of any of its streams of signals lies, bytes."""
    places = []

    def note(name, item):
        if isinstance(item, h5py.Dataset) and item.chunks:
            item.id.chunk_iter(lambda chunk: places.append(chunk.byte_offset))

    with h5py.File(path, "r") as file:
        for kind in ("blocks", "plants", "inputs"):
            file[kind].visititems(note)
    return min(places)


@pytest.mark.usefixtures("niceness")
class TestRefused:
    def test_nothing_and_two_things(self, capsys, path):
        assert "no source" in refused(capsys)
        assert "both" in refused(capsys, str(path), "--stream", "postures")

    @pytest.mark.parametrize("option", [("--side", "left"), ("--network", "lab")])
    def test_what_is_a_streams_alone(self, capsys, path, option):
        assert refused(capsys, str(path), *option).startswith(f"fesloop: {option[0]}: {option[1]}")

    @pytest.mark.slow
    def test_what_is_no_recording(self, capsys, tmp_path):
        text, other, half = (tmp_path / name for name in ("text.h5", "other.h5", "half.h5"))
        text.write_text("no recording")
        with h5py.File(other, "w") as file:
            file["numbers"] = [1, 2]
        for file in (tmp_path / "absent.h5", text, other, tmp_path):
            assert str(file) in refused(capsys, str(file))
        half.write_bytes(other.read_bytes()[:500])
        assert str(half) in refused(capsys, str(half))

    def test_a_folder_and_what_to_give_instead(self, capsys, tmp_path, path):
        assert "is a folder, without recordings" in refused(capsys, str(tmp_path))
        for number in range(7):
            (tmp_path / f"run-{number}.h5").touch()
        told = refused(capsys, str(tmp_path))
        assert "run-0.h5, run-1.h5, run-2.h5, run-3.h5, run-4.h5 and 2 more" in told
        assert f"fesloop view {tmp_path}/run-0.h5" in told
        (tmp_path / "study.sqlite").touch()
        told = refused(capsys, str(tmp_path))
        assert "is a study's folder" in told
        assert f"fesloop report {tmp_path}" in told

    def test_a_recording_of_which_no_hand_is_left(self, capsys, tmp_path, path):
        share = first_row_at(path) / path.stat().st_size
        said = refused(capsys, str(cut(path, tmp_path / "cut.h5", share)))
        assert str(tmp_path / "cut.h5") in said
        assert "is damaged, and what is left of it holds no hand" in said

    def test_a_recording_without_a_hand(self, capsys, tmp_path):
        reference = Node("reference", MinimumJerk(times_s=(0.0,), angles_deg=((10.0, 20.0, 30.0),)), "100")
        found = Experiment(name="none", nodes=(reference,), duration_s=0.1).run(tmp_path)
        assert "holds no hand" in refused(capsys, str(found.recording))

    def test_a_port_that_is_taken(self, capsys, path):
        with serving(ToldSource()) as server:
            port = str(server.server_port)
            assert f"--port {port}: is taken" in refused(capsys, str(path), "--port", port)
        assert "--port 99999" in refused(capsys, str(path), "--port", "99999")

    def test_a_stream_without_pylsl(self, capsys, monkeypatch):
        monkeypatch.setattr("fesloop.streams.live.library._opened", {})
        monkeypatch.setitem(sys.modules, "pylsl", None)
        assert "pip install 'fesloop[lsl]'" in refused(capsys, "--stream", "postures")


@pytest.mark.slow
def test_of_a_damaged_recording_what_is_left_is_served_and_what_is_not_is_said(path, tmp_path):
    process = subprocess.Popen([sys.executable, "-m", "fesloop", "view",
                                str(cut(path, tmp_path / "cut.h5", 0.6))], stderr=subprocess.PIPE, text=True)
    said = []
    while not said or "http://" not in said[-1]:
        said.append(process.stderr.readline())
        assert said[-1], said
    assert said[0].startswith("fesloop: The file is damaged")
    assert any("rows are left" in line for line in said)
    with events(int(re.search(r"127\.0\.0\.1:(\d+)/", said[-1])[1])) as frames:
        assert len(next(frames)["hands"]["truth"]) == 17
    process.send_signal(signal.SIGTERM)
    rest = process.communicate(timeout=120.0)[1]
    assert process.returncode == 0
    assert "Traceback" not in rest


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_at_the_lowest_priority_until_it_is_ended(path, number):
    process = subprocess.Popen([sys.executable, "-m", "fesloop", "view", str(path)],
                               stderr=subprocess.PIPE, text=True)
    said = process.stderr.readline()
    port = int(re.search(r"http://127\.0\.0\.1:(\d+)/", said)[1])
    assert os.getpriority(os.PRIO_PROCESS, process.pid) == 19
    with events(port) as frames:
        assert len(next(frames)["hands"]["truth"]) == 17
        process.send_signal(number)
        began = time.monotonic()
        rest = process.communicate(timeout=120.0)[1]
    assert process.returncode == 0
    assert time.monotonic() - began < 100.0
    assert "Traceback" not in rest

"""The fuzz bench: that it finds what it is after, and that 300 spoilt files of a fixed seed find nothing.

The 300 files take about 30 s.
"""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from fesloop.apps.bench import _fuzz_reading, fuzz
from fesloop.errors import InputError

HELD = []


def allocate(folder, name):
    HELD.append(np.ones(60_000_000))


def say_too_much(folder, name):
    raise InputError("file", "bad") from None


class Unclear(InputError):
    """A fault of two lines that claims to be one."""

    def __str__(self):
        return "one\ntwo"


def two_lines(folder, name):
    raise Unclear("file", "bad")


OUTCOMES = {
    "hang": lambda folder, name: time.sleep(30.0),
    "crash": lambda folder, name: os.kill(os.getpid(), signal.SIGKILL),
    "memory": allocate,
    "write": lambda folder, name: (folder / "source" / "more").write_text("x"),
    "KeyError": lambda folder, name: {}["gyr"],
    "unclear": two_lines,
    "refused": say_too_much,
    "read": lambda folder, name: (folder / "target" / "motion.h5").write_text("x"),
    "no answer": lambda folder, name: os._exit(0),
}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("outcome", list(OUTCOMES))
def test_each_way_to_go_wrong_is_told_from_the_others(tmp_path, monkeypatch, outcome):
    for part in ("source", "target", "tmp", "cwd"):
        (tmp_path / part).mkdir()
    monkeypatch.setitem(_fuzz_reading._READERS, "made", OUTCOMES[outcome])
    monkeypatch.setattr(_fuzz_reading, "LONGEST_S", 2.0 if outcome == "hang" else 20.0)
    if outcome == "memory":
        monkeypatch.setattr(_fuzz_reading, "MOST_BYTES", 400_000_000)
        monkeypatch.setattr(_fuzz_reading.resource, "setrlimit", lambda *_: None)
    told = _fuzz_reading._in_a_child("made", tmp_path, "lab.xdf")
    assert told["outcome"] == outcome, told
    assert told["seconds"] < 4.0
    if outcome == "memory":
        assert told["bytes"] == pytest.approx(480e6, rel=0.5)


@pytest.mark.slow
def test_three_hundred_spoilt_files_do_no_harm():
    shares = []
    result = fuzz.run(short=True, progress=shares.append)
    assert list(result) == ["bench", "rows", "files", "bad_files"]
    assert result["files"] == 300
    assert [(row["case"], row["bad"]) for row in result["rows"] if row["bad"]] == []
    assert shares[-1] == 1.0
    for row in result["rows"]:
        assert row["read"] + row["refused"] == row["files"]
        assert row["refused"] > 0, row
        assert row["us_worst"] < 5e6
    assert {"xdf", "bids", "mat5", "mat73", "npz", "csv", "motion", "run"} <= {
        row["case"] for row in result["rows"]}


def test_a_file_is_spoilt_alike_each_time(tmp_path):
    seeds = fuzz.make_seeds(tmp_path)
    for kind, sound in seeds.items():
        first = [fuzz.spoilt(kind, sound, number) for number in range(4)]
        assert first == [fuzz.spoilt(kind, sound, number) for number in range(4)]
        assert any(files != sound.files for files in first)
    assert not Path("/tmp", fuzz.spoil.ESCAPED).exists()

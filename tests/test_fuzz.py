"""Spoilt files: that the harness finds what it is after, and that a few of every format do no harm.

`python tests/fuzz.py` reads 10,000.
"""

import os
import time
from pathlib import Path

import fuzz
import pytest
from fuzz_seeds import make_seeds

from fesloop.errors import InputError


class Unclear(InputError):
    """A fault of two lines that claims to be one."""

    def __str__(self):
        return "one\ntwo"


def fail(fault):
    raise fault


@pytest.mark.parametrize(("outcome", "read"), [
    ("KeyError", lambda folder, name: fail(KeyError("gyr"))),
    ("unclear", lambda folder, name: fail(Unclear("file", "bad"))),
    ("refused", lambda folder, name: fail(InputError("file", "bad"))),
    ("read", lambda folder, name: None)])
def test_outcomes_are_known_apart(tmp_path, outcome, read):
    assert fuzz.outcome_of(read, tmp_path, "lab.xdf")["outcome"] == outcome


def test_a_worker_that_dies_or_hangs_is_noticed_and_started_again(tmp_path, monkeypatch):
    script = tmp_path / "worker.py"
    script.write_text("import os, sys, time\nname = sys.stdin.readline()\n"
                      "os.kill(os.getpid(), 9) if '\"dies\"' in name else time.sleep(600)\n")
    monkeypatch.setattr(fuzz, "__file__", str(script))
    monkeypatch.setattr(fuzz, "PATIENCE_S", 1.0)
    with fuzz.Worker() as worker:
        assert worker.read("recording", tmp_path, "hangs")["outcome"] == "hang"
        began = time.monotonic()
        monkeypatch.setattr(fuzz, "PATIENCE_S", 60.0)
        found = worker.read("recording", tmp_path, "dies")
    assert found["outcome"] == "crash"
    assert time.monotonic() - began < 60.0


def test_writes_elsewhere_are_noticed(tmp_path):
    watch = fuzz.Watch()
    watch.allowed = (f"{tmp_path}/target",)
    for event, path, flags in (("open", tmp_path / "target/new", os.O_WRONLY), ("open", "/etc", os.O_RDONLY)):
        watch.note(event, (str(path), "", flags))
    assert watch.writes == []
    watch.note("open", (str(tmp_path / "more"), "w", os.O_WRONLY | os.O_CREAT))
    watch.note("os.mkdir", (str(tmp_path / "targets"), 0o777, -1))
    assert len(watch.writes) == 2


def test_spoilt_files_do_no_harm():
    rows = fuzz.run(200)
    assert sum(row["files"] for row in rows) == 200
    assert [(row["format"], row["bad"]) for row in rows if row["bad"]] == []
    for row in rows:
        assert row["read"] + row["refused"] == row["files"]
        assert row["refused"] > 0 or row["format"] == "fmu", row
    assert {"xdf", "bids", "mat5", "mat73", "npz", "csv", "motion", "run", "stimulation", "stimulation_npz",
            "stimulation_tables"} <= {row["format"] for row in rows}


def test_a_file_is_spoilt_alike_each_time(tmp_path):
    seeds = make_seeds(tmp_path)
    for kind, sound in seeds.items():
        first = [fuzz.spoilt(kind, sound, number) for number in range(4)]
        assert first == [fuzz.spoilt(kind, sound, number) for number in range(4)]
        assert any(files != sound.files for files in first)
    assert not Path("/tmp", fuzz.spoil.ESCAPED).exists()

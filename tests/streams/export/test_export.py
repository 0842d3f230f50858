"""What is exported, where it goes, and that bad input leaves nothing behind."""

import json
import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from export_parts import BLOCK, INPUT, PLANT, Node, times, write_run

import fesloop
from fesloop import InputError, Recording
from fesloop.apps.cli import main
from fesloop.errors import RunError
from fesloop.experiment.export import FORMATS, export
from fesloop.experiment.recording import reading
from fesloop.experiment.recording import reading as signal_table

SMALL = Path(__file__).parents[2] / "experiment" / "small.toml"


@pytest.fixture
def run(tmp_path):
    """Three trials with everything that a format takes."""
    nodes = [Node("tracker", BLOCK, {"angles": ("rad", (2,)), "orientation": ("1", (2, 4))}),
             Node("finger", PLANT, {"angles": ("rad", (2,))}), Node("finger", INPUT, {"drive": ("1", (1,))})]
    for node in nodes:
        for trial in range(3):
            node.add(times(20), {port: np.full((20, *shape), trial + 0.5)
                                 for port, (_, shape) in node.ports.items()})
    (tmp_path / "in").mkdir()
    return write_run(tmp_path / "in" / "run.h5", nodes)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_real_run_goes_into_every_format_but_what_it_has_not(kind, tmp_path):
    recorded = fesloop.load(SMALL).run(tmp_path / "runs").recording
    if kind == "sto":
        with pytest.raises(InputError, match="records no orientations"):
            export(recorded, kind, tmp_path / "out")
        return
    exported = export(recorded, kind, tmp_path / "out")
    assert exported.files
    assert all(path.stat().st_size for path in exported.files)


@pytest.mark.parametrize("kind", FORMATS)
def test_the_run_of_a_killed_process_is_exported_alike(kind, tmp_path):
    nodes = [Node("tracker", BLOCK, {"angles": ("rad", (2,)), "orientation": ("1", (2, 4))})]
    nodes[0].add(times(500), {"angles": np.random.default_rng(8).normal(size=(500, 2)), "orientation": 0.5})
    contents = []
    for killed in (False, True):
        recorded = write_run(tmp_path / str(killed) / "run.h5", nodes, killed=killed)
        with Recording(recorded) as recording:
            assert recording.status == ("running" if killed else "done")
        files = export(recorded, kind, tmp_path / str(killed) / "out").files
        contents.append([path.read_bytes().replace(b"running", b"done") for path in files
                         if path.suffix != ".mat"])
    assert contents[0] == contents[1]


def test_all_trials_and_signals_or_those_that_are_named(run, tmp_path):
    names = [path.name for path in export(run, "mot", tmp_path / "a").files]
    assert names == [f"trial-{trial}_{node}.angles.mot" for trial in range(3)
                     for node in ("finger", "tracker")]
    one = export(run, "mot", tmp_path / "b.mot", trial=2, signals=["finger.angles"])
    assert one.files == (tmp_path / "b.mot",)
    assert "143.2394487827058" in one.path.read_text()
    assert [path.name for path in export(run, "xdf", tmp_path / "c").files] == [
        f"trial-{trial}_run.xdf" for trial in range(3)]
    tables = {path.name for path in export(run, "csv", tmp_path / "d", trial=0).files}
    assert tables == {"trial-0_events.csv", "trial-0_finger.csv", "trial-0_finger.drive.csv",
                      "trial-0_tracker.csv"}


REFUSED = {
    "unknown format": ({"format": "c3d"}, "--format: 'c3d'; allowed: motion-bids, xdf, mat, mot, sto, csv"),
    "unknown signal": ({"signals": ["tracker.angle"]},
                       "--signals: 'tracker.angle' is not recorded; .*; did you mean 'tracker.angles'"),
    "no signal": ({"signals": []}, "--signals: no name"),
    "trial beyond": ({"trial": 3}, "--trial: 3; allowed: 0 to 2"),
    "trial below": ({"trial": -1}, "--trial: -1; allowed: 0 to 2"),
    "one file for several": ({"format": "mat", "out": "o.mat"}, "is one file, and 3 are to be written"),
    "one file for tables": ({"out": "o.csv"}, "o.csv: is one file, and tables and events are to be written"),
    "one file for a folder": ({"format": "motion-bids", "out": "o.motion-bids"},
                              "o.motion-bids: is one file, and tables and their descriptions"),
    "name of another format": ({"format": "mat", "out": "o.STO"}, r"o\.STO: has the ending of another"),
    "no recording": ({"run": "absent.h5"}, "absent.h5: there is no such recording"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_named_and_nothing_is_made(name, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    changed, message = REFUSED[name]
    with pytest.raises(InputError, match=message):
        export(**{"run": run, "format": "csv", **changed})
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_a_target_that_exists_is_left_alone(run, tmp_path):
    for out in ("folder", "file.xdf", "link"):
        target = tmp_path / out
        if out == "folder":
            target.mkdir()
        elif out == "link":
            target.symlink_to(tmp_path / "nowhere")
        else:
            target.write_text("mine")
        with pytest.raises(InputError, match="is there already; allowed: a name that is free"):
            export(run, "xdf", target, trial=0)
    assert (tmp_path / "file.xdf").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file.xdf", "folder", "in", "link"]


def test_a_target_that_came_meanwhile_is_left_alone(run, tmp_path, monkeypatch):
    target = tmp_path / "one.xdf"

    def late(selection, folder):
        (folder / "x.xdf").write_text("ours")
        target.write_text("theirs")
        return []

    monkeypatch.setattr(FORMATS["xdf"], "write", late)
    with pytest.raises(RunError, match=r"one\.xdf: cannot be written: File exists; nothing was exported"):
        export(run, "xdf", target, trial=0)
    assert target.read_text() == "theirs"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in", "one.xdf"]


def test_a_folder_below_a_file_is_refused(run, tmp_path):
    with pytest.raises(InputError, match=r"nothing can be made there: (Not a directory|File exists)"):
        export(run, "csv", run / "out")


def test_a_run_without_a_row_is_refused(tmp_path):
    empty = write_run(tmp_path / "run.h5", [Node("n", BLOCK, {"y": ("1", ())})])
    with pytest.raises(InputError, match="has no row of any trial"):
        export(empty, "xdf", tmp_path / "out")


@pytest.mark.parametrize("fault", [KeyboardInterrupt, OSError("no number"), ValueError])
def test_nothing_is_left_of_an_export_that_is_cut_short(fault, run, tmp_path, monkeypatch):
    def cut(selection, folder):
        (folder / "half.xdf").write_bytes(b"x" * 1000)
        raise fault

    monkeypatch.setattr(FORMATS["xdf"], "write", cut)
    with pytest.raises(RunError if isinstance(fault, OSError) else fault):
        export(run, "xdf", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_a_recording_whose_rows_are_damaged_says_so(tmp_path):
    node = Node("n", BLOCK, {"y": ("1", (400,))}).add(times(2000), {"y": np.zeros((2000, 400))})
    recorded = write_run(tmp_path / "run.h5", [node])
    with h5py.File(recorded, "r") as file:
        offset = file["blocks/n"].id.get_chunk_info(20).byte_offset
    os.truncate(recorded, offset)
    with pytest.raises((InputError, RunError)):
        export(recorded, "csv", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


ON_A_SMALL_DISK = """
import sys
import tracemalloc
from pathlib import Path
from fesloop.errors import FesloopError
from fesloop.experiment.export import FORMATS, export

run, disk = sys.argv[1], Path(sys.argv[2])
for kind in FORMATS:
    try:
        export(run, kind, disk / "out", **({} if kind != "mat" else {"signals": ["n.angles"]}))
    except FesloopError as fault:
        print(kind, fault)
print(list(disk.iterdir()))
import subprocess
subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
try:
    export(run, "xdf", disk / "new")
except FesloopError as fault:
    print(fault)
"""


@pytest.mark.slow
def test_on_a_full_disk_and_a_read_only_one_the_fault_is_named_and_nothing_is_left(tmp_path):
    node = Node("n", BLOCK, {"angles": ("rad", (20,)), "orientation": ("1", (5, 4))})
    node.add(times(10_000), {"angles": np.full((10_000, 20), np.pi),
                              "orientation": np.full((10_000, 5, 4), 1 / 3)})
    recorded = write_run(tmp_path / "in" / "run.h5", [node])
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = f"mount -t tmpfs -o size=1m none {disk}"
    if subprocess.run(["unshare", "-rm", "sh", "-c", mount], capture_output=True, check=False).returncode:
        pytest.skip("this machine lets nobody mount a disk of their own")
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", f'{mount} && "$0" -c "$1" {recorded} {disk}', sys.executable,
         ON_A_SMALL_DISK], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])})
    *full, left, read_only = done.stdout.splitlines()
    assert [line.split(" ", 1)[0] for line in full] == list(FORMATS)
    for line in full:
        assert "the disk is full; make room, or give another folder; nothing was exported" in line
    assert left == "[]"
    assert "nothing can be made there: Read-only file system" in read_only


def test_the_command_prints_what_it_wrote(run, tmp_path, capsys):
    command = ["export", str(run), "--format", "mot", "--signals", "finger.angles, tracker.angles",
               "--trial", "1", "--out", str(tmp_path / "out"), "--json"]
    assert main(command) == 0
    report = json.loads(capsys.readouterr().out)
    assert [Path(path).name for path in report["files"]] == [
        "trial-1_finger.angles.mot", "trial-1_tracker.angles.mot"]
    assert main(command) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["export", str(run), "--format", "mot", "--signals", "finger.drive",
                 "--out", str(tmp_path / "b")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", FORMATS)
def test_memory_is_bounded_and_progress_is_told(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(signal_table, "_PIECE_BYTES", 2**16)
    monkeypatch.setattr(reading, "_KEPT_BYTES", 0)
    rows = 2000
    node = Node("n", BLOCK, {"angles": ("rad", (60,)), "orientation": ("1", (15, 4))})
    rng = np.random.default_rng(9)
    values = {"angles": rng.normal(size=(rows, 60)), "orientation": rng.normal(size=(rows, 15, 4))}
    recorded = write_run(tmp_path / "run.h5", [node.add(times(rows), values)])
    signals = {"mot": ["n.angles"], "sto": ["n.orientation"]}.get(kind, ["n.angles", "n.orientation"])
    every = sum(values[name.partition(".")[2]].nbytes for name in signals)
    fractions = []

    def note(fraction):
        if not fractions:
            tracemalloc.reset_peak()  # what opening takes does not count
        fractions.append(fraction)

    tracemalloc.start()
    export(recorded, kind, tmp_path / "out", signals=signals, progress=note)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < (1.5 if kind == "mat" else 0.5) * every  # SciPy holds a signal twice as it writes it
    assert len(fractions) > 10
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0

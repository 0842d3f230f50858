"""`fesloop study` as a user meets it."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress

import psutil
import pytest
from study_parts import started, write_study

from fesloop import load as load_experiment
from fesloop.analysis.study import load
from fesloop.analysis.study.design.shipped_studies import shipped_studies
from fesloop.apps.cli import main
from fesloop.apps.cli.study_command import StudyProgress

LATENCIES = "[axes.latency_ms]\nvalues = [0, 20, 40]\n"


@pytest.fixture
def study(tmp_path):
    return write_study(tmp_path, LATENCIES)


def refused(capsys, *arguments):
    """The lines of a refusal, which are in the object on standard output too."""
    code = main(["study", *map(str, arguments), "--json"])
    captured = capsys.readouterr()
    faults = json.loads(captured.out)["faults"]
    assert code == 2
    assert captured.err.splitlines()[-len(faults):] == [f"fesloop: {fault}" for fault in faults]
    return faults


@pytest.mark.parametrize(("arguments", "fault"), [
    (["--workers", "0"], "--workers: 0; allowed: 1 to 1024"),
    (["--workers", "-3", "--dry-run"], "--workers: -3; allowed: 1 to 1024"),
    (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "--workers: is given together with --scheduler"),
    (["--form", "full"], "--form full: there is no form of this name")])
def test_what_cannot_be_asked_for_is_refused_and_leaves_nothing(capsys, study, tmp_path, arguments, fault):
    (found,) = refused(capsys, study, *arguments, "--out", tmp_path / "out")
    assert fault in found
    assert not (tmp_path / "out").exists()


def test_an_unknown_name_is_answered_with_the_one_that_is_like_it(capsys, tmp_path):
    name = shipped_studies()[-1]
    (found,) = refused(capsys, f"{name}s", "--out", tmp_path / "out")
    assert f"did you mean '{name}'?" in found


def test_a_fault_of_a_cell_is_one_line_before_any_worker_is_started(capsys, tmp_path):
    study = write_study(tmp_path, "[axes.latncy_ms]\nvalues = [0, 1]")
    (found,) = refused(capsys, study, "--out", tmp_path / "out")
    assert re.search(r"tiny: axes\.latncy_ms: .*\(latncy_ms 0\).*did you mean 'latency_ms'", found)
    study = write_study(tmp_path, LATENCIES, more='[prepare.model]\nexperiment = "identify_graps"')
    (found,) = refused(capsys, study, "--out", tmp_path / "other")
    assert re.search(r"tiny: prepare\.model: identify_graps: .*did you mean 'identify_grasp'", found)


def test_without_dask_the_extra_is_named(capsys, study, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    (found,) = refused(capsys, study, "--out", tmp_path / "out")
    assert "pip install 'fesloop[study]'" in found


@pytest.mark.slow
def test_a_dry_run_says_what_the_study_takes_and_keeps_nothing(capsys, study, tmp_path):
    assert main(["study", str(study), "--dry-run", "--json", "--workers", "1", "--out",
                 str(tmp_path / "out" / "deep")]) == 0
    captured = capsys.readouterr()
    told = json.loads(captured.out)
    assert (told["cells"], told["runs"], told["done"], told["workers"]) == (3, 3, 0, 1)
    assert told["simulated_s"] == pytest.approx(0.9)
    assert 0.0 < told["least_s"] <= told["run_s"] <= told["most_s"]
    assert told["left_s"] == pytest.approx(3 * told["run_s"], rel=1.0)
    assert 0 < told["disk_bytes"] < 1e6 < told["free_bytes"]
    for word in ("runs", "time left", "disk"):
        assert word in captured.err
    assert not (tmp_path / "out").exists()


def test_a_dry_run_counts_the_models_that_come_before(capsys, tmp_path):
    study = write_study(
        tmp_path, "[axes.strength]\nkey = \"blocks.finger.strength\"\nvalues = [1.0, 1.2]\n"
        "[axes.move_weight]\nvalues = [0.05, 0.1]\n", experiment="grasp_mpc", duration_s=1.0,
        settings=["plant=finger", "experiment.trials=1"], metrics='error_deg = "joint_rmse_deg"',
        more='[prepare.model]\nexperiment = "identify_grasp"\nsettings = ["plant=finger"]\n'
        'axes = ["strength"]\n')
    assert main(["study", str(study), "--dry-run", "--json", "--workers", "1", "--out", str(tmp_path)]) == 0
    captured = capsys.readouterr()
    told = json.loads(captured.out)
    assert told["prepared"] == 2
    excited_s = load_experiment("identify_grasp", ["plant=finger"]).duration_ns / 1e9
    pace = told["left_s"] / told["simulated_s"]
    assert told["prepared_s"] == pytest.approx(2 * excited_s * pace)
    assert "models before these" in captured.err


def children(process):
    """Of a coordinator: its workers and what else it started."""
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(process.pid).children(recursive=True)
    return []


def listening(processes):
    """Addresses at which they listen."""
    found = set()
    for each in processes:
        with suppress(psutil.NoSuchProcess):
            found |= {place.laddr.ip for place in each.net_connections("inet") if place.status == "LISTEN"}
    return found


def finished(out):
    """Runs that have a result so far."""
    store = out / "tiny" / "study.sqlite"
    with suppress(ValueError):
        return load(store).finished if store.exists() else 0
    return 0


def gone_within(processes, seconds):
    """Those that are still there then."""
    return psutil.wait_procs(processes, timeout=seconds)[1]


def left_over(scratch):
    """Files of a study, and of workers; the locks with which Dask clears up after the killed are its own."""
    return [path for path in scratch.rglob("*")
            if path.name.startswith("fesloop-") or (path.is_file() and not path.name.endswith("lock"))]


@pytest.mark.slow
def test_a_study_that_is_ended_leaves_no_process_and_no_file_and_goes_on(tmp_path):
    """By Ctrl-C, by what schedulers of clusters send, and by what nobody can hear."""
    study, runs = write_study(tmp_path, LATENCIES, replicates=60, duration_s=2.0), 180
    out, scratch = tmp_path / "out", tmp_path / "scratch"
    scratch.mkdir()
    environment = {**os.environ, "TMPDIR": str(scratch)}
    addresses, had = set(), 0
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        with started(study, out, env=environment, start_new_session=True) as process:
            while finished(out) < had + 2:
                assert process.poll() is None
                addresses |= listening([psutil.Process(process.pid), *children(process)])
                time.sleep(0.05)
            processes = children(process)
            # A terminal sends Ctrl-C to the whole group.
            (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
            text, errors = process.communicate(timeout=60.0)
        assert process.returncode == (-9 if number == signal.SIGKILL else 130)
        assert text == ""
        assert "Traceback" not in errors
        if number != signal.SIGKILL:
            assert errors.splitlines()[-1] == "fesloop: interrupted"
            assert left_over(scratch) == []
        assert gone_within(processes, 10.0) == []
        had = finished(out)
    assert len(processes) >= 2
    assert addresses == {"127.0.0.1"}
    assert 6 <= had < runs
    with started(study, out, env=environment) as process:
        text, errors = process.communicate(timeout=120.0)
    assert json.loads(text)["done"] == runs
    assert left_over(scratch) == []


def screen(text, columns):
    """Lines that a terminal shows in the end; it knows returns, new lines and erasure to the end."""
    lines, column = [[]], 0
    for part in re.findall(r"\x1b\[[0-9;?]*[a-zA-Z]|[^\x1b]", text):
        if part == "\r":
            column = 0
        elif part == "\n":
            lines.append([])
        elif part == "\x1b[K":
            del lines[-1][column:]
        elif not part.startswith("\x1b"):
            if column == columns:
                lines.append([])
                column = 0
            lines[-1][column:column + 1] = part
            column += 1
    return ["".join(line).rstrip() for line in lines]


ON_A_TERMINAL = """
import time
from fesloop.apps.cli import study_command
study_command._REFRESH_S = 0.0
watch = study_command.StudyProgress("tiny")
watch.stage("check", 0.5)
for done in range(5):
    watch.runs(done, {"a cause that takes more room than a terminal of forty columns has": 1}, 10)
    time.sleep(0.01)
watch.finish()
print("after", flush=True)
"""


def test_on_a_terminal_one_line_renews_itself_and_is_taken_away():
    ours, theirs = pty.openpty()
    subprocess.run([sys.executable, "-c", ON_A_TERMINAL], stdout=theirs, stderr=theirs, check=True,
                   env={**os.environ, "COLUMNS": "40"})
    os.close(theirs)
    text = b""
    with suppress(OSError):
        while some := os.read(ours, 65536):
            text += some
    os.close(ours)
    assert "tiny: 5 of 10 runs" in text.decode()
    assert screen(text.decode(), 40) == ["after", ""]


def test_rate_and_time_left_are_those_of_the_last_minute(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    watch = StudyProgress("tiny")
    for second in range(0, 201, 5):
        now[0] = float(second)
        # Ten a second for 100 s, then two a second, some of them failing.
        over = 10 * min(second, 100) + 2 * max(0, second - 100)
        watch.runs(over - over // 10, {"late": over // 10}, 2000)
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("tiny: 1190 of 2000 runs, 2.0 a second, 7 min left, 119 failed, most: late")


def test_where_there_is_no_terminal_a_line_comes_now_and_then(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    watch = StudyProgress("tiny")
    for share in range(100):
        watch.stage("check", share / 100)
    for second in range(60):
        now[0] = float(second)
        watch.runs(second, {}, 600)
    watch.finish()
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "tiny: check"
    assert 4 <= len(lines) <= 6
    assert "1.0 a second, 9 min left" in lines[-1]

import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from told_recording import broken, summed

from fesloop.apps.reproduce import cohort
from fesloop.apps.reproduce.cohort import Job, run_jobs
from fesloop.errors import InputError, RunError

ROOT = Path(__file__).resolve().parents[2]
SMALL = str(ROOT / "tests" / "experiment" / "small.toml")
SCRIPT = f"""
import sys
sys.path.insert(0, {str(ROOT / "tests")!r})
from fesloop.apps.reproduce.cohort import Job, run_jobs
from told_recording import summed
print(run_jobs([Job((seed,), {SMALL!r}, (), seed, summed) for seed in (1, 2)], 2)[(2,)]["trials"])
"""


def jobs(score=summed, settings=()):
    return [Job(("subject", seed), SMALL, settings, seed, score) for seed in (1, 2, 3)]


def children(pid):
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_processes():
    told = []
    alone = run_jobs(jobs(), 1, told.append)
    assert list(alone) == [("subject", 1), ("subject", 2), ("subject", 3)]
    assert told == pytest.approx([1 / 3, 2 / 3, 1.0])
    assert run_jobs(jobs(), 2) == alone


def test_a_run_that_fails_is_named(monkeypatch):
    monkeypatch.setattr(cohort, "run", lambda *given: SimpleNamespace(status="failed", cause="it diverged"))
    with pytest.raises(RunError, match=r"subject 1 \(seed 1\): it diverged$"):
        run_jobs(jobs(), 1)


def test_a_person_who_cannot_do_the_script_is_a_run_that_fails(monkeypatch):
    def refuse(*given):
        raise InputError("contacts", "stay 3 mm off")

    monkeypatch.setattr(cohort, "run", refuse)
    with pytest.raises(RunError, match=r"subject 1 \(seed 1\): contacts: stay 3 mm off"):
        run_jobs(jobs(), 1)


def test_an_interrupted_run_is_an_interruption(monkeypatch):
    monkeypatch.setattr(cohort, "run", lambda *given: SimpleNamespace(status="interrupted", cause=""))
    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs(), 1)


@pytest.mark.slow
def test_settings_that_are_wrong_are_so_in_other_processes_too():
    with pytest.raises(InputError, match="nothing"):
        run_jobs(jobs(settings=("nothing=1",)), 2)


@pytest.mark.slow
def test_what_a_scoring_raises_is_raised_here():
    with pytest.raises(ValueError, match="cannot be scored") as fault:
        run_jobs(jobs(score=broken), 2)
    assert "in broken" in fault.value.__notes__[0]


@pytest.mark.slow
def test_a_script_without_main_guard_runs_once(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("2\n", "")


@pytest.mark.slow
def test_ctrl_c_ends_in_one_line_and_leaves_no_process(tmp_path):
    # Where the tests run in a shell's background, Ctrl-C is ignored by all that is begun there.
    hears = ("import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
             "from fesloop.apps.cli import main; sys.exit(main())")
    process = subprocess.Popen(
        [sys.executable, "-c", hears, "reproduce", "kortier2014", "--subjects", "2", "--workers", "2",
         "--out", str(tmp_path)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    # Patient: on a busy machine imports alone take long, and who still imports hears no signal.
    limit = time.monotonic() + 60.0
    while len(workers := children(process.pid)) < 2 and time.monotonic() < limit:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert len(workers) == 2
    assert (process.returncode, out, err) == (130, "", "fesloop: interrupted\n")
    # Who has ended stays listed until the system's first process has noticed.
    limit = time.monotonic() + 60.0
    while any(Path(f"/proc/{pid}").exists() for pid in workers) and time.monotonic() < limit:
        time.sleep(0.05)
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers)

import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from fesloop.apps.reproduce.worker import Worker
from fesloop.errors import InputError, RunError


@pytest.fixture
def worker():
    one = Worker()
    yield one
    one.end()


def test_calls_are_answered_one_after_the_other_by_the_same_process(worker):
    assert worker.call(math.factorial, 5) == 120
    with pytest.raises(ValueError, match="factorial"):
        worker.call(math.factorial, -1)
    first, second = (worker.call(eval, "__import__('os').getpid()") for _ in range(2))
    assert first == second != os.getpid()


def test_what_is_printed_there_does_not_come_between(worker):
    assert worker.call(eval, "print('hello') or 3") == 3


def test_faults_that_cannot_travel_are_told_by_their_text(worker):
    text = "(_ for _ in ()).throw(type('Odd', (Exception,), {})('of its own'))"
    with pytest.raises(RunError, match="Odd: of its own"):
        worker.call(eval, text)


def test_a_process_that_ends_by_itself_is_told(worker):
    with pytest.raises(RunError, match="ended by itself"):
        worker.call(os._exit, 3)
    with pytest.raises(RunError, match="ended by itself"):
        worker.call(abs, 1)


def test_what_it_does_is_broken_off_at_the_end():
    worker = Worker()
    worker.call(abs, 1)
    threading.Timer(0.3, worker.end).start()
    began = time.monotonic()
    with pytest.raises(RunError):
        worker.call(time.sleep, 60)
    assert time.monotonic() - began < 50.0


def test_a_function_of_the_script_is_refused(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text("from fesloop.apps.reproduce.worker import Worker\n"
                      "def own(x): return x\n"
                      "worker = Worker()\n"
                      "try:\n    worker.call(own, 1)\n"
                      "except Exception as fault:\n    print(type(fault).__name__, fault)\n"
                      "worker.end()\n")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith(InputError.__name__)
    assert "move it out of the script" in done.stdout


@pytest.mark.slow
def test_it_ends_with_the_process_that_began_it(tmp_path):
    code = ("import os; from fesloop.apps.reproduce.worker import Worker; worker = Worker(); "
            "print(worker.call(eval, \"__import__('os').getpid()\"), flush=True); os.kill(os.getpid(), 9)")
    began = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, timeout=60)
    assert began.returncode == -signal.SIGKILL
    limit = time.monotonic() + 60.0
    running = Path(f"/proc/{int(began.stdout)}")
    while running.exists() and time.monotonic() < limit:
        time.sleep(0.05)
    assert not running.exists()

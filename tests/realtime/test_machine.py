"""What the system is asked for: granted or refused, in words, and taken back; in other processes."""

import subprocess
import sys

import pytest

from fesloop.posix import attainable

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="of Linux")
SHOW = """
import os, resource, sys
from pathlib import Path
import fesloop.posix  # before the test becomes a user who cannot read it
from fesloop.loop.machine import realtime_privileges

def locked_kb():
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmLck:")))

def state():
    policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    return policy, os.sched_getparam(0).sched_priority, locked_kb() > 0
"""


def shown(code):
    """Lines that code prints in another process."""
    command = [sys.executable, "-c", SHOW + code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def test_what_is_granted_is_in_force_and_taken_back():
    told, during, child, after = shown("""
before = state()
with realtime_privileges(True, 7) as granted:
    print(granted.memory, "/", granted.scheduling, flush=True)
    print(state(), flush=True)
    pid = os.fork()
    if pid == 0:
        print(state()[:2], flush=True)
        os._exit(0)
    os.waitpid(pid, 0)
print(state() == before)
""")
    memory, _, scheduling = told.partition(" / ")
    assert memory.startswith(("locked", "refused: "))
    assert scheduling == "SCHED_FIFO, priority 7" or scheduling.startswith("refused: ")
    in_force = ((1, 7) if scheduling.startswith("SCHED_FIFO") else (0, 0))
    assert during == str((*in_force, memory.startswith("locked")))
    assert child == "(0, 0)", "children are as any other program"
    assert after == "True"


def test_threads_beside_the_loop_are_raised_and_set_back():
    """Those that were named and are there; one that is started later is as any other program's."""
    granted, during, later, after = shown("""
import threading
from fesloop.loop.machine import threads_now

def policies(*threads):
    return [os.sched_getscheduler(thread.native_id) & ~os.SCHED_RESET_ON_FORK for thread in threads]

def started(over):
    thread = threading.Thread(target=over.wait)
    thread.start()
    return thread

before, over, soon = threads_now(), threading.Event(), threading.Event()
named, ends = started(over), started(soon)
numbers = threads_now() - before
assert numbers == {named.native_id, ends.native_id}
soon.set()
ends.join()
other = started(over)
with realtime_privileges(False, 7, numbers) as granted:
    print(granted.scheduling)
    print(policies(named, other))
    late = started(over)
    print(policies(late))
print(policies(named, other, late), state()[:2])
over.set()
""")
    if granted.startswith("refused: "):
        assert during == "[0, 0]"
    else:
        assert granted == "SCHED_FIFO, priority 7, with 1 thread beside the loop's"
        assert during == "[1, 0]"
    assert later == "[0]"
    assert after == "[0, 0, 0] (0, 0)"


def test_an_ordinary_user_gets_the_common_class_back():
    """To them the kernel refuses to take back the mark by which children do not inherit a class."""
    granted, after = shown("""
with realtime_privileges(False, 7) as granted:
    print(granted.scheduling)
    if os.geteuid() == 0:
        os.setuid(65534)
print(state())
""")
    assert granted == "SCHED_FIFO, priority 7" or granted.startswith("refused: ")
    assert after == "(0, 0, False)"


def test_what_is_not_asked_for_is_left_alone():
    told, unchanged = shown("""
before = state()
with realtime_privileges(False, 0) as granted:
    print(granted.memory, "/", granted.scheduling)
    print(state() == before)
""")
    assert told == "not locked: not requested / as any other program"
    assert unchanged == "True"


def test_what_is_refused_says_why_and_the_run_goes_on():
    memory, scheduling, unchanged = shown("""
resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
if os.geteuid() == 0:
    os.setuid(65534)
before = state()
with realtime_privileges(True, 7) as granted:
    print(granted.memory)
    print(granted.scheduling)
    print(state() == before)
""")
    assert memory.startswith("refused: ")
    assert memory.endswith("the limit is 0.1 MB (ulimit -l)")
    assert scheduling.startswith("refused: needs CAP_SYS_NICE")
    assert unchanged == "True"


@pytest.mark.parametrize(("limit", "wanted", "attained"), [
    (50, 99, 50), (50, 7, 7), (0, 99, 99), (-1, 99, 99)])  # 0: asking is left to be refused; -1: no limit
def test_an_ordinary_user_has_as_high_a_priority_as_the_limit_lets_them(monkeypatch, limit, wanted, attained):
    monkeypatch.setattr("resource.getrlimit", lambda which: {resource.RLIMIT_RTPRIO: (limit, limit)}[which])
    assert attainable(wanted) == attained

"""What the operating system is asked for a run in real time, and what it grants: told in words, undone later.

Memory is locked (`mlockall(2)`), so that no page of the run is swapped out; pages are locked as they come
into use, not before. Where the limit on locked memory (RLIMIT_MEMLOCK) is not lifted, what comes later is
left out: the allocations of a run would fail at the limit. The scheduling class is SCHED_FIFO (`sched(7)`)
only if a priority is asked for: such a thread that never rests keeps everything else of its core waiting.
Processes that the run starts do not inherit it.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
"""Of Linux's <asm-generic/mman.h>."""
_CAP_IPC_LOCK = 14
"""Number of the capability that lifts the limit on locked memory (`capabilities(7)`)."""


_NOT_LOCKED, _COMMON = "not locked: not asked for", "as any other program"


@dataclass(frozen=True, slots=True)
class Granted:
    """What a run got.

    Attributes
    ----------
    memory, scheduling: in words; what was refused says why.
    """

    memory: str
    scheduling: str


@contextmanager
def asked_of_machine(lock_memory: bool, priority: int) -> Iterator[Granted]:
    """Ask for locked memory and for SCHED_FIFO of a priority (0: do not); take all of it back at the end."""
    scheduler, parameters = _scheduling_now()
    scheduling = _raise_priority(priority) if priority else _COMMON
    memory = _lock_memory() if lock_memory else _NOT_LOCKED
    try:
        yield Granted(memory, scheduling)
    finally:
        if memory.startswith("locked"):
            _libc().munlockall()
        if parameters is not None and scheduling.startswith("SCHED_FIFO"):
            os.sched_setscheduler(0, scheduler, parameters)


def attainable(priority: int) -> int:
    """This priority, or that which an ordinary user may ask for (RLIMIT_RTPRIO) where that is lower."""
    if sys.platform != "linux":
        return priority
    import resource

    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return limit if 0 < limit < priority else priority


def _scheduling_now() -> tuple[int, os.sched_param | None]:
    if sys.platform != "linux":
        return 0, None
    return os.sched_getscheduler(0), os.sched_getparam(0)


def _raise_priority(priority: int) -> str:
    if sys.platform != "linux":
        return f"refused: {sys.platform} has no SCHED_FIFO"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except PermissionError:
        return "refused: needs CAP_SYS_NICE, or a limit such as 'rtprio 50' in /etc/security/limits.conf"
    except OSError as fault:
        return f"refused: {fault.strerror}"
    return f"SCHED_FIFO, priority {priority}"


def _lock_memory() -> str:
    if sys.platform != "linux":
        return f"refused: not known how on {sys.platform}"
    import resource  # there is none on some other systems

    limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    unlimited = limit == resource.RLIM_INFINITY or bool(int(_told_of_self("CapEff"), 16) >> _CAP_IPC_LOCK & 1)
    if _told_of_self("VmLck").split()[0] != "0":
        return "was locked before the run"
    which = _MCL_CURRENT | _MCL_ONFAULT | (_MCL_FUTURE if unlimited else 0)
    libc = _libc()
    if libc.mlockall(which) == 0:
        return "locked" if unlimited else "locked as far as it was in use at the start"
    reason = os.strerror(ctypes.get_errno())
    return f"refused: {reason}; the limit is {limit / 1e6:.1f} MB (ulimit -l)"


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _told_of_self(key: str) -> str:
    """A line of what the kernel tells of this process (`proc(5)`, status)."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8", errors="replace").splitlines()
    return next(line.partition(":")[2].strip() for line in lines if line.startswith(f"{key}:"))

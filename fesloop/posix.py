"""Calls to Linux and POSIX, with substitutes on other systems.

Other modules of the library name no such call, but for those that need Linux as a whole, which are imported
after `require_linux` alone: processes that hold a stimulator, FMUs in processes of their own, and some
measurements of speed. `tests/test_posix.py` holds both.

Locked memory and SCHED_FIFO are those of a run in real time (`fesloop.loop.machine`); the limits are those of
the process that reads foreign files (`fesloop.streams.reading`).
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

from fesloop.errors import InputError

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
"""Flags of mlockall in Linux's <asm-generic/mman.h>."""
_CAP_IPC_LOCK = 14
"""Number of the capability that lifts the limit on locked memory (`capabilities(7)`)."""


def is_linux() -> bool:
    """Whether this is Linux."""
    return sys.platform == "linux"


def require_linux(where: str, what: str, remedy: str) -> None:
    """Raise InputError, which begins with `where`, on another system than Linux."""
    if not is_linux():
        raise InputError(where, f"{what} needs Linux, and this is {sys.platform}", "Linux", remedy)


Scheduling = dict[int, tuple[int, Any]]
"""Class and parameters of threads, by their numbers; 0 is the calling one."""


def scheduling_of(threads: Collection[int]) -> Scheduling:
    """Class and parameters of threads; those that have ended are left out, and all where there are none."""
    found: Scheduling = {}
    if sys.platform == "linux":
        for thread in threads:
            with suppress(ProcessLookupError):
                found[thread] = os.sched_getscheduler(thread), os.sched_getparam(thread)
    return found


def raise_priority(priority: int, threads: Collection[int]) -> str:
    """Raise the priority of threads, the calling one first; return the outcome in words."""
    if sys.platform != "linux":
        return f"refused: {sys.platform} has no SCHED_FIFO"
    raised = 0
    for thread in threads:
        try:
            os.sched_setscheduler(thread, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
        except ProcessLookupError:
            continue
        except PermissionError:
            return "refused: needs CAP_SYS_NICE, or a limit such as 'rtprio 50' in /etc/security/limits.conf"
        except OSError as fault:
            return f"refused: {fault.strerror}"
        raised += 1
    others = "1 thread" if raised == 2 else f"{raised - 1} threads"
    return f"SCHED_FIFO, priority {priority}" + (f", with {others} beside the loop's" if raised > 1 else "")


def set_back(before: Mapping[int, tuple[int, Any]], here: Collection[int]) -> None:
    """Give threads that are still `here` the class that they had.

    Only root may undo that children do not inherit a class; for the common class it has no meaning.
    """
    for thread, (scheduler, parameters) in before.items():
        if sys.platform != "linux" or (thread and thread not in here):
            continue
        with suppress(ProcessLookupError):
            try:
                os.sched_setscheduler(thread, scheduler, parameters)
            except PermissionError:
                os.sched_setscheduler(thread, scheduler | os.SCHED_RESET_ON_FORK, parameters)


def attainable(priority: int) -> int:
    """The priority, or the greatest that an ordinary user may request (RLIMIT_RTPRIO) where that is lower."""
    if sys.platform != "linux":
        return priority
    import resource

    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return limit if 0 < limit < priority else priority


def lock_memory() -> str:
    """Lock the memory of this process; return the outcome in words, which begin with "locked" if it is."""
    if sys.platform != "linux":
        return f"refused: not known how on {sys.platform}"
    import resource

    limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    unlimited = limit == resource.RLIM_INFINITY or bool(int(_own_status("CapEff"), 16) >> _CAP_IPC_LOCK & 1)
    if _own_status("VmLck").split()[0] != "0":
        return "was locked before the run"
    which = _MCL_CURRENT | _MCL_ONFAULT | (_MCL_FUTURE if unlimited else 0)
    if _libc().mlockall(which) == 0:
        return "locked" if unlimited else "locked as far as it was in use at the start"
    reason = os.strerror(ctypes.get_errno())
    return f"refused: {reason}; the limit is {limit / 1e6:.1f} MB (ulimit -l)"


def unlock_memory() -> None:
    """Undo `lock_memory`."""
    _libc().munlockall()


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _own_status(key: str) -> str:
    """A line of the kernel's status of this process (`proc(5)`)."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8", errors="replace").splitlines()
    return next(line.partition(":")[2].strip() for line in lines if line.startswith(f"{key}:"))


def limit_memory(more_bytes: int) -> None:
    """Limit the address space of this process to so much more than it has; no limit but on Linux."""
    if sys.platform == "linux":
        import resource

        with Path("/proc/self/statm").open() as pages:
            has = int(pages.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (has + more_bytes, resource.getrlimit(resource.RLIMIT_AS)[1]))


def limit_processor_time(until_s: int) -> None:
    """End this process once it has taken so much processor time; no limit on Windows."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (until_s, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def ran_out_of_time(ended_by: int) -> bool:
    """Whether a process that this signal ended had taken too much processor time."""
    return sys.platform != "win32" and ended_by in (signal.SIGXCPU, signal.SIGKILL)


def lower_priority() -> None:
    """Let every other process come first; nothing on Windows."""
    if sys.platform != "win32":
        os.nice(19)


@contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Block Ctrl-C in threads and processes that are started in the context, and in their children.

    The caller receives it afterwards. On Windows nothing is blocked.
    """
    if sys.platform == "win32":
        yield
        return
    # Python starts its resource tracker with the first process, and then unblocks interrupts.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

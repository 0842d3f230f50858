"""A session under way: a run in real time in a process of its own, and a device at its end."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from fesloop.apps.bench._device_log import given
from fesloop.errors import RunError

EXPERIMENT = "hil_dry_stimulator"
_DEVICE = "plants.devices.science_mode_peer"
_STARTS_S = 60.0
_ENDS_S = 30.0
_LOOK_S = 0.005


@dataclass(slots=True)
class Session:
    """What a fault can be done to, and where to look what came of it.

    Attributes
    ----------
    loop: the run's process.
    device: the simulated device's, which takes faults on its standard input; None with `dry`.
    log: of the device.
    recordings: folder, as it is seen from here.
    """

    loop: subprocess.Popen[str]
    device: subprocess.Popen[str] | None
    log: Path
    recordings: Path

    def tell_device(self, fault: str) -> None:
        """A fault on demand."""
        assert self.device is not None
        assert self.device.stdin is not None
        self.device.stdin.write(f"{fault}\n")
        self.device.stdin.flush()

    def ended(self) -> str:
        """What it said on standard error, once it has ended."""
        try:
            return self.loop.communicate(timeout=_ENDS_S)[1]
        except subprocess.TimeoutExpired:
            raise RunError(f"the session did not end within {_ENDS_S:g} s of its fault") from None

    def recording(self) -> Path:
        """The file of the run."""
        found = sorted(self.recordings.glob("*.h5"))
        if len(found) != 1:
            raise RunError(f"{len(found)} recordings where one is expected")
        return found[0]


@contextmanager
def session(folder: Path, driver: str, settings: Sequence[str], *, own_disk: bool) -> Iterator[Session]:
    """A run that stimulates; all its processes have ended when it is left.

    Parameters
    ----------
    folder: scratch.
    driver: `dry`, or `science_mode` with a simulated device.
    settings: more of `--set`.
    own_disk: whether it records onto a small disk of its own; RunError where this machine allows none.
    """
    log, runs = folder / "device.log", folder / "runs"
    runs.mkdir(parents=True)
    with ExitStack() as stack:
        port, device = log, None
        if driver != "dry":
            port = folder / "tty"
            device = stack.enter_context(_started([sys.executable, "-m", _DEVICE, str(port), str(log)], True))
            _wait(lambda: port.is_symlink() and log.exists(), device)
        inside, seen = stack.enter_context(_small_disk(runs)) if own_disk else ((), runs)
        loop = stack.enter_context(_started(
            [*inside, sys.executable, "-m", "fesloop", "run", EXPERIMENT, "--realtime", "--out", str(runs),
             *(word for setting in (f"driver={driver}", f"port={port}", *settings)
               for word in ("--set", setting))], False))
        _wait(lambda: any(row.on for row in given(log)), loop)
        yield Session(loop, device, log, seen)


@contextmanager
def _started(command: list[str], takes_input: bool) -> Iterator[subprocess.Popen[str]]:
    """A process that has ended when the context is left, whatever became of it."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE if takes_input else subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@contextmanager
def _small_disk(folder: Path, megabytes: int = 40) -> Iterator[tuple[tuple[str, ...], Path]]:
    """A disk in memory over `folder`, for processes started with the words that are given first.

    It exists in a namespace of its own, so that nobody needs to be allowed to mount for all; the path given
    second leads there from outside.
    """
    mount = f"mount -t tmpfs -o size={megabytes}m none {folder} && echo mounted && exec cat"
    with subprocess.Popen(["unshare", "-rm", "sh", "-c", mount], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as holder:
        assert holder.stdout is not None
        if holder.stdout.readline() != "mounted\n":
            raise RunError("this machine lets nobody mount a disk of their own")
        into = ("nsenter", "-t", str(holder.pid), "-U", "-m", "--preserve-credentials")
        yield into, Path(f"/proc/{holder.pid}/root{folder}")


def _wait(holds: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    """Until something is so; RunError where the process ends before."""
    until = time.monotonic() + _STARTS_S
    while not holds():
        if process.poll() is not None or time.monotonic() > until:
            process.kill()
            raise RunError(f"the session did not begin: {process.communicate()[1].strip()[-500:]}")
        time.sleep(_LOOK_S)

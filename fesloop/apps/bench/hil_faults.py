"""`fesloop bench hil_faults`: what becomes of current and recording when a session breaks.

A row a fault, tried at random moments of `hil_dry_stimulator`, each time in fresh processes. The times are
those from the fault to zero current, measured at the device's end of the line; `reference` is the time that
`fesloop check` states, so that `ratio`, of the worst, must be below 1. `recording_readable`, `cause_named`:
of how many; `lost_s`: the most that a recording misses before its fault; `stated_held`: of how many tries
current was zero in time; `without_current`: tries that do not count, for the safety block, or a machine too
busy for real time, had ended stimulation before. A fault that cannot be tried here is told as `not_tried`.
What befalls a live stream is `stream_faults`.

Each is tried fifty times, which takes some 25 minutes; in the short form three times.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fesloop.apps.bench._device_log import given, zero_after_ms
from fesloop.errors import FesloopError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S

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


_PATIENCE_S = 5.0
_SESSION_LOOK_S = 0.01
_BLOCK_BYTES = 2**18
_FULL_MS = 1000.0
"""The stated time until a full disk is found out: a run writes every 0.4 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A fault.

    Attributes
    ----------
    name: of it.
    strike: does it to a session.
    cause: words that must be told afterwards, on standard error or in the recording.
    driver: of the device. A simulated science-mode device is beyond the line, as a real one is.
    alone: whether the device is left to itself.
    added_ms: to the stated time, until the loop can know.
    mend: what is done when current is zero, so that the session ends.
    settings: of the run.
    own_disk: whether it needs a small disk.
    """

    name: str
    strike: Callable[[Session], None]
    cause: str
    driver: str = "science_mode"
    alone: bool = False
    added_ms: float = 0.0
    mend: Callable[[Session], None] | None = None
    settings: tuple[str, ...] = ()
    own_disk: bool = False


def _kill(session: Session) -> None:
    session.loop.kill()


def _kill_keeper(session: Session) -> None:
    for child in Path(f"/proc/{session.loop.pid}/task").glob("*/children"):
        for process in child.read_text().split():
            if b"plants.devices.keeper" in Path(f"/proc/{process}/cmdline").read_bytes():
                os.kill(int(process), signal.SIGKILL)


def _stop(session: Session) -> None:
    session.loop.send_signal(signal.SIGSTOP)


def _continue(session: Session) -> None:
    session.loop.send_signal(signal.SIGCONT)


def _unplug(session: Session) -> None:
    session.tell_device("unplug")


def _fill_disk(session: Session) -> None:
    """To the last byte, as another program would."""
    with suppress(OSError), (session.recordings / "ballast").open("wb", buffering=0) as ballast:
        while ballast.write(bytes(_BLOCK_BYTES)):
            pass


def zero_or_late(session: Session) -> None:
    """Wait until there is no current, but not for ever."""
    until = time.monotonic_ns() + round(_PATIENCE_S * NS_PER_S)
    while time.monotonic_ns() < until and given(session.log)[-1].on:
        time.sleep(_SESSION_LOOK_S)


FAULTS = (
    Fault(name="loop process killed", strike=_kill, cause="loop_ended"),
    Fault(name="loop process stopped (SIGSTOP)", strike=_stop, mend=_continue, cause="silence"),
    Fault(name="keeper of the device killed", strike=_kill_keeper, alone=True, cause="keeper of the device"),
    Fault(name="device unplugged", strike=_unplug, alone=True, cause="unplugged"),
    Fault(name="disk full", strike=_fill_disk, own_disk=True, added_ms=_FULL_MS, cause="the disk is full"),
)
"""Every fault that is tried."""


_FEW, _MANY = 3, 50
_EARLIEST_S, _LATEST_S = 0.2, 4.5
"""After the first current; the session's movement lies within."""


class Outcome(NamedTuple):
    """What came of one fault.

    Attributes
    ----------
    zero_ms: to zero current; infinite where it never was.
    lost_s: of the recording before the fault; infinite where it cannot be read.
    named: whether the cause was told.
    """

    zero_ms: float
    lost_s: float
    named: bool


def run(short: bool = False, seed: int | None = None, progress: Callable[[float], None] | None = None,
        faults: Sequence[Fault] = FAULTS, moments: int | None = None) -> dict[str, Any]:
    """One row a fault; `seed` of the moments, None for new ones each time; `moments` of another count."""
    moments = (_FEW if short else _MANY) if moments is None else moments
    chance = random.Random(seed)
    rows, not_tried = [], []
    for number, fault in enumerate(faults):
        outcomes: list[Outcome] = []
        without = 0
        try:
            while len(outcomes) < moments and without <= _FEW * moments:
                outcome = _tried(fault, chance.uniform(_EARLIEST_S, _LATEST_S))
                if outcome is None:
                    without += 1
                    continue
                outcomes.append(outcome)
                if progress:
                    progress((number + len(outcomes) / moments) / len(faults))
        except RunError as why:
            not_tried.append({"fault": fault.name, "tried": len(outcomes), "why": str(why)})
        if outcomes:
            rows.append(_row(fault, outcomes) | {"without_current": without})
    return {"bench": "hil_faults", "rows": rows, "not_tried": not_tried}


def _tried(fault: Fault, after_s: float) -> Outcome | None:
    """A session, the fault, and what is left; None where there was no current when it was to begin."""
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder, \
            session(Path(folder), fault.driver, fault.settings, own_disk=fault.own_disk) as this:
        time.sleep(after_s)
        if not given(this.log)[-1].on:
            return None
        struck_ns = time.monotonic_ns()
        fault.strike(this)
        zero_or_late(this)
        if fault.mend is not None:
            fault.mend(this)
        said = this.ended()
        zero_ms = zero_after_ms(given(this.log), struck_ns)
        lost_s, told = _read(this.recording(), struck_ns)
    return Outcome(float("inf") if zero_ms is None else zero_ms, lost_s, fault.cause in said + told)


def _read(path: Path, struck_ns: int) -> tuple[float, str]:
    """How much of the recording is missing before the fault, s, and what it tells from then on."""
    try:
        with Recording(path) as recording:
            until_ns = struck_ns - int(recording.origins["monotonic_ns"][0])
            last_ns = int(recording.signal("safety.stimulation").times_ns.max(initial=0))
            told = " ".join(f"{event.status}: {event.detail}" for event in recording.events
                            if event.time_ns >= until_ns)
    except (FesloopError, IndexError):
        return float("inf"), ""
    return max(0, until_ns - last_ns) / NS_PER_S, told


def _row(fault: Fault, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    micros = 1e3 * np.array([outcome.zero_ms for outcome in outcomes])
    kept_ms, alone_ms = _stated_ms(fault)
    stated = 1e3 * ((alone_ms if fault.alone else kept_ms) + fault.added_ms)
    count = len(outcomes)
    return {"case": fault.name, "us_median": float(np.median(micros)),
            "us_p99": float(np.percentile(micros, 99)), "us_worst": float(micros.max()),
            "reference": "stated time", "reference_us_median": stated, "ratio": float(micros.max()) / stated,
            "count": count,
            "stated_held": f"{int((micros <= stated).sum())} of {count}",
            "recording_readable": f"{sum(np.isfinite(outcome.lost_s) for outcome in outcomes)} of {count}",
            "lost_s": float(max(outcome.lost_s for outcome in outcomes)), "cause": fault.cause,
            "cause_named": f"{sum(outcome.named for outcome in outcomes)} of {count}"}


def _stated_ms(fault: Fault) -> tuple[float, float]:
    """What the device states: zero current by the keeper, and by the device alone."""
    experiment = load(EXPERIMENT, [f"driver={fault.driver}", "port=/dev/null", *fault.settings])
    device: Any = experiment.wiring.node("device").part
    kept_ms, alone_ms = device.stated_ms
    return kept_ms, alone_ms

"""Time to zero current, and state of the recording, after faults of a session with a stimulator.

    python tests/hil_faults.py [--short]

prints JSON with one row per fault, tried at random moments of `hil_dry_stimulator`, each time in new
processes. Times run from the fault to zero current, measured at the device's end of the line. `reference` is
the time that `fesloop check` states; `ratio`, worst time over stated time, must be below 1.
`recording_readable`, `cause_named` and `stated_held` count tries; `lost_s` is the greatest part of a
recording missing before its fault. `without_current` counts discarded tries, in which the safety block, or a
machine too busy for real time, had already ended stimulation. `not_tried` lists faults that this machine
cannot cause. Faults of a live stream: `stream_faults`.

Each fault is tried fifty times, which takes some 25 minutes; three times with --short.
"""

from __future__ import annotations

import json
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

from fesloop.apps.bench.stream_faults import Given, given
from fesloop.errors import FesloopError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S

EXPERIMENT = "hil_dry_stimulator"
_DEVICE = str(Path(__file__).with_name("science_mode_peer.py"))
_STARTS_S = 60.0
_ENDS_S = 30.0
_LOOK_S = 0.005


def zero_after_ms(rows: list[Given], since_ns: int) -> float | None:
    """Time from an instant to zero current that lasts, ms; None while there is current.

    Raises RunError where there is no current at that instant: such a try shows nothing.
    """
    before = [row for row in rows if row.stamp_ns <= since_ns]
    if not before or not before[-1].on:
        raise RunError("the patient was not stimulated when the fault began")
    if rows[-1].on:
        return None
    last_on = max(number for number, row in enumerate(rows) if row.on)
    return max(0.0, (rows[last_on + 1].stamp_ns - since_ns) / NS_PER_MS)


@dataclass(slots=True)
class Session:
    """Processes and files of a running session.

    Attributes
    ----------
    loop: process of the run.
    device: process of the simulated device, which takes faults on its standard input; None with `dry`.
    log: log of the device.
    recordings: folder of recordings, as seen from this process.
    """

    loop: subprocess.Popen[str]
    device: subprocess.Popen[str] | None
    log: Path
    recordings: Path

    def tell_device(self, fault: str) -> None:
        """Cause a fault of the simulated device."""
        assert self.device is not None
        assert self.device.stdin is not None
        self.device.stdin.write(f"{fault}\n")
        self.device.stdin.flush()

    def ended(self) -> str:
        """Wait for the loop's end; its standard error."""
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
    """A run that stimulates; all its processes end with the context.

    Parameters
    ----------
    folder: temporary folder.
    driver: `dry`, or `science_mode` with a simulated device.
    settings: further `--set` settings.
    own_disk: whether to record onto a small disk of its own; RunError where this machine allows none.
    """
    log, runs = folder / "device.log", folder / "runs"
    runs.mkdir(parents=True)
    with ExitStack() as stack:
        port, device = log, None
        if driver != "dry":
            port = folder / "tty"
            device = stack.enter_context(_started([sys.executable, _DEVICE, str(port), str(log)], True))
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
    """A process that is killed when the context ends."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE if takes_input else subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@contextmanager
def _small_disk(folder: Path, megabytes: int = 40) -> Iterator[tuple[tuple[str, ...], Path]]:
    """A disk in memory over `folder`: the command prefix that enters it, and its path from outside.

    The disk exists in a mount namespace of its own, so no privilege is needed.
    """
    mount = f"mount -t tmpfs -o size={megabytes}m none {folder} && echo mounted && exec cat"
    with subprocess.Popen(["unshare", "-rm", "sh", "-c", mount], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as holder:
        assert holder.stdout is not None
        if holder.stdout.readline() != "mounted\n":
            raise RunError("this machine does not allow a mount namespace")
        into = ("nsenter", "-t", str(holder.pid), "-U", "-m", "--preserve-credentials")
        yield into, Path(f"/proc/{holder.pid}/root{folder}")


def _wait(holds: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    """Wait until a condition is true; RunError where the process ends before."""
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
"""Stated time until a full disk is noticed: a run writes every 0.4 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A fault of a session.

    Attributes
    ----------
    name: name of the fault.
    strike: causes the fault.
    cause: text that must afterwards appear on standard error or in the recording.
    driver: driver of the device. A simulated science-mode device is beyond the line, like a real one.
    alone: whether only the device itself can end current.
    added_ms: time added to the stated one, until the loop can notice the fault.
    mend: called when current is zero, so that the session ends.
    settings: settings of the run.
    own_disk: whether the fault needs a small disk.
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
    """Fill the disk to the last byte, as another program might."""
    with suppress(OSError), (session.recordings / "ballast").open("wb", buffering=0) as ballast:
        while ballast.write(bytes(_BLOCK_BYTES)):
            pass


def zero_or_late(session: Session) -> None:
    """Wait until there is no current, 5 s at most."""
    until = time.monotonic_ns() + round(_PATIENCE_S * NS_PER_S)
    while time.monotonic_ns() < until and given(session.log)[-1].on:
        time.sleep(_SESSION_LOOK_S)


FAULTS = (
    Fault(name="loop process killed", strike=_kill, cause="loop_ended"),
    Fault(name="loop process stopped (SIGSTOP)", strike=_stop, mend=_continue, cause="command_timeout"),
    Fault(name="keeper of the device killed", strike=_kill_keeper, alone=True, cause="keeper of the device"),
    Fault(name="device unplugged", strike=_unplug, alone=True, cause="unplugged"),
    Fault(name="disk full", strike=_fill_disk, own_disk=True, added_ms=_FULL_MS, cause="the disk is full"),
)
_FEW, _MANY = 3, 50
_EARLIEST_S, _LATEST_S = 0.2, 4.5
"""Range of a fault's instant after the first current; the session's movement lies within."""


class Outcome(NamedTuple):
    """Outcome of one try.

    Attributes
    ----------
    zero_ms: time to zero current; infinite if it stays.
    lost_s: missing part of the recording before the fault; infinite if the recording is unreadable.
    named: whether the cause is named.
    """

    zero_ms: float
    lost_s: float
    named: bool


def run(short: bool = False, seed: int | None = None, progress: Callable[[float], None] | None = None,
        faults: Sequence[Fault] = FAULTS, moments: int | None = None) -> dict[str, Any]:
    """Try each fault at random moments (`seed` None: new ones each time); a row per fault.

    `moments` overrides the number of tries per fault.
    """
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
    """Run a session with one fault; None where there is no current just before it."""
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
        lost_s, events = _read(this.recording(), struck_ns)
    return Outcome(float("inf") if zero_ms is None else zero_ms, lost_s, fault.cause in said + events)


def _read(path: Path, struck_ns: int) -> tuple[float, str]:
    """Missing part of the recording before the fault, s, and the text of its events from then on."""
    try:
        with Recording(path) as recording:
            until_ns = struck_ns - int(recording.origins["monotonic_ns"][0])
            last_ns = int(recording.signal("safety.stimulation").times_ns.max(initial=0))
            events = " ".join(f"{event.status}: {event.detail}" for event in recording.events
                              if event.time_ns >= until_ns)
    except (FesloopError, IndexError):
        return float("inf"), ""
    return max(0, until_ns - last_ns) / NS_PER_S, events


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
    """Stated times to zero current: by the keeper, and by the device alone."""
    experiment = load(EXPERIMENT, [f"driver={fault.driver}", "port=/dev/null", *fault.settings])
    device: Any = experiment.wiring.node("device").part
    kept_ms, alone_ms = device.stated_ms
    return kept_ms, alone_ms


if __name__ == "__main__":
    print(json.dumps(run(short="--short" in sys.argv), indent=1))

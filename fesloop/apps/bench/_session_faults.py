"""Faults that may befall a session, each a few lines: what is done to it, and what must come of it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fesloop.apps.bench._device_log import given
from fesloop.apps.bench._paced_session import Session
from fesloop.loop.clock import NS_PER_S

_PATIENCE_S = 5.0
_LOOK_S = 0.01
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
        time.sleep(_LOOK_S)


FAULTS = (
    Fault(name="loop process killed", strike=_kill, cause="loop_ended"),
    Fault(name="loop process stopped (SIGSTOP)", strike=_stop, mend=_continue, cause="silence"),
    Fault(name="keeper of the device killed", strike=_kill_keeper, alone=True, cause="keeper of the device"),
    Fault(name="device unplugged", strike=_unplug, alone=True, cause="unplugged"),
    Fault(name="disk full", strike=_fill_disk, own_disk=True, added_ms=_FULL_MS, cause="the disk is full"),
)
"""Every fault that is tried."""

"""Contract of stimulator drivers, and the faults that they report.

A driver is registered by name as an entry point of the group "fesloop.stimulators". It runs in the keeper's
process (`plants.devices.keeper`), which alone holds the device, and is called there by one thread.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any, ClassVar, Protocol

from plants.stimulator import Preset

Pulses = Sequence[tuple[float, float]]
"""Current, A, and pulse width, s, of each channel; zeros for a channel without pulses."""

FAULTS = {
    "no_answer": "the device did not answer in time",
    "wrong_checksum": "a frame from the device fails its checksum",
    "refused": "the device refused a command",
    "electrode_error": "the device finds no contact at an electrode",
    "unplugged": "the line to the device is gone",
    "device_failed": "the device reports a fault of its own",
}
"""Statuses of a device's faults."""

SLACK_MS = 50.0
"""Added to every stated time (chosen: three times the worst wake-up of a plain kernel under load, 16 ms)."""


class DeviceFault(Exception):
    """Fault of the device, or of the line to it, raised by a driver.

    Parameters
    ----------
    status: one of `FAULTS`.
    detail: description of the fault.
    """

    def __init__(self, status: str, detail: str) -> None:
        self.status, self.detail = status, detail
        super().__init__(f"{status}: {detail}")


class StimulatorDriver(Protocol):
    """Driver of one device. No method waits longer than stated; each raises DeviceFault and nothing else.

    Constructed with `(port, channels, hertz)`: the device's port, the number of channels in use, and the
    stimulation frequency, Hz, at which the device repeats the newest pulses.

    Attributes
    ----------
    preset: the device's channels, ranges, steps and latency.
    faults: members of `FAULTS` that the driver can raise.
    answer_ms: longest wait of `give` and `stop` for the device's answer.
    alone_ms: time for which the device itself continues to stimulate after the last message.
    open_s: longest duration of `open`.
    attend_ms: interval between calls of `attend`.
    """

    preset: ClassVar[Preset]
    faults: ClassVar[tuple[str, ...]]
    answer_ms: ClassVar[float]
    alone_ms: ClassVar[float]
    open_s: ClassVar[float]
    attend_ms: ClassVar[float]

    @staticmethod
    def check(port: str, channels: int, hertz: float) -> None:
        """Raise InputError, in the loop's process, for settings beyond the device, or a missing library."""

    def open(self) -> None:
        """Open the device, ready and without current."""

    def give(self, pulses: Pulses) -> None:
        """Start these pulses, within `preset`, on all channels; returns when the device has answered."""

    def attend(self) -> None:
        """Check for messages of the device, and keep the connection alive."""

    def stop(self) -> None:
        """Set zero current; returns when the device has confirmed it."""

    def close(self) -> None:
        """Release the device in any state; raises nothing."""


def driver_at(place: str) -> Any:
    """Import the class of a driver, given as "module:Class"."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


@contextmanager
def driver_faults() -> Iterator[None]:
    """Convert every exception of a driver into a DeviceFault."""
    try:
        yield
    except DeviceFault:
        raise
    except Exception as fault:  # anything else would end the keeper with the device running
        raise DeviceFault("device_failed", f"{type(fault).__name__}: {fault}") from fault


def stated_ms(driver: type[StimulatorDriver], hold_ms: float) -> tuple[float, float]:
    """Longest time from the last fresh command to zero current at the device, ms.

    The first holds while keeper and line work: `hold_ms`, and the answer to a pending command. The second
    holds without keeper or line, by the device alone.
    """
    return hold_ms + driver.answer_ms + SLACK_MS, driver.alone_ms + SLACK_MS

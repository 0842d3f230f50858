"""The contract of a driver: what the keeper of a stimulator asks of whatever speaks to the device.

A driver is registered by name as an entry point of the group "fesloop.stimulators". It lives in the keeper's
process (`plants.devices.keeper`), which alone holds the device, and is called there by one thread.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any, ClassVar, Protocol

from plants.stimulator.generations import Preset

Pulses = Sequence[tuple[float, float]]
"""Current, A, and pulse width, s, of each channel; a channel that gives nothing has zeros."""

FAULTS = {
    "no_answer": "the device did not answer in time",
    "wrong_checksum": "what came from the device fails its checksum",
    "refused": "the device refused a command",
    "electrode_error": "the device finds no contact at an electrode",
    "unplugged": "the line to the device is gone",
    "device_failed": "the device reports a fault of its own",
}
"""Statuses of what can go wrong at a device."""

SLACK_MS = 50.0
"""Added to every stated time (chosen: three times the worst wake-up of a plain kernel under load, 16 ms)."""


class DeviceFault(Exception):
    """What a driver raises when the device, or the line to it, fails.

    Parameters
    ----------
    status: one of `FAULTS`.
    detail: what happened, in words.
    """

    def __init__(self, status: str, detail: str) -> None:
        self.status, self.detail = status, detail
        super().__init__(f"{status}: {detail}")


class StimulatorDriver(Protocol):
    """Speaks to one device. No method waits longer than stated; each raises DeviceFault and nothing else.

    Made with `(port, channels, hertz)`: where the device is, how many of its channels are in use, and the
    stimulation frequency, Hz, at which it repeats the newest pulses by itself.

    Attributes
    ----------
    preset: the device's channels, ranges, steps and latency.
    faults: which of `FAULTS` it can raise.
    answer_ms: the longest that `give` and `stop` wait for the device's answer.
    alone_ms: how long the device itself goes on stimulating after the last thing it heard.
    open_s: the longest that `open` takes.
    attend_ms: how often `attend` wants to be called.
    """

    preset: ClassVar[Preset]
    faults: ClassVar[tuple[str, ...]]
    answer_ms: ClassVar[float]
    alone_ms: ClassVar[float]
    open_s: ClassVar[float]
    attend_ms: ClassVar[float]

    @staticmethod
    def check(port: str, channels: int, hertz: float) -> None:
        """Raise InputError, in the loop's process, for what the device cannot do or what is not installed."""

    def open(self) -> None:
        """Take hold of the device; it is ready and gives no current."""

    def give(self, pulses: Pulses) -> None:
        """From now on these pulses, within `preset`, on all channels; returns when the device answered."""

    def attend(self) -> None:
        """Look for what the device says by itself, and keep the connection alive."""

    def stop(self) -> None:
        """Zero current; returns when the device has said so."""

    def close(self) -> None:
        """Let the device go, whatever state it is in; raises nothing."""


def driver_at(place: str) -> Any:
    """The class of a driver, by "module:Class"; what its module raises when imported."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


@contextmanager
def driver_faults() -> Iterator[None]:
    """Whatever a driver raises is a fault of the device's."""
    try:
        yield
    except DeviceFault:
        raise
    except Exception as fault:  # anything else would end the keeper with the device running
        raise DeviceFault("device_failed", f"{type(fault).__name__}: {fault}") from fault


def stated_ms(driver: type[StimulatorDriver], hold_ms: float) -> tuple[float, float]:
    """The longest from the last fresh command to zero current at the device, ms.

    The first holds while the keeper lives and the line carries: `hold_ms`, and the answer to a command under
    way. The second holds where keeper or line are gone, and the device is alone.
    """
    return hold_ms + driver.answer_ms + SLACK_MS, driver.alone_ms + SLACK_MS

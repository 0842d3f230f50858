"""`dry`: a driver for rehearsals, which gives no current and logs its commands."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import ClassVar

from fesloop.errors import InputError
from plants.devices.driver import DeviceFault, Pulses
from plants.stimulator import PRESETS, Preset


class Dry:
    """Driver without a device; if `port` names a file, commands are logged there.

    An existing file is overwritten. A line has the instant (monotonic clock, ns), an event (`open`, `give`,
    `stop`, `close`) and, for `give`, the pulses of all channels as mA/us. Each line is written at once, so
    that the file is complete whichever process is killed. Ranges are those of the science-mode device, so
    that a rehearsal is limited like the real session.
    """

    preset: ClassVar[Preset] = PRESETS["generation1"]
    faults: ClassVar[tuple[str, ...]] = ("device_failed",)
    answer_ms: ClassVar[float] = 0.0
    alone_ms: ClassVar[float] = 0.0
    open_s: ClassVar[float] = 1.0
    attend_ms: ClassVar[float] = 1000.0

    def __init__(self, port: str, channels: int, hertz: float) -> None:
        self._path = Path(port) if port else None
        self._file = -1

    @staticmethod
    def check(port: str, channels: int, hertz: float) -> None:
        """Raise InputError where the file's folder does not exist."""
        if port and not Path(port).parent.is_dir():
            raise InputError("port", f"there is no folder {Path(port).parent}",
                             "a file for the log of `dry`, or nothing")

    def open(self) -> None:
        """Open the log."""
        if self._path is not None:
            try:
                self._file = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
            except OSError as fault:
                raise DeviceFault("device_failed", f"the log cannot be written: {fault}") from None
        self._write("open")

    def give(self, pulses: Pulses) -> None:
        """Log the pulses."""
        self._write("give", " ".join(f"{1e3 * current:.6g}/{1e6 * width:.6g}" for current, width in pulses))

    def attend(self) -> None:
        """Do nothing: there is no device."""

    def stop(self) -> None:
        """Log zero current."""
        self._write("stop")

    def close(self) -> None:
        """Close the log."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _write(self, event: str, pulses: str = "") -> None:
        if self._file < 0:
            return
        try:
            os.write(self._file, f"{time.monotonic_ns()}\t{event}\t{pulses}\n".encode())
        except OSError as fault:
            raise DeviceFault("device_failed", f"the log cannot be written: {fault}") from None

"""`science_mode`: an 8-channel stimulator that speaks ScienceMode 2 (RehaStim 2), through `pysciencemode`.

The protocol is "ScienceMode2, description and protocol" (HASOMED, 12 December 2012), as `pysciencemode` 1.1.5
and other open drivers implement it. The device sends Init every 500 ms until that is answered. It takes the
pulses of all channels in one command and repeats them at the main interval for as long as it receives
messages: after 1.2 s without one it disconnects and stops.

The library provides command numbers, frames and the meaning of error codes. Its class `Rehastim2` is not
used,
as it is unsafe in a control loop: its own thread keeps the connection alive while the process lives, so that
the device continues to stimulate when the program hangs; without an answer it waits for ever, at full load;
checksums of received frames are not checked; of two messages that arrive together the first is dropped; and
answers and error messages are compared only while it prints its log.
"""

from __future__ import annotations

from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from fesloop.errors import InputError
from plants.devices.driver import Pulses
from plants.stimulator import PRESETS, Preset

if TYPE_CHECKING:
    from plants.devices.science_mode_line import ScienceModeLine

_ALL_CHANNELS_MOST_HZ = 40.0
"""Highest frequency with all channels (README of github.com/ScienceMode/ScienceMode2)."""
_INTERPULSE_CODE = 1
"""Code of 2 ms within doublets, (2 - 1.5) / 0.5; doublets are not used."""
_SINGLE = 0
_MS_PER_S = 1000
_STOPPED = (0, -3)
"""Answers to a stop that confirm zero current: done, and "wrong mode", as nothing was running."""


class ScienceMode:
    """Driver of the device on a serial line; `port` is a name such as "/dev/ttyUSB0"."""

    preset: ClassVar[Preset] = PRESETS["generation1"]
    faults: ClassVar[tuple[str, ...]] = ("no_answer", "wrong_checksum", "refused", "electrode_error",
                                         "unplugged", "device_failed")
    answer_ms: ClassVar[float] = 100.0
    """Four times the 24 ms that the device takes at most for a command, as a serial line over USB and a busy
    computer add to it."""
    alone_ms: ClassVar[float] = 1200.0
    open_s: ClassVar[float] = 6.0
    attend_ms: ClassVar[float] = 5.0

    def __init__(self, port: str, channels: int, hertz: float) -> None:
        self._port, self._channels, self._hertz = port, channels, hertz
        self._line: ScienceModeLine | None = None

    @staticmethod
    def check(port: str, channels: int, hertz: float) -> None:
        """Raise InputError for a missing library or port, or settings beyond the device."""
        if find_spec("pysciencemode") is None or find_spec("serial") is None:
            raise InputError("driver", "`science_mode` needs pysciencemode, which is not installed",
                             remedy="pip install 'fesloop[stimulator]'")
        if not port:
            raise InputError("port", "is missing", 'the serial port of the device, such as "/dev/ttyUSB0"')
        if (2 * _MS_PER_S / Fraction(hertz)).denominator != 1:
            raise InputError("frequency_hz", f"{hertz:g}",
                             "one whose period is a multiple of 0.5 ms: 20, 25, 31.25, 40, 50")
        if channels == ScienceMode.preset.channels and hertz > _ALL_CHANNELS_MOST_HZ:
            raise InputError("frequency_hz", f"{hertz:g}", f"at most {_ALL_CHANNELS_MOST_HZ:g} with "
                             f"{channels} channels")
        if not Path(port).exists():
            raise InputError("port", f"there is no {port}", "the serial port of the device, plugged in")

    def open(self) -> None:
        """Answer the device's Init and set channels and frequency."""
        from plants.devices.science_mode_line import ScienceModeLine

        self._line = ScienceModeLine(self._port, self.answer_ms / _MS_PER_S)
        self._line.connect(self.open_s / 2.0)
        interval = round(2.0 * (_MS_PER_S / self._hertz - 1.0))
        self._line.ask("InitChannelListMode", [0, 2**self._channels - 1, 0, _INTERPULSE_CODE,
                                               interval // 256, interval % 256, 0])

    def give(self, pulses: Pulses) -> None:
        """Send all channels in one command, exactly, as pulses are multiples of the device's steps."""
        content = []
        for current, width in pulses:
            microseconds = round(1e6 * width)
            content += [_SINGLE, microseconds // 256, microseconds % 256, round(1e3 * current)]
        self._opened().ask("StartChannelListMode", content)

    def attend(self) -> None:
        """Check for errors that the device reports; send a watchdog message if no command is due."""
        self._opened().listen()

    def stop(self) -> None:
        """End stimulation on all channels."""
        line = self._opened()
        line.forget()
        line.ask("StopChannelListMode", [], fine=_STOPPED, heed_errors=False)

    def close(self) -> None:
        """Close the port."""
        if self._line is not None:
            self._line.close()

    def _opened(self) -> ScienceModeLine:
        assert self._line is not None, "a driver is opened before it is used"
        return self._line

"""Simulated ScienceMode 2 stimulator behind a pseudo-terminal, for tests and rehearsals.

    python tests/science_mode_peer.py LINK LOG

LINK becomes a symbolic link to the terminal that a driver opens. LOG gets one line for each change of
current, in the format of the `dry` driver (monotonic clock, ns; `open`, `give`, `stop`; mA/us). The simulator
shares neither code nor library with the driver. Like the device it sends Init every 500 ms until that is
answered, carries out a command some milliseconds after it arrives, repeats pulses by itself, and disconnects
with zero current after 1.2 s without a message.

Lines on standard input cause faults: `silent` (no more answers), `wrong_checksum` (all frames damaged),
`electrode_error`, `emergency_stop`, `slow MS` (answers delayed), `refuse` (answers "parameter error"),
`restart` (disconnects and starts again), `unplug` (the line is cut; the device keeps running). `heal` ends
all but the last two.
"""

from __future__ import annotations

import os
import select
import sys
import termios
import time
import tty
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fesloop.loop.machine import realtime_privileges


def checksum(content: bytes | bytearray) -> int:
    """CRC-8 with the polynomial x^8 + x^2 + x + 1, bit by bit."""
    rest = 0
    for byte in content:
        rest ^= byte
        for _ in range(8):
            rest = (rest << 1) ^ 0x107 if rest & 0x80 else rest << 1
    return rest


def framed(number: int, command: int, content: Sequence[int] = ()) -> bytes:
    """A frame from the device."""
    stuffed = bytearray()
    for byte in (number, command, *(value & 0xFF for value in content)):
        stuffed += bytes((0x81, byte ^ 0x55)) if byte in (0xF0, 0x0F, 0x81) else bytes((byte,))
    marks = (0xF0, 0x81, checksum(stuffed) ^ 0x55, 0x81, len(stuffed) ^ 0x55)
    return bytes((*marks, *stuffed, 0x0F))


def split(received: bytes) -> tuple[list[tuple[int, int, bytes]], bytes]:
    """(number, command, content) of each sound frame, and the bytes of one that is not whole."""
    frames: list[tuple[int, int, bytes]] = []
    while True:
        begin = received.find(b"\xf0")
        if begin < 0:
            return frames, b""
        received = received[begin:]
        if len(received) < 5 or len(received) < 6 + (received[4] ^ 0x55):
            return frames, received
        size = received[4] ^ 0x55
        stuffed, stop = received[5:5 + size], received[5 + size]
        if checksum(stuffed) == received[2] ^ 0x55 and stop == 0x0F:
            content, parts = bytearray(), iter(stuffed)
            for byte in parts:
                content.append(next(parts, 0) ^ 0x55 if byte == 0x81 else byte)
            frames.append((content[0], content[1], bytes(content[2:])))
        received = received[6 + size:]


_INIT, _INIT_ACK, _UNKNOWN, _WATCHDOG = 1, 2, 3, 4
_GET_MODE, _SET, _START, _STOP, _SINGLE, _ERROR = 10, 30, 32, 34, 36, 38
_PARAMETER_ERROR, _WRONG_MODE = -2, -3
_CHANNELS, _CURRENT_MAX, _WIDTH_MIN, _WIDTH_MAX = 8, 126, 20, 500
_SILENCE_S, _INIT_EVERY_S, _LATENCY_S = 1.2, 0.5, 0.01
_READY, _INITIALISED, _RUNNING = 0, 1, 2
_PRIORITY = 85
"""Priority in SCHED_FIFO, where granted (chosen: above the keeper's): a device has its own processor."""
Pulses = tuple[tuple[int, int], ...]


@dataclass(slots=True)
class Faults:
    """Faults of the device at present."""

    silent: bool = False
    spoilt: bool = False
    refusing: bool = False
    slow_s: float = 0.0


@dataclass(slots=True, eq=False)
class Peer:
    """The device.

    Attributes
    ----------
    line: its end of the terminal, -1 when it is unplugged.
    far_end: the driver's end, held open so that the terminal stays while no driver has it.
    log: file that changes of current are written to.
    """

    line: int
    far_end: int
    log: int
    faults: Faults = field(default_factory=Faults)
    received: bytes = b""
    connected: bool = False
    mode: int = _READY
    channels: tuple[int, ...] = ()
    given: Pulses = ()
    number: int = 0
    heard_s: float = 0.0
    init_s: float = 0.0
    due: list[tuple[float, bytes, Pulses | None]] = field(default_factory=list)

    def live(self) -> None:
        """Serve until standard input ends."""
        os.set_blocking(0, False)
        asked = b""
        while True:
            ready, _, _ = select.select([0, *([self.line] if self.line >= 0 else [])], [], [], 0.002)
            if 0 in ready:
                more = os.read(0, 4096)
                if not more:
                    self._current((), "stop")
                    return
                *lines, asked = (asked + more).split(b"\n")
                for line in lines:
                    self._go_wrong(line.decode().split())
            if self.line in ready:
                self._read()
            self._pass_time(time.monotonic())

    def _read(self) -> None:
        self.received += os.read(self.line, 4096)
        frames, self.received = split(self.received)
        for number, command, content in frames:
            self._obey(number, command, content)

    def _pass_time(self, now: float) -> None:
        if self.connected and now - self.heard_s > _SILENCE_S:
            self._restart()
        if not self.connected and self.line >= 0 and now - self.init_s > _INIT_EVERY_S:
            self.init_s = now
            _forget_settings(self.far_end)
            self.number = (self.number + 1) % 256
            self._say(framed(self.number, _INIT, (1,)))
        while self.due and self.due[0][0] <= now:
            _, answer, pulses = self.due.pop(0)
            if pulses is not None and self.mode != _READY:
                self._current(pulses, "give")
            self._say(answer)

    def _obey(self, number: int, command: int, content: bytes) -> None:
        """Carry out a command."""
        self.heard_s = time.monotonic()
        if command == _INIT_ACK:
            self.connected = True
        elif not self.connected or command == _WATCHDOG:
            return
        elif command == _GET_MODE:
            self._answer(number, command, (0, self.mode))
        elif command == _SET:
            self._set_channels(number, content)
        elif command == _START:
            self._start(number, content)
        elif command == _STOP:
            self.due.clear()
            self.mode = _READY
            self._current((), "stop")
            self._answer(number, command, (0,))
        else:
            self._answer(number, _UNKNOWN - 1, (command,))

    def _set_channels(self, number: int, content: bytes) -> None:
        wrong = len(content) != 7 or not content[1] or not 14 <= 256 * content[4] + content[5] <= 2048
        if self.mode == _RUNNING or wrong or self.faults.refusing:
            self._answer(number, _SET, (_WRONG_MODE if self.mode == _RUNNING else _PARAMETER_ERROR,))
            return
        self.mode = _INITIALISED
        self.channels = tuple(bit for bit in range(_CHANNELS) if content[1] >> bit & 1)
        self._answer(number, _SET, (0,))

    def _start(self, number: int, content: bytes) -> None:
        rows = [content[i:i + 4] for i in range(0, len(content), 4)]
        pulses = tuple((row[3], 256 * row[1] + row[2]) for row in rows if len(row) == 4)
        sound = len(content) == 4 * len(self.channels) and all(
            current <= _CURRENT_MAX and current % 2 == 0 and (width == 0 or _WIDTH_MIN <= width <= _WIDTH_MAX)
            for current, width in pulses)
        if self.mode == _READY or not sound or self.faults.refusing:
            self._answer(number, _START, (_WRONG_MODE if self.mode == _READY else _PARAMETER_ERROR,))
            return
        self.mode = _RUNNING
        self._answer(number, _START, (0,), pulses)

    def _answer(
        self, number: int, command: int, content: Sequence[int], pulses: Pulses | None = None
    ) -> None:
        """Queue an answer, numbered one above its command; its pulses start when it is sent."""
        at = time.monotonic() + _LATENCY_S + self.faults.slow_s
        self.due.append((at, framed(number, command + 1, content), pulses))

    def _restart(self) -> None:
        self.connected, self.mode, self.init_s = False, _READY, 0.0
        self.due.clear()
        self._current((), "stop")

    def _say(self, frame: bytes) -> None:
        if self.line < 0 or self.faults.silent:
            return
        if self.faults.spoilt:
            frame = frame[:2] + bytes((frame[2] ^ 1,)) + frame[3:]
        try:
            os.write(self.line, frame)
        except BlockingIOError:  # nobody reads at the other end
            return

    def _current(self, pulses: Pulses, event: str) -> None:
        """Set the pulses given from now on, and log a change."""
        if pulses != self.given:
            self.given = pulses
            text = " ".join(f"{current}/{width}" for current, width in pulses)
            os.write(self.log, f"{time.monotonic_ns()}\t{event}\t{text}\n".encode())

    def _go_wrong(self, words: list[str]) -> None:
        """Cause a fault."""
        match words:
            case ["silent"]:
                self.faults.silent = True
            case ["wrong_checksum"]:
                self.faults.spoilt = True
            case ["refuse"]:
                self.faults.refusing = True
            case ["slow", milliseconds]:
                self.faults.slow_s = float(milliseconds) / 1e3
            case ["heal"]:
                self.faults = Faults()
            case ["electrode_error" | "emergency_stop" as word]:
                self.mode = _READY
                self.due.clear()
                self._current((), "stop")
                self._say(framed(0, _ERROR, (-2 if word == "electrode_error" else -1,)))
            case ["restart"]:
                self._restart()
            case ["unplug"]:
                os.close(self.line)
                os.close(self.far_end)
                self.line = -1


def _forget_settings(terminal: int) -> None:
    """Change the terminal's settings: a driver that sets only the parity, which it lacks, gets an error."""
    settings = termios.tcgetattr(terminal)
    settings[4] = settings[5] = termios.B9600
    termios.tcsetattr(terminal, termios.TCSANOW, settings)


def main(link: Path, log: Path) -> None:
    """Simulate the device until standard input ends."""
    line, far_end = os.openpty()
    tty.setraw(far_end)
    link.unlink(missing_ok=True)
    link.symlink_to(os.ttyname(far_end))
    os.set_blocking(line, False)
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
    os.write(file, f"{time.monotonic_ns()}\topen\t\n".encode())
    with realtime_privileges(False, _PRIORITY):
        Peer(line, far_end, file).live()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))

"""Serial line to a ScienceMode 2 device: frames, and answers within a stated time."""

from __future__ import annotations

import select
import termios
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple

import serial
from crccheck.crc import Crc8
from pysciencemode.acks import rehastim_error, stimulation_error
from pysciencemode.enums import Rehastim2Commands
from pysciencemode.utils import packet_construction

from plants.devices.driver import DeviceFault

_START, _STOP, _STUFFING, _KEY = 0xF0, 0x0F, 0x81, 0x55
_HEAD = 5
"""Bytes before the packet number."""


class Frame(NamedTuple):
    """A frame from the device.

    Attributes
    ----------
    number: number of the packet.
    command: number of the command.
    content: content of the command.
    """

    number: int
    command: int
    content: bytes


class FrameReader:
    """Assembler of frames from received bytes."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, received: bytes) -> None:
        """Add received bytes."""
        self._bytes += received

    def next(self) -> Frame | None:
        """The next complete frame, or None; DeviceFault for a damaged one."""
        head = self._bytes.find(_START)
        del self._bytes[:len(self._bytes) if head < 0 else head]
        if len(self._bytes) < _HEAD:
            return None
        length = self._bytes[4] ^ _KEY
        if len(self._bytes) < _HEAD + length + 1:
            return None
        frame = bytes(self._bytes[:_HEAD + length + 1])
        del self._bytes[:len(frame)]
        stuffed = frame[_HEAD:-1]
        if not (frame[1] == frame[3] == _STUFFING and frame[-1] == _STOP
                and Crc8.calc(stuffed) == frame[2] ^ _KEY):
            raise DeviceFault("wrong_checksum", f"the frame {frame.hex(' ')} fails its checksum")
        content = _unstuffed(stuffed)
        if len(content) < 2:
            raise DeviceFault("wrong_checksum", f"the frame {frame.hex(' ')} is too short")
        return Frame(content[0], content[1], content[2:])


def _unstuffed(stuffed: bytes) -> bytes:
    """Undo byte stuffing: each 0x81 precedes a changed byte."""
    content, changed = bytearray(), False
    for byte in stuffed:
        if byte == _STUFFING and not changed:
            changed = True
        else:
            content.append(byte ^ _KEY if changed else byte)
            changed = False
    return bytes(content)


_BAUD = 460_800
_VERSION = 1
_MOST_BYTES = 4096
_ALIVE_S = 0.4
"""Time without a command after which a watchdog message is sent: a third of the device's 1.2 s."""
_MISBUILT = frozenset({10, 15, 85, 129, 240})
"""Packet numbers that pysciencemode 1.1.5 does not stuff correctly; they are skipped."""
_ELECTRODE = -2


class ScienceModeLine:
    """An open port. Every method raises DeviceFault, `unplugged` if the line is gone.

    Parameters
    ----------
    port: name of the serial port. answer_s: longest wait for an answer.
    """

    def __init__(self, port: str, answer_s: float) -> None:
        self._answer_s = answer_s
        self._number = 0
        self._said_s = 0.0
        self._frames = FrameReader()
        try:
            self._port = serial.Serial(port, _BAUD, bytesize=serial.EIGHTBITS, parity=serial.PARITY_EVEN,
                                       stopbits=serial.STOPBITS_ONE, timeout=0.0, write_timeout=answer_s,
                                       exclusive=True)
        except (OSError, ValueError, termios.error) as fault:
            raise DeviceFault("unplugged", f"{port} does not open: {fault}") from None

    def connect(self, patience_s: float) -> None:
        """Wait for the device's Init, and answer it.

        A device that another program has just left takes 1.2 s to notice, and sends Init every 500 ms.
        """
        until = time.monotonic() + patience_s
        frame = None
        while frame is None and time.monotonic() < until:
            try:
                frame = next((each for each in self._arriving(until) if _is_init(each)), None)
            except DeviceFault as fault:
                if fault.status != "wrong_checksum":
                    raise  # the first bytes may be the end of a frame, whose checksum then fails
        if frame is None:
            raise DeviceFault("no_answer", f"no Init within {patience_s:g} s: is the device on, and in "
                              "ScienceMode?")
        if frame.content[:1] != bytes([_VERSION]):
            raise DeviceFault("refused", f"the device speaks version {frame.content.hex()} of the protocol, "
                              f"not {_VERSION}")
        self._write(packet_construction(frame.number, "InitAck", [0]))

    def ask(
        self, command: str, content: Sequence[int], *, fine: Collection[int] = (0,), heed_errors: bool = True
    ) -> None:
        """Send a command and wait for its answer, which must be among `fine`."""
        self._write(packet_construction(self._next_number(), command, list(content)))
        acknowledgement = Rehastim2Commands[f"{command}Ack"].value
        for frame in self._arriving(time.monotonic() + self._answer_s):
            if frame.command == acknowledgement:
                result = _signed(frame)
                if result not in fine:
                    raise DeviceFault("refused", f"{command}: {_words(stimulation_error(result), result)}")
                return
            if heed_errors:
                _heed(frame)
        raise DeviceFault("no_answer", f"{command}: no answer within {1e3 * self._answer_s:g} ms")

    def listen(self) -> None:
        """Check for errors that the device reports, and send a watchdog message if it is due."""
        now = time.monotonic()
        for frame in self._arriving(now):
            _heed(frame)
        if now - self._said_s > _ALIVE_S:
            self._write(packet_construction(self._next_number(), "Watchdog"))

    def forget(self) -> None:
        """Discard a partial frame: its end may be lost, and the next frame taken for it."""
        self._frames = FrameReader()

    def close(self) -> None:
        """Close the port; unsent bytes are discarded, as closing would wait for them on a dead line."""
        with suppress(OSError, serial.SerialException, termios.error):
            self._port.reset_output_buffer()
        self._port.close()

    def _next_number(self) -> int:
        self._number = (self._number + 1) % 256
        while self._number in _MISBUILT:
            self._number += 1
        return self._number

    def _write(self, frame: bytes) -> None:
        try:
            self._port.write(frame)
        except (OSError, serial.SerialException) as fault:
            raise DeviceFault("unplugged", f"the line is gone: {fault}") from None
        self._said_s = time.monotonic()

    def _arriving(self, until_s: float) -> Iterator[Frame]:
        """Frames that arrive until an instant.

        After it the line is read once more, for frames that arrived in time, however many messages follow.
        """
        over = False
        while True:
            while (frame := self._frames.next()) is not None:
                yield frame
            if over:
                return
            left_s = until_s - time.monotonic()
            over = left_s <= 0.0
            try:
                ready, _, _ = select.select([self._port], [], [], max(0.0, left_s))
                if not ready:
                    return
                self._frames.feed(self._port.read(_MOST_BYTES))
            except (OSError, serial.SerialException) as fault:
                raise DeviceFault("unplugged", f"the line is gone: {fault}") from None


def _is_init(frame: Frame) -> bool:
    return frame.command == Rehastim2Commands.Init.value and frame.number not in _MISBUILT


def _heed(frame: Frame) -> None:
    """Raise DeviceFault for an unsolicited message that reports an error."""
    if frame.command == Rehastim2Commands.StimulationError.value:
        code = _signed(frame)
        raise DeviceFault("electrode_error" if code == _ELECTRODE else "device_failed",
                          _words(rehastim_error(code), code))
    if frame.command == Rehastim2Commands.UnknownCommand.value:
        raise DeviceFault("refused", "the device does not know the command")
    if frame.command == Rehastim2Commands.Init.value:
        raise DeviceFault("device_failed", "the device has disconnected and restarted")


def _signed(frame: Frame) -> int:
    return int.from_bytes(frame.content[:1], "big", signed=True)


def _words(known: str | None, code: int) -> str:
    """Meaning of a code, from the library."""
    return f"{(known or 'unknown error').strip().lower()} ({code})"

"""Frames of ScienceMode 2 as they come from the device.

    0xF0, 0x81, checksum ^ 0x55, 0x81, length ^ 0x55, packet number, command, data..., 0x0F

The checksum (CRC-8, polynomial x^8 + x^2 + x + 1) and the length are those of the bytes between, in which any
byte that could be taken for a mark is sent as 0x81 and itself ^ 0x55. `pysciencemode` builds such frames; it
does not check those that it reads.
"""

from __future__ import annotations

from typing import NamedTuple

from crccheck.crc import Crc8

from plants.devices.driver import DeviceFault

_START, _STOP, _STUFFING, _KEY = 0xF0, 0x0F, 0x81, 0x55
_HEAD = 5
"""Bytes before the packet number."""


class Frame(NamedTuple):
    """What the device says.

    Attributes
    ----------
    number: of the packet.
    command: what it is.
    content: what belongs to it.
    """

    number: int
    command: int
    content: bytes


class FrameReader:
    """Puts frames together from bytes as they come."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, received: bytes) -> None:
        """More bytes."""
        self._bytes += received

    def next(self) -> Frame | None:
        """The next whole frame, None while there is none; DeviceFault for one that is damaged."""
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
    """The bytes meant; each 0x81 announces one that was changed."""
    content, changed = bytearray(), False
    for byte in stuffed:
        if byte == _STUFFING and not changed:
            changed = True
        else:
            content.append(byte ^ _KEY if changed else byte)
            changed = False
    return bytes(content)

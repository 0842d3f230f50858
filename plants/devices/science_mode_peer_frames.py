"""Frames of ScienceMode 2 as the device's end of the line makes and reads them, by the protocol alone.

Nothing here is shared with the driver or its library, so that each end checks the other.
"""

from __future__ import annotations

from collections.abc import Sequence


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

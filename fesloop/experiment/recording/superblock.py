"""The superblock of a recording's file: whether a writer has it open.

Version 3, as HDF5 writes it in SWMR mode (HDF5 File Format Specification 3.0, II.A).
"""

from __future__ import annotations

from pathlib import Path

_FLAGS, _CHECKSUM, _LENGTH = 11, 44, 48
"""Where in it the consistency flags stand, and the checksum of all that is before it; its length, bytes."""
_WORD = 2**32 - 1


def mark_closed(path: Path) -> None:
    """Clear the flags of a file that no writer has open any more, so that HDF5 opens it as any other.

    Nothing is done to a superblock that is damaged.
    """
    with path.open("r+b") as file:
        block = bytearray(file.read(_LENGTH))
        if len(block) < _LENGTH or block[_CHECKSUM:] != checksum(bytes(block[:_CHECKSUM])):
            return
        block[_FLAGS] = 0
        block[_CHECKSUM:] = checksum(bytes(block[:_CHECKSUM]))
        file.seek(0)
        file.write(block)


def checksum(content: bytes) -> bytes:
    """Of HDF5's metadata, of one byte or more: lookup3, `hashlittle` from 0 (Bob Jenkins, 2006)."""
    state = [(0xDEADBEEF + len(content)) & _WORD] * 3
    while len(content) > 12:
        _add(state, content[:12])
        for one, other, third, by in ((0, 2, 1, 4), (1, 0, 2, 6), (2, 1, 0, 8), (0, 2, 1, 16), (1, 0, 2, 19),
                                      (2, 1, 0, 4)):
            state[one] = (state[one] - state[other]) & _WORD ^ _turned(state[other], by)
            state[other] = (state[other] + state[third]) & _WORD
        content = content[12:]
    _add(state, content.ljust(12, b"\0"))
    for one, other, by in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        state[one] = ((state[one] ^ state[other]) - _turned(state[other], by)) & _WORD
    return state[2].to_bytes(4, "little")


def _add(state: list[int], words: bytes) -> None:
    for number in range(3):
        state[number] = (state[number] + int.from_bytes(words[4 * number:4 * number + 4], "little")) & _WORD


def _turned(word: int, by: int) -> int:
    """Bits of a word of 32 turned round to the left."""
    return (word << by | word >> 32 - by) & _WORD

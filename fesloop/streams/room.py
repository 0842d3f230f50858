"""How much memory the content of a file may take: a small file can declare more than there is anywhere."""

from __future__ import annotations

from pathlib import Path

from fesloop.errors import InputError

_FLOOR_BYTES = 2**28
_EXPANSION = 20
"""Chosen: samples of real sensors hardly compress to a third, constant columns to far less; an hour of 17
sensors takes 440 MB as float64, and lies in 150 MB or more of a file."""


class Room:
    """Bytes that may be decoded of a file: 256 MB, or 20 times its size if that is more.

    Parameters
    ----------
    path: of the file, which must exist.
    """

    __slots__ = ("_left", "_whole")

    def __init__(self, path: Path) -> None:
        self._whole = self._left = max(_FLOOR_BYTES, _EXPANSION * path.stat().st_size)

    @property
    def left(self) -> int:
        """Bytes that are left."""
        return self._left

    def take(self, count: int, where: str) -> None:
        """Use so many bytes up; InputError where they are more than there are."""
        if count > self._left:
            raise InputError(where, f"would take {count:.3g} bytes, a file of this size is not to unpack to "
                             f"more than {self._whole:.3g}", "an undamaged file")
        self._left -= count

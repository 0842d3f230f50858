"""Counter-based randomness: a row of numbers is a function of (seed, name, trial, tick).

Adding a block changes no other block's numbers, and tick k does not need tick k - 1. Numbers come from
numpy's Philox generator, keyed by a hash of seed, name and trial and counted by the tick.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

_TICKS_PER_PAGE = 128


def stream_key(seed: int, name: str, trial: int) -> int:
    """128-bit key of the random numbers of `name` (block and purpose) in one trial."""
    text = f"fesloop/{seed}/{name}/{trial}".encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:16], "little")


class NoiseStream:
    """Rows of `width` independent numbers, one row a tick.

    Parameters
    ----------
    key: from `stream_key`.
    width: numbers a tick.
    kind: "normal" (mean 0, sd 1) or "uniform" (in [0, 1)).
    """

    __slots__ = ("_page", "_rows", "key", "kind", "width")

    def __init__(self, key: int, width: int, kind: str = "normal") -> None:
        if kind not in ("normal", "uniform"):
            raise ValueError(f"noise kind {kind!r}: allowed are normal, uniform")
        self.key, self.width, self.kind = key, width, kind
        self._page = -1
        self._rows: NDArray[np.float64] = np.empty((0, width))

    def row(self, tick: int) -> NDArray[np.float64]:
        """The numbers of tick `tick`, (width,); read-only."""
        page = tick // _TICKS_PER_PAGE
        if page != self._page:
            generator = np.random.Generator(np.random.Philox(key=self.key, counter=page << 128))
            draw = generator.standard_normal if self.kind == "normal" else generator.random
            self._rows = draw((_TICKS_PER_PAGE, self.width))
            self._rows.flags.writeable = False
            self._page = page
        row: NDArray[np.float64] = self._rows[tick % _TICKS_PER_PAGE]
        return row

    def __reduce__(self) -> tuple[type[NoiseStream], tuple[int, int, str]]:
        return NoiseStream, (self.key, self.width, self.kind)

"""What a device would have given, as it writes it down at its end of the line."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS


class Given(NamedTuple):
    """A line of the log.

    Attributes
    ----------
    stamp_ns: monotonic clock.
    on: whether there is current from then on.
    """

    stamp_ns: int
    on: bool


def given(log: Path) -> list[Given]:
    """Every whole line of a log that `dry` or the simulated device writes."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    return [Given(int(stamp), any(float(pulse.partition("/")[0]) > 0.0 for pulse in pulses.split()))
            for stamp, _, pulses in (line.split("\t") for line in lines)]


def zero_after_ms(rows: list[Given], since_ns: int) -> float | None:
    """From an instant to zero current that lasts, ms; None while there is current.

    Raises RunError where there was none at that instant, for then nothing would be shown.
    """
    before = [row for row in rows if row.stamp_ns <= since_ns]
    if not before or not before[-1].on:
        raise RunError("the patient was not stimulated when the fault began")
    if rows[-1].on:
        return None
    last_on = max(number for number, row in enumerate(rows) if row.on)
    return max(0.0, (rows[last_on + 1].stamp_ns - since_ns) / NS_PER_MS)

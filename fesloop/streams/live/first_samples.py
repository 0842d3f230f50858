"""Whether a stream and its first samples are what was said of them: rate, units and clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.streams.checks import plausible_acc, plausible_gyr, plausible_mag
from fesloop.streams.live.description import Picked
from fesloop.streams.live.source import Pulled, Source, StreamLost

_SAMPLES, _WAIT_S = 10, 2.0
_CLOCKS_AGREE_NS = NS_PER_S // 2
"""How old a sample may seem, and how far ahead, before its stamps count as those of another clock (chosen:
the age at which a safety block stops, by default)."""
_RATE_AGREES = 0.01
"""By how much the stated rate may differ from the nominal one (chosen: sensors' clocks are better)."""
_PLAUSIBLE: Mapping[str, Callable[[NDArray[np.float64], str], None]] = {
    "gyr": plausible_gyr, "acc": plausible_acc, "mag": plausible_mag}


def check_rate(stated_hz: float, clock: RateClock, where: str) -> None:
    """Raise InputError where a stream states another rate than the nominal one; 0 states none."""
    if stated_hz > 0.0 and abs(stated_hz * clock.period_s - 1.0) > _RATE_AGREES:
        raise InputError(where, f"states a rate of {stated_hz:g} Hz", f"nominal_rate = {float(clock.rate):g}",
                         f'say nominal_rate = "{stated_hz:g}"')


def check_first_samples(source: Source, picked: Mapping[str, Picked], where: str, *, by_sender: bool) -> None:
    """Raise InputError where a stream is silent, its numbers cannot be in its units, or its clock is another.

    Parameters
    ----------
    source: opened; ten samples of it are read.
    picked: channels of "gyr", "acc" and "mag", (n, 3) each.
    where: the stream, for messages.
    by_sender: whether its stamps are to be used.
    """
    pulled = _read(source, where)
    values = np.stack([sample.values for sample in pulled])
    for kind, channels in picked.items():
        readings = np.stack([channels.of(row) for row in values])
        if np.isfinite(readings).all(axis=2).any():
            _PLAUSIBLE[kind](readings.reshape(-1, 3), f"{where}: {kind}")
    age_ns = time.monotonic_ns() - pulled[-1].stamp_ns
    if by_sender and abs(age_ns) > _CLOCKS_AGREE_NS:
        told = f"{abs(age_ns) / NS_PER_S:.3g} s {'old' if age_ns > 0 else 'ahead of this machine'}"
        raise InputError(where, f"its samples are stamped {told}", f"up to {_CLOCKS_AGREE_NS / NS_PER_S:g} s",
                         'its stamps are of another clock: say stamps = "arrival"')


def _read(source: Source, where: str) -> list[Pulled]:
    pulled: list[Pulled] = []
    until = time.monotonic() + _WAIT_S
    while len(pulled) < _SAMPLES and (left := until - time.monotonic()) > 0.0:
        try:
            sample = source.pull(left)
        except StreamLost:
            raise InputError(where, "was lost as it was opened", remedy="start its sender again") from None
        if sample is not None:
            pulled.append(sample)
    if not pulled:
        raise InputError(where, f"is there, but sends nothing within {_WAIT_S:g} s", "samples")
    return pulled

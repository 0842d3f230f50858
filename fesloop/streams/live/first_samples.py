"""Whether the first samples of a stream are what its description says: units and clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.checks import plausible_acc, plausible_gyr, plausible_mag
from fesloop.streams.live.description import Picked
from fesloop.streams.live.source import Pulled, Source, StreamLost

_SAMPLES, _WAIT_S = 10, 2.0
_CLOCKS_AGREE_NS = NS_PER_S // 2
"""How old a sample may seem, and how far ahead, before its stamps count as those of another clock (chosen:
the age at which a safety block stops, by default)."""
_PLAUSIBLE: Mapping[str, Callable[[NDArray[np.float64], str], None]] = {
    "gyr": plausible_gyr, "acc": plausible_acc, "mag": plausible_mag}


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
    ages = [time.monotonic_ns() - sample.stamp_ns for sample in pulled[-1:]]
    if by_sender and abs(ages[0]) > _CLOCKS_AGREE_NS:
        told = f"{abs(ages[0]) / NS_PER_S:.4g} s {'old' if ages[0] > 0 else 'ahead of this machine'}"
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

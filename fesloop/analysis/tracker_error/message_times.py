"""How old a tracker's estimates are when they come, and how often none comes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Signal
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.losses import least_burst

_STEADY_NS = NS_PER_MS // 100
"""Ages that differ by less are one age (chosen: nothing in a loop tells them apart)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageTimes:
    """As of `ErrorProcess`: age at least, what comes on top, loss and its bursts."""

    age_ms: float
    jitter: Duration
    loss: float
    burst_messages: float


def message_times(signal: Signal, lost: NDArray[np.bool_], before_ns: int) -> MessageTimes:
    """Age and loss of the estimates that were put out before an instant.

    An estimate is lost where its newest capture is not later than that of the one before, or where `lost`
    (ticks,) says that a sample for it was. The age above the least is taken as exponential.
    """
    early = (signal.times_ns < before_ns) & (signal.newest_ns >= 0)
    newest = signal.newest_ns[early]
    if newest.size < 2:
        return MessageTimes(age_ms=0.0, jitter=ZERO, loss=0.0, burst_messages=0.0)
    missing = lost[early] | (np.diff(newest, prepend=-1) <= 0)
    ages = (signal.left_ns[early] - newest)[~missing]
    least = int(ages.min()) if ages.size else 0
    above_ms = (ages - least) / NS_PER_MS
    jitter = ZERO
    if ages.size and above_ms.max() * NS_PER_MS > _STEADY_NS:
        jitter = Duration(kind="exponential", mean_ms=float(above_ms.mean()), high_ms=float(above_ms.max()))
    share, burst = _bursts(missing)
    return MessageTimes(age_ms=least / NS_PER_MS, jitter=jitter, loss=share, burst_messages=burst)


def sample_ms(signal: Signal) -> float:
    """Median time between the captures behind estimates, ms; 0 where there are no two."""
    steps = np.diff(np.unique(signal.newest_ns[signal.newest_ns >= 0]))
    return float(np.median(steps)) / NS_PER_MS if steps.size else 0.0


def _bursts(missing: NDArray[np.bool_]) -> tuple[float, float]:
    """Share of what is missing, and how much of it in a row at the mean; 0 where nothing is."""
    count = int(missing.sum())
    if not count or count == missing.size:
        return (0.0, 0.0)
    begins = int(missing[0]) + int((missing[1:] & ~missing[:-1]).sum())
    share = count / missing.size
    return share, max(count / begins, least_burst(share))

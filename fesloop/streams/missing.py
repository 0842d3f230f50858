"""What a recording of inertial sensors lacks, in words: gaps in its stamps, and samples that sensors lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S
from fesloop.streams.pace import Gap, gaps_of, pace_of, rate_change
from fesloop.streams.recording import MotionRecording

_MOST_SHOWN = 4
_REPEATS, _REPEATS_S = 10, 0.1
"""Samples, and s, for which a sensor must repeat itself (as trackers have it: `frozen_sample`)."""


def lost_samples(recording: MotionRecording) -> NDArray[np.bool_]:
    """Samples that lack a number, (n_samples, n_sensors)."""
    kinds = [recording.gyr, recording.acc] + ([] if recording.mag is None else [recording.mag])
    return np.asarray(np.any([np.isnan(kind).any(axis=2) for kind in kinds], axis=0))


@dataclass(frozen=True, slots=True)
class Lacking:
    """What a whole recording lacks.

    Attributes
    ----------
    rate_hz: of the samples between gaps.
    gaps: see there.
    text: all that is lacking, and a rate that changes; empty for nothing.
    """

    rate_hz: float
    gaps: tuple[Gap, ...]
    text: str


def lacking_in(recording: MotionRecording) -> Lacking:
    """Gaps, lost samples and changes of rate of a recording."""
    times_s = recording.stamps_ns / NS_PER_S
    pace = pace_of(times_s)
    gaps, changed = gaps_of(times_s, pace), rate_change(times_s, pace)
    told = [missing_text(recording, 0, recording.samples, gaps)] if gaps or lost_samples(
        recording).any() else []
    if changed is not None:
        at_s, before, then = changed
        told.append(f"the rate changes from {before:.4g} Hz to {then:.4g} Hz at {at_s:.4g} s: only a part of "
                    "one rate can be played, with start_s and duration_s")
    return Lacking(pace.rate_hz if pace.period_s > 0.0 else 0.0, tuple(gaps), "; ".join(told))


def missing_text(recording: MotionRecording, first: int, stop: int, gaps: Sequence[Gap]) -> str:
    """What samples `first` to `stop` lack, with the gaps among them; empty for nothing."""
    told = []
    if gaps:
        missing = sum(gap.missing for gap in gaps)
        gap_s = sum((gap.to_s - gap.from_s) * gap.missing / (gap.missing + 1) for gap in gaps)
        told.append(f"{len(gaps)} gap{'s' * (len(gaps) > 1)}, {gap_s:.4g} s without samples ({missing} of "
                    f"{stop - first + missing} missing): {_where(gaps)}")
    lost = lost_samples(recording)[first:stop].sum(axis=0)
    of = [f"{name} {count} of {stop - first}"
          for name, count in zip(recording.sensors, lost.tolist(), strict=True) if count]
    if of:
        more = f" and {len(of) - _MOST_SHOWN} sensors more" if len(of) > _MOST_SHOWN else ""
        told.append("lost samples: " + ", ".join(of[:_MOST_SHOWN]) + more)
    return "; ".join(told)


def repeated_text(recording: MotionRecording, first: int = 0, stop: int | None = None) -> str:
    """Which sensors repeat a sample for long in samples `first` to `stop`; empty for none.

    Devices do so that have lost the sensor.
    """
    period_s = pace_of(recording.stamps_ns / NS_PER_S).period_s
    least = max(_REPEATS, round(_REPEATS_S / period_s)) if period_s > 0.0 else _REPEATS
    told = []
    for number, name in enumerate(recording.sensors):
        samples = np.concatenate([recording.gyr[first:stop, number], recording.acc[first:stop, number]],
                                 axis=1)
        same = np.concatenate([[False], np.all(samples[1:] == samples[:-1], axis=1), [False]])
        edges = np.flatnonzero(np.diff(same.astype(np.int8)))
        lengths = edges[1::2] - edges[::2]
        if (lengths >= least).any():
            long = lengths[lengths >= least]
            often = "once" if len(long) == 1 else f"{len(long)} times"
            from_s = recording.stamps_ns[first + edges[::2][lengths >= least][0]] / NS_PER_S
            told.append(f"{name} {often}, {long.sum() * period_s:.3g} s in all, from {from_s:.4g} s on")
    more = f" and {len(told) - _MOST_SHOWN} sensors more" if len(told) > _MOST_SHOWN else ""
    return f"samples that repeat the one before: {', '.join(told[:_MOST_SHOWN])}{more}: a sensor that was " \
           "lost; angles may stay off after it" if told else ""


def _where(gaps: Sequence[Gap]) -> str:
    """The first gaps by their beginning and end."""
    more = f" and {len(gaps) - _MOST_SHOWN} more" if len(gaps) > _MOST_SHOWN else ""
    return ", ".join(f"{gap.from_s:.4g} to {gap.to_s:.4g} s" for gap in gaps[:_MOST_SHOWN]) + more

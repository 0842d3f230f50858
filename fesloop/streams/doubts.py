"""Doubts about a recording in words that say what to do: gaps, lost samples, clipping, and more."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S
from fesloop.streams.agreement import Agreement, agreements_in, disagreement_text, unjudged_text
from fesloop.streams.checks import Array
from fesloop.streams.labels import GRAVITY, not_understood
from fesloop.streams.mounting import mounting_text
from fesloop.streams.pace import Gap, gaps_of, pace_of, rate_change
from fesloop.streams.recording import MotionRecording

Doubts = tuple[tuple[str, str], ...]
_MOST_SHOWN = 4
_REPEATS, _REPEATS_S = 10, 0.1
"""Number and duration, s, of equal samples that count as repeated (as for a tracker's `frozen_sample`)."""
_FLAT = 3
"""Equal samples in a row that are flat (chosen: noise forbids two)."""
_STEPS = 4.0
"""Least jump of samples to a flat and from it, in steps of the numbers' resolution: coarse numbers are equal
at the top of a smooth curve as well, but rise to it by one step (chosen)."""
_OUTERMOST = 0.7
"""Share of a sensor's greatest sample below which a flat is not the end of its range (chosen)."""
_RANGES = {"gyr": (180.0 / np.pi, "deg/s", "gyr_range_deg_s"), "acc": (1.0 / GRAVITY, "g", "acc_range_g")}


def doubts(recording: MotionRecording, first: int = 0, stop: int | None = None) -> Doubts:
    """Status and text of each doubt about samples `first` to `stop`."""
    return _doubts(recording, first, stop, agreements_in(recording, first, stop))


def all_doubts(recording: MotionRecording) -> Doubts:
    """Doubts about a whole recording, with what it lacks and what could not be judged."""
    found = agreements_in(recording)
    more = (("recording_incomplete", lacking_in(recording).text),
            ("rates_not_checked", unjudged_text(recording, found)))
    return *_doubts(recording, 0, None, found), *((status, text) for status, text in more if text)


def _doubts(recording: MotionRecording, first: int, stop: int | None, found: Sequence[Agreement]) -> Doubts:
    every = (("channels_left_out", not_understood(recording.left_out)),
             ("rates_disagree", disagreement_text(recording, found)),
             ("mounting_disagrees", mounting_text(recording, first, stop)),
             ("range_too_small", clipped_text(recording, first, stop)),
             ("repeated_samples", repeated_text(recording, first, stop)))
    return tuple((status, text) for status, text in every if text)


@dataclass(frozen=True, slots=True)
class Lacking:
    """Gaps, lost samples, a changing rate and a missing reference of a whole recording.

    Attributes
    ----------
    rate_hz: of the samples between gaps.
    gaps: stretches without samples.
    text: all that is lacking, in the reference too, and a rate that changes; empty for nothing.
    """

    rate_hz: float
    gaps: tuple[Gap, ...]
    text: str


def lacking_in(recording: MotionRecording) -> Lacking:
    """Parts that a recording lacks."""
    times_s = recording.stamps_ns / NS_PER_S
    pace = pace_of(times_s)
    gaps, changed = gaps_of(times_s, pace), rate_change(times_s, pace)
    texts = [missing_text(recording, 0, recording.samples, gaps)]
    if changed is not None:
        at_s, before, then = changed
        texts.append(f"the rate changes from {before:.4g} Hz to {then:.4g} Hz at {at_s:.4g} s: only a part "
                     "of one rate can be played, with start_s and duration_s")
    if recording.reference is not None:
        unknown = np.asarray(np.isnan(recording.reference.orientation).any(axis=2))
        counts = zip(recording.sensors, unknown.sum(axis=0).tolist(), strict=True)
        shares = [f"{name} {count} of {len(unknown)}" for name, count in counts if count]
        if shares:
            texts.append(f"orientations of the reference that are missing, NaN or zeros: "
                         f"{_first_few(shares, 'sensors more')}")
    return Lacking(pace.rate_hz if pace.period_s > 0.0 else 0.0, tuple(gaps), "; ".join(filter(None, texts)))


def lost_samples(recording: MotionRecording) -> NDArray[np.bool_]:
    """Samples that lack a number, (n_samples, n_sensors)."""
    kinds = [recording.gyr, recording.acc] + ([] if recording.mag is None else [recording.mag])
    return np.asarray(np.any([np.isnan(kind).any(axis=2) for kind in kinds], axis=0))


def missing_text(recording: MotionRecording, first: int, stop: int, gaps: Sequence[Gap]) -> str:
    """Text on lost samples from `first` to `stop`, gaps included; empty for none."""
    texts = []
    if gaps:
        missing = sum(gap.missing for gap in gaps)
        gap_s = sum((gap.to_s - gap.from_s) * gap.missing / (gap.missing + 1) for gap in gaps)
        shown = [f"{gap.from_s:.4g} to {gap.to_s:.4g} s" for gap in gaps]
        texts.append(f"{len(gaps)} gap{'s' * (len(gaps) > 1)}, {gap_s:.4g} s without samples ({missing} of "
                     f"{stop - first + missing} missing): {_first_few(shown)}")
    lost = lost_samples(recording)[first:stop].sum(axis=0)
    shares = [f"{name} {count} of {stop - first}"
              for name, count in zip(recording.sensors, lost.tolist(), strict=True) if count]
    if shares:
        texts.append(f"lost samples: {_first_few(shares, 'sensors more')}")
    return "; ".join(texts)


def _first_few(texts: Sequence[str], more: str = "more") -> str:
    rest = f" and {len(texts) - _MOST_SHOWN} {more}" if len(texts) > _MOST_SHOWN else ""
    return ", ".join(texts[:_MOST_SHOWN]) + rest


def repeated_text(recording: MotionRecording, first: int = 0, stop: int | None = None) -> str:
    """Text on sensors that repeat a sample for long in samples `first` to `stop`; empty for none.

    Devices repeat a sample after they have lost the sensor.
    """
    period_s = pace_of(recording.stamps_ns / NS_PER_S).period_s
    least = max(_REPEATS, round(_REPEATS_S / period_s)) if period_s > 0.0 else _REPEATS
    repeating = []
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
            repeating.append(f"{name} {often}, {long.sum() * period_s:.3g} s in all, from {from_s:.4g} s on")
    return (f"samples that repeat the one before: {_first_few(repeating, 'sensors more')}: a sensor that was "
            "lost; angles may stay off after it") if repeating else ""


def clipped_text(recording: MotionRecording, first: int = 0, stop: int | None = None) -> str:
    """Text on sensors with clipped samples, their range, and the trackers' setting; empty for none."""
    clipped, settings = [], []
    for kind, (scale, unit, setting) in _RANGES.items():
        samples = getattr(recording, kind)[first:stop]
        found = {name: clipped_at(samples[:, number]) for number, name in enumerate(recording.sensors)}
        levels = {name: scale * level for name, (level, count) in found.items() if count}
        clipped += [f"{kind} of {name} at {level:.4g} {unit} ({found[name][1]} samples)"
                    for name, level in levels.items()]
        if levels:
            least = min(levels.values())
            digit = 10.0 ** (np.floor(np.log10(least)) - 3.0)
            below = float(np.floor(least / digit * (1.0 - 1e-6)) * digit)
            settings.append(f"`{setting}` of the tracker to {below:.4g}")
    return (f"samples are clipped: {_first_few(clipped)}: set {' and '.join(settings)}, so that its standard "
            "deviation accounts for it, and record with a wider range") if clipped else ""


def clipped_at(samples: Array) -> tuple[float, int]:
    """Least end of the range of a sensor's axes (n, 3), and the number of samples flat there, or 0."""
    there = samples[np.isfinite(samples).all(axis=1)]
    if not len(there):
        return 0.0, 0
    # A sample that repeats the one before in all axes is a repeated sample, not a clipped one.
    new = there[np.concatenate([[True], np.any(np.diff(there, axis=0) != 0.0, axis=1)])]
    outer = _OUTERMOST * float(np.abs(new).max())
    flats = [flat for column in new.T for sign in (1.0, -1.0) for flat in _flats(sign * column, outer)]
    return (min(level for level, _ in flats), sum(count for _, count in flats)) if flats else (0.0, 0)


def _flats(values: Array, outer: float) -> Iterator[tuple[float, int]]:
    """The greatest of values (n,) and the number that is flat there, where it is at least `outer`."""
    level = float(values.max())
    if not level >= outer > 0.0:
        return
    at = np.concatenate([[False], values == level, [False]])
    edges = np.flatnonzero(at[1:] != at[:-1])
    begins, ends = edges[::2], edges[1::2]
    inner = (ends - begins >= _FLAT) & (begins > 0) & (ends < len(values))
    if not inner.any():
        return
    begins, ends = begins[inner], ends[inner]
    jumps = level - 0.5 * (values[begins - 1] + values[ends])
    apart = np.diff(np.unique(values))
    # Of numbers that were scaled, rounding makes steps of next to nothing.
    step = float(apart[apart > 1e-9 * level].min(initial=np.inf))
    if float(np.median(jumps)) > _STEPS * step:
        yield level, int(np.sum(ends - begins))

"""Exact rates and integer stamps from rates and times in files."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.checks import Array, finite, numbers
from fesloop.streams.pace import Pace

SLOWEST_HZ, FASTEST_HZ = 1.0, 100_000.0
"""Bounds of the rates of motion recordings; outside them, the unit of time is wrong (chosen)."""
_SIMPLE = 1000
_ROUNDING_S = 1e-6
"""Stamps that differ by no more from evenly spaced ones are evenly spaced, and rounded."""
_STATED_AGREES = 0.05
"""Relative difference allowed between a stated rate and the rate of the stamps (chosen: sensors' clocks are
within 1 %; a rate in another unit or of another table is further off)."""

_FEW = 10.0
"""Greatest error of the first and last of a few stamps, in standard deviations of their jitter (chosen)."""


def exact_rate(hertz: float, where: str, uncertainty: float = 1e-9) -> Fraction:
    """The simplest ratio (denominator up to 1000) that `hertz` may be, else its decimal text.

    285.7142857142857 is 2000/7; `uncertainty` is relative. Raises InputError outside 1 Hz to 100 kHz.
    """
    if not np.isfinite(hertz) or not SLOWEST_HZ <= hertz <= FASTEST_HZ:
        raise InputError(where, f"{hertz!r} is not a sampling rate", f"{SLOWEST_HZ:g} to {FASTEST_HZ:g} Hz")
    simple = Fraction(hertz).limit_denominator(_SIMPLE)
    return simple if abs(float(simple) - hertz) <= uncertainty * hertz else Fraction(repr(hertz))


def rate_of(content: Mapping[str, Any], key: str, where: str) -> Fraction:
    """The rate that a scalar key states, Hz."""
    stated = {key: np.ravel(np.asarray(content[key]))} if key in content else content
    return exact_rate(float(numbers(stated, key, (1,), where)[0]), f"{where}: {key}")


def stamps_of_rate(samples: int, rate: Fraction) -> NDArray[np.int64]:
    """Instants floor(k / rate), ns, (samples,): those of a RateClock."""
    period = NS_PER_S / rate
    return np.array([k * period.numerator // period.denominator for k in range(samples)], dtype=np.int64)


def stamps_of_times(times: Array, unit_s: float, place: str) -> tuple[NDArray[np.int64], Fraction | None]:
    """Stamps from 0 on, ns, and the exact rate where the samples are evenly spaced.

    Parameters
    ----------
    times: (n,), in units of `unit_s` seconds.

    Raises InputError for times that do not increase, or whose spacing is no sampling period.
    """
    finite(times, place)
    steps = np.diff(times)
    if steps.size == 0:
        raise InputError(place, "holds a single instant", "two or more")
    if (steps <= 0.0).any():
        at = int(np.argmax(steps <= 0.0)) + 1
        raise InputError(place, f"sample {at} does not come after the one before it", "increasing times")
    stamps = np.rint((times - times[0]) * (unit_s * NS_PER_S)).astype(np.int64)
    mean_s = float(times[-1] - times[0]) / steps.size * unit_s
    exact_rate(1.0 / (float(np.median(steps)) * unit_s), place)
    rounding = 2.0 / NS_PER_S / (mean_s * steps.size)  # first and last instant may each be a ns off
    simplest = simplest_rate(stamps)
    if np.array_equal(stamps_of_rate(times.size, simplest), stamps):
        return stamps, simplest
    if 1.0 / mean_s < SLOWEST_HZ:
        return stamps, None
    rate = exact_rate(float(f"{1.0 / mean_s:.9g}"), place, 1e-9 + rounding)
    even = np.arange(times.size) / float(rate)
    if np.abs((times - times[0]) * unit_s - even).max() <= _ROUNDING_S:
        return stamps_of_rate(times.size, rate), rate
    return stamps, None


def require_stated_rate(stated_hz: float, times_s: Array, where: str) -> None:
    """Raise InputError where stamps (n,), s, are at another rate than a file states; 0 states none.

    The stated rate may be that of the whole, which bursts do not change, or that of a step, which gaps do not
    change. Stamps that do not increase are left to `stamps_of_times`.
    """
    steps = np.diff(times_s)
    if stated_hz <= 0.0 or not steps.size or not (steps > 0.0).all():
        return
    whole, single = 1.0 / float(steps.mean()), 1.0 / float(np.median(steps))
    if all(abs(stated_hz / stamped - 1.0) > _STATED_AGREES for stamped in (whole, single)):
        raise InputError(where, f"states {stated_hz:g} Hz, the stamps are at {whole:.4g} Hz",
                         f"the rate of the stamps, within {100.0 * _STATED_AGREES:g} %",
                         "mend whichever is wrong")


def require_rate(stated_hz: float, pace: Pace, samples: int, where: str) -> None:
    """Raise InputError where a file states another rate than stamps are at between their gaps."""
    few = _FEW / samples
    if abs(stated_hz * pace.period_s - 1.0) > _STATED_AGREES + few * pace.jitter_s / pace.period_s:
        raise InputError(where, f"states {stated_hz:g} Hz, the stamps are at {pace.rate_hz:.4g} Hz",
                         f"the rate of the stamps, within {100.0 * _STATED_AGREES:g} %",
                         "describe the file with a layout, whose `time` takes the stamps and no stated rate")


def simplest_rate(stamps_ns: NDArray[np.int64]) -> Fraction:
    """The ratio of least denominator that stamps (n,) in whole ns, the last after the first, allow, Hz.

    Their mean period is known to 1 / (n - 1) ns: 28 stamps over 170886075 ns are at 158 Hz.
    """
    steps, length = len(stamps_ns) - 1, int(stamps_ns[-1] - stamps_ns[0])
    if length == 1:
        return Fraction(NS_PER_S * steps)
    return _simplest(Fraction(NS_PER_S * steps, length + 1), Fraction(NS_PER_S * steps, length - 1))


def _simplest(low: Fraction, high: Fraction) -> Fraction:
    """The ratio of least denominator between two, above 0, by continued fractions."""
    whole = low.numerator // low.denominator
    if low == whole:
        return Fraction(whole)
    if high > whole + 1:
        return Fraction(whole + 1)
    return whole + 1 / _simplest(1 / (high - whole), 1 / (low - whole))

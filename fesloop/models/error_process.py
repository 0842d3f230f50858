"""Error of a tracker as a stochastic process of few numbers, fitted to a recording and kept in a file.

A file is TOML: of which recording and tracker it is (source), one table for each angle whose error was
fitted, how what drives these is correlated, and how old and how often lost the tracker's messages were. It
holds parameters only, no sample of the recording. Units are SI but where a name says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.schema import plain
from fesloop.forms.toml import tables_of_file, write_tables
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.wire import least_burst

Array = NDArray[np.float64]
FORMAT = "fesloop error process 1"
_NOT_NEGATIVE = ("bias_sd_deg", "size_sd", "slow_deg", "slow_s", "rise_s", "fast_deg", "fast_s", "quick_deg",
                 "quick_s", "quick_hz", "speed_s", "rate_deg_s")
_NO_NUMBERS = ("name", "moved", "smooth")
_ROUNDING = 1e-3
"""Rounding of a correlation in a file; eigenvalues err by at most that times its size."""
_COMPONENTS = (("slow_deg", "slow_s"), ("fast_deg", "fast_s"))


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorSeries:
    """The error of one angle: what follows from the motion, and what is random.

        error = bias + slope a + curve a^2 + lead a' + slow(t) + fast(t) + quick(t)

    `a` is the true angle from the centre of its motion, clipped to `angle_deg`; a' its rate, clipped to
    +-`rate_deg_s`, the limits of the recording. `fast` is an Ornstein-Uhlenbeck process
    (doi 10.1103/PhysRev.36.823): what drives it grows with the rate, its variance by 1 + (speed_s a')^2, as
    of soft tissue that is shaken. `slow` is another, or, where `smooth`, one through a low pass of time
    constant `rise_s`, as trackers and interpolation are, with a derivative of its own: its autocorrelation is
    (slow_s exp(-t / slow_s) - rise_s exp(-t / rise_s)) / (slow_s - rise_s), and with equal time constants
    (1 + t / slow_s) exp(-t / slow_s) (Matern 3/2, doi 10.1109/MLSP.2010.5589113). `quick` is
    independent from tick to tick, or, with a time constant, one more Ornstein-Uhlenbeck process, or, with a
    frequency, a damped oscillation that noise drives, like that of a sensor on soft tissue: a stochastic
    cycle of autocorrelation exp(-t / quick_s) cos(2 pi quick_hz t) (Harvey 1989, Forecasting, structural
    time series models and the Kalman filter), which motion drives as it drives `fast`.

    Attributes
    ----------
    name: of the angle, such as "seg2-seg3.x": about x, in the child's frame.
    moved: whether the joint moves about this axis; else this is what constraints leave of a turn that the
        joint forbids, and `a` that angle of the joint which moves most.
    bias_deg: constant part. bias_sd_deg: its sd between recordings, sampled once a trial; 0 for one.
    size_sd: sd of the logarithm of the size of the random parts between recordings, sampled once a trial; 0
        for one. The sds below are those of the mean square over recordings.
    slope: of the angle, "1". curve_deg: at one radian from the centre. lead_s: by how much the estimate is
        ahead of the truth; negative where it lags.
    slow_deg, fast_deg, quick_deg: sd. slow_s, fast_s, quick_s: time constants; of the first two 0, with an
        sd of 0, where there is no such part. quick_hz: frequency; 0 where the quick part does not oscillate.
    smooth: whether the slow part has a derivative; then `slow_s` is above 0. rise_s: its other time constant;
        0 where that is `slow_s`.
    speed_s: above; 0 where the rate makes no difference.
    angle_deg: least and greatest angle from the centre.
    rate_deg_s: greatest rate.
    """

    name: str
    moved: bool = True
    bias_deg: float = 0.0
    bias_sd_deg: float = 0.0
    size_sd: float = 0.0
    slope: float = 0.0
    curve_deg: float = 0.0
    lead_s: float = 0.0
    slow_deg: float = 0.0
    slow_s: float = 0.0
    smooth: bool = False
    rise_s: float = 0.0
    fast_deg: float = 0.0
    fast_s: float = 0.0
    quick_deg: float = 0.0
    quick_s: float = 0.0
    quick_hz: float = 0.0
    speed_s: float = 0.0
    angle_deg: tuple[float, float] = (-180.0, 180.0)
    rate_deg_s: float = 2000.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            numbers = value if isinstance(value, tuple) else (value,)
            if each.name not in _NO_NUMBERS and not all(math.isfinite(number) for number in numbers):
                raise InputError(each.name, f"{value}", "finite numbers")
        for name in _NOT_NEGATIVE:
            if getattr(self, name) < 0.0:
                raise InputError(name, f"{getattr(self, name)}", "zero or more")
        for sd, time in _COMPONENTS:
            if getattr(self, sd) > 0.0 and not getattr(self, time) > 0.0:
                raise InputError(time, f"{getattr(self, time)} with a {sd} of {getattr(self, sd)}", "above 0")
        if self.smooth and not self.slow_s > 0.0:
            raise InputError("slow_s", f"{self.slow_s} of a smooth part", "above 0", "or say smooth = false")
        if self.quick_hz > 0.0 and not self.quick_s > 0.0:
            raise InputError("quick_s", f"{self.quick_s} with a quick_hz of {self.quick_hz}", "above 0")
        if not self.angle_deg[0] <= 0.0 <= self.angle_deg[1]:
            raise InputError("angle_deg", f"{self.angle_deg}", "a least angle up to 0, a greatest from 0 on")

    def row(self) -> Array:
        """Row of numbers, rad and s, in the order of `fesloop.models.error_steps`."""
        rise_s = (self.rise_s or self.slow_s) if self.smooth else 0.0
        bias, curve, slow, fast, quick, low, high, rate = np.radians([
            self.bias_deg, self.curve_deg, self.slow_deg, self.fast_deg, self.quick_deg, *self.angle_deg,
            self.rate_deg_s])
        return np.array([bias, self.slope, curve, self.lead_s, slow, self.slow_s, fast, self.fast_s, quick,
                         self.quick_s, self.speed_s, low, high, rate, rise_s,
                         2.0 * math.pi * self.quick_hz])


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorProcess:
    """Errors of a tracker's angles, and the age and loss of its messages.

    Attributes
    ----------
    series: one an angle.
    correlation: (series, series), of what drives them; empty: independent.
    age_ms: from capture to estimate, at least. jitter: what comes on top of it.
    loss: share of the estimates that never come. burst_messages: mean number lost in a row; 0: each by
        itself.
    source: of which recording and tracker.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]] = MappingProxyType({})
    OFFERED_BY: ClassVar[str] = ""

    @staticmethod
    def file_tables(path: Path) -> dict[str, Any]:
        """Read the parameters' tables from a file, unchecked. Raises InputError for another kind of file."""
        table = tables_of_file(path, FORMAT, "an error process", "fesloop fit-error")
        series = table.get("series")
        if not isinstance(series, dict):
            raise InputError(f"{path}: series", "has no tables", "a table for each angle",
                             "run fesloop fit-error")
        table["series"] = [{"name": name, **each} if isinstance(each, dict) else each
                           for name, each in series.items()]
        return table

    series: tuple[ErrorSeries, ...]
    correlation: tuple[tuple[float, ...], ...] = ()
    age_ms: float = 0.0
    jitter: Duration = field(default=ZERO)
    loss: float = 0.0
    burst_messages: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        names = [each.name for each in self.series]
        if not names or len(set(names)) < len(names):
            raise InputError("series", f"{', '.join(names) or 'none'}", "one or more, each name once")
        rows = [len(row) for row in self.correlation] or [len(names)] * len(names)
        if rows != [len(names)] * len(names) or not _is_correlation(self.matrix()):
            raise InputError("correlation", f"is no correlation of {len(names)} series",
                             "symmetric, ones on the diagonal, no negative eigenvalue")
        if not (math.isfinite(self.age_ms) and self.age_ms >= 0.0):
            raise InputError("age_ms", f"{self.age_ms}", "0 or more ms")
        if self.jitter.kind in ("measured", "recorded"):
            raise InputError("jitter.kind", f"{self.jitter.kind!r}",
                             "zero, fixed, uniform, normal, exponential")
        if self.age_ms + self.jitter.least_ns / NS_PER_MS < 0.0:
            raise InputError("jitter", f"{self.jitter.least_ns / NS_PER_MS:g} ms at least on top of "
                             f"{self.age_ms:g} ms", "a sum of at least 0", "raise age_ms or jitter.low_ms")
        if not 0.0 <= self.loss < 1.0:
            raise InputError("loss", f"{self.loss}", "a share in [0, 1)")
        if not (self.burst_messages == 0.0 or self.burst_messages >= least_burst(self.loss)):
            raise InputError("burst_messages", f"{self.burst_messages}",
                             f"{least_burst(self.loss):g} or more with this loss, or 0")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the series."""
        return tuple(each.name for each in self.series)

    def number(self, name: str) -> int:
        """Index of a series. Raises InputError for an unknown name."""
        if name not in self.names:
            raise InputError("like", f"there is no series {name!r}", ", ".join(self.names),
                             did_you_mean(name, self.names))
        return self.names.index(name)

    def usual(self) -> tuple[str, ...]:
        """Default names of the series for the joints.

        Those of hinges, pairs of segments that move about one axis alone; else of all axes that are moved
        about; else all.
        """
        moved = [each.name for each in self.series if each.moved]
        pairs = [name.rpartition(".")[0] for name in moved]
        hinges = [name for name, pair in zip(moved, pairs, strict=True) if pair and pairs.count(pair) == 1]
        return tuple(hinges or moved or self.names)

    def matrix(self) -> Array:
        """The correlation, (series, series)."""
        return np.array(self.correlation or np.eye(len(self.series)), dtype=np.float64)

    def save(self, path: str | Path) -> None:
        """Write the file. Raises InputError where it cannot be written."""
        table: dict[str, Any] = _rounded(plain(self))
        table["correlation"] = np.round(table["correlation"], 3).tolist()
        series = {each.pop("name"): each for each in table.pop("series")}
        write_tables(path, {"format": FORMAT, **table, "series": series})


def _rounded(value: Any) -> Any:
    """Numbers to six digits, more than any recording determines."""
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _is_correlation(matrix: Array) -> bool:
    symmetric = np.allclose(matrix, matrix.T, atol=1e-9) and np.allclose(np.diag(matrix), 1.0, atol=1e-9)
    return bool(symmetric and np.linalg.eigvalsh(matrix).min() > -_ROUNDING * len(matrix))

"""Checks of the content of files; each raises an InputError that names the file, the key and the fault."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

Array = NDArray[np.float64]

FASTEST_GYR = 60.0
"""rad/s; gyroscopes end at 2000 to 3000 deg/s (35 to 52 rad/s), so more means another unit (chosen)."""
GRAVITY_BAND = (7.5, 13.0)
"""m/s^2; range of the median length of an accelerometer's samples, which allows for scale errors of 20 % and
lively movement (chosen)."""
FIELD_BAND = (2e-6, 1e-3)
"""T; the Earth's field is 25 to 65 uT, and iron indoors changes it by less than tenfold (chosen)."""
EARTH_BAND = (15e-6, 100e-6)
"""T; range of the Earth's field; a factor that leads into it is a factor of units (chosen)."""
_UNITS = {"T": 1.0, "uT": 1e-6, "gauss": 1e-4, "mgauss": 1e-7, "nT": 1e-9, "mT": 1e-3}


def entry(content: Mapping[str, Any], key: str, where: str) -> Any:
    """The value of a key."""
    if key not in content:
        raise InputError(f"{where}: {key}", "is missing", remedy="take the file as its makers published it")
    return content[key]


def numbers(content: Mapping[str, Any], key: str, shape: Sequence[int | None], where: str) -> Array:
    """A key's numbers as a fresh float64 array of the given shape, None for any length above 0."""
    value = entry(content, key, where)
    array = np.asarray(value)
    place = f"{where}: {key}"
    if array.dtype.kind not in "fiub":
        raise InputError(place, f"holds {array.dtype.name} values", "real numbers")
    fits = array.ndim == len(shape) and array.size > 0 and all(
        length is None or size == length for size, length in zip(array.shape, shape, strict=False))
    if not fits:
        allowed = "(" + ", ".join("any" if size is None else str(size) for size in shape) + ")"
        raise InputError(place, f"has shape {array.shape}", allowed)
    return np.array(array, dtype=np.float64, order="C")


def finite(array: Array, place: str) -> None:
    """Raise InputError unless every row is of finite numbers."""
    bad = ~np.isfinite(array.reshape(array.shape[0], -1)).all(axis=1)
    if bad.any():
        raise InputError(place, f"{int(bad.sum())} of {bad.size} samples are not finite, the first is sample "
                         f"{int(np.argmax(bad))}", "finite numbers")


def sound(samples: Array, place: str) -> Array:
    """Rows of samples (n, 3) that are not lost: a lost one holds NaN; infinite ones are refused."""
    if np.isinf(samples).any():
        at = int(np.argmax(np.isinf(samples).any(axis=1)))
        raise InputError(place, f"is infinite in sample {at}", "finite numbers, NaN where a sample was lost")
    rows = samples[~np.isnan(samples).any(axis=1)]
    if not len(rows):
        raise InputError(place, "holds no sample at all", "finite numbers, NaN where a sample was lost",
                         "leave the sensor out")
    return rows


def plausible_gyr(gyr: Array, place: str) -> None:
    """Angular rates (n, 3) that can be rad/s, as far as they are not lost."""
    fastest = float(np.abs(sound(gyr, place)).max())
    if fastest > FASTEST_GYR:
        raise InputError(place, f"reaches {fastest:.4g}, which is no angular rate in rad/s",
                         f"at most {FASTEST_GYR:g} rad/s", "convert deg/s to rad/s")


def plausible_acc(acc: Array, place: str) -> None:
    """Accelerations (n, 3) that can be m/s^2 with gravity in them, as far as they are not lost."""
    median = float(np.median(np.linalg.norm(sound(acc, place), axis=-1)))
    low, high = GRAVITY_BAND
    if not low <= median <= high:
        raise InputError(place, f"has a median length of {median:.4g}",
                         f"{low:g} to {high:g} m/s^2, gravity included", "convert to m/s^2")


def plausible_mag(mag: Array, place: str) -> None:
    """Magnetic fields (n, 3) that can be T, as far as they are not lost."""
    median = float(np.median(np.linalg.norm(sound(mag, place), axis=-1)))
    low, high = FIELD_BAND
    if not low <= median <= high:
        raise InputError(place, f"has a median length of {median * 1e6:.4g} uT",
                         f"{low * 1e6:g} to {high * 1e6:g} uT", _likely_unit(median))


def _likely_unit(median: float) -> str:
    """Remedy for a median field: the likely unit of the numbers, and the unit that they are read in."""
    found = [f"{its} read as {taken}" for taken, other in _UNITS.items() for its, one in _UNITS.items()
             if EARTH_BAND[0] <= median * one / other <= EARTH_BAND[1]]
    state = f"state it as `units.mag` of a layout, one of {', '.join(_UNITS)}"
    return f"the unit looks like {' or '.join(found[:4])}: {state}" if found else (
        f"no unit explains that: {state}, or leave the magnetometers out")


def orientations(quaternions: Array, place: str) -> Array:
    """Quaternions (n, 4) with length 1, whole rows NaN where a component is, or where all are zero.

    Raises where a length is off by more than 1 %, and where nothing but NaN is left.
    """
    known = np.isfinite(quaternions).all(axis=1) & quaternions.any(axis=1)
    if not known.any():
        raise InputError(place, "holds no orientation at all", "quaternions, NaN or zeros where occluded")
    length = np.linalg.norm(quaternions[known], axis=1)
    off = np.abs(length - 1.0) > 0.01
    if off.any():
        at = int(np.flatnonzero(known)[np.argmax(off)])
        raise InputError(place, f"{int(off.sum())} quaternions are not of length 1, the first is row {at}",
                         "unit quaternions w, x, y, z")
    unit = np.full_like(quaternions, np.nan)
    unit[known] = quaternions[known] / length[:, np.newaxis]
    return unit


def equal_lengths(lengths: Mapping[str, int], where: str) -> None:
    """Raise InputError unless all keys have as many samples as the first."""
    first = next(iter(lengths))
    for key, length in lengths.items():
        if length != lengths[first]:
            raise InputError(f"{where}: {key}", f"has {length} samples, {first} has {lengths[first]}",
                             "equal lengths")


def columns(content: Mapping[str, Any], key: str, chosen: Sequence[str], where: str) -> list[int]:
    """Numbers of the chosen columns, from a key that lists the names of all."""
    names = [str(name) for name in np.atleast_1d(np.asarray(entry(content, key, where))).ravel()]
    absent = [name for name in chosen if name not in names]
    if absent:
        raise InputError(f"{where}: {key}", f"names no column {absent[0]!r}", ", ".join(names[:12]))
    return [names.index(name) for name in chosen]

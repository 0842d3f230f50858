"""What a sender plays: rows of numbers, and what their channels are."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import parse_rate
from fesloop.streams.live.description import Channel
from fesloop.streams.pace import timeline
from fesloop.streams.recording import MotionRecording

_UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T"}


class Played(NamedTuple):
    """A stream's type, its channels, its rows (samples, channels), and their rate in Hz."""

    stream_type: str
    channels: tuple[Channel, ...]
    rows: NDArray[np.float32]
    rate_hz: float


def inertial(recording: MotionRecording, rate: str | None = None) -> Played:
    """A recording of inertial sensors: gyr, acc and mag of the first sensor, then of the next.

    Channels are called such as `F2p_gyr_x`, in SI. NaN is what the recording lost, or what a gap lacks.

    Parameters
    ----------
    recording: what is played.
    rate: Hz; None: as recorded, between gaps. Raises InputError where there is none, as of uneven samples.
    """
    known = recording.rate if rate is None else parse_rate(rate)
    line = timeline(recording.stamps_ns, str(recording.path))
    if known is None and line.gaps:
        known = Fraction(line.rate_hz)
    if known is None:
        raise InputError("rate", f"{recording.path} is not evenly sampled", "a rate in Hz")
    kinds = {"gyr": recording.gyr, "acc": recording.acc}
    if recording.mag is not None:
        kinds["mag"] = recording.mag
    rows = np.stack(list(kinds.values()), axis=2).reshape(recording.samples, -1).astype(np.float32)
    rows = np.where((line.rows >= 0)[:, np.newaxis], rows[line.rows], np.float32(np.nan))
    channels = tuple(Channel(f"{sensor}_{kind}_{axis}", _UNITS[kind], kind.upper())
                     for sensor in recording.sensors for kind in kinds for axis in "xyz")
    return Played("IMU", channels, rows, float(known))


def posture(angles: NDArray[np.float64], joints: Sequence[str], rate_hz: float) -> Played:
    """Joint angles (samples, joints), rad."""
    channels = tuple(Channel(joint, "rad", "Angle") for joint in joints)
    return Played("Posture", channels, angles.astype(np.float32), rate_hz)

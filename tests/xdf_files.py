"""XDF files written byte by byte from the specification, so that a reader is held against nothing of ours."""

from __future__ import annotations

import struct

import numpy as np

BOUNDARY = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")
MOTION_LABELS = [f"{kind}_{axis}" for kind in ("gyr", "acc", "mag") for axis in "xyz"]
MOTION_UNITS = ["deg/s"] * 3 + ["g"] * 3 + ["uT"] * 3


def chunk(tag, body, width=4):
    """A chunk; `width` bytes hold its length."""
    return bytes([width]) + (len(body) + 2).to_bytes(width, "little") + struct.pack("<H", tag) + body


def header(stream, name="imu", kind="IMU", rate=100.0, form="float32", labels=(), units=None, types=None,
           extra=""):
    """A stream's header."""
    units = units if units is not None else [""] * len(labels)
    types = types if types is not None else [""] * len(labels)
    described = "".join(f"<channel><label>{label}</label><unit>{unit}</unit><type>{each}</type></channel>"
                        for label, unit, each in zip(labels, units, types, strict=True))
    xml = (f"<?xml version='1.0'?><info><name>{name}</name><type>{kind}</type><channel_count>{len(labels)}"
           f"</channel_count><nominal_srate>{rate}</nominal_srate><channel_format>{form}</channel_format>"
           f"<desc><channels>{described}</channels>{extra}</desc></info>")
    return chunk(2, struct.pack("<I", stream) + xml.encode())


def samples(stream, times, values, stamped=None, width=4):
    """A chunk of samples; those that are not `stamped` follow the one before at the nominal rate."""
    stamped = np.ones(len(times), bool) if stamped is None else stamped
    body = struct.pack("<I", stream) + bytes([width]) + len(times).to_bytes(width, "little")
    for time, row, with_stamp in zip(times, values, stamped, strict=True):
        body += (b"\x08" + struct.pack("<d", time) if with_stamp else b"\x00") + row.tobytes()
    return chunk(3, body)


def clock_offset(stream, time, offset):
    """A measurement of the sender's clock."""
    return chunk(4, struct.pack("<Idd", stream, time, offset))


def footer(stream, count):
    """A stream's footer."""
    return chunk(6, struct.pack("<I", stream) + f"<info><sample_count>{count}</sample_count></info>".encode())


def file_of(*chunks):
    """A whole file."""
    first = chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>", 1)
    return b"XDF:" + first + b"".join(chunks)


def motion(count=400, seed=0):
    """(times, values float32) of a sensor at rest: deg/s, g, uT; stamps with jitter."""
    rng = np.random.default_rng(seed)
    values = np.hstack([rng.normal(0.0, 1.0, (count, 3)),
                        np.array([0.0, 0.0, 1.0]) + rng.normal(0.0, 0.01, (count, 3)),
                        np.array([0.0, 20.0, -40.0]) + rng.normal(0.0, 0.1, (count, 3))]).astype("<f4")
    return 1000.0 + 0.01 * np.arange(count) + rng.normal(0.0, 1e-4, count), values


def motion_file(chunk_samples=50, **changes):
    """A file of one sensor with jitter, clock offsets, chunks of several sizes and missing stamps."""
    times, values = motion()
    rng = np.random.default_rng(1)
    parts = [header(7, **{"labels": MOTION_LABELS, "units": MOTION_UNITS, **changes})]
    for number, start in enumerate(range(0, len(times), chunk_samples)):
        rows = slice(start, start + chunk_samples)
        stamped = rng.random(len(times[rows])) < 0.5 if number % 2 else None
        if stamped is not None:
            stamped[0] = True
        parts += [clock_offset(7, times[start] + 0.5, -20.0 + 1e-5 * number + rng.normal(0.0, 1e-5)),
                  samples(7, times[rows], values[rows], stamped, (1, 4, 8)[number % 3]),
                  chunk(5, BOUNDARY, 1)]
    return file_of(*parts, footer(7, len(times)))

"""`fesloop bench lsl`: latency from a sample sent to its command received, and of the bare sample.

Four processes on one machine: a sender of 16 sensors with nine channels each at 100 Hz, the loop of the
shipped experiment `hil_live` in step with the wall clock (tracker, MPC, safety block, outlet, recording on
disk), a receiver of its commands, and one that receives the samples themselves, which is the bare loopback.
Commands carry the capture of their sample. Latencies are of the same samples.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
from collections.abc import Callable
from multiprocessing.queues import SimpleQueue
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run as run_experiment
from fesloop.loop.realtime import Pacing
from fesloop.streams.live.library import open_library

Array = NDArray[np.float64]
SECONDS, SHORT_S, WARM_UP_S = 60.0, 10.0, 2.0
"""Duration of the loop, and its beginning, not counted, in which caches fill and the tracker aligns."""
_STARTING_S = 120.0
_MATCH_S = 1e-3
"""Difference allowed between the stamps of a command and of its sample: the offset between two clocks is
measured repeatedly, and a sample comes every 10 ms."""


def run(short: bool = False, seconds: float | None = None, priority: int = 0,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Rows for the bare loopback and end to end, us; no rows, with the reason, where liblsl is missing.

    `priority` is that of the loop, as of `fesloop run`; 0 for none. `excess_p99_us` is the 99th
    percentile end to end less that of the bare loopback.
    """
    try:
        open_library()
    except InputError as absent:
        print(f"bench lsl: {absent}", file=sys.stderr)
        return {"bench": "lsl", "rows": []}
    seconds = seconds or (SHORT_S if short else SECONDS)
    bare, commands = measure(seconds, Pacing(priority=priority), progress or (lambda share: None))
    ends = _answered(commands, bare[:, 0])
    counted = ends[ends[:, 0] > ends[0, 0] + WARM_UP_S]
    direct = bare[np.isin(bare[:, 0], counted[:, 0])]
    whole_us, bare_us = (1e6 * (pairs[:, 1] - pairs[:, 0]) for pairs in (counted, direct))
    reference = float(np.median(bare_us))
    rows = [_row("bare loopback", bare_us, None), _row("sample to command", whole_us, reference)]
    rows[1]["excess_p99_us"] = rows[1]["us_p99"] - rows[0]["us_p99"]
    return {"bench": "lsl", "rows": rows, "samples": len(counted)}


def measure(seconds: float, pacing: Pacing, progress: Callable[[float], None]) -> tuple[Array, Array]:
    """(stamp, instant received), s by LSL's clock, of samples and of commands, (n, 2) each."""
    context = multiprocessing.get_context("spawn")
    ending, found = context.Event(), context.SimpleQueue()
    samples, commands = f"samples of bench {os.getpid()}", f"commands of bench {os.getpid()}"
    works: tuple[tuple[Callable[..., None], tuple[Any, ...]], ...] = (
        (_send, (samples, ending)), (_receive, (samples, ending, found)),
        (_receive, (commands, ending, found)))
    processes = [context.Process(target=target, args=args, daemon=True) for target, args in works]
    for process in processes:
        process.start()
    settings = [f"stream={samples}", f"blocks.outlet.stream={commands}",
                "blocks.sensors.magnetometers=true", f"blocks.sensors.timeout_s={_STARTING_S}",
                f"experiment.duration_s={seconds}"]
    try:
        with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
            run_experiment(load("hil_live", settings), Path(folder), realtime=pacing, progress=progress)
        ending.set()
        pairs = dict(found.get() for _ in (samples, commands))
    finally:
        for process in processes:
            process.terminate()
            process.join()
    return np.array(pairs[samples]), np.array(pairs[commands])


def _send(stream: str, ending: Event) -> None:
    """Play a hand that moves, again and again."""
    from fesloop.experiment.moving_hand import moving_hand
    from fesloop.streams.live.sender import StreamSender, inertial

    sender = StreamSender(played=inertial(moving_hand()), stream=stream, repeat=True)
    sender.send(going_on=lambda: not ending.is_set())


def _receive(stream: str, ending: Event, found: SimpleQueue[tuple[str, list[tuple[float, float]]]]) -> None:
    """Hand over (stamp, instant) of every sample that comes until the end."""
    pylsl = open_library()
    inlet = pylsl.StreamInlet(pylsl.resolve_byprop("name", stream, timeout=_STARTING_S)[0], max_chunklen=1,
                              recover=False, as_numpy=True)
    pairs: list[tuple[float, float]] = []
    while not ending.is_set():
        try:
            _, stamp = inlet.pull_sample(timeout=0.5)
        except RuntimeError:  # the loop has closed its outlet
            break
        if stamp is not None:
            pairs.append((stamp, pylsl.local_clock()))
    found.put((stream, pairs))


def _answered(commands: Array, stamps: Array) -> Array:
    """(stamp of the sample, instant of the command), the first command of each sample, (n, 2)."""
    nearest = np.searchsorted(stamps, commands[:, 0])
    nearest = np.clip(nearest, 1, len(stamps) - 1)
    nearest -= commands[:, 0] - stamps[nearest - 1] < stamps[nearest] - commands[:, 0]
    sound = np.abs(stamps[nearest] - commands[:, 0]) < _MATCH_S
    _, first = np.unique(nearest[sound], return_index=True)
    return np.column_stack([stamps[nearest[sound]], commands[sound, 1]])[first]


def _row(case: str, us: Array, reference_us: float | None) -> dict[str, Any]:
    """A case; the reference is the bare loopback's median."""
    median = float(np.median(us))
    return {"case": case, "us_median": median, "us_p99": float(np.percentile(us, 99)),
            "us_worst": float(us.max()), "reference": "bare loopback" if reference_us else None,
            "reference_us_median": reference_us, "ratio": median / reference_us if reference_us else None}

"""`fesloop bench stream_faults`: what becomes of current when the sensors' stream goes wrong.

A session of `hil_live` with a `dry` stimulator directly behind its safety block, and a sender in another
process that goes wrong at random moments, now in one way, now in another, and right again in between. A row a
fault: the time from its first sample to zero current that lasts, as the device's own log has it. `reference`
is the stated time, so that `ratio`, of the worst, must be below 1; `stated_held` and `cause_named`: of how
many. Only faults that begin while the patient is stimulated count; `not_stimulated` says how many did not.
"""

from __future__ import annotations

import multiprocessing
import os
import random
import sys
import tempfile
from collections.abc import Callable, Sequence
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fesloop.bench._device_log import Given, given
from fesloop.errors import InputError
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.parse import from_document, load
from fesloop.experiment.reading import Recording
from fesloop.experiment.trial import run as run_experiment
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.streams.live.library import open_library
from fesloop.streams.live.sender_faults import SenderFault

FAULTS = {"stop": (350.0, "stream_silent"), "vanish": (350.0, "stream_lost"),
          "freeze": (400.0, "stream_frozen"), "repeat": (350.0, "stamp_repeated"),
          "clock": (350.0, "stamp_behind"), "nan": (350.0, "empty_sample"),
          "reorder": (650.0, "rate_changed"), "rate": (650.0, "rate_changed")}
"""Stated time, ms, and the status that names the cause. 300 are the posture's greatest age and the ramp of
`hil_live`; 30 pass until a silent stream is ticked on, 20 are left for waking up. Frozen numbers are
known after 50, another rate after ten samples that are all of it, 300 at half the rate."""
_MANY, _FEW = 50, 3
_LENGTH_S, _REST_S = 1.2, (3.0, 4.0)
"""Of a fault, and between two: the stimulation begins anew a second after the stream is sound."""
_BEGIN_S = 6.0
_A_SESSION = 40
"""Faults in one session: some three minutes (chosen)."""
_HOLD_MS = 1000.0
"""The keeper of the device is not what is tried here: it waits for longer than the safety block takes."""
_STARTING_S = 120.0


class Outcome(NamedTuple):
    """What came of one fault: time to zero current, ms, infinite for never; whether the cause was told."""

    zero_ms: float
    named: bool


def run(short: bool = False, seed: int | None = None, progress: Callable[[float], None] | None = None,
        kinds: Sequence[str] = tuple(FAULTS), moments: int | None = None) -> dict[str, Any]:
    """One row a fault; `seed` of the moments, None for new ones each time; `moments` of another count.

    No rows, with the reason on standard error, where liblsl is missing.
    """
    try:
        open_library()
    except InputError as absent:
        print(f"bench stream_faults: {absent}", file=sys.stderr)
        return {"bench": "stream_faults", "rows": []}
    chance = random.Random(seed)
    order = [kind for kind in kinds for _ in range(moments or (_FEW if short else _MANY))]
    chance.shuffle(order)
    outcomes: dict[str, list[Outcome]] = {kind: [] for kind in kinds}
    idle = 0
    for begin in range(0, len(order), _A_SESSION):
        faults = _planned(order[begin:begin + _A_SESSION], chance)
        for fault, outcome in zip(faults, _session(faults), strict=True):
            if outcome is None:
                idle += 1
            else:
                outcomes[fault.kind].append(outcome)
        if progress:
            progress(min(1.0, (begin + _A_SESSION) / len(order)))
    rows = [_row(kind, outcomes[kind]) for kind in kinds if outcomes[kind]]
    return {"bench": "stream_faults", "rows": rows, "not_stimulated": idle}


def _planned(kinds: Sequence[str], chance: random.Random) -> list[SenderFault]:
    """These faults one after the other, at random moments."""
    faults, begin = [], _BEGIN_S
    for kind in kinds:
        begin += chance.uniform(*_REST_S)
        faults.append(SenderFault.parse(f"{kind}@{begin:.4f}+{_LENGTH_S}"))
        begin += _LENGTH_S
    return faults


def _session(faults: Sequence[SenderFault]) -> list[Outcome | None]:
    """What came of each; None where it met no stimulation."""
    context = multiprocessing.get_context("spawn")
    begun: SimpleQueue[int] = context.SimpleQueue()
    stream = f"samples of bench {os.getpid()}"
    sender = context.Process(target=_send, args=(stream, list(faults), begun), daemon=True)
    sender.start()
    try:
        with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
            log = Path(folder) / "device.log"
            seconds = faults[-1].start_s + _LENGTH_S
            result = run_experiment(_experiment(stream, log, seconds), Path(folder), realtime=True)
            return _judged(faults, begun.get(), given(log), result.recording)
    finally:
        sender.terminate()
        sender.join()


def _send(stream: str, faults: list[SenderFault], begun: SimpleQueue[int]) -> None:
    """Play a hand that moves, with its faults."""
    from fesloop.streams.live.moving_hand import moving_hand
    from fesloop.streams.live.sender import StreamSender

    StreamSender(recording=moving_hand(), stream=stream, repeat=True, faults=faults).send(begins=begun.put)


def _experiment(stream: str, log: Path, seconds: float) -> Experiment:
    """`hil_live` with a device."""
    document = load("hil_live", [f"stream={stream}", f"blocks.outlet.stream=commands to {stream}",
                                 f"blocks.sensors.timeout_s={_STARTING_S}",
                                 f"experiment.duration_s={seconds}"]).document()
    document["blocks"]["device"] = {"kind": "stimulator_device", "clock": "sensors", "driver": "dry",
                                    "port": str(log), "frequency_hz": "40", "hold_ms": _HOLD_MS}
    document["wires"].append({"from": "safety.stimulation", "to": "device.stimulation"})
    return from_document(document, "hil_live")


def _judged(faults: Sequence[SenderFault], begun_ns: int, rows: Sequence[Given],
            path: Path) -> list[Outcome | None]:
    """What the device's log and the recording tell of each fault."""
    with Recording(path) as recording:
        origin = int(recording.origins["monotonic_ns"][0])
        events = [(origin + event.time_ns, event.status) for event in recording.events]
    outcomes: list[Outcome | None] = []
    for fault in faults:
        first = begun_ns + round(fault.start_s * NS_PER_S)
        last = first + round(fault.length_s * NS_PER_S)
        zero_ms = zero_within_ms(rows, first, last)
        named = any(first <= when <= last and status == FAULTS[fault.kind][1] for when, status in events)
        outcomes.append(None if zero_ms is None else Outcome(zero_ms, named))
    return outcomes


def zero_within_ms(rows: Sequence[Given], first_ns: int, last_ns: int) -> float | None:
    """From the first instant to zero current that lasts until the last one, ms; infinite where it does not
    come, None where there was no current at the first."""
    before = [row for row in rows if row.stamp_ns <= first_ns]
    if not before or not before[-1].on:
        return None
    within = [row for row in rows if first_ns < row.stamp_ns <= last_ns]
    on = [number for number, row in enumerate(within) if row.on]
    zero = on[-1] + 1 if on else 0
    return (within[zero].stamp_ns - first_ns) / NS_PER_MS if zero < len(within) else float("inf")


def _row(kind: str, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    stated_ms, cause = FAULTS[kind]
    micros = 1e3 * np.array([outcome.zero_ms for outcome in outcomes])
    count = len(outcomes)
    return {"case": kind, "us_median": float(np.median(micros)), "us_p99": float(np.percentile(micros, 99)),
            "us_worst": float(micros.max()), "reference": "stated time",
            "reference_us_median": 1e3 * stated_ms, "ratio": float(micros.max()) / (1e3 * stated_ms),
            "count": count, "stated_held": f"{int((micros <= 1e3 * stated_ms).sum())} of {count}",
            "cause": cause, "cause_named": f"{sum(outcome.named for outcome in outcomes)} of {count}"}

"""`fesloop bench stream_faults`: time to zero current after a fault of the sensors' stream.

A session of `hil_live` has a `dry` stimulator directly behind its safety block, and a sender in another
process that is faulty at random moments, in various ways, and sound in between. A jump is tested on a stream
of joint angles in place of sensors and tracker: a jump of inertial samples, each of them plausible, cannot be
detected. Each row is a fault: the time from its first sample to lasting zero current in the device's own log.
`reference` is the stated time, so that `ratio`, of the worst, must be below 1; `stated_held` and
`cause_named` count faults. Only faults that begin while the patient is stimulated count; `not_stimulated`
counts the others.
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

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.experiment.running import run as run_experiment
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.streams.live.library import open_library
from fesloop.streams.live.sender import Played, SenderFault, posture


class Given(NamedTuple):
    """A line of a device's log: its instant (monotonic clock) and whether there is current from then on."""

    stamp_ns: int
    on: bool


def given(log: Path) -> list[Given]:
    """Every whole line of a log that `dry` or a simulated device writes."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    return [Given(int(stamp), any(float(pulse.partition("/")[0]) > 0.0 for pulse in pulses.split()))
            for stamp, _, pulses in (line.split("\t") for line in lines)]


FAULTS = {"stop": (380.0, "stream_silent"), "vanish": (380.0, "stream_lost"),
          "freeze": (430.0, "stream_frozen"), "repeat": (380.0, "stamp_repeated"),
          "clock": (380.0, "stamp_behind"), "nan": (380.0, "empty_sample"),
          "reorder": (680.0, "rate_changed"), "rate": (680.0, "rate_changed"),
          "jump": (280.0, "posture_jumped")}
"""Longest time from a fault to the end of stimulation, ms, and the status that names the cause. Each is a
sum: 200 for the ramp of `hil_live`, 60 for stalls of a busy machine, 100 for the greatest age of a posture
    (not
for a jump, which is seen at once), 20 until the next tick of a silent stream, 50 until a frozen value is
noticed, and 300 for ten samples at half the rate."""
_OF_POSTURE = "jump"
_HELD_S, _GOES_S = 10.0, 1.0
_VALUES = {"jump": _HELD_S + _GOES_S, "clock": -1.0, "rate": 0.5}
"""The posture is held straight and bent in turn, so that a jump by half a period leads from one to the other.
Jumps begin while it is held: half way through the movement a jump would lead to the same posture."""
_MANY, _FEW = 50, 3
_LENGTH_S, _REST_S = 0.9, (3.0, 4.0)
"""Durations of a fault, and between two: stimulation resumes a second after the posture is sound."""
_BEGIN_S = 6.0
_A_SESSION = 40
"""Faults in one session: some three minutes (chosen)."""
_HOLD_MS = 1000.0
"""The watchdog of the device is not tested here: it waits for longer than the safety block takes."""
_STARTING_S = 120.0
_RATE_HZ = 100.0
_JOINTS = ("F2_mcp_flexion", "F2_pip_flexion", "F2_dip_flexion")


class Outcome(NamedTuple):
    """Outcome of one fault: time to zero current, ms, inf for never; whether a status named the cause."""

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
    sessions = _sessions(kinds, moments or (_FEW if short else _MANY), chance)
    outcomes: dict[str, list[Outcome]] = {kind: [] for kind in kinds}
    idle = 0
    for number, faults in enumerate(sessions):
        for fault, outcome in zip(faults, _session(faults), strict=True):
            if outcome is None:
                idle += 1
            else:
                outcomes[fault.kind].append(outcome)
        if progress:
            progress((number + 1) / len(sessions))
    rows = [_row(kind, outcomes[kind]) for kind in kinds if outcomes[kind]]
    return {"bench": "stream_faults", "rows": rows, "not_stimulated": idle}


def _sessions(kinds: Sequence[str], moments: int, chance: random.Random) -> list[list[SenderFault]]:
    """Sessions with each kind of fault so often, in random order; those on a posture are sessions apart."""
    planned = []
    for of_posture in (False, True):
        order = [kind for kind in kinds for _ in range(moments) if (kind == _OF_POSTURE) == of_posture]
        chance.shuffle(order)
        planned += [_planned(order[begin:begin + _A_SESSION], chance)
                    for begin in range(0, len(order), _A_SESSION)]
    return planned


def _planned(kinds: Sequence[str], chance: random.Random) -> list[SenderFault]:
    """These faults one after the other, at random moments."""
    faults, begin = [], _BEGIN_S
    for kind in kinds:
        begin += chance.uniform(*_REST_S)
        if kind == _OF_POSTURE:
            begin = _held_from(begin)
        faults.append(SenderFault(kind, begin, _LENGTH_S, _VALUES.get(kind, 0.0)))
        begin += _LENGTH_S
    return faults


def _held_from(begin_s: float) -> float:
    """The first instant from this one on at which the posture is held, for as long as a fault lasts."""
    within = begin_s % (_HELD_S + _GOES_S)
    return begin_s if within + _LENGTH_S <= _HELD_S else begin_s - within + _HELD_S + _GOES_S


def _session(faults: Sequence[SenderFault]) -> list[Outcome | None]:
    """The outcome of each fault; None where it met no stimulation."""
    context = multiprocessing.get_context("spawn")
    begun: SimpleQueue[int] = context.SimpleQueue()
    stream = f"samples of bench {os.getpid()}"
    of_posture = faults[0].kind == _OF_POSTURE
    sender = context.Process(target=_send, args=(stream, list(faults), begun, of_posture), daemon=True)
    sender.start()
    try:
        with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
            log = Path(folder) / "device.log"
            seconds = faults[-1].start_s + _LENGTH_S
            experiment = _experiment(stream, log, seconds, of_posture)
            result = run_experiment(experiment, Path(folder), realtime=True)
            return _judged(faults, begun.get(), given(log), result.recording)
    finally:
        sender.terminate()
        sender.join()


def _send(stream: str, faults: list[SenderFault], begun: SimpleQueue[int], of_posture: bool) -> None:
    """Play sensors of a hand that moves, or a posture, with faults."""
    from fesloop.experiment.moving_hand import moving_hand
    from fesloop.streams.live.sender import StreamSender, inertial

    played = _posture() if of_posture else inertial(moving_hand())
    StreamSender(played=played, stream=stream, repeat=True, faults=faults).send(begins=begun.put)


def _posture() -> Played:
    """The index finger's flexions, straight and bent in turn, with a tracker's noise of .1 deg."""
    held, goes = np.zeros(round(_HELD_S * _RATE_HZ)), np.linspace(0.0, 1.0, round(_GOES_S * _RATE_HZ))
    share = np.concatenate([held, goes, held + 1.0, 1.0 - goes])[:, np.newaxis]
    noise = np.random.default_rng(1).normal(0.0, 0.1, (len(share), len(_JOINTS)))
    return posture(np.radians(5.0 + share * [26.0, 36.0, 15.0] + noise), _JOINTS, _RATE_HZ)


def _experiment(stream: str, log: Path, seconds: float, of_posture: bool) -> Experiment:
    """`hil_live` with a device, and with a posture in place of sensors and tracker."""
    document = load("hil_live", [f"stream={stream}", f"blocks.outlet.stream=commands to {stream}",
                                 f"blocks.sensors.timeout_s={_STARTING_S}",
                                 f"experiment.duration_s={seconds}"]).document()
    blocks = document["blocks"]
    blocks["device"] = {"kind": "stimulator_device", "clock": "sensors", "driver": "dry",
                        "port": str(log), "frequency_hz": "40", "hold_ms": _HOLD_MS}
    document["wires"].append({"from": "safety.stimulation", "to": "device.stimulation"})
    if of_posture:
        blocks["reference"]["angles_deg"] = [[34, 45, 22]] * len(blocks["reference"]["times_s"])
        blocks["sensors"] = {"kind": "lsl_inlet", "stream": stream, "holds": "posture",
                             "joints": list(_JOINTS), "timeout_s": _STARTING_S}
        for name in ("tracker", "finger", "finger_sd"):
            del blocks[name]
        document["wires"] = [
            *(wire for wire in document["wires"] if wire["from"].partition(".")[0] in blocks
              and wire["to"].partition(".")[0] in blocks),
            {"from": "sensors.angles", "to": "controller.measured"},
            {"from": "sensors.angles", "to": "safety.posture"}]
    return from_document(document, "hil_live")


def _judged(faults: Sequence[SenderFault], begun_ns: int, rows: Sequence[Given],
            path: Path) -> list[Outcome | None]:
    """The outcome of each fault, from the device's log and the recording."""
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
    """Time from the first instant to zero current that lasts until the last one, ms.

    Infinite where it does not come, None where there was no current at the first.
    """
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
    return {"case": kind, "us_median": float(np.percentile(micros, 50, method="higher")),
            "us_p99": float(np.percentile(micros, 99, method="higher")),
            "us_worst": float(micros.max()), "reference": "stated time",
            "reference_us_median": 1e3 * stated_ms, "ratio": float(micros.max()) / (1e3 * stated_ms),
            "count": count, "stated_held": f"{int((micros <= 1e3 * stated_ms).sum())} of {count}",
            "cause": cause, "cause_named": f"{sum(outcome.named for outcome in outcomes)} of {count}"}

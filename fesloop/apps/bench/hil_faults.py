"""`fesloop bench hil_faults`: what becomes of current and recording when a session breaks.

A row a fault, tried at random moments of `hil_dry_stimulator`, each time in fresh processes. The times are
those from the fault to zero current, measured at the device's end of the line; `reference` is the time that
`fesloop check` states, so that `ratio`, of the worst, must be below 1. `recording_readable`, `cause_named`:
of how many; `lost_s`: the most that a recording misses before its fault; `stated_held`: of how many tries
current was zero in time; `without_current`: tries that do not count, for the safety block, or a machine too
busy for real time, had ended stimulation before. A fault that cannot be tried here is told as `not_tried`.
What befalls a live stream is `stream_faults`.

Each is tried fifty times, which takes some 25 minutes; in the short form three times.
"""

from __future__ import annotations

import random
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fesloop.apps.bench._device_log import given, zero_after_ms
from fesloop.apps.bench._paced_session import EXPERIMENT, session
from fesloop.apps.bench._session_faults import FAULTS, Fault, zero_or_late
from fesloop.errors import FesloopError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S

_FEW, _MANY = 3, 50
_EARLIEST_S, _LATEST_S = 0.2, 4.5
"""After the first current; the session's movement lies within."""


class Outcome(NamedTuple):
    """What came of one fault.

    Attributes
    ----------
    zero_ms: to zero current; infinite where it never was.
    lost_s: of the recording before the fault; infinite where it cannot be read.
    named: whether the cause was told.
    """

    zero_ms: float
    lost_s: float
    named: bool


def run(short: bool = False, seed: int | None = None, progress: Callable[[float], None] | None = None,
        faults: Sequence[Fault] = FAULTS, moments: int | None = None) -> dict[str, Any]:
    """One row a fault; `seed` of the moments, None for new ones each time; `moments` of another count."""
    moments = (_FEW if short else _MANY) if moments is None else moments
    chance = random.Random(seed)
    rows, not_tried = [], []
    for number, fault in enumerate(faults):
        outcomes: list[Outcome] = []
        without = 0
        try:
            while len(outcomes) < moments and without <= _FEW * moments:
                outcome = _tried(fault, chance.uniform(_EARLIEST_S, _LATEST_S))
                if outcome is None:
                    without += 1
                    continue
                outcomes.append(outcome)
                if progress:
                    progress((number + len(outcomes) / moments) / len(faults))
        except RunError as why:
            not_tried.append({"fault": fault.name, "tried": len(outcomes), "why": str(why)})
        if outcomes:
            rows.append(_row(fault, outcomes) | {"without_current": without})
    return {"bench": "hil_faults", "rows": rows, "not_tried": not_tried}


def _tried(fault: Fault, after_s: float) -> Outcome | None:
    """A session, the fault, and what is left; None where there was no current when it was to begin."""
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder, \
            session(Path(folder), fault.driver, fault.settings, own_disk=fault.own_disk) as this:
        time.sleep(after_s)
        if not given(this.log)[-1].on:
            return None
        struck_ns = time.monotonic_ns()
        fault.strike(this)
        zero_or_late(this)
        if fault.mend is not None:
            fault.mend(this)
        said = this.ended()
        zero_ms = zero_after_ms(given(this.log), struck_ns)
        lost_s, told = _read(this.recording(), struck_ns)
    return Outcome(float("inf") if zero_ms is None else zero_ms, lost_s, fault.cause in said + told)


def _read(path: Path, struck_ns: int) -> tuple[float, str]:
    """How much of the recording is missing before the fault, s, and what it tells from then on."""
    try:
        with Recording(path) as recording:
            until_ns = struck_ns - int(recording.origins["monotonic_ns"][0])
            last_ns = int(recording.signal("safety.stimulation").times_ns.max(initial=0))
            told = " ".join(f"{event.status}: {event.detail}" for event in recording.events
                            if event.time_ns >= until_ns)
    except (FesloopError, IndexError):
        return float("inf"), ""
    return max(0, until_ns - last_ns) / NS_PER_S, told


def _row(fault: Fault, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    micros = 1e3 * np.array([outcome.zero_ms for outcome in outcomes])
    kept_ms, alone_ms = _stated_ms(fault)
    stated = 1e3 * ((alone_ms if fault.alone else kept_ms) + fault.added_ms)
    count = len(outcomes)
    return {"case": fault.name, "us_median": float(np.median(micros)),
            "us_p99": float(np.percentile(micros, 99)), "us_worst": float(micros.max()),
            "reference": "stated time", "reference_us_median": stated, "ratio": float(micros.max()) / stated,
            "count": count,
            "stated_held": f"{int((micros <= stated).sum())} of {count}",
            "recording_readable": f"{sum(np.isfinite(outcome.lost_s) for outcome in outcomes)} of {count}",
            "lost_s": float(max(outcome.lost_s for outcome in outcomes)), "cause": fault.cause,
            "cause_named": f"{sum(outcome.named for outcome in outcomes)} of {count}"}


def _stated_ms(fault: Fault) -> tuple[float, float]:
    """What the device states: zero current by the keeper, and by the device alone."""
    experiment = load(EXPERIMENT, [f"driver={fault.driver}", "port=/dev/null", *fault.settings])
    device: Any = experiment.wiring.node("device").part
    kept_ms, alone_ms = device.stated_ms
    return kept_ms, alone_ms

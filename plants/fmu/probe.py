"""Trying an FMU out in a process of its own, so that one that crashes takes nothing with it.

The child instantiates, initialises and steps the FMU, looks whether its outputs are stale and whether a
saved state really replays, and writes down how far it has come; the parent tells a crash from a refusal.
"""

from __future__ import annotations

import json
import math
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from plants.fmu.running import FmuSetup, RunningFmu

STEPS = 2000
STEPS_WALL_S = 2.0
REPLAY_STEPS = 20
PLATEAUS = 3
"""Chosen: how far a probe goes, and how many equal plateaus of an output are taken for a fixed step."""


@dataclass(frozen=True, slots=True)
class Probed:
    """What a probe found out.

    Attributes
    ----------
    internal_step_s: the FMU's own fixed step where its outputs were stale, else 0.
    replays: whether a saved and restored state gave identical outputs.
    why_not: why not, "" if it does.
    """

    internal_step_s: float = 0.0
    replays: bool = False
    why_not: str = ""


def probe(setup: FmuSetup, folder: Path, path: Path, timeout_s: float) -> Probed:
    """Try the FMU out.

    Raises InputError if it crashes, refuses, or takes longer than `timeout_s` before it can be stepped.
    """
    with tempfile.TemporaryDirectory(prefix="fesloop-probe-") as name:
        journal = Path(name) / "journal"
        journal.touch()
        command = [sys.executable, "-c", "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
                   "from plants.fmu.probe import main; main()", json.dumps(sys.path), str(journal)]
        try:
            done = subprocess.run(command, input=pickle.dumps((setup, folder)), stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, timeout=timeout_s, check=False)
            code = done.returncode
            last_words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        except subprocess.TimeoutExpired:
            code, last_words = None, []
        entries = [json.loads(line) for line in journal.read_text().splitlines()]
    found = {key: value for entry in entries for key, value in entry.items()}
    if "refused" in found:
        raise InputError("path", f"{path}: {found['refused']}", "an FMU that can be initialised",
                         "check its start values")
    if "probed" in found:
        return Probed(**found["probed"])
    stage = found.get("stage", "loading")
    if stage == "trial":
        ended = "was not done" if code is None else f"ended, {_ending(code, last_words)},"
        return Probed(why_not=f"the FMU {ended} when it was tried out at load with made-up inputs")
    if code is None:
        raise InputError("path", f"{path} did not finish {stage} within {timeout_s:g} s",
                         remedy="give it longer with probe_timeout_s, or do not use it")
    raise InputError("path", f"{path} crashed in {stage}: {_ending(code, last_words)}", "an FMU that runs",
                     "have the FMU's maker mend it")


def _ending(code: int, last_words: list[str]) -> str:
    """How a process ended, in words."""
    if code < 0:
        try:
            return f"killed by {signal.Signals(-code).name}"
        except ValueError:
            return f"killed by signal {-code}"
    return f"exit code {code}" + (f", {last_words[0]}" if last_words else "")


def main() -> None:
    """The child: setup on standard input, journal in the second argument."""
    setup, folder = pickle.loads(sys.stdin.buffer.read())
    with Path(sys.argv[2]).open("a", buffering=1) as journal:

        def note(**entry: object) -> None:
            journal.write(json.dumps(entry) + "\n")

        try:
            note(stage="initialisation")
            running = RunningFmu(setup, folder, "probe")
            note(stage="its first step")
            running.step(False)
        except RunError as fault:
            note(refused=str(fault).removeprefix("probe: "))
            return
        note(stage="trial")
        note(probed=_tried(setup, folder, running))


def _tried(setup: FmuSetup, folder: Path, running: RunningFmu) -> dict[str, object]:
    """What `Probed` says, of an FMU that has done its first step."""
    internal_step_s = 0.0
    if setup.description.interface == "co_simulation":
        internal_step_s = setup.description.internal_step_s
        if internal_step_s <= setup.period_s * (1 + 1e-9):
            internal_step_s = _internal_step(setup, running)
    running.end()
    if not setup.description.saves:
        why_not = "the FMU does not offer it"
    elif setup.description.once:
        why_not = "the FMU can be instantiated only once in a process"
    else:
        why_not = _why_no_replay(setup, folder)
    return {"internal_step_s": internal_step_s, "replays": not why_not, "why_not": why_not}


def _internal_step(setup: FmuSetup, running: RunningFmu) -> float:
    """The FMU's fixed internal step in s if it is longer than a communication step, else 0.

    Either the FMU says itself that it fell short, or its continuous outputs move on every m-th step only,
    each time to values not seen before (a square wave comes back to them). An FMU that does not move at all
    tells nothing; it is given inputs for the second half.
    """
    moving = np.concatenate([np.full(v.size, v.variability == "continuous")
                             for bound in setup.outputs for v in bound.variables] or [np.zeros(0, bool)])
    changes: list[int] = []
    seen: set[bytes] = set()
    before, shortfalls, began = running.outputs.values.copy(), 0, time.perf_counter()
    for step in range(STEPS):
        if step == STEPS // 2:
            if changes:
                break
            _excite(setup, running)
        try:
            running.step(step == STEPS // 2)
        except RunError:
            break
        shortfalls += running.shortfall_s() > 0.0
        if (running.outputs.values != before)[moving].any():
            if changes and step - changes[-1] == 1:
                return 0.0 if not shortfalls else _estimate(setup, changes, running)
            changes.append(step)
            before = running.outputs.values.copy()
            seen.add(before[moving].tobytes())
        if len(changes) > 10 * PLATEAUS or time.perf_counter() - began > STEPS_WALL_S:
            break
    gaps = np.diff(changes)
    staircase = gaps.size >= PLATEAUS and gaps.max() - gaps.min() <= 1 and len(seen) == len(changes)
    if shortfalls or staircase:
        return _estimate(setup, changes, running)
    return 0.0


def _estimate(setup: FmuSetup, changes: list[int], running: RunningFmu) -> float:
    """Length of the internal step from the instants of change, or from what the FMU says it reached."""
    gaps = np.diff(changes)
    if gaps.size:
        return float(gaps.mean()) * setup.period_s
    return setup.period_s + running.shortfall_s()


def _excite(setup: FmuSetup, running: RunningFmu) -> None:
    """Move every input away from its start value: by one, or by the start value itself."""
    values: NDArray[np.float64] = running.inputs.values
    values += np.where(values == 0.0, 1.0, values)


def _why_no_replay(setup: FmuSetup, folder: Path) -> str:
    """Why a saved state does not give the same future in a new instance; "" if it does."""
    first, second = RunningFmu(setup, folder, "probe"), RunningFmu(setup, folder, "probe_again")
    try:
        _excite(setup, first)
        for step in range(REPLAY_STEPS):
            first.step(step == 0)
        saved = first.save()
        _excite(setup, first)
        future = _future(first)
        second.restore(saved)
        _excite(setup, second)
        if not np.array_equal(_future(second), future, equal_nan=True):
            return "a restored state did not give the same outputs when it was tried at load"
        if (future == future[0]).all():
            return "no output moved when it was tried at load, so nothing shows that it replays"
    except RunError as fault:
        return str(fault).removeprefix("probe: ").removeprefix("probe_again: ")
    finally:
        first.end()
        second.end()
    return ""


def _future(running: RunningFmu) -> NDArray[np.float64]:
    """Outputs of the steps to come, (steps, elements)."""
    rows = []
    for step in range(max(REPLAY_STEPS, math.ceil(0.1 / running.setup.period_s))):
        running.step(step == 0)
        rows.append(running.outputs.values.copy())
    return np.array(rows)

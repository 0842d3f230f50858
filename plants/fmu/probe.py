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
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from plants.fmu.internal_step import excite, find_by_finer_steps, find_internal_step
from plants.fmu.running import FmuSetup, RunningFmu

REPLAY_STEPS = 20
"""Chosen: how far a saved state is followed, 0.1 s at least."""


@dataclass(frozen=True, slots=True)
class Probed:
    """What a probe found out.

    Attributes
    ----------
    internal_step_s: the FMU's own fixed step, 0 where none was seen.
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
    stepped = setup.description.interface == "co_simulation"
    internal_step_s = find_internal_step(setup, running) if stepped else 0.0
    running.end()
    if not setup.description.saves:
        why_not = "the FMU does not offer it"
    elif setup.description.once:
        why_not = "the FMU can be instantiated only once in a process"
    else:
        why_not = _why_no_replay(setup, folder)
    if stepped and not internal_step_s and not setup.description.once:
        internal_step_s = find_by_finer_steps(setup, folder)
    return {"internal_step_s": internal_step_s, "replays": not why_not, "why_not": why_not}


def _why_no_replay(setup: FmuSetup, folder: Path) -> str:
    """Why a saved state does not give the same future in a new instance; "" if it does."""
    first, second = RunningFmu(setup, folder, "probe"), RunningFmu(setup, folder, "probe_again")
    try:
        excite(setup, first)
        for step in range(REPLAY_STEPS):
            first.step(step == 0)
        saved = first.save()
        excite(setup, first)
        future = _future(first)
        second.restore(saved)
        excite(setup, second)
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

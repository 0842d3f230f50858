"""What an FMU does when it is tried out: whether its outputs are stale, and whether a saved state replays."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from plants.fmu.internal_step import InternalStep, excite, find_by_finer_steps, find_internal_step
from plants.fmu.running import FmuSetup, RunningFmu

COARSE_S, COARSE_WALL_S, ROUNDED = 1.0, 2.0, 1e-9
"""Chosen: how far substeps are compared with shorter ones, how long that may take, and the part of an output
that differs by rounding."""
REPLAY_STEPS = 20
"""Chosen: how far a saved state is followed, 0.1 s at least."""


def tried(setup: FmuSetup, folder: Path, running: RunningFmu) -> dict[str, object]:
    """Fields of `Probed`, of an FMU that has done its first step; it is ended."""
    stepped = setup.description.interface == "co_simulation"
    internal = find_internal_step(setup, running) if stepped else InternalStep()
    tells = bool(running.reached_s())  # one that leaves it at 0 says nothing
    running.end()
    if not setup.description.saves:
        why_not = "the FMU does not offer it"
    elif setup.description.once:
        why_not = "the FMU can be instantiated only once in a process"
    else:
        why_not = _why_no_replay(setup, folder)
    coarse = 0.0 if stepped or setup.description.once else _coarse(setup, folder)
    return {"internal": internal, "coarse": coarse, "tells": tells, "replays": not why_not,
            "why_not": why_not}


def tried_finer(setup: FmuSetup, folder: Path) -> dict[str, object]:
    """The internal step by finer communication steps, which are not without risk."""
    if setup.description.interface != "co_simulation" or setup.description.once:
        return {}
    return {"internal": find_by_finer_steps(setup, folder)}


def _coarse(setup: FmuSetup, folder: Path) -> float:
    """How far outputs differ with substeps half as long, as part of what they move; 0 where one refuses.

    The largest of all elements, 1 at most, which it is, too, where integration diverges to no number.
    """
    pair: list[RunningFmu] = []
    rows, began = [], time.perf_counter()
    try:
        pair = [RunningFmu(setup, folder, "probe")]
        pair.append(RunningFmu(replace(setup, substeps=2 * setup.substeps), folder, "probe_finer"))
        for step in range(max(REPLAY_STEPS, math.ceil(COARSE_S / setup.period_s))):
            for running in pair:
                if step == 1:
                    excite(setup, running)
                running.step(step == 1)
            rows.append([running.outputs.values.copy() for running in pair])
            if time.perf_counter() - began > COARSE_WALL_S:
                break
    except RunError:
        return 0.0
    finally:
        for running in pair:
            running.end()
    with np.errstate(all="ignore"):
        coarse, fine = np.array(rows).swapaxes(0, 1)
        apart = np.abs(coarse - fine).max(axis=0)
        moved = np.maximum(np.ptp(coarse, axis=0), np.ptp(fine, axis=0))
        worst = np.where(apart > ROUNDED * np.abs(fine).max(axis=0), apart / moved, 0.0)
    finite = np.isfinite(fine).all(axis=0)  # an output that is no number with any step is reported elsewhere
    worst = np.where(np.isfinite(coarse).all(axis=0), worst, 1.0)[finite | np.isfinite(coarse).all(axis=0)]
    return float(min(1.0, np.nan_to_num(worst, nan=1.0).max(initial=0.0)))


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

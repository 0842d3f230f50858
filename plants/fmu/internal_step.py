"""An FMU's fixed internal step: found by stepping the FMU, and compared with the communication step.

Outputs are those of a communication point only where the communication step is a whole multiple of the
internal one. An FMU that counts in decimal digits or whole ns has no step of exactly 1/60 s: steps that
differ by 1 ns or less are taken as equal, and the FMU is then stepped by its own.
"""

from __future__ import annotations

import time
from dataclasses import replace
from decimal import ROUND_FLOOR, Context, Decimal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.loop.clock import RateClock
from plants.fmu.running import FmuSetup, RunningFmu

RESOLUTION_S, EXACT_S = 1e-9, 1e-12
"""Within which steps are equal (of steps longer than 1 s, the same part), and beyond which that is seen."""
STEPS = 2000
STEPS_WALL_S = 2.0
PLATEAUS = 3
ENOUGH = 30
FINER = 16
"""Chosen: how far an FMU is tried out, how many equal plateaus of an output are taken for a fixed step, after
how many changes an output is taken to move at will, and how much finer than the communication step it is
looked for."""


def fits(period_s: float, internal_s: float) -> bool:
    """Whether a communication step is a whole multiple of an internal step; True where that is 0, unknown."""
    if internal_s == 0.0:
        return True
    multiple = max(1, round(period_s / internal_s))
    return abs(period_s / multiple - internal_s) <= RESOLUTION_S * max(1.0, period_s)


def stepped_alike(setup: FmuSetup, internal_s: float) -> FmuSetup:
    """The setup with communication steps that are whole multiples of an internal step that fits, exactly."""
    if internal_s == 0.0:
        return setup
    step_s = max(1, round(setup.period_s / internal_s)) * internal_s
    return setup if abs(step_s - setup.period_s) <= EXACT_S else replace(setup, own_step_s=step_s)


def misfit(period_s: float, internal_s: float, silent: bool = False) -> InputError:
    """The refusal of a communication step that does not fit, with a rate that does.

    `silent`: the FMU says nothing of its internal step, and `internal_s` is the longest that it can be.
    """
    step, internal = _told_apart(1e3 * period_s, 1e3 * internal_s)
    if silent:
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, about "
            f"{internal} ms: outputs would be stale", f"at most about {_rate_below(internal_s)} Hz",
            "prefer the rate that the FMU's maker gives: this one is an estimate from outputs")
    rate = _rate_of(internal_s)
    if internal_s > period_s:
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, "
            f"{internal} ms: outputs would be stale", f"at most {rate} Hz")
    return InputError(
        "step_rate", f"the communication step, {step} ms, is no whole multiple of the FMU's internal step, "
        f"{internal} ms: outputs would be up to so much old", f"{rate} Hz, or that over a whole number")


def _told_apart(one: float, other: float) -> tuple[str, str]:
    """Two numbers in as many digits as it takes to see that they differ, six at least."""
    pairs = ((f"{one:.{digits}g}", f"{other:.{digits}g}") for digits in range(6, 18))
    return next((pair for pair in pairs if pair[0] != pair[1]), (repr(one), repr(other)))


def _rate_of(internal_s: float) -> str:
    """The shortest text of a rate in Hz whose period is the internal step, of six digits at least."""
    texts = [f"{1.0 / internal_s:.{digits}g}" for digits in range(6, 18)]
    return next((text for text in texts if fits(RateClock.from_rate(text).period_s, internal_s)), texts[-1])


def _rate_below(internal_s: float) -> str:
    """The shortest text of a rate in Hz whose period is an internal step to 1e-12 s, never shorter."""
    exact = Decimal(1) / Decimal(internal_s) * (1 + Decimal("1e-13"))  # 200 Hz, not 199.999..., for 0.005
    texts = [f"{Context(prec=digits, rounding=ROUND_FLOOR).create_decimal(exact).normalize():f}"
             for digits in range(1, 18)]
    near = (text for text in texts if abs(RateClock.from_rate(text).period_s - internal_s) <= EXACT_S)
    return next(near, texts[-1])


def find_internal_step(setup: FmuSetup, running: RunningFmu) -> float:
    """The internal step of a co-simulation FMU in s, 0 where nothing shows that there is one.

    A declared one is believed where the communication step does not fit it because it is shorter. Else the
    FMU is stepped as in a run.
    """
    declared_s = setup.description.internal_step_s
    if declared_s > setup.period_s and not fits(setup.period_s, declared_s):
        return declared_s
    return _observed(running, setup.period_s)


def find_by_finer_steps(setup: FmuSetup, folder: Path) -> float:
    """The same, by finer steps than those of a run, which not every FMU can do; 0 where it cannot.

    So shows an internal step that is longer than the communication step, but less than twice as long.
    """
    finer = replace(setup, own_step_s=0.0, period_den=FINER * setup.period_den)
    try:
        running = RunningFmu(finer, folder, "probe")
    except RunError:
        return 0.0
    try:
        return _observed(running, setup.period_s)
    finally:
        running.end()


def _observed(running: RunningFmu, period_s: float) -> float:
    """The internal step by what the FMU says or, if it is silent and it is longer than `period_s`, does.

    It says which instant it has reached; or its continuous outputs move on every m-th step only, each time to
    values not seen before (a square wave comes back to them). An FMU that does not move at all is given
    inputs for the second half.
    """
    setup = running.setup
    moving = np.concatenate([np.full(v.size, v.variability == "continuous")
                             for bound in setup.outputs for v in bound.variables] or [np.zeros(0, bool)])
    changes: list[int] = []
    reached = [instant_s for instant_s in [running.reached_s()] if instant_s is not None]
    seen: set[bytes] = set()
    adjacent, before, began = False, running.outputs.values.copy(), time.perf_counter()
    for step in range(STEPS):
        excited = step == STEPS // 2 and not changes
        if excited:
            excite(setup, running)
        try:
            running.step(excited)
        except RunError:
            break
        instant_s = running.reached_s()
        if instant_s is not None and instant_s not in reached[-1:]:
            reached.append(instant_s)
        if (running.outputs.values != before)[moving].any():
            adjacent = adjacent or (bool(changes) and running.tick - changes[-1] == 1)
            changes.append(running.tick)
            before = running.outputs.values.copy()
            seen.add(before[moving].tobytes())
        if (adjacent and len(changes) > ENOUGH) or time.perf_counter() - began > STEPS_WALL_S:
            break
    if len(reached) > 1:
        return _told_step(np.diff(reached), period_s)
    return 0.0 if len(seen) < len(changes) else _plateau(np.array(changes), setup.period_s, period_s)


def _told_step(lengths: NDArray[np.float64], period_s: float) -> float:
    """The internal step by how far an FMU says that it went: whole multiples of it, which differ by one.

    0 where `period_s` fits that and the lengths are not equal, but rounded.
    """
    longest, shortest = float(lengths.max()), float(lengths.min())
    if longest - shortest <= EXACT_S:
        return float(lengths.mean())
    unequal_s = shortest if longest - shortest <= RESOLUTION_S * max(1.0, longest) else longest - shortest
    return 0.0 if fits(period_s, unequal_s) else unequal_s


def _plateau(changes: NDArray[np.int64], step_s: float, period_s: float) -> float:
    """The longest internal step, in s, that explains equal gaps between changes; 0 where they are not
    certainly longer than `period_s`.

    `changes` are communication points of distance `step_s`, counted from the start. Internal steps are
    counted from there, too: the k-th shows at the first communication point that is not before it. Where
    that explains the changes badly, their distances count alone, each end uncertain by a communication step.
    """
    gaps = np.diff(changes)
    if gaps.size < PLATEAUS or gaps.min() == 1 or np.ptp(gaps) > 1:
        return 0.0
    if (gaps.sum() - 1) / gaps.size * step_s <= period_s + RESOLUTION_S:
        return 0.0
    numbers = max(1, round(changes[0] / gaps.mean())) + np.arange(changes.size)
    longest = (changes / numbers).min()
    if longest <= ((changes - 1) / numbers).max():
        longest = (gaps.sum() + 1) / gaps.size
    return float(longest * step_s)


def excite(setup: FmuSetup, running: RunningFmu) -> None:
    """Move every input away from its start value: by one, or by the start value itself."""
    values: NDArray[np.float64] = running.inputs.values
    values += np.where(values == 0.0, 1.0, values)

"""An FMU's fixed internal step: found by stepping the FMU, and compared with the communication step.

Outputs are those of a communication point only where the communication step is a whole multiple of the
internal one. An FMU that counts in decimal digits or whole ns has no step of exactly 1/60 s: steps that
differ by 1 ns or less are taken as equal, and the FMU is then stepped by its own.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from decimal import ROUND_FLOOR, Context, Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.loop.clock import RateClock
from plants.fmu.ports import limits
from plants.fmu.running import FmuSetup, RunningFmu

RESOLUTION_S, EXACT_S = 1e-9, 1e-12
"""Within which steps are equal (of steps longer than 1 s, the same part), and beyond which that is seen."""
STEPS = 2000
STEPS_WALL_S = 2.0
PLATEAUS = 3
ENOUGH = 30
FINER = 16
ROUNDINGS = 16
"""Chosen: how far an FMU is tried out, how many equal plateaus of an output are taken for a fixed step, how
many steps it takes at least, how much finer than the communication step is looked for, and how many times its
resolution an output moves that does not just drift by rounding."""


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


def misfit(period_s: float, internal: InternalStep) -> InputError:
    """The refusal of a communication step that does not fit, with a rate that does."""
    internal_s, outputs, *_ = internal
    step, shown = _told_apart(1e3 * period_s, 1e3 * internal_s)
    if outputs:
        names = ", ".join(map(repr, outputs[:3])) + (f" and {len(outputs) - 3} more" if outputs[3:] else "")
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, about "
            f"{shown} ms: {names} would be stale", f"at most about {_rate_below(internal_s)} Hz",
            "prefer the rate that the FMU's maker gives: this one is an estimate from outputs; or set "
            "sampled = true in an output port whose values are meant to hold")
    rate = _rate_of(internal_s)
    if internal_s > period_s:
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, "
            f"{shown} ms: outputs would be stale", f"at most {rate} Hz")
    return InputError(
        "step_rate", f"the communication step, {step} ms, is no whole multiple of the FMU's internal step, "
        f"{shown} ms: outputs would be up to so much old", f"{rate} Hz, or that over a whole number")


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


class InternalStep(NamedTuple):
    """An internal step.

    Attributes
    ----------
    length_s: 0 where nothing shows that there is one; the longest that it can be if it shows in outputs.
    outputs: names of the outputs that alone show it, as they hold still between its steps.
    unchecked: names of the continuous outputs that show neither that there is one, nor that there is none.
    why: why they do not.
    """

    length_s: float = 0.0
    outputs: tuple[str, ...] = ()
    unchecked: tuple[str, ...] = ()
    why: str = ""


def find_internal_step(setup: FmuSetup, running: RunningFmu) -> InternalStep:
    """The internal step of a co-simulation FMU.

    A declared one is believed where the communication step does not fit it. Else the FMU is stepped as in a
    run.
    """
    declared_s = setup.description.internal_step_s
    if not fits(setup.period_s, declared_s):
        return InternalStep(declared_s)
    found = _observed(running, setup.period_s)
    return found._replace(unchecked=(), why="") if declared_s else found


def find_by_finer_steps(setup: FmuSetup, folder: Path) -> InternalStep:
    """The same, by finer steps than those of a run, which not every FMU can do.

    So shows an internal step that is longer than the communication step, but less than twice as long.
    """
    finer = replace(setup, own_step_s=0.0, period_den=FINER * setup.period_den)
    try:
        running = RunningFmu(finer, folder, "probe")
    except RunError:
        return InternalStep()
    try:
        return _observed(running, setup.period_s)
    finally:
        running.end()


def _observed(running: RunningFmu, period_s: float) -> InternalStep:
    """The internal step by what the FMU says or, if that fits `period_s`, by what its outputs do.

    It says which instant it has reached; or an output moves on every m-th step only, each time to a value
    not seen before (a square wave comes back to them). Each continuous output is looked at by itself: one
    that moves at every step says nothing of the others. If any does not move at all, inputs are moved for the
    second half, and those that had moved before count no further.
    """
    setup = running.setup
    watched, outputs = _watched(setup)
    before = running.outputs.values[watched]
    reached = [instant_s for instant_s in [running.reached_s()] if instant_s is not None]
    why = "they did not move as it takes, when the FMU was tried out"
    open_, began = set(range(len(outputs))), time.perf_counter()
    for step in range(STEPS):
        excited = step == STEPS // 2
        if excited:
            open_ = {i for i in open_ if not outputs[i].changes}
            if not fits(period_s, _shown(reached, outputs, setup.period_s, period_s).length_s):
                break
            excite(setup, running)
        try:
            running.step(excited)
        except RunError as fault:
            why = f"tried out, it ended early: {str(fault).removeprefix('probe: ')}"
            break
        instant_s = running.reached_s()
        if instant_s is not None and instant_s not in reached[-1:]:
            reached.append(instant_s)
        now = running.outputs.values[watched]
        if not excited:  # what follows an input at once does so between its steps, too
            moved = (now != before) & ~(np.isnan(now) & np.isnan(before))
            for i in open_.intersection(np.flatnonzero(moved).tolist()):
                if not outputs[i].move(running.tick, float(before[i]), float(now[i])):
                    open_.remove(i)
        before = now
        if not open_ and step >= ENOUGH:
            break
        if time.perf_counter() - began > STEPS_WALL_S:
            why = f"{step + 1} steps took the {STEPS_WALL_S:g} s in which it is tried out"
            break
    found = _shown(reached, outputs, setup.period_s, period_s)
    unchecked = tuple(dict.fromkeys(output.name for output in outputs if not output.moves_always))
    return found._replace(unchecked=unchecked, why=why) if unchecked else found


class _Output:
    """One element of the outputs: the communication points at which it moved.

    `rounding`: part of its value that its type resolves, nearly.
    """

    __slots__ = ("_adjacent", "_furthest", "_rounding", "_seen", "changes", "name")

    def __init__(self, name: str, rounding: float) -> None:
        self.name, self._rounding = name, rounding
        self.changes: list[int] = []
        self._seen: set[float] = set()
        self._furthest, self._adjacent = 0.0, False

    @property
    def moves_always(self) -> bool:
        """Whether it was seen to move from one step to the next, by more than rounding."""
        return self._adjacent and self._furthest > self._rounding

    def move(self, tick: int, before: float, now: float) -> bool:
        """Note a change; whether an internal step may still show, as it was not at the point before, too."""
        adjacent = self.changes[-1:] == [tick - 1]
        self.changes.append(tick)
        self._seen.add(now)
        size = max(abs(now), abs(before))
        if size > 0.0:
            self._furthest = max(self._furthest, abs(now - before) / size)
        self._adjacent = self._adjacent or adjacent
        return not adjacent

    def plateau(self, step_s: float, period_s: float) -> float:
        """The internal step in s, 0 where none shows: see `_plateau`."""
        if len(self._seen) < len(self.changes) or self._furthest <= self._rounding:
            return 0.0
        return _plateau(np.array(self.changes), step_s, period_s)


def continuous(setup: FmuSetup) -> tuple[str, ...]:
    """Names of the outputs that can be stale; none in model exchange, which integrates here."""
    if setup.description.interface == "model_exchange":
        return ()
    return tuple(dict.fromkeys(output.name for output in _watched(setup)[1]))


def _watched(setup: FmuSetup) -> tuple[NDArray[np.intp], list[_Output]]:
    """Places of the continuous outputs among all, and these."""
    places: list[int] = []
    outputs: list[_Output] = []
    place = 0
    for bound in setup.outputs:
        for variable in bound.variables:
            if variable.variability == "continuous" and not bound.sampled:
                kind = np.float32 if variable.type == "Float32" else np.float64
                rounding = ROUNDINGS * float(np.finfo(kind).eps)
                places += range(place, place + variable.size)
                outputs += [_Output(variable.name, rounding) for _ in range(variable.size)]
            place += variable.size
    return np.array(places, dtype=np.intp), outputs


def _shown(reached: list[float], outputs: list[_Output], step_s: float, period_s: float) -> InternalStep:
    """The internal step by the instants reached or, if that fits, by the outputs."""
    told_s = _told_step(np.diff(reached), period_s) if len(reached) > 1 else 0.0
    if fits(period_s, told_s):
        held = [(output.plateau(step_s, period_s), output.name) for output in outputs]
        longest_s = max((length_s for length_s, _ in held), default=0.0)
        if longest_s:
            return InternalStep(longest_s, tuple(dict.fromkeys(name for length_s, name in held if length_s)))
    return InternalStep(told_s)


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
    about = changes[0] / gaps.mean()
    explaining = []
    for first in {max(1, math.floor(about)), max(1, math.ceil(about))}:
        numbers = first + np.arange(changes.size)
        longest = (changes / numbers).min()
        if longest > ((changes - 1) / numbers).max():
            explaining.append(longest)
    return float(max(explaining, default=(gaps.sum() + 1) / gaps.size) * step_s)


def excite(setup: FmuSetup, running: RunningFmu) -> None:
    """Move every input away from its start value: by one, or by the start value itself.

    Never beyond its min and max: up to these, or the other way where it is at one of them.
    """
    values: NDArray[np.float64] = running.inputs.values
    by = np.where(values == 0.0, 1.0, values)
    low, high = limits(setup.inputs)
    there = np.clip(values + by, low, high)
    values[:] = np.where(there == values, np.clip(values - by, low, high), there)

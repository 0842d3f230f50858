"""Trial steps of an FMU before a run: its fixed internal step, whether it replays, and too long substeps.

Outputs belong to a communication point only if the communication step is a whole multiple of the internal
step. An FMU that counts in decimal digits or whole ns has no step of exactly 1/60 s: steps that differ by
1 ns or less count as equal, and the FMU is then stepped by its own step.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
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
"""Difference up to which steps count as equal (relative for steps longer than 1 s), and up to which they are
exactly equal."""
STEPS = 2000
STEPS_WALL_S = 2.0
PLATEAUS = 3
ENOUGH = 30
FINER = 16
ROUNDINGS = 16
"""Chosen: greatest number and time of trial steps; number of equal plateaus of an output that show a fixed
step; least number of trial steps; ratio of the finer steps; and number of resolutions by which an output
moves that does not merely drift by rounding."""


def fits(period_s: float, internal_s: float) -> bool:
    """Whether a communication step is a whole multiple of an internal step; True if that is 0, unknown."""
    if internal_s == 0.0:
        return True
    multiple = max(1, round(period_s / internal_s))
    return abs(period_s / multiple - internal_s) <= RESOLUTION_S * max(1.0, period_s)


def stepped_alike(setup: FmuSetup, internal_s: float) -> FmuSetup:
    """The setup with communication steps that are exact multiples of an internal step that fits."""
    if internal_s == 0.0:
        return setup
    step_s = max(1, round(setup.period_s / internal_s)) * internal_s
    return setup if abs(step_s - setup.period_s) <= EXACT_S else replace(setup, own_step_s=step_s)


def misfit(period_s: float, internal: InternalStep) -> InputError:
    """Error for a communication step that does not fit, with a rate that does."""
    internal_s, outputs = internal.length_s, internal.outputs
    step, shown = _distinct_texts(1e3 * period_s, 1e3 * internal_s)
    if outputs:
        names = ", ".join(map(repr, outputs[:3])) + (f" and {len(outputs) - 3} more" if outputs[3:] else "")
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, about "
            f"{shown} ms: {names} would be stale", f"at most about {_rate_below(internal_s)} Hz",
            "prefer the rate that the FMU's maker gives, as this one is an estimate from outputs; or set "
            "sampled = true in an output port whose values are sampled")
    rate = _rate_of(internal_s)
    if internal_s > period_s:
        return InputError(
            "step_rate", f"the communication step, {step} ms, is shorter than the FMU's internal step, "
            f"{shown} ms: outputs would be stale", f"at most {rate} Hz")
    return InputError(
        "step_rate", f"the communication step, {step} ms, is no whole multiple of the FMU's internal step, "
        f"{shown} ms: outputs would be up to that much old", f"{rate} Hz, or that over a whole number")


def _distinct_texts(one: float, other: float) -> tuple[str, str]:
    """Two numbers with enough digits to differ, six at least."""
    pairs = ((f"{one:.{digits}g}", f"{other:.{digits}g}") for digits in range(6, 18))
    return next((pair for pair in pairs if pair[0] != pair[1]), (repr(one), repr(other)))


def _rate_of(internal_s: float) -> str:
    """Shortest text of a rate in Hz whose period is the internal step, six digits at least."""
    texts = [f"{1.0 / internal_s:.{digits}g}" for digits in range(6, 18)]
    return next((text for text in texts if fits(RateClock.from_rate(text).period_s, internal_s)), texts[-1])


def _rate_below(internal_s: float) -> str:
    """Shortest text of a rate in Hz whose period is the internal step to 1e-12 s, never shorter."""
    exact = Decimal(1) / Decimal(internal_s) * (1 + Decimal("1e-13"))  # 200 Hz, not 199.999..., for 0.005
    texts = [f"{Context(prec=digits, rounding=ROUND_FLOOR).create_decimal(exact).normalize():f}"
             for digits in range(1, 18)]
    near = (text for text in texts if abs(RateClock.from_rate(text).period_s - internal_s) <= EXACT_S)
    return next(near, texts[-1])


class InternalStep(NamedTuple):
    """An FMU's fixed internal step, as far as trial steps show it.

    Attributes
    ----------
    length_s: length; 0 if none shows; the greatest possible one if it shows in outputs alone.
    outputs: names of the outputs that show it by holding between its steps, if nothing else does.
    unchecked: names of continuous outputs that show neither a step nor its absence.
    why: reason for that.
    """

    length_s: float = 0.0
    outputs: tuple[str, ...] = ()
    unchecked: tuple[str, ...] = ()
    why: str = ""


def find_internal_step(setup: FmuSetup, running: RunningFmu) -> InternalStep:
    """Find the internal step of a co-simulation FMU.

    A declared step that the communication step does not fit is taken as it is. Otherwise the FMU is stepped
    as in a run.
    """
    declared_s = setup.description.internal_step_s
    if not fits(setup.period_s, declared_s):
        return InternalStep(declared_s)
    found = _observed(running, setup.period_s)
    return found._replace(unchecked=(), why="") if declared_s else found


def find_by_finer_steps(setup: FmuSetup, folder: Path) -> InternalStep:
    """Find the internal step by finer steps than those of a run, which not every FMU supports.

    They show an internal step between one and two communication steps.
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
    """Find the internal step from the times the FMU reports or, if these fit `period_s`, from its outputs.

    An output shows an internal step if it moves on every m-th step only, each time to a new value (a square
    wave returns to old ones). Each continuous output is judged by itself: one that moves at every step shows
    nothing about the others. If some output does not move at all, inputs are changed for the second half, in
    which outputs that moved before are ignored.
    """
    setup = running.setup
    watched, outputs = _watched(setup)
    before = running.outputs.values[watched]
    reached = [instant_s for instant_s in [running.reached_s()] if instant_s is not None]
    why = "they did not move enough in the trial at load"
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
            why = f"the trial ended early: {str(fault).removeprefix('probe: ')}"
            break
        instant_s = running.reached_s()
        if instant_s is not None and instant_s not in reached[-1:]:
            reached.append(instant_s)
        now = running.outputs.values[watched]
        if not excited:  # an output with feedthrough follows an input between internal steps, too
            moved = (now != before) & ~(np.isnan(now) & np.isnan(before))
            for i in open_.intersection(np.flatnonzero(moved).tolist()):
                if not outputs[i].move(running.tick, float(before[i]), float(now[i])):
                    open_.remove(i)
        before = now
        if not open_ and step >= ENOUGH:
            break
        if time.perf_counter() - began > STEPS_WALL_S:
            why = f"{step + 1} steps took all {STEPS_WALL_S:g} s of the trial at load"
            break
    found = _shown(reached, outputs, setup.period_s, period_s)
    unchecked = tuple(dict.fromkeys(output.name for output in outputs if not output.moves_always))
    return found._replace(unchecked=unchecked, why=why) if unchecked else found


class _Output:
    """Communication points at which one element of the outputs moved.

    `rounding`: relative change that is rounding of its type.
    """

    __slots__ = ("_adjacent", "_furthest", "_rounding", "_seen", "changes", "name")

    def __init__(self, name: str, rounding: float) -> None:
        self.name, self._rounding = name, rounding
        self.changes: list[int] = []
        self._seen: set[float] = set()
        self._furthest, self._adjacent = 0.0, False

    @property
    def moves_always(self) -> bool:
        """Whether it moved in two successive steps, by more than rounding."""
        return self._adjacent and self._furthest > self._rounding

    def move(self, tick: int, before: float, now: float) -> bool:
        """Note a change; False if it also changed one step before, which rules out an internal step."""
        adjacent = self.changes[-1:] == [tick - 1]
        self.changes.append(tick)
        self._seen.add(now)
        size = max(abs(now), abs(before))
        if size > 0.0:
            self._furthest = max(self._furthest, abs(now - before) / size)
        self._adjacent = self._adjacent or adjacent
        return not adjacent

    def plateau(self, step_s: float, period_s: float) -> float:
        """Internal step in s, 0 if none shows: see `_plateau`."""
        if len(self._seen) < len(self.changes) or self._furthest <= self._rounding:
            return 0.0
        return _plateau(np.array(self.changes), step_s, period_s)


def continuous(setup: FmuSetup) -> tuple[str, ...]:
    """Names of the outputs that can be stale; none in model exchange, where fesloop integrates."""
    if setup.description.interface == "model_exchange":
        return ()
    return tuple(dict.fromkeys(output.name for output in _watched(setup)[1]))


def _watched(setup: FmuSetup) -> tuple[NDArray[np.intp], list[_Output]]:
    """Indices of the continuous elements among all outputs, and a record for each."""
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
    """Internal step from the times reached or, if that fits, from the outputs."""
    reported_s = _reported_step(np.diff(reached), period_s) if len(reached) > 1 else 0.0
    if fits(period_s, reported_s):
        held = [(output.plateau(step_s, period_s), output.name) for output in outputs]
        longest_s = max((length_s for length_s, _ in held), default=0.0)
        if longest_s:
            return InternalStep(longest_s, tuple(dict.fromkeys(name for length_s, name in held if length_s)))
    return InternalStep(reported_s)


def _reported_step(lengths: NDArray[np.float64], period_s: float) -> float:
    """Internal step from reported step lengths, which are multiples of it that differ by one.

    0 if `period_s` fits it and the lengths differ by rounding.
    """
    longest, shortest = float(lengths.max()), float(lengths.min())
    if longest - shortest <= EXACT_S:
        return float(lengths.mean())
    unequal_s = shortest if longest - shortest <= RESOLUTION_S * max(1.0, longest) else longest - shortest
    return 0.0 if fits(period_s, unequal_s) else unequal_s


def _plateau(changes: NDArray[np.int64], step_s: float, period_s: float) -> float:
    """Longest internal step, s, that explains equal gaps between changes; 0 unless surely above `period_s`.

    `changes` are numbers of communication points `step_s` apart, counted from the start. Internal steps are
    counted from there, too: the k-th shows at the first communication point that is not before it. If that
    does not explain the changes, only their distances count, each end uncertain by a communication step.
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
    """Change every input from its start value: by one, or by the start value itself.

    The change ends at the input's min or max, or goes the other way if it starts there.
    """
    values: NDArray[np.float64] = running.inputs.values
    by = np.where(values == 0.0, 1.0, values)
    low, high = limits(setup.inputs)
    there = np.clip(values + by, low, high)
    values[:] = np.where(there == values, np.clip(values - by, low, high), there)


@dataclass(frozen=True, slots=True)
class Probed:
    """Results of trying out an FMU.

    Attributes
    ----------
    internal: the FMU's fixed internal step.
    reports_time: whether the FMU reports its last successful time.
    coarse: change of outputs with substeps half as long, relative to their movement (model exchange).
    replays: whether a saved and restored state gives identical outputs.
    why_not: reason why it does not, or "".
    """

    internal: InternalStep = field(default_factory=InternalStep)
    reports_time: bool = False
    coarse: float = 0.0
    replays: bool = False
    why_not: str = ""


COARSE_S, COARSE_WALL_S, ROUNDED = 1.0, 2.0, 1e-9
"""Chosen: simulated and wall time over which substeps are compared with shorter ones, and relative difference
of an output that is rounding."""
REPLAY_STEPS = 20
"""Chosen: number of steps after a restored state that are compared, 0.1 s at least."""


def try_out(setup: FmuSetup, folder: Path, running: RunningFmu) -> dict[str, object]:
    """Fields of `Probed` for an FMU that has done its first step; ends the FMU."""
    stepped = setup.description.interface == "co_simulation"
    internal = find_internal_step(setup, running) if stepped else InternalStep()
    reports_time = bool(running.reached_s())  # an FMU that leaves it at 0 reports nothing
    running.end()
    if not setup.description.saves:
        why_not = "the FMU does not offer it"
    elif setup.description.once:
        why_not = "the FMU can be instantiated only once in a process"
    else:
        why_not = _why_no_replay(setup, folder)
    coarse = 0.0 if stepped or setup.description.once else _coarse(setup, folder)
    return {"internal": internal, "coarse": coarse, "reports_time": reports_time, "replays": not why_not,
            "why_not": why_not}


def try_finer_steps(setup: FmuSetup, folder: Path) -> dict[str, object]:
    """Find the internal step by finer communication steps, which may crash some FMUs."""
    if setup.description.interface != "co_simulation" or setup.description.once:
        return {}
    return {"internal": find_by_finer_steps(setup, folder)}


def _coarse(setup: FmuSetup, folder: Path) -> float:
    """Difference of outputs with substeps half as long, relative to their movement; 0 if the FMU refuses.

    The largest of all elements, at most 1; it is 1 if integration diverges to NaN or infinity.
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
    finite = np.isfinite(fine).all(axis=0)  # outputs that are not finite with either step are reported later
    worst = np.where(np.isfinite(coarse).all(axis=0), worst, 1.0)[finite | np.isfinite(coarse).all(axis=0)]
    return float(min(1.0, np.nan_to_num(worst, nan=1.0).max(initial=0.0)))


def _why_no_replay(setup: FmuSetup, folder: Path) -> str:
    """Reason why a saved state does not give the same outputs in a new instance; "" if it does."""
    first, second = RunningFmu(setup, folder, "probe"), RunningFmu(setup, folder, "probe_again")
    try:
        excite(setup, first)
        for step in range(REPLAY_STEPS):
            first.step(step == 0)
        saved = first.save()
        excite(setup, first)
        future = _next_outputs(first)
        second.restore(saved)
        excite(setup, second)
        if not np.array_equal(_next_outputs(second), future, equal_nan=True):
            return "in the trial at load a restored state did not give the same outputs"
        if (future == future[0]).all():
            return "in the trial at load no output moved, so nothing shows that it replays"
    except RunError as fault:
        return str(fault).removeprefix("probe: ").removeprefix("probe_again: ")
    finally:
        first.end()
        second.end()
    return ""


def _next_outputs(running: RunningFmu) -> NDArray[np.float64]:
    """Outputs of the next steps, (steps, elements)."""
    rows = []
    for step in range(max(REPLAY_STEPS, math.ceil(0.1 / running.setup.period_s))):
        running.step(step == 0)
        rows.append(running.outputs.values.copy())
    return np.array(rows)

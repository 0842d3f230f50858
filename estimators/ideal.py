"""`ideal`: the true joint angles with a declared error, for sweeps of accuracy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERS
from fesloop.loop.abilities import Passage
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, duration_ns
from fesloop.loop.noise import NoiseStream
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless, uncovered

Array = NDArray[np.float64]
PerJoint = float | tuple[float, ...]
_TIPS = (len(FINGERS), 3)


@dataclass(slots=True, eq=False)
class IdealState:
    """State of an IdealTracker.

    Attributes
    ----------
    noise: random numbers of white noise and random walk, two rows a tick.
    errors: (4, joints), rad: bias, drift a second, sd of white noise, sd of the walk a root second.
    walk: (joints,), rad, present random walk.
    time_ns: instant of the last tick.
    past: (instant, true angles, and fingertips if they are read) of the ticks within the delay, oldest first.
    missing: whether a missing truth has been reported.
    """

    noise: NoiseStream
    errors: Array
    walk: Array
    time_ns: int = 0
    past: list[tuple[int, tuple[Array, ...]]] = field(default_factory=list)
    missing: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdealTracker(BlockToControl):
    """True joint angles with a declared error: bias, drift, random walk, white noise, delay, quantisation.

    Input and output `angles` (joints,), rad. At tick time t the output is

        round((truth(t - delay) + bias + drift t + walk(t) + noise) / quantisation) quantisation

    with walk(t) a Wiener process. Errors are given as one value for all joints or one a joint. Before the
    first truth there is no output, with the status `no_sample`.

    With `fingertips`, also input and output `fingertips` (5, 3), m, late by the delay but otherwise exact,
    and output `fingertip_sd` (5, 3), m, which is 0.

    Attributes
    ----------
    joints: number of joints; 0 takes it from the wire.
    bias_deg: constant error.
    drift_deg_s: linear drift, deg/s.
    walk_deg: sd of the random walk after one second, deg.
    noise_deg: sd of the white noise of each tick, deg.
    quantisation_deg: step of the output; 0 for none.
    delay_ms: delay, rounded up to this block's ticks: the truth is that of the last tick at least this old
        (until then the first one). Stamps do not show this delay; `latency_ms` of a wire is exact and shows
        in them.
    fingertips: whether the fingertips of a hand are read and put out.
    """

    joints: int = 0
    bias_deg: PerJoint = 0.0
    drift_deg_s: PerJoint = 0.0
    walk_deg: PerJoint = 0.0
    noise_deg: PerJoint = 0.0
    quantisation_deg: float = 0.0
    delay_ms: float = 0.0
    fingertips: bool = False

    def __post_init__(self) -> None:
        if self.joints < 0:
            raise InputError("joints", f"{self.joints}", "1 or more, or 0 to take it from the wire")
        duration_ns(self.delay_ms, NS_PER_MS, "delay_ms")
        if not (math.isfinite(self.quantisation_deg) and self.quantisation_deg >= 0.0):
            raise InputError("quantisation_deg", f"{self.quantisation_deg}", "zero or more")
        for name in ("bias_deg", "drift_deg_s", "walk_deg", "noise_deg"):
            signed = name in ("bias_deg", "drift_deg_s")
            _require_per_joint(name, getattr(self, name), self.joints, signed=signed)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """angles, and fingertips."""
        angles = Port("angles", (self.joints or None,), "rad")
        return (angles, Port("fingertips", _TIPS, "m")) if self.fingertips else (angles,)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """angles, and fingertips and fingertip_sd."""
        return (*self.inputs, Port("fingertip_sd", _TIPS, "m")) if self.fingertips else self.inputs

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> IdealTracker:
        """The tracker for the number of wired joints."""
        return replace(self, joints=shapes["angles"][0])

    def init(self, context: Context) -> IdealState:
        """State before the first tick."""
        errors = np.array([_rad(getattr(self, name), self.joints)
                           for name in ("bias_deg", "drift_deg_s", "noise_deg", "walk_deg")])
        return IdealState(context.noise(2 * self.joints), errors, np.zeros(self.joints))

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """The delay, which stamps do not show, from the first truth on."""
        delay_ns = duration_ns(self.delay_ms, NS_PER_MS, "delay_ms")
        if not delay_ns:
            return ()
        read = tuple(port.name for port in self.inputs)
        return (Passage(inputs=read, delay_ns=delay_ns, since="read", delay="delay, in whole ticks"),)

    def linear_form(self, context: Context) -> SampledForm:
        """The truth with white noise after the delay, in ticks.

        Raises InputError for errors without a steady state, for quantisation, and for a delay without a rate.
        """
        for name in ("drift_deg_s", "walk_deg", "quantisation_deg"):
            if np.any(getattr(self, name)):
                raise uncovered(name, f"{getattr(self, name)}", "0")
        sd = _rad(self.noise_deg, self.joints)
        whole = replace(
            memoryless(("angles",), "angles", np.eye(self.joints), np.diag(sd) if sd.any() else None),
            offset=_rad(self.bias_deg, self.joints))
        delay, clock = duration_ns(self.delay_ms, NS_PER_MS, "delay_ms"), context.clock
        if not delay:
            return whole
        if not isinstance(clock, RateClock) or clock.period_den != 1:
            raise uncovered("delay_ms", f"{self.delay_ms:g} on a clock without a period of whole ns", "0")
        ticks, joints = -(-delay // clock.period_num), self.joints
        line = np.eye(ticks * joints, k=-joints)
        return replace(whole, a=line, b=np.eye(ticks * joints, joints), d=np.zeros((joints, joints)),
                       c=np.eye(ticks * joints)[-joints:])

    def step(self, state: IdealState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The truth with its error; before the first truth nothing, and a report."""
        if any(sample.arrived_ns < 0 for sample in inputs):
            if not state.missing:
                names = " or ".join(port.name for port in self.inputs)
                tick.report("no_sample", f"no {names} have arrived yet: no output")
                state.missing = True
            return ()
        elapsed_s = (tick.time_ns - state.time_ns) / NS_PER_S
        state.time_ns = tick.time_ns
        truth, *tips = tuple(cast(Array, sample.value) for sample in inputs)
        if self.delay_ms:
            truth, *tips = self._delayed(state, (truth, *tips), tick.time_ns)
        angles: Array = with_error(truth, state.errors, state.walk, state.noise.row(tick.index),
                                   tick.time_ns / NS_PER_S, elapsed_s, math.radians(self.quantisation_deg))
        return (angles, *tips, np.zeros(_TIPS)) if self.fingertips else (angles,)

    def _delayed(self, state: IdealState, truth: tuple[Array, ...], time_ns: int) -> tuple[Array, ...]:
        """Truth of the last tick at or before `delay_ms` ago."""
        past = state.past
        past.append((time_ns, truth))
        due = time_ns - duration_ns(self.delay_ms, NS_PER_MS, "delay_ms")
        while len(past) > 1 and past[1][0] <= due:
            del past[0]
        return past[0][1]


@compiled
def with_error(
    truth: Any, errors: Any, walk: Any, row: Any, time_s: float, elapsed_s: float, step: float
) -> Any:
    """Truth (joints,) with its error, rad; advances `walk` by `elapsed_s`.

    `errors` is (4, joints) as in IdealState, `row` (2 joints,) standard normal, `step` the quantisation.
    """
    joints = truth.size
    angles = np.empty(joints)
    for i in range(joints):
        walk[i] += errors[3, i] * math.sqrt(elapsed_s) * row[joints + i]
        angle = truth[i] + errors[0, i] + errors[1, i] * time_s + walk[i] + errors[2, i] * row[i]
        angles[i] = step * np.floor(angle / step + 0.5) if step > 0.0 else angle
    return angles


def _require_per_joint(name: str, value: PerJoint, joints: int, *, signed: bool) -> None:
    """Raise InputError for a wrong number of values, and for negative ones unless `signed`.

    No array of `joints` values is made: that number has not been checked against the wires yet.
    """
    values = value if isinstance(value, tuple) else (value,)
    if values is value and joints and len(values) != joints:
        raise InputError(name, f"has {len(values)} values", f"one, or {joints}: one a joint")
    if not values or not all(math.isfinite(v) and (signed or v >= 0.0) for v in values):
        raise InputError(name, f"{value}", "finite numbers" if signed else "finite numbers, zero or more")


def _rad(value_deg: PerJoint, joints: int) -> Array:
    """Value of each joint, (joints,), rad."""
    return np.radians(np.full(joints, value_deg, dtype=np.float64))

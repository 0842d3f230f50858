"""The muscles of hand and forearm: from recruited fractions and stimulation frequencies to activation."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value
from plants.checks import require_not_negative, require_positive
from plants.muscles.ding import Ding2003, Ding2007
from plants.muscles.fitness import MuscleFatigue
from plants.muscles.lags import Hammerstein, Riener, TwoLags, follow, held_drives, limit_pulses
from plants.muscles.patient_drive import MuscleTremor, StretchReflex, greatest_efforts, trembling, within
from plants.muscles.state import EFFORT, PULSES, REFLEX, Contraction, MusclesState

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Constants:
    """Constants of the muscles.

    Attributes
    ----------
    contraction: of stimulated muscle. natural: of what nerves drive.
    delays_ns: of each signal, in the order of `plants.muscles.state`.
    sides: (muscles,), on which side of its joint each trembles; zeros without a tremor.
    efforts: (muscles,), the greatest at will.
    """

    contraction: Contraction
    natural: TwoLags
    delays_ns: tuple[int, int, int]
    sides: Array
    efforts: Array


def constants_of(muscles: Muscles) -> Constants:
    """The constants of these parameters; InputError for parameters that cannot be."""
    models: dict[str, Hammerstein | Riener | Ding2003 | Ding2007] = {
        "hammerstein": muscles.hammerstein, "riener": muscles.riener, "ding2003": muscles.ding2003,
        "ding2007": muscles.ding2007}
    if muscles.model not in models:
        raise InputError("muscles.model", f"{muscles.model!r}", ", ".join(models))
    if muscles.model == "ding2003" and muscles.fatigue is not None:
        raise InputError("muscles.fatigue", "the fitness equation beside model ding2003",
                         "no `fatigue` there", "that model tires by its own equations: ding2003.fatigue")
    if not 0.0 <= muscles.wear_per_trial < 1.0:
        raise InputError("muscles.wear_per_trial", f"{muscles.wear_per_trial}", "from 0 to below 1")
    require_positive("muscles", muscles, "fusion_hz", "natural_rad_s")
    require_not_negative("muscles", muscles, "rest_between_trials_s", "delay_growth")
    efforts = greatest_efforts(muscles.voluntary_limit, muscles.voluntary_limits)
    delay = duration_ns(muscles.delay_ms, NS_PER_MS, "muscles.delay_ms")
    reflex = duration_ns(muscles.reflex.delay_ms, NS_PER_MS, "reflex.delay_ms") if muscles.reflex else 0
    return Constants(
        contraction=models[muscles.model].contraction(),
        natural=TwoLags(1.0 / muscles.natural_rad_s, 1.0 / muscles.natural_rad_s),
        delays_ns=(delay, delay, delay + reflex),
        sides=muscles.tremor.sides() if muscles.tremor else np.zeros(len(MUSCLES)), efforts=efforts)


Flags = NDArray[np.bool_]
HIGHEST_HZ = 500.0
"""Frequencies above count as this (chosen: far beyond stimulators, and a muscle is long fused)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Muscles:
    """The 29 muscles of hand and forearm (`fesloop.hand.movements`): four models, fatigue, reflex, tremor.

        stimulated = model(v(t - delay), f(t - delay))
        natural'' + 2 w natural' + w^2 natural = w^2 min(effort + reflex, 1 - v)
        activation = fitness min(1, stimulated + natural + tremor)

    Activation is the force over that of the fresh, fully stimulated muscle at the same length and speed:
    the skeleton scales it by strength. `hammerstein` and `riener` follow v h(f), the recruited fraction
    times h(f) = (f / fusion_hz)^2 / (1 + (f / fusion_hz)^2); `ding2003` and `ding2007` follow single
    pulses, the first when f begins, the next 1 / f later and so on, whatever v does; a pulse takes the v
    that acts at its instant. Fibres that stimulation holds are out of reach of effort and reflex, whose
    drives are held between messages and tire nobody (chosen: at will, fibres take turns). All is exact at
    any instant, Ding's force within 1e-6 (`STEP_NS` in `muscles.ding_kernels`), and the same to
    the last bit whoever looks in between.

    Inputs, (29,) each: `recruitment` v, from 0 to 1, and `frequency` f in Hz; optional `velocity` in 1/s,
    of the fibres over their optimal length, positive in stretch; optional `voluntary` effort, from 0 to 1.
    What lies beyond counts as the nearest value within. Outputs, (29,) each: `activation`, and `fitness`,
    of `ding2003` with fatigue A over its rest value. A next trial begins at rest, fitness as the pause
    left it.

    Attributes
    ----------
    model: how stimulated muscle contracts; its numbers are in the table of its name.
    delay_ms: electromechanical delay (10-20 in models, 40-140 measured at the wrist).
    delay_growth: the delay of what sets out to a muscle that has lost the share x of its fitness is
        1 + delay_growth x times as long; 0: it stays. That it grows is known (Merad 2016, IEEE TCST
        24(3):971), how far is chosen by whoever turns it on. Nothing overtakes.
    fusion_hz: frequency of half the fused force (10, models of the Riener-Fuhr type).
    fatigue: fitness equation; None for muscles that do not tire. Refused beside `ding2003`, which tires by
        its own equations (`ding2003.fatigue`).
    rest_between_trials_s: how long the muscles rest before the next trial, s (chosen).
    wear_per_trial: share of their force that all muscles lose from trial to trial and no rest brings back.
    voluntary_limit: the patient's greatest effort; 0 where nothing can be moved at will.
    voluntary_limits: that of single muscles by name, in place of it.
    natural_rad_s: w, of effort and reflex (25, grip-force data).
    reflex, tremor: None for a patient without.
    """

    model: Literal["hammerstein", "riener", "ding2003", "ding2007"] = "hammerstein"
    hammerstein: Hammerstein = field(default_factory=Hammerstein)
    riener: Riener = field(default_factory=Riener)
    ding2003: Ding2003 = field(default_factory=Ding2003)
    ding2007: Ding2007 = field(default_factory=Ding2007)
    delay_ms: float = 20.0
    delay_growth: float = 0.0
    fusion_hz: float = 10.0
    fatigue: MuscleFatigue | None = None
    rest_between_trials_s: float = 10.0
    wear_per_trial: float = 0.0
    voluntary_limit: float = 1.0
    voluntary_limits: dict[str, float] = field(default_factory=dict)
    natural_rad_s: float = 25.0
    reflex: StretchReflex | None = None
    tremor: MuscleTremor | None = None
    _constants: Constants = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_constants", constants_of(self))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Recruitment, frequency; velocity and effort, which may be left out."""
        each = (len(MUSCLES),)
        return (Port("recruitment", each, "1"), Port("frequency", each, "Hz"),
                Port("velocity", each, "1/s", optional=True), Port("voluntary", each, "1", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Activation and fitness."""
        return Port("activation", (len(MUSCLES),), "1"), Port("fitness", (len(MUSCLES),), "1", 1.0)

    @property
    def ignores(self) -> tuple[str, ...]:
        """Velocity, of muscles without a stretch reflex."""
        return () if self.reflex is not None else ("velocity",)

    @property
    def grid(self) -> None:
        """None: any instant can be gone to."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: every input shows through a lag at least."""
        return False

    def init(self, context: Context) -> MusclesState:
        """At rest, the muscles fresh."""
        return MusclesState(self._constants.contraction.start(), self._constants.natural.start(),
                            np.ones(len(MUSCLES)), self._waves(context))

    def next_trial(self, state: MusclesState, context: Context) -> MusclesState:
        """At rest again; fatigue as the pause between the trials left it."""
        rest_s, fitness = self.rest_between_trials_s, self._fitness(state, state.now_ns)
        if self.fatigue is not None:
            fitness = self.fatigue.after(fitness, np.zeros(len(MUSCLES)), rest_s)
        rested = self._constants.contraction.rested(state.stimulated, rest_s)
        following = MusclesState(rested, self._constants.natural.start(), fitness, self._waves(context))
        following.left = (1.0 - self.wear_per_trial) * state.left
        return following

    def _waves(self, context: Context) -> Array:
        return self.tremor.waves(context) if self.tremor else np.zeros((3, 0))

    def advance(self, state: MusclesState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """From `start_ns` to `stop_ns`, through the instants at which a drive changes."""
        self._send(state, inputs, start_ns)
        while state.arriving and state.arriving[0][0] <= stop_ns:
            self._take(state, *state.arriving.pop(0))
        self._constants.contraction.advance(state.stimulated, stop_ns)
        state.now_ns = stop_ns

    def read(self, state: MusclesState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """(activation, fitness)."""
        activation, fitness = self._outputs(state)
        return state.left * activation, state.left * fitness

    def observe(
        self, state: MusclesState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(activation, fitness) at `times_ns`, ascending, state untouched."""
        return self.advance_through(state.copy(), inputs, start_ns, times_ns)

    def advance_through(
        self, state: MusclesState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(activation, fitness) at `times_ns`, ascending, the state brought to the last of them."""
        self._send(state, inputs, start_ns)
        rows, done = np.empty((2, len(times_ns), len(MUSCLES))), 0
        while done < len(times_ns):
            while state.arriving and state.arriving[0][0] <= times_ns[done]:
                self._take(state, *state.arriving.pop(0))
            upto = len(times_ns)
            if state.arriving:
                upto = bisect_left(times_ns, state.arriving[0][0], done)
            self._follow(state, times_ns[done:upto], rows[0, done:upto], rows[1, done:upto])
            done = upto
        rows *= state.left
        return rows[0], rows[1]

    def _follow(self, state: MusclesState, times_ns: Sequence[int], activation: Array, fit: Array) -> None:
        """Fill `activation` and `fit` (n, 29) at `times_ns`, between which nothing reaches the muscles."""
        lags, drawn = self._constants.contraction, state.stimulated
        if isinstance(lags, TwoLags) and self.tremor is None and state.natural.idle:
            follow(drawn.levels, drawn.drive, (lags.first_s, lags.second_s), drawn.since_ns, state.fitness,
                   state.effort, self.fatigue.rates if self.fatigue else (0.0, 0.0, 0.0), state.since_ns,
                   np.array(times_ns), activation, fit)
        else:
            for k, instant in enumerate(times_ns):
                lags.advance(drawn, instant)
                state.now_ns = instant
                activation[k], fit[k] = self._outputs(state)
        state.now_ns = times_ns[-1]

    def _send(self, state: MusclesState, inputs: Sequence[Value], time_ns: int) -> None:
        """Send off what the inputs of `time_ns` change; equal ones change nothing, so split nothing."""
        recruitment, frequency, velocity, voluntary = cast(Sequence[Array], inputs)
        seen, state.seen = state.seen, (recruitment, frequency, velocity, voluntary)
        if recruitment is not seen[0] or frequency is not seen[1]:
            pulses = np.empty((2, len(MUSCLES)))
            if limit_pulses(recruitment, frequency, HIGHEST_HZ, state.sent[PULSES], pulses):
                self._send_one(state, PULSES, pulses, time_ns)
        if velocity is not seen[2] and self.reflex is not None:
            self._send_one(state, REFLEX, self.reflex.drive(velocity), time_ns)
        if voluntary is not seen[3]:
            self._send_one(state, EFFORT, within(voluntary, self._constants.efforts), time_ns)

    def _send_one(self, state: MusclesState, signal: int, value: Array, time_ns: int) -> None:
        if value.tobytes() == state.sent[signal].tobytes():
            return
        state.sent[signal] = value
        if self.delay_growth > 0.0:
            lost = 1.0 - self._outputs(state)[1]
            late = np.rint(self._constants.delays_ns[PULSES] * self.delay_growth * lost).astype(np.int64)
            state.send_late(time_ns + self._constants.delays_ns[signal], late, signal, value)
        else:
            state.send(time_ns + self._constants.delays_ns[signal], signal, value)

    def _take(self, state: MusclesState, time_ns: int, signal: int, value: Array, some: Flags | None) -> None:
        """Let a signal act from `time_ns` on, on some muscles or on all."""
        state.fitness = self._fitness(state, time_ns)
        acting = value if some is None else np.where(some, value, state.acting[signal])
        state.acting[signal], state.since_ns = acting, time_ns
        weight = self.fatigue.frequency_weight if self.fatigue is not None else 0.0
        drive, effort, natural = held_drives(
            state.acting[PULSES], state.acting[EFFORT], state.acting[REFLEX], self.fusion_hz, weight)
        if signal == PULSES:
            self._constants.contraction.change(state.stimulated, time_ns, acting, drive)
            if self.fatigue is not None:
                state.effort = effort
        self._constants.natural.change(state.natural, time_ns, state.acting[PULSES], natural)

    def _fitness(self, state: MusclesState, time_ns: int) -> Array:
        """What the fitness equation gives at an instant, (29,); ones without it."""
        if self.fatigue is None:
            return state.fitness
        return self.fatigue.after(state.fitness, state.effort, (time_ns - state.since_ns) / NS_PER_S)

    def _outputs(self, state: MusclesState) -> tuple[Array, Array]:
        """(activation, fitness) of the instant that the state is of."""
        now, fitness = state.now_ns, self._fitness(state, state.now_ns)
        activation, capacity = self._constants.contraction.look(state.stimulated, now)
        if self.tremor is not None or not state.natural.idle:
            natural, _ = self._constants.natural.look(state.natural, now)
            if self.tremor is not None:
                natural += trembling(state.waves, self._constants.sides, now)
            natural *= capacity
            activation += natural
        np.minimum(activation, 1.0, out=activation)
        activation *= fitness
        return activation, fitness * capacity

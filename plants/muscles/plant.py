"""`muscles`: muscles of hand and forearm, from recruited fraction and stimulation frequency to activation."""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from operator import itemgetter
from typing import Any, Literal, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.movements import MUSCLES, each_muscle
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value
from plants.muscles.ding import Ding2003, Ding2007
from plants.muscles.lags import (
    NO_FATIGUE,
    Hammerstein,
    LagState,
    MuscleFatigue,
    Riener,
    TwoLags,
    follow,
    held_drives,
    lags_s,
    limit_pulses,
)
from plants.muscles.patient_drive import MuscleTremor, StretchReflex, greatest_efforts, trembling, within
from plants.muscles.variation import Variation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Instants = NDArray[np.int64]
PULSES, EFFORT, REFLEX = range(3)
"""Signals to the muscles: pulses (recruited fraction, frequency in Hz) (2, muscles); drives (muscles,)."""


class MuscleInputs(NamedTuple):
    """Values of the input ports, (muscles,) each; None before the first."""

    recruitment: Array | None
    frequency: Array | None
    velocity: Array | None
    voluntary: Array | None


class Contraction(Protocol):
    """Contraction model of all muscles, whose state has `copy()` and changes at its own instants."""

    def start(self) -> Any:
        """State at rest, without fatigue."""

    def rested(self, state: Any, rest_s: float) -> Any:
        """State at rest, `rest_s` after `state`."""

    def advance(self, state: Any, stop_ns: int) -> None:
        """Advance to the model's last own instant before `stop_ns`."""

    def change(self, state: Any, time_ns: int, pulses: Array, drive: Array) -> None:
        """Let `pulses` (2, muscles), or the steady activation `drive` (muscles,), act from `time_ns` on."""

    def look(self, state: Any, time_ns: int) -> tuple[Array, Array]:
        """Activation, and capacity left by the model's own fatigue, (muscles,) each, at an instant up to
        which `advance` went."""


class MusclesState:
    """State of the muscles. All but `now_ns` changes at the muscles' own instants, not at observations.

    Attributes
    ----------
    now_ns: instant of the state.
    stimulated, natural: contraction by stimulation, and by nerves.
    fitness, effort: (muscles,), fitness at `since_ns`, and the effort that reduces it from then on.
    since_ns: last change of the drive.
    latched: last inputs, to recognise new ones.
    sent, acting: newest value of each signal sent to the muscles, and the one that acts.
    arriving: values in the delays, in order of arrival: instant in ns, signal, value, and the muscles that
        they apply to, (muscles,), None for all.
    latest: (3, muscles), last arrivals of each signal, where muscles have delays of their own; those get only
        values that change.
    waves: sinusoids of the tremor (3, c).
    strength: fraction of force left after the wear of trials.
    slow, factors: slow part of the variation (1 + muscles,), and its factors (muscles,) in this trial.
    """

    __slots__ = ("acting", "arriving", "effort", "factors", "fitness", "latched", "latest", "natural",
                 "now_ns", "sent", "since_ns", "slow", "stimulated", "strength", "waves")

    def __init__(self, stimulated: Any, natural: LagState, fitness: Array, waves: Array, slow: Array,
                 factors: Array) -> None:
        count = len(MUSCLES)
        self.now_ns = self.since_ns = 0
        self.stimulated, self.natural = stimulated, natural
        self.fitness, self.effort, self.waves = fitness, np.zeros(count), waves
        self.slow, self.factors = slow, factors
        self.latched = MuscleInputs(None, None, None, None)
        self.sent: list[Array] = [np.zeros((2, count)), np.zeros(count), np.zeros(count)]
        self.acting: list[Array] = list(self.sent)
        self.arriving: list[tuple[int, int, Array, Flags | None]] = []
        self.latest = np.zeros((3, count), np.int64)
        self.strength = 1.0

    def send(self, arrival_ns: int, signal: int, value: Array) -> None:
        """Send a value to all muscles."""
        insort(self.arriving, (arrival_ns, signal, value, None), key=itemgetter(0))

    def send_each(self, arrivals_ns: Instants, signal: int, value: Array, changed: Flags) -> None:
        """Send a value to the muscles `changed` (muscles,), arriving at each at its own instant, in order."""
        latest = np.maximum(arrivals_ns, self.latest[signal])
        self.latest[signal, changed] = latest[changed]
        for instant in np.unique(latest[changed]):
            some = changed & (latest == instant)
            insort(self.arriving, (int(instant), signal, value, some), key=itemgetter(0))

    def copy(self) -> MusclesState:
        """An independent copy."""
        ahead = MusclesState.__new__(MusclesState)
        ahead.now_ns, ahead.since_ns = self.now_ns, self.since_ns
        ahead.stimulated, ahead.natural = self.stimulated.copy(), self.natural.copy()
        ahead.fitness, ahead.effort, ahead.waves = self.fitness, self.effort, self.waves
        ahead.slow, ahead.factors = self.slow, self.factors
        ahead.latched = self.latched
        ahead.sent, ahead.acting = self.sent.copy(), self.acting.copy()
        ahead.strength = self.strength
        ahead.arriving, ahead.latest = self.arriving.copy(), self.latest.copy()
        return ahead


@dataclass(frozen=True, slots=True, eq=False)
class Constants:
    """Coefficients derived from the parameters of the muscles.

    Attributes
    ----------
    contraction: model of stimulated muscle. natural: model of muscle driven by nerves.
    delays_ns: (3, muscles), delay of each signal, indexed by PULSES, EFFORT, REFLEX.
    together: whether a signal reaches all muscles at the same instant.
    sides: (muscles,), sign of each muscle's tremor; zeros without a tremor.
    efforts: (muscles,), greatest voluntary effort.
    """

    contraction: Contraction
    natural: TwoLags
    delays_ns: Instants
    together: bool
    sides: Array
    efforts: Array


def constants_of(muscles: Muscles) -> Constants:
    """Derive the coefficients; InputError for invalid parameters."""
    models: dict[str, Hammerstein | Riener | Ding2003 | Ding2007] = {
        "hammerstein": muscles.hammerstein, "riener": muscles.riener, "ding2003": muscles.ding2003,
        "ding2007": muscles.ding2007}
    if muscles.model not in models:
        raise InputError("muscles.model", f"{muscles.model!r}", ", ".join(models))
    if muscles.model == "ding2003" and muscles.fatigue is not None:
        raise InputError("muscles.fatigue", "the fitness equation is given with model ding2003",
                         "no `fatigue`", "use the fatigue equations of that model: ding2003.fatigue")
    if not 0.0 <= muscles.wear_per_trial < 1.0:
        raise InputError("muscles.wear_per_trial", f"{muscles.wear_per_trial}", "from 0 to below 1")
    require_positive("muscles", muscles, "fusion_hz", "natural_rad_s")
    require_not_negative("muscles", muscles, "rest_between_trials_s", "delay_growth", "session")
    efforts = greatest_efforts(muscles.voluntary_limit, muscles.voluntary_limits)
    usual = duration_ns(muscles.delay_ms, NS_PER_MS, "muscles.delay_ms")
    own = {name: duration_ns(each, NS_PER_MS, f"muscles.delays_ms.{name}")
           for name, each in muscles.delays_ms.items()}
    delays = each_muscle(usual, own, "muscles.delays_ms").astype(np.int64)
    reflex = duration_ns(muscles.reflex.delay_ms, NS_PER_MS, "reflex.delay_ms") if muscles.reflex else 0
    lags = lags_s(muscles.natural_rad_s, muscles.naturals_rad_s, "muscles.naturals_rad_s")
    return Constants(
        contraction=models[muscles.model].contraction(), natural=TwoLags(lags, lags),
        delays_ns=np.stack([delays, delays, delays + reflex]),
        together=muscles.delay_growth == 0.0 and bool((delays == delays[0]).all()),
        sides=muscles.tremor.sides() if muscles.tremor else np.zeros(len(MUSCLES)), efforts=efforts)


HIGHEST_HZ = 500.0
"""Frequencies above count as this (chosen: far beyond stimulators, and a muscle is long fused)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Muscles:
    """The 29 muscles of hand and forearm (`fesloop.hand.movements`): four models, fatigue, reflex, tremor.

        stimulated = factor model(v(t - delay), f(t - delay))
        natural'' + 2 w natural' + w^2 natural = w^2 min(effort + reflex, 1 - v)
        activation = fitness min(1, stimulated + natural + tremor)

    Activation is the force over that of the fresh, fully stimulated muscle at the same length and speed:
    the skeleton scales it by strength. `hammerstein` and `riener` follow v h(f), the recruited fraction
    times h(f) = (f / fusion_hz)^2 / (1 + (f / fusion_hz)^2); `ding2003` and `ding2007` follow single
    pulses, the first when f begins, the next 1 / f later and so on, whatever v does; a pulse takes the v
    that acts at its instant. Fibres that stimulation holds are out of reach of effort and reflex, whose
    drives are held between messages and tire nobody (chosen: at will, fibres take turns). The factor of
    `variation` differs from trial to trial, and does not tire a muscle more or less. All is exact at
    any instant, Ding's force within 1e-6 (`STEP_NS` in `plants.muscles.ding`), and the same to
    the last bit whoever looks in between.

    Inputs, (29,) each: `recruitment` v, from 0 to 1, and `frequency` f in Hz; optional `velocity` in 1/s,
    of the fibres over their optimal length, positive in stretch; optional `voluntary` effort, from 0 to 1.
    What lies beyond counts as the nearest value within. Outputs, (29,) each: `activation`, and `fitness`,
    of `ding2003` with fatigue A over its rest value. A next trial begins at rest, fitness as the pause
    left it.

    Attributes
    ----------
    model: contraction model of stimulated muscle; its parameters are in the table of its name.
    delay_ms: electromechanical delay (40, the middle of stimulated muscles of elbow and forearm:
        docs/models/people.md; 10-20 in models, 40-140 measured at the wrist).
    delays_ms: delays of single muscles by name, in place of it.
    delay_growth: growth of a muscle's delay with lost fitness x, to 1 + delay_growth x times; 0: none. The
        growth is measured (Merad 2016, IEEE TCST 24(3):971), its size is left to the user. Signals keep
        their order.
    fusion_hz: frequency of half the fused force (10, models of the Riener-Fuhr type).
    fatigue: fitness equation; None for muscles that do not tire. Refused with `ding2003`, which has its own
        equations (`ding2003.fatigue`).
    rest_between_trials_s: rest of the muscles before the next trial, s (chosen).
    wear_per_trial: fraction of force that all muscles lose from trial to trial without recovery.
    variation: of the strength of stimulated muscle from trial to trial; without parameters: none.
    session: number of the session. Trials of another one vary otherwise, with the same seed too: a model is
        not tried in the trial that it is of.
    voluntary_limit: greatest voluntary effort; 0 for complete paralysis.
    voluntary_limits: greatest voluntary effort of single muscles by name, in place of it.
    natural_rad_s: natural frequency w of effort and reflex (16, as of stimulation; grip-force data: 20-25).
    naturals_rad_s: natural frequencies of single muscles by name, in place of it.
    reflex, tremor: stretch reflex and tremor; None for a patient without.
    """

    model: Literal["hammerstein", "riener", "ding2003", "ding2007"] = "hammerstein"
    hammerstein: Hammerstein = field(default_factory=Hammerstein)
    riener: Riener = field(default_factory=Riener)
    ding2003: Ding2003 = field(default_factory=Ding2003)
    ding2007: Ding2007 = field(default_factory=Ding2007)
    delay_ms: float = 40.0
    delays_ms: dict[str, float] = field(default_factory=dict)
    delay_growth: float = 0.0
    fusion_hz: float = 10.0
    fatigue: MuscleFatigue | None = None
    rest_between_trials_s: float = 10.0
    wear_per_trial: float = 0.0
    variation: Variation = field(default_factory=Variation)
    session: int = 0
    voluntary_limit: float = 1.0
    voluntary_limits: dict[str, float] = field(default_factory=dict)
    natural_rad_s: float = 16.0
    naturals_rad_s: dict[str, float] = field(default_factory=dict)
    reflex: StretchReflex | None = None
    tremor: MuscleTremor | None = None
    _constants: Constants = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_constants", constants_of(self))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Recruitment and frequency; optionally velocity and voluntary effort."""
        each = (len(MUSCLES),)
        return (Port("recruitment", each, "1"), Port("frequency", each, "Hz"),
                Port("velocity", each, "1/s", optional=True), Port("voluntary", each, "1", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Activation and fitness."""
        return (Port("activation", (len(MUSCLES),), "1", rows=MUSCLES),
                Port("fitness", (len(MUSCLES),), "1", 1.0, rows=MUSCLES))

    @property
    def ignores(self) -> tuple[str, ...]:
        """Velocity, for muscles without a stretch reflex."""
        return () if self.reflex is not None else ("velocity",)

    @property
    def grid(self) -> None:
        """None: the plant advances to any instant."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: every input acts through at least one lag."""
        return False

    def init(self, context: Context) -> MusclesState:
        """State at rest, without fatigue."""
        context = self._in_session(context)
        slow = self.variation.start(context)
        return MusclesState(self._constants.contraction.start(), self._constants.natural.start(),
                            np.ones(len(MUSCLES)), self._waves(context), slow,
                            self.variation.factors(slow, context))

    def next_trial(self, state: MusclesState, context: Context) -> MusclesState:
        """State at rest, with the fatigue left after the pause between trials."""
        context = self._in_session(context)
        rest_s, fitness = self.rest_between_trials_s, self._fitness(state, state.now_ns)
        if self.fatigue is not None:
            fitness = self.fatigue.after(fitness, np.zeros(len(MUSCLES)), rest_s)
        rested = self._constants.contraction.rested(state.stimulated, rest_s)
        slow = self.variation.later(state.slow, state.now_ns / NS_PER_S + rest_s, context)
        following = MusclesState(rested, self._constants.natural.start(), fitness, self._waves(context), slow,
                                 self.variation.factors(slow, context))
        following.strength = (1.0 - self.wear_per_trial) * state.strength
        return following

    def _in_session(self, context: Context) -> Context:
        """Place with random numbers of its own in each session."""
        return replace(context, name=f"{context.name} in session {self.session}") if self.session else context

    def _waves(self, context: Context) -> Array:
        return self.tremor.waves(context) if self.tremor else np.zeros((3, 0))

    def advance(self, state: MusclesState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance through the instants at which a drive changes."""
        self._send(state, self._changed(state, inputs), start_ns)
        self._go(state, stop_ns)

    def _go(self, state: MusclesState, stop_ns: int) -> None:
        """Advance to an instant; nothing is sent until then."""
        while state.arriving and state.arriving[0][0] <= stop_ns:
            self._take(state, *state.arriving.pop(0))
        self._constants.contraction.advance(state.stimulated, stop_ns)
        state.now_ns = stop_ns

    def read(self, state: MusclesState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """(activation, fitness)."""
        activation, fitness = self._outputs(state)
        return state.strength * activation, state.strength * fitness

    def observe(
        self, state: MusclesState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(activation, fitness) at `times_ns`, ascending; the state is not changed."""
        return self.advance_through(state.copy(), [(start_ns, inputs)], times_ns)

    def advance_through(
        self, state: MusclesState, inputs: Sequence[tuple[int, Sequence[Value]]], times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(activation, fitness) at `times_ns`, ascending; the state advances to the last of them."""
        rows, done = np.empty((2, len(times_ns), len(MUSCLES))), 0
        for start_ns, values in inputs:
            if signals := self._changed(state, values):
                upto = bisect_right(times_ns, start_ns, done)
                self._fill(state, times_ns[done:upto], rows[:, done:upto])
                done = upto
                self._go(state, start_ns)
                self._send(state, signals, start_ns)
        self._fill(state, times_ns[done:], rows[:, done:])
        rows *= state.strength
        return rows[0], rows[1]

    def _fill(self, state: MusclesState, times_ns: Sequence[int], rows: Array) -> None:
        """Fill activation and fitness, `rows` (2, n, 29), at `times_ns`, n, during which nothing is sent."""
        done = 0
        while done < len(times_ns):
            while state.arriving and state.arriving[0][0] <= times_ns[done]:
                self._take(state, *state.arriving.pop(0))
            upto = len(times_ns)
            if state.arriving:
                upto = bisect_left(times_ns, state.arriving[0][0], done)
            self._follow(state, times_ns[done:upto], rows[0, done:upto], rows[1, done:upto])
            done = upto

    def _follow(self, state: MusclesState, times_ns: Sequence[int], activation: Array, fit: Array) -> None:
        """Fill `activation` and `fit` (n, 29) at `times_ns`, during which no signal arrives."""
        model, stimulated = self._constants.contraction, state.stimulated
        if isinstance(model, TwoLags) and self.tremor is None and state.natural.idle:
            follow(stimulated.levels, stimulated.drive, model.first_s, model.second_s, stimulated.since_ns,
                   state.fitness, state.effort, self.fatigue.rates if self.fatigue else NO_FATIGUE,
                   state.since_ns, state.factors, np.array(times_ns), activation, fit)
        else:
            for k, instant in enumerate(times_ns):
                model.advance(stimulated, instant)
                state.now_ns = instant
                activation[k], fit[k] = self._outputs(state)
        state.now_ns = times_ns[-1]

    def _changed(self, state: MusclesState, inputs: Sequence[Value]) -> list[tuple[int, Array]]:
        """(signal, new value) of the signals that inputs change; equal inputs change none."""
        signals: list[tuple[int, Array]] = []
        recruitment, frequency, velocity, voluntary = cast(Sequence[Array], inputs)
        before, state.latched = state.latched, MuscleInputs(recruitment, frequency, velocity, voluntary)
        if recruitment is not before.recruitment or frequency is not before.frequency:
            pulses = np.empty((2, len(MUSCLES)))
            if limit_pulses(recruitment, frequency, HIGHEST_HZ, state.sent[PULSES], pulses):
                signals.append((PULSES, pulses))
        if velocity is not before.velocity and self.reflex is not None:
            signals.append((REFLEX, self.reflex.drive(velocity)))
        if voluntary is not before.voluntary:
            signals.append((EFFORT, within(voluntary, self._constants.efforts)))
        return [(signal, value) for signal, value in signals
                if value.tobytes() != state.sent[signal].tobytes()]

    def _send(self, state: MusclesState, signals: Sequence[tuple[int, Array]], time_ns: int) -> None:
        """Send new values of signals at `time_ns`."""
        for signal, value in signals:
            self._send_one(state, signal, value, time_ns)

    def _send_one(self, state: MusclesState, signal: int, value: Array, time_ns: int) -> None:
        before, state.sent[signal] = state.sent[signal], value
        delays = self._constants.delays_ns
        if self._constants.together:
            state.send(time_ns + int(delays[signal, 0]), signal, value)
            return
        arrivals = time_ns + delays[signal]
        if self.delay_growth > 0.0:
            lost = 1.0 - self._outputs(state)[1]
            arrivals += np.rint(delays[PULSES] * self.delay_growth * lost).astype(np.int64)
        state.send_each(arrivals, signal, value, (value != before).reshape(-1, len(MUSCLES)).any(axis=0))

    def _take(self, state: MusclesState, time_ns: int, signal: int, value: Array, some: Flags | None) -> None:
        """Let a signal act from `time_ns` on, on some muscles or all."""
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
        """Fitness at an instant, (29,); ones without the fitness equation."""
        if self.fatigue is None:
            return state.fitness
        return self.fatigue.after(state.fitness, state.effort, (time_ns - state.since_ns) / NS_PER_S)

    def _outputs(self, state: MusclesState) -> tuple[Array, Array]:
        """(activation, fitness) at the instant of the state."""
        now, fitness = state.now_ns, self._fitness(state, state.now_ns)
        activation, capacity = self._constants.contraction.look(state.stimulated, now)
        activation *= state.factors
        if self.tremor is not None or not state.natural.idle:
            natural, _ = self._constants.natural.look(state.natural, now)
            if self.tremor is not None:
                natural += trembling(state.waves, self._constants.sides, now)
            natural *= capacity
            activation += natural
        np.minimum(activation, 1.0, out=activation)
        activation *= fitness
        return activation, fitness * capacity

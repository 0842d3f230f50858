"""`intention`: what a person tries to do, as effort of the muscles and surface EMG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.movements import MUSCLES
from fesloop.loop.abilities import Passage, Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.noise import NoiseStream
from fesloop.loop.signals import NEVER, Port, Sample, Sensors, Value
from plants.intention.emg import STATES, EmgElectrode, Shaping, require_band, shaping
from plants.intention.script import Attempt, Course, marks, require_order
from plants.muscles.patient_drive import greatest_efforts

Array = NDArray[np.float64]
_LONGEST_S = 4e-3
"""Longest sampling period of EMG (chosen: half the power of a usual spectrum is below 100 Hz)."""


class Gains(NamedTuple):
    """Amplitudes of the electrodes, (k,) each: V at full effort, V at rest, V/C of an artefact."""

    greatest: Array
    rest: Array
    artefact: Array


@dataclass(slots=True, eq=False)
class IntentionState:
    """State of the person and the electrodes.

    Attributes
    ----------
    course: attempts of this trial.
    noise: random numbers of this trial's ticks.
    keeps: factor on the noise of effort from tick to tick.
    wander: (all muscles,), noise of effort, variance 1.
    gains: of the electrodes; constant.
    shaping: filter of the EMG's noise; constant. waves: (3, k), its states.
    artefact: (k,), V, at `now_ns`.
    now_ns: instant of the newest tick. pulse_ns: of the newest pulse. heard_ns: of the newest message.
    """

    course: Course
    noise: NoiseStream
    keeps: float
    wander: Array
    gains: Gains
    shaping: Shaping
    waves: Array
    artefact: Array
    now_ns: int = 0
    pulse_ns: int = NEVER
    heard_ns: int = NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class Intention:
    """A person who tries to move at chosen instants, with muscles of which some obey and others do not.

    Effort begins at `at_s` plus a reaction time, rises and falls linearly, and has noise in proportion to
    itself, as isometric force has (Jones 2002, doi 10.1152/jn.2002.88.3.1533). No effort exceeds the
    greatest that the person can make with a muscle: muscles that do not obey give no effort and no EMG but
    the noise at rest. EMG is amplitude-modulated noise (`plants.intention.emg`).

    Input, if an electrode has an artefact: `stimulation` (elements, 3): pulses of the slot, A, s, Hz, as
    `stimulator` puts them out. Outputs: `voluntary` (29,), effort of the muscles of
    `fesloop.hand.movements`, from 0 to 1; `attempt`, number of the attempt under way, from 1, 0 for none;
    with electrodes `emg` (k,), V, NaN while blanked, and `effort` (k,), the effort of their muscles as a
    fraction of the greatest that the person can make, for comparison.

    Attributes
    ----------
    attempts: attempts in order of time.
    emg: electrodes.
    elsewhere: greatest effort, from 0 to 1, of muscles outside the forearm and hand, by a name of your own.
    voluntary_limit: greatest effort of each muscle; voluntary_limits: of single muscles, in place of it.
        Both are the patient's, as those of `muscles` are.
    reaction_s: mean time from an attempt's instant to the onset of effort (chosen: simple reactions).
    jitter_s: sd of the onset; none is before the attempt's instant (chosen).
    rise_s: duration of the rise of an effort, and of its fall (chosen).
    noise: sd of the effort as a fraction of the effort (chosen).
    noise_s: time constant of that noise (chosen).
    band_hz: frequencies fl, fh of the EMG's spectrum (chosen: a mean frequency near 100 Hz).
    artefact_ms: time constant of the decay of an artefact (chosen: an amplifier that recovers fast).
    blanking_ms: time after each pulse in which electrodes with an artefact give no sample; 0: none.
    elements: number of elements in `stimulation`; 0 takes it from the wire.
    """

    attempts: tuple[Attempt, ...]
    emg: tuple[EmgElectrode, ...] = ()
    elsewhere: dict[str, float] = field(default_factory=dict)
    voluntary_limit: float = 1.0
    voluntary_limits: dict[str, float] = field(default_factory=dict)
    reaction_s: float = 0.2
    jitter_s: float = 0.03
    rise_s: float = 0.15
    noise: float = 0.03
    noise_s: float = 0.1
    band_hz: tuple[float, float] = (60.0, 120.0)
    artefact_ms: float = 0.5
    blanking_ms: float = 0.0
    elements: int = 0
    _efforts: Array = field(init=False, repr=False, compare=False)
    _limits: Array = field(init=False, repr=False, compare=False)
    _rows: NDArray[np.intp] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_not_negative("intention", self, "reaction_s", "jitter_s", "noise")
        require_positive("intention", self, "rise_s", "noise_s", "artefact_ms")
        require_band(self.band_hz)
        duration_ns(self.blanking_ms, NS_PER_MS, "blanking_ms")
        require_order(self.attempts, self.rise_s)
        for name, limit in self.elsewhere.items():
            if name in MUSCLES:
                raise InputError(f"elsewhere.{name}", "is a muscle of the forearm or hand", "other names",
                                 "its greatest effort is in voluntary_limits")
            if not 0.0 <= limit <= 1.0:
                raise InputError(f"elsewhere.{name}", f"{limit:g}", "from 0 to 1")
        names = (*MUSCLES, *self.elsewhere)
        for number, electrode in enumerate(self.emg):
            if electrode.muscle not in names:
                raise InputError(f"emg[{number}].muscle", f"{electrode.muscle!r}", ", ".join(names),
                                 did_you_mean(electrode.muscle, names)
                                 or "name muscles of other limbs in elsewhere")
        limits = np.concatenate([greatest_efforts(self.voluntary_limit, self.voluntary_limits),
                                 list(self.elsewhere.values())])
        object.__setattr__(self, "_limits", limits)
        object.__setattr__(self, "_efforts", marks(self.attempts, names) * limits)
        object.__setattr__(self, "_rows", np.array([names.index(each.muscle) for each in self.emg], np.intp))

    @property
    def gains(self) -> Gains:
        """Amplitudes of the electrodes."""
        table = [(1e-3 * each.greatest_mv, 1e-6 * each.rest_uv, 1e3 * each.artefact_mv_per_uc)
                 for each in self.emg]
        return Gains(*np.array(table).reshape(-1, 3).T)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation` if an electrode has an artefact, else none."""
        near = any(each.artefact_mv_per_uc for each in self.emg)
        return (Port("stimulation", (self.elements or None, 3), "A,s,Hz", every=True),) if near else ()

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Intention:
        """This block with the number of wired elements."""
        return replace(self, elements=shapes["stimulation"][0]) if self.inputs else self

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`voluntary`, `attempt`; with electrodes `emg`, `effort`."""
        always = Port("voluntary", (len(MUSCLES),), "1", rows=MUSCLES), Port("attempt")
        if not self.emg:
            return always
        sensors = Sensors(tuple(each.muscle for each in self.emg))
        size = (len(self.emg),)
        return (*always, Port("emg", size, "V", sensors=sensors, gaps=self.blanking_ms > 0.0),
                Port("effort", size, "1", rows=sensors.names))

    @property
    def captures(self) -> bool:
        """True: the person and the electrodes are now as they are, whatever stimulation derives from."""
        return True

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """Stimulation acts on the EMG alone."""
        return (Passage(inputs=("stimulation",), outputs=("emg",)),) if self.inputs else ()

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """A rate that is too low for EMG."""
        period_s = context.clock.period_s if context.clock is not None else math.inf
        if not self.emg or period_s <= _LONGEST_S:
            return ()
        return (InputError("rate", f"{1.0 / period_s:g}", f"{1.0 / _LONGEST_S:g} or more, to sample EMG"),)

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Warnings (status, detail) about attempts with muscles that do not obey."""
        names = (*MUSCLES, *self.elsewhere)
        found = []
        for number, attempt in enumerate(self.attempts):
            idle = [name for name in attempt.contracted if self._limits[names.index(name)] == 0.0]
            if len(idle) == len(attempt.contracted):
                found.append(("attempt_in_vain", f"attempt {number + 1} at {attempt.at_s:g} s: the person "
                              f"cannot contract {', '.join(idle)} at will"))
        return tuple(found)

    def init(self, context: Context) -> IntentionState:
        """State at the start of a trial, whose reaction times differ from those of other trials."""
        count, electrodes = len(self._limits), len(self.emg)
        period_s = context.clock.period_s if context.clock is not None else 1e-3
        late = context.noise(max(len(self.attempts), 1), purpose="onsets").row(0)[:len(self.attempts)]
        delays_s = np.maximum(self.reaction_s + self.jitter_s * late, 0.0)
        start = context.noise(count + STATES * electrodes, purpose="start").row(0)
        filters = shaping(self.band_hz, period_s)
        return IntentionState(
            Course.of(self.attempts, delays_s, self.rise_s),
            context.noise(count + (STATES + 1) * electrodes), math.exp(-period_s / self.noise_s),
            start[:count].copy(), self.gains, filters,
            filters.start @ start[count:].reshape(STATES, electrodes), np.zeros(electrodes))

    def step(self, state: IntentionState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Efforts and EMG of one tick."""
        tick.captured_ns = tick.time_ns
        count, electrodes = len(self._limits), len(self.emg)
        normal = state.noise.row(tick.index)
        state.wander *= state.keeps
        state.wander += math.sqrt(1.0 - state.keeps**2) * normal[:count]
        intended = (state.course.shares(tick.time_ns)[:, np.newaxis] * self._efforts).max(axis=0, initial=0.0)
        efforts = np.minimum(np.maximum(intended * (1.0 + self.noise * state.wander), 0.0), self._limits)
        attempt = float(state.course.under_way(tick.time_ns))
        if not electrodes:
            return efforts[:len(MUSCLES)], attempt
        made = efforts[self._rows]
        normal = normal[count:].reshape(STATES + 1, electrodes)
        state.waves = state.shaping.step @ state.waves + state.shaping.noise @ normal[:STATES]
        emg = (state.gains.greatest * made * (state.shaping.output @ state.waves)
               + state.gains.rest * normal[STATES])
        if inputs:
            emg += self._heard(state, inputs[0], tick.time_ns)
            if state.pulse_ns >= 0 and tick.time_ns < state.pulse_ns + round(self.blanking_ms * NS_PER_MS):
                emg[state.gains.artefact > 0.0] = np.nan
        state.now_ns = tick.time_ns
        able = self._limits[self._rows]
        share = np.divide(made, able, np.zeros(electrodes), where=able > 0.0)
        return efforts[:len(MUSCLES)], attempt, emg, share

    def _heard(self, state: IntentionState, stimulation: Sample, now_ns: int) -> Array:
        """Artefact of all pulses up to now, (k,), V."""
        decay_ns = self.artefact_ms * NS_PER_MS
        state.artefact *= math.exp((state.now_ns - now_ns) / decay_ns)
        if stimulation.arrived_ns > state.heard_ns:
            state.heard_ns = stimulation.arrived_ns
            pulses = cast(Array, stimulation.value)
            charge = float(pulses[:, 0] @ pulses[:, 1])
            if charge > 0.0:
                state.pulse_ns = stimulation.arrived_ns
                left = math.exp((state.pulse_ns - now_ns) / decay_ns)
                state.artefact += state.gains.artefact * charge * left
        return state.artefact

"""`electrodes`: arrays on a forearm, from pulses of their elements to recruitment of muscles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port, Sample, Value, is_finite
from plants.checks import require_not_negative, require_positive, require_shape
from plants.electrodes.arrays import (
    ALONG,
    DORSAL,
    MOTOR_POINTS,
    THRESHOLD,
    VOLAR,
    AxonScatter,
    ElectrodeArray,
    MotorPoint,
)
from plants.electrodes.state import ElectrodesState, Forearm, find_active

Array = NDArray[np.float64]
_AXONS = AxonScatter()


@dataclass(frozen=True, slots=True, kw_only=True)
class Electrodes:
    """Arrays on a forearm, and the axons under them that their currents excite.

    The forearm is a cylinder. Axons lie around each muscle's motor point. An axon fires when the effective
    currents I / (1 + chronaxie / pulse width) of all simultaneously active elements, each times its field at
    the axon, add up to the axon's threshold. A pulse counts until the next pulse of its train is due, so that
    pulses of interleaved channels recruit independently, and a muscle by their union. To process all pulses
    the block must step as often as the stimulator has slots (8 channels at 40 Hz: 320 Hz).

    The parameters of the model are calibrated choices; none is published.

    Inputs: `elements` (elements, 3): current, A, pulse width, s, and stimulation frequency, Hz, of the pulse
    of every element, 0 without a pulse; the elements of one message are active simultaneously. Optional:
    `posture`, pronation of the forearm from neutral, rad, in place of `pronation_deg`; `skin` (elements,),
    factors on `skin_gain`; `shift` (2,), m, displacement of the arrays on the skin, around the forearm
    towards the radial side, and along it towards the wrist. Outputs, for the muscles in the order of
    `fesloop.hand.movements`: `recruitment` (29,), fraction of the axons, 0 to 1, 0 for muscles of the hand;
    `frequency` (29,), Hz, mean rate of the recruited axons.

    Statuses: `bad_input` for a pulse that is negative, not finite or without a frequency (no pulse of its
    message is given), `bad_skin` for factors that are negative or not finite, `bad_posture`, and `bad_shift`
    beyond the forearm's ends (the last good values hold), `pulses_missed` if pulses come more often than
    ticks.

    Attributes
    ----------
    arrays: electrode arrays; their elements are numbered in this order, and `elements` of `stimulator` must
        be their total.
    motor_points: motor points of the muscles within reach, one each.
    axons: distribution of axons around every motor point.
    axon_seed: seed of the person's axons, in place of the run's seed.
    threshold: factors on the thresholds of the muscles' axons, in the order of `MUSCLES`; empty: 1.
    radius_mm, length_mm: measures of the forearm (chosen; length: an adult's from elbow to wrist).
    reference_mm: depth at which the field under a pad is 1.
    chronaxie_us: chronaxie of the axons.
    pronation_deg: pronation of the forearm since the arrays were put on, if `posture` has no wire; the hand's
        own forearm orientation has no effect here.
    pronation_share: fraction of forearm rotation that a motor point at the wrist follows; others in
        proportion to their distance from the elbow. Pronation moves them towards the radial side (chosen,
        sweep 0 to 0.7).
    posture_step_deg: step of forearm rotation at which the field is computed again (chosen).
    shift_mm, shift_deg: displacement of the arrays, towards the wrist and towards the radial side.
    skin_gain: fraction of each element's current that passes the skin; empty: 1.
    """

    arrays: tuple[ElectrodeArray, ...] = (DORSAL, VOLAR)
    motor_points: tuple[MotorPoint, ...] = MOTOR_POINTS
    axons: AxonScatter = _AXONS
    axon_seed: int | None = None
    threshold: tuple[float, ...] = ()
    radius_mm: float = 40.0
    length_mm: float = 260.0
    reference_mm: float = 10.0
    chronaxie_us: float = 200.0
    pronation_deg: float = 0.0
    pronation_share: float = 0.35
    posture_step_deg: float = 1.0
    shift_mm: float = 0.0
    shift_deg: float = 0.0
    skin_gain: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_positive("electrodes", self, "radius_mm", "length_mm", "reference_mm", "chronaxie_us",
                         "posture_step_deg")
        require_not_negative("electrodes", self, "pronation_share")
        require_shape("electrodes", self, (), "a number", "shift_mm", "shift_deg", "pronation_deg")
        if self.pronation_share > 1.0:
            raise InputError("electrodes.pronation_share", f"{self.pronation_share:g}", "0 to 1")
        names = [point.muscle for point in self.motor_points]
        if not names or len(set(names)) < len(names):
            raise InputError("electrodes.motor_points", ", ".join(names) or "none",
                             "one or more, each muscle once")
        for point in self.motor_points:
            if point.along_mm > self.length_mm:
                raise InputError(f"electrodes.motor_points {point.muscle}.along_mm", f"{point.along_mm:g}",
                                 f"at most length_mm, {self.length_mm:g}")
        self._require_arrays()
        if self.threshold:
            require_shape("electrodes", self, (len(MUSCLES),), "one a muscle", "threshold")
            require_positive("electrodes", self, "threshold")
        if self.skin_gain:
            require_shape("electrodes", self, (self.elements,), "one an element", "skin_gain")
            require_not_negative("electrodes", self, "skin_gain")

    def _require_arrays(self) -> None:
        """Raise InputError for arrays that do not fit on the forearm."""
        if not self.arrays:
            raise InputError("electrodes.arrays", "none", "one or more")
        girth_mm = 2.0 * math.pi * self.radius_mm
        for number, array in enumerate(self.arrays):
            if array.rows * array.pitch_mm[0] > girth_mm:
                raise InputError(f"electrodes.arrays[{number}]",
                                 f"{array.rows} rows of {array.pitch_mm[0]:g} mm around a forearm",
                                 f"{girth_mm:.0f} mm at most, its girth at radius_mm {self.radius_mm:g}")
        along = self.places[:, ALONG]
        if along.min() < 0.0 or along.max() > self.length_mm:
            element = int(np.argmax((along < 0.0) | (along > self.length_mm)))
            raise InputError("electrodes.arrays",
                             f"element {element} lies {along[element]:g} mm from the elbow",
                             f"0 to length_mm, {self.length_mm:g}")

    @property
    def elements(self) -> int:
        """Number of elements of all arrays."""
        return sum(array.elements for array in self.arrays)

    @property
    def places(self) -> Array:
        """Displaced elements (elements, 3): place around the forearm, along it, and size, mm."""
        shift = math.radians(self.shift_deg) * self.radius_mm, self.shift_mm, 0.0
        return np.concatenate([array.places(self.radius_mm) for array in self.arrays]) + shift

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Pulses of the elements, forearm rotation, skin, displacement of the arrays."""
        return (Port("elements", (self.elements, 3), "A,s,Hz", every=True),
                Port("posture", (), "rad", math.radians(self.pronation_deg), optional=True),
                Port("skin", (self.elements,), "1", 1.0, optional=True),
                Port("shift", (2,), "m", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Recruitment and frequency of the muscles."""
        return Port("recruitment", (len(MUSCLES),), "1"), Port("frequency", (len(MUSCLES),), "Hz")

    def init(self, context: Context) -> ElectrodesState:
        """State with the axons of this person, or of this run."""
        points, count = self.motor_points, self.axons.count
        seed = context.seed if self.axon_seed is None else self.axon_seed
        axons = self.axons.draw(points, self.radius_mm, seed, context.name).reshape(-1, 4)
        if self.threshold:
            factors = [self.threshold[muscle(point.muscle)] for point in points]
            axons[:, THRESHOLD] *= np.repeat(factors, count)
        share = self.pronation_share * self.radius_mm / self.length_mm
        turns = np.repeat([share * point.along_mm for point in points], count)
        muscles = np.array([muscle(point.muscle) for point in points])
        forearm = Forearm(
            np.column_stack((axons, turns)), muscles, 2.0 * math.pi * self.radius_mm, self.reference_mm,
            1e-6 * self.chronaxie_us)
        period_s = context.clock.period_s if context.clock is not None else 0.0
        return ElectrodesState.of(forearm, period_s, self.places, self._own_gains())

    def _own_gains(self) -> Array:
        return np.array(self.skin_gain, dtype=np.float64) if self.skin_gain else np.ones(self.elements)

    def step(self, state: ElectrodesState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Recruitment after the pulses of one tick."""
        elements, posture, skin, shift = inputs
        self._turn(state, cast(float, posture.value), tick)
        if skin.arrived_ns > state.skin_ns:
            self._take_skin(state, skin, tick)
        if shift.arrived_ns > state.shift_ns:
            self._take_shift(state, shift, tick)
        if elements.arrived_ns > state.newest_ns:
            state.newest_ns = elements.arrived_ns
            pulses = cast(Array, elements.value)
            hertz = self._checked_frequency(state, pulses, tick)
            if hertz > 0.0:
                turn = state.rotation * math.radians(self.posture_step_deg)
                state.excite(pulses, hertz, turn, tick.time_ns)
        return state.recruited(tick.time_ns)

    def _turn(self, state: ElectrodesState, posture: float, tick: Tick) -> None:
        """Discard the field if the forearm has turned by a step or more."""
        sound = math.isfinite(posture)
        state.latch.put(tick, "bad_posture", not sound, "not finite: the last good one holds")
        if sound:
            rotation = round(math.degrees(posture) / self.posture_step_deg)
            if rotation != state.rotation:
                state.rotation = rotation
                state.known[:] = False

    def _take_shift(self, state: ElectrodesState, shift: Sample, tick: Tick) -> None:
        """Move the elements, and discard the field if their displacement is new."""
        state.shift_ns = shift.arrived_ns
        offset = cast(Array, shift.value)
        sound = True
        if offset.tobytes() != state.shift.tobytes():
            places = self.places + 1e3 * np.array([*offset, 0.0])
            along = places[:, ALONG]
            sound = is_finite(places) and along.min() >= 0.0 and along.max() <= self.length_mm
            if sound:
                state.shift, state.places = offset, places
                state.known[:] = False
        state.latch.put(tick, "bad_shift", not sound,
                        "not finite, or beyond the forearm's ends: the last good one holds")

    def _take_skin(self, state: ElectrodesState, skin: Sample, tick: Tick) -> None:
        """Apply new factors; faulty ones are reported and ignored."""
        state.skin_ns = skin.arrived_ns
        factors = cast(Array, skin.value)
        sound = is_finite(factors) and bool((factors >= 0.0).all())
        state.latch.put(tick, "bad_skin", not sound,
                        "a factor is negative or not finite: the last good ones hold")
        if sound:
            state.gains = self._own_gains() * factors

    def _checked_frequency(self, state: ElectrodesState, pulses: Array, tick: Tick) -> float:
        """Frequency of the pulses of a message, Hz; 0 if there are none or one is faulty."""
        faulty, hertz = find_active(pulses, state.active)
        missed = hertz * state.period_ns > NS_PER_S + hertz
        if faulty >= 0 or missed or state.latch.holding:
            latch = state.latch
            latch.put(tick, "bad_input", faulty >= 0, f"element {faulty}: no pulse of the message is given")
            latch.put(tick, "pulses_missed", missed, f"{hertz:g} pulses a second, more than ticks")
        return hertz

"""`electrodes`: arrays on a forearm, from pulses of their elements to recruitment of muscles."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import plain, require_not_negative, require_positive, require_shape
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Value, is_finite
from fesloop.models.electrode_arrays import USUAL, USUAL_RADIUS_MM, ElectrodeArray, ElectrodeArrays
from plants.electrodes.axons import (
    ALONG,
    AROUND,
    DEPTH,
    MOTOR_POINTS,
    SIZE,
    THRESHOLD,
    TURN,
    AxonScatter,
    MotorPoint,
)

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
CURRENT, WIDTH, FREQUENCY = range(3)
"""Columns of pulses: current, A, pulse width, s, and stimulation frequency, Hz."""


@compiled
def find_active(pulses: Array, active: Flags) -> tuple[int, float]:
    """Fill `active` (elements,) from pulses (elements, 3); first faulty element, -1 for none, and frequency.

    An active element has current and width; a pulse is faulty if it is negative, not finite or without a
    frequency.
    """
    hertz = 0.0
    for e in range(pulses.shape[0]):
        active[e] = pulses[e, CURRENT] != 0.0 and pulses[e, WIDTH] != 0.0
        if active[e]:
            for k in range(3):
                if not 0.0 < pulses[e, k] < math.inf:
                    return e, 0.0
            hertz = max(hertz, pulses[e, FREQUENCY])
    return -1, hertz


@compiled
def field_row(
    element: Array, axons: Array, turn: float, circumference_mm: float, unit: float, row: Array
) -> None:
    """Fill `row` (axons,): effective current at each axon, relative to its threshold, for 1 mA of an element.

    The field is (unit / (d^2 + r^2 + a^2))^1.5 at depth d and distance r on the unrolled skin, with the pad's
    size a: a greater pad spreads its current. `unit`, mm^2: that sum where the field is 1. `element` (3,),
    `axons` (axons, 5): see `plants.electrodes.axons`; `turn`: forearm rotation, rad.
    """
    pad = element[SIZE] * element[SIZE]
    for i in range(axons.shape[0]):
        around = abs(axons[i, AROUND] + turn * axons[i, TURN] - element[AROUND]) % circumference_mm
        around = min(around, circumference_mm - around)
        along = axons[i, ALONG] - element[ALONG]
        share = unit / (axons[i, DEPTH] * axons[i, DEPTH] + around * around + along * along + pad)
        row[i] = share * math.sqrt(share) / axons[i, THRESHOLD]


@compiled
def fill_rows(
    active: Flags, known: Flags, places: Array, axons: Array, turn: float, circumference_mm: float,
    unit: float, field: Array
) -> None:
    """Fill the unknown rows of `field` (elements, axons) of active elements."""
    for e in range(places.shape[0]):
        if active[e] and not known[e]:
            field_row(places[e], axons, turn, circumference_mm, unit, field[e])
            known[e] = True


@compiled
def fire(pulses: Array, skin: Array, active: Flags, field: Array, chronaxie_s: Array, fired: Flags) -> None:
    """Fill `fired` (axons,): whether simultaneous `pulses` (elements, 3) excite each axon.

    An element's effective current is I / (1 + chronaxie / pulse width), times the `skin` gain (elements,);
    `chronaxie_s` (muscles,), of equally many axons each.
    """
    drive = np.zeros(field.shape[1])
    count = drive.size // chronaxie_s.size
    for e in range(pulses.shape[0]):
        if active[e]:
            row = field[e]
            for m in range(chronaxie_s.size):
                effective = 1e3 * skin[e] * pulses[e, CURRENT] / (1.0 + chronaxie_s[m] / pulses[e, WIDTH])
                for i in range(m * count, (m + 1) * count):
                    drive[i] += effective * row[i]
    for i in range(drive.size):
        fired[i] = drive[i] >= 1.0


@compiled
def recruit_muscles(
    fired: Flags, hertz: Array, muscles: NDArray[np.int64], shares: Array, recruitment: Array,
    frequency: Array
) -> None:
    """Fill `recruitment` and `frequency` of the `muscles` that have axons, from the groups that count.

    `fired` (groups, axons), `hertz` (groups,), 0 for a group that no longer counts; `shares`, of each axon of
    a muscle in its force. Recruitment is the share of a muscle's force whose axons any group fires; frequency
    is their mean rate, where an axon fired by several groups has the sum of their rates.
    """
    rate = np.zeros(fired.shape[1])
    for g in range(hertz.size):
        if hertz[g] > 0.0:
            row, share = fired[g], hertz[g]
            for i in range(rate.size):
                rate[i] += share * row[i]
    for m in range(muscles.size):
        recruited, total = 0.0, 0.0
        for k in range(shares.size):
            hz = rate[m * shares.size + k]
            if hz > 0.0:
                recruited += shares[k]
                total += shares[k] * hz
        if recruited > 0.0:
            recruitment[muscles[m]] = min(recruited, 1.0)
            frequency[muscles[m]] = total / recruited


@compiled
def excite_through(
    pulses: Array, fresh: Flags, times_ns: NDArray[np.int64], first: int, period_ns: float, places: Array,
    axons: Array, turn: float, circumference_mm: float, unit: float, muscles: NDArray[np.int64],
    shares: Array, chronaxie_s: Array, skin: Array, active: Flags, known: Flags, fields: Array, fired: Flags,
    until_ns: Array, hertz: Array, recruitment: Array, frequency: Array,
) -> int:
    """Do the ticks from `first` on, of those at `times_ns` (n,); `fresh` (n,) where pulses are new.

    `pulses` (n, elements, 3). Fills `recruitment` and `frequency` (n, all muscles), and updates the arrays of
    `ElectrodesState`. Returns the first tick that it leaves to the caller: one with a faulty or too frequent
    pulse, one for which there is no free group, or n.
    """
    counting = np.empty(hertz.size)
    for k in range(first, times_ns.size):
        now = times_ns[k]
        if fresh[k]:
            faulty, rate = find_active(pulses[k], active)
            if faulty >= 0 or rate * period_ns > NS_PER_S + rate:
                return k
            if rate > 0.0:
                group = -1
                for g in range(until_ns.size):
                    if until_ns[g] <= now:
                        group = g
                        break
                if group < 0:
                    return k
                fill_rows(active, known, places, axons, turn, circumference_mm, unit, fields)
                fire(pulses[k], skin, active, fields, chronaxie_s, fired[group])
                until_ns[group] = now + max(NS_PER_S / rate, period_ns) - 0.5 * period_ns
                hertz[group] = rate
        for g in range(hertz.size):
            counting[g] = hertz[g] if until_ns[g] > now else 0.0
        recruitment[k] = 0.0
        frequency[k] = 0.0
        recruit_muscles(fired, counting, muscles, shares, recruitment[k], frequency[k])
    return times_ns.size


class Forearm(NamedTuple):
    """Constants of a forearm; never written to.

    Attributes
    ----------
    axons: (axons, 5), in the order of muscles, in neutral rotation; columns as in `plants.electrodes.axons`.
    muscles: numbers of the muscles that have axons.
    shares: (axons of a muscle,), share of each in the muscle's force.
    circumference_mm: circumference of the forearm.
    unit: square of depth and pad's size, mm^2, where the field is 1.
    chronaxie_s: (muscles that have axons,), chronaxie of their axons.
    """

    axons: Array
    muscles: NDArray[np.int64]
    shares: Array
    circumference_mm: float
    unit: float
    chronaxie_s: Array


@dataclass(slots=True, eq=False)
class ElectrodesState:
    """State of the electrodes: cached field and recent pulses.

    Attributes
    ----------
    forearm: constants of the forearm.
    period_ns: period of the block's clock.
    places: (elements, 3), around the forearm, along it, size, mm; never written to.
    shift: (2,), m, displacement of the arrays around and along; never written to.
    gains: (elements,), fraction of the current that passes the skin; never written to.
    fields: (elements, axons), rows of `field_row`, computed when an element is first active.
    known: (elements,), whether each row is computed.
    active: (elements,), buffer for the active elements of the newest pulses.
    fired: (groups, axons), axons that each group of simultaneous pulses fired.
    until_ns: (groups,), instant until which each group counts.
    hertz: (groups,), stimulation frequency of each group.
    rotation: steps of forearm rotation to which the field applies.
    newest_ns, skin_ns, shift_ns: arrival of the newest pulses, skin factors, and shift.
    """

    forearm: Forearm
    period_ns: float
    places: Array
    gains: Array
    fields: Array
    known: Flags
    active: Flags
    fired: Flags
    until_ns: Array
    hertz: Array
    shift: Array = field(default_factory=lambda: np.zeros(2))
    rotation: int = 0
    newest_ns: int = NEVER
    skin_ns: int = NEVER
    shift_ns: int = NEVER
    latch: StatusLatch = field(default_factory=StatusLatch)

    @classmethod
    def of(cls, forearm: Forearm, period_s: float, places: Array, gains: Array) -> ElectrodesState:
        """State before the first pulse."""
        elements, axons = len(places), len(forearm.axons)
        return cls(
            forearm, period_s * NS_PER_S, places, gains, np.empty((elements, axons)),
            np.zeros(elements, np.bool_), np.zeros(elements, np.bool_), np.zeros((1, axons), np.bool_),
            np.array([float(NEVER)]), np.zeros(1))

    def excite(self, pulses: Array, hertz: float, turn: float, now_ns: int) -> None:
        """Fire axons by simultaneous pulses (elements, 3) of the active elements; `turn` in rad.

        They count until the next pulse of their train is due, less half a tick, as that pulse may come 1 ns
        early or late.
        """
        forearm = self.forearm
        fill_rows(self.active, self.known, self.places, forearm.axons, turn, forearm.circumference_mm,
                  forearm.unit, self.fields)
        group = self._free_group(now_ns)
        fire(pulses, self.gains, self.active, self.fields, forearm.chronaxie_s, self.fired[group])
        self.until_ns[group] = now_ns + max(NS_PER_S / hertz, self.period_ns) - 0.5 * self.period_ns
        self.hertz[group] = hertz

    def _free_group(self, now_ns: int) -> int:
        """Index of a group that no longer counts, or of a new one."""
        for group, until_ns in enumerate(self.until_ns.tolist()):
            if until_ns <= now_ns:
                return group
        self.fired = np.concatenate((self.fired, np.zeros_like(self.fired[:1])))
        self.until_ns = np.append(self.until_ns, float(NEVER))
        self.hertz = np.append(self.hertz, 0.0)
        return len(self.hertz) - 1

    def recruited(self, now_ns: int) -> tuple[Array, Array]:
        """Recruitment and frequency, Hz, of all muscles, (muscles,) each."""
        hertz = np.where(self.until_ns > now_ns, self.hertz, 0.0)
        recruitment, frequency = np.zeros(len(MUSCLES)), np.zeros(len(MUSCLES))
        recruit_muscles(self.fired, hertz, self.forearm.muscles, self.forearm.shares, recruitment, frequency)
        return recruitment, frequency


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
    `fesloop.hand.movements`: `recruitment` (29,), share of the force whose axons fire, 0 to 1,
    0 for muscles of the hand;
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
    reference_mm, reference_pad_mm: the field is 1 at this depth under a pad of this size.
    chronaxie_us: chronaxie of the axons: mean of three muscles of one person (docs/models/people.md).
    chronaxie: factors on the chronaxie of the muscles' axons, in the order of `MUSCLES`; empty: 1.
    pronation_deg: pronation of the forearm since the arrays were put on, if `posture` has no wire; the hand's
        own forearm orientation has no effect here.
    pronation_share: fraction of forearm rotation that a motor point at the wrist follows; others in
        proportion to their distance from the elbow. Pronation moves them towards the radial side (chosen such
        that torque changes with posture as in people: docs/models/people.md).
    posture_step_deg: step of forearm rotation at which the field is computed again (chosen).
    shift_mm, shift_deg: displacement of the arrays, towards the wrist and towards the radial side.
    skin_gain: fraction of each element's current that passes the skin; empty: 1.
    """

    arrays: tuple[ElectrodeArray, ...] = USUAL
    motor_points: tuple[MotorPoint, ...] = MOTOR_POINTS
    axons: AxonScatter = _AXONS
    axon_seed: int | None = None
    threshold: tuple[float, ...] = ()
    radius_mm: float = USUAL_RADIUS_MM
    length_mm: float = 260.0
    reference_mm: float = 10.0
    reference_pad_mm: float = 7.0
    chronaxie_us: float = 122.0
    chronaxie: tuple[float, ...] = ()
    pronation_deg: float = 0.0
    pronation_share: float = 0.8
    posture_step_deg: float = 1.0
    shift_mm: float = 0.0
    shift_deg: float = 0.0
    skin_gain: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_positive("electrodes", self, "radius_mm", "length_mm", "reference_mm", "chronaxie_us",
                         "posture_step_deg")
        require_not_negative("electrodes", self, "pronation_share", "reference_pad_mm")
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
        for factors in ("threshold", "chronaxie"):
            if getattr(self, factors):
                require_shape("electrodes", self, (len(MUSCLES),), "one a muscle", factors)
                require_positive("electrodes", self, factors)
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
        return np.concatenate([array.pads(self.radius_mm) for array in self.arrays]) + shift

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

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, Any]:
        """The arrays themselves."""
        return {"arrays": plain(arrays.arrays)}

    def of_arrays(self) -> list[tuple[str, str]]:
        """Elements of each array, and where they lie on this forearm."""
        rows, first = [], 0
        for number, array in enumerate(self.arrays):
            places = self.places[first:first + array.elements]
            degrees = np.degrees(places[:, AROUND] / self.radius_mm)
            rows.append((f"array {number}", f"elements {first} to {first + array.elements - 1}: "
                         f"{array.in_words()}, pads of {array.pad_mm:g} mm radius, {degrees.min():.0f} to "
                         f"{degrees.max():.0f} deg, {places[:, ALONG].min():.0f} to "
                         f"{places[:, ALONG].max():.0f} mm from the elbow"))
            first += array.elements
        return rows

    def init(self, context: Context) -> ElectrodesState:
        """State with the axons of this person, or of this run."""
        points, count = self.motor_points, self.axons.total
        seed = context.seed if self.axon_seed is None else self.axon_seed
        axons = self.axons.draw(points, self.radius_mm, seed, context.name).reshape(-1, 4)
        muscles = np.array([muscle(point.muscle) for point in points])
        if self.threshold:
            axons[:, THRESHOLD] *= np.repeat(np.array(self.threshold)[muscles], count)
        chronaxie = np.array(self.chronaxie)[muscles] if self.chronaxie else np.ones(len(points))
        share = self.pronation_share * self.radius_mm / self.length_mm
        turns = np.repeat([share * point.along_mm for point in points], count)
        forearm = Forearm(
            np.column_stack((axons, turns)), muscles, self.axons.shares, 2.0 * math.pi * self.radius_mm,
            self.reference_mm**2 + self.reference_pad_mm**2, 1e-6 * self.chronaxie_us * chronaxie)
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

    def steps_through(self, state: ElectrodesState, inputs: Sequence[Sequence[Sample]], ticks: Sequence[Tick]
                      ) -> tuple[Array, Array]:
        """Recruitment after the pulses of each tick."""
        count = len(ticks)
        recruitment, frequency = np.empty((2, count, len(MUSCLES)))
        times = np.array([tick.time_ns for tick in ticks])
        arrived = np.array([state.newest_ns, *[sample.arrived_ns for sample in inputs[0]]])
        fresh = arrived[1:] > arrived[:-1]
        pulses = np.array([sample.value for sample in inputs[0]])
        done = 0
        while done < count:
            if self._ordinary(state, inputs, done, count):
                done = self._excite(state, pulses, fresh, times, done, recruitment, frequency)
                state.newest_ns = max(state.newest_ns, int(arrived[done]))
            if done < count:
                samples = [column[done] for column in inputs]
                recruitment[done], frequency[done] = self.step(state, samples, ticks[done])
                done += 1
        return recruitment, frequency

    def _excite(self, state: ElectrodesState, pulses: Array, fresh: Flags, times_ns: NDArray[np.int64],
                first: int, recruitment: Array, frequency: Array) -> int:
        """Do ticks from `first` on; return the first that is left to `step`."""
        forearm = state.forearm
        done: int = excite_through(
            pulses, fresh, times_ns, first, state.period_ns, state.places, forearm.axons,
            state.rotation * math.radians(self.posture_step_deg), forearm.circumference_mm, forearm.unit,
            forearm.muscles, forearm.shares, forearm.chronaxie_s, state.gains, state.active, state.known,
            state.fields, state.fired, state.until_ns, state.hertz, recruitment, frequency)
        return done

    def _ordinary(self, state: ElectrodesState, inputs: Sequence[Sequence[Sample]], first: int, stop: int
                  ) -> bool:
        """Whether pulses alone change in these ticks, and no status holds."""
        _, posture, skin, shift = inputs
        return not state.latch.holding and all(
            skin[k].arrived_ns <= state.skin_ns and shift[k].arrived_ns <= state.shift_ns
            and math.isfinite(turn := cast(float, posture[k].value))
            and round(math.degrees(turn) / self.posture_step_deg) == state.rotation
            for k in range(first, stop))

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

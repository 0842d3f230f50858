"""`grip_force`: control of the force on a held object, as muscles tire."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.force_sensors import require_count, wired_places
from controllers.pid.tuning import Gains, Lag, simc
from controllers.timing import period_ns
from fesloop.errors import InputError
from fesloop.hand.grip import grip_force, require_places
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.abilities import AgeLimit
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Sensors, Value, is_finite

Array = NDArray[np.float64]
_LOST = 0.5
"""Share of the force at contact below which contact is lost (chosen: noise does not cross both)."""


@dataclass(slots=True, eq=False)
class Trembling:
    """Turning points of the forces of k sensors.

    Attributes
    ----------
    extreme: (k,), N, greatest force since it turned to rise, or least since it turned to fall.
    heading: (k,), 1 where a force rises, -1 where it falls, 0 before it has changed.
    turned_ns: (k, n), instants of the last n turns, newest first; NEVER where there were fewer.
    """

    extreme: Array
    heading: Array
    turned_ns: NDArray[np.int64]


@dataclass(slots=True, eq=False)
class Touch:
    """State of the detection.

    Attributes
    ----------
    holding: whether an object is held.
    since_ns: instant from which forces contradict `holding`; NEVER while they agree.
    trembling: turning points of the forces; None before the first sample.
    taken_ns: capture of the last sample.
    raised: factor by which slips have raised the target force.
    raised_ns: instant of the last rise.
    """

    holding: bool = False
    since_ns: int = NEVER
    trembling: Trembling | None = None
    taken_ns: int = NEVER
    raised: float = 1.0
    raised_ns: int = NEVER

    def let_go(self) -> None:
        """Set to nothing held."""
        self.holding, self.since_ns, self.raised = False, NEVER, 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Limits beyond which an object counts as held.

    Attributes
    ----------
    force_n, lasts_ms: grip force, and its duration, above which contact begins (chosen: ten times the offset
        of a thin resistive sensor; four periods of 25 ms).
    lost_ms: duration below half of that force after which contact ends (chosen: longer than a finger
        bounces).
    """

    force_n: float = 0.5
    lasts_ms: float = 100.0
    lost_ms: float = 300.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.force_n) and self.force_n > 0.0):
            raise InputError("contact.force_n", f"{self.force_n}", "a finite force above 0")
        for key in ("lasts_ms", "lost_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, f"contact.{key}")

    @property
    def lost_n(self) -> float:
        """Force below which contact is lost, N."""
        return _LOST * self.force_n

    def look(self, touch: Touch, grip_n: float, now_ns: int) -> None:
        """Update in `touch` whether an object is held."""
        against = grip_n < self.lost_n if touch.holding else grip_n > self.force_n
        if not against:
            touch.since_ns = NEVER
            return
        if touch.since_ns < 0:
            touch.since_ns = now_ns
        if now_ns - touch.since_ns >= (self.lost_ms if touch.holding else self.lasts_ms) * NS_PER_MS:
            touch.holding, touch.since_ns = not touch.holding, NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class Slip:
    """Limits beyond which an object slips: it sticks and slides by turns, and a force on it trembles.

    A force trembles while it turns `turns` times within `within_ms`, from rising to falling or back, by more
    than `change_n` each time. A force that rises with its target, one that another part of the hand takes
    over, and the slow swing of a loop that settles turn less often. Slips call for a firmer grip (Westling
    and Johansson 1984, doi 10.1007/BF00238156).

    Attributes
    ----------
    change_n: least change of a force between two turns (chosen: that of a sensor that flickers at its
        threshold of .1 N, with a noise of .02 N, is below .2).
    turns, within_ms: number of turns, and duration in which they happen (chosen: two periods of 10 Hz, beyond
        the bandwidth of muscles).
    raise_by: factor on the target force for each slip (chosen).
    pause_ms: least time between two rises (chosen: response time of the force).
    """

    change_n: float = 0.25
    turns: int = 4
    within_ms: float = 200.0
    raise_by: float = 1.15
    pause_ms: float = 300.0

    def __post_init__(self) -> None:
        if not self.change_n > 0.0:
            raise InputError("slip.change_n", f"{self.change_n}", "above 0; inf for no reaction to slips")
        if self.turns < 1:
            raise InputError("slip.turns", f"{self.turns}", "1 or more")
        if not (math.isfinite(self.raise_by) and self.raise_by >= 1.0):
            raise InputError("slip.raise_by", f"{self.raise_by}", "1 or more")
        for key in ("within_ms", "pause_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, f"slip.{key}")

    def record(self, touch: Touch, force: Array, taken_ns: int) -> int | None:
        """Record a sample (k,), N; return the number of a sensor whose force trembles, or None."""
        if touch.trembling is None:
            touch.trembling = Trembling(force.copy(), np.zeros(force.size),
                                        np.full((force.size, self.turns), NEVER))
        each = touch.trembling
        if taken_ns > touch.taken_ns:
            touch.taken_ns = taken_ns
            change = force - each.extreme
            turned = (np.abs(change) > self.change_n) & (change * each.heading <= 0.0)
            counted = turned & (each.heading != 0.0)
            each.turned_ns[counted, 1:] = each.turned_ns[counted, :-1]
            each.turned_ns[counted, 0] = taken_ns
            each.heading[turned] = np.sign(change[turned])
            onwards = change * each.heading > 0.0
            each.extreme[onwards] = force[onwards]
        first_ns = each.turned_ns[:, -1]
        newest = int(np.argmax(first_ns))
        trembles = first_ns[newest] >= 0 and touch.taken_ns - first_ns[newest] < self.within_ms * NS_PER_MS
        return newest if trembles else None

    def react(self, touch: Touch, now_ns: int) -> bool:
        """Raise the target after a slip, unless that has just been done; return whether it is raised."""
        if touch.raised_ns >= 0 and now_ns - touch.raised_ns < self.pause_ms * NS_PER_MS:
            return False
        touch.raised, touch.raised_ns = touch.raised * self.raise_by, now_ns
        return True


_LEAST_S = 1e-9
"""Shortest pulse (chosen: a thousandth of a device's step)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceLoop:
    """PI control of ln(force) by ln(scale), the scale that of pulse widths.

        e = ln(wanted / force)        ln s = kp e + I        I[k+1] = I[k] + (kp h / Ti) e

    I stays constant where s would leave its limits. Force is a power of pulse width over most of a
    recruitment curve, so that in logarithms the loop's gain is the same for weak and strong muscles, and
    stays so while they tire.

    Attributes
    ----------
    exponent: that power (chosen: 1 to 5 between threshold and saturation).
    lag_ms: lag of force behind pulse width (activation of 16 rad/s rises from 10 to 90 % in 210 ms).
    delay_ms: delay of force behind pulse width, with the age of the samples (electromechanical 40 ms, and two
        periods of 25 ms).
    scale_min, scale_max: limits of s (chosen).
    """

    exponent: float = 3.0
    lag_ms: float = 210.0
    delay_ms: float = 90.0
    scale_min: float = 0.3
    scale_max: float = 2.0

    def __post_init__(self) -> None:
        for key in ("exponent", "lag_ms"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"loop.{key}", f"{value}", "a finite number above 0")
        duration_ns(self.delay_ms, NS_PER_MS, "loop.delay_ms")
        if not 0.0 < self.scale_min <= 1.0 <= self.scale_max < math.inf:
            raise InputError("loop.scale_max", f"{self.scale_min:g} to {self.scale_max:g}", "around 1")

    @property
    def span(self) -> float:
        """Least and greatest ln s."""
        return math.log(self.scale_max / self.scale_min)

    def gains(self, period_s: float) -> Gains:
        """Gains by Skogestad's rule (`controllers.pid.tuning.simc`), with half a period in the delay."""
        delay_s = 1e-3 * self.delay_ms + 0.5 * period_s
        return simc(Lag(self.exponent, 1e-3 * self.lag_ms, delay_s), delay_s)

    def next(self, gains: Gains, period_s: float, integral: float, error: float,
             highest: float) -> tuple[float, float]:
        """Pair of ln s and the next I for an error; ln s is at most `highest`, if its limits allow that."""
        low = math.log(self.scale_min)
        high = max(min(math.log(self.scale_max), highest), low)
        wanted = gains.kp * error + integral
        growth = gains.kp * period_s / gains.integral_s * error
        if low < wanted < high or (wanted >= high and growth < 0.0) or (wanted <= low and growth > 0.0):
            integral += growth
        return min(max(wanted, low), high), integral


def longest_s(current: Array, width_max_us: float, charge_max_uc: float) -> Array:
    """Longest pulses (channels,), s, at currents (channels,), A, within a width and a charge per phase."""
    widths = np.full(current.shape, 1e-6 * width_max_us)
    np.divide(1e-6 * charge_max_uc, current, out=widths, where=current * widths > 1e-6 * charge_max_uc)
    return widths


def useful_scale(widths_s: Array, longest: Array) -> float:
    """Value of ln s above which all channels are at their `longest` pulses (channels,), s; 0 for none."""
    on = widths_s > _LEAST_S
    return math.log(float((longest[on] / widths_s[on]).max())) if on.any() else 0.0


_CONTACT, _SLIP, _LOOP = Contact(), Slip(), ForceLoop()
_POSITIVE = ("target_n", "mass_kg", "friction", "margin", "force_max_n", "rise_n_per_s", "width_max_us",
             "charge_max_uc", "ramp_ms")
_TROUBLES = ("no_force", "stale_force", "non_finite_force", "implausible_force", "no_reference")
_IMPLAUSIBLE_N = 1000.0
"""Greatest plausible force of a sensor (chosen: twice the strongest grip as a whole)."""
_OPENING = 0.9
"""Fraction of the pulse widths that closed the hand below which posture control counts as opening it (chosen:
widths change by less while it holds)."""


@dataclass(slots=True, eq=False)
class GripForceState:
    """State of the controller, with the coefficients that follow from its clock.

    Attributes
    ----------
    gains, period_s: constant coefficients.
    touch: contact as the forces show it.
    widths_s: (channels,), pulse widths at the hand-over; None while nothing is held.
    log_scale, integral: ln s of the closing channels' pulse widths, and its integral part.
    target_n: present target of the force; 0 while nothing is held.
    handed_ns: instant of the hand-over from posture control.
    rising: whether `target_n` has not reached its end.
    closing: whether the hand may still close on the object: `target_n` has not reached its end since the
        hand-over.
    closed_s: sum of the input's pulse widths of the closing channels when it was last `closing`.
    """

    gains: Gains
    period_s: float
    touch: Touch = field(default_factory=Touch)
    widths_s: Array | None = None
    log_scale: float = 0.0
    integral: float = 0.0
    target_n: float = 0.0
    handed_ns: int = NEVER
    rising: bool = False
    closing: bool = False
    closed_s: float = 0.0
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class GripForce:
    """PI control of grip force by the pulse widths of the channels that close the hand.

    It is wired between posture control and `safety`. Its input passes unchanged until the grip force
    (`fesloop.hand.grip.grip_force`) shows that something is held. From then on the closing channels have
    their pulse widths of that instant, or the input's where these are less, times a scale s, by which `loop`
    controls the force. There is no jump: `target` starts from the force at the hand-over. While posture
    control releases the object, s does not rise: its pulse widths have fallen by a tenth since `target` was
    first reached; before, the hand may still be closing, and they may fall. Where a force trembles
    as under a slipping object while nothing else changes it, `target` is raised. When contact is lost, s
    returns to 1 within `ramp_ms`.

    Attributes
    ----------
    channels: their number; 0 takes it from the wire.
    places: parts of the hand that the force sensors are on, such as "palm" and "F1d"; empty: as their block
        states. What touches other parts is not felt: `grip` is then at most the force between the hand and
        the object.
    closing: numbers of the channels that close the hand; empty: all.
    target_n: grip force, N.
    mass_kg: mass of the object, in place of `target_n`: `margin` mass_kg 9.80665 / (2 `friction`). Without
        both, `reference` must be wired.
    friction: friction between skin and object (chosen: the low end of .5 to 1 for skin on plastics).
    margin: safety factor on the force (chosen).
    force_max_n: greatest target, slips included (chosen: within the range of sensors, 25 N).
    rise_n_per_s: rate of change of `target` (chosen).
    contact, slip: limits beyond which an object counts as held, and as slipping.
    loop: control of the force by s.
    set_within_s: duration for which the force is controlled, after which s stays constant and slips change
        nothing, as on a stimulator that is set once; 0: as long as something is held.
    width_max_us, charge_max_uc: limits of every channel, on the input too.
    max_age_ms: greatest age of `force`.
    ramp_ms: duration in which s returns to 1.

    Inputs: `stimulation` (channels, 2), A and s; `force` (places,), N; optional `reference`, N. Outputs:
    `stimulation` (channels, 2); `grip`, N, as measured; `target`, N; `scale`. With forces that are missing,
    too old, not finite or above 1000 N nothing counts as held: the input passes unchanged, with a status.
    With stimulation that is missing or not finite the output is zero, with a status.
    """

    channels: int = 0
    places: tuple[str, ...] = ()
    closing: tuple[int, ...] = ()
    target_n: float | None = None
    mass_kg: float | None = None
    friction: float = 0.5
    margin: float = 1.5
    force_max_n: float = 20.0
    rise_n_per_s: float = 4.0
    contact: Contact = _CONTACT
    slip: Slip = _SLIP
    loop: ForceLoop = _LOOP
    set_within_s: float = 0.0
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    max_age_ms: float = 200.0
    ramp_ms: float = 300.0

    def __post_init__(self) -> None:
        if self.channels < 0:
            raise InputError("channels", f"{self.channels}", "1 or more, or 0 to take it from the wire")
        require_places(self.places, "places")
        if len(set(self.closing)) < len(self.closing) or not all(
                0 <= number < (self.channels or math.inf) for number in self.closing):
            raise InputError("closing", f"{self.closing}", "numbers of channels, from 0 on, each once")
        for key in _POSITIVE:
            value = getattr(self, key)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise InputError(key, f"{value}", "a finite number above 0")
        duration_ns(self.max_age_ms, NS_PER_MS, "max_age_ms")
        duration_ns(self.set_within_s, NS_PER_S, "set_within_s")
        if self.target_n is not None and self.mass_kg is not None:
            raise InputError("target_n", "is given together with mass_kg", "one of the two", "remove one")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation`, `force`, `reference`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"),
                Port("force", (len(self.places) or None,), "N"), Port("reference", (), "N", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`, `grip`, `target`, `scale`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"), Port("grip", (), "N"),
                Port("target", (), "N"), Port("scale", (), "1", 1.0))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> GripForce:
        """The block for the wired channels; raises InputError for numbers beyond them."""
        require_count(self.places, shapes)
        return replace(self, channels=shapes.get("stimulation", (self.channels,))[0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> GripForce:
        """The block for the places of the wired force sensors."""
        return replace(self, places=wired_places(self.places, sources))

    def age_limits(self) -> tuple[AgeLimit, ...]:
        """Age limit of `force`."""
        return (AgeLimit(port="force", limit_ms=self.max_age_ms, since="newest",
                         then="nothing counts as held, and stimulation passes unchanged"),)

    def init(self, context: Context) -> GripForceState:
        """State while nothing is held."""
        period_s = period_ns(context) / NS_PER_S
        return GripForceState(self.loop.gains(period_s), period_s)

    def step(self, state: GripForceState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses of this tick."""
        base, force, reference = inputs
        usable = base.present and is_finite(base.value)
        state.latch.put(tick, "no_stimulation", not usable, "input is missing or not finite: no stimulation")
        pulses = np.maximum(cast(Array, base.value), 0.0) if usable else np.zeros((self.channels, 2))
        target_n = self._target_n(reference)
        trouble = self._trouble(force, target_n, tick.time_ns)
        for status in _TROUBLES:
            state.latch.put(tick, status, status == trouble,
                            "nothing counts as held: stimulation passes unchanged")
        grip_n = 0.0 if trouble else float(grip_force(cast(Array, force.value), self.places))
        if trouble:
            state.touch.let_go()
        else:
            self._look(state, force, grip_n, pulses, tick)
        if state.touch.holding:
            self._regulate(state, grip_n, target_n, pulses, tick.time_ns)
        else:
            state.widths_s, state.target_n = None, 0.0
            back = self.loop.span * 1e3 * state.period_s / self.ramp_ms
            state.log_scale = math.copysign(max(abs(state.log_scale) - back, 0.0), state.log_scale)
        self._scale(state, pulses)
        return pulses, grip_n, state.target_n, math.exp(state.log_scale)

    def _target_n(self, reference: Sample) -> float:
        """Target of the grip force without slips; NaN where none is given."""
        if reference.present:
            return float(cast(float, reference.value))
        if self.mass_kg is not None:
            return self.margin * self.mass_kg * STANDARD_GRAVITY / (2.0 * self.friction)
        return self.target_n if self.target_n is not None else math.nan

    def _trouble(self, force: Sample, target_n: float, now_ns: int) -> str:
        """Status that prevents control; "" for none."""
        sound = {"no_force": force.present,
                 "stale_force": now_ns - force.newest_ns <= self.max_age_ms * NS_PER_MS,
                 "non_finite_force": is_finite(force.value),
                 "implausible_force": not np.abs(force.value).max() > _IMPLAUSIBLE_N,
                 "no_reference": math.isfinite(target_n) and target_n > 0.0}
        return next((status for status, fine in sound.items() if not fine), "")

    def _columns(self) -> list[int]:
        return list(self.closing or range(self.channels))

    def _look(self, state: GripForceState, force: Sample, grip_n: float, pulses: Array, tick: Tick) -> None:
        """Take over at contact, react to slips, and report both."""
        touch, held = state.touch, state.touch.holding
        self.contact.look(touch, grip_n, tick.time_ns)
        trembles = self.slip.record(touch, cast(Array, force.value), force.newest_ns)
        if touch.holding and not held:
            state.widths_s, state.target_n = pulses[:, 1].copy(), min(grip_n, self.force_max_n)
            state.integral, state.handed_ns, state.rising = state.log_scale, tick.time_ns, True
            state.closing = True
            tick.report("contact", f"{grip_n:.2f} N: the force is controlled from now on")
        elif held and not touch.holding:
            touch.let_go()
            tick.report("contact_lost", "stimulation passes unchanged")
        elif trembles is not None and held and not (
                state.rising or self._opens(state, pulses) or self._set(state, tick.time_ns)) and (
                self.slip.react(touch, tick.time_ns)):
            tick.report("slip", f"the force on {self.places[trembles]} turned {self.slip.turns} times within "
                                f"{self.slip.within_ms:g} ms by more than {self.slip.change_n:g} N")

    def _regulate(self, state: GripForceState, grip_n: float, target_n: float, pulses: Array,
                  now_ns: int) -> None:
        """Advance `target_n` and the scale by a tick."""
        assert state.widths_s is not None
        columns = self._columns()
        if state.closing:
            state.closed_s = float(pulses[columns, 1].sum())
        target = min(target_n * state.touch.raised, self.force_max_n)
        reach = self.rise_n_per_s * state.period_s
        state.rising = abs(target - state.target_n) > reach
        state.closing &= state.rising
        state.target_n += min(max(target - state.target_n, -reach), reach)
        if self._set(state, now_ns):
            return
        least = self.contact.force_n
        error = math.log(max(state.target_n, least) / max(grip_n, least))
        longest = longest_s(pulses[columns, 0], self.width_max_us, self.charge_max_uc)
        highest = state.log_scale if self._opens(state, pulses) else useful_scale(
            state.widths_s[columns], longest)
        state.log_scale, state.integral = self.loop.next(state.gains, state.period_s, state.integral, error,
                                                         highest)

    def _set(self, state: GripForceState, now_ns: int) -> bool:
        """Whether s is set once for all."""
        return 0.0 < self.set_within_s * NS_PER_S <= now_ns - state.handed_ns

    def _opens(self, state: GripForceState, pulses: Array) -> bool:
        """Whether posture control opens the hand that it has closed."""
        return not state.closing and bool(pulses[self._columns(), 1].sum() < _OPENING * state.closed_s)

    def _scale(self, state: GripForceState, pulses: Array) -> None:
        """Scale the closing channels of `pulses` (channels, 2) and keep all within their limits, in place."""
        columns = self._columns()
        longest = longest_s(pulses[:, 0], self.width_max_us, self.charge_max_uc)
        np.minimum(pulses[:, 1], longest, out=pulses[:, 1])
        if state.widths_s is not None:
            pulses[columns, 1] = np.minimum(pulses[columns, 1], state.widths_s[columns])
        pulses[columns, 1] *= math.exp(state.log_scale)
        np.minimum(pulses[:, 1], longest, out=pulses[:, 1])

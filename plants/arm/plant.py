"""`arm`: a stimulated arm whose elbow, forearm and wrist a device holds or moves, solved exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive, require_shape
from fesloop.hand.muscle_paths import JOINTS
from fesloop.loop.block import Context
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value
from fesloop.models.arm_people import NOBODY, ArmPeople, ArmPerson, StoredArm
from fesloop.models.arm_responses import FRICTION_NM, ArmResponse, ArmResponses, effective_a
from fesloop.models.evoked_torque import UNDER_ELECTRODES, Postures, features, muscles_under
from plants.muscles.lags import settle_lags

Array = NDArray[np.float64]
CURRENT, WIDTH, FREQUENCY = range(3)
"""Columns of pulses: current, A, pulse width, s, and stimulation frequency, Hz."""
LEAST_HZ = 1.0
"""Frequency below which a pulse lasts no longer (chosen)."""
Joints = tuple[float, float, float, float]


@compiled
def hold(
    levels: Array, drive: Array, lag_s: float, elapsed_s: float, torque: Array, still: Array,
    friction: Array, passed: Array, after: Array, evoked: Array, passed_after: Array
) -> None:
    """Fill `after` (2, e), `evoked` (j,) and `passed_after` (j,) with levels, torque and play after a time.

    Both lags of each electrode have `levels` (2, e), and `drive` (e,) since then; `torque` (e, j) is evoked
    at full activation. The play follows `still` (j,) plus the evoked torque within `friction` (j,), from
    `passed` (j,). All lags are equal: between two changes of the drive the evoked torque of a joint is a
    constant plus (Z + X t / lag) exp(-t / lag), with one extremum at lag (1 - Z / X). The play is exact if it
    passes this and the end.
    """
    lags_s = np.full(drive.size, lag_s)
    settle_lags(levels, drive, lags_s, lags_s, elapsed_s, after)
    for j in range(torque.shape[1]):
        settled, first, second, now = 0.0, 0.0, 0.0, 0.0
        for e in range(drive.size):
            settled += drive[e] * torque[e, j]
            first += (levels[0, e] - drive[e]) * torque[e, j]
            second += (levels[1, e] - drive[e]) * torque[e, j]
            now += after[1, e] * torque[e, j]
        last = passed[j]
        if first != 0.0:
            turn_s = lag_s * (1.0 - second / first)
            if 0.0 < turn_s < elapsed_s:
                turning = still[j] + settled + (second + first * turn_s / lag_s) * math.exp(-turn_s / lag_s)
                last = min(max(last, turning - friction[j]), turning + friction[j])
        evoked[j] = now
        passed_after[j] = min(max(last, still[j] + now - friction[j]), still[j] + now + friction[j])


class ArmState:
    """State of the arm, which changes at its own instants, not at observations.

    Attributes
    ----------
    now_ns: instant that was advanced to.
    since_ns: instant of `levels` (2, electrodes), `drive` (electrodes,) and `passed` (joints,), N m.
    until_ns: (electrodes,), end of the effect of each electrode's last pulse.
    arriving: pulses in the delay: instant of effect, electrode, recruited share, end of the effect.
    pulses, reference: newest inputs.
    torque: (electrodes, joints), N m at full activation. still: (joints,), N m, stiffness times reference.
    """

    __slots__ = ("arriving", "drive", "levels", "now_ns", "passed", "pulses", "reference", "since_ns",
                 "still", "torque", "until_ns")

    def __init__(self, pulses: Array, reference: Array, torque: Array, still: Array) -> None:
        electrodes = len(pulses)
        self.now_ns, self.since_ns = 0, 0
        self.levels, self.drive = np.zeros((2, electrodes)), np.zeros(electrodes)
        self.passed = still
        self.until_ns: NDArray[np.int64] = np.full(electrodes, FOREVER)
        self.arriving: list[tuple[int, int, float, int]] = []
        self.pulses, self.reference, self.torque, self.still = pulses, reference, torque, still

    def copy(self) -> ArmState:
        """An independent copy; its arrays are replaced, never written to."""
        ahead = ArmState.__new__(ArmState)
        for name in self.__slots__:
            setattr(ahead, name, getattr(self, name))
        ahead.arriving = self.arriving.copy()
        return ahead


@dataclass(frozen=True, slots=True, kw_only=True)
class Arm:
    """A stimulated arm in a device that holds or moves elbow, forearm and wrist.

        v_e = Phi((ln I_e - ln threshold_e) / spread_e)       recruited share, I the effective current
        a_e'' + 2 w a_e' + w^2 a_e = w^2 v_e(t - delay)       activation
        T(q) = sum a_e T_e(q)                                 evoked torque, by posture
        d = k q - P(k q + T(q))                               torque of the device at the arm

    T_e(q) is the torque of all muscle under the electrode in posture q. The person's torque
    (`fesloop.models.evoked_torque`) is what a device read at the highest pulse width, where a share of the
    muscle was recruited and friction hid a part: R is taken to come from R (1 + h / sqrt(R^2 + h^2)), which
    is h more where it is large (chosen; trials of 24 postures through this arm then have .88 to .96 of R, by
    joint, and .51 to .85 without). P is the play of the device's dry friction: the joint moves only
    where device and muscle together overcome it. The angle is P / k, the reading of the
    device is d, as a position controller of stiffness k commands it; the moving masses are left out. A pulse
    recruits for a period of its stimulation frequency; torques are those at about 40 Hz.

    Without a `person`, the arm is that of the shipped population (docs/models/people.md). `member` takes a
    random person of it, or a random one of those who fit the person's recordings alike; without it the
    means count. Parameters of the response that are given take the place of the person's.

    Inputs: `elements` (electrodes, 3), pulses as a `stimulator` gives them: current, A, pulse width, s, and
    frequency, Hz; a message equal to the one before is the same pulse. Optional `reference` (4,), rad, the
    angles to which the device moves the joints; else `posture_deg`. Outputs, by `JOINTS`: `evoked`, N m,
    `device`, N m, `angles`, rad; and `activation` (electrodes,).

    Attributes
    ----------
    person: weights of a person's torque, as { file = "person.json" } of `fesloop identify --stimulation`.
    member: number of the random person; none: means.
    electrodes: names, after the muscles that they are to stimulate (`UNDER_ELECTRODES`).
    posture_deg: elbow flexion, pronation, wrist flexion, radial deviation.
    friction_nm: dry friction of the device's joints. Those of an exoskeleton, from its recordings.
    hidden_nm: h, friction of the device that the person's torques were recorded with.
    stiffness_nm_rad: of the device's position controller. The same one's.
    delay_ms: from pulse to torque. activation_rad_s: natural frequency w.
    threshold_ma: effective current that recruits half; spread: of its logarithm; chronaxie_us; highest: share
        recruited at the width at which the person's torques were recorded. One an electrode each.
    strength: factor on all torques.
    """

    person: StoredArm = NOBODY
    member: int | None = None
    electrodes: tuple[str, ...] = tuple(UNDER_ELECTRODES)
    posture_deg: Joints = (45.0, 0.0, 0.0, 0.0)
    friction_nm: Joints = FRICTION_NM
    hidden_nm: Joints = FRICTION_NM
    stiffness_nm_rad: Joints = (120.0, 40.0, 25.0, 25.0)
    delay_ms: float | None = None
    activation_rad_s: float | None = None
    threshold_ma: tuple[float, ...] = ()
    spread: tuple[float, ...] = ()
    chronaxie_us: tuple[float, ...] = ()
    highest: tuple[float, ...] = ()
    strength: float = 1.0
    response: ArmResponse = field(init=False, repr=False, compare=False)
    _weights: tuple[Array, ...] = field(init=False, repr=False, compare=False)
    _arm: ArmPerson = field(init=False, repr=False, compare=False)
    _delay_ns: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_shape("arm", self, (len(JOINTS),), ", ".join(JOINTS), "posture_deg", "friction_nm",
                      "hidden_nm", "stiffness_nm_rad")
        require_positive("arm", self, "stiffness_nm_rad", "strength")
        require_not_negative("arm", self, "friction_nm", "hidden_nm")
        if not self.electrodes or len(set(self.electrodes)) < len(self.electrodes):
            raise InputError("arm.electrodes", ", ".join(self.electrodes) or "none", "one or more, each once")
        for name in self.electrodes:
            muscles_under(name, "arm.electrodes")
        for key in ("threshold_ma", "spread", "chronaxie_us", "highest"):
            if getattr(self, key):
                require_shape("arm", self, (len(self.electrodes),), "one an electrode", key)
                require_positive("arm", self, key)
        if any(share > 1.0 for share in self.highest):
            raise InputError("arm.highest", f"{self.highest}", "shares above 0, up to 1")
        for key in ("delay_ms", "activation_rad_s"):
            if getattr(self, key) is not None:
                require_positive("arm", self, key)
        if self.member is not None and self.member < 0:
            raise InputError("arm.member", f"{self.member}", "0 or more")
        self._choose()

    def _choose(self) -> None:
        """Choose the person's weights and response."""
        rng = None if self.member is None else np.random.default_rng([self.member])
        responses = ArmResponses.shipped()
        found = (responses.middle(self.electrodes) if rng is None
                 else responses.drawn(self.electrodes, rng))
        changed: dict[str, Any] = {name: value for name, value in (
            ("delay_s", self.delay_ms and 1e-3 * self.delay_ms), ("frequency_rad_s", self.activation_rad_s),
            ("threshold_ma", np.array(self.threshold_ma)), ("spread", np.array(self.spread)),
            ("chronaxie_s", 1e-6 * np.array(self.chronaxie_us)), ("highest", np.array(self.highest)))
            if value is not None and np.size(value)}
        response = found._replace(**changed)
        arm = self.person.as_person() or ArmPeople.shipped().stranger(rng)
        for name in self.electrodes:
            if name not in arm.weights:
                raise InputError("arm.electrodes", f"the person has no {name!r}", ", ".join(arm.weights))
        weights = tuple(arm.weights[name].mean if rng is None else arm.weights[name].drawn(rng)
                        for name in self.electrodes)
        object.__setattr__(self, "response", response)
        object.__setattr__(self, "_arm", arm)
        object.__setattr__(self, "_weights", weights)
        object.__setattr__(self, "_delay_ns", duration_ns(1e3 * response.delay_s, NS_PER_MS, "arm.delay_ms"))

    def torque_nm(self, angles: Array) -> Array:
        """Torque (electrodes, 4), N m, of wholly recruited muscles at angles (4,), rad."""
        rows = [features(Postures.of(name, angles[np.newaxis]), self._arm.scale_nm, self._arm.spreads)[0]
                for name in self.electrodes]
        read = np.array([row @ weights for row, weights in zip(rows, self._weights, strict=True)])
        hidden = np.array(self.hidden_nm)
        size = np.maximum(np.hypot(read, hidden), np.finfo(float).tiny)
        shares = np.array(self.response.highest)[:, np.newaxis]
        return np.asarray(self.strength * read * (1.0 + hidden / size) / shares)

    def recruited(self, current_a: Array, pulse_width_s: Array) -> Array:
        """Recruited share (electrodes,) of muscles; 0 where current or width is 0 or less."""
        response = self.response
        given = (current_a > 0.0) & (pulse_width_s > 0.0)
        effective = effective_a(current_a, pulse_width_s, response.chronaxie_s)
        logs = np.log(np.where(given, 1e3 * effective, 1.0) / response.threshold_ma)
        return np.where(given, ndtr(logs / response.spread), 0.0)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Pulses, and the device's reference."""
        posture = tuple(float(angle) for angle in np.deg2rad(self.posture_deg))
        return (Port("elements", (len(self.electrodes), 3), "A,s,Hz", rows=self.electrodes),
                Port("reference", (len(JOINTS),), "rad", posture, optional=True, rows=JOINTS))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Evoked torque, the device's torque, angles and activation."""
        posture = tuple(float(angle) for angle in np.deg2rad(self.posture_deg))
        return (Port("evoked", (len(JOINTS),), "N m", rows=JOINTS),
                Port("device", (len(JOINTS),), "N m", rows=JOINTS),
                Port("angles", (len(JOINTS),), "rad", posture, rows=JOINTS),
                Port("activation", (len(self.electrodes),), "1", rows=self.electrodes))

    @property
    def grid(self) -> None:
        """None: exact at any instant."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: pulses act after a delay, and a reference from its instant on."""
        return False

    def init(self, context: Context) -> ArmState:
        """State at rest at the reference, in the middle of the device's friction."""
        angles = np.deg2rad(self.posture_deg)
        return ArmState(np.zeros((len(self.electrodes), 3)), angles, self.torque_nm(angles),
                        np.array(self.stiffness_nm_rad) * angles)

    def advance(self, state: ArmState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance through the instants at which the drive changes."""
        pulses, reference = cast(tuple[Array, Array], tuple(inputs))
        if pulses is not state.pulses:
            self._stimulate(state, pulses, start_ns)
        if reference is not state.reference:
            self._move(state, reference, start_ns)
        while (change := self._next_change(state)) <= stop_ns:
            self._change_drive(state, change)
        state.now_ns = stop_ns

    def read(self, state: ArmState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """(evoked, device, angles, activation)."""
        levels, evoked, passed = self._after(state, state.now_ns)
        return evoked, state.still - passed, passed / np.array(self.stiffness_nm_rad), levels[1]

    def observe(
        self, state: ArmState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(evoked, device, angles, activation) at `times_ns`, ascending; the state is not changed."""
        ahead, rows = state.copy(), []
        for time_ns in times_ns:
            if time_ns > start_ns:  # inputs act after the instant of their arrival
                self.advance(ahead, inputs, start_ns, time_ns)
                start_ns = time_ns
            rows.append(self.read(ahead, inputs))
        return tuple(np.array(column) for column in zip(*rows, strict=True))

    def _stimulate(self, state: ArmState, pulses: Array, time_ns: int) -> None:
        """Send new pulses to the muscles; an equal message is the same pulse."""
        if pulses.tobytes() != state.pulses.tobytes():
            recruited = self.recruited(pulses[:, CURRENT], pulses[:, WIDTH])
            for e in np.flatnonzero((recruited > 0.0) & (pulses[:, FREQUENCY] > 0.0)).tolist():
                acts = time_ns + self._delay_ns
                period_ns = math.ceil(NS_PER_S / max(float(pulses[e, FREQUENCY]), LEAST_HZ))
                state.arriving.append((acts, e, float(recruited[e]), acts + period_ns))
        state.pulses = pulses

    def _move(self, state: ArmState, reference: Array, time_ns: int) -> None:
        """Move the device's reference; torques are those of the new posture at once."""
        if reference.tobytes() != state.reference.tobytes():
            self._settle(state, time_ns)
            state.torque = self.torque_nm(reference)
            state.still = np.array(self.stiffness_nm_rad) * reference
            state.passed = self._after(state, time_ns)[2]
        state.reference = reference

    def _next_change(self, state: ArmState) -> int:
        """The next instant at which the drive changes, ns."""
        arrives = state.arriving[0][0] if state.arriving else FOREVER
        return min(arrives, int(state.until_ns.min()))

    def _change_drive(self, state: ArmState, time_ns: int) -> None:
        """Apply pulses that take effect at an instant, and end those whose period is over."""
        self._settle(state, time_ns)
        drive, until = state.drive.copy(), state.until_ns.copy()
        over = until <= time_ns
        drive[over], until[over] = 0.0, FOREVER
        while state.arriving and state.arriving[0][0] <= time_ns:
            _, e, drive[e], until[e] = state.arriving.pop(0)
        state.drive, state.until_ns = drive, until

    def _settle(self, state: ArmState, time_ns: int) -> None:
        """Begin a new stretch of a constant drive."""
        state.levels, _, state.passed = self._after(state, time_ns)
        state.since_ns = time_ns

    def _after(self, state: ArmState, time_ns: int) -> tuple[Array, Array, Array]:
        """Levels (2, electrodes), evoked torque (4,) and play (4,) at an instant of the present stretch."""
        levels, evoked, passed = np.empty_like(state.levels), np.empty(len(JOINTS)), np.empty(len(JOINTS))
        hold(state.levels, state.drive, 1.0 / self.response.frequency_rad_s,
             (time_ns - state.since_ns) / NS_PER_S, state.torque, state.still, np.array(self.friction_nm),
             state.passed, levels, evoked, passed)
        return levels, evoked, passed

"""`finger`: an index finger moved by four stimulated muscles, solved exactly between changes of its input."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_positive, require_shape
from fesloop.loop.block import Context
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value
from fesloop.models.linear_form import ContinuousForm, PlantToControl, uncovered
from fesloop.models.linear_model import LinearModel, Recruitment
from plants.finger.dynamics import (
    INDEX_LENGTHS_MM,
    JOINTS,
    MUSCLES,
    OUTPUTS,
    FingerEquations,
    chain_mass_matrix,
    state_matrices,
)
from plants.linear.system import HeldLinearSystem
from plants.muscles.lags import Fatigue

Array = NDArray[np.float64]


class FingerState:
    """State of the finger, which changes at the finger's own instants, not at observations.

    Attributes
    ----------
    z: (18,), the states x (14,) of `FingerEquations`, then the drive (4,): fitness times the recruited
        fraction that acts.
    recruited: (4,), recruited fraction that acts.
    arriving: recruited fractions in the delay, each with its instant of arrival in ns.
    stimulation: (4, 2), newest input.
    fitness: (4,), fitness of the muscles at `fitness_ns`.
    fitness_ns: instant of `fitness`.
    """

    __slots__ = ("arriving", "fitness", "fitness_ns", "recruited", "stimulation", "z")

    def __init__(self, fitness: Array) -> None:
        self.z = np.zeros(18)
        self.recruited = np.zeros(4)
        self.arriving: list[tuple[int, Array]] = []
        self.stimulation: Array = np.zeros((4, 2))
        self.fitness = fitness
        self.fitness_ns = 0

    def copy(self) -> FingerState:
        """An independent copy."""
        ahead = FingerState.__new__(FingerState)
        ahead.z, ahead.fitness = self.z.copy(), self.fitness
        ahead.recruited, ahead.stimulation = self.recruited, self.stimulation
        ahead.arriving, ahead.fitness_ns = self.arriving.copy(), self.fitness_ns
        return ahead


OutputName = Literal["angles", "rates", "accelerations", "activation"]
Joints = tuple[float, float, float]
Muscles = tuple[float, float, float, float]
_SURFACE_RECRUITMENT = Recruitment(threshold_ma=(12.0, 10.0, 10.0, 8.0), spread=(0.35, 0.35, 0.35, 0.35))
FITNESS_STEP_NS = 20 * NS_PER_MS
"""Grid on which fitness changes the drive, with fatigue."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finger(PlantToControl):
    """An index finger, from stimulation through recruitment, delay, activation and force to joint motion.

        v = recruitment(stimulation)                          fraction of each muscle, 0 to 1
        alpha'' + 2 w alpha' + w^2 alpha = w^2 mu v(t - delay)        activation, mu the fitness
        M q'' + B q' + K (q - rest) = R' (F alpha)            torque by constant moment arms

    The finger is linear after recruitment, so it advances exactly to any instant. M is that of the rest
    posture; gravity and resting tone are included in `rest_deg`, the range of motion has no stops, and forces
    are those of a free finger (a few newtons, as its joints are soft). Input: `stimulation`, (4, 2), current
    in A and pulse width in s of FDP, FDS, EDC, INT. Outputs: `angles`, `rates`, `accelerations` of MCP, PIP,
    DIP, positive in flexion, and `activation` of the muscles.

    With `fatigue`, the drive of a muscle is its fitness times its recruited fraction, updated every 20 ms and
    whenever recruitment changes; fitness itself is exact for the constant fraction, and recovers in the rest
    between trials. `equations()` returns the complete equations.

    Attributes
    ----------
    recruitment_curve: "lognormal" uses `recruitment`; "linear" takes v = pulse width / `full_scale_us`,
        unlimited and signed, for the theory of the linear loop.
    recruitment: thresholds like those of surface stimulation of forearm muscles, 300 us at 10-40 mA (chosen).
    full_scale_us: pulse width of full linear recruitment.
    delay_ms: electromechanical delay (10-20 in models).
    activation_rad_s: natural frequency of each muscle's activation (20-25 in grip-force data).
    force_n: tendon force at full activation. Chosen: FDP and FDS together flex MCP to 55 and PIP to 94
        deg, INT takes MCP to 74, EDC takes MCP to -10.
    moment_arms_mm: moment arms of each muscle at MCP, PIP, DIP, positive in flexion. FDP and FDS: Ketchum
        1978. EDC and INT at the MCP after An 1983 (doi 10.1016/0021-9290(83)90053-X) as usually quoted; EDC
        at PIP and DIP from the proportions in which it extends the joints (Nimbarte 2008: 18.3, 15.2, 4.0
        deg).
    stiffness: stiffness of each joint, N m/rad. MCP in the healthy range .033-.047 (PMC7775510); PIP and DIP
        from the proportions in which FDP and FDS flex the joints (Nimbarte 2008).
    damping: damping of each joint, N m s/rad; MCP .003-.005; PIP and DIP chosen for the MCP's damping ratio,
        1.6, with all distal segments moving along.
    lengths_mm, radii_mm, density: phalanges as cylinders, 1100 kg/m^3; radii chosen so that the proximal
        one has the published 2e-6 kg m^2.
    rest_deg: posture without stimulation (chosen), also at the start of a trial.
    strength: factor on all forces. speed: factor on the speed of activation and joints, with unchanged
        statics.
    fatigue: fitness equation; None for muscles that do not tire.
    """

    recruitment_curve: Literal["lognormal", "linear"] = "lognormal"
    recruitment: Recruitment = _SURFACE_RECRUITMENT
    full_scale_us: float = 500.0
    delay_ms: float = 20.0
    activation_rad_s: Muscles = (25.0, 25.0, 25.0, 25.0)
    force_n: Muscles = (1.1, 1.1, 2.4, 2.0)
    moment_arms_mm: tuple[Joints, Joints, Joints, Joints] = (
        (10.1, 9.8, 6.5), (12.1, 8.3, 0.0), (-8.6, -2.9, -0.8), (6.6, -2.6, -1.6))
    stiffness: Joints = (0.040, 0.0165, 0.0173)
    damping: Joints = (0.004, 0.00085, 0.00022)
    lengths_mm: Joints = INDEX_LENGTHS_MM
    radii_mm: Joints = (8.0, 7.0, 6.0)
    density: float = 1100.0
    rest_deg: Joints = (20.0, 25.0, 15.0)
    strength: float = 1.0
    speed: float = 1.0
    fatigue: Fatigue | None = None
    _system: HeldLinearSystem = field(init=False, repr=False, compare=False)
    _delay_ns: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_shape("finger", self, (len(MUSCLES),), ", ".join(MUSCLES), "activation_rad_s", "force_n")
        require_shape("finger", self, (len(MUSCLES), len(JOINTS)), "muscles by joints", "moment_arms_mm")
        require_shape("finger", self, (len(JOINTS),), ", ".join(JOINTS), "stiffness", "damping", "lengths_mm",
                      "radii_mm", "rest_deg")
        require_positive("finger", self, "activation_rad_s", "force_n", "stiffness", "damping", "lengths_mm",
                         "radii_mm", "density", "strength", "speed", "full_scale_us")
        if self.recruitment.muscles != len(MUSCLES):
            raise InputError("finger.recruitment", f"{self.recruitment.muscles} muscles", ", ".join(MUSCLES))
        object.__setattr__(self, "_delay_ns", duration_ns(self.delay_ms, NS_PER_MS, "finger.delay_ms"))
        a, b, c = self._matrices()
        object.__setattr__(self, "_system", HeldLinearSystem(a, b, c, np.zeros((13, 4)), self._offset()))

    def _matrices(self) -> tuple[Array, Array, Array]:
        mass_matrix = chain_mass_matrix(1e-3 * np.asarray(self.lengths_mm), 1e-3 * np.asarray(self.radii_mm),
                                        self.density, np.deg2rad(self.rest_deg))
        arms = 1e-3 * np.asarray(self.moment_arms_mm).T
        return state_matrices(
            self.speed * np.asarray(self.activation_rad_s), self.strength * arms * np.asarray(self.force_n),
            mass_matrix / self.speed**2, np.asarray(self.damping) / self.speed, np.asarray(self.stiffness))

    def _offset(self) -> Array:
        offset = np.zeros(13)
        offset[OUTPUTS["angles"]] = np.deg2rad(self.rest_deg)
        return offset

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Stimulation of FDP, FDS, EDC, INT."""
        return (Port("stimulation", (4, 2), "A,s", rows=MUSCLES),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Joint angles, rates and accelerations, and activation."""
        rest = tuple(float(angle) for angle in np.deg2rad(self.rest_deg))
        joints = tuple(map(str.upper, JOINTS))
        return (Port("angles", (3,), "rad", rest, rows=joints), Port("rates", (3,), "rad/s", rows=joints),
                Port("accelerations", (3,), "rad/s^2", rows=joints),
                Port("activation", (4,), "1", rows=MUSCLES))

    @property
    def grid(self) -> None:
        """None: exact at any instant."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: stimulation acts through activation alone."""
        return False

    def init(self, context: Context) -> FingerState:
        """State at rest, without fatigue."""
        return FingerState(np.ones(4))

    def next_trial(self, state: FingerState, context: Context) -> FingerState:
        """State at rest, with the fitness left after the pause between trials."""
        if self.fatigue is None:
            return FingerState(np.ones(4))
        return FingerState(self.fatigue.after(state.fitness, np.zeros(4), self.fatigue.rest_between_trials_s))

    def advance(self, state: FingerState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance through the instants at which the drive changes."""
        if inputs[0] is not state.stimulation:
            self._stimulate(state, cast(Array, inputs[0]), start_ns)
        while (change := self._next_change(state)) <= stop_ns:
            if change > start_ns:
                self._system.advance(state.z, change - start_ns)
                start_ns = change
            self._change_drive(state, change)
        self._system.advance(state.z, stop_ns - start_ns)

    def read(self, state: FingerState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """(angles, rates, accelerations, activation)."""
        y = self._system.read(state.z)
        return y[0:3], y[3:6], y[6:9], y[9:13]

    def observe(
        self, state: FingerState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """(angles, rates, accelerations, activation) at `times_ns`, ascending; the state is not changed."""
        rows = np.empty((len(times_ns), 13))
        # A new stimulation has no effect before its delay is over.
        change = self._next_change(state)
        if inputs[0] is not state.stimulation:
            change = min(change, start_ns + self._delay_ns)
        if change >= times_ns[-1]:
            self._system.read_ahead(state.z, start_ns, np.array(times_ns, dtype=np.int64), rows)
        else:
            self._observe_across(state.copy(), cast(Array, inputs[0]), start_ns, times_ns, rows)
        return rows[:, 0:3], rows[:, 3:6], rows[:, 6:9], rows[:, 9:13]

    def _observe_across(
        self, ahead: FingerState, stimulation: Array, start_ns: int, times_ns: Sequence[int], rows: Array
    ) -> None:
        """Fill `rows` with the outputs at `times_ns`, across changes of the drive; advances `ahead`."""
        if stimulation is not ahead.stimulation:
            self._stimulate(ahead, stimulation, start_ns)
        times, done = np.array(times_ns, dtype=np.int64), 0
        while True:
            change = self._next_change(ahead)
            upto = bisect_right(times_ns, change, lo=done)
            if upto > done:
                self._system.read_ahead(ahead.z, start_ns, times[done:upto], rows[done:upto])
                done = upto
            if done == len(times_ns):
                return
            self._system.advance(ahead.z, change - start_ns)
            start_ns = change
            self._change_drive(ahead, change)

    def _stimulate(self, state: FingerState, stimulation: Array, time_ns: int) -> None:
        """Send the input at `time_ns` to the muscles; an equal input sends nothing."""
        if stimulation.tobytes() != state.stimulation.tobytes():
            state.arriving.append((time_ns + self._delay_ns, self.recruited(stimulation)))
        state.stimulation = stimulation

    def recruited(self, stimulation: Array) -> Array:
        """Recruited fraction of each muscle, (4,), under a stimulation (4, 2) in A and s."""
        if self.recruitment_curve == "linear":
            fraction: Array = stimulation[:, 1] * (1e6 / self.full_scale_us)
            return fraction
        return self.recruitment.fraction(stimulation)

    def _next_change(self, state: FingerState) -> int:
        """The next instant at which the drive changes, ns."""
        change = state.arriving[0][0] if state.arriving else FOREVER
        if self.fatigue is None:
            return change
        return min(change, (state.fitness_ns // FITNESS_STEP_NS + 1) * FITNESS_STEP_NS)

    def _change_drive(self, state: FingerState, time_ns: int) -> None:
        """Update fitness and apply the recruitment that arrives at `time_ns`."""
        if self.fatigue is not None:
            elapsed_s = (time_ns - state.fitness_ns) / NS_PER_S
            state.fitness = self.fatigue.after(state.fitness, state.recruited, elapsed_s)
            state.fitness_ns = time_ns
        if state.arriving and state.arriving[0][0] == time_ns:
            state.recruited = state.arriving.pop(0)[1]
        state.z[14:] = state.fitness * state.recruited

    def equations(self) -> FingerEquations:
        """Complete equations of the finger, with `strength` and `speed`, without fatigue."""
        system, linear = self._system, self.recruitment_curve == "linear"
        curve = self.recruitment
        return FingerEquations(
            a=system.a, b=system.b, c=system.c, offset=system.offset, delay_ns=self._delay_ns,
            threshold_ma=() if linear else curve.threshold_ma, spread=() if linear else curve.spread,
            chronaxie_us=curve.chronaxie_us, full_scale_us=self.full_scale_us if linear else 0.0)

    def linear_model(self, outputs: OutputName = "angles") -> LinearModel:
        """Model for controllers, from recruited fractions to one of the outputs."""
        rows, system = OUTPUTS[outputs], self._system
        return LinearModel(
            a=system.a, b=system.b, c=system.c[rows], offset=system.offset[rows], delay_ns=self._delay_ns,
            recruitment=None if self.recruitment_curve == "linear" else self.recruitment)

    def linear_form(self, output: OutputName) -> ContinuousForm:
        """Linear form without fatigue, from drives (with "linear": pulse widths, s) to one of the outputs."""
        if self.fatigue is not None:
            raise uncovered("fatigue", "muscles that tire", "none")
        per_unit = 1e6 / self.full_scale_us if self.recruitment_curve == "linear" else 1.0
        return ContinuousForm.of(self.linear_model(output), "stimulation", output, per_unit)

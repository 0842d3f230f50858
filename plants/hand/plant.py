"""`hand`: a whole hand moved by 29 muscles, that can grasp: rigid bodies and contact by MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, duration_ns
from fesloop.loop.signals import Port, Value
from plants.hand.assist import Assistance, Hold, add_hold, require_time
from plants.hand.contract import (
    PALM_DOWN,
    Bounds,
    HandState,
    HandValues,
    Views,
    add_forearm_drive,
    advance_steps,
    advance_to,
    contact_forces,
    evaluate,
    hand_inputs,
    hand_outputs,
    object_pose,
    parts_of_geoms,
    require_hand,
    sensed,
    stable_bounds,
    start_state,
    turn_forearm,
)
from plants.hand.model import (
    ADULT_MM,
    Muscle,
    add_muscles,
    add_splint,
    add_springs,
    build_hand,
    compiled,
    empty_spec,
    moment_arms,
    muscles,
    nominal_passive,
    require_posture,
    resting_posture,
    resting_tension,
    set_passive_joints,
)
from plants.hand.scene import GraspObject, Table, add_object, add_table, require_apart
from plants.hand.tendons import STRAIN, Tendons, activated, add_tendons, fibre_rates

Array = NDArray[np.float64]
_KEPT = 32
"""Number of settled hands in the cache (chosen: .1 MB each)."""
LEAST_STRAIN, MOST_STRAIN = 0.003, 0.2
"""Bounds of the tendons' strain (chosen: stable under twice the usual force; more than any tendon bears)."""
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""The state from which MuJoCo continues bit for bit."""


def settled(model: mujoco.MjModel, positions: Array, steps: int, hold: Hold | None = None) -> mujoco.MjData:
    """New data of a model, `steps` after rest at `positions` (nq,), with time 0; `hold` acts all the time."""
    data = mujoco.MjData(model)
    if not steps:
        _begin(data, positions, Tendons.of(model))
        return data
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    state = _settled_state(content.tobytes(), positions.tobytes(), steps, hold)
    mujoco.mj_setState(model, data, np.frombuffer(state), _STATE)
    return data


@lru_cache(maxsize=_KEPT)
def _settled_state(content: bytes, positions: bytes, steps: int, hold: Hold | None) -> bytes:
    """MuJoCo's state for `settled`, cached by all bytes of the model."""
    model = mujoco.MjModel.from_binary_path("hand.mjb", {"hand.mjb": content})
    data, tendons = mujoco.MjData(model), Tendons.of(model)
    _begin(data, np.frombuffer(positions), tendons)
    relaxed = np.zeros(len(MUSCLES))
    for number in range(steps):
        if hold is not None:
            hold.approach(data, number / steps)
        if tendons is not None:
            tendons.pull(data, relaxed)
        mujoco.mj_step(model, data)
    data.time = 0.0
    state = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)
    return state.tobytes()


def _begin(data: mujoco.MjData, positions: Array, tendons: Tendons | None) -> None:
    """Put the hand at rest at `positions` (nq,), its fibres in equilibrium."""
    data.qpos[:] = positions
    if tendons is not None:
        tendons.rest(data)


_SEGMENTS = np.arange(1, 18)
"""Bodies of the segments in MuJoCo's order."""
_ANGLES, _RATES, _VELOCITY = (HandValues._fields.index(name) for name in ("angles", "rates", "velocity"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hand:
    """A whole hand of 23 degrees of freedom, moved by 29 muscles, that can grasp, in gravity.

        M(q) q'' + bias(q, q') = R' f + passive moments + contact
        f_i = F_i (a_i fl(l_i) fv(l_i') + fp(l_i)) = F_i T(L_i - l_i),   L_i = L_rest - R_i (q - q_rest)

    in MuJoCo's fixed steps; activation is latched at their starts. Muscles are those of
    `fesloop.hand.movements`, with forces, fibres and constant moment arms R of `plants.hand.model`;
    force-length, force-velocity and passive tension are MuJoCo's muscle curves. Tendons yield by a curve T
    (`plants.hand.tendons`): lengths l of the fibres are states, which begin in equilibrium.
    Passive moments of the joints themselves are linear (`plants.hand.model`), with springs set so that
    without gravity the hand rests at `rest_deg`.

    Inputs: `activation` (29,), from 0 to 1, clipped; if the forearm moves, `forearm` (4,), its commanded
    orientation to the global frame: it turns about the wrist's centre and arrives within .1 s.

    Outputs: `angles`, `rates`, `accelerations` (23,), rad and s, in the order of the hand's freedoms;
    `fingertips` (5, 3), m, bone ends in the wrist coordinate system; of 17 sites on the back of the segments
    `site_orientation` (17, 4), to the global frame, `site_position` (17, 3), m, global, `site_rate` (17, 3),
    rad/s, and `site_force` (17, 3), m/s^2, angular velocity and specific force in the segments' frames;
    `contact_force` (16,), N, sums of the normal forces on the palm and on each bone of the digits; `velocity`
    (29,), 1/s, lengthening of the fibres in optimal lengths, over the last step where tendons yield; and with
    an object `object_position` (3,), m, from the wrist's centre, `object_orientation` (4,), both global, and
    `object_force` (16,), N, the part of `contact_force` that the object causes. Accelerations and forces are
    those at the end of a step, under the activation, and with tendons that yield under their forces, that led
    there.

    Attributes
    ----------
    hand: measures and side; forces and moments scale with its length (`plants.hand.model`).
    forearm_orientation: (w, x, y, z), from the wrist coordinate system to the global frame (ENU); empty: palm
        down, fingers to the north.
    forearm_moves: whether the input `forearm` turns the forearm.
    rest_deg: resting posture by freedom, in place of that of `plants.hand.model`.
    start_deg: posture at the start by freedom, such as open fingers; other freedoms start at rest.
    settle_s: time for which the relaxed hand settles, in gravity and its splints, before the start.
    assist: pose into which a therapist brings the hand while it settles, and holds it from the start on.
    splint_deg: angles of freedoms held by a splint, such as the wrist's.
    elastic_deg: angles to which springs pull freedoms, such as the wrist's by a dynamic splint.
    elastic_n_m_rad: stiffness of these springs (chosen, for a wrist: hand and stimulated fingers bend it by
        some 20 deg).
    strength: factors on the peak forces of the muscles, in the order of `MUSCLES`; empty: 1.
    stiffness, damping, passive_tension: factors on the joints' stiffness, on their damping, and on the
        muscles' passive tension.
    tendon_strain: strain of the tendons under the healthy muscles' greatest isometric force (default: that of
        MoBL-ARMS, Saul 2015); 0: stiff tendons.
    contracture: factor on the stiffness of the MCP joints: of a total of .04 N m/rad, .03 are the joint's, so
        2.6 makes .088 (MAS 1+ after stroke), 17 makes .52 (MAS 2), 21 makes .64 (MAS 3); PMC7775510.
    object: object to grasp. table: table under it.
    step_ms: step of the solver (chosen: halving it changes a grasp by less than a degree). Hands shorter than
        180 mm under full force need half of it; otherwise joints move far beyond their ranges.

    Raises InputError for invalid values, such as an object or a table inside the hand; RunError when the
    simulation becomes unstable.
    """

    hand: HandSize = field(default_factory=HandSize)
    forearm_orientation: tuple[float, ...] = ()
    forearm_moves: bool = False
    rest_deg: dict[str, float] = field(default_factory=dict)
    start_deg: dict[str, float] = field(default_factory=dict)
    settle_s: float = 0.0
    assist: Assistance | None = None
    splint_deg: dict[str, float] = field(default_factory=dict)
    elastic_deg: dict[str, float] = field(default_factory=dict)
    elastic_n_m_rad: float = 0.5
    strength: tuple[float, ...] = ()
    stiffness: float = 1.0
    damping: float = 1.0
    passive_tension: float = 1.0
    tendon_strain: float = STRAIN
    contracture: float = 1.0
    object: GraspObject | None = None
    table: Table | None = None
    step_ms: float = 1.0
    model: mujoco.MjModel = field(init=False, repr=False, compare=False)
    _tree: SegmentTree = field(init=False, repr=False, compare=False)
    _rest: Array = field(init=False, repr=False, compare=False)
    _start: Array = field(init=False, repr=False, compare=False)
    _stretch: Array = field(init=False, repr=False, compare=False)
    _sites: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _tips: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _parts: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _bounds: Bounds = field(init=False, repr=False, compare=False)
    _hold: Hold | None = field(init=False, repr=False, compare=False)
    _tendons: Tendons | None = field(init=False, repr=False, compare=False)
    _grid: RateClock = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_hand("hand", self)
        require_not_negative("hand", self, "elastic_n_m_rad", "settle_s")
        require_time("hand", self.assist, self.settle_s)
        if not (self.tendon_strain == 0.0 or LEAST_STRAIN <= self.tendon_strain <= MOST_STRAIN):
            raise InputError("hand.tendon_strain", f"{self.tendon_strain:g}",
                             f"0 for stiff tendons, or {LEAST_STRAIN:g} to {MOST_STRAIN:g}")
        tree = hand_tree(self.hand)
        for key in ("rest_deg", "start_deg", "splint_deg", "elastic_deg"):
            require_posture(f"hand.{key}", tree, getattr(self, key))
        rest = resting_posture(tree, self.rest_deg)
        start = resting_posture(tree, {**self.rest_deg, **self.elastic_deg, **self.start_deg,
                                        **self.splint_deg})
        scale = self.hand.hand_mm / ADULT_MM
        arms = moment_arms(tree, float(rest[tree.freedom("F1_cmc_pronation")]), scale)
        fibres = 1e-3 * np.array([muscle.fibre_mm for muscle in muscles(scale)])
        object.__setattr__(self, "_tree", tree)
        object.__setattr__(self, "_rest", rest)
        object.__setattr__(self, "_start", start)
        object.__setattr__(self, "_stretch", -arms / fibres[:, np.newaxis])
        object.__setattr__(self, "_grid", RateClock(
            duration_ns(self.step_ms, NS_PER_MS, "hand.step_ms"), 1))
        model = self._compiled(arms, muscles(scale), scale)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "_tendons", Tendons.of(model))
        object.__setattr__(self, "_bounds", stable_bounds(model))
        for key, names in (("_sites", [f"imu {name}" for name in tree.names]),
                           ("_tips", [f"tip {finger}d" for finger in FINGERS])):
            object.__setattr__(self, key, np.array([model.site(name).id for name in names]))
        object.__setattr__(self, "_parts", parts_of_geoms(model))
        require_apart(model, self.init(Context("hand")).data)

    def _compiled(self, arms: Array, rows: tuple[Muscle, ...], scale: float) -> mujoco.MjModel:
        tree, rest, moments = self._tree, self._rest, scale**3
        spec = empty_spec(1e-3 * self.step_ms)
        build_hand(spec, tree, self.hand, self._forearm(), arms)
        pulling = rows, np.array(self.strength or (1.0,) * len(MUSCLES)), self.passive_tension, -arms @ rest
        if self.tendon_strain > 0.0:
            add_tendons(spec, *pulling, self.tendon_strain, scale)
        else:
            add_muscles(spec, *pulling)
        object.__setattr__(self, "_hold", None if self.assist is None else add_hold(
            spec, {name: name for name in tree.freedoms if name not in self.splint_deg},
            self.assist.held_deg(tree), self.assist))
        if self.forearm_moves:
            add_forearm_drive(spec)
        # In a fixed order: the order of constraints changes the last bits of results.
        add_splint(spec, {name: math.radians(self.splint_deg[name]) for name in tree.freedoms
                          if name in self.splint_deg})
        if self.object is not None:
            add_object(spec, self.object)
        if self.table is not None:
            add_table(spec, self.table)
        model = compiled(spec)
        stiffness, damping = nominal_passive(tree, self.contracture)
        set_passive_joints(
            model, tree, moments * self.stiffness * stiffness, moments * self.damping * damping, rest,
            arms.T @ resting_tension(rows, self.passive_tension), moments * self.stiffness)
        add_springs(model, self.elastic_deg, self.elastic_n_m_rad)
        return model

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Activation of the muscles and, if the forearm moves, its commanded orientation."""
        return hand_inputs(self._forearm() if self.forearm_moves else None)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Posture, fingertips, kinematics of the sites, forces, fibres, and the object's pose."""
        return hand_outputs(self._start, self.object is not None)

    @property
    def grid(self) -> RateClock:
        """Steps of `step_ms`."""
        return self._grid

    @property
    def feedthrough(self) -> bool:
        """False: activation shows at the end of the step in which it acts."""
        return False

    def init(self, context: Context) -> HandState:
        """State at the start, with muscles at rest."""
        positions = self.model.qpos0.copy()
        positions[self._hinges()] = self._start
        steps = round(self.settle_s * NS_PER_S / self._grid.period_num)
        data = settled(self.model, positions, steps, self._hold)
        return start_state(self.model, self.object, data)

    def advance(self, state: HandState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance by steps of the grid."""
        if self._tendons is None:
            state.views.ctrl[:len(MUSCLES)] = cast(Array, inputs[0])
        else:
            activated(state.views.userdata)[:] = cast(Array, inputs[0])
        if self.forearm_moves:
            turn_forearm(state, self._forearm(), inputs[1])
        advance_to(self.model, self._bounds, self.object, self.table, self._hold, state, stop_ns,
                   self._grid.period_num, self._tendons)

    def advance_steps(self, state: HandState, inputs: Sequence[Sequence[Value]], start_ns: int,
                      times_ns: Sequence[int]) -> bool:
        """Advance by steps of the grid, in one call; False with stiff tendons, or a forearm that moves."""
        if self._tendons is None or self.forearm_moves:
            return False
        return advance_steps(self.model, self._bounds, self.object, self.table, self._hold, self._tendons,
                             state, np.array(inputs[0]), times_ns, self._grid.period_num)

    def pull(self, data: mujoco.MjData, activation: Array) -> None:
        """Set the muscles' part of MuJoCo's data for its next step, under an activation (29,).

        `mj_step` after each call goes on as the plant does; for linearisation, and comparison with MuJoCo.
        """
        if self._tendons is None:
            data.ctrl[:len(MUSCLES)] = activation
        else:
            self._tendons.pull(data, activation)

    def held_moments(self, angles: Array, activation: Array) -> Array:
        """Moments (23,), N m, of the muscles at angles (23,), rad, held until they change no more."""
        positions, hinges = self.model.qpos0.copy(), self._hinges()
        positions[hinges] = angles
        if self._tendons is not None:
            return self._tendons.held(positions, activation)[hinges]
        data = mujoco.MjData(self.model)
        data.qpos[:] = positions
        data.ctrl[:len(MUSCLES)] = activation
        mujoco.mj_forward(self.model, data)
        return np.array(data.qfrc_actuator[hinges])

    def _forearm(self) -> Array:
        """Orientation of the forearm at the start."""
        return np.array(self.forearm_orientation or PALM_DOWN[self.hand.side])

    def read(self, state: HandState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """All outputs at this instant."""
        evaluate(self.model, state)
        views, hinges = state.views, self._hinges()
        rates = views.qvel[hinges].copy()
        every, of_object = contact_forces(state.data, self._parts)
        values = HandValues(views.qpos[hinges].copy(), rates, views.qacc[hinges].copy(),
                            *sensed(views, not self.forearm_moves, _SEGMENTS, self._sites, self._tips),
                            contact_force=every, velocity=self._velocity(views, rates))
        return values if self.object is None else (*values, *object_pose(views), of_object)

    def glance(self, state: HandState) -> dict[int, Value]:
        """Outputs that need no evaluation, by port: angles, rates, velocity of the fibres."""
        hinges = self._hinges()
        rates = state.views.qvel[hinges].copy()
        return {_ANGLES: state.views.qpos[hinges].copy(), _RATES: rates,
                _VELOCITY: self._velocity(state.views, rates)}

    def _velocity(self, views: Views, rates: Array) -> Array:
        """Lengthening of the fibres (29,), 1/s, at rates (23,) of the joints."""
        return self._stretch @ rates if self._tendons is None else fibre_rates(views.userdata).copy()

    def _hinges(self) -> slice:
        """Indices of the hand's freedoms among MuJoCo's."""
        return slice(3, 26) if self.forearm_moves else slice(0, 23)

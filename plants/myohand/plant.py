"""`myohand`: the hand model MyoHand in place of `hand`; needs the extra `myohand`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative
from fesloop.hand.anthropometry import FINGERTIPS, HandSize
from fesloop.hand.movements import MUSCLES
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
    add_forearm_drive,
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
from plants.hand.model import add_splint, add_springs, compiled
from plants.hand.plant import settled
from plants.hand.scene import GraspObject, Table, add_object, add_table, require_apart
from plants.myohand.anatomy import JOINTS, activated_by
from plants.myohand.joints import NO_JOINT, Joints, rest_angles
from plants.myohand.model import (
    add_segments,
    fibres_of,
    loaded,
    set_muscles,
    set_skin,
    weld_arm,
)
from plants.myohand.patches import JOINTS_PATCH, NAMES, patch

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MyoHand:
    """MyoHand of the package `myo-sim`, patched, with the inputs, outputs and parameters of `hand`.

    A right hand of its own size, with 22 joints and 36 muscles on paths around bones (39 as shipped). Each
    muscle of `hand` activates those that it represents (`plants.myohand.anatomy.REPRESENTS`); the thenar
    group is the opponens alone. Changes of MyoHand are in `plants.myohand.patches`, by name:

    - `inertia`: phalanges have 1e-4 kg m^2, some fifty times too much; cylinders of the shipped masses.
    - `armature`: the same on every joint; 2e-6 kg m^2.
    - `ends`: soft ends of the joints' ranges; hard ones.
    - `deviation`: 25 deg radial and 10 ulnar at the wrist; exchanged.
    - `strength`: moments of wrist muscles are 2 to 3 times too large; the fractions of `hand`, and EDC5's
      39.4 N.
    - `lengths`: tendons leave the stored ranges of lengths; ranges over all postures.
    - `passive`: joints have no stiffness and ten times the damping, relaxed tendons are slack; springs and
      dampers of `hand` on joints and tendons, the MCP joints' total stiffness as measured, a resting posture.

    These changes are permanent: the arm is welded to the forearm, activation acts without MyoHand's own
    lag (which the muscles' block has), skin collides as in `hand`, and RI2, whose path jumps, and the
    pronators are removed. Force-length, force-velocity and tendon paths are MyoHand's, and tendons are
    stiff: wrist and fingers reach its ranges, extensors have a longer arm at the DIP joints, APL_r has
    none about the axis that moves the thumb sideways, and the wrist's axis of flexion is tilted by 17
    deg. The palm has the weight of its bones and, as shipped, of the surfaces that tendons wrap around;
    the hand weighs .43 kg.

    Angles are computed from the bodies' orientations, intrinsic z-x-y between segments (`joint_rotations`),
    so all 23 exist; `F1_cmc_pronation` follows from the two joints at the thumb's base. Rotations of PIP, DIP
    and MCP joints beyond their freedoms, due to MyoHand's tilted axes, are omitted, as by a tracker: in
    straight fingers, bones are turned about themselves by up to 18 deg (F5p, F2p), which adds to the mounting
    of their sensors in what contradicts an initial pose.

    Inputs and outputs are those of `hand`. `velocity` is that of tendons over the fibre lengths of `hand`,
    the mean over the muscles that one muscle represents.

    Attributes
    ----------
    hand: MyoHand's own; other values are refused. Trackers take its measures from the attribute `size`.
    forearm_orientation, forearm_moves, strength, stiffness, damping, passive_tension, contracture, object,
        table, step_ms, elastic_n_m_rad, settle_s: as in `hand`.
    assist, rest_deg, start_deg, splint_deg, elastic_deg: as in `hand`, to within 20 deg, as near as MyoHand's
        joints allow; `F1_cmc_pronation` has the lowest priority, within 45 deg, is held only with the
        freedoms that it follows from, and has no spring.
    as_shipped: names of the patches to omit.

    Raises InputError if `myo-sim` is missing and for invalid values; RunError when the simulation becomes
    unstable.
    """

    hand: HandSize | None = None
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
    contracture: float = 1.0
    object: GraspObject | None = None
    table: Table | None = None
    step_ms: float = 1.0
    as_shipped: tuple[str, ...] = ()
    model: mujoco.MjModel = field(init=False, repr=False, compare=False)
    size: HandSize = field(init=False, repr=False, compare=False)
    _joints: Joints = field(init=False, repr=False, compare=False)
    _start: Array = field(init=False, repr=False, compare=False)
    _angles: Array = field(init=False, repr=False, compare=False)
    _activated: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _fibres: Array = field(init=False, repr=False, compare=False)
    _sites: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _tips: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _parts: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    _bounds: Bounds = field(init=False, repr=False, compare=False)
    _hold: Hold | None = field(init=False, repr=False, compare=False)
    _grid: RateClock = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_hand("myohand", self)
        require_not_negative("myohand", self, "elastic_n_m_rad", "settle_s")
        require_time("myohand", self.assist, self.settle_s)
        for name in self.as_shipped:
            if name not in NAMES:
                raise InputError("myohand.as_shipped", f"{name!r}", ", ".join(NAMES))
        led_by = {"F1_cmc_flexion", "F1_cmc_abduction"}
        if NO_JOINT in self.splint_deg and not led_by <= self.splint_deg.keys():
            raise InputError(f"myohand.splint_deg.{NO_JOINT}", "has no joint of its own in MyoHand",
                             "it together with F1_cmc_flexion and F1_cmc_abduction, which it follows from")
        if NO_JOINT in self.elastic_deg:
            raise InputError(f"myohand.elastic_deg.{NO_JOINT}", "has no joint of its own in MyoHand",
                             "F1_cmc_flexion and F1_cmc_abduction, which it follows from")
        _, _, found = loaded()
        if self.hand not in (None, HandSize(), found.size):
            raise InputError("myohand.hand", "is not MyoHand's own hand",
                             f"a right one, {found.size.hand_mm:.0f} mm long", "remove it")
        self._build()

    def _build(self) -> None:
        """Derive model and coefficients from the parameters."""
        pristine, shipped, found = loaded()
        spec, tree = pristine.copy(), hand_tree(found.size)
        patch(spec, self.as_shipped)
        set_muscles(spec, np.array(self.strength or (1.0,) * len(MUSCLES)), self.passive_tension)
        weld_arm(spec, shipped, found, self._forearm(), 1e-3 * self.step_ms)
        set_skin(spec)
        add_segments(spec, found)
        bare = compiled(spec)
        joints = Joints.of(bare, tree)
        zero = np.zeros(len(JOINTS))
        rest = joints.nearest("myohand.rest_deg", bare, rest_angles(self.rest_deg), zero)
        joints.nearest("myohand.splint_deg", bare, self.splint_deg, rest)
        pulled = dict(zip(JOINTS, joints.nearest("myohand.elastic_deg", bare, self.elastic_deg, rest),
                          strict=True))
        start = joints.nearest("myohand.start_deg", bare,
                               {**self.elastic_deg, **self.start_deg, **self.splint_deg}, rest)
        hold = None if self.assist is None else self._held(spec, joints, bare, rest)
        if self.forearm_moves:
            add_forearm_drive(spec)
        held = dict(zip(JOINTS, start, strict=True))
        add_splint(spec, {JOINTS[name]: float(held[name]) for name in JOINTS if name in self.splint_deg})
        if self.object is not None:
            add_object(spec, self.object)
        if self.table is not None:
            add_table(spec, self.table)
        model = compiled(spec)
        joints = Joints.of(model, tree)  # which a forearm that moves shifts
        if JOINTS_PATCH not in self.as_shipped:
            joints.hold(model, rest, self.contracture, self.stiffness, self.damping,
                        self.passive_tension)
        add_springs(model, {JOINTS[name]: float(np.rad2deg(pulled[name])) for name in self.elastic_deg},
                    self.elastic_n_m_rad)
        activated = activated_by(model)
        for key, value in (
                ("size", found.size), ("model", model), ("_joints", joints), ("_start", start),
                ("_activated", np.array([MUSCLES.index(name) for name in activated])),
                ("_fibres", fibres_of(activated)),
                ("_sites", np.array([model.site(f"imu {name}").id for name in tree.names])),
                ("_tips", np.array([model.site(f"tip {name}").id for name in FINGERTIPS])),
                ("_parts", parts_of_geoms(model)),
                ("_hold", hold),
                ("_bounds", stable_bounds(model)),
                ("_grid", RateClock(duration_ns(self.step_ms, NS_PER_MS, "myohand.step_ms"), 1))):
            object.__setattr__(self, key, value)
        data = self.init(Context("hand")).data
        require_apart(model, data)
        object.__setattr__(self, "_angles", joints.moved(data)[0])

    def _held(self, spec: mujoco.MjSpec, joints: Joints, bare: mujoco.MjModel, rest: Array) -> Hold:
        """Add the hold of `assist`, at the joint positions that are nearest to its pose."""
        assert self.assist is not None
        pose_deg = self.assist.held_deg(joints.tree)
        places = joints.nearest("myohand.assist.pose_deg", bare, {**pose_deg, **self.splint_deg}, rest)
        at_deg = dict(zip(JOINTS, np.rad2deg(places).tolist(), strict=True))
        free = {name: joint for name, joint in JOINTS.items() if name not in self.splint_deg}
        return add_hold(spec, free, {name: at_deg[name] for name in pose_deg if name in free}, self.assist)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Activation of the muscles and, if the forearm moves, its commanded orientation."""
        return hand_inputs(self._forearm() if self.forearm_moves else None)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Posture, fingertips, kinematics of the sites, forces, fibres, and the object's pose."""
        return hand_outputs(self._angles, self.object is not None)

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
        positions[self._joints.places] = self._start
        steps = round(self.settle_s * NS_PER_S / self._grid.period_num)
        data = settled(self.model, positions, steps, self._hold)
        return start_state(self.model, self.object, data)

    def advance(self, state: HandState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance by steps of the grid."""
        state.views.ctrl[:self._activated.size] = cast(Array, inputs[0])[self._activated]
        if self.forearm_moves:
            turn_forearm(state, self._forearm(), inputs[1])
        advance_to(self.model, self._bounds, self.object, self.table, self._hold, state, stop_ns,
                   self._grid.period_num)

    def _forearm(self) -> Array:
        """Orientation of the forearm at the start."""
        return np.array(self.forearm_orientation or PALM_DOWN["right"])

    def read(self, state: HandState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """All outputs at this instant."""
        evaluate(self.model, state)
        data = state.data
        fibres = self._fibres @ data.actuator_velocity[:self._activated.size]
        angles, rates, accelerations = self._joints.moved(data)
        every, of_object = contact_forces(data, self._parts)
        values = HandValues(
            angles, rates, accelerations,
            *sensed(state.views, not self.forearm_moves, self._joints.segments, self._sites, self._tips),
            contact_force=every, velocity=fibres)
        return values if self.object is None else (*values, *object_pose(state.views), of_object)

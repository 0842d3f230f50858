"""MyoHand's joints: their springs and dampers, and their relation to the angles of the hand's freedoms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import FINGER_RESTS_DEG
from plants.hand.model import FIBRES_MM, RESTING_LENGTH, nominal_passive, passive_n_m
from plants.myohand.anatomy import JOINTS, REPRESENTS, activated_by

Array = NDArray[np.float64]


@compiled
def joint_rotations(parents: NDArray[np.int64], axes: Array, rates: Array, accelerations: Array) -> Array:
    """Angles, rates and accelerations (n, 3, 3) of flexion, abduction and pronation between segments.

    `parents` (n,), -1 for the root; `axes` (n, 3, 3), each segment's in the columns, global; `rates` and
    `accelerations` (n, 3), rad/s and rad/s^2, angular, global. Intrinsic about z, x, y
    (doi 10.3390/s19010208, eq. 20-22): R = Rz(a) Rx(b) Ry(c), so that in the parent's frame the child turns
    at w = z a' + Rz x b' + Rz Rx y c', solved for a', b', c', and its derivative for a'', b'', c''.
    The pole is at an abduction of +-90 deg.
    """
    found = np.zeros((parents.size, 3, 3))
    for k in range(parents.size):
        i = parents[k]
        if i < 0:
            continue
        turn = axes[i].T @ axes[k]
        flexion = math.atan2(-turn[0, 1], turn[1, 1])
        abduction = math.asin(min(1.0, max(-1.0, turn[2, 1])))
        pronation = math.atan2(-turn[2, 0], turn[2, 2])
        sf, cf, sa, ca = math.sin(flexion), math.cos(flexion), turn[2, 1], math.cos(abduction)
        w = axes[i].T @ (rates[k] - rates[i])
        about_y = (cf * w[1] - sf * w[0]) / ca
        about_x = cf * w[0] + sf * w[1]
        about_z = w[2] - sa * about_y
        # In the rotating parent's frame; then without the contribution of the rotating axes.
        past = axes[i].T @ rates[i]
        seen = axes[i].T @ (accelerations[k] - accelerations[i]) - np.cross(past, w)
        x_axis = np.array([cf, sf, 0.0])
        y_axis = np.array([-sf * ca, cf * ca, sa])
        z_axis = np.array([0.0, 0.0, 1.0])
        spin = z_axis * about_z
        seen -= np.cross(spin, x_axis) * about_x + np.cross(spin + x_axis * about_x, y_axis) * about_y
        twist = (cf * seen[1] - sf * seen[0]) / ca
        found[k, 0] = flexion, abduction, pronation
        found[k, 1] = about_z, about_x, about_y
        found[k, 2] = seen[2] - sa * twist, cf * seen[0] + sf * seen[1], twist
    return found


TENDONS_SHARE = 0.01
"""Stiffness, N m/rad, that relaxed tendons add to the fingers' MCP joints' own .03 in `hand`, so that the
total is as measured, .033 to .047 (PMC7775510). MyoHand's tendons, on smaller arms, add less; the joints'
springs add the rest."""
ALLOWANCE_DEG = 20.0
"""Chosen: greatest error of an angle at the end of a joint of MyoHand."""
NO_JOINT, NO_JOINT_WEIGHT, NO_JOINT_ALLOWANCE_DEG = "F1_cmc_pronation", 0.05, 45.0
"""The freedom that follows from two others, its lower weight and its greater allowed error (chosen)."""
NEAR_BASE = 1e-3
"""Weight of the distance from the base posture relative to that from the requested angles (chosen)."""


def rest_angles(rest_deg: dict[str, float]) -> dict[str, float]:
    """Requested angles of the relaxed hand, deg: flexion of fingers and thumb as in `hand`.

    Wrist, fingers' abduction and the thumb's base keep MyoHand's angles with its joints at 0.
    """
    fingers = {f"{finger}_{joint}_flexion": angle for finger, angles in FINGER_RESTS_DEG.items()
               for joint, angle in zip(("mcp", "pip", "dip"), angles, strict=True)}
    return {**fingers, "F1_mcp_flexion": 15.0, "F1_ip_flexion": 20.0, **rest_deg}


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """MyoHand's 22 joints in a model, and the hand's 23 freedoms.

    Attributes
    ----------
    tree: segments of the hand. places: indices of the joints among MuJoCo's hinges, (22,), in the order of
        `JOINTS`.
    segments: (17,), bodies oriented like the tree's segments. parents: (17,), parents of these.
    free: (17, 3), whether each joint has a freedom about each of three axes.
    """

    tree: SegmentTree
    places: NDArray[np.int64]
    segments: NDArray[np.int64]
    parents: NDArray[np.int64]
    free: NDArray[np.bool_]

    @classmethod
    def of(cls, model: mujoco.MjModel, tree: SegmentTree) -> Joints:
        """Find the joints of a model with MyoHand."""
        return cls(tree, np.array([model.joint(name).id for name in JOINTS.values()]),
                   np.array([model.body(name).id for name in tree.names]),
                   np.ascontiguousarray(tree.layout[:, 0]), np.arange(3) < tree.layout[:, 1:2])

    def moved(self, state: mujoco.MjData) -> Array:
        """Angles, rates, accelerations of the freedoms, (3, 23), rad and s, from evaluated data."""
        axes = state.xmat[self.segments].reshape(-1, 3, 3)
        rates, accelerations = state.cvel[self.segments, :3], state.cacc[self.segments, :3]
        rows = joint_rotations(self.parents, axes, rates, accelerations)
        return np.asarray(rows.transpose(1, 0, 2)[:, self.free])

    def nearest(self, where: str, model: mujoco.MjModel, target_deg: dict[str, float], base: Array) -> Array:
        """Joint positions (22,) within their ranges, nearest to angles of freedoms, deg.

        Joints that these do not determine stay at `base`, (22,). Raises InputError, naming the parameter
        `where`, for an unknown freedom and for an angle out of MyoHand's reach.
        """
        _require_angles(where, self.tree.freedoms, target_deg)
        if not target_deg:
            return base
        rows = np.array([self.tree.freedom(name) for name in target_deg])
        target = np.deg2rad(list(target_deg.values()))
        led = np.array([name == NO_JOINT for name in target_deg])
        weight = np.where(led, NO_JOINT_WEIGHT, 1.0)
        trial = mujoco.MjData(model)

        def angles(places: Array) -> Array:
            trial.qpos[self.places] = places
            mujoco.mj_kinematics(model, trial)
            return np.asarray(self.moved(trial)[0, rows])

        def misfit(places: Array) -> Array:
            return np.concatenate([weight * (angles(places) - target), NEAR_BASE * (places - base)])

        low, high = model.jnt_range[self.places].T
        found = least_squares(misfit, np.clip(base, low + 1e-6, high - 1e-6), bounds=(low, high), xtol=1e-12,
                              ftol=1e-12)
        reached = np.rad2deg(angles(found.x))
        allowed = np.where(led, NO_JOINT_ALLOWANCE_DEG, ALLOWANCE_DEG)
        off = np.abs(reached - np.rad2deg(target)) / allowed
        worst = int(np.argmax(off))
        if not off[worst] <= 1.0:
            name = tuple(target_deg)[worst]
            raise InputError(f"{where}.{name}", f"{target_deg[name]:g}",
                             f"angles within reach of MyoHand's joints, such as {reached[worst]:.0f} deg")
        return np.asarray(found.x)

    def hold(self, model: mujoco.MjModel, rest: Array, contracture: float, stiffness: float,
             damping: float, tension: float) -> None:
        """Set springs and dampers as in `hand`, so that without gravity the hand rests at `rest`, (22,).

        Factors apply to the stiffness of MCP joints, of all joints, to damping, and to tendons' stiffness.
        """
        springs, dampers = nominal_passive(self.tree, contracture)
        rows = [self.tree.freedom(name) for name in JOINTS]
        relaxed = mujoco.MjData(model)
        relaxed.qpos[self.places] = rest
        mujoco.mj_forward(model, relaxed)
        added = self._tighten(model, relaxed, tension)
        mcp = np.array([name.endswith("mcp_flexion") and name[:2] != "F1" for name in JOINTS])
        strengths = stiffness * (springs[rows] + np.where(mcp, np.maximum(TENDONS_SHARE - added, 0.0), 0.0))
        mujoco.mj_forward(model, relaxed)
        pull = (relaxed.qfrc_actuator + relaxed.qfrc_passive)[self.places]
        shift = np.divide(pull, strengths, out=np.zeros_like(pull), where=strengths > 0.0)
        model.jnt_stiffness[self.places] = strengths
        model.dof_damping[self.places] = damping * dampers[rows]
        model.qpos_spring[self.places] = rest - shift

    def _tighten(self, model: mujoco.MjModel, relaxed: mujoco.MjData, tension: float) -> Array:
        """Make springs of relaxed tendons; returns their contribution to joint stiffness, (22,), N m/rad.

        They are as stiff as those of `hand`, and slack at the same lengths; the contribution is that of
        healthy tendons.
        """
        arms = np.zeros((model.nu, model.nv))
        mujoco.mju_sparse2dense(arms, relaxed.actuator_moment.ravel(), relaxed.moment_rownnz,
                                relaxed.moment_rowadr, relaxed.moment_colind)
        added = np.zeros(model.nv)
        for muscle, name in enumerate(activated_by(model)):
            tendon = int(model.actuator_trnid[muscle, 0])
            stiff = passive_n_m(name) / len(REPRESENTS[name])
            slack = relaxed.ten_length[tendon] - (RESTING_LENGTH - 1.0) * 1e-3 * FIBRES_MM[name]
            model.tendon_stiffness[tendon] = tension * stiff
            model.tendon_lengthspring[tendon] = 0.0, slack
            added += stiff * arms[muscle] ** 2
        return np.asarray(added[self.places])


def _require_angles(where: str, freedoms: tuple[str, ...], target_deg: dict[str, float]) -> None:
    for name, angle in target_deg.items():
        if name not in freedoms:
            raise InputError(f"{where}.{name}", "is not a freedom of the hand", ", ".join(freedoms),
                             did_you_mean(name, freedoms))
        if not abs(angle) <= 180.0:
            raise InputError(f"{where}.{name}", f"{angle:g}", "-180 to 180 deg")

"""One tick of a Kortier tracker in one kernel: samples, hand, chains, posture."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import UNSEEN_SD, Body, chain_up, fill_lever, place_tips
from estimators.body.misalignment import Misalignment, add_misalignment, add_to_tips, scaled
from estimators.kortier.chain import Filters, Gates, covariance_of, track_chains
from estimators.kortier.navigation import HandFilter, HandGates, track_hands
from estimators.kortier.samples import Moment, Trust, take
from estimators.kortier.tree import Chains, chains_of
from fesloop.compiled import compiled
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.quaternion_kernels import (
    Components,
    conjugate,
    euler_x_of_zxy,
    euler_y_of_zxy,
    euler_z_of_zxy,
    multiply,
)
from fesloop.loop.block import Tick


@compiled
def put_angles(
    chains: Chains, filters: Filters, wrong: Misalignment, scale: float, orientation: Any, heading: float,
    pending: Any, angles: Any, sds: Any, random_sds: Any
) -> None:
    """Fill angles and sds (freedoms,), rad, with 0 and pi for joints that are not seen.

    To the filters' covariance come the variances of what they do not estimate: misalignment, with its
    constant part times `scale`, a `heading`, rad^2, about the vertical, of joints that are no hinges, and
    `pending` (n,), rad^2, of sensors in gaps; orientation (n, 4), sensors to earth. `random_sds` are without
    the constant part of misalignment.

    With R = R_f(f) R_a(a) R_p(p) about the joint's axes, dth = R'f df + R_p'a da + p dp, which is solved
    for the angles' errors; f, a, p take the places of z, x, y.
    """
    angles[:] = 0.0
    sds[:] = UNSEEN_SD
    random_sds[:] = UNSEEN_SD
    whole, random = np.empty((3, 3)), np.empty((3, 3))
    for chain in range(chains.first.size - 1):
        covariance = covariance_of(chain, chains, filters)
        for k in range(chains.first[chain], chains.first[chain + 1]):
            if not (filters.begun[k] and filters.seen[k]):
                continue
            q = _in_joint(filters.q[k], chains.axes[k])
            a, p = euler_x_of_zxy(q), euler_y_of_zxy(q)
            sine, cosine, upright = math.sin(p), math.cos(p), max(math.cos(a), 1e-6)
            tilt = math.sin(a) / upright
            values = (euler_z_of_zxy(q), a, p)
            rows = ((-sine / upright, 0.0, cosine / upright), (cosine, 0.0, sine),
                    (sine * tilt, 1.0, -cosine * tilt))
            at, segment = 3 * (k - chains.first[chain]), chains.segments[k]
            whole[:] = covariance[at:at + 3, at:at + 3]
            missed = pending[chains.sensors[k + chain]] + pending[chains.sensors[k + chain + 1]]
            for i in range(3):
                whole[i, i] += missed
            if chains.freedoms[k] > 1:
                o = orientation[chains.sensors[k + chain + 1]]
                up = turned(conjugate((o[0], o[1], o[2], o[3])), 0.0, 0.0, 1.0)
                for i in range(3):
                    for j in range(3):
                        whole[i, j] += heading * up[i] * up[j]
            random[:] = whole
            for i in range(3):
                random[i, i] += wrong.fused
            add_misalignment(filters.q[k], scaled(wrong.pair[segment], wrong.fused, scale),
                             scale * wrong.growing[segment], whole)
            for i in range(chains.freedoms[k]):
                angles[chains.first_angle[k] + i] = values[i]
                for covered, filled in ((whole, sds), (random, random_sds)):
                    variance = _variance(rows[i], chains.axes[k], covered)
                    filled[chains.first_angle[k] + i] = min(math.sqrt(variance), UNSEEN_SD)


@compiled
def _in_joint(q: Any, axes: Any) -> Components:
    """Express q (4,) in the frame whose z, x and y are the joint's axes."""
    f, a, p = axes[0], axes[1], axes[2]
    x, y, z = q[1], q[2], q[3]
    return (q[0], a[0] * x + a[1] * y + a[2] * z, p[0] * x + p[1] * y + p[2] * z,
            f[0] * x + f[1] * y + f[2] * z)


@compiled
def _variance(row: Any, axes: Any, covariance: Any) -> float:
    """Variance of an angle whose Jacobian by dth is `row`, (3,) in the frame of _in_joint."""
    f, a, p = axes[0], axes[1], axes[2]
    x, y, z = row
    u, v, w = (x * a[0] + y * p[0] + z * f[0], x * a[1] + y * p[1] + z * f[1],
               x * a[2] + y * p[2] + z * f[2])
    return float(u * u * covariance[0, 0] + v * v * covariance[1, 1] + w * w * covariance[2, 2]
                 + 2.0 * (u * v * covariance[0, 1] + u * w * covariance[0, 2] + v * w * covariance[1, 2]))


@compiled
def put_orientations(
    layout: Any, sensors: Any, chains: Chains, filters: Filters, attitudes: Any, relative: Any,
    orientation: Any
) -> None:
    """Fill `relative` (segments, 4), child to parent, and `orientation` (n, 4), segment to earth.

    Parameters
    ----------
    sensors: (segments,), as in Body. attitudes: (parts, 4), of the tracked segments, to earth.
    relative: straight where a joint has never been seen.
    """
    relative[:] = 0.0
    relative[:, 0] = 1.0
    for k in range(chains.segments.size):
        if filters.begun[k]:
            relative[chains.segments[k]] = filters.q[k]
    within = np.zeros((layout.shape[0], 4))
    within[:, 0] = 1.0
    for k in range(layout.shape[0]):
        if chains.joint_of[k] >= 0:
            _store(within[k], multiply(_components(within[layout[k, 0]]), _components(relative[k])))
    for k in range(layout.shape[0]):
        part = chains.part_of[k]
        if part >= 0:
            to_tracked = conjugate(_components(within[chains.held[part]]))
            turn = multiply(_components(attitudes[part]), to_tracked)
            _store(orientation[sensors[k]], multiply(turn, _components(within[k])))


@compiled(inline="always")
def _components(q: Any) -> Components:
    return q[0], q[1], q[2], q[3]


@compiled(inline="always")
def _store(row: Any, q: Components) -> None:
    row[0], row[1], row[2], row[3] = q


@compiled
def put_fingertips(
    layout: Any, geometry: Any, tips: Any, sensors: Any, chains: Chains, filters: Filters,
    wrong: Misalignment, scale: float, heading: float, pending: Any, up: Any, relative: Any, fingertips: Any,
    sds: Any
) -> None:
    """Fill fingertips and their sds (t, 3), m, in the root's frame.

    Errors of joints in one chain have the covariance of its filter, those in different chains are assumed
    independent. An unseen joint is taken as straight, with an sd of pi about each of its axes. The mounting
    of the sensors, with its constant part times `scale`, and, for each joint that is no hinge, a heading
    error of this variance, rad^2, are added, and `pending` (n,), rad^2, of sensors in gaps.

    Parameters
    ----------
    sensors: (segments,), as in Body. up: (3,), the vertical in the root's frame.
    relative: (segments, 4), child to parent; unseen joints are set straight.
    """
    count = layout.shape[0]
    orientations, positions = np.empty((count, 4)), np.zeros((count, 3))
    levers, path = np.empty((count, 3, 3)), np.empty(count, dtype=np.int64)
    for k in range(chains.segments.size):
        if not filters.seen[k]:
            relative[chains.segments[k]] = 0.0
            relative[chains.segments[k], 0] = 1.0
    chain_up(layout, relative, orientations)
    place_tips(layout, geometry, orientations, tips, positions, fingertips)
    for t in range(tips.size):
        k, depth = tips[t], 0
        while layout[k, 0] >= 0:
            fill_lever(orientations[k], geometry[k, 4], positions[k], fingertips[t], levers[depth])
            path[depth] = k
            k, depth = layout[k, 0], depth + 1
        for x in range(3):
            sds[t, x] = 0.0
        for i in range(depth):
            joint = chains.joint_of[path[i]]
            if joint < 0 or not filters.seen[joint]:
                _add_unseen(levers[i], geometry[path[i]], layout[path[i], 1], sds[t])
            else:
                _add_seen(levers, path, i, chains, filters, sds[t])
                missed = pending[sensors[path[i]]] + pending[sensors[layout[path[i], 0]]]
                for x in range(3):
                    for a in range(3):
                        sds[t, x] += missed * levers[i, x, a] ** 2
                if chains.freedoms[joint] > 1:
                    _add_heading(orientations[path[i]], up, levers[i], heading, sds[t])
    add_to_tips(layout, geometry, orientations, positions, tips, sensors, wrong, scale, sds)
    for t in range(tips.size):
        for x in range(3):
            sds[t, x] = math.sqrt(sds[t, x])


@compiled
def _add_heading(q: Any, up: Any, lever: Any, heading: float, variance: Any) -> None:
    """Add the variance of a tip by a rotation about the vertical; q (4,), segment to root."""
    own = turned(conjugate((q[0], q[1], q[2], q[3])), up[0], up[1], up[2])
    for x in range(3):
        moved = lever[x, 0] * own[0] + lever[x, 1] * own[1] + lever[x, 2] * own[2]
        variance[x] += heading * moved * moved


@compiled
def _add_unseen(lever: Any, axes: Any, freedoms: int, variance: Any) -> None:
    for i in range(freedoms):
        for x in range(3):
            moved = lever[x, 0] * axes[i, 0] + lever[x, 1] * axes[i, 1] + lever[x, 2] * axes[i, 2]
            variance[x] += (UNSEEN_SD * moved) ** 2


@compiled
def _add_seen(levers: Any, path: Any, i: int, chains: Chains, filters: Filters, variance: Any) -> None:
    """Add the variance of joint `i` of a path and its covariance with earlier joints of its chain."""
    joint, chain = chains.joint_of[path[i]], chains.chain_of[path[i]]
    first = chains.first[chain]
    covariance = covariance_of(chain, chains, filters)
    for m in range(i + 1):
        other = chains.joint_of[path[m]]
        if chains.chain_of[path[m]] != chain or not filters.seen[other]:
            continue
        row, col, times = 3 * (joint - first), 3 * (other - first), 1.0 if m == i else 2.0
        for x in range(3):
            for a in range(3):
                for b in range(3):
                    variance[x] += times * levers[i, x, a] * covariance[row + a, col + b] * levers[m, x, b]


Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


class Worn(NamedTuple):
    """Arrays of a body and its sensors, for kernels; read-only.

    Attributes
    ----------
    layout, geometry: of the tree. sensors, tips: as in Body.
    magnetometers: (n,), whether each is read: those of each chain's base and tip, and of `chains.held`.
    held_sensors: (parts,), sensors of the segments in `chains.held`.
    base: the part whose position and velocity are outputs.
    wrong: misalignment of sensors and joints.
    """

    layout: Numbers
    geometry: Array
    sensors: Numbers
    tips: Numbers
    magnetometers: NDArray[np.bool_]
    held_sensors: Numbers
    base: int
    chains: Chains
    wrong: Misalignment


class Settings(NamedTuple):
    """Parameters of the filters; `heading`: variance of the field's direction between segments, rad^2."""

    trust: Trust
    gates: Gates
    own: HandGates
    heading: float


class Posture(NamedTuple):
    """Output arrays: orientation (n, 4); angles (3, freedoms), with their sds and those of
    random errors; fingertips (2, t, 3), with their sds."""

    orientation: Array
    angles: Array
    fingertips: Array


def worn_by(body: Body, base: int, wrong: Misalignment) -> Worn:
    """Create the arrays of a body whose segment `base` has its position tracked."""
    chains = chains_of(body, base)
    number = np.arange(len(chains.first) - 1)
    read = np.zeros(len(body.sensed), dtype=np.bool_)
    for places in (chains.first[:-1] + number, chains.first[1:] + number):
        read[chains.sensors[places]] = True
    tracked = body.sensors[chains.held]
    read[tracked] = True
    for array in (read, tracked):
        array.flags.writeable = False
    return Worn(body.tree.layout, body.tree.geometry, body.sensors, body.tips, read, tracked,
                int(chains.part_of[base]), chains, wrong)


@compiled
def track(
    samples: Any, codes: Any, elapsed: Any, period: float, worn: Worn, settings: Settings, hands: HandFilter,
    filters: Filters, moment: Moment, scale: float, posture: Posture
) -> Any:
    """Process one tick and fill `posture`; return whether any joint was lost or found again.

    Parameters
    ----------
    samples, codes, elapsed, period: as in `estimators.kortier.samples.take`.
    scale: of the variance of mounting and axes, as in `estimators.kortier.tilts`.
    """
    trust, gates, own, heading = settings
    take(samples, codes, elapsed, period, trust, moment)
    track_hands(hands, worn.held_sensors, moment, elapsed, gates, own)
    joints = track_chains(worn.chains, filters, moment, elapsed, gates)
    relative = np.empty((worn.layout.shape[0], 4))
    put_orientations(worn.layout, worn.sensors, worn.chains, filters, hands.q, relative, posture.orientation)
    put_angles(worn.chains, filters, worn.wrong, scale, posture.orientation, heading, moment.gaps.pending,
               posture.angles[0], posture.angles[1], posture.angles[2])
    put_fingertips(worn.layout, worn.geometry, worn.tips, worn.sensors, worn.chains, filters, worn.wrong,
                   scale, heading, moment.gaps.pending, _vertical(worn, posture.orientation), relative,
                   posture.fingertips[0], posture.fingertips[1])
    return joints


@compiled
def _vertical(worn: Worn, orientation: Any) -> Any:
    """The vertical in the frame of the tree's root, or of the innermost segment with a sensor."""
    for k in range(worn.sensors.size):
        if worn.sensors[k] >= 0:
            o = orientation[worn.sensors[k]]
            return turned(conjugate((o[0], o[1], o[2], o[3])), 0.0, 0.0, 1.0)
    return 0.0, 0.0, 1.0


def report_unseen(
    before: tuple[str, ...], body: Body, chains: Chains, seen: NDArray[np.bool_], tick: Tick
) -> tuple[str, ...]:
    """Report joints that were lost or found again; return the names of unseen joints.

    Parameters
    ----------
    before: the names returned last time. seen: (joints,), whether each joint of the chains is seen.
    """
    joint_of, freedoms = chains.joint_of, body.tree.layout[:, 1]
    unseen = tuple(body.joints[k] for k in np.flatnonzero(freedoms)
                   if joint_of[k] < 0 or not seen[joint_of[k]])
    for status, now, other in (("untracked", unseen, before), ("tracked", before, unseen)):
        changed = [joint for joint in now if joint not in other]
        if changed:
            tick.report(status, "joint " + ", ".join(changed))
    return unseen

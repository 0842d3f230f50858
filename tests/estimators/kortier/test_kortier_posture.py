"""Angles, orientations and fingertips against the hand's kinematics; sd against whole covariances."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.body.body import body_of
from estimators.body.misalignment import misalignment
from estimators.kortier.chain import covariance_of, new_filters
from estimators.kortier.tick import put_angles, put_fingertips, put_orientations
from estimators.kortier.tree import chains_of
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import joint_angles, placed, relative_orientations, segment_poses
from fesloop.hand.segments import Segment

SIZE = HandSize(side="left")
STEP = 1e-6


def tilted_tree(rng):
    """A hand-like tree whose joints are all tilted: forearm, hand, and two fingers of three."""
    def joint(name, parent, kind, freedoms):
        frame = quaternion.to_matrix(quaternion.normalized(rng.normal(size=4)))
        return Segment(name=name, parent=parent, joint=kind, axes=tuple(map(tuple, frame[:freedoms])),
                       base=tuple(0.03 * rng.normal(size=3)), offset=tuple(0.05 * rng.normal(size=3)))

    fingers = [joint(f"{f}{i}", "hand" if i == 0 else f"{f}{i - 1}", kind, freedoms) for f in "AB"
               for i, (kind, freedoms) in enumerate((("saddle", 2), ("hinge", 1), ("ball", 3)))]
    return (Segment(name="forearm"), joint("hand", "forearm", "saddle", 2), *fingers)


def filters_at(body, angles, rng):
    """Chains and their filters at a posture, every joint seen, with covariances that couple everything."""
    chains = chains_of(body, body.tree.index("hand"))
    filters = new_filters(chains, relative_orientations(body.tree, angles)[chains.segments], 0.1, 0.01, 0.1)
    filters.seen[:], filters.begun[:] = True, True
    for c in range(len(chains.first) - 1):
        covariance = covariance_of(c, chains, filters)
        root = 0.01 * rng.normal(size=covariance.shape)
        covariance[:] = root @ root.T
    return chains, filters


def put_out(body, chains, filters, attitudes, pending=None, wrong=None, scale=1.0):
    """angles, their sd, orientation, relative orientations, fingertips, their sd, sd of random errors."""
    n, freedoms, tips = len(body.tree.segments), len(body.tree.ranges), len(body.tips)
    angles, tip = np.empty((3, freedoms)), np.empty((2, tips, 3))
    relative, orientation = np.empty((n, 4)), np.empty((len(body.sensed), 4))
    put_orientations(body.tree.layout, body.sensors, chains, filters, attitudes, relative, orientation)
    wrong = misalignment(body.tree, 0.0, 0.0) if wrong is None else wrong
    pending = np.zeros(n) if pending is None else pending
    put_angles(chains, filters, wrong, scale, orientation, 0.0, pending, *angles)
    put_fingertips(body.tree.layout, body.tree.geometry, body.tips, body.sensors, chains, filters, wrong,
                   scale, 0.0, pending, (0.0, 0.0, 1.0), relative, *tip)
    return (*angles[:2], orientation, relative, *tip, angles[2])


def spread(body, chains, filters, quantity):
    """Sd of a quantity by finite differences in every joint error and the chains' whole covariances."""
    q, variance = filters.q.copy(), 0.0
    for c in range(len(chains.first) - 1):
        joints = range(chains.first[c], chains.first[c + 1])
        columns = []
        for k in joints:
            for axis in np.eye(3):
                for sign in (1.0, -1.0):
                    filters.q[k] = quaternion.multiply(q[k], quaternion.from_axis_angle(axis, sign * STEP))
                    columns.append(quantity())
                filters.q[k] = q[k]
        moved = np.array([(a - b) / (2 * STEP) for a, b in zip(columns[::2], columns[1::2], strict=True)])
        block = covariance_of(c, chains, filters)[:3 * len(joints), :3 * len(joints)]
        variance = variance + np.einsum("a...,ab,b...->...", moved, block, moved)
    return np.sqrt(variance)


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(deadline=None, max_examples=15)
def test_posture_and_its_spread(seed, of_hand):
    rng = np.random.default_rng(seed)
    segments = () if of_hand else tilted_tree(rng)
    body = body_of(17 if of_hand else 8, SIZE if of_hand else HandSize(), segments, ())
    true = rng.uniform(-0.7, 0.7, len(body.tree.ranges))
    chains, filters = filters_at(body, true, rng)
    attitude = quaternion.normalized(rng.normal(size=(1, 4)))
    angles, sds, orientation, _, tips, tip_sds, _ = put_out(body, chains, filters, attitude)
    poses = segment_poses(body.tree, true)
    np.testing.assert_allclose(angles, true, atol=1e-12)
    np.testing.assert_allclose(tips, poses.position[body.tips], atol=1e-14)
    hand = poses.orientation[1]
    expected = quaternion.multiply(attitude[0], quaternion.relative(hand, poses.orientation))
    assert quaternion.rotation_angle(quaternion.relative(orientation, expected)).max() < 1e-7
    np.testing.assert_allclose(sds, spread(body, chains, filters, lambda: put_out(
        body, chains, filters, attitude)[0]), rtol=1e-5)
    np.testing.assert_allclose(tip_sds, spread(body, chains, filters, lambda: put_out(
        body, chains, filters, attitude)[4]), rtol=1e-5, atol=1e-9)


def test_angles_beyond_what_joints_allow_are_those_of_the_kinematics():
    rng = np.random.default_rng(4)
    body = body_of(8, HandSize(), tilted_tree(rng), ())
    chains, filters = filters_at(body, np.zeros(14), rng)
    filters.q[:] = quaternion.normalized(rng.normal(size=filters.q.shape))
    angles, _, _, relative, tips, *_ = put_out(body, chains, filters, np.array([[1.0, 0.0, 0.0, 0.0]]))
    chained = np.zeros((8, 4))
    chained[:, 0] = 1.0
    for k, (parent, _, _) in enumerate(body.tree.layout[1:], start=1):
        chained[k] = quaternion.multiply(chained[parent], relative[k])
    np.testing.assert_allclose(angles, joint_angles(body.tree, relative), atol=1e-12)
    np.testing.assert_allclose(tips, placed(body.tree, chained).position[body.tips], atol=1e-14)


def test_joints_out_of_sight_stand_at_zero_and_err_by_pi():
    rng = np.random.default_rng(5)
    body = body_of(16, SIZE, (), ())
    true = rng.uniform(-0.5, 0.5, 23)
    chains, filters = filters_at(body, true, rng)
    never, lost = body.tree.index("F3m"), body.tree.index("F2d")
    filters.seen[chains.joint_of[[never, lost]]] = False
    filters.begun[chains.joint_of[never]] = False
    angles, sds, _, _, tips, tip_sds, _ = put_out(body, chains, filters, np.array([[1.0, 0.0, 0.0, 0.0]]))
    expected = true.copy()
    pip, dip = body.tree.freedom("F3_pip_flexion"), body.tree.freedom("F2_dip_flexion")
    expected[[0, 1, dip, pip]] = 0.0
    np.testing.assert_allclose(angles, expected, atol=1e-12)
    assert np.flatnonzero(sds == np.pi).tolist() == [0, 1, dip, pip]
    np.testing.assert_allclose(tips, segment_poses(body.tree, expected).position[body.tips], atol=1e-14)
    # The wrist's own error of pi is that of all fingertips alike; the DIP joint's comes on top.
    bone = body.tree.geometry[lost, 4, 1]
    filters.seen[chains.joint_of[lost]] = True
    with_dip = put_out(body, chains, filters, np.array([[1.0, 0.0, 0.0, 0.0]]))[5]
    more = np.sum(tip_sds[1] ** 2 - with_dip[1] ** 2)
    assert np.sqrt(more) > 0.95 * np.pi * bone
    np.testing.assert_allclose(tip_sds[3], with_dip[3])


def test_a_gap_adds_to_angles_and_fingertips_beyond_it_alone():
    rng = np.random.default_rng(6)
    body = body_of(16, SIZE, (), ())
    chains, filters = filters_at(body, rng.uniform(-0.5, 0.5, 23), rng)
    up = np.array([[1.0, 0.0, 0.0, 0.0]])
    _, before, _, _, _, tips_before, _ = put_out(body, chains, filters, up)
    pending = np.zeros(len(body.tree.segments))
    pending[body.sensors[body.tree.index("F2m")]] = 0.1
    _, sds, _, _, _, tip_sds, _ = put_out(body, chains, filters, up, pending)
    of_gap = [name in ("F2_pip_flexion", "F2_dip_flexion") for name in body.tree.freedoms]
    np.testing.assert_array_equal(sds > before, of_gap)
    np.testing.assert_allclose((sds**2 - before**2)[of_gap], 0.1, rtol=0.2)
    np.testing.assert_array_equal((tip_sds > tips_before).any(axis=1), [False, True, False, False, False])


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 2.0))
@settings(deadline=None, max_examples=10)
def test_a_scale_is_that_of_other_mounting_and_axes_but_of_no_random_error(seed, factor):
    rng = np.random.default_rng(seed)
    body = body_of(17, SIZE, (), ())
    chains, filters = filters_at(body, rng.uniform(-0.5, 0.5, 23), rng)
    up = np.array([[1.0, 0.0, 0.0, 0.0]])
    found = put_out(body, chains, filters, up, wrong=misalignment(body.tree, 5.0, 4.0, 1.5), scale=factor**2)
    other = put_out(body, chains, filters, up, wrong=misalignment(body.tree, 5.0 * factor, 4.0 * factor, 1.5))
    for one, two in zip(found, other, strict=True):
        np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-12)
    whole = put_out(body, chains, filters, up, wrong=misalignment(body.tree, 5.0, 4.0, 1.5))
    np.testing.assert_array_equal(found[6], whole[6])

"""Chain, constraints and spread against scipy's rotations and 4 x 4 matrices, against samples of errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from estimators.arrivals import CLIPPED, LOST
from estimators.body.body import UNSEEN_SD, body_of
from estimators.body.misalignment import misalignment
from estimators.gaps import Gaps
from estimators.salchow.fusion import find_seen, in_joint, joint_turns, posture, widen
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import relative_orientations
from fesloop.hand.segments import Segment

SEEDS = st.integers(0, 2**32 - 1)
SIDES = ("left", "right")


def tilted_chain():
    """A hinge, a saddle and a ball whose axes are none of their segments'."""
    axes = Rotation.random(3, random_state=3).as_matrix()
    rows = [tuple(tuple(float(x) for x in row) for row in matrix) for matrix in axes]
    return (Segment(name="a"),
            Segment(name="b", parent="a", joint="hinge", axes=rows[0][:1], base=(0.01, 0.0, 0.0),
                    offset=(0.0, 0.05, 0.01), ranges=((-0.5, 1.2),)),
            Segment(name="c", parent="b", joint="saddle", axes=rows[1][:2], offset=(0.0, 0.04, 0.0),
                    ranges=((-0.8, 0.8), (-0.3, 0.4))),
            Segment(name="d", parent="c", joint="ball", axes=rows[2], offset=(0.02, 0.03, 0.0)))


def bodies():
    whole = [body_of(17, HandSize(side=side), (), ()) for side in SIDES]
    return [*whole, body_of(16, HandSize(), (), ()), body_of(4, HandSize(), tilted_chain(), ())]


def postured(body, fused, constrained=True, headings=None, seen=None, tilt=0.01, heading=0.02, gaps=None,
             kernel=posture, wrong=(0.0, 0.0), changing=0.02):
    """Outputs of the kernel: orientation, angles, sd, fingertips, fingertip_sd, random_sd."""
    n, tree, tips = len(body.sensed), body.tree, len(body.tips)
    outputs = (np.empty((n, 4)), np.empty(len(tree.ranges)), np.empty(len(tree.ranges)), np.empty((tips, 3)),
               np.empty((tips, 3)), np.empty(len(tree.ranges)))
    kernel(tree.layout, tree.geometry, tree.ranges, body.sensors, np.ones(len(tree.segments), dtype=np.bool_),
           body.tips, fused, np.tile([1.0, 0.0], (n, 1)) if headings is None else headings,
           body.seen() if seen is None else seen, constrained, misalignment(tree, *wrong), tilt, heading,
           changing, np.zeros((n, 2)) if gaps is None else gaps, *outputs)
    return outputs


def by_matrices(body, fused, constrained):
    """Section 2.4.3 and 2.4.4 with scipy's Euler angles and 4 x 4 matrices: angles, fingertips."""
    tree, angles = body.tree, []
    to_earth = {k: Rotation.from_quat(fused[s], scalar_first=True) for s, k in enumerate(body.sensed)}
    chain = []
    for k, segment in enumerate(tree.segments):
        if segment.parent is None:
            chain.append(np.eye(4))
            continue
        parent, freedoms, first = tree.layout[k]
        step = np.eye(4)
        if parent in to_earth and k in to_earth:
            z, x, y = tree.geometry[k, :3]
            axes = Rotation.from_matrix(np.stack([x, y, z], axis=1))
            relative = axes.inv() * to_earth[parent].inv() * to_earth[k] * axes
            euler = relative.as_euler("ZXY")
            if constrained:
                limits = tree.ranges[first:first + freedoms]
                euler[freedoms:] = 0.0
                euler[:freedoms] = np.clip(euler[:freedoms], *limits.T)
                relative = Rotation.from_euler("ZXY", euler)
            angles.extend(euler[:freedoms])
            step[:3, :3] = (axes * relative * axes.inv()).as_matrix()
        else:
            angles.extend([0.0] * freedoms)
        base, offset = np.eye(4), np.eye(4)
        base[:3, 3], offset[:3, 3] = tree.geometry[k, 3], tree.geometry[k, 4]
        chain.append(chain[parent] @ base @ step @ offset)
    return np.array(angles), np.array([chain[k][:3, 3] for k in body.tips])


@pytest.mark.parametrize("body", bodies(), ids=["left", "right", "without forearm", "tilted axes"])
@given(seed=SEEDS, constrained=st.booleans(), near=st.booleans())
@settings(deadline=None, max_examples=40)
def test_angles_and_fingertips_are_those_of_scipy_and_matrices(body, seed, constrained, near):
    rng = np.random.default_rng(seed)
    fused = rng.normal(size=(len(body.sensed), 4))
    if near:
        fused = np.array([1.0, 0.0, 0.0, 0.0]) + 0.1 * fused
    fused = quaternion.normalized(fused)
    orientation, angles, sd, tips, tip_sd, random_sd = postured(body, fused, constrained)
    np.testing.assert_allclose(random_sd, sd, rtol=1e-12)  # without misalignment all errors are random
    expected, places = by_matrices(body, fused, constrained)
    assert np.abs(np.angle(np.exp(1j * (angles - expected)))).max() < 1e-6
    assert np.abs(tips - places).max() < 1e-7
    assert np.allclose(np.linalg.norm(orientation, axis=1), 1.0)
    assert (sd > 0).all()
    assert (sd <= UNSEEN_SD).all()
    assert np.isfinite(tip_sd).all()


@pytest.mark.parametrize("body", bodies(), ids=["left", "right", "without forearm", "tilted axes"])
@given(seed=SEEDS)
@settings(deadline=None, max_examples=25)
def test_constraints_once_more_change_nothing(body, seed):
    rng = np.random.default_rng(seed)
    fused = quaternion.normalized(rng.normal(size=(len(body.sensed), 4)))
    once = postured(body, fused)
    again = postured(body, once[0])
    for port in (1, 3):
        assert np.abs(again[port] - once[port]).max() < 1e-6
    assert quaternion.rotation_angle(quaternion.relative(once[0], again[0])).max() < 1e-6
    low, high = body.tree.ranges.T
    assert (once[1] >= low).all()
    assert (once[1] <= high).all()


def test_pip_and_dip_are_held_to_the_papers_ranges():
    body = body_of(17, HandSize(), (), ())
    bent = quaternion.about_z(np.radians(130.0))
    fused = np.tile([1.0, 0.0, 0.0, 0.0], (17, 1))
    fused[[body.tree.index("F2m"), body.tree.index("F2d")]] = bent
    angles = postured(body, fused)[1]
    assert np.degrees(angles[body.tree.freedom("F2_pip_flexion")]) == pytest.approx(100.0)
    fused[body.tree.index("F2m")] = quaternion.about_z(np.radians(-130.0))
    assert np.degrees(postured(body, fused)[1][body.tree.freedom("F2_pip_flexion")]) == pytest.approx(-20.0)


def test_headings_turn_sensors_about_the_vertical():
    body = bodies()[0]
    rng = np.random.default_rng(0)
    fused, turns = quaternion.normalized(rng.normal(size=(17, 4))), rng.uniform(-3.0, 3.0, 17)
    headings = np.stack([np.cos(0.5 * turns), np.sin(0.5 * turns)], axis=1)
    turned = quaternion.multiply(quaternion.about_z(turns), fused)
    for ours, expected in zip(postured(body, fused, headings=headings), postured(body, turned), strict=True):
        np.testing.assert_allclose(ours, expected, atol=1e-9)


def test_what_is_not_seen_is_neutral_and_unknown():
    body = bodies()[0]
    fused = quaternion.normalized(np.random.default_rng(1).normal(size=(17, 4)))
    seen = body.seen()
    seen[body.tree.index("F3m")] = False
    number = body.tree.freedom("F3_pip_flexion")
    orientation, angles, sd, _, tip_sd, random_sd = postured(body, fused, seen=seen)
    assert random_sd[number] == UNSEEN_SD
    assert angles[number] == 0.0
    assert sd[number] == UNSEEN_SD
    np.testing.assert_allclose(orientation[body.tree.index("F3m")], fused[body.tree.index("F3m")])
    assert tip_sd[2].max() > 0.1


@pytest.mark.parametrize("constrained", [True, False])
@pytest.mark.parametrize("body", [bodies()[0], bodies()[3]], ids=["left", "tilted axes"])
def test_sds_are_those_of_errors_drawn(body, constrained):
    rng = np.random.default_rng(2)
    tree, n = body.tree, len(body.sensed)
    middle, span = tree.ranges.mean(axis=1), np.ptp(tree.ranges, axis=1)
    angles = middle + 0.2 * rng.uniform(-1, 1, len(span)) * np.minimum(span, 1.0)
    relative = relative_orientations(tree, angles)
    base = quaternion.normalized(rng.normal(size=4))
    tilt, heading, draws = 0.004**2, 0.007**2, 4000

    def chained(errors):
        """Orientations (..., n, 4) with errors (..., n, 3) of each joint's rotation, in the child's frame."""
        turns = Rotation.from_rotvec(errors.reshape(-1, 3)).as_quat(scalar_first=True)
        turns = turns.reshape(*errors.shape[:-1], 4)
        chain = [np.broadcast_to(base, (*errors.shape[:-2], 4))]
        for k in range(1, n):
            own = quaternion.multiply(chain[tree.layout[k, 0]], relative[k])
            chain.append(quaternion.multiply(own, turns[..., k, :]))
        return np.stack(chain, axis=-2)

    still = chained(np.zeros((n, 3)))
    _, _, sd, _, tip_sd, _ = postured(body, still, constrained, tilt=tilt, heading=heading)
    up = quaternion.rotate(quaternion.conjugate(still), [0.0, 0.0, 1.0])
    errors = (np.sqrt(tilt) * rng.normal(size=(draws, n, 3))
              + np.sqrt(heading) * rng.normal(size=(draws, n, 1)) * up)
    found = []
    for fused in chained(errors):
        drawn = postured(body, fused, constrained)
        found.append(np.concatenate([drawn[1], drawn[3].ravel()]))
    spread = np.std(found, axis=0)
    # 4000 draws know an sd to 1.1 %; errors of 0.5 deg are all but linear.
    np.testing.assert_allclose(sd, spread[:len(sd)], rtol=0.08)
    np.testing.assert_allclose(tip_sd.ravel(), spread[len(sd):], rtol=0.08, atol=1e-6)


@given(seed=SEEDS)
@settings(deadline=None, max_examples=50)
def test_turns_are_how_a_small_change_of_each_angle_moves_the_child(seed):
    """By differences of scipy's rotations, about axes of any direction."""
    rng = np.random.default_rng(seed)
    axes = Rotation.random(random_state=rng).as_matrix()
    about = Rotation.from_matrix(np.stack([axes[1], axes[2], axes[0]], axis=1))
    angles = rng.uniform([-3.0, -1.4, -3.0], [3.0, 1.4, 3.0])

    def posed(angles):
        return about * Rotation.from_euler("ZXY", angles) * about.inv()

    measured = tuple(posed(angles).as_quat(scalar_first=True).tolist())
    step = 1e-6
    moved = [(posed(angles - step * one).inv() * posed(angles + step * one)).as_rotvec() / (2.0 * step)
             for one in np.eye(3)]
    np.testing.assert_allclose(joint_turns(axes, in_joint(axes, measured)), moved, atol=1e-7)


def test_what_bad_samples_cost_grows_with_the_time_and_fades_with_samples():
    codes = np.zeros((3, 2), dtype=np.uint8)
    gaps, missed, forget = Gaps.none(2), np.zeros((2, 2)), np.array([0.5, 1.0])
    gaps.spread[1], gaps.pending[1], codes[0, 1] = 0.2, 0.1, LOST
    for _ in range(10):
        widen(codes, 0.01, 3.0, forget, gaps, missed)
    np.testing.assert_allclose(missed, [[0.0, 0.0], [0.02, 0.02]])
    gaps.spread[1], gaps.pending[1], codes[:] = 0.0, 0.0, 0
    widen(codes, 0.01, 3.0, forget, gaps, missed)
    np.testing.assert_allclose(missed[1], [0.01, 0.02])
    codes[0, 1], missed[:] = CLIPPED, 0.0
    widen(codes, 0.01, 3.0, forget, gaps, missed)
    np.testing.assert_allclose(np.sqrt(missed), [[0.0, 0.0], [0.03, 0.03]])
    for _ in range(1000):
        widen(codes, 0.01, 3.0, forget, gaps, missed)
    np.testing.assert_allclose(np.sqrt(missed[1]), UNSEEN_SD)


def test_a_joint_is_seen_by_two_sound_posed_sensors():
    body = body_of(3, HandSize(), (), ("hand", "F2p", "F2d"))
    silent, posed, seen = np.zeros((3, 2)), np.ones(3, dtype=np.bool_), np.zeros(17, dtype=np.bool_)
    arguments = (body.tree.layout, body.sensors, silent, posed, 0.1, seen)
    assert find_seen(*arguments)
    assert not find_seen(*arguments)
    assert [body.joints[k] for k in np.flatnonzero(seen)] == ["F2_mcp"]
    silent[1] = 0.2
    assert find_seen(*arguments)
    assert not seen.any()
    silent[1], posed[0] = 0.0, False
    assert not find_seen(*arguments)


def test_compiled_kernels_equal_plain_python():
    body = bodies()[3]
    fused = quaternion.normalized(np.random.default_rng(5).normal(size=(4, 4)))
    for constrained in (True, False):
        for ours, plain in zip(postured(body, fused, constrained),
                               postured(body, fused, constrained, kernel=posture.py_func), strict=True):
            np.testing.assert_allclose(ours, plain, atol=1e-12)
    results = []
    for kernel in (widen, widen.py_func):
        missed, gaps = np.full((2, 2), 0.1), Gaps.none(2)
        gaps.spread[1] = 0.3
        kernel(np.array([[0, LOST]] * 3, dtype=np.uint8), 0.01, 2.0, np.array([0.9, 0.8]), gaps, missed)
        results.append(missed)
    np.testing.assert_allclose(*results)

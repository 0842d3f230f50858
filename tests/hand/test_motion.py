"""Inertial sensors on a moving tree against MuJoCo's site sensors and against differences of positions."""

import mujoco
import numpy as np
import pytest
from mujoco_trees import mujoco_model

from fesloop.errors import InputError
from fesloop.hand import kinematics, motion, quaternion
from fesloop.hand import motion as motion_kernels
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from plants.imus.finger_imus import chain_samples


def drawn(tree, count, seed=0):
    """Angles, rates and accelerations as of fast hands, and how the root moves."""
    rng = np.random.default_rng(seed)
    freedoms = len(tree.ranges)
    joints = (rng.uniform(tree.ranges[:, 0], tree.ranges[:, 1], (count, freedoms)),
              rng.normal(scale=10.0, size=(count, freedoms)), rng.normal(scale=100.0, size=(count, freedoms)))
    orientation = quaternion.normalized(rng.normal(size=(count, 4)))
    return joints, (orientation, *(rng.normal(scale=scale, size=(count, 3)) for scale in (3.0, 30.0, 10.0)))


def on_every_segment(tree, seed=2):
    places = np.random.default_rng(seed).normal(scale=0.02, size=(len(tree.names), 3))
    return motion.sensor_points(tree, tree.names, places)


@pytest.mark.parametrize("side", ["left", "right"])
def test_samples_equal_mujocos_site_sensors(side):
    tree = hand_tree(HandSize(side=side))
    sensors = on_every_segment(tree)
    model = mujoco_model(tree, sensors)
    record = mujoco.MjData(model)
    (angles, rates, accelerations), (orientation, turning, turning_up, linear) = drawn(tree, 200)
    root = motion.root_motion(orientation, turning, turning_up, linear)
    ours = motion.sensed(tree, sensors, angles, rates, accelerations, root)
    expected = []
    for t in range(200):
        record.qpos[:] = np.concatenate([np.zeros(3), orientation[t], angles[t]])
        record.qvel[:] = np.concatenate([[0.3, -0.2, 0.1], turning[t], rates[t]])
        record.qacc[:] = np.concatenate([linear[t], turning_up[t], accelerations[t]])
        mujoco.mj_inverse(model, record)
        expected.append(record.sensordata.reshape(-1, 2, 3).copy())
    expected = np.array(expected)
    np.testing.assert_allclose(ours.gyr, expected[:, :, 0], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(ours.acc, expected[:, :, 1], rtol=0.0, atol=1e-8)


def test_specific_force_is_the_second_difference_of_position_less_gravity():
    tree = hand_tree(HandSize(side="left"))
    rng = np.random.default_rng(5)
    phase, step = rng.uniform(0.0, 2.0 * np.pi, 23), 1e-4
    time = step * np.arange(-1, 2)[:, np.newaxis]
    angles, rates = 0.4 * np.sin(6.0 * time + phase), 2.4 * np.cos(6.0 * time + phase)
    accelerations = -14.4 * np.sin(6.0 * time + phase)
    place = np.array([[0.004, -0.01, 0.002]])
    ours = motion.sensed(tree, motion.sensor_points(tree, ["F4d"], place), angles, rates, accelerations)
    poses = kinematics.segment_poses(tree, angles)
    where = kinematics.points(tree, poses, "F4d", place[0])
    force = (where[0] - 2.0 * where[1] + where[2]) / step**2 + np.array(motion.UPWARDS)
    own = quaternion.rotate(quaternion.conjugate(poses.orientation[1, tree.index("F4d")]), force)
    np.testing.assert_allclose(ours.acc[1, 0], own, atol=1e-5)


def test_the_index_finger_of_a_still_right_hand_feels_what_the_planar_chain_says():
    size = HandSize()
    tree = hand_tree(size)
    names = ("hand", "F2p", "F2m", "F2d")
    sensors = motion.sensor_points(tree, names, -0.5 * tree.geometry[[tree.index(name) for name in names], 4])
    up = np.array([-6.0, 1.0, np.sqrt(9.80665**2 - 37.0)])
    finger = [tree.freedom(f"F2_{joint}_flexion") for joint in ("mcp", "pip", "dip")]
    whole, planar = np.zeros((3, 23)), np.array([[0.4, 0.9, 0.3], [5.0, -7.0, 9.0], [80.0, 50.0, -60.0]])
    whole[:, finger] = planar
    ours = motion.sensed(tree, sensors, *whole, motion.root_motion(upwards=up))
    expected = np.empty((2, 4, 3))
    chain_samples(*planar, size.segments[1], up, expected)
    np.testing.assert_allclose(ours.gyr, expected[0], atol=1e-12)
    np.testing.assert_allclose(ours.acc, expected[1], atol=1e-12)


def test_a_hand_at_rest_feels_gravity_alone():
    tree = hand_tree(HandSize())
    angles = drawn(tree, 1)[0][0]
    still = np.zeros_like(angles)
    ours = motion.sensed(tree, on_every_segment(tree), angles, still, still)
    assert np.abs(ours.gyr).max() == 0.0
    up = quaternion.rotate(kinematics.segment_poses(tree, angles).orientation, ours.acc)
    np.testing.assert_allclose(up, np.broadcast_to(motion.UPWARDS, up.shape), atol=1e-12)


@pytest.mark.slow
def test_kernels_at_rate_equal_batch_and_plain_python():
    tree = hand_tree(HandSize())
    sensors = on_every_segment(tree)
    (angles, rates, accelerations), moving = drawn(tree, 1)
    root = motion.root_motion(*moving)
    batch = motion.sensed(tree, sensors, angles, rates, accelerations, root)
    for form in (lambda kernel: kernel, lambda kernel: kernel.py_func):
        chain, work, samples = np.empty((17, 3, 3)), np.empty((3, 3)), np.empty((2, 17, 3))
        form(motion_kernels.motions)(tree.layout, tree.geometry, angles[0], rates[0], accelerations[0],
                                     root[0], chain)
        form(motion_kernels.sense)(chain, sensors.segments, sensors.places, work, samples)
        np.testing.assert_allclose(samples[0], batch.gyr[0], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(samples[1], batch.acc[0], rtol=0.0, atol=1e-10)


def test_unknown_segments_and_missing_places_are_named():
    tree = hand_tree(HandSize())
    with pytest.raises(InputError, match="did you mean 'F1m'"):
        motion.sensor_points(tree, ["F1mm"], [[0.0, 0.0, 0.0]])
    with pytest.raises(InputError, match=r"shape \(1, 3\); allowed: \(2, 3\)"):
        motion.sensor_points(tree, ["F1m", "hand"], [[0.0, 0.0, 0.0]])

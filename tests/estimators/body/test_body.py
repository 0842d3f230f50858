import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.body.body import body_of, chain_up, place_tips, spread_tips
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import relative_orientations, segment_poses
from fesloop.hand.segments import Segment

HAND = HandSize(side="left")


def test_seventeen_sensors_sit_on_every_segment_and_sixteen_leave_the_forearm_out():
    whole, fingers = body_of(17, HAND, (), ()), body_of(16, HAND, (), ())
    assert whole.sensed.tolist() == list(range(17))
    assert fingers.sensed.tolist() == list(range(1, 17))
    assert [whole.joints[k] for k in range(17) if not whole.seen()[k]] == [""]
    assert [fingers.joints[k] for k in range(17) if not fingers.seen()[k]] == ["", "wrist"]
    assert [whole.tree.names[k] for k in whole.tips] == ["F1d", "F2d", "F3d", "F4d", "F5d"]


def test_a_strip_left_off_leaves_its_joints_unseen():
    names = tuple(n for n in body_of(17, HAND, (), ()).tree.names if not n.startswith("F3"))
    body = body_of(14, HAND, (), names)
    unseen = [body.joints[k] for k in range(1, 17) if not body.seen()[k]]
    assert unseen == ["F3_mcp", "F3_pip", "F3_dip"]


@pytest.mark.parametrize(("sensors", "sensed", "text"), [
    (2, (), "name the sensors' segments"), (2, ("hand", "F2q"), "F2q"), (2, ("hand", "hand"), "twice"),
    (3, ("hand", "F2p"), "one name a sensor")])
def test_names_that_do_not_fit_are_named(sensors, sensed, text):
    with pytest.raises(InputError, match=text):
        body_of(sensors, HAND, (), sensed)


def test_a_hand_beside_another_tree_is_refused():
    with pytest.raises(InputError, match="one of the two"):
        body_of(1, HAND, (Segment(name="root"),), ())


def _tips_of(body, relative):
    orientations, positions = np.empty((17, 4)), np.zeros((17, 3))
    tips = np.empty((5, 3))
    chain_up(body.tree.layout, relative, orientations)
    place_tips(body.tree.layout, body.tree.geometry, orientations, body.tips, positions, tips)
    return orientations, positions, tips


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_fingertips_are_those_of_the_dual_quaternions_and_their_spread_that_of_samples(seed):
    rng = np.random.default_rng(seed)
    body = body_of(17, HAND, (), ())
    tree = body.tree
    angles = rng.uniform(-1.0, 1.0, 23)
    relative = relative_orientations(tree, angles)
    orientations, positions, tips = _tips_of(body, relative)
    assert np.abs(tips - segment_poses(tree, angles).position[body.tips]).max() < 1e-14
    roots = 0.02 * rng.normal(size=(17, 3, 3))
    covariance = roots @ roots.transpose(0, 2, 1)
    sd = np.empty((5, 3))
    spread_tips(tree.layout, tree.geometry, orientations, positions, covariance, body.tips, sd)
    step = 1e-6
    variance = np.zeros((5, 3))
    for k in range(1, 17):
        moved = np.empty((3, 5, 3))
        for a in range(3):
            turned = relative.copy()
            turned[k] = quaternion.multiply(turned[k], quaternion.from_axis_angle(np.eye(3)[a], step))
            moved[a] = (_tips_of(body, turned)[2] - tips) / step
        variance += np.einsum("atx,ab,btx->tx", moved, covariance[k], moved)
    assert np.allclose(sd, np.sqrt(variance), rtol=1e-4, atol=1e-8)

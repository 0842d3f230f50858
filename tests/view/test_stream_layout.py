"""What channels of a stream are of a hand, against kinematics by matrices."""

import numpy as np
import pytest
from homogeneous import segment_matrices
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.show.view.posture_stream import layout_of
from fesloop.streams.live.description import Channel

SIZE = HandSize()
TREE = hand_tree(SIZE)
RESTING = np.deg2rad([RESTING_DEG[name] for name in TREE.freedoms])
SHARES = st.lists(st.floats(0.0, 1.0), min_size=23, max_size=23)


def from_forearm(poses):
    """Positions and matrices of all segments, in the frame of the forearm."""
    back = quaternion.conjugate(poses.orientation[0])
    turns = quaternion.to_matrix(quaternion.multiply(back, poses.orientation))
    return quaternion.rotate(back, poses.position - poses.position[0]), turns


def require(poses, angles):
    matrices = segment_matrices(TREE, angles)
    places, turns = from_forearm(poses)
    np.testing.assert_allclose(places, matrices[:, :3, 3], atol=1e-9)
    np.testing.assert_allclose(turns, matrices[:, :3, :3], atol=1e-9)


def labelled(names, unit=""):
    return [Channel(name, unit, "") for name in names]


@settings(max_examples=15, deadline=None)
@given(shares=SHARES, order=st.permutations(range(23)))
def test_named_angles_in_any_order_and_in_degrees(shares, order):
    low, high = TREE.ranges.T
    angles = low + np.array(shares) * (high - low)
    layout = layout_of(labelled([TREE.freedoms[i] for i in order], "deg"), 23, SIZE, "stream")
    require(layout.poses_of(np.rad2deg(angles)[list(order)]), angles)


def test_angles_without_names_are_those_of_the_hand_in_order():
    angles = np.random.default_rng(3).uniform(0.0, 0.5, 23)
    for channels in ((), labelled(map(str, range(23)), "rad")):
        require(layout_of(channels, 23, SIZE, "stream").poses_of(angles), angles)


@pytest.mark.parametrize("channels", [(), labelled(["MCP", "PIP", "DIP"], "rad"), labelled("012", "rad")])
def test_three_angles_are_an_index_fingers_in_a_hand_at_rest(channels):
    posture = RESTING.copy()
    for name, angle in zip(("mcp", "pip", "dip"), (0.3, 0.8, 0.4), strict=True):
        posture[TREE.freedom(f"F2_{name}_flexion")] = angle
    require(layout_of(channels, 3, SIZE, "stream").poses_of(np.array([0.3, 0.8, 0.4])), posture)


@settings(max_examples=15, deadline=None)
@given(shares=SHARES, named=st.booleans())
def test_orientations_place_the_fingers(shares, named):
    low, high = TREE.ranges.T
    angles = low + np.array(shares) * (high - low)
    turns = segment_matrices(TREE, angles)[:, :3, :3]
    q = np.stack([quaternion.normalized(_quaternion(turn)) for turn in turns])
    channels = labelled([f"{name} {part}" for name in TREE.names for part in "wxyz"]) if named else ()
    layout = layout_of(channels, 68, SIZE, "stream")
    assert layout.turns
    require(layout.poses_of(3.0 * q.ravel()), angles)


def _quaternion(turn):
    """(w, x, y, z) of a rotation matrix, as the eigenvector of Bar-Itzhack's matrix (2000)."""
    m = turn
    k = np.array([[m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
                  [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
                  [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
                  [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)]])
    x, y, z, w = np.linalg.eigh(k)[1][:, -1]
    return np.array([w, x, y, z])


def test_a_segment_without_a_sensor_turns_with_the_one_it_hangs_on():
    names = [name for name in TREE.names if name not in ("forearm", "F3d")]
    layout = layout_of(labelled([f"{name} {part}" for name in names for part in "wxyz"]), 60, SIZE, "stream")
    turn = quaternion.normalized([0.5, 0.1, -0.7, 0.3])
    poses = layout.poses_of(np.tile(turn, len(names)))
    np.testing.assert_allclose(poses.orientation, np.tile(turn, (17, 1)), atol=1e-12)


def test_what_is_lost_is_not_a_number_and_what_hangs_on_it():
    sample = np.tile([1.0, 0.0, 0.0, 0.0], 17)
    sample[4 * TREE.index("F4m"):4 * TREE.index("F4m") + 4] = np.nan
    sample[4 * TREE.index("F5d"):4 * TREE.index("F5d") + 4] = 0.0
    poses = layout_of((), 68, SIZE, "stream").poses_of(sample)
    lost = np.isnan(poses.position).any(axis=-1)
    assert [TREE.names[k] for k in np.flatnonzero(lost)] == ["F4m", "F4d", "F5d"]


@pytest.mark.parametrize(("channels", "count"), [
    ((), 9), (labelled(["gyr_x", "gyr_y"]), 2), ((), 0), (labelled(["F2p w", "F2p x", "F2p y"]), 3),
    (labelled(["MCP", "PIP", "DIP"], "kg"), 3)])
def test_channels_of_something_else_are_refused(channels, count):
    with pytest.raises(InputError, match="stream"):
        layout_of(channels, count, SIZE, "stream")


@pytest.mark.parametrize(("labels", "named"), [
    (["F2_mcp_flexion", "F2_pip_flexion", "F2_mcp_flexion"], "2 channels of F2_mcp_flexion"),
    (["MCP", "PIP", "F2_mcp_flexion"], "2 channels of F2_mcp_flexion"),
    ([f"F2p {part}" for part in "wxyz"] + ["F2p w"], "2 channels of F2p w")])
def test_two_channels_of_the_same_are_refused(labels, named):
    with pytest.raises(InputError, match=f"stream: has {named}; allowed: one; give each a label"):
        layout_of(labelled(labels), len(labels), SIZE, "stream")


def test_channels_of_something_else_may_be_called_alike():
    layout = layout_of(labelled(["battery", "F2_pip_flexion", "battery"]), 3, SIZE, "stream")
    posture = RESTING.copy()
    posture[TREE.freedom("F2_pip_flexion")] = 0.7
    require(layout.poses_of(np.array([9.0, 0.7, 9.0])), posture)

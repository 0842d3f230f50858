"""Trees: what they derive from their segments, and what they refuse."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand.segments import Segment, SegmentTree

ROOT = Segment(name="trunk")
ARM = Segment(name="arm", parent="trunk", joint="saddle", joint_name="shoulder", offset=(0.0, 0.3, 0.0))
HAND = Segment(name="hand", parent="arm", joint="hinge", joint_name="wrist", ranges=((-1.0, 1.2),))
LEG = Segment(name="leg", parent="trunk", joint="ball", joint_name="hip")


def test_a_tree_knows_its_freedoms_and_what_they_move():
    tree = SegmentTree((ROOT, ARM, HAND, LEG))
    assert tree.freedoms == ("shoulder_flexion", "shoulder_abduction", "wrist_flexion", "hip_flexion",
                             "hip_abduction", "hip_pronation")
    assert tree.moved.astype(int).tolist() == [[0] * 6, [1, 1, 0, 0, 0, 0], [1, 1, 1, 0, 0, 0],
                                               [0, 0, 0, 1, 1, 1]]
    assert tree.ranges[2].tolist() == [-1.0, 1.2]
    assert tree.ranges[3].tolist() == [-np.pi, np.pi]
    assert tree.index("hand") == 2
    assert tree.freedom("wrist_flexion") == 2


def test_trees_are_equal_by_their_segments_and_survive_pickling():
    tree = SegmentTree((ROOT, ARM))
    again = pickle.loads(pickle.dumps(tree))
    assert again == tree
    assert again != SegmentTree((ROOT, LEG))
    np.testing.assert_array_equal(again.geometry, tree.geometry)
    with pytest.raises(ValueError, match="read-only"):
        tree.geometry[0, 0, 0] = 1.0


@given(st.floats(-1.0, 1.0), st.floats(0.0, 2.0 * np.pi))
def test_a_hinges_frame_is_right_handed_about_any_axis(z, around):
    across = np.sqrt(1.0 - z * z)
    axis = (across * np.cos(around), across * np.sin(around), z)
    frame = Segment(name="hand", parent="arm", joint="hinge", axes=(axis,)).frame
    np.testing.assert_allclose(frame[0], axis)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-6)
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("segments", "said"), [
    ((), "no segment"),
    ((ARM,), "is first and not a root"),
    ((ROOT, ROOT), "given twice"),
    ((ROOT, Segment(name="other")), "a second root"),
    ((ROOT, HAND, ARM), "list parents before their children"),
    ((ROOT, Segment(name="arm", parent="trunkk")), "did you mean 'trunk'"),
])
def test_what_is_no_tree_is_refused_in_one_line(segments, said):
    with pytest.raises(InputError, match=said) as caught:
        SegmentTree(segments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("fields", "said"), [
    ({"joint": "slider"}, "'slider'; allowed: fixed, hinge, saddle, ball"),
    ({"base": (0.0, float("nan"), 0.0)}, "three finite numbers"),
    ({"joint": "hinge", "axes": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))}, "2 of them; allowed: 1"),
    ({"joint": "hinge", "axes": ((0.0, 0.0, 2.0),)}, "unit vectors"),
    ({"joint": "saddle", "axes": ((0.0, 0.0, 1.0), (0.6, 0.0, 0.8))}, "at right angles"),
    ({"joint": "ball", "axes": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0))}, "first x second"),
    ({"joint": "hinge", "ranges": ((1.0, -1.0),)}, "low < high"),
])
def test_impossible_joints_are_refused_in_one_line(fields, said):
    with pytest.raises(InputError, match=said) as caught:
        Segment(name="arm", parent="trunk", **fields)
    assert "\n" not in str(caught.value)

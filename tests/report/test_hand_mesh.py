"""The hand's meshes enclose what the pictures' hand encloses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_parts import euler_characteristic, require_closed, volume, winding_numbers

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.flesh import flesh, flesh_distances
from fesloop.show.picture.hand_mesh import FOREARM_SHOWN, NOTHING, segment_meshes

SHARES = st.lists(st.floats(0.0, 1.0), min_size=23, max_size=23)
NEAR_M = 1.5e-3


@pytest.fixture(scope="module")
def meshes():
    return segment_meshes(HandSize())


def placed(size, meshes, shares):
    """The drawn flesh, and vertices of each segment's mesh, at these shares of every range."""
    tree = hand_tree(size)
    low, high = tree.ranges.T
    poses = segment_poses(tree, low + np.array(shares) * (high - low))
    vertices = [poses.position[k] + quaternion.rotate(poses.orientation[k], mesh.vertices)
                for k, mesh in enumerate(meshes)]
    return flesh(size, poses), vertices


@settings(max_examples=4, deadline=None)
@given(side=st.sampled_from(["left", "right"]), hand_mm=st.floats(150.0, 220.0))
def test_every_segment_is_closed_and_of_one_piece(side, hand_mm):
    size = HandSize(side=side, hand_mm=hand_mm)
    found = segment_meshes(size)
    assert len(found) == len(hand_tree(size).segments)
    for mesh in found:
        require_closed(mesh)
        assert euler_characteristic(mesh) == 2
        assert volume(mesh) > 0.0
    assert 3000 < sum(len(mesh.faces) for mesh in found) < 9000


@settings(max_examples=15, deadline=None)
@given(shares=SHARES)
def test_in_any_posture_the_meshes_lie_under_the_drawn_skin(meshes, shares):
    drawn, vertices = placed(HandSize(), meshes, shares)
    for each in vertices:
        assert flesh_distances(each, drawn).max() < 1e-5


@settings(max_examples=6, deadline=None)
@given(shares=SHARES, seed=st.integers(0, 1000))
def test_what_is_inside_the_drawn_hand_is_inside_a_mesh(meshes, shares, seed):
    drawn, vertices = placed(HandSize(), meshes, shares)
    chances = np.random.default_rng(seed)
    points = np.concatenate(vertices[1:])[chances.integers(0, 2000, 60)]
    points = points + chances.normal(scale=0.006, size=points.shape)
    depth = flesh_distances(points, drawn)
    # Where two segments meet the pictures' flesh is rounded, by a quarter of their blending at most.
    sure = (depth < -0.25 * drawn.blends.max() - NEAR_M) | (depth > NEAR_M)
    inside = np.zeros(len(points), dtype=bool)
    for mesh, each in zip(meshes, vertices, strict=True):
        inside |= winding_numbers(each, mesh.faces, points) > 0.5
    np.testing.assert_array_equal(inside[sure], depth[sure] < 0.0)


def test_a_bent_joint_stays_closed():
    # A point just under the skin on the outer side of every bent finger joint, where a gap would open.
    size = HandSize()
    meshes = segment_meshes(size)
    tree = hand_tree(size)
    angles = np.zeros(23)
    angles[[tree.freedom(f"F{i}_{joint}_flexion") for i in range(2, 6) for joint in ("pip", "dip")]] = 1.2
    poses = segment_poses(tree, angles)
    for finger in ("F2", "F3", "F4", "F5"):
        for near, far in (("p", "m"), ("m", "d")):
            k, after = tree.index(finger + near), tree.index(finger + far)
            outer = sum(quaternion.rotate(poses.orientation[each], [size.outwards, 0.0, 0.0])
                        for each in (k, after))
            point = poses.position[k] + 0.005 * outer / np.linalg.norm(outer)
            around = [winding_numbers(
                poses.position[each] + quaternion.rotate(poses.orientation[each], meshes[each].vertices),
                meshes[each].faces, point[np.newaxis])[0] for each in (k, after)]
            assert max(around) > 0.99


def test_the_shown_forearm_ends_where_it_should_or_is_not_there(meshes):
    size = HandSize()
    ends = meshes[0].vertices[:, 1] * size.outwards
    belly = 0.2 * 1e-3 * size.hand_mm
    assert -FOREARM_SHOWN * size.forearm - belly < ends.min() < -FOREARM_SHOWN * size.forearm
    assert segment_meshes(size, forearm=False)[0] is NOTHING

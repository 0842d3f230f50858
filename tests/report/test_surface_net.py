"""Surfaces of shapes whose volume, genus and distance are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_parts import euler_characteristic, require_closed, volume

from fesloop.show.picture.hand_mesh import surface_net

CORNER = np.array([0.06, 0.06, 0.06])


def ball(radius, middle=(0.0, 0.0, 0.0)):
    return lambda points: np.linalg.norm(points - np.array(middle), axis=1) - radius


def ring(points):
    """A torus of radii 35 and 12 mm."""
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.035, points[:, 2]) - 0.012


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(radius=st.floats(0.01, 0.04), middle=st.tuples(*[st.floats(-0.01, 0.01)] * 3))
def test_a_ball_wherever_it_lies_on_the_grid(radius, middle):
    mesh = surface_net(ball(radius, middle), -CORNER, CORNER, 0.004)
    require_closed(mesh)
    assert euler_characteristic(mesh) == 2
    np.testing.assert_allclose(ball(radius, middle)(mesh.vertices), 0.0, atol=1e-7)
    # Triangles that a cell h holds are within h / sqrt(2) of their middle: 3 h^2 / 8 r^2 of a ball lies over
    # them, more where cells are cut askew.
    share = volume(mesh) / (4.0 / 3.0 * np.pi * radius**3)
    assert 1.0 - 0.6 * (0.004 / radius) ** 2 < share < 1.0


def test_a_ring_has_its_hole():
    mesh = surface_net(ring, -CORNER, CORNER, 0.003)
    require_closed(mesh)
    assert euler_characteristic(mesh) == 0
    assert volume(mesh) == pytest.approx(2.0 * np.pi**2 * 0.035 * 0.012**2, rel=0.03)
    np.testing.assert_allclose(ring(mesh.vertices), 0.0, atol=1e-7)


def test_normals_point_outwards_everywhere():
    mesh = surface_net(ring, -CORNER, CORNER, 0.003)
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle, ahead = corners.mean(axis=1), 1e-3 * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    assert (ring(middle + ahead) > ring(middle)).all()

"""Meshes of hands and solids are where geometry says, and are lit, outlined and painted accordingly."""

import numpy as np
import pytest

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.flesh import flesh, flesh_distances, nearest_segments
from fesloop.show.picture.hand_mesh import hand_surface
from fesloop.show.picture.render import (
    Camera,
    Frame,
    Solid,
    Surface,
    ambient_share,
    best_view,
    lamp_share,
    over,
    painted,
    solid_surface,
    vignetted,
)

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
TURNED = np.array([0.5, 0.5, -0.5, 0.5])
SKIN = (0.9, 0.8, 0.7)
BLUE = (0.0, 0.0, 1.0)
PIXEL = 2.5e-4
SOLIDS = [("box", (0.02, 0.03, 0.01)), ("cylinder", (0.02, 0.03, 0.0)), ("sphere", (0.025, 0.0, 0.0))]


def solid(kind, half, place=(0.0, 0.0, 0.0), turn=UPRIGHT, colour=SKIN):
    return Solid(kind, np.array(place), turn, np.array(half), colour)


def frame(half=0.05, pixel=PIXEL, along=(0.0, 1.0, -0.3)):
    return Frame(Camera.towards(along), np.array([-half, -half]), np.array([half, half]), pixel)


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
def test_a_solids_distance_is_that_to_the_nearest_of_its_points(kind, half):
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.035, 0.035, (400_000, 3))
    if kind == "box":
        inside = (np.abs(points) < half).all(axis=1)
    elif kind == "cylinder":
        inside = (np.hypot(points[:, 0], points[:, 1]) < half[0]) & (np.abs(points[:, 2]) < half[1])
    else:
        inside = np.linalg.norm(points, axis=1) < half[0]
    shift = np.array([0.01, 0.02, -0.03])
    body = solid(kind, half, shift, TURNED)
    placed = shift + quaternion.rotate(TURNED, points[inside])
    directions = rng.normal(size=(12, 3))
    outside = shift + 0.06 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    nearest = [np.linalg.norm(placed - each, axis=1).min() for each in outside]
    np.testing.assert_allclose(body.distances(outside), nearest, atol=1.5e-3)
    assert (body.distances(placed) < 0.0).all()


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
def test_a_solids_mesh_lies_on_its_surface_and_faces_outwards(kind, half):
    body = solid(kind, half, (0.01, 0.02, -0.03), TURNED)
    found = solid_surface(body)
    np.testing.assert_allclose(body.distances(found.vertices), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0)
    np.testing.assert_allclose(body.distances(found.vertices + 1e-3 * found.normals), 1e-3, atol=1e-5)
    a, b, c = (found.vertices[found.faces[:, i]] for i in range(3))
    outwards = np.cross(b - a, c - a)
    assert ((outwards * (a + b + c - 3.0 * body.position)).sum(axis=1) > 0.0).all()


def test_a_sphere_is_painted_as_a_disc_of_its_radius():
    view = frame()
    picture = painted(view, [solid_surface(solid("sphere", (0.02, 0.0, 0.0))).facing(view.camera)])
    assert picture.shape == (*view.shape, 4)
    # Gouraud triangles reach half a pixel beyond their edges.
    assert picture[..., 3].sum() * PIXEL**2 == pytest.approx(np.pi * (0.02 + 0.5 * PIXEL)**2, rel=0.005)
    there = picture[..., 3] > 0.99
    np.testing.assert_allclose(picture[there][:, :3], np.tile(SKIN, (there.sum(), 1)), atol=0.01)
    rows, columns = np.nonzero(there)
    assert (rows.mean(), columns.mean()) == pytest.approx((199.5, 199.5), abs=1.0)


def test_what_is_nearer_hides_what_is_behind_it():
    view = frame()
    behind = solid_surface(solid("sphere", (0.02, 0.0, 0.0)))
    ahead = solid_surface(solid("sphere", (0.01, 0.0, 0.0), -0.03 * view.camera.along, colour=BLUE))
    for order in ([behind, ahead], [ahead, behind]):
        middle = painted(view, [each.facing(view.camera) for each in order])[200, 200]
        np.testing.assert_allclose(middle, [0.0, 0.0, 1.0, 1.0], atol=0.01)


def test_opacity_is_even_without_seams_between_triangles():
    view = frame()
    found = solid_surface(solid("box", (0.02, 0.02, 0.02))).facing(view.camera)
    found.colours[:, 3] = 0.5
    inner = painted(view, [found])[180:220, 180:220]
    np.testing.assert_allclose(inner[..., 3], 0.5, atol=0.01)


def test_nothing_is_painted_where_there_is_no_surface():
    view = frame()
    nothing = Surface(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((0, 4)))
    assert not painted(view, [nothing])[..., 3].any()


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
def test_an_outline_runs_round_the_edge_of_what_is_seen(kind, half):
    view = frame()
    surface = solid_surface(solid(kind, half))
    whole = painted(view, [surface.facing(view.camera)])[..., 3] > 0.5
    line = painted(view, [surface.outline(view.camera, alpha=1.0)])[..., 3] > 0.2
    inside = whole.copy()
    for shift in ((4, 0), (-4, 0), (0, 4), (0, -4)):
        inside &= np.roll(whole, shift, (0, 1))
    edge = whole & ~np.roll(whole, 1, 0)
    around = sum(np.roll(line, shift, (0, 1)) for shift in ((0, 0), (1, 0), (-1, 0), (2, 0), (-2, 0)))
    assert (around[edge] > 0).mean() > 0.97
    assert line[inside].mean() < 0.05


def test_a_table_is_dark_under_a_ball_and_light_far_from_it():
    table, ball = solid("box", (0.3, 0.3, 0.005), (0.0, 0.0, -0.025)), solid("sphere", (0.02, 0.0, 0.0))
    camera = Camera.towards((0.0, 0.6, -0.8))
    top = solid_surface(table)
    top = top.vertices[top.normals[:, 2] > 0.5]
    up = np.tile([0.0, 0.0, 1.0], (len(top), 1))

    def distances(points):
        return np.minimum(table.distances(points), ball.distances(points))

    lit, ambient = lamp_share(top, up, camera, distances), ambient_share(top, up, distances)
    assert lit.min() < 0.02
    assert np.median(lit) > 0.95
    far = np.linalg.norm(top[:, :2], axis=1)
    assert ambient[far < 0.01].max() < ambient[far > 0.05].min()
    shaded = solid_surface(table).lit(camera, distances)
    light = shaded.colours[shaded.normals[:, 2] > 0.5][:, :3].mean(axis=1)
    assert light[lit < 0.02].max() < np.median(light[lit > 0.99])


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_mesh_of_a_hand_lies_on_its_skin_and_encloses_the_ends_of_bones(side):
    size = HandSize(side=side)
    poses = segment_poses(hand_tree(size), np.zeros(23))
    shape = flesh(size, poses)
    mesh = hand_surface(shape, 0.004)
    np.testing.assert_allclose(flesh_distances(mesh.vertices, shape), 0.0, atol=1e-5)
    assert {4, 7, 10, 13, 16} <= set(nearest_segments(mesh.vertices, shape).tolist())
    # From the back of the flat hand, where nothing hides anything.
    camera = Camera.towards((-size.outwards, 0.2, -0.3))
    seen = camera.seen(poses.position)
    low, high = seen[:, :2].min(axis=0) - 0.03, seen[:, :2].max(axis=0) + 0.03
    plain = Surface(mesh.vertices, np.zeros_like(mesh.vertices), mesh.faces, np.ones((len(mesh.vertices), 4)))
    picture = painted(Frame(camera, low, high, 1e-3), [plain.facing(camera)])
    columns = ((seen[:, 0] - low[0]) / 1e-3).astype(int)
    rows = ((high[1] - seen[:, 1]) / 1e-3).astype(int)
    assert (picture[rows, columns, 3] > 0.99).all()


def test_a_second_picture_is_laid_over_without_hiding_what_it_covers():
    first, ghost = np.zeros((1, 4, 4)), np.zeros((1, 4, 4))
    first[0, :2] = (0.2, 0.4, 0.6, 1.0)
    ghost[0, 1:3] = (0.8, 0.3, 0.0, 0.4)
    laid = over(first, ghost)[0]
    np.testing.assert_allclose(laid[0], first[0, 0])
    np.testing.assert_allclose(laid[1], [0.44, 0.36, 0.36, 1.0])
    np.testing.assert_allclose(laid[2], ghost[0, 2])
    np.testing.assert_allclose(laid[3], 0.0)


def test_a_picture_fades_at_its_edge():
    faded = vignetted(np.ones((4, 6, 4)), 2)
    assert faded[0, :, 3].max() < 0.5
    assert faded[1, 2, 3] < 1.0
    assert (vignetted(np.ones((8, 12, 4)), 2)[3:5, 3:9, 3] == 1.0).all()


def test_a_view_shows_motion_from_the_side_and_keeps_upright():
    times = np.linspace(0.0, 1.0, 5)[:, np.newaxis]
    place = np.stack([np.zeros((5, 4)), 0.1 * np.linspace(0, 1, 4) * np.ones((5, 1)),
                      0.1 * times * np.ones((1, 4))], axis=-1)
    for liked in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        camera = best_view(place, place, np.array(liked))
        assert camera.along @ np.array(liked) < -0.9
        assert camera.along[2] < 0.0 < camera.up[2]
        assert camera.right[2] == 0.0

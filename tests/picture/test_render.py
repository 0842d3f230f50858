"""Rays find what geometry says they must: sizes, distances, normals, shadows, and a hand's own bones."""

import numpy as np
import pytest

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.camera import Camera, best_view
from fesloop.show.picture.distance_kernels import BALL, BOX, CYLINDER, blended, solid_distance
from fesloop.show.picture.flesh import Flesh, flesh
from fesloop.show.picture.render import AROUND_M, Frame, Solid, over, shaded, smaller, traced, vignetted

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
SKIN = (0.9, 0.8, 0.7)


def bars(*rows):
    """Bars each in a group of its own."""
    count = len(rows)
    return Flesh(np.array(rows).reshape(-1, 8), np.arange(count), np.full(count, 1e-3), np.full(count, 5))


def frame(half=0.05, pixel=2.5e-4, along=(0.0, 1.0, -0.3)):
    return Frame(Camera.towards(along), np.array([-half, -half]), np.array([half, half]), pixel)


def test_a_ball_is_a_disc_of_its_radius_its_nearest_point_in_the_middle():
    found = traced(frame(), bars([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02, 0.02]), ())
    there = found.surface == 0
    assert there.sum() * 2.5e-4**2 == pytest.approx(np.pi * 0.02**2, rel=0.01)
    assert found.depth.min() == pytest.approx(AROUND_M - 0.02, abs=2e-4)
    points = frame().points(found.depth)[there]
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.02, atol=2e-4)
    assert ((points * found.normal[there]).sum(axis=1) / 0.02 > 0.999).all()
    assert np.isinf(found.depth[~there]).all()


def test_a_bar_is_as_long_and_as_thick_as_it_says():
    found = traced(frame(along=(0.0, 1.0, -1e-9)), bars([-0.03, 0.0, 0.0, 0.03, 0.0, 0.0, 0.01, 0.01]), ())
    rows, columns = np.nonzero(found.surface == 0)
    assert np.ptp(columns) * 2.5e-4 == pytest.approx(0.08, abs=1e-3)
    assert np.ptp(rows) * 2.5e-4 == pytest.approx(0.02, abs=1e-3)


@pytest.mark.parametrize(("kind", "half"), [(BOX, (0.02, 0.03, 0.01)), (CYLINDER, (0.02, 0.03, 0.0)),
                                            (BALL, (0.025, 0.0, 0.0))])
def test_a_solids_distance_is_that_to_the_nearest_of_its_points(kind, half):
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.035, 0.035, (400_000, 3))
    if kind == BOX:
        inside = (np.abs(points) < half).all(axis=1)
    elif kind == CYLINDER:
        inside = (np.hypot(points[:, 0], points[:, 1]) < half[0]) & (np.abs(points[:, 2]) < half[1])
    else:
        inside = np.linalg.norm(points, axis=1) < half[0]
    turn = np.array([0.5, 0.5, -0.5, 0.5])
    shift = np.array([0.01, 0.02, -0.03])
    row = Solid(kind, shift, turn, np.array(half), SKIN).row
    matrix = row[4:13].reshape(3, 3)
    placed = points[inside] @ matrix.T + shift
    for direction in rng.normal(size=(12, 3)):
        outside = shift + 0.06 * direction / np.linalg.norm(direction)
        nearest = np.linalg.norm(placed - outside, axis=1).min()
        assert solid_distance(tuple(outside), row) == pytest.approx(nearest, abs=1.5e-3)


def test_blending_rounds_inwards_only_where_surfaces_are_near_each_other():
    assert blended(0.01, 0.05, 0.004) == 0.01
    assert blended(0.01, 0.01, 0.004) == pytest.approx(0.009)
    assert blended(0.01, 0.012, 0.004) == pytest.approx(0.01 - 0.25 * 0.004 * 0.5**2)


def test_a_table_is_dark_under_a_ball_and_light_far_from_it():
    table = Solid(BOX, np.array([0.0, 0.0, -0.025]), UPRIGHT, np.array([0.3, 0.3, 0.005]), SKIN)
    view = frame(half=0.15, pixel=1e-3, along=(0.0, 0.6, -0.8))
    found = traced(view, bars([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02, 0.02]), [table])
    assert set(np.unique(found.surface)) == {0, 1}
    ground = found.surface == 1
    assert found.lit[ground].min() < 0.02
    assert np.median(found.lit[ground]) > 0.95
    near = np.linalg.norm(view.points(found.depth)[..., :2], axis=-1) < 0.01
    assert found.ambient[ground & near].max(initial=0.0) < found.ambient[ground & ~near].max()
    picture = shaded(found, view.camera, np.broadcast_to(SKIN, (*found.depth.shape, 3)))
    light = picture[..., :3].mean(axis=-1)
    assert light[ground & (found.lit < 0.02)].max() < np.median(light[ground & (found.lit > 0.99)])


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_ends_of_bones_are_under_the_pixels_where_they_project_to(side):
    size = HandSize(side=side)
    poses = segment_poses(hand_tree(size), np.zeros(23))
    # From the back of the flat hand, where nothing hides anything.
    camera = Camera.towards((-size.outwards, 0.2, -0.3))
    seen = camera.seen(poses.position)
    low, high = seen[:, :2].min(axis=0) - 0.03, seen[:, :2].max(axis=0) + 0.03
    view = Frame(camera, low, high, 1e-3)
    found = traced(view, flesh(size, poses), (), shading=False)
    columns = ((seen[:, 0] - low[0]) / 1e-3).astype(int)
    rows = ((high[1] - seen[:, 1]) / 1e-3).astype(int)
    assert (found.surface[rows, columns] == 0).all()
    assert (found.depth[rows, columns] - AROUND_M < seen[:, 2]).all()
    drawn = flesh(size, poses)
    tips = [4, 7, 10, 13, 16]
    assert set(tips) <= set(np.unique(drawn.segments[found.bar[found.surface == 0]]))


def test_a_second_hand_is_laid_over_without_hiding_what_it_covers():
    behind = bars([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02, 0.02])
    ahead = bars([0.01, -0.03, 0.0, 0.01, -0.03, 0.0, 0.01, 0.01])
    first, ghost = traced(frame(), behind, ()), traced(frame(), ahead, (), shading=False)
    picture = shaded(first, frame().camera, np.broadcast_to(SKIN, (*first.depth.shape, 3)))
    laid = over(picture, first, ghost, (0.8, 0.3, 0.0), 0.4)
    both = (first.surface == 0) & (ghost.surface == 0)
    none = (first.surface < 0) & (ghost.surface < 0)
    assert both.any()
    np.testing.assert_allclose(laid[none], 0.0, atol=1e-12)
    assert (laid[both][:, 3] == 1.0).all()
    assert (np.abs(laid[both] - picture[both]).max(axis=1) > 0.01).all()
    only = (first.surface < 0) & (ghost.surface == 0)
    assert (laid[only][:, 3] < 1.0).all()


def test_a_picture_made_smaller_keeps_its_mean_colour_and_fades_at_its_edge():
    rng = np.random.default_rng(0)
    picture = np.concatenate([rng.uniform(size=(8, 12, 3)), np.ones((8, 12, 1))], axis=-1)
    small = smaller(picture, 2)
    assert small.shape == (4, 6, 4)
    np.testing.assert_allclose(small.mean(axis=(0, 1)), picture.mean(axis=(0, 1)))
    faded = vignetted(picture, 2)
    assert faded[0, :, 3].max() < 0.5
    assert (faded[3:5, 3:9, 3] == 1.0).all()


def test_a_view_shows_motion_from_the_side_and_keeps_upright():
    times = np.linspace(0.0, 1.0, 5)[:, np.newaxis]
    place = np.stack([np.zeros((5, 4)), 0.1 * np.linspace(0, 1, 4) * np.ones((5, 1)),
                      0.1 * times * np.ones((1, 4))], axis=-1)
    for liked in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        camera = best_view(place, place, np.array(liked))
        assert camera.along @ np.array(liked) < -0.9
        assert camera.along[2] < 0.0 < camera.up[2]
        assert camera.right[2] == 0.0

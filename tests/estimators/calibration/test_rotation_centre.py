"""The centre of arcs that are known, and arcs that have no single one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from estimators.calibration.rotation_centre import deviation_sum, rotation_centre
from fesloop.errors import InputError
from fesloop.hand import kinematics
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree

SEEDS = st.integers(0, 2**32 - 1)


def wrist_arcs(samples=300, deviation_deg=25.0):
    """Tip of F3, m, in the forearm's frame, whose origin is the centre: wrist flexion, then deviation."""
    tree = hand_tree(HandSize(side="left"))
    phase = np.linspace(0.0, 4 * np.pi, samples)
    angles = np.zeros((2 * samples, len(tree.ranges)))
    angles[:samples, tree.freedom("wrist_flexion")] = np.radians(50) * np.sin(phase)
    angles[samples:, tree.freedom("wrist_abduction")] = np.radians(deviation_deg) * np.sin(phase)
    return kinematics.segment_poses(tree, angles).position[:, tree.index("F3d")]


def elsewhere(points, seed):
    """Points in another frame, and where their origin is there."""
    rng = np.random.default_rng(seed)
    centre = rng.normal(size=3)
    return Rotation.random(rng=rng).apply(points) + centre, centre


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_the_wrist_of_the_kinematic_hand(seed):
    points, centre = elsewhere(wrist_arcs(), seed)
    found = rotation_centre(points)
    np.testing.assert_allclose(found.centre, centre, atol=1e-6)
    assert found.radius == pytest.approx(np.linalg.norm(points[0] - centre))
    assert found.deviation < 1e-6


@settings(deadline=None, max_examples=15)
@given(SEEDS)
def test_no_other_search_finds_less_deviation(seed):
    rng = np.random.default_rng(seed)
    points = elsewhere(wrist_arcs(100), seed)[0] + 1e-3 * rng.normal(size=(200, 3))
    found = rotation_centre(points)
    best = minimize(lambda c: deviation_sum(points, c), found.centre, method="Nelder-Mead",
                    options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000})
    assert deviation_sum(points, found.centre) <= best.fun * (1 + 1e-4)
    assert np.linalg.norm(found.centre - best.x) < found.sd


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_noise_moves_it_by_what_it_says(seed):
    # Markers within 1 mm (S19, section 3.1.1). Least absolute deviations of normal noise: sqrt(pi/2) the sd.
    points, centre = elsewhere(wrist_arcs(), seed)
    found = rotation_centre(points + 1e-3 * np.random.default_rng(seed).normal(size=points.shape))
    assert np.linalg.norm(found.centre - centre) < 5 * np.sqrt(np.pi / 2) * found.sd
    assert found.sd < 1e-3
    assert found.deviation == pytest.approx(np.sqrt(2 / np.pi) * 1e-3, rel=0.2)


def test_an_outlier_hardly_moves_it():
    points, centre = elsewhere(wrist_arcs(), 1)
    noisy = points + 1e-3 * np.random.default_rng(0).normal(size=points.shape)
    spoilt = noisy.copy()
    spoilt[77] += [0.3, -0.2, 0.1]
    clean, found = rotation_centre(noisy), rotation_centre(spoilt)
    assert np.linalg.norm(found.centre - clean.centre) < 1e-3
    squares = np.linalg.lstsq(np.hstack([2 * spoilt, np.ones((len(spoilt), 1))]),
                              np.sum(spoilt**2, axis=1), rcond=None)[0][:3]
    assert np.linalg.norm(squares - centre) > 3 * np.linalg.norm(found.centre - centre)


@settings(deadline=None, max_examples=25)
@given(SEEDS, st.sampled_from([0.0, 1e-4, 1e-3]), st.floats(20, 300))
def test_a_plane_arc_is_refused(seed, noise, reach_deg):
    rng = np.random.default_rng(seed)
    angle = np.radians(reach_deg) * np.linspace(-0.5, 0.5, 200)
    arc = 0.19 * np.stack([np.cos(angle), np.sin(angle), np.zeros(200)], axis=1)
    points = elsewhere(arc, seed)[0] + noise * rng.normal(size=arc.shape)
    with pytest.raises(InputError, match=r"positions: lie on one arc: .*move about another axis as well"):
        rotation_centre(points)


def test_a_little_deviation_of_the_wrist_is_enough():
    points, centre = elsewhere(wrist_arcs(deviation_deg=8.0), 3)
    found = rotation_centre(points + 5e-4 * np.random.default_rng(1).normal(size=points.shape))
    assert np.linalg.norm(found.centre - centre) < 2e-3


def test_unknown_positions_are_left_out_and_too_few_refused():
    points, centre = elsewhere(wrist_arcs(), 4)
    points[::3] = np.nan
    np.testing.assert_allclose(rotation_centre(points).centre, centre, atol=1e-6)
    with pytest.raises(InputError, match="positions: 9 are known; allowed: 10 or more"):
        rotation_centre(points[1:14])
    with pytest.raises(InputError, match=r"positions: shape \(4, 2\)"):
        rotation_centre(np.zeros((4, 2)))
    with pytest.raises(InputError, match="are all the same"):
        rotation_centre(np.ones((20, 3)))

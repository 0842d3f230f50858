"""Mountings found again from what sensors on a kinematic hand feel, and poses that cannot be believed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mounted_hand import NAMES, RATE, flat_then_bent, mounted
from scipy.spatial.transform import Rotation

from estimators.calibration.poses import PoseLimits
from estimators.calibration.sensor_to_segment import (
    assumed_mounting,
    calibrate_by_poses,
    dorsal,
    rotation_from_axes,
)
from fesloop.errors import InputError, InputErrors
from fesloop.hand import quaternion

SIDES = st.sampled_from(["left", "right"])
SEEDS = st.integers(0, 2**32 - 1)


def calibrated(flat, bent, side, **options):
    return calibrate_by_poses(*flat, bent.gyr, period_s=1 / RATE, side=side, names=NAMES, **options)


def away_deg(found, true):
    """Angle between rotations, deg."""
    return np.degrees(quaternion.rotation_angle(quaternion.relative(true, found)))


@settings(deadline=None, max_examples=25)
@given(SIDES, SEEDS)
def test_any_mounting_of_ideal_sensors_is_recovered(side, seed):
    rng = np.random.default_rng(seed)
    true = Rotation.random(len(NAMES), rng=rng).as_quat(scalar_first=True)
    flat, bent = flat_then_bent(side)
    found = calibrated(mounted(flat, true), mounted(bent, true), side)
    assert away_deg(found.rotations, true).max() < 1e-5
    assert np.abs(found.skew_deg).max() < 1e-5
    assert found.wobble_deg.max() < 1e-4
    assert found.quality.min() > 1 - 1e-9


@settings(deadline=None, max_examples=15)
@given(SIDES, SEEDS)
def test_noise_and_bias_move_it_by_what_they_imply(side, seed):
    # Kortier 2014, Table 1: 4e-2 m/s^2 a sample over 300 of them tilts by 1e-4 rad; accelerometer offsets of
    # 2e-2 m/s^2 by up to 2e-2 / 9.8 rad an axis; a bias of the gyroscopes is taken off.
    rng = np.random.default_rng(seed)
    true = Rotation.random(len(NAMES), rng=rng).as_quat(scalar_first=True)
    flat, bent = (mounted(part, true) for part in flat_then_bent(side))
    offset, bias = 2e-2 * rng.uniform(-1, 1, (len(NAMES), 3)), 0.05 * rng.uniform(-1, 1, (len(NAMES), 3))
    flat = (flat.gyr + bias + 5e-4 * rng.normal(size=flat.gyr.shape),
            flat.acc + offset + 4e-2 * rng.normal(size=flat.acc.shape))
    bent = bent._replace(gyr=bent.gyr + bias + 5e-4 * rng.normal(size=bent.gyr.shape))
    found = calibrated(flat, bent, side)
    tilt = np.linalg.norm(offset, axis=1) / 9.8
    assert (away_deg(found.rotations, true) <= np.degrees(tilt + 1e-3)).all()


@settings(deadline=None, max_examples=25)
@given(SIDES, st.floats(-8, 8), st.floats(-8, 8))
def test_an_imperfect_pose_costs_no_more_than_it_is_imperfect(side, tilt_deg, abduction_deg):
    # The table leans by `tilt`; the axis of flexion lies `abduction` off, as where a finger swings outwards.
    flat, bent = flat_then_bent(side, tilt_deg=tilt_deg, swerve_deg=abduction_deg)
    found = calibrated(flat, bent, side)
    off = away_deg(found.rotations, [1.0, 0.0, 0.0, 0.0])
    assert off.max() <= np.hypot(tilt_deg, abduction_deg) + 1e-3
    assert off.max() >= 0.4 * max(abs(tilt_deg), abs(abduction_deg)) - 1e-3


def test_there_and_back_again_is_flexion_as_well():
    flat, bent = flat_then_bent("left")
    back = bent._replace(gyr=np.concatenate([bent.gyr, -bent.gyr[::-1], bent.gyr[:150]]))
    found = calibrated(flat, back, "left")
    assert away_deg(found.rotations, [1.0, 0.0, 0.0, 0.0]).max() < 1e-5


def test_a_segment_of_other_directions_is_told_them():
    # A forearm that is lifted turns about -z, and a thumb that lies on its side has up along +z's neighbour.
    true = Rotation.random(2, rng=np.random.default_rng(3)).as_quat(scalar_first=True)
    ups, axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8]]), np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    inverse = quaternion.conjugate(true)
    acc = np.broadcast_to(9.81 * quaternion.rotate(inverse, ups), (100, 2, 3))
    gyr = np.broadcast_to(quaternion.rotate(inverse, axes), (100, 2, 3))
    found = calibrate_by_poses(np.zeros((100, 2, 3)), acc, gyr, period_s=0.01, side="left", verticals=ups,
                               axes=axes)
    assert away_deg(found.rotations, true).max() < 1e-5


@settings(deadline=None, max_examples=50)
@given(SEEDS)
def test_rotation_from_axes_solves_wahbas_problem(seed):
    rng = np.random.default_rng(seed)
    measured, known = rng.normal(size=(2, 2, 3))
    measured /= np.linalg.norm(measured, axis=1, keepdims=True)
    known /= np.linalg.norm(known, axis=1, keepdims=True)
    if min(np.linalg.norm(np.cross(*pair)) for pair in (measured, known)) < 0.15:
        return
    best = Rotation.align_vectors(known, measured)[0].as_quat(scalar_first=True)
    assert away_deg(rotation_from_axes(tuple(measured), tuple(known)), best) < 1e-5


def test_as_printed_eq_34_is_the_inverse_for_perpendicular_axes():
    x, z = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
    printed = np.stack([x, np.cross(z, x), z], axis=1)
    found = quaternion.to_matrix(rotation_from_axes((x, z), ([1.0, 0, 0], [0, 0, 1.0])))
    np.testing.assert_allclose(found, printed.T, atol=1e-12)


@pytest.mark.parametrize(("spoil", "found"), [
    ("moved", r"F2m: moved in the flat pose: 2\d\.\d deg/s"),
    ("slid", r"F2m: moved in the flat pose: .* spread by 0\.\d+"),
    ("short", r"hand: the flat pose was too short: 20 gyroscope samples; allowed: 50 or more"),
    ("units", r"F2m: the flat pose does not agree with gravity: 1\.00 m/s\^2"),
    ("lost", r"F2m: lost in the flat pose: 10 sound accelerometer samples of 300"),
    ("never bent", r"F2m: turned by \d+ deg in the flexion; allowed: 30 deg or more"),
    ("lost later", r"F2m: lost in the flexion: 0 sound gyroscope samples"),
    ("circled", r"F2m: the flexion was about several axes: \d+ deg off one"),
    ("not perpendicular", r"F2m: vertical and flexion axis are [+-]\d+\.\d deg from the angle"),
])
def test_a_pose_that_cannot_be_believed_names_sensor_and_remedy(spoil, found):
    flat, bent = flat_then_bent("right")
    gyr, acc, turn, i = flat.gyr.copy(), flat.acc.copy(), bent.gyr.copy(), NAMES.index("F2m")
    if spoil == "moved":
        gyr[100:130, i, 1] += 0.4
    elif spoil == "slid":
        acc[:, i] += np.linspace(-0.9, 0.9, len(acc))[:, np.newaxis] * [0.0, 1.0, 0.0]
    elif spoil == "short":
        gyr = gyr[:20]
    elif spoil == "units":
        acc[:, i] /= 9.80665
    elif spoil == "lost":
        acc[10:200, i], acc[200:, i] = np.nan, 0.0
    elif spoil == "never bent":
        turn[:, i] *= 0.1
    elif spoil == "lost later":
        turn[:, i] = np.nan
    elif spoil == "circled":
        phase = np.linspace(0, 20, len(turn))
        turn[:, i, :2] += 2.0 * np.stack([np.cos(phase), np.sin(phase)], axis=1)
    else:
        turn[:, i] = turn[:, i, 2:] * [0.5, 0.0, 1.0]
    with pytest.raises(InputErrors, match=found) as caught:
        calibrate_by_poses(gyr, acc, turn, period_s=1 / RATE, names=NAMES)
    assert all(fault.remedy for fault in caught.value.faults)
    assert len(caught.value.faults) == (len(NAMES) if spoil == "short" else 1)


def test_a_finger_that_was_not_flat_is_found_by_its_stated_mounting():
    flat, bent = flat_then_bent("left")
    acc = flat.acc.copy()
    acc[:, 5] = quaternion.rotate(quaternion.about_z(np.radians(50)), acc[:, 5])
    with pytest.raises(InputErrors, match=rf"{NAMES[5]}: upwards is 50 deg from .* lay the whole hand flat"):
        calibrated((flat.gyr, acc), bent, "left", rotations=(1.0, 0.0, 0.0, 0.0))


def test_extending_first_is_found_by_the_stated_mounting():
    # The furthest turn is taken for flexion: extension alone, or the raising of the hand, turns z round.
    flat, bent = flat_then_bent("right")
    nominal = quaternion.from_axis_angle([1.0, 2.0, 3.0], 0.1)
    assert calibrated(flat, bent, "right", rotations=nominal).quality.min() > 0.99
    with pytest.raises(InputErrors, match=r"hand: is 1[78]\d deg from .*raise the hand before") as caught:
        calibrated(flat, bent._replace(gyr=-bent.gyr), "right", rotations=nominal)
    assert len(caught.value.faults) == len(NAMES)


def test_nothing_is_assumed_but_what_is_stated():
    np.testing.assert_array_equal(assumed_mounting((), 2), [[1, 0, 0, 0]] * 2)
    np.testing.assert_array_equal(assumed_mounting((0.0, 0.6, 0.8, 0.0), 2), [[0, 0.6, 0.8, 0]] * 2)
    for wrong in ([[1.0, 0, 0, 0]] * 3, (2.0, 0, 0, 0), (np.nan, 0, 0, 0), (1.0, 0, 0)):
        with pytest.raises(InputError, match="rotations"):
            assumed_mounting(wrong, 2)


def test_misuse_is_named():
    flat, bent = flat_then_bent("left")
    with pytest.raises(InputError, match="side: 'both'"):
        dorsal("both")
    with pytest.raises(InputError, match="verticals"):
        calibrated(flat, bent, "left", verticals=[(0.0, 0.0, 0.0)])
    with pytest.raises(InputError, match="nearly parallel"):
        calibrated(flat, bent, "left", verticals=[(0.0, 0.0, 1.0)])
    with pytest.raises(InputError, match="the same sensors"):
        calibrate_by_poses(flat.gyr, flat.acc, bent.gyr[:, :3], period_s=0.01)
    with pytest.raises(InputError, match=r"flat_gyr: shape \(300, 3\)"):
        calibrate_by_poses(flat.gyr[:, 0], flat.acc, bent.gyr, period_s=0.01)
    with pytest.raises(InputError, match=r"limits\.skew_deg"):
        PoseLimits(skew_deg=0.0)

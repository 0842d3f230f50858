"""The initial pose on arrays: what it finds, and what it refuses, naming sensor and remedy."""

import numpy as np
import pytest
from hand_parts import FIELD
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.arrivals import LOST
from estimators.body.body import body_of
from estimators.calibration.initial_pose import (
    InitialPoseLimits,
    add_samples,
    headings,
    known_angles,
    new_record,
    ties_of,
    turn_headings,
)
from estimators.calibration.pose_evidence import still_readings
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.motion import UPWARDS

BODY = body_of(17, HandSize(side="left"), (), ())
THUMB = {"F1_cmc_abduction": -40.0, "F1_cmc_pronation": 30.0}
ROWS = 300
SEEDS = st.integers(0, 2**32 - 1)


def true_orientation(base, angles_deg=THUMB, body=BODY):
    """Segments' orientations (n, 4) in a pose of a hand at `base`."""
    poses = segment_poses(body.tree, known_angles(body.tree, angles_deg))
    return quaternion.multiply(base, poses.orientation)[body.sensed]


def pose_samples(seed=0, angles_deg=THUMB, body=BODY):
    """Bias (n, 3), gyr, acc, mag (ROWS, n, 3), with sensor noise, of a hand that keeps a pose."""
    rng = np.random.default_rng(seed)
    n = len(body.sensed)
    back = quaternion.conjugate(true_orientation(quaternion.normalized(rng.normal(size=4)), angles_deg, body))
    bias = np.radians(0.6) * rng.normal(size=(n, 3))
    gyr = bias + 5e-4 * rng.normal(size=(ROWS, n, 3))
    acc = quaternion.rotate(back, UPWARDS) + 4e-2 * rng.normal(size=(ROWS, n, 3))
    return bias, gyr, acc, np.tile(quaternion.rotate(back, FIELD), (ROWS, 1, 1))


def readings(gyr, acc, mag=None, angles_deg=THUMB, least=ROWS, **limits):
    return still_readings(BODY, angles_deg, gyr, acc, mag, least=least, limits=InitialPoseLimits(**limits))


@given(SEEDS)
@settings(deadline=None, max_examples=10)
def test_bias_and_mean_readings_are_found(seed):
    bias, gyr, acc, mag = pose_samples(seed)
    rest, _ = readings(gyr, acc, mag)
    # 300 samples know a mean to 1/17 of their noise.
    assert np.abs(rest.bias - bias).max() < 5 * 5e-4 / np.sqrt(ROWS)
    assert np.abs(rest.acc - acc.mean(axis=0)).max() < 1e-12
    assert np.abs(rest.mag - mag[0]).max() < 1e-12
    assert rest.present.all()


@given(SEEDS, st.sampled_from([(), ("hand", "F1m", "F2p", "F2d", "F4m"), ("F1d", "forearm", "F3d", "F3m")]))
@settings(deadline=None, max_examples=30)
def test_relative_headings_become_those_of_the_known_pose(seed, sensed):
    rng = np.random.default_rng(seed)
    body = body_of(len(sensed) or 17, HandSize(), (), sensed)
    n = len(body.sensed)
    true = true_orientation(quaternion.normalized(rng.normal(size=4)), body=body)
    shifted = quaternion.multiply(quaternion.about_z(rng.uniform(-np.pi, np.pi, n)), true)
    ties = ties_of(body, known_angles(body.tree, THUMB), np.ones(n, dtype=np.bool_))
    aligned = quaternion.multiply(quaternion.about_z(headings(ties, shifted)), shifted)
    first = np.flatnonzero(ties.neighbours < 0)
    apart = quaternion.multiply(aligned, quaternion.conjugate(true))
    assert len(first) == 1 or sensed
    for s in range(n):
        top = s
        while ties.neighbours[top] >= 0:
            top = ties.neighbours[top]
        assert quaternion.rotation_angle(quaternion.relative(apart[top], apart[s])) < 1e-6
        np.testing.assert_array_equal(aligned[top], shifted[top])


def test_a_tie_skips_segments_without_a_sensor():
    body = body_of(3, HandSize(), (), ("F2d", "hand", "F2p"))
    every = np.ones(3, dtype=np.bool_)
    angles = known_angles(body.tree, {"F2_pip_flexion": 30.0, "F2_dip_flexion": 20.0, "F2_mcp_flexion": 10.0})
    ties = ties_of(body, angles, every)
    assert ties.neighbours.tolist() == [2, -1, 1]
    assert np.degrees(quaternion.rotation_angle(ties.relative)) == pytest.approx([50.0, 0.0, 10.0])
    without = ties_of(body, angles, np.array([True, True, False]))
    assert without.neighbours[0] == 1
    assert np.degrees(quaternion.rotation_angle(without.relative[0])) == pytest.approx(60.0)


def jerk(gyr, acc):
    gyr[150, 4] = [0.0, 0.0, 1.0]
    return gyr, acc


def shake(gyr, acc):
    gyr[:, 4, 2] += np.radians(20.0) * np.sin(np.arange(ROWS))
    return gyr, acc


def creep(gyr, acc):
    gyr[:, 4, 2] += np.radians(8.0)
    return gyr, acc


def tilt(gyr, acc):
    turn = quaternion.from_axis_angle([1.0, 2.0, 3.0], np.linspace(0.0, np.radians(30.0), ROWS))
    acc[:, 4] = quaternion.rotate(turn, acc[:, 4])
    return gyr, acc


def fall(gyr, acc):
    acc[:, 4] *= 0.9
    return gyr, acc


def bend(gyr, acc):
    across = np.cross(acc[0, 4], [1.0, 2.0, 3.0])
    acc[:, 4] = quaternion.rotate(quaternion.from_axis_angle(across, np.radians(40.0)), acc[:, 4])
    return gyr, acc


def silence(gyr, acc):
    gyr[50:150, 4] = np.nan
    return gyr, acc


@pytest.mark.parametrize(("spoil", "words"), [
    (jerk, r"sensor 4 \(F1d\) .*57 deg/s"), (shake, r"sensor 4 \(F1d\) .*vary by 14 deg/s"),
    (creep, r"sensor 4 \(F1d\) .*on at"), (tilt, r"sensor 4 \(F1d\) .*its inclination changed"),
    (fall, r"sensor 4 \(F1d\) .*calibrate"),
    (bend, r"not in the stated pose: gravity shows a difference of 40 deg at F1_ip \(sensor 4, F1d\)"),
    (silence, r"sensor 4 \(F1d\) .*gave 200 of 300 samples")])
def test_a_bad_pose_is_refused_by_the_sensor_that_tells(spoil, words):
    _, gyr, acc, _ = pose_samples(1)
    readings(gyr, acc)
    with pytest.raises(InputError, match=words) as refused:
        readings(*spoil(gyr, acc))
    assert "keep still in the known pose" in str(refused.value)


def test_limits_are_parameters():
    _, gyr, acc, _ = pose_samples(1)
    jerked = jerk(gyr, acc)
    with pytest.raises(InputError):
        readings(*jerked)
    readings(*jerked, rate_deg_s=60.0)
    gyr, acc = silence(*pose_samples(1)[1:3])
    readings(gyr, acc, share=0.5)


def test_too_short_unequal_and_misshapen_streams_are_refused():
    _, gyr, acc, mag = pose_samples(2)
    with pytest.raises(InputError, match="too short: 300 samples"):
        readings(gyr, acc, least=301)
    with pytest.raises(InputError, match="initial pose: acc"):
        readings(gyr, acc[:-1])
    with pytest.raises(InputError, match="initial pose: mag"):
        readings(gyr, acc, mag[:, :16])
    with pytest.raises(InputError, match="no sensor has given a sample"):
        readings(np.full_like(gyr, np.nan), acc)


def test_a_sensor_that_gave_nothing_is_left_out_and_its_neighbours_held_against_the_next():
    _, gyr, acc, _ = pose_samples(3)
    silent = BODY.tree.index("F2m")
    gyr[:, silent], acc[:, silent] = np.nan, np.nan
    rest, ties = readings(gyr, acc)
    assert np.flatnonzero(~rest.present).tolist() == [silent]
    assert ties.neighbours[BODY.tree.index("F2d")] == BODY.tree.index("F2p")


@pytest.mark.parametrize(("angles_deg", "words"), [
    ({"F2_pip_flexoin": 3.0}, "F2_pip_flexion"), ({"F2_pip_flexion": 130.0}, "-20 to 100 deg"),
    ({"F2_pip_flexion": float("nan")}, "nan")])
def test_poses_that_no_hand_has_are_refused(angles_deg, words):
    with pytest.raises(InputError, match=words):
        known_angles(BODY.tree, angles_deg)


@pytest.mark.parametrize("wrong", [{"share": 1.5}, {"turned_deg": 0.0}, {"gravity": float("inf")}])
def test_impossible_limits_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        InitialPoseLimits(**wrong)


def test_compiled_kernel_equals_plain_python():
    rng = np.random.default_rng(6)
    vectors, codes = rng.normal(size=(3, 4, 3)), np.zeros((3, 4), dtype=np.uint8)
    codes[0, 1] = codes[1, 2] = LOST
    records = []
    for kernel in (add_samples, add_samples.py_func):
        record = new_record(4)
        moving = kernel(*vectors, codes, np.array([True, True, False]), 1, 0.5, record)
        records.append([moving, *(part.sum() for part in record)])
    np.testing.assert_allclose(*records)
    ties = ties_of(BODY, known_angles(BODY.tree, THUMB), np.ones(17, dtype=np.bool_))
    orientation = quaternion.normalized(rng.normal(size=(17, 4)))
    plain = np.zeros(17)
    turn_headings.py_func(ties.neighbours, ties.relative, ties.order, orientation, plain)
    np.testing.assert_allclose(headings(ties, orientation), plain, atol=1e-12)

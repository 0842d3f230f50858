"""Knocks and jolts of the `constrained` tracker on recordings."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker

from estimators.body.joint_constraints import Joint
from estimators.constrained import ConstrainedTracker
from estimators.constrained.measurements import N, measure
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.hand import quaternion
from fesloop.streams.files import open_recording

X, Y, Z = (tuple(row) for row in np.eye(3).tolist())
SADDLES = (Joint(parent=1, child=3, kind="saddle", parent_axis=X, child_axis=Y),
           Joint(parent=2, child=4, kind="saddle", parent_axis=Y, child_axis=Z))
HINGES = ("seg2-seg3", "seg3-seg4", "seg4-seg5")
SPANS = ("seg2-seg4", "seg3-seg5")


def knocked(acc, rng, count=10, size=50.0):
    """Accelerations with `count` knocks of single samples in random directions, m/s^2."""
    acc = acc.copy()
    for _ in range(count):
        direction = rng.normal(size=3)
        acc[rng.integers(len(acc)), rng.integers(acc.shape[1])] += (
            size * direction / np.linalg.norm(direction))
    return acc


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1e6))
@settings(deadline=None, max_examples=100)
def test_an_innovation_pulls_by_little_more_than_its_usual_size(seed, size):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N))
    cov, h, x = root @ root.T / N, np.zeros(N), np.zeros(N)
    h[:3] = rng.normal(size=3)
    sd = math.sqrt(h @ cov @ h + 0.5)
    before, pulled = cov.copy(), np.zeros(N)
    measure(cov, h, size * sd, 0.5, x, pulled, 0, 0)
    assert abs(h @ x) <= 1.345 * (h @ before @ h) / sd + 1e-12
    assert np.linalg.eigvalsh(before - cov).min() > -1e-9
    if size < 1.345:
        assert h @ x == pytest.approx(size * (h @ before @ h) / sd, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
@pytest.mark.parametrize(("joints", "names"), [((), HINGES), (SADDLES, SPANS)])
def test_ten_knocks_change_nothing(sensor_set, joints, names, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)

    def rms_deg(acc):
        out = run_tracker(ConstrainedTracker(sensors=5, joints=joints), recording.gyr, acc, rate=40)[0]
        score = score_recording(recording, recording.stamps_ns, out[0], "relative")
        return np.array([score["orientation_rmse_deg"][name]["total"] for name in names])

    whole = rms_deg(recording.acc)
    for seed in range(3):
        assert (rms_deg(knocked(recording.acc, np.random.default_rng(seed))) < 1.03 * whole).all()


def shaken(acc, rate, rng):
    """Accelerations with six jolts of one sensor or another, which ring for a tenth of a second."""
    acc, times = acc.copy(), np.arange(int(0.5 * rate)) / rate
    for _ in range(6):
        direction = rng.normal(size=3)
        direction *= rng.uniform(20.0, 60.0) / np.linalg.norm(direction)
        ring = np.exp(-times / 0.12) * np.sin(2.0 * np.pi * rng.uniform(5.0, 15.0) * times)
        start = rng.integers(int(3 * rate), len(acc) - len(times))
        acc[start:start + len(times), rng.integers(acc.shape[1])] += ring[:, np.newaxis] * direction
    return acc


@pytest.mark.slow
def test_no_start_and_no_jolt_leaves_a_wrist_wrong_and_sure(recordings):
    """Relative orientations of this set are known up to constant turns on both sides: angles compare."""
    recording = open_recording(recordings / "wrist" / "circle-250.npz")
    true = recording.reference.orientation
    true = quaternion.rotation_angle(quaternion.multiply(quaternion.conjugate(true[:, 0]), true[:, 1]))
    for start in range(0, 2250, 250):
        for acc in (recording.acc, shaken(recording.acc, 125, np.random.default_rng(start))):
            joint = Joint(parent=0, child=1, kind="ball")
            orientation, _, sd, *_ = run_tracker(
                ConstrainedTracker(sensors=2, joints=(joint,)), recording.gyr[start:], acc[start:],
                rate=125)[0]
            found = quaternion.rotation_angle(
                quaternion.multiply(quaternion.conjugate(orientation[:, 0]), orientation[:, 1]))
            off, sure = np.abs(found - true[start:]), sd.max(axis=1) < math.radians(15.0)
            assert np.mean(sure & (off > math.radians(30.0))) <= 0.002

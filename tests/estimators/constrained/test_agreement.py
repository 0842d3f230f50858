"""Whether a joint's filter notices that the joint is none of its kind, or points the wrong way."""

import math

import numpy as np
import pytest
from tracker_parts import run_tracker

from estimators.body.joint_constraints import Joint
from estimators.constrained import ConstrainedTracker
from estimators.constrained.agreement import (
    COLUMNS,
    MOVED,
    TURNED,
    contradicted,
    disagreement,
    note,
    note_axes,
    variances,
)
from estimators.constrained.measurements import N, measure
from fesloop.hand import quaternion
from fesloop.streams.files import open_recording

X, Y, Z = (tuple(row) for row in np.eye(3).tolist())


def learnt(rng, noise, drift=0.0):
    """Sums after 60 measurements of a constant error with sd 1, whose filter assumes noise of sd 1."""
    s, cov, x, gain = np.zeros(COLUMNS), np.eye(N), np.zeros(N), np.zeros(N)
    true = rng.normal(size=N)
    for _ in range(60):
        for i in (0, 1, 2, 6, 7, 8, 9, 10, 11):
            before, x[:] = variances(cov), 0.0
            h = np.zeros(N)
            h[i] = 1.0
            true[i] += drift
            measure(cov, h, true[i] + noise * rng.normal(), 1.0, x, gain, 6, 12)
            true -= x
            note(s, cov, x, before, (0.0, 0.0, 0.0), 0.0)
    return s


def test_the_variance_of_a_sum_of_corrections_is_what_the_covariance_lost():
    """Nine sums of 150 filters each: the sd of their mean square is 7 % and 5 %; large ones count less."""
    sums = np.array([learnt(np.random.default_rng(seed), 1.0) for seed in range(150)])
    for first, count, spread in ((TURNED, 3, 0.07), (MOVED, 6, 0.05)):
        square = np.square(sums[:, first:first + count]).sum(axis=1)
        assert abs(square.mean() / sums[:, first + count].mean() - 1.0) < 3.0 * spread


def test_an_error_that_goes_on_growing_contradicts():
    s = learnt(np.random.default_rng(1), 0.5)
    assert not contradicted(s)
    assert disagreement(s, 0.1) < 1.0
    s = learnt(np.random.default_rng(1), 0.5, drift=0.5)
    assert contradicted(s)
    assert disagreement(s, 0.1) > 1.0


def test_axes_apart_disagree_once_they_have_been_for_seconds():
    s, tissue_sd = np.zeros(COLUMNS), math.radians(4.0)
    for _ in range(400):
        note_axes(s, (3.0 * tissue_sd) ** 2, 0.025)
    assert disagreement(s, tissue_sd) == pytest.approx(3.0 / 1.7 * math.sqrt(1 - math.exp(-2.0)), rel=1e-9)


def reports(recordings, sensor_set, joints):
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    return run_tracker(ConstrainedTracker(sensors=5, joints=joints), recording.gyr, recording.acc, rate=40)[1]


@pytest.mark.slow
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_hinges_about_other_axes_are_misfits_and_the_right_joints_are_not(sensor_set, recordings):
    assert not [each for each in reports(recordings, sensor_set, ()) if each[0] == "misfit"]
    wrong = tuple(Joint(parent=i, child=i + 1, kind="hinge", parent_axis=axis, child_axis=axis)
                  for i, axis in enumerate((X, Y, Z)))
    told = " ".join(each[1] for each in reports(recordings, sensor_set, wrong) if each[0] == "misfit")
    assert all(f"seg{i + 1}-seg{i + 2}" in told or f"{i}-{i + 1}" in told for i in range(3)), told


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [120.0, 180.0])
@pytest.mark.parametrize(("joints", "within"), [
    (tuple(Joint(parent=i, child=i + 1, kind="ball") for i in range(4)), 8.0),
    ((Joint(parent=1, child=3, kind="saddle", parent_axis=X, child_axis=Y),
      Joint(parent=2, child=4, kind="saddle", parent_axis=Y, child_axis=Z)), 5.0)])
def test_a_wrong_heading_is_found_and_corrected(joints, within, degrees, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", "rigid")
    tracker, at, after = ConstrainedTracker(sensors=5, joints=joints), 800, 800 + round(within * 40)
    _, _, state = run_tracker(tracker, recording.gyr, recording.acc, rate=40, last=at)
    half = math.radians(0.5 * degrees)
    for j, joint in enumerate(joints):
        up = recording.acc[at - 20:at + 20, joint.child].mean(axis=0)
        up /= np.linalg.norm(up)
        turned = np.append(math.cos(half), math.sin(half) * up)
        state.found.q[0, j] = quaternion.multiply(state.found.q[0, j], turned)
    orientation = run_tracker(tracker, recording.gyr, recording.acc, rate=40, state=state, first=at)[0][0]
    reference, stamps = recording.reference, recording.stamps_ns
    begin, end = np.searchsorted(reference.stamps_ns, stamps[[after, after + 200]])
    true = reference.orientation[begin:end]
    found = orientation[np.searchsorted(stamps, reference.stamps_ns[begin:end]) - at]
    for joint in joints:
        off = [quaternion.multiply(quaternion.conjugate(each[:, joint.parent]), each[:, joint.child])
               for each in (true, found)]
        error = quaternion.rotation_angle(quaternion.multiply(quaternion.conjugate(off[0]), off[1]))
        assert np.nanmedian(error) < math.radians(12.0)

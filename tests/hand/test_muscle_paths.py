"""Tests of muscle paths: against their own derivatives, published moment arms, and MyoArm itself."""

import hypothesis.extra.numpy as arrays
import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from fesloop.hand.muscle_paths import HALF_RANGE_RAD, JOINTS, MIDDLE_RAD, muscle_paths

PATHS = muscle_paths()
LOWEST, HIGHEST = np.deg2rad([10, -80, -45, -10]), np.deg2rad([130, 80, 45, 25])
WITHIN = arrays.arrays(float, (3, 4), elements=st.floats(0.0, 1.0)).map(
    lambda share: LOWEST + share * (HIGHEST - LOWEST))


@given(WITHIN)
@settings(deadline=None)
def test_moment_arms_are_what_shortens_the_muscle(angles):
    step = 1e-5
    for joint in range(len(JOINTS)):
        ahead, behind = angles.copy(), angles.copy()
        ahead[:, joint] += step
        behind[:, joint] -= step
        slope = -(PATHS.lengths(ahead) - PATHS.lengths(behind)) / (2.0 * step)
        np.testing.assert_allclose(PATHS.moment_arms(angles)[:, :, joint], slope, atol=1e-8)


@pytest.mark.parametrize(("muscle", "joint", "least_mm", "most_mm"), [
    ("BIClong", "elbow_flexion", 30, 50),
    ("BRD", "elbow_flexion", 60, 90),
    ("TRIlong", "elbow_flexion", -28, -15),
    ("PT", "forearm_pronation", 5, 15),
    ("BIClong", "forearm_pronation", -18, -8),
    ("FCR", "wrist_flexion", 12, 21),
    ("FCU", "wrist_flexion", 12, 21),
    ("ECRL", "wrist_flexion", -13, -5),
    ("ECRB", "wrist_flexion", -17, -10),
    ("ECRL", "wrist_radial_deviation", 15, 27),
    ("FCU", "wrist_radial_deviation", -20, -8),
])
def test_moment_arms_have_the_sign_and_size_of_anatomy(muscle, joint, least_mm, most_mm):
    """Elbow flexed by 90 deg: in cadavers BIC 36 to 47, BRD 68 to 87, triceps 17 to 23 mm."""
    arms = PATHS.moment_arms(np.deg2rad([[90.0, 0.0, 0.0, 0.0]]))[0]
    assert least_mm < 1e3 * arms[PATHS.muscles.index(muscle), JOINTS.index(joint)] < most_mm


def test_a_muscle_that_does_not_cross_a_joint_does_not_turn_it():
    away = np.random.default_rng(1).uniform(-0.5, 0.5, (50, 4)) * HALF_RANGE_RAD
    arms = PATHS.moment_arms(MIDDLE_RAD + away)
    wrist = [JOINTS.index("wrist_flexion"), JOINTS.index("wrist_radial_deviation")]
    for name in ("BIClong", "BRA", "TRIlong", "PT"):
        assert np.abs(arms[:, PATHS.muscles.index(name)][:, wrist]).max() < 5e-4


@pytest.mark.filterwarnings("ignore:Attaching a spec")
def test_lengths_and_moment_arms_are_those_of_myoarm():
    mujoco = pytest.importorskip("mujoco")
    myo_sim = pytest.importorskip("myo_sim", reason="the extra myohand is not installed")
    model = myo_sim.load_model("myoarm")
    data = mujoco.MjData(model)
    joints = [model.joint(name) for name in ("elbow_flexion_r", "pro_sup_r", "flexion_r", "deviation_r")]
    rows = [model.actuator(name).id for name in PATHS.muscles]
    angles = np.random.default_rng(2).uniform(LOWEST, HIGHEST, (40, 4))
    for posture in angles:
        mujoco.mj_resetData(model, data)
        data.qpos[model.joint("shoulder_elv_r").qposadr[0]] = np.radians(30.0)
        data.qpos[[joint.qposadr[0] for joint in joints]] = posture
        mujoco.mj_forward(model, data)
        moments = np.zeros((model.nu, model.nv))
        mujoco.mju_sparse2dense(moments, data.actuator_moment, data.moment_rownnz, data.moment_rowadr,
                                data.moment_colind)
        theirs = -moments[rows][:, [joint.dofadr[0] for joint in joints]]
        np.testing.assert_allclose(PATHS.lengths(posture[np.newaxis])[0], data.actuator_length[rows],
                                   atol=3e-3)
        np.testing.assert_allclose(PATHS.moment_arms(posture[np.newaxis])[0], theirs, atol=6e-3)

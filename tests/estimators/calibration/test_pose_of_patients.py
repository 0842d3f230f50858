"""Patients in the assisted pose: those who are held in it are tracked, those who are not are found out."""

from functools import cache

import numpy as np
import pytest
from tracker_parts import run_tracker

from estimators.calibration.pose_evidence import PoseEvidence
from estimators.constrained import ConstrainedTracker
from estimators.salchow import SalchowM2
from fesloop.hand import quaternion
from fesloop.hand.movements import FREEDOMS, MUSCLES
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.assist import Assistance
from plants.patients.files import load

SPLINT = {"wrist_abduction": 0.0, "F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0,
          "F1_cmc_pronation": 100.0}
STRAIGHT = {name: 0.0 for name in FREEDOMS if name not in SPLINT}
THUMB_UP = (0.0, 0.0, 0.0, 1.0)
POSE_S, RELAXED_S = 1.0, 0.9
FINGERS = [FREEDOMS.index(f"F{i}_{joint}_flexion") for i in range(2, 6) for joint in ("mcp", "pip", "dip")]
SPASTIC = "stroke_severe_spastic"
EVERY = [SPASTIC, "sci_c6", "stroke_mild", "able_bodied"]


@cache
def recorded(patient, held):
    """gyr, acc (300, 17, 3) at 100 Hz of a relaxed hand, and its angles, deg, with crookedly mounted sensors.

    It is held straight until 1.1 s, or not at all.
    """
    assist = Assistance(pose_deg=STRAIGHT, until_s=1.1, release_s=0.2) if held else None
    plant = Hand(**load(patient).hand(), settle_s=2.0, forearm_orientation=THUMB_UP, splint_deg=SPLINT,
                 elastic_deg={"wrist_flexion": -20.0}, assist=assist)
    rng = np.random.default_rng(1)
    turn = np.radians(2.0) * rng.normal(size=(17, 3))
    back = quaternion.conjugate(quaternion.from_axis_angle(turn, np.linalg.norm(turn, axis=1)))
    names = [port.name for port in plant.outputs]
    state, relaxed = plant.init(Context("hand")), [np.zeros(len(MUSCLES))]
    gyr, acc, angles = np.empty((300, 17, 3)), np.empty((300, 17, 3)), np.empty((300, len(FREEDOMS)))
    for k in range(300):
        if k:
            plant.advance(state, relaxed, (k - 1) * 10_000_000, k * 10_000_000)
        values = dict(zip(names, plant.read(state, relaxed), strict=True))
        gyr[k], acc[k] = values["site_rate"], values["site_force"]
        angles[k] = np.degrees(values["angles"])
    gyr, acc = quaternion.rotate(back, gyr), quaternion.rotate(back, acc)
    return (gyr + 5e-4 * rng.normal(size=gyr.shape), acc + 0.04 * rng.normal(size=acc.shape)), angles


def tracked(kind, samples, pose_deg):
    """Last angles, deg, `aligned` by tick, and texts of contradictions, of a tracker told that pose."""
    tracker = kind(sensors=17, initial_pose_s=POSE_S, initial_angles_deg=pose_deg,
                   evidence=PoseEvidence(relaxed_s=RELAXED_S))
    outputs, reports, _ = run_tracker(tracker, *samples)
    ports = {port.name: rows for port, rows in zip(tracker.outputs, outputs, strict=True)}
    return (np.degrees(ports["angles"][-1]), ports["aligned"][:, 0],
            [text for status, text in reports if status == "pose_contradicted"])


@pytest.mark.parametrize("kind", [SalchowM2, ConstrainedTracker])
@pytest.mark.parametrize("patient", EVERY)
def test_a_hand_that_is_held_in_the_pose_is_tracked(patient, kind):
    samples, angles = recorded(patient, held=True)
    found, aligned, contradictions = tracked(kind, samples, SPLINT)
    assert not contradictions
    assert aligned[-1] == 1.0
    assert np.sqrt(np.mean((found - angles[-1])[FINGERS]**2)) < 10.0


@pytest.mark.parametrize("kind", [SalchowM2, ConstrainedTracker])
@pytest.mark.parametrize("patient", EVERY)
def test_a_hand_that_nobody_holds_in_the_pose_is_found_out_before_it_is_stimulated(patient, kind):
    samples, _ = recorded(patient, held=False)
    _, aligned, contradictions = tracked(kind, samples, SPLINT)
    assert contradictions
    assert not aligned[round(100 * (POSE_S + RELAXED_S)) + 1:].any()


def test_the_pose_that_a_spastic_hand_rests_in_is_no_contradiction_if_it_is_stated():
    samples, angles = recorded(SPASTIC, held=False)
    goniometer = {name: round(angle / 5.0) * 5.0 for name, angle in zip(FREEDOMS, angles[0], strict=True)}
    found, aligned, contradictions = tracked(SalchowM2, samples, {**goniometer, **SPLINT})
    assert not contradictions
    assert aligned[-1] == 1.0
    assert np.sqrt(np.mean((found - angles[-1])[FINGERS]**2)) < 6.0

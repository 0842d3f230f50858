"""What is told of a cohort that learns to grasp, on made-up patients; failures; held-back stimulation."""

import math
from pathlib import Path

import numpy as np
import pytest

from fesloop.apps.reproduce import grasp_ilc, grasp_trackers
from fesloop.apps.reproduce.patient_session import Session
from fesloop.errors import RunError
from fesloop.experiment.files.parse import load
from fesloop.models.patient_model import load_patient_model, shipped_models


def patient(rmse=2.0, floor=1.0, held=True, worn=True, wrist=1.0, fingers=2.0, aperture=5.0):
    last = {"joint_rmse_deg": [9.0, rmse], "held": [False, held], "object_moved_mm": [140.0, 5.0],
            "aperture_mm": {"opening": [60.0, 90.0]}, "wrist_extension_deg": [17.0, 25.0],
            "grip_margin": [0.0, 1.0], "unwanted_motion_deg": [0.0, 0.1], "charge_uc": [0.0, 6000.0]}
    return {"failed": "", "floor": {"rmse_deg": floor}, "grasp": last,
            "worn": {**last, "held": [False, worn]},
            "reach": {"wrist_extension": [9.0, wrist], "finger_flexion": [9.0, fingers],
                      "thumb_flexion": [1.0, 1.0], "aperture_mm": [20.0, aperture]}}


FAILED = {"failed": "channel 7: nothing moved"}


def holds(patients):
    return {(row.table, row.row): row.holds for row in grasp_ilc.compare(patients).rows}


def test_ten_good_patients_hold_every_row():
    assert all(holds([patient()] * 10).values())


@pytest.mark.parametrize(("bad", "row"), [
    ({"wrist": 6.0}, "wrist_extension, at most"), ({"fingers": 6.0}, "finger_flexion, at most"),
    ({"aperture": 11.0}, "aperture, at most"), ({"rmse": 5.0}, "excess over the floor, at most")])
def test_the_median_decides_and_who_failed_counts_as_infinitely_wrong(bad, row):
    def of(patients):
        return next(value for (_, name), value in holds(patients).items() if name == row)

    assert of([patient(**bad)] * 4 + [patient()] * 6)
    assert not of([patient(**bad)] * 6 + [patient()] * 4)
    assert of([FAILED] * 4 + [patient()] * 6)
    assert not of([FAILED] * 6 + [patient()] * 4)


@pytest.mark.parametrize(("key", "enough"), [("held", 8), ("worn", 7)])
def test_so_many_must_hold_and_who_failed_does_not(key, enough):
    def told(count, others):
        rows = grasp_ilc.compare([patient()] * count + others).rows
        return [row for row in rows if row.row == "patients, at least"][key == "worn"].holds

    assert told(enough, [patient(**{key: False})] * (10 - enough))
    assert not told(enough - 1, [patient(**{key: False})] * (11 - enough))
    assert not told(enough - 1, [FAILED] * (11 - enough))


def test_what_is_not_known_is_not_nothing():
    """A trial that ends before the object could be dropped does not say whether it was held."""
    lost = patient(held=None)
    lost["grasp"]["grip_margin"] = [0.0, math.nan]
    found = grasp_ilc.compare([patient()] * 7 + [lost] * 3)
    row = next(row for row in found.rows if row.row == "patients, at least")
    assert (row.ours, row.holds) == ("7 of 10", False)
    table = found.sweeps["patients"]
    last = dict(zip(table.columns, table.rows[-1][1], strict=True))
    assert math.isnan(last["held"])
    assert math.isnan(last["grip margin"])
    assert last["held, worn"] == 1.0
    unknown = [patient(aperture=math.nan)] * 4 + [patient()] * 6
    assert all(holds(unknown).values())
    assert not all(holds([patient(aperture=math.nan)] * 6 + [patient()] * 4).values())


def test_each_error_is_floor_plus_excess():
    table = grasp_ilc.compare([patient(rmse=6.0, floor=4.5), patient()]).sweeps["patients"]
    first = dict(zip(table.columns, table.rows[0][1], strict=True))
    assert first["excess"] == pytest.approx(first["therapist's reference"] - first["floor"])


def test_a_session_that_fails_is_told_with_its_reason():
    def steps(session, folder):
        assert folder.is_dir()
        raise RunError("tracker lost")

    assert Session((0,), ("patient=sci_c6",), 1, steps).kept() == {"failed": "tracker lost"}


WHOLE_HANDS = [name for name in shipped_models() if len(load_patient_model(Path(name)).current_ma) == 8]


@pytest.mark.parametrize("name", WHOLE_HANDS)
def test_held_back_stimulation_is_admissible_moves_and_is_another_for_every_patient(name):
    model = load_patient_model(Path(name))
    settings = grasp_ilc.held_back(model, 3)
    assert settings == grasp_ilc.held_back(model, 3)
    assert settings != grasp_ilc.held_back(model, 4)
    experiment = load("grasp_ilc", settings)
    programme = next(node.part for node in experiment.nodes if node.name == "controller")
    widths = np.array(programme.width_us)
    assert not widths[0].any()
    assert widths.max() <= 500.0
    assert (widths[1:].max(axis=0) > 0.0).sum() >= 6


def test_trackers_are_compared_by_part_and_a_failed_patient_counts():
    good = {"failed": "", **{tracker: {"total": 1.0, "tracker": 0.2, "controller": 0.9, "held": 1.0}
                             for tracker in grasp_trackers.TRACKERS}}
    found = grasp_trackers.compare([good, good, FAILED])
    rows = dict(found.sweeps["trackers"].rows)
    assert rows["kortier"] == (1.0, 0.2, 0.9, 2.0)
    assert all(row.holds for row in found.rows)
    worse = {**good, "constrained": {**good["constrained"], "total": 2.5}}
    told = {row.row.partition(":")[0]: row.holds for row in grasp_trackers.compare([worse] * 3).rows}
    assert told == {"salchow_m2": True, "constrained": False, "kortier": True}
    lost = grasp_trackers.compare([FAILED] * 2)
    assert math.isinf(dict(lost.sweeps["trackers"].rows)["ideal"][0])
    assert not any(row.holds for row in lost.rows), "nothing is near an error that nobody knows"

"""The curve over a tracker's latency, from sessions made up so that the answers are known."""

import math

import numpy as np
import pytest

from fesloop.apps.reproduce import grasp_mpc
from fesloop.apps.reproduce.figures import draw
from fesloop.experiment.files.parse import load

LATENCIES = (0.0, 40.0, 100.0)


def patient(held=(True, True, True), wrist=(1.0, 1.0, 1.2), failed=""):
    if failed:
        return {"failed": failed}
    return {"failed": "", "runs": [
        {"failed": "", "held": stays, "margin": 2.0, "wrist": error, "fingers": 2.0 * error}
        for stays, error in zip(held, wrist, strict=True)]}


def compared(*patients):
    return grasp_mpc.compare(list(patients), LATENCIES)


def test_who_holds_and_what_latency_costs_is_told():
    found = compared(patient(), patient(), patient(wrist=(1.0, 1.5, 4.0)))
    assert [row.holds for row in found.rows] == [True, True, True]
    assert (found.rows[0].theirs, found.rows[0].ours) == ("3 of 3", "3 of 3")
    assert found.rows[1].ours == "1.20 (0 of 3 failed)"
    assert dict(found.sweeps["wrist"].rows)["median"] == pytest.approx((1.0, 1.0, 1.2))
    assert dict(found.sweeps["held"].rows)["patients"] == (3.0, 3.0, 3.0)


def test_who_cannot_be_identified_counts_as_one_who_failed():
    found = compared(patient(), patient(failed="no channel moves the fingers"))
    assert [row.holds for row in found.rows] == [False, False, False, False]
    assert found.rows[0].ours == "1 of 2"
    assert (found.rows[-1].table, found.rows[-1].ours) == ("member 1", "no channel moves the fingers")
    assert dict(found.sweeps["held"].rows)["member 1"] == (0.0, 0.0, 0.0)
    assert math.isinf(dict(found.sweeps["wrist"].rows)["member 1"][0])


def test_a_run_that_came_to_no_end_is_told_with_its_reason():
    broken = patient()
    broken["runs"][2] |= {"failed": "diverged", "held": False, "wrist": math.inf, "fingers": math.inf}
    rows = compared(broken).rows
    assert (rows[-1].row, rows[-1].ours) == ("run to its end at 100 ms", "diverged")
    assert not any(row.holds for row in rows[1:])


def test_the_point_of_failure_is_where_nothing_is_held_any_more():
    fails = grasp_mpc.point_of_failure
    assert math.isnan(fails(np.array([True, False, True]), LATENCIES))
    assert fails(np.array([True, True, False]), LATENCIES) == 100.0
    assert fails(np.array([False, False, False]), LATENCIES) == 0.0
    assert grasp_mpc.point_of_doubling(np.array([1.0, 1.9, 2.0]), LATENCIES) == 100.0
    assert math.isnan(grasp_mpc.point_of_doubling(np.array([1.0, 1.9, 1.9]), LATENCIES))


def test_figures_are_drawn_of_failures_too(tmp_path):
    drawn = draw(compared(patient(), patient(failed="lost")), tmp_path)
    assert "latency.png" in {path.name for path in drawn}


@pytest.mark.slow
def test_every_latency_of_the_curve_fits_the_horizon():
    for latency in grasp_mpc.LATENCIES_MS:
        experiment = load("grasp_mpc", [f"tracker_latency_ms={latency:g}"])
        (late,) = [wire for wire in experiment.wires if wire.target == "controller.measured"]
        assert late.latency_ms == latency

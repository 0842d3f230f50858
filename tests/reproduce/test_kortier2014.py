import numpy as np
import pytest
from made_up_scores import kortier, run_jobs, spread

from fesloop.apps.reproduce import error_model, kortier2014
from fesloop.apps.reproduce.comparison import share_that_holds
from fesloop.apps.reproduce.error_model import PRIORS, theta_at
from fesloop.apps.reproduce.kortier2014 import FIGURES, PATTERNS, angle_key, replicate, replicates, tip_key
from fesloop.apps.reproduce.scores import figure_rows, pattern_rows
from fesloop.experiment.files.parse import load

SEATS = {"flexion": [0], "circles": [0], "pinch": [1], "rapid": [1], "flat": [2, 3, 4, 5, 6],
         "mould": [2, 3, 4, 5, 6]}
THETA = theta_at("kortier2014", np.full(len(PRIORS["kortier2014"]), 0.6))


def rows(times=1.0, papers=6):
    """Rows of made-up scores, which are their own baseline."""
    found = replicates([{(motion, seat): kortier(motion, times * spread(paper))
                         for motion, seats in SEATS.items() for seat in seats} for paper in range(papers)])
    return [*figure_rows(FIGURES, found, found), *pattern_rows(PATTERNS, found, found)]


@pytest.mark.parametrize("motion", SEATS)
def test_every_run_can_be_loaded(motion):
    jobs = replicate(THETA, range(1, 9), motion)
    assert [job.key for job in jobs] == [(motion, seat) for seat in SEATS[motion]]
    for job in jobs:
        experiment = load(job.experiment, job.settings, job.seed)
        parts = {node.name: node.part for node in experiment.nodes}
        assert parts["hand"].script == f"kortier_{motion}"
        assert parts["hand"].repeat_sd_deg == THETA["repeat_deg"]
        # Both blocks are one device, mounted once.
        assert parts["gyroscopes"].mounting_deg == parts["imus"].mounting_deg
        assert parts["gyroscopes"].gyroscope.bias_sd == THETA["bias_rad_s"]
        assert experiment.duration_ns / 1e9 <= parts["hand"].length_s


def test_one_subject_moves_the_index_finger_in_both_ways():
    jobs = [replicate(THETA, range(1, 9), motion)[0] for motion in ("flexion", "circles", "flat")]
    hands = [next(node.part.hand for node in load(job.experiment, job.settings, job.seed).nodes
                  if node.name == "hand") for job in jobs]
    assert hands[0] == hands[1] != hands[2]


def test_the_papers_own_figures_hold_in_every_row():
    found = rows()
    assert len(found) == 8 + 3 + 4 + 5
    assert share_that_holds(found) == 1.0
    assert {row.table for row in found} == {"Table 2", "Pinch", "Figure 6", "Table 3", "Conclusion"}


@pytest.mark.parametrize("times", [0.8, 1.2])
def test_other_figures_hold_in_no_row(times):
    assert not any(row.holds for row in rows(times) if row.unit)


@pytest.mark.parametrize(("statement", "changed"), [
    ("z the largest", {tip_key("circles", "x"): 9.9}),
    ("circles worse", {tip_key("circles", "distance"): 4.9}),
    ("fingertip below", {tip_key("flexion", "distance"): 13.1}),
    ("mould less", {angle_key("mould", "range"): 1.0}),
    ("a joint's angle", {angle_key("flat", "range"): 2.1}),
])
def test_a_pattern_breaks_where_one_figure_breaks_it(statement, changed):
    own = {key: figure.value for key, figure in FIGURES.items()}
    (pattern,) = [each for each in PATTERNS if each.statement.startswith(statement)]
    papers = {key: np.array([own[key], changed.get(key, own[key])]) for key in own}
    assert pattern.occurs(papers).tolist() == [True, False]


def test_a_whole_reproduction_has_a_row_for_each_figure_of_the_paper(monkeypatch):
    monkeypatch.setattr(error_model, "run_jobs", run_jobs)
    found = kortier2014.run(3, 1)
    assert (found.paper, found.cohort, len(found.rows)) == ("kortier2014", "3 virtual papers", 20)
    assert set(found.curves["traces"]) == {"flexion", "circles", "rapid"}
    sweep = found.sweeps["constraints"]
    assert [name for name, _ in sweep.rows] == list(kortier2014.CONSTRAINTS)
    assert sweep.rows[0][1] == pytest.approx((5.0, 12.4), rel=0.03)

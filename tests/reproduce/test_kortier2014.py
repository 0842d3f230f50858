import numpy as np
import pytest
from made_up_scores import kortier, run_jobs, spread

from fesloop.apps.reproduce import kortier2014
from fesloop.apps.reproduce.comparison import share_that_holds
from fesloop.apps.reproduce.kortier2014 import FIGURES, PATTERNS, angle_key, jobs, subject_values, tip_key
from fesloop.apps.reproduce.scores import figure_rows, papers_of_subjects, pattern_rows
from fesloop.experiment.files.parse import load

MOTIONS = ("flexion", "circles", "pinch", "rapid", "flat", "mould")
EVERY = {" ".join(map(str, job.key)): job for job in jobs(1)}


def rows(times=1.0, subjects=6):
    """Rows of made-up scores, which are their own baseline."""
    kept = {motion: [kortier(motion, times * spread(seed)) for seed in range(subjects)] for motion in MOTIONS}
    papers = papers_of_subjects(subject_values(kept), FIGURES)
    return [*figure_rows(FIGURES, papers, papers), *pattern_rows(PATTERNS, papers, papers)]


@pytest.mark.parametrize("name", EVERY)
def test_every_run_can_be_loaded(name):
    job = EVERY[name]
    experiment = load(job.experiment, job.settings, job.seed)
    hand = next(node.part for node in experiment.nodes if node.name == "hand")
    motion = next(part for part in job.key if part in MOTIONS)
    assert hand.script == f"kortier_{motion}"
    assert experiment.duration_ns == pytest.approx(hand.length_s * 1e9)


def test_movements_are_repeated_as_in_the_paper():
    trials = {job.key[0]: load(job.experiment, job.settings).trials for job in jobs(1)
              if job.key[0] in MOTIONS}
    assert trials == {"flexion": 10, "circles": 10, "pinch": 10, "rapid": 1, "flat": 3, "mould": 3}


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
    monkeypatch.setattr(kortier2014, "run_jobs", run_jobs)
    found = kortier2014.run(3, 1)
    assert (found.paper, found.subjects, len(found.rows)) == ("kortier2014", 3, 20)
    assert set(found.curves["traces"]) == {"flexion", "circles", "rapid"}
    sweep = found.sweeps["constraints"]
    assert [name for name, _ in sweep.rows] == list(kortier2014.CONSTRAINTS)
    assert sweep.rows[0][1] == pytest.approx((5.0, 12.4), rel=0.03)

"""What is made of scores, and that every run that is asked for can be asked for."""

import numpy as np
import pytest
from made_up_scores import run_jobs, salchow, spread

from fesloop.apps.reproduce import salchow2019
from fesloop.apps.reproduce.comparison import share_that_holds
from fesloop.apps.reproduce.salchow2019 import (
    DISTANCES,
    FIGURES,
    MOMENTS,
    PAIRS,
    PATTERNS,
    SOURCES,
    TIPS,
    distance_key,
    furniture,
    jobs,
    moment_of,
    subject_values,
    tip_key,
)
from fesloop.apps.reproduce.scores import figure_rows, papers_of_subjects, pattern_rows
from fesloop.experiment.files.parse import load

EVERY = {(job.key[0], job.key[1]): job for job in jobs(1, 1)}


def made_up(change=lambda motion, scores: None, subjects=6, times=1.0):
    """Scores of every subject; `change` alters those of a movement in place."""
    main = {motion: [salchow(motion, times * spread(seed)) for seed in range(subjects)]
            for motion in (*TIPS, *PAIRS)}
    for motion, every in main.items():
        for scores in every:
            change(motion, scores)
    return main


def rows(main):
    """Rows of made-up scores, which are their own baseline."""
    papers = papers_of_subjects(subject_values(main), FIGURES)
    return [*figure_rows(FIGURES, papers, papers), *pattern_rows(PATTERNS, papers, papers)]


def pattern(found, name):
    return next(row for row in found if row.row.startswith(name))


@pytest.mark.parametrize("key", EVERY, ids=" ".join)
def test_every_run_can_be_loaded(key):
    """Each movement and each of its error sources: the same subject, on the movement's script."""
    job = EVERY[key]
    experiment = load(job.experiment, job.settings, job.seed)
    hand = next(node.part for node in experiment.nodes if node.name == "hand")
    assert hand.script == job.key[1]
    assert experiment.duration_ns == pytest.approx(hand.length_s * 1e9)
    assert experiment.seed == job.seed


def test_jobs_are_told_apart_and_cover_every_movement_source_and_field():
    every = jobs(3, 2)
    keys = [job.key for job in every]
    assert len(set(keys)) == len(keys)
    for name, subjects in [("main", 3), *((f"source {source}", 2) for source in SOURCES),
                           *((f"moment {moment:g}", 2) for moment in MOMENTS)]:
        assert {seed for key, _, seed in keys if key == name} == set(range(1, subjects + 1))
    assert {motion for key, motion, _ in keys if key == "main"} == {*TIPS, *PAIRS}


def test_setting_1_has_no_furniture_and_setting_2_has():
    assert not any("dipoles" in each for each in EVERY["main", "A-F1"].settings)
    experiment = load("salchow2019", EVERY["main", "P1"].settings, 1)
    fields = [node.part.magnetic_field for node in experiment.nodes if hasattr(node.part, "magnetic_field")]
    assert len(fields) == 2
    assert fields[0] == fields[1]
    assert len(fields[0].dipoles) == 3


def test_an_error_source_alone_is_alone():
    parts = {node.name: node.part for node in load(
        "salchow2019", EVERY["source none", "F-F2"].settings, 1).nodes}
    for imus in (parts["imus"], parts["forearm_imu"]):
        assert not any(each.numbers()[[0, 1, 2, 4, 5, 6, 7]].any()
                       for each in (imus.gyroscope, imus.accelerometer, imus.magnetometer))
        assert imus.mounting_angle_deg == (0.0, 0.0)
        assert (imus.soft_tissue.share, imus.soft_tissue.sag_deg) == (0.0, 0.0)
        assert imus.magnetic_field.dipoles == ()
    assert (parts["hand"].deviation.length, parts["hand"].deviation.axis_tilt_deg) == (0.0, (0.0, 0.0))
    mounted = {node.name: node.part for node in load(
        "salchow2019", EVERY["source sensor-to-segment, 5-10 deg", "F-F2"].settings, 1).nodes}
    assert mounted["imus"].mounting_angle_deg == (5.0, 10.0)
    assert mounted["imus"].gyroscope.noise_sd == 0.0


def test_furniture_is_a_subjects_own_and_lies_where_it_is_said_to():
    moments = [moment_of(seed) for seed in range(1, 301)]
    assert min(moments) >= 0.3
    assert max(moments) <= 10.0
    # Uniform in the logarithm: half of them below the geometric mean.
    assert np.mean(np.array(moments) < np.sqrt(3.0)) == pytest.approx(0.5, abs=0.09)
    assert furniture(1, 2.0) == furniture(1, 2.0) != furniture(2, 2.0)
    for seed in range(1, 6):
        settings = ["motion=P1", *furniture(seed, 2.0)]
        part = next(node.part for node in load("salchow2019", settings, 1).nodes if node.name == "imus")
        for dipole in part.magnetic_field.dipoles:
            assert 0.15 <= np.linalg.norm(dipole.position) <= 0.5
            assert dipole.position[2] <= 0.0
            assert np.linalg.norm(dipole.moment) == pytest.approx(2.0)


def test_the_papers_own_figures_hold_in_every_row():
    found = rows(made_up())
    assert len(found) == 8 * 3 + 6 * 3 + 8
    assert share_that_holds(found) == 1.0


def test_figures_twice_as_large_hold_in_no_row_with_a_band():
    found = rows(made_up(times=2.0))
    assert not any(row.holds for row in found if row.unit)
    # Ratios are the same, limits are broken.
    assert [row.table for row in found if not row.unit and not row.holds] == ["Section 5"]


@pytest.mark.parametrize(("name", "motion", "change"), [
    ("B worst", "F-F2", lambda scores: scores["B"].update(rmse=0.5)),
    ("M2 best", "P2", lambda scores: scores["B"]["F2-F3"].update(rmse=1.0)),
    ("thumb worst in A and in AF, M1", "AF-F1", lambda scores: scores["M1"].update(rmse=1.2)),
    ("thumb worst in A and in AF, M2", "A-F3", lambda scores: scores["M2"].update(rmse=1.9)),
    ("M2 at most", "P3", lambda scores: scores["M2"]["F1-F2"].update(rmse=2.2)),
    ("M2 at most", "P2", lambda scores: scores["M2"]["F2-F3"].update(rmse=1.5)),
    ("M2 at most", "F-F2", lambda scores: scores["M2"].update(rmse=1.5)),
])
def test_a_pattern_that_breaks_in_one_row_does_not_hold(name, motion, change):
    def spoil(this, scores):
        if this == motion:
            change(scores)

    assert pattern(rows(made_up()), name).holds
    broken = pattern(rows(made_up(spoil)), name)
    assert not broken.holds
    assert broken.ours == "in 0 %"


@pytest.mark.parametrize("times", [0.6, 0.9, 1.5])
def test_m1_is_about_m2_or_not(times):
    def spoil(motion, scores):
        if motion in TIPS:
            scores["M1"]["rmse"] = times * scores["M2"]["rmse"]

    row = pattern(rows(made_up(spoil)), "M1 about M2")
    assert (row.theirs, row.holds) == ("1.11", 0.8 < times < 1.25)


@pytest.mark.parametrize(("better", "holds"), [(1, True), (2, False)])
def test_m1_is_worse_than_b_in_five_rows_or_not(better, holds):
    """In the paper it is in all but P2; here in `better` rows of six it is not."""
    left = [key for key in DISTANCES if key != ("P2", "F2-F3")][:better - 1]

    def spoil(motion, scores):
        for name, pair in left:
            if name == motion:
                scores["M1"][pair]["rmse"] = 0.01

    row = pattern(rows(made_up(spoil)), "M1 worse than B")
    assert row.holds == holds


def test_table_7_is_of_means_of_four_subjects():
    def widen(motion, scores):
        if motion == "P1":
            scores["B"]["F1-F2"]["rmse"] = next(values)

    values = iter(np.linspace(0.1, 4.6, 50))
    row = next(row for row in rows(made_up(widen, 50)) if row.row.startswith("P1 F1-F2, B"))
    assert row.holds
    # Of single subjects it would be as wide as the values, of means of four it is half that.
    assert row.ours.high - row.ours.low == pytest.approx(0.5 * 0.9 * 4.5, rel=0.15)


def test_the_sweeps_tell_tips_from_distances(monkeypatch):
    monkeypatch.setattr(salchow2019, "run_jobs", run_jobs)
    found = salchow2019.run(2, 1)
    sources = found.sweeps["sources"]
    assert [name for name, _ in sources.rows] == list(SOURCES)
    assert [name for name, _ in found.sweeps["field"].rows] == [f"{moment:g} A m2" for moment in MOMENTS]
    of_b = np.mean([FIGURES[tip_key(motion, "B")].value for motion in ("F-F2", "AF-F1", "AF-F3")])
    of_m2 = np.mean([FIGURES[distance_key(*each, "M2")].value for each in DISTANCES if each[0] != "P2"])
    values = dict(zip(sources.columns, sources.rows[0][1], strict=True))
    assert values["tips, B"] == pytest.approx(of_b)
    assert values["distances, M2"] == pytest.approx(of_m2)

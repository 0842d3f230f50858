"""Tests of `fesloop reproduce people`: who predicts whom, and that scores are those of plain formulas."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from fesloop.analysis.people.courses import StepResponse, fits_of
from fesloop.analysis.people.population import ArmPopulation
from fesloop.apps.reproduce import people
from fesloop.apps.reproduce.figures import draw
from fesloop.apps.reproduce.people import bench, evoked
from fesloop.apps.reproduce.result import Reproduction
from fesloop.errors import InputError
from fesloop.models.arm_responses import ArmResponses, effective_a
from fesloop.streams.stimulation import open_stimulation


def test_needs_recordings(monkeypatch, tmp_path):
    monkeypatch.delenv("FESLOOP_RECORDINGS", raising=False)
    with pytest.raises(InputError, match="FESLOOP_RECORDINGS: no recordings"):
        people.run()
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path))
    with pytest.raises(InputError, match="a folder that holds fes_exo"):
        people.run()


def test_other_peoples_density_is_students():
    others = [np.array([1.0, 0.0]), np.array([2.0, 0.0]), np.array([3.0, 3.0])]
    found = evoked._others_log_density(np.array([2.0, 1.0]), others)
    # Density of t with 2 degrees of freedom at 0: 1 / (2 sqrt 2), over the scale sqrt(4 / 3).
    assert found[0] == pytest.approx(np.log(1.0 / (2.0 * np.sqrt(2.0)) / np.sqrt(4.0 / 3.0)))
    assert np.isnan(evoked._others_log_density(np.zeros(2), others[:2])).all()


@pytest.mark.slow
def test_nobody_predicts_themselves(recordings, monkeypatch):
    found = evoked.recordings(recordings / "fes_exo")
    shipped = ArmPopulation.shipped()
    assert {each.person for each in found} == set(shipped.people)
    asked = []
    monkeypatch.setattr(ArmPopulation, "of", lambda trials: asked.append([each.person for each in trials]))
    evoked.populations(found)
    assert [set(shipped.people) - set(others) for others in asked] == [{each.person} for each in found]


@pytest.mark.slow
def test_people_are_predicted_better_than_by_lines_and_by_other_peoples_mean(recordings):
    rows, sweeps, _ = evoked.rows_and_sweeps(recordings / "fes_exo", 400)
    by_name = {(row.table, row.row): row for row in rows}
    assert all(row.holds for key, row in by_name.items() if "stretch" not in key[1])
    assert len(sweeps["postures"].rows) == 5


def answers(*delays_and_joints):
    return [StepResponse(joint, False, 1e-3 * delay, *(np.nan,) * 4) for delay, joint in delays_and_joints]


def test_joints_count_as_often_as_in_the_recordings():
    """Three of four recorded responses are of joint 3: the median is among ours of joint 3."""
    theirs = answers((130, 3), (140, 3), (150, 3), (100, 0))
    ours = answers(*[(200 + k, 0) for k in range(50)], (140, 3), (142, 3), (144, 3))
    row = bench.dynamic_rows(theirs, ours)[0]
    assert row.holds
    assert 141 <= float(row.ours.split()[0]) <= 144
    assert not bench.dynamic_rows(theirs, answers((200, 0), (190, 3)))[0].holds
    # without a bar, our median has to lie between their quartiles
    rows = {row.row: row.holds for row in bench.dynamic_rows(theirs, answers((140, 3), (100, 0)))}
    assert rows["5 % of torque, wrist_radial_deviation"]
    rows = {row.row: row.holds for row in bench.dynamic_rows(theirs, answers((151, 3), (100, 0)))}
    assert not rows["5 % of torque, wrist_radial_deviation"]
    assert not bench.dynamic_rows(theirs, [])[0].holds


def test_a_random_persons_widths_are_the_usable_ones():
    response = ArmResponses.shipped().drawn(("biceps",), np.random.default_rng(4))
    times, widths = bench.protocol(response, 0.065, np.random.default_rng(1))
    effective = 1e3 * effective_a(0.065, np.array([widths.min(), widths.max()]), response.chronaxie_s[0])
    shares = norm.cdf(np.log(effective / response.threshold_ma) / response.spread)
    assert shares == pytest.approx([response.lowest[0], response.highest[0]])
    assert times[0] == 0.0
    assert 1.0 <= times[2] <= 1.05


def test_recruitment_is_drawn_for_courses_that_are_explained(recordings, tmp_path):
    people = [open_stimulation(recordings / "fes_exo" / f"{name}.npz")
              for name in ("S9002", "S9003", "S9007")]
    curves = bench.recruitment_curves(people, 50)
    assert {name: [fit["person"] for fit in each["fits"]] for name, each in curves.items()} == {
        "biceps": ["S9007"], "triceps": ["S9002"], "palmaris longus": ["S9007"]}
    for each in curves.values():
        assert (np.diff(each["band"], axis=0) >= 0.0).all()
        assert (np.diff(each["band"], axis=1) >= 0.0).all()
        for fit in each["fits"]:
            at, theirs, ours = (fit["ramps"][name] for name in ("at_ma", "theirs_nm", "ours_nm"))
            assert each["at_ma"][0] < at.min() < at.max() < each["at_ma"][-1]
            # widths rise for 2 s of the 4: the highest current is in the middle of the recorded ramps
            assert at.argmax() * 0.01 == pytest.approx(2.0, abs=0.6)
            assert abs(theirs.argmax() - at.argmax()) * 0.01 < 1.0
            assert np.corrcoef(theirs, ours)[0, 1] > 0.7
    written = draw(Reproduction("people", 1, [], curves={"recruitment": curves}), tmp_path)
    assert [path.name for path in written] == ["recruitment.png"]


def test_a_course_without_ramps_has_none(recordings):
    person = open_stimulation(recordings / "fes_exo" / "S9002.npz")
    course = person.courses[1]
    short = replace(course, **{name: getattr(course, name)[:round(14.8 / course.period_s)] for name in (
        "pulse_width_s", "angle_rad", "device_torque_nm")})
    (fit,) = fits_of(replace(person, courses=(short,)))
    assert all(np.isnan(each).all() for each in bench.ramps(fit, short).values())


def test_intervals_narrow_with_the_postures_that_are_known(recordings, tmp_path):
    person = open_stimulation(recordings / "fes_exo" / "S9004.npz")
    found = evoked.learned(person, ArmPopulation.shipped(), 400)
    assert list(found["intervals_nm"]) == [0, 4, 24]
    low, _, high = np.moveaxis(np.array(list(found["intervals_nm"].values())), 1, 0)
    assert (np.diff(high - low, axis=0) < 0.0).all()
    inside = (low <= found["theirs_nm"]) & (found["theirs_nm"] <= high)
    assert inside.shape == (3, 8, 4)
    assert inside.mean(axis=(1, 2)).min() > 0.8
    written = draw(Reproduction("people", 1, [], curves={"learned": found}), tmp_path)
    assert [path.name for path in written] == ["learned.png"]


@pytest.mark.slow
def test_random_people_recruit_as_the_recorded_do(recordings):
    folder = recordings / "fes_exo"
    people = [open_stimulation(folder / f"{name}.npz") for name in ("S9006", "S9007")]
    rows = {row.row: row for row in bench.recruitment_rows(people, 400)}
    assert len(rows) == 6
    assert all(row.holds for row in rows.values())


@pytest.mark.slow
def test_simulated_courses_answer_like_recorded_ones(recordings, monkeypatch):
    """One random person for each course of one recorded: the chain of simulation, noise and reduction."""
    monkeypatch.setattr(bench, "PEOPLE_A_COURSE", 2)
    person = open_stimulation(recordings / "fes_exo" / "S9004.npz")
    courses = list(bench.simulated([person], {}))
    assert len(courses) == 2 * len(person.courses)
    found = [each for course in courses for each in bench.step_responses(course)]
    assert found
    assert all(0.05 < each.delay_s < 0.4 for each in found)
    noise = bench.noise(person.courses[0], 1000, np.random.default_rng(1))
    assert np.abs(noise[:190].mean(axis=0)).max() < 1e-12 + np.abs(noise).max()
    assert np.array_equal(noise[:800], noise[190:990])

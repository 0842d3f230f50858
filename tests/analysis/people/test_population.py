"""Tests of populations and people: against brute force, people whose truth is known, and recordings."""

import json
from dataclasses import replace

import hypothesis.extra.numpy as arrays
import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from scipy.stats import multivariate_normal

from fesloop.analysis.people.identify import identify_person, load_person
from fesloop.analysis.people.population import ArmPopulation, trials_of
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.evoked_torque import (
    UNDER_ELECTRODES,
    Postures,
    Spreads,
    Weights,
    common_shares,
    features,
    log_density,
    muscle_torques,
)
from fesloop.streams.stimulation import SteadyTrials, StimulationRecording, open_stimulation
from fesloop.streams.stimulation.stored import write_stimulation

SPREADS = Spreads(muscles=1.5, constants=(0.2, 0.3, 0.5, 0.4), slopes=(0.3, 0.3, 0.1, 0.2),
                  curvatures=(0.5, 0.2, 0.2, 0.3), common_muscles=0.8, common_constants=0.3,
                  common_slopes=0.4, coupling=0.1)
SCALE_NM = np.array([0.25, 0.04, 0.07, 0.08])
GRID_DEG = np.array([[e, f, w, r] for e in (-60, -30, -5) for f in (-40, 40) for w in (-10, 10)
                     for r in (-10, 10)], float)
ZERO_RAD = np.deg2rad([90.0, 0.0, 0.0, 0.0])
NUMBERS = st.floats(-3.0, 3.0)


def recording(torque_nm, noise_nm, rng, *, person="one", repeats=3, postures=range(24), joints=range(4)):
    """A recording of `torque_nm` {electrode: (24, 4)} with noise."""
    rows, joints = [], list(joints)
    for repeat in range(repeats):
        for posture in postures:
            for number, torque in enumerate(torque_nm.values()):
                rows.append((number, posture, repeat, torque[posture] + noise_nm * rng.normal(size=4)))
    count = len(rows)
    angles = np.deg2rad(GRID_DEG[[row[1] for row in rows]])[:, joints]
    missing = np.full((count, len(joints)), np.nan)
    steady = SteadyTrials(
        muscle=np.array([row[0] for row in rows]), posture=np.array([f"{row[1]:02}" for row in rows]),
        visit=np.array([row[2] * 24 + row[1] for row in rows]), order=np.zeros(count, int),
        repeat=np.array([row[2] for row in rows]), time_s=np.arange(float(count)), reference_rad=angles,
        angle_rad=angles.copy(), pulse_width_s=np.full(count, 2e-4), current_a=np.full(count, 0.02),
        device_torque_nm=-np.array([row[3] for row in rows])[:, joints], device_torque_sd_nm=missing,
        creep_nm=missing.copy(), stiffness_nm_rad=missing.copy(), baseline="none")
    unknown = np.full(len(torque_nm), np.nan)
    return StimulationRecording(
        person=person, muscles=tuple(torque_nm), joints=tuple(JOINTS[j] for j in joints),
        zero_rad=ZERO_RAD[joints], friction_nm=np.full(len(joints), np.nan), frequency_hz=40.0,
        lowest_width_s=unknown, highest_width_s=unknown.copy(), width_current_a=unknown.copy(),
        source=f"{person}.csv", source_format="csv", steady=steady)


def people(number, rng, scale_sd=0.5):
    """People of a population with `SPREADS`: {electrode: (24, 4)} and the scale of each."""
    common = {name: rng.normal(size=len(common_shares(name, SPREADS))) for name in UNDER_ELECTRODES}
    found = []
    for _ in range(number):
        scale = SCALE_NM * np.exp(scale_sd * rng.normal())
        torque = {}
        for name in UNDER_ELECTRODES:
            shares = common_shares(name, SPREADS)
            weights = np.sqrt(shares) * common[name] + np.sqrt(1 - shares) * rng.normal(size=len(shares))
            at = Postures.of(name, ZERO_RAD + np.deg2rad(GRID_DEG))
            torque[name] = features(at, scale, SPREADS) @ weights
        found.append((torque, scale))
    return found


@pytest.fixture(scope="module")
def world():
    """Six people as recorded, their population, and what is true of them."""
    rng = np.random.default_rng(3)
    truth = people(7, rng)
    recordings = [recording(torque, scale, rng, person=f"p{i}") for i, (torque, scale) in enumerate(truth)]
    return truth, recordings, ArmPopulation.of([trials_of(each) for each in recordings[:6]])


@given(arrays.arrays(float, (5, 3), elements=NUMBERS), arrays.arrays(float, (5,), elements=NUMBERS),
       arrays.arrays(float, (3, 3), elements=NUMBERS), arrays.arrays(float, (3,), elements=NUMBERS))
@settings(deadline=None)
def test_posterior_is_that_of_normal_equations(rows, seen, root, mean):
    prior = Weights(mean, root @ root.T + 0.1 * np.eye(3))
    variance = np.linspace(0.5, 1.0, 5)
    precision = np.linalg.inv(prior.covariance) + rows.T @ (rows / variance[:, np.newaxis])
    information = np.linalg.solve(prior.covariance, mean) + rows.T @ (seen / variance)
    expected = np.linalg.solve(precision, information)
    found = prior.given(rows, seen, variance)
    np.testing.assert_allclose(found.mean, expected, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(precision), rtol=1e-6, atol=1e-6)
    assert log_density(rows, seen, prior, variance) == pytest.approx(multivariate_normal(
        rows @ mean, rows @ prior.covariance @ rows.T + np.diag(variance)).logpdf(seen), rel=1e-6, abs=1e-6)


def test_a_device_feels_the_elbows_torque_about_the_horizontal_axis_of_the_wrist():
    """Biceps lifts the hand: it deviates a neutral one radially, and extends a pronated one."""
    neutral, pronated = np.deg2rad([[90.0, 0.0, 0.0, 0.0], [90.0, 80.0, 0.0, 0.0]])
    felt = muscle_torques(Postures.of("biceps", np.array([neutral, pronated])), 0.1)[:, 0]
    assert felt[0, 3] == pytest.approx(0.1 * felt[0, 0], rel=0.03)
    assert abs(felt[0, 2]) < 1e-2 * felt[0, 0]
    assert felt[1, 2] == pytest.approx(-0.1 * np.sin(np.deg2rad(80.0)) * felt[1, 0], rel=0.03)


def test_people_in_a_device_show_it(recordings):
    """Wrist torque of biceps and triceps, which do not cross the wrist, follows the elbow's in all five."""
    for path in sorted((recordings / "fes_exo").glob("S900[2-9].npz")):
        cells = trials_of(open_stimulation(path)).cells
        for joint, share in ((2, lambda turn: -np.sin(turn)), (3, np.cos)):
            lifted, seen = (np.concatenate(each) for each in zip(*(
                (share(cells[name].postures.angles[:, 1]) * cells[name].torque_nm[:, 0],
                 cells[name].torque_nm[:, joint]) for name in ("biceps", "triceps")), strict=True))
            assert 0.02 < lifted @ seen / (lifted @ lifted) < 0.25, (path.stem, joint)


def test_spreads_of_people_are_found(world):
    _, _, population = world
    found = population.spreads
    assert found.muscles == pytest.approx(SPREADS.muscles, rel=0.4)
    np.testing.assert_allclose(found.constants, SPREADS.constants, rtol=0.5)
    np.testing.assert_allclose(found.slopes, SPREADS.slopes, rtol=0.4)
    np.testing.assert_allclose(found.curvatures, SPREADS.curvatures, rtol=0.5)
    assert found.common_slopes == pytest.approx(SPREADS.common_slopes, abs=0.2)
    assert found.coupling == pytest.approx(SPREADS.coupling, rel=0.4)


@pytest.mark.parametrize("postures", [range(0, 24, 3), [5]])
def test_intervals_of_a_person_hold_the_truth(world, postures):
    truth, _, population = world
    torque, scale = truth[6]
    rng = np.random.default_rng(8)
    me = population.person(trials_of(recording(torque, scale, rng, postures=postures)))
    off = []
    for name in UNDER_ELECTRODES:
        mean, sd = me.torque(name, ZERO_RAD + np.deg2rad(GRID_DEG))
        off.append(((torque[name] - mean) / sd).ravel())
        drawn = me.draws(name, ZERO_RAD + np.deg2rad(GRID_DEG), 4000, rng)
        np.testing.assert_allclose(drawn.std(axis=0), sd, rtol=0.1)
    assert 0.8 < np.mean(np.abs(np.concatenate(off)) < 1.645) < 0.98


def test_more_postures_narrow_the_interval_and_none_leaves_the_population(world):
    truth, _, population = world
    torque, scale = truth[6]
    at, widths = ZERO_RAD + np.deg2rad(GRID_DEG), []
    for postures in ([5], [5, 12], range(0, 24, 3), range(24)):
        trials = trials_of(recording(torque, scale, np.random.default_rng(1), postures=postures, repeats=2))
        me = population.person(trials._replace(scale_nm=scale))
        widths.append(np.mean([me.torque(name, at)[1].mean() for name in UNDER_ELECTRODES]))
    assert (np.diff(widths) < 0.0).all()
    only = {"biceps": torque["biceps"]}
    me = population.person(trials_of(recording(only, scale, np.random.default_rng(1))))
    np.testing.assert_array_equal(me.weights["triceps"].mean, population.newcomer("triceps").mean)
    assert me.tried == ("biceps",)


def test_the_scale_of_a_person_without_repeats_is_that_of_the_population(world):
    truth, _, population = world
    once = trials_of(recording(*truth[6], np.random.default_rng(1), repeats=1))
    assert np.isnan(once.scale_nm).all()
    np.testing.assert_allclose(population.person(once).scale_nm, np.exp(population.scale_log_mean))


def test_a_recording_of_the_wrist_alone_will_do(world):
    truth, _, population = world
    torque, scale = truth[6]
    flexor = {"flexor carpi radialis": torque["flexor carpi radialis"]}
    wrist = recording(flexor, scale, np.random.default_rng(1), joints=(2, 3))
    me = population.person(trials_of(wrist))
    at = ZERO_RAD + np.deg2rad(GRID_DEG)
    own, unseen = me.torque("flexor carpi radialis", at)[1], population.person(
        trials_of(recording({"biceps": torque["biceps"]}, scale, np.random.default_rng(1)))).torque(
            "flexor carpi radialis", at)[1]
    assert (own[:, 2:] < unseen[:, 2:]).all()


def test_a_population_is_read_as_it_was_written(world):
    _, _, population = world
    again = ArmPopulation.from_document(json.loads(json.dumps(population.as_document())))
    assert again.people == population.people
    for name, weights in population.common.items():
        np.testing.assert_allclose(again.common[name].mean, weights.mean, rtol=1e-5)
        np.testing.assert_allclose(again.common[name].covariance, weights.covariance, rtol=1e-4, atol=1e-6)
    assert again.spreads.coupling == pytest.approx(population.spreads.coupling, rel=1e-5)


def test_identifies_a_person_from_a_file(world, tmp_path, monkeypatch, capsys):
    truth, _, _ = world
    torque, scale = truth[6]
    seen = {name: torque[name] for name in ("biceps", "flexor carpi radialis")}
    write_stimulation(recording(seen, scale, np.random.default_rng(1), person="she", postures=[5, 6]),
                      tmp_path / "she.h5")
    monkeypatch.chdir(tmp_path)
    assert main(["identify", "--stimulation", "she.h5", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert told["person"] == "she"
    assert {row["electrode"] for row in told["electrodes"] if row["recorded"]} == set(seen)
    assert "she.h5: few postures of biceps (2), flexor carpi radialis (2)" in err
    assert "triceps was not stimulated: the interval is the population's" in err
    assert {row["pulses"] for row in told["electrodes"] if row["recorded"]} == {"20 mA, 200 us"}
    assert {row["pulses"] for row in told["electrodes"] if not row["recorded"]} == {""}
    person = load_person("she_person.json")
    at = ZERO_RAD + np.deg2rad(GRID_DEG)
    expected = identify_person("she.h5").person
    for name in person.weights:
        for ours, theirs in zip(person.torque(name, at), expected.torque(name, at), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-5)
    assert main(["identify", "--stimulation", "she.h5"]) == 2
    assert "--out she_person.json: exists already" in capsys.readouterr().err


def test_other_pulse_widths_are_no_repeats_of_a_person(world, tmp_path):
    """Torque in proportion to width: the scatter of a repeat is the population's, and the output says so."""
    torque, scale = world[0][6]
    once = recording(torque, scale, np.random.default_rng(1), repeats=2, postures=range(8))
    steady = once.steady
    wide = np.where(steady.repeat == 1, 1.5, 1.0)
    write_stimulation(replace(once, steady=replace(
        steady, pulse_width_s=wide * steady.pulse_width_s,
        device_torque_nm=wide[:, np.newaxis] * steady.device_torque_nm)), tmp_path / "wide.h5")
    found = identify_person(tmp_path / "wide.h5")
    np.testing.assert_allclose(np.log(found.person.scale_nm), ArmPopulation.shipped().scale_log_mean)
    assert any("biceps, " in each and "by pulses that differ between trials" in each for each in found.doubts)
    assert any("no posture was repeated by the same pulses" in each for each in found.doubts)


@pytest.mark.parametrize("times", [0.4, 1.0, 4.0])
def test_a_person_whose_torque_is_unusual_for_its_scatter_is_believed(world, times):
    """Spreads of people are in units of a repeat's scatter, which does not grow here."""
    truth, _, population = world
    torque, scale = truth[6]
    louder = {name: times * values for name, values in torque.items()}
    me = population.person(trials_of(recording(louder, scale, np.random.default_rng(1),
                                               postures=range(0, 24, 3))))
    off = []
    for name in UNDER_ELECTRODES:
        mean, sd = me.torque(name, ZERO_RAD + np.deg2rad(GRID_DEG))
        off.append(((louder[name] - mean) / sd).ravel())
    assert 0.8 < np.mean(np.abs(np.concatenate(off)) < 1.645) < 0.98


def test_the_gain_that_other_electrodes_follow_is_reported(world, tmp_path):
    torque, scale = world[0][6]
    found = []
    for times in (1.0, 4.0):
        seen = {"biceps": times * torque["biceps"]}
        write_stimulation(recording(seen, scale, np.random.default_rng(1)), tmp_path / f"{times}.h5")
        found.append(identify_person(tmp_path / f"{times}.h5"))
    at = ZERO_RAD + np.deg2rad(GRID_DEG)
    weaker, stronger = (np.abs(each.person.torque("triceps", at)[0][:, 0]).mean() for each in found)
    assert stronger > 1.5 * weaker
    assert found[1].gain / found[0].gain == pytest.approx(stronger / weaker, rel=0.1)


def test_a_recording_with_the_other_sign_is_named(world, tmp_path, recordings):
    person = open_stimulation(recordings / "fes_exo" / "S9007.npz")
    write_stimulation(person, tmp_path / "right.h5")
    write_stimulation(replace(person, steady=replace(
        person.steady, device_torque_nm=-person.steady.device_torque_nm)), tmp_path / "wrong.h5")
    assert not any("sign" in each for each in identify_person(tmp_path / "right.h5").doubts)
    assert any("biceps: elbow_flexion of -" in each for each in identify_person(tmp_path / "wrong.h5").doubts)


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"format": "fesloop person 1"}', "\x00"])
def test_refuses_what_is_no_persons_file(tmp_path, content):
    (tmp_path / "no.json").write_text(content)
    with pytest.raises(InputError, match=r"no\.json: is not a person's file"):
        load_person(tmp_path / "no.json")
    with pytest.raises(InputError, match="cannot be read"):
        load_person(tmp_path / "absent.json")


def test_names_what_it_cannot_be_made_of(world):
    _, recordings, population = world
    good = recordings[0]
    with pytest.raises(InputError, match="two or more"):
        ArmPopulation.of([trials_of(good)])
    with pytest.raises(InputError, match="has no steady trials"):
        trials_of(replace(good, steady=None))
    with pytest.raises(InputError, match=r"joints: 'knee_flexion'; allowed: of elbow_flexion"):
        trials_of(replace(good, joints=("knee_flexion", *good.joints[1:])))
    with pytest.raises(InputError, match=r"'soleus'; allowed: one of biceps.*name an electrode after"):
        trials_of(replace(good, muscles=("soleus", *good.muscles[1:])))
    with pytest.raises(InputError, match="no trial of a muscle in 99"):
        trials_of(good, ["99"])
    wrist = trials_of(recording({"biceps": np.zeros((24, 4))}, SCALE_NM, np.random.default_rng(1),
                                joints=(2, 3)))
    with pytest.raises(InputError, match="lacks joints or repeated trials"):
        ArmPopulation.of([wrist, wrist])
    assert population.people == ("p0", "p1", "p2", "p3", "p4", "p5")


def test_people_and_postures_that_were_not_seen(recordings):
    """Bars are those of plain means, lines and Gaussian processes of the same eight postures."""
    paths = sorted((recordings / "fes_exo").glob("S900[2-9].npz"))
    found = [open_stimulation(path) for path in paths]
    trials = [trials_of(each) for each in found]
    left_out = found[2]
    postures = sorted(set(left_out.steady.posture[left_out.steady.stimulated].tolist()))
    population = ArmPopulation.of([each for each in trials if each.person != left_out.person])
    me = population.person(trials_of(left_out, postures[::3]))
    rest = trials_of(left_out, [name for i, name in enumerate(postures) if i % 3])
    off = np.concatenate([me.torque(name, cells.postures.angles)[0] - cells.torque_nm
                          for name, cells in rest.cells.items()])
    ratio = np.sqrt((off**2).mean(axis=0)) / trials_of(left_out).scale_nm
    assert (ratio < [0.86, 0.82, 0.95, 0.97]).all()

"""Tests of a person's virtual patient: posterior against closed forms, simulated people of known strength."""

import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from stimulation_parts import wrist_recording

from fesloop.analysis.people import own_patient
from fesloop.analysis.people.own_patient import courses_posterior, posterior
from fesloop.analysis.people.pads import Forearm, HeldWrist, Pads
from fesloop.analysis.people.population import ArmPopulation, trials_of
from fesloop.analysis.people.scatter import Scatter
from fesloop.analysis.people.scatter import simulated as scatter_simulated
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.registry import patient_reader
from fesloop.models.arm_responses import ArmResponses
from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.stored import write_stimulation

SPREADS = {"strength": 0.25, "muscle_strength": 0.15, "threshold": 0.18, "muscle_threshold": 0.12}
ELECTRODES = tuple(Pads().muscles)
STRONG = {"current_a": 0.126, "width_s": 5e-4}
"""Pulses that recruit wholly, so that torque is strength."""


def grids():
    return own_patient._grids(SPREADS)


def test_without_information_the_spreads_are_the_presets():
    logs = grids()
    common, single = posterior([np.ones((len(logs[0]),) * 2)] * 2, SPREADS, logs)
    assert common == (pytest.approx((0.0, 0.25), abs=3e-3), pytest.approx((0.0, 0.18), abs=3e-3))
    for strength, threshold in single:
        assert strength == pytest.approx((0.0, np.hypot(0.25, 0.15)), abs=5e-3)
        assert threshold == pytest.approx((0.0, np.hypot(0.18, 0.12)), abs=5e-3)


def test_posterior_of_normal_likelihoods_is_that_of_a_linear_model():
    """Of log torque = strength - 3 threshold with normal errors, by the textbook's formula."""
    logs, seen, error = grids(), np.array([0.9, 0.3]), 0.2
    u, v = np.meshgrid(*logs, indexing="ij")
    likelihoods = [np.exp(-0.5 * ((u - 3.0 * v - each) / error)**2) for each in seen]
    common, single = posterior(likelihoods, SPREADS, logs)
    # S, T, s1, s2, t1, t2
    prior = np.diag([0.25, 0.18, 0.15, 0.15, 0.12, 0.12])**2
    rows = np.array([[1, -3, 1, 0, -3, 0], [1, -3, 0, 1, 0, -3]], float)
    gain = prior @ rows.T @ np.linalg.inv(rows @ prior @ rows.T + error**2 * np.eye(2))
    mean, covariance = gain @ seen, prior - gain @ rows @ prior
    for found, row in ((common[0], [1, 0, 0, 0, 0, 0]), (common[1], [0, 1, 0, 0, 0, 0]),
                       (single[0][0], [1, 0, 1, 0, 0, 0]), (single[1][0], [1, 0, 0, 1, 0, 0]),
                       (single[0][1], [0, 1, 0, 0, 1, 0]), (single[1][1], [0, 1, 0, 0, 0, 1])):
        assert found == pytest.approx((row @ mean, np.sqrt(row @ covariance @ row)), abs=0.01)
    assert single[0][0].sd < np.hypot(0.25, 0.15)


def test_delay_of_a_course_moves_its_muscle_and_less_so_the_person():
    """One course of FCR, 18 ms later than the preset, error 4, person 4 and muscle 9 ms: by conditioning."""
    pool, beside = ArmResponses.shipped().delay, (40.0, 4.0, 9.0)
    common, single = courses_posterior([("flexor carpi radialis", 58.0, 4.0)], *beside, pool, 50.0, Pads())
    total = 4.0**2 + 9.0**2 + 4.0**2
    assert common == pytest.approx((18.0 * 16.0 / total, np.sqrt(16.0 - 16.0**2 / total)))
    assert single["FCR"] == pytest.approx((18.0 * 81.0 / total, np.sqrt(81.0 - 81.0**2 / total)))
    usual = 50.0 * pool.of("triceps")[0]
    common, single = courses_posterior([("triceps", usual, 4.0)], *beside, pool, 50.0, Pads())
    assert common.mean == pytest.approx(0.0, abs=1e-9)
    assert common.sd < 4.0
    assert not single


def simulated(patient, seed, electrodes=ELECTRODES, noise_nm=0.02, **settings):
    """A recording of a patient under pads, in a device without friction, and who they seem to be."""
    forearm, wrist = Forearm(patient, Pads(), np.random.default_rng(seed)), HeldWrist(patient)
    rng = np.random.default_rng([seed, 1])
    given = {"current_a": 0.03, "width_s": 1.5e-4, **settings}

    def torque(signs, repeats, muscles):
        out = np.zeros((len(signs), 4))
        for row, ((pronated, flexed, radial), muscle) in enumerate(zip(signs, muscles, strict=True)):
            recruited, hertz = forearm.recruitment(
                ELECTRODES.index(electrodes[muscle]), given["current_a"], given["width_s"], 40.0,
                np.deg2rad(40.0 * pronated))
            angles = np.deg2rad([10.0 * flexed, 10.0 * radial])
            out[row, 2:] = wrist.torque_nm(wrist.activation(recruited, hertz), *angles)
        return out + noise_nm * rng.normal(size=out.shape)

    recording = wrist_recording(torque, muscles=electrodes, friction_nm=np.zeros(4), **given)
    return recording, ArmPopulation.shipped().person(trials_of(recording))


def of_strength(factor, number):
    """A member of the preset whose muscles are `factor` times as strong as the preset's."""
    tables = patient_reader().load("able_bodied").member(cohort=9, number=number).table()
    tables["strength"] |= {"overall": factor, "muscles": {}}
    return patient_reader().from_table(tables, "known")


def test_whole_recruitment_tells_strength(monkeypatch):
    monkeypatch.setattr(own_patient, "MEMBERS", 16)
    found = {factor: own_patient.own_patient(*simulated(of_strength(factor, 1), 1, ELECTRODES[:2], **STRONG))
             for factor in (0.7, 1.4)}
    assert found[1.4].strength.mean - found[0.7].strength.mean > 0.3 * np.log(2.0)
    for factor, own in found.items():
        for each in own.muscles:
            assert each.strength.sd < 0.28
            assert abs(each.strength.mean - np.log(factor)) < 2.0 * each.strength.sd
            assert each.stranger_nm[0] < each.expected_nm < each.stranger_nm[1]
            assert each.own_nm == pytest.approx(evoked_by(own.tables, each.electrode), rel=0.03)
        assert f"{own.muscles[0].own_nm:+.3g}, " in own_patient.patient_text(own, "p.h5")


def evoked_by(tables, electrode):
    """Mean flexion that a patient of a file evokes at `STRONG`, its pads over its motor points."""
    patient = patient_reader().from_table(tables, "own")
    wrist, forearm = HeldWrist(patient), Forearm(patient, Pads(error_mm=0.0), np.random.default_rng(0))
    torque = []
    for pronated, flexed, radial in product((-1, 1), repeat=3):
        recruited = forearm.recruitment(ELECTRODES.index(electrode), STRONG["current_a"], STRONG["width_s"],
                                        40.0, np.deg2rad(40.0 * pronated))
        angles = np.deg2rad([10.0 * flexed, 10.0 * radial])
        torque.append(wrist.torque_nm(wrist.activation(*recruited), *angles)[0])
    return np.mean(torque)


@pytest.mark.slow
def test_patients_of_known_strength_are_found_again(monkeypatch):
    """Members of the preset, recorded: 90 % intervals hold their strength and thresholds."""
    monkeypatch.setattr(own_patient, "MEMBERS", 60)
    inside, scores, narrower = [], [], []
    for number in range(10):
        patient = patient_reader().load("able_bodied").member(cohort=9, number=number)
        own = own_patient.own_patient(*simulated(patient, number))
        for each in own.muscles:
            truth = np.log([patient.strength.overall * patient.strength.muscles[each.muscle],
                            patient.recruitment.threshold * patient.recruitment.thresholds[each.muscle]])
            for factor, value in zip((each.strength, each.threshold), truth, strict=True):
                scores.append((value - factor.mean) / factor.sd)
                inside.append(abs(scores[-1]) < own_patient.WITHIN)
            narrower.append(each.threshold.sd / np.hypot(0.18, 0.15))
    assert np.mean(inside) >= 0.8
    assert 0.6 < np.std(scores) < 1.4
    assert np.mean(narrower) < 0.95


def biceps_alone():
    return wrist_recording(lambda signs, *_: np.tile([1.0, 0.1, 0.0, 0.0], (len(signs), 1)),
                           muscles=("biceps",))


def flexion_of(torque_nm):
    """A recording of FCR with a mean flexion."""
    def evoked(signs, *_):
        rng = np.random.default_rng(0)
        return np.array([0.0, 0.0, torque_nm, 0.0]) + 0.01 * rng.normal(size=(len(signs), 4))

    return wrist_recording(evoked)


@pytest.mark.parametrize(("recording", "message"), [
    (biceps_alone(), "made up: muscles: biceps; allowed: one or more of flexor carpi radialis"),
    (flexion_of(20.0), r"made up: flexor carpi radialis: evokes \+20 N m of wrist flexion at 30 mA and 200 "),
    (flexion_of(-4.0), r"made up: flexor carpi radialis: evokes -4 N m .*check signs, currents")])
def test_recordings_of_no_patient_are_refused_in_one_line(recording, message, monkeypatch):
    monkeypatch.setattr(own_patient, "MEMBERS", 8)
    person = ArmPopulation.shipped().person(trials_of(recording))
    with pytest.raises(InputError, match=message) as raised:
        own_patient.own_patient(recording, person)
    assert "\n" not in str(raised.value)


def test_an_offset_of_passive_trials_is_named_and_both_baselines_are_labelled(tmp_path, monkeypatch, capsys):
    """Six electrodes of which five do nothing: the visit's median is 0, but for noise."""
    monkeypatch.setattr(own_patient, "MEMBERS", 8)
    monkeypatch.chdir(tmp_path)
    muscles = (*ELECTRODES, "biceps", "triceps")

    def evoked(signs, _, muscle):
        rng = np.random.default_rng(0)
        return (0.3 * (muscle == 0)[:, np.newaxis] * [0.0, 0.0, 1.0, 0.0]
                + 0.01 * rng.normal(size=(len(signs), 4)))

    plain = wrist_recording(evoked, muscles=muscles)
    steady = replace(plain.steady, baseline="visit_median")
    device = steady.device_torque_nm.copy()
    device[~steady.stimulated] += [0.0, 0.0, 0.15, 0.0]
    recorded = []
    for name, each in (("even", steady), ("off", replace(steady, device_torque_nm=device))):
        write_stimulation(replace(plain, steady=each), tmp_path / f"{name}.h5")
        assert main(["identify", "--stimulation", f"{name}.h5", "--patient", f"{name}.toml",
                     "--out", f"{name}.json"]) == 0
        err = " ".join(capsys.readouterr().err.split())
        assert ("passive trials are not at the median of their visits, but at wrist_flexion -0.15" in err
                ) == (name == "off")
        assert "evoked torque, N m, over the median of each visit, at" in err
        assert "recorded, over all passive trials, of this patient" in err
        recorded.append(float(re.search(r"FCR (\S+) \(sd", err)[1]))
    assert recorded[1] - recorded[0] == pytest.approx(0.15, abs=0.01)


def test_a_muscle_that_strong_pulses_do_not_move_leaves_the_interval_wide(monkeypatch):
    monkeypatch.setattr(own_patient, "MEMBERS", 16)
    recording = flexion_of(0.0)
    own = own_patient.own_patient(recording, ArmPopulation.shipped().person(trials_of(recording)))
    usual = np.hypot(0.18, 0.15)
    assert own.muscles[0].expected_nm > 0.5
    assert abs(own.muscles[0].threshold.mean) < usual
    assert own.muscles[0].threshold.sd > 0.8 * usual


def test_command_writes_a_patient_that_experiments_take(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(own_patient, "MEMBERS", 16)
    monkeypatch.chdir(tmp_path)
    recording, _ = simulated(of_strength(1.3, 2), 2, ELECTRODES[:2], person='Anna "A"')
    write_stimulation(recording, tmp_path / "p1.h5")
    assert main(["identify", "p1.h5", "--patient", "own.toml"]) == 2
    assert "--patient: is for recordings of stimulation" in capsys.readouterr().err
    assert main(["identify", "--stimulation", "p1.h5", "--patient", "own.toml"]) == 0
    out = capsys.readouterr()
    assert out.out.split() == ["p1_person.json", "own.toml"]
    assert "arm_bench takes these torques; recruitment, delay and speed of its muscles are the" in out.err
    text = (tmp_path / "own.toml").read_text("utf-8")
    assert "# strength and thresholds of FCR, PL are the preset's, moved" in text
    assert "natural frequency, and their spreads, are those of able_bodied: there are no courses" in text
    own, preset = patient_reader().load("own.toml"), patient_reader().load("able_bodied")
    assert own.name == 'Anna "A"'
    assert set(own.strength.muscles) == {"FCR", "PL"}
    assert set(own.cohort.strengths) == {"FCR", "PL"} == set(own.cohort.thresholds)
    assert own.cohort.strengths["FCR"] < preset.cohort.muscle_strength + 0.01
    assert own.cohort.motor_along_mm == preset.cohort.motor_along_mm
    assert own.muscle == preset.muscle
    assert "# variation between trials is" in text
    assert "# pads are assumed to have a radius of 12 mm and to lie within 6 mm (sd)" in text
    members = [own.member(cohort=1, number=number) for number in range(40)]
    strengths = np.log([each.strength.overall * each.strength.muscles["FCR"] for each in members])
    total = np.hypot(own.cohort.strength, own.cohort.strengths["FCR"])
    assert 0.6 * total < strengths.std() < 1.4 * total
    choice = ("patient=own.toml", "cohort=1", "member=3")
    assert main(["check", "open_close", *(word for each in choice for word in ("--set", each))]) == 0


@pytest.mark.parametrize(("noise_nm", "repeats", "reason"), [
    (0.0, 2, "has no muscle of a clear torque"), (0.01, 1, "has no repeated steady trials")])
def test_variation_that_repeats_do_not_tell_is_the_presets(noise_nm, repeats, reason):
    rng = np.random.default_rng(0)
    recording = wrist_recording(lambda signs, *_: np.array([0.0, 0.0, 0.3, 0.0]) + noise_nm * rng.normal(
        size=(len(signs), 4)), repeats=repeats)
    tables = {"variation": dict(patient_reader().load("able_bodied").table()["variation"])}
    assert own_patient._write_variation(tables, recording).endswith(f"the recording {reason}")
    assert tables["variation"]["scale"] == 1.0


@pytest.mark.slow
def test_variation_between_trials_is_found_again(recordings):
    """A recorded person, simulated with half and twice the preset's variation."""
    person = open_stimulation(recordings / "fes_exo" / "S9006.npz")
    preset = patient_reader().load("able_bodied").table()["variation"]
    scales = {}
    for factor in (0.5, 1.0, 2.0):
        scatter = Scatter(*(factor * preset[name] for name in Scatter._fields))
        tables = {"variation": dict(preset)}
        made_up = scatter_simulated(person, scatter, preset["drift_s"], np.random.default_rng(5))
        assert "by repeats" in own_patient._write_variation(tables, made_up)
        scales[factor] = tables["variation"]["scale"]
    assert scales[0.5] < 0.75
    assert 0.85 < scales[1.0] < 1.18
    assert 1.5 < scales[2.0] < 2.2


@pytest.mark.slow
def test_a_recorded_person_is_a_patient(recordings, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = recordings / "fes_exo" / "S9004.npz"
    assert main(["import", "--stimulation", str(path), "--out", "p.h5"]) == 0
    assert main(["identify", "--stimulation", "p.h5", "--patient", "own.toml", "--json"]) == 0
    own = patient_reader().load("own.toml")
    assert set(own.strength.muscles) == {"FCR", "PL", "FCU", "ECRL"}
    assert "FCR" in own.muscle.delays_ms
    assert own.cohort.delay_ms < patient_reader().load("able_bodied").cohort.delay_ms
    assert own.recruitment.thresholds["ECRL"] < own.recruitment.thresholds["FCU"]

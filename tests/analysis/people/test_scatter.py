"""Scatter of repeats in proportion to torque: of simulated people whose scatter is known, and of people."""

from dataclasses import replace

import numpy as np
import pytest

from fesloop.analysis.people.scatter import Scatter, repeats_of, scatter_of, simulated
from fesloop.errors import InputError
from fesloop.streams.stimulation import SteadyTrials, StimulationRecording, open_stimulation
from plants.patients.files import load

MUSCLES, POSTURES, DRIFT_S = ("biceps", "triceps", "flexor carpi radialis", "palmaris longus"), 16, 600.0
KNOWN = Scatter(trial=0.15, muscle_trial=0.25, drift=0.2, muscle_drift=0.3)


def recorded(scatter, rng, repeats=3):
    """A recording of one joint in random order, without friction: visits of 25 s."""
    visits = np.concatenate([rng.permutation(POSTURES) for _ in range(repeats)])
    visit, muscle = (grid.ravel() for grid in np.meshgrid(np.arange(len(visits)), np.arange(len(MUSCLES)),
                                                          indexing="ij"))
    posture, time_s = visits[visit], 25.0 * visit + 3.0 * muscle
    angle = 0.1 * posture[:, np.newaxis]
    slow = np.linalg.cholesky(np.exp(-abs(np.subtract.outer(time_s, time_s)) / DRIFT_S)
                              + 1e-9 * np.eye(len(time_s)))
    logs = scatter.trial * rng.normal(size=len(visits))[visit]
    logs += scatter.muscle_trial * rng.normal(size=len(visit))
    logs += scatter.drift * slow @ rng.normal(size=len(visit))
    for number in range(len(MUSCLES)):
        logs += scatter.muscle_drift * (muscle == number) * (slow @ rng.normal(size=len(visit)))
    torque = ((1.0 + 0.3 * angle[:, 0]) * np.array([1.0, -0.8, 0.5, 0.7])[muscle] * np.exp(logs)
              + 0.05 * rng.normal(size=len(visit)))
    missing, count = np.full((len(visit), 1), np.nan), len(visit)
    steady = SteadyTrials(
        muscle=muscle, posture=np.array([f"{each:02}" for each in posture]), visit=visit, order=muscle,
        repeat=visit // POSTURES, time_s=time_s, reference_rad=angle, angle_rad=angle,
        pulse_width_s=np.full(count, 2e-4), current_a=np.full(count, 0.02),
        device_torque_nm=-torque[:, np.newaxis], device_torque_sd_nm=missing, creep_nm=missing.copy(),
        stiffness_nm_rad=missing.copy(), baseline="none")
    unknown = np.full(len(MUSCLES), np.nan)
    return StimulationRecording(
        person="one", muscles=MUSCLES, joints=("elbow_flexion",), zero_rad=np.zeros(1), frequency_hz=40.0,
        friction_nm=np.full(1, np.nan), lowest_width_s=unknown, highest_width_s=unknown.copy(),
        width_current_a=unknown.copy(), source="one.csv", source_format="csv", steady=steady)


def test_the_scatter_of_simulated_people_is_found():
    rng = np.random.default_rng(4)
    people = [repeats_of(recorded(KNOWN, rng)) for _ in range(12)]
    np.testing.assert_allclose(scatter_of(people, DRIFT_S), KNOWN, atol=0.05)


def test_what_does_not_grow_with_torque_is_no_scatter_of_muscles():
    rng = np.random.default_rng(5)
    people = [repeats_of(recorded(Scatter(0.0, 0.0, 0.0, 0.0), rng)) for _ in range(6)]
    assert max(scatter_of(people, DRIFT_S)) < 0.03


def test_a_recording_without_repeats_is_refused():
    once = recorded(KNOWN, np.random.default_rng(1), repeats=1)
    with pytest.raises(InputError, match="repeated"):
        repeats_of(once)
    with pytest.raises(InputError, match="steady"):
        simulated(replace(once, steady=None), KNOWN, DRIFT_S, np.random.default_rng(1))


@pytest.mark.slow
def test_the_able_bodied_preset_scatters_as_people_in_the_friction_of_their_device(recordings):
    people = [open_stimulation(recordings / "fes_exo" / f"S900{number}.npz") for number in (2, 3, 4, 6, 7)]
    variation = load("able_bodied").variation
    given = Scatter(*(getattr(variation, name) for name in Scatter._fields))
    found = scatter_of([repeats_of(each) for each in people], variation.drift_s)
    rngs = [[np.random.default_rng([seed, k]) for k in range(len(people))] for seed in range(4)]
    ours = [scatter_of([repeats_of(simulated(each, given, variation.drift_s, rng))
                        for each, rng in zip(people, several, strict=True)], variation.drift_s)
            for several in rngs]
    np.testing.assert_allclose(np.mean(ours, axis=0), found, atol=0.03)
    friction_alone = [repeats_of(simulated(each, Scatter(0.0, 0.0, 0.0, 0.0), variation.drift_s,
                                           np.random.default_rng(1))) for each in people]
    assert max(scatter_of(friction_alone, variation.drift_s)) < 0.05


def test_trials_of_other_pulse_widths_are_no_repeats():
    """Torque in proportion to width, of 3 widths: what scatters is what scatters at one of them."""
    one = recorded(KNOWN, np.random.default_rng(6))
    steady = one.steady
    assert [rows.tolist() for rows in steady.repeats()] == [rows.tolist() for rows in steady.cells().values()]
    factor = 0.5 + 0.5 * ((steady.repeat + steady.muscle) % 3)
    wide = replace(one, steady=replace(steady, pulse_width_s=factor * steady.pulse_width_s,
                                       device_torque_nm=factor[:, np.newaxis] * steady.device_torque_nm))
    with pytest.raises(InputError, match=r"no repeated steady trials; .* by the same pulses"):
        repeats_of(wide)
    assert np.isnan(wide.steady.repeatability().sd_nm).all()
    jitter = replace(one, steady=replace(steady, current_a=steady.current_a * (1.0 + 0.005 * (factor - 1.0))))
    np.testing.assert_array_equal(jitter.steady.stimulus, steady.muscle)


def test_scatter_of_people_with_three_widths_is_found():
    rng, people = np.random.default_rng(4), []
    for _ in range(12):
        one = recorded(KNOWN, rng, repeats=6)
        factor = 0.5 + 0.5 * (one.steady.repeat % 3)
        people.append(repeats_of(replace(one, steady=replace(
            one.steady, pulse_width_s=factor * one.steady.pulse_width_s,
            device_torque_nm=factor[:, np.newaxis] * one.steady.device_torque_nm))))
    assert np.hypot.reduce(scatter_of(people, DRIFT_S)) == pytest.approx(np.hypot.reduce(KNOWN), rel=0.1)

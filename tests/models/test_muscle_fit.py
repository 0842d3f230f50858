"""Fits of a muscle: parameters found again within their standard errors, and bad recordings refused."""

from dataclasses import replace

import numpy as np
import pytest

from fesloop.analysis.muscle_fit import STEP_S, MuscleTrial, fit_muscle, rms_error, trial_of
from fesloop.errors import InputError
from fesloop.models.hill_muscle import HillMuscle
from fesloop.streams.stimulation import ForceCourse

TRUE = HillMuscle(force_n=12.0, fibre_mm=12.0, slack_mm=26.0, strain=0.08, fastest=10.0, calcium_ms=35.0)
BOUNDS = {"force_n": (5.0, 30.0), "fibre_mm": (8.0, 16.0), "slack_mm": (20.0, 45.0), "strain": (0.01, 0.15),
          "fastest": (4.0, 25.0), "calcium_ms": (10.0, 80.0)}


def made(muscle, seed, count=16):
    """Isometric trials, and ramps of shortening, with white noise of 1 % of the force."""
    random, times = np.random.default_rng(seed), STEP_S * np.arange(500)
    trials = []
    for number in range(count):
        fibre = 0.75 + 0.5 * (number % 4) / 3.0
        ramp = 0.0 if number < count // 2 else -random.uniform(2.0, 8.0)
        shortened = np.clip(ramp * (times - 0.25), -0.35, 0.0) if ramp else 0.0 * times
        length = 1e-3 * (muscle.slack_mm * 1.04 + muscle.fibre_mm * (fibre + shortened))
        drive = ((times > 0.05) & (times < 0.05 + random.uniform(0.05, 0.3))).astype(float)
        force = muscle.force(length, drive, STEP_S)
        noisy = force + 0.01 * muscle.force_n * random.normal(size=force.size)
        trials.append(MuscleTrial(f"{number}", "ramp" if ramp else "isometric", length, noisy, drive))
    return trials


@pytest.mark.parametrize("seed", [1, 2])
def test_a_known_muscle_is_found_within_its_standard_errors(seed):
    found = fit_muscle(made(TRUE, seed), BOUNDS)
    for name, error in found.standard_errors.items():
        off = getattr(found.muscle, name) - getattr(TRUE, name)
        assert abs(off) < 5.0 * error, name
        assert error < 0.1 * getattr(TRUE, name), name
    assert found.muscle.passive == HillMuscle().passive


def test_a_parameter_on_its_bound_has_no_standard_error():
    found = fit_muscle(made(TRUE, 3, 8), BOUNDS | {"fibre_mm": (8.0, 9.0)})
    assert found.muscle.fibre_mm == pytest.approx(9.0)
    assert np.isnan(found.standard_errors["fibre_mm"])
    assert np.isfinite(found.standard_errors["force_n"])


def test_the_error_of_a_trial_is_that_of_its_noise():
    (trial, *_) = made(TRUE, 4)
    assert rms_error(TRUE, trial) == pytest.approx(0.12, rel=0.1)


def course(**changes):
    kept = {"name": "ISOM01", "kind": "ISOM", "muscle": 0, "start_s": 0.0, "period_s": 5e-4,
            "force_n": np.arange(100.0), "length_m": np.full(100, 0.04), "pulses_s": np.array([0.01, 0.02])}
    return ForceCourse(**(kept | changes))


def test_samples_are_averaged_and_a_pulse_acts_until_the_next_is_due():
    trial = trial_of(course(), 100.0)
    np.testing.assert_allclose(trial.force_n, 0.5 + 2.0 * np.arange(50))
    np.testing.assert_array_equal(np.flatnonzero(trial.drive), np.arange(10, 30))


def test_bad_recordings_are_one_line():
    with pytest.raises(InputError, match="ISOM01: the length of the muscle is missing"):
        trial_of(course(length_m=np.full(100, np.nan)), 100.0)
    with pytest.raises(InputError, match=r"a sample each 0\.7 ms"):
        trial_of(course(period_s=7e-4), 100.0)
    with pytest.raises(InputError, match="at least 2"):
        fit_muscle(made(TRUE, 1)[:1], BOUNDS)
    still = [trial._replace(force_n=0.0 * trial.force_n) for trial in made(replace(TRUE), 1, 4)]
    with pytest.raises(InputError, match="stimulation and force"):
        fit_muscle(still, BOUNDS)

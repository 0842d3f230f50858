"""About 20 s, most of it subspace identification and the first compilation."""

import json
from dataclasses import replace

import numpy as np
import pytest
from identification_parts import finger_record
from scipy.special import ndtr

import fesloop
from controllers.identification.dynamics import Dynamics, delayed, identify_dynamics
from controllers.identification.patient_model import fit_of, fit_recruitment, identify, lagged
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger

FINE = 25_000_000
FINGERS_US = Finger().recruitment.chronaxie_us


@pytest.fixture(scope="module")
def record():
    return finger_record(Finger())


@pytest.fixture(scope="module")
def identified(record):
    return identify(record, chronaxie_us=FINGERS_US)


@pytest.mark.slow
def test_recovers_the_fingers_recruitment_curves(identified):
    curves = Finger().recruitment
    np.testing.assert_allclose(identified.model.recruitment.threshold_ma, curves.threshold_ma, rtol=0.05)
    np.testing.assert_allclose(identified.model.recruitment.spread, curves.spread, rtol=0.15)


def test_recovers_the_fingers_dynamics(identified):
    truth = Finger().linear_model()
    found, true = (model.sampled(FINE).lifted(60) for model in (identified.model, truth))
    assert np.linalg.norm(found - true) < 0.08 * np.linalg.norm(true)
    np.testing.assert_allclose(identified.model.offset, truth.offset, atol=np.deg2rad(0.5))
    assert 0 <= identified.model.delay_ns <= 50_000_000


@pytest.mark.slow
def test_predicts_what_it_was_not_fitted_to(identified, record):
    assert min(identified.fit["free_run"].values()) > 95.0
    assert identified.held_out_s == pytest.approx(15.0)
    by_fir = identify(record, method="fir", chronaxie_us=FINGERS_US)
    assert min(by_fir.fit["free_run"].values()) > 90.0


def test_a_ramp_does_as_well_as_stairs():
    short = finger_record(Finger(), recruitment="ramp", prbs_s=0.2)
    for channel, threshold in enumerate(Finger().recruitment.threshold_ma):
        rows = short.phase == channel
        found = fit_recruitment(short.stimulation[rows, channel, 1], 40.0, short.measured[rows], 0.02,
                                chronaxie_us=FINGERS_US)
        assert found.threshold_ma == pytest.approx(threshold, rel=0.05)


def test_isometric_force_gives_the_curve_as_motion_does():
    """In newtons, without a joint: recruitment behind the activation's own two lags."""
    width = np.repeat(np.linspace(50e-6, 400e-6, 8), 25)
    fraction = np.array([Finger().recruitment.fraction(np.tile([0.04, w], (4, 1)))[0] for w in width])
    force = 3.0 * lagged(fraction, 0.04, 0.02)[:, np.newaxis]
    found = fit_recruitment(width, 40.0, force, 0.02, chronaxie_us=FINGERS_US)
    assert found.threshold_ma == pytest.approx(12.0, rel=0.01)
    assert found.spread == pytest.approx(0.35, rel=0.03)
    assert found.lag_s == pytest.approx(0.04, rel=0.03)
    assert found.gain[0] == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize(("half_ma", "end"), [(12.0, None), (20.0, None), (45.0, "or more")])
def test_a_half_that_lies_beyond_the_strongest_pulse_is_marked_as_at_the_bound(half_ma, end):
    width = np.repeat(np.linspace(50e-6, 400e-6, 8), 25)
    effective = 40.0 * width / (width + 200e-6)
    force = 3.0 * lagged(ndtr(np.log(effective / half_ma) / 0.35), 0.04, 0.02)[:, np.newaxis]
    found = fit_recruitment(width, 40.0, force, 0.02, chronaxie_us=FINGERS_US)
    assert found.at_bound.get("threshold_ma") == end
    assert (found.threshold_ma > 0.99 * effective.max()) == (end is not None)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["subspace", "fir"])
def test_a_system_of_second_order_with_delay_is_found(method):
    """Two states a channel: x'' + 2 w x' + w^2 x = w^2 g v(t - 40 ms), a multiple of the period."""
    w, period = 8.0, 0.02
    a = np.kron(np.eye(2), [[0.0, 1.0], [-w * w, -1.6 * w]])
    b, c = np.kron(np.eye(2), [[0.0], [w * w]]), np.array([[1.0, 0.0, -0.4, 0.0]])
    truth = LinearModel(a=a, b=b, c=c, offset=np.array([0.3]), delay_ns=40_000_000)
    drive = np.repeat(np.random.default_rng(1).integers(0, 2, (200, 2)), 10, axis=0).astype(float)
    sampled = truth.sampled(20_000_000)
    x, y = np.zeros(sampled.a.shape[0]), []
    for v in drive:
        y.append(sampled.c @ x + sampled.offset)
        x = sampled.a @ x + sampled.b @ v
    noise = 1e-4 * np.random.default_rng(2).standard_normal((len(drive), 1))
    found = identify_dynamics(drive, np.array(y) + noise, period, method=method)
    a_found, b_found = found.continuous()
    model = LinearModel(a=a_found, b=b_found, c=found.c, offset=found.offset,
                        delay_ns=round(1e9 * found.delay_s))
    ours, true = (each.sampled(FINE).lifted(40) for each in (model, truth))
    assert np.linalg.norm(ours - true) < (0.03 if method == "subspace" else 0.05) * np.linalg.norm(true)


DRIFTS = {"tires in 12 s": lambda times, rng: 4.0 * np.exp(-times / 12.0),
          "tires in 30 s": lambda times, rng: 4.0 * np.exp(-times / 30.0),
          "line": lambda times, rng: 3.0 * times / times[-1],
          "walk": lambda times, rng: 0.1 * np.cumsum(rng.standard_normal(times.size))}


@pytest.mark.parametrize(("kind", "least"), [
    ("tires in 12 s", 85.0), ("tires in 30 s", 85.0), ("line", 85.0),
    ("walk", 20.0)])  # it has quick parts, too
def test_drift_of_muscles_is_not_taken_for_a_slow_lag(kind, least):
    """It is as large as what the drives do, or several times that; what these do is known."""
    period = 0.025
    true = Dynamics(a=np.diag([0.85, 0.7]), b=np.array([[0.15, 0.0], [0.1, 0.3]]),
                    c=np.array([[1.0, 0.0], [0.5, 1.0]]), offset=np.zeros(2), delay_s=0.05, period_s=period)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        drive = np.repeat(rng.integers(0, 2, (120, 2)), 10, axis=0).astype(float)
        moved, times = true.response(drive), np.arange(len(drive)) * period
        course = np.stack([DRIFTS[kind](times, rng), -DRIFTS[kind](times, rng)], axis=1) * moved.std(axis=0)
        found = identify_dynamics(drive, moved + course + 0.02 * rng.standard_normal(moved.shape), period)
        assert -1.0 / np.linalg.eigvals(found.continuous()[0]).real.max() <= 2.0
        again = found.response(drive)
        assert min(fit_of(moved - moved.mean(axis=0), again - again.mean(axis=0))) > least


def test_continuous_time_is_the_inverse_of_sampling():
    nominal = Finger().linear_model()
    sampled = replace(nominal, delay_ns=0).sampled(1_000_000)
    a, b = Dynamics(a=sampled.a, b=sampled.b, c=sampled.c, offset=sampled.offset, delay_s=0.0,
                    period_s=0.001).continuous()
    np.testing.assert_allclose(a, nominal.a, atol=1e-6 * np.abs(nominal.a).max())
    np.testing.assert_allclose(b, nominal.b, atol=1e-6 * np.abs(nominal.b).max())


def test_a_delay_of_part_of_a_period_is_averaged():
    drive = np.array([[0.0], [1.0], [1.0], [0.0]])
    np.testing.assert_allclose(delayed(drive, 1.25)[:, 0], [0.0, 0.0, 0.75, 1.0])


def test_as_good_as_the_yardstick(record):
    """Within a percent of nfoursid's N4SID of the same order, free run on what was held out."""
    nfoursid = pytest.importorskip("nfoursid.nfoursid")
    pandas = pytest.importorskip("pandas")
    recruitment = Finger().recruitment
    binary = record.phase == record.channels
    drive = np.array([recruitment.fraction(pulses) for pulses in record.stimulation[binary]])
    measured, first = record.measured[binary], 1500
    mean = measured[:first].mean(axis=0), drive[:first].mean(axis=0)
    table = pandas.DataFrame(np.hstack([measured[:first] - mean[0], drive[:first] - mean[1]]),
                             columns=[*"abc", *"defg"])
    theirs = nfoursid.NFourSID(table, output_columns=list("abc"), input_columns=list("defg"),
                               num_block_rows=15)
    theirs.subspace_identification()
    system, _ = theirs.system_identification(rank=8)
    x, predicted = np.zeros((8, 1)), []
    for v in drive - mean[1]:
        predicted.append((system.c @ x + system.d @ v[:, np.newaxis])[:, 0] + mean[0])
        x = system.a @ x + system.b @ v[:, np.newaxis]
    ours = identify_dynamics(drive[:first], measured[:first], 0.02).response(drive)
    theirs_fit, ours_fit = (np.array(fit_of(measured[first:], each[first:]))
                            for each in (np.array(predicted), ours))
    assert (ours_fit > theirs_fit - 1.0).all()


def test_names_what_it_cannot_be_made_of(record):
    still = replace(record, measured=np.where((record.phase == 2)[:, np.newaxis], 0.3, record.measured))
    silent = replace(record, stimulation=np.zeros_like(record.stimulation))
    with pytest.raises(InputError, match=r"channel 0: recruitment: no pulse was given.*pose_contradicted"):
        identify(silent)
    with pytest.raises(InputError, match="channel 2: recruitment: nothing moved"):
        identify(still)
    with pytest.raises(InputError, match="not finite"):
        replace(record, measured=np.where(record.phase[:, np.newaxis] == 4, np.nan, record.measured))
    with pytest.raises(InputError, match="longer prbs_s"):
        identify(finger_record(Finger(), prbs_s=2.0))
    with pytest.raises(InputError, match="channel 3: was not recruited"):
        identify(replace(record, phase=np.where(record.phase == 3, -1.0, record.phase)))


def identification_of_a_finger(tmp_path):
    """An identification experiment in a file of its own, run."""
    return from_document({
        "experiment": {"name": "identify_finger", "duration_s": 68.0, "seed": 3},
        "blocks": {"excitation": {"kind": "excitation", "rate": "50", "current_ma": [40.0] * 4,
                                  "width_us": [[0, 400]] * 4, "prbs_us": [[0, 150]] * 4, "lead_s": 1.0},
                   "finger": {"kind": "finger", "strength": 1.2, "speed": 0.85},
                   "tracker": {"kind": "ideal", "rate": "100", "noise_deg": 0.3}},
        "wires": [{"from": "excitation.stimulation", "to": "finger.stimulation", "latency_ms": 5.0},
                  {"from": "finger.angles", "to": "tracker.angles"}]}).run(tmp_path)


@pytest.mark.slow
def test_from_a_recording_to_a_controller_that_holds(tmp_path, capsys):
    """finger_mpc's patient, who differs from the model that it ships with, is the one identified."""
    result = identification_of_a_finger(tmp_path)
    path = tmp_path / "model.toml"
    assert main(["identify", str(result.recording), "--measured", "tracker.angles", "--out", str(path),
                 "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert min(report["fit_percent"]["free_run"].values()) > 95.0
    # 5 % of FDP at 40 mA: 12 mA e^(-1.645 x .35) = 6.75 mA effective, 200 us x 6.75 / (40 - 6.75) = 40.6 us.
    assert report["channels"][0]["threshold_us"] == pytest.approx(40.6, rel=0.15)
    run = fesloop.load("finger_mpc", [f'blocks.controller.model={{ file = "{path}" }}',
                                      "experiment.duration_s=6"]).run(tmp_path)
    assert run.metrics["joint_rmse_deg"][0] < 3.0


def test_the_command_names_a_recording_of_something_else(tmp_path, capsys):
    result = fesloop.load("finger_mpc", ["experiment.duration_s=1"]).run(tmp_path)
    assert main(["identify", str(result.recording)]) == 2
    assert "no block of kind 'excitation'" in capsys.readouterr().err


def test_an_opening_is_asked_for_after_a_sweep_alone(tmp_path, capsys):
    result = fesloop.load("finger_mpc", ["experiment.duration_s=1"]).run(tmp_path)
    assert main(["identify", str(result.recording), "--opened-deg", "8"]) == 2
    assert capsys.readouterr().err.endswith(
        f"opened_deg: 8, but {result.recording} is no sweep over elements; allowed: a recording of "
        "sweep_grasp; leave it out\n")
    assert main(["identify", "any.csv", "--stimulation", "--opened-deg", "8"]) == 2
    assert "--opened-deg: is for recordings of sweep_grasp" in capsys.readouterr().err

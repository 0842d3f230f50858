"""The estimate of effort from EMG: its filter, its calibration, and its stated rate of false alarms."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, lfilter

from estimators.emg_effort import EmgEffort
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample, Sensors

SHORT = {"rest_s": (0.0, 0.5), "contraction_s": (0.5, 1.0)}


def run(block, emg, hertz=1000):
    """Outputs (n, 3) and reports of EMG (n,) or (n, k)."""
    emg = np.asarray(emg, dtype=np.float64).reshape(len(emg), -1)
    clock, tick = RateClock.from_rate(hertz), Tick()
    state = block.init(Context("emg", 1, 0, clock))
    rows = []
    for index, row in enumerate(emg):
        now = tick.time_ns = clock.tick(index)
        tick.index = index
        rows.append(block.step(state, (Sample(row, now, now, now),), tick))
    return np.array(rows), tick.reports


@given(cutoff_hz=st.floats(0.5, 10.0), level=st.floats(0.1, 1.0), greatest=st.floats(1e-5, 1e-2))
@settings(max_examples=20, deadline=None)
def test_a_step_of_rectified_emg_is_followed_as_two_equal_lags_do(cutoff_hz, level, greatest):
    signs = np.where(np.arange(2500) % 2, -1.0, 1.0)
    emg = signs * np.concatenate([np.zeros(500), np.full(450, greatest), np.zeros(550),
                                  np.full(1000, level * greatest)])
    outputs, reports = run(EmgEffort(cutoff_hz=cutoff_hz, contraction_s=(0.5, 1.5), rest_s=(0.0, 0.5)), emg)
    assert not reports
    assert not outputs[:1500, [0, 2]].any()
    keeps = math.exp(-2.0 * math.pi * cutoff_hz * 1e-3)
    expected = np.abs(emg)
    for _ in range(2):
        expected = lfilter([1.0 - keeps], [1.0, -keeps], expected)
    np.testing.assert_allclose(outputs[1500:, 0], np.minimum(expected[1500:] / greatest, 1.0), atol=1e-9)
    assert (outputs[1500:, 1:] == (0.0, 1.0)).all()
    wt = np.arange(1, 1001) * 2e-3 * math.pi * cutoff_hz
    if cutoff_hz > 4.0:  # what was before has gone
        analytic = level * (1.0 - (1.0 + wt) * np.exp(-wt))
        np.testing.assert_allclose(outputs[1500:, 0], analytic, atol=0.04)


@given(emg=st.lists(st.one_of(st.floats(-1e-2, 1e-2), st.just(math.nan)), min_size=110, max_size=160))
@settings(max_examples=50, deadline=None)
def test_effort_is_a_share_whatever_comes_in(emg):
    outputs, _ = run(EmgEffort(rest_s=(0.0, 0.6), contraction_s=(0.6, 1.0)), emg, hertz=100)
    assert np.isfinite(outputs).all()
    assert ((outputs >= 0.0) & (outputs <= 1.0)).all()


def coloured(rng, count, kind):
    """Noise at rest, (count,)."""
    white = rng.standard_normal(count)
    return white if kind == "white" else lfilter(*butter(1, [60.0, 200.0], "bandpass", fs=1000.0), white)


@pytest.mark.parametrize("kind", ["white", "band"])
@pytest.mark.parametrize("per_min", [6.0, 30.0])
def test_noise_of_rest_exceeds_the_detection_no_more_often_than_stated(kind, per_min):
    """Over many calibrations, each with a quarter of a minute of rest behind it."""
    rng, crossings, times = np.random.default_rng(7), 0, 100
    block = EmgEffort(rest_s=(0.0, 1.5), contraction_s=(1.5, 2.0), false_alarms_per_min=per_min)
    keeps = math.exp(-2.0 * math.pi * 3.0 * 1e-3)
    for _ in range(times):
        emg = 1e-6 * coloured(rng, 18_000, kind)
        emg[1500:2000] *= 50.0
        (*_, (_, detection, calibrated)), _ = run(block, emg[:2001])
        assert calibrated == 1.0
        rest, strong = np.abs(emg[:1500]).mean(), max(np.abs(emg[k:k + 250]).mean() for k in (1500, 1750))
        envelope = np.abs(emg[2000:])
        for _ in range(2):
            envelope = lfilter([1.0 - keeps], [1.0, -keeps], envelope)
        above = envelope[1000:] > rest + detection * (strong - rest)
        crossings += int((above[1:] & ~above[:-1]).sum())
    stated = per_min * times * 15.0 / 60.0
    assert crossings <= stated
    assert crossings >= stated / 10.0, "a threshold that nothing ever reaches says nothing"


def test_a_muscle_without_a_contraction_gives_no_effort():
    noise = 5e-6 * np.random.default_rng(1).standard_normal(3000)
    outputs, reports = run(EmgEffort(**SHORT), noise)
    assert [status for status, _ in reports] == ["no_contraction"]
    assert not outputs[:, [0, 2]].any()
    assert (outputs[:, 1] == 1.0).all()


def test_a_rest_without_samples_gives_no_effort():
    emg = np.concatenate([np.full(500, np.nan), np.full(1500, 1e-3)])
    outputs, reports = run(EmgEffort(**SHORT, lost_ms=1e4), emg)
    assert [status for status, _ in reports] == ["no_rest"]
    assert not outputs[:, 0].any()


def test_lost_samples_do_not_move_the_effort_and_end_it_when_they_last():
    rng = np.random.default_rng(3)
    emg = 1e-4 * rng.standard_normal(3000)
    emg[:500] *= 0.01
    emg[2000:2600] = np.nan
    outputs, reports = run(EmgEffort(**SHORT, lost_ms=250.0), emg)
    assert (outputs[2000:2250, 0] == outputs[1999, 0]).all()
    assert not outputs[2250:2600, 0].any()
    assert outputs[2601, 0] > 0.3
    assert [status for status, _ in reports] == ["emg_lost"]


def test_nothing_is_put_out_before_the_first_sample():
    block = EmgEffort()
    state = block.init(Context("emg", 1, 0, RateClock.from_rate("1000")))
    assert block.step(state, (Sample(np.zeros(1), NEVER, NEVER, NEVER),), Tick()) == ()


def test_the_named_muscle_counts():
    emg = 1e-4 * np.random.default_rng(1).standard_normal((2000, 2))
    emg[:500] *= 0.01
    emg[1000:, 0] = 0.0
    block = EmgEffort(muscle="FCR", **SHORT).with_sensors({"emg": Sensors(("ECRL", "FCR"))})
    assert run(block, emg)[0][1900, 0] > 0.3
    block = EmgEffort(muscle="ECRL", **SHORT).with_sensors({"emg": Sensors(("ECRL", "FCR"))})
    assert run(block, emg)[0][1900, 0] < 0.01


@pytest.mark.parametrize(("parameters", "says"), [
    ({"muscle": "ECR", "muscles": ("ECRL", "FCR")}, "muscle: 'ECR' has no EMG.*did you mean 'ECRL'"),
    ({"muscles": ("ECRL", "FCR")}, "muscle: is not named"),
    ({"rest_s": (2.0, 1.0)}, "rest_s"), ({"contraction_s": (1.0, 3.0)}, "contraction_s.*from 2 on"),
    ({"cutoff_hz": 0.0}, "cutoff_hz"), ({"false_alarms_per_min": 500.0}, "false_alarms_per_min.*below 180")])
def test_wrong_parameters_are_refused_in_one_line(parameters, says):
    with pytest.raises(InputError, match=says) as refused:
        EmgEffort(**parameters)
    assert "\n" not in str(refused.value)

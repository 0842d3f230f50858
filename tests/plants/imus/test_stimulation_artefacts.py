"""Spikes at the pulses, and tremor whose spectrum and size are those that are stated."""

import math

import numpy as np
import pytest
from imu_parts import ideal, run, sites
from scipy.signal import periodogram

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.signals import NEVER, Sample
from plants.imus.disturbances import PulseArtefacts, Pulses, PulseWatch, Tremor

FULL = np.array([[0.01, 1e-4], [0.025, 4e-4]])
"""The second channel's 10 uC are full charge."""


def pulses_every(period_ms, stimulation=FULL, first_ms=0):
    """Messages that arrive every so often."""
    def now(time_ns):
        last = (time_ns // NS_PER_MS - first_ms) // period_ms * period_ms + first_ms
        arrived = last * NS_PER_MS if last >= first_ms else NEVER
        return Sample(stimulation, arrived, arrived, arrived)
    return now


def test_samples_within_the_window_are_spoilt_by_the_stated_size_and_no_other():
    imus = ideal(5, channels=2, artefacts=PulseArtefacts(window_ms=3.0, gyr=0.02, acc=0.3, mag=2e-6))
    clean, _ = run(ideal(5), sites(5), 400, rate="1000")
    spoilt, _ = run(imus, sites(5), 400, rate="1000", pulses=pulses_every(20, first_ms=100))
    hit = (np.arange(400) >= 100) & ((np.arange(400) - 100) % 20 < 3)
    for kind, size in (("gyr", 0.02), ("acc", 0.3), ("mag", 2e-6)):
        sizes = np.linalg.norm(spoilt[kind] - clean[kind], axis=-1)
        np.testing.assert_array_equal(sizes[~hit], 0.0)
        np.testing.assert_allclose(sizes[hit], size, rtol=1e-9)


def test_a_spike_is_in_proportion_to_the_charge():
    imus = ideal(1, channels=2, artefacts=PulseArtefacts(acc=0.3))
    half, _ = run(imus, sites(1), 1, pulses=pulses_every(20, stimulation=FULL * [0.5, 1.0]))
    np.testing.assert_allclose(np.linalg.norm(half["acc"][0] - [0.0, 0.0, 9.80665]), 0.15, rtol=1e-9)
    nothing, _ = run(imus, sites(1), 1, pulses=pulses_every(20, stimulation=0.0 * FULL))
    np.testing.assert_array_equal(nothing["acc"][0, 0], [0.0, 0.0, 9.80665])


def test_a_stimulator_may_repeat_the_newest_message_at_its_own_rate():
    watch, sample = PulseWatch(), Sample(FULL, 0, 0, 7 * NS_PER_MS)
    pulses = Pulses(rate_hz=40.0)
    share, since, interval = watch.now(pulses, sample, 93 * NS_PER_MS)
    assert (share, interval) == (pytest.approx(1.0), 0.025)
    assert since == pytest.approx(0.011)


def test_two_messages_make_a_frequency():
    watch = PulseWatch()
    assert watch.now(Pulses(), Sample(FULL, 0, 0, 0), 0)[2] == 0.0
    assert watch.now(Pulses(), Sample(FULL, 0, 0, 20 * NS_PER_MS), 25 * NS_PER_MS)[1:] == (0.005, 0.02)


def test_physiological_tremor_lies_in_its_band_with_its_size():
    tremor = Tremor(physiological=0.05, band_hz=(8.0, 12.0), tetanic=0.0)
    samples, _ = run(ideal(6, tremor=tremor, measures=("gyr",)), sites(6), 20000, rate="500")
    rate = np.linalg.norm(samples["gyr"], axis=-1)
    np.testing.assert_allclose(np.sqrt((rate**2).mean(axis=0)), 0.05, rtol=0.03)
    frequency, power = periodogram(samples["gyr"], 500.0, axis=0)
    inside = (frequency > 7.9) & (frequency < 12.1)
    assert power[inside].sum() > 0.99 * power.sum()


@pytest.mark.slow
def test_tetanic_tremor_is_at_the_stimulation_frequency_and_follows_the_charge():
    tremor = Tremor(physiological=0.0, tetanic=0.2, rise_s=0.05)
    imus = ideal(1, tremor=tremor, measures=("gyr",), channels=2)
    samples, _ = run(imus, sites(1), 4000, rate="1000", pulses=pulses_every(40))
    along = samples["gyr"][:, 0] @ np.linalg.svd(samples["gyr"][:, 0])[2][0]
    frequency, power = periodogram(along[2000:], 1000.0)
    assert frequency[np.argmax(power)] == pytest.approx(25.0)
    assert along[2000:].std() == pytest.approx(0.2, rel=1e-3)
    peaks = np.abs(along[:400:40]) / (math.sqrt(2.0) * 0.2)
    np.testing.assert_allclose(peaks[2:], 1.0 - np.exp(-np.arange(80, 400, 40) / 50.0), atol=1e-9)


def test_rate_and_acceleration_are_of_one_vibration():
    """What the accelerometer gains is the lever times the derivative of the angular rate."""
    tremor = Tremor(physiological=0.05, tetanic=0.1, lever_m=0.04)
    imus = ideal(3, tremor=tremor, channels=2)
    samples, _ = run(imus, sites(3, force=(0.0, 0.0, 0.0)), 4000, rate="4000", pulses=pulses_every(25))
    for i in range(3):
        gyr, acc = samples["gyr"][2000:, i], samples["acc"][2000:, i]
        axis, swing = np.linalg.svd(gyr)[2][0], np.linalg.svd(acc)[2][0]
        assert abs(axis @ swing) < 1e-9
        change = np.gradient(gyr @ axis, 1 / 4000.0)[5:-5]
        along = (acc @ swing)[5:-5]
        ratio = (change @ along) / (change @ change)
        assert abs(ratio) == pytest.approx(0.04, rel=1e-3)
        np.testing.assert_allclose(along, ratio * change, atol=2e-3 * np.abs(along).max())


def test_two_blocks_of_one_device_shake_as_one_and_anew_in_each_trial():
    def shaking(name, rate, trial):
        imus = ideal(2, tremor=Tremor(), device="glove", measures=("gyr",))
        return run(imus, sites(2), int(rate), rate=rate, name=name, trial=trial)[0]["gyr"]

    slow, fast = shaking("a", "100", 0), shaking("b", "200", 0)
    np.testing.assert_allclose(slow, fast[::2], atol=1e-12)
    assert np.abs(shaking("a", "100", 1) - slow).max() > 1e-3


@pytest.mark.parametrize(("make", "name"), [
    (lambda: PulseArtefacts(window_ms=0.0), "window_ms"), (lambda: PulseArtefacts(acc=-1.0), "acc"),
    (lambda: Tremor(band_hz=(12.0, 8.0)), "band_hz"), (lambda: Tremor(rise_s=0.0), "rise_s"),
    (lambda: Tremor(tetanic=math.nan), "tetanic"), (lambda: Pulses(rate_hz=-1.0), "rate_hz"),
    (lambda: Pulses(full_charge_uc=0.0), "full_charge_uc")])
def test_parameters_that_cannot_be_are_named(make, name):
    with pytest.raises(InputError, match=name):
        make()

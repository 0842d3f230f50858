"""Front ends by name, equal to what they are made of, and beginning anew at rest; samples kind by kind."""

import numpy as np
import pytest
from tracker_parts import sample
from vqf import VQF

from estimators.front_end import NAMES, front_end_of
from estimators.sample_arrivals import Arrivals, inspect_kinds
from estimators.samples import CLIPPED, LOST
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Tick
from fesloop.loop.signals import NEVER, Sample

PERIOD = 0.01
EVERY = np.ones(3, dtype=np.bool_)


def made(name, magnetometer=False, periods=(PERIOD,) * 3, tau_acc_s=None, tau_mag_s=None):
    return front_end_of(name, 3, periods, magnetometer, tau_acc_s, tau_mag_s)


def noisy(count=400):
    gyr, acc, mag = np.random.default_rng(0).normal(size=(3, count, 3, 3))
    return gyr, acc + np.array([0.0, 0.0, 9.81]), mag + np.array([0.0, 20.0, -40.0])


@pytest.mark.parametrize("magnetometer", [False, True])
def test_vqf_at_three_rates_is_vqf_of_three_rates(magnetometer):
    bank = made("vqf", magnetometer, (PERIOD, 2 * PERIOD, 4 * PERIOD), 2.0, 5.0)
    bare = VQF(PERIOD, 2 * PERIOD, 4 * PERIOD, tauAcc=2.0, tauMag=5.0)
    for k, (gyr, acc, mag) in enumerate(zip(*noisy(), strict=True)):
        new_acc, new_mag = k % 2 == 0, magnetometer and k % 4 == 0
        bank.update(gyr, acc if new_acc else None, mag if new_mag else None)
        bare.updateGyr(gyr[1])
        if new_acc:
            bare.updateAcc(acc[1])
        if new_mag:
            bare.updateMag(mag[1])
    expected = bare.getQuat9D() if magnetometer else bare.getQuat6D()
    np.testing.assert_array_equal(bank.orientation()[1], expected)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("magnetometer", [False, True])
def test_begin_forgets_what_was_and_holds_the_bias(name, magnetometer):
    rng = np.random.default_rng(1)
    true = quaternion.normalized(rng.normal(size=(3, 4)))
    back = quaternion.conjugate(true)
    bias = 0.02 * rng.normal(size=(3, 3))
    acc, mag = quaternion.rotate(back, [0.0, 0.0, 9.81]), quaternion.rotate(back, [0.0, 20.0, -40.0])
    bank = made(name, magnetometer)
    for samples in zip(*noisy(), strict=True):
        bank.update(*samples[:2], samples[2] if magnetometer else None)
    untouched = bank.orientation()[2]
    bank.begin(np.array([True, True, False]), bias, acc, mag if magnetometer else None, 300)
    np.testing.assert_array_equal(bank.orientation()[2], untouched)
    for _ in range(500):
        bank.update_only(np.array([True, True, False]), bias, acc, mag if magnetometer else None)
    error = quaternion.multiply(bank.orientation(), quaternion.conjugate(true))[:2]
    assert np.degrees(quaternion.tilt_z(error)).max() < 0.05
    if magnetometer:
        assert np.degrees(np.abs(quaternion.twist_z(error))).max() < 0.05


@pytest.mark.parametrize("name", NAMES)
def test_an_orientation_that_was_given_is_not_written_to(name):
    bank = made(name)
    gyr, acc, _ = noisy(2)
    bank.update(gyr[0], acc[0], None)
    first = bank.orientation()
    kept = first.copy()
    bank.update(gyr[1], acc[1], None)
    np.testing.assert_array_equal(first, kept)
    assert not np.array_equal(bank.orientation(), kept)


def test_another_name_is_refused_with_those_that_there_are():
    with pytest.raises(InputError, match=r"vqf, seel_ruppin.*vqf"):
        made("vfq")
    with pytest.raises(InputError, match="tau_acc_s"):
        made("seel_ruppin", tau_acc_s=-1.0)


def arrived(arrivals, gyr, acc, mag, at):
    """Which kinds are new when gyr, acc and mag have these captures, and what is reported."""
    tick = Tick()
    samples = [sample(rows, stamp) for rows, stamp in zip((gyr, acc, mag), at, strict=True)]
    return arrivals.note(samples, tick), tick.reports


def test_kinds_are_new_by_their_own_stamps_and_only_a_held_rate_is_a_repetition():
    gyr, acc, mag = (rows[0] for rows in noisy(1))
    arrivals = Arrivals(3, (30.0, 100.0, np.inf))
    assert arrived(arrivals, gyr, acc, mag, (0, 0, 0)) == ((True, True, True), [])
    assert arrived(arrivals, gyr, acc, mag, (10, 0, 0)) == ((True, False, False), [])
    assert arrived(arrivals, gyr, acc, mag, (20, 20, 0)) == ((True, True, False), [])
    new, reports = arrived(arrivals, gyr, acc, mag, (20, 20, 0))
    assert not any(new)
    assert [status for status, _ in reports] == ["repeated_sample"]
    assert arrived(arrivals, gyr, acc, mag, (30, 20, 30))[1][0][0] == "samples_sound"


def test_nothing_has_come_before_the_first_message():
    arrivals, tick = Arrivals(3, (30.0, 100.0, np.inf)), Tick()
    nothing = Sample(np.zeros((3, 3)), NEVER, NEVER, NEVER)
    assert arrivals.note([nothing, nothing], tick) == (False, False, False)
    assert (arrivals.codes[0] == LOST).all()
    assert [status for status, _ in tick.reports] == ["lost_sample", "repeated_sample"]


def test_codes_tell_kinds_apart_and_plain_python_agrees():
    gyr, acc, mag = (rows[0] for rows in noisy(1))
    gyr[0], acc[1], mag[2, 0], acc[2, 1], gyr[1] = np.nan, 0.0, np.inf, 120.0, 0.0
    limits = np.array([30.0, 100.0, np.inf])
    found = []
    for kernel in (inspect_kinds, inspect_kinds.py_func):
        codes = np.zeros((3, 3), dtype=np.uint8)
        kernel(gyr, acc, mag, 3, limits, codes)
        found.append(codes.tolist())
    # Zeros of gyroscope and accelerometer together are what stands in a port before the first message.
    assert found[0] == found[1] == [[LOST, LOST, 0], [0, LOST, CLIPPED], [0, 0, LOST]]

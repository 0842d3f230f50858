"""Front ends by name, equal to what they are made of, and beginning anew at rest."""

import numpy as np
import pytest
from vqf import VQF

from estimators.fusion.front_end import NAMES, front_end_of
from fesloop.errors import InputError
from fesloop.hand import quaternion

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


@pytest.mark.slow
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
        bank.update_sound(bias, acc, mag if magnetometer else None, np.tile([False, False, True], (3, 1)))
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

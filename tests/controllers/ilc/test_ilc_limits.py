import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.allocation import Allocation
from controllers.ilc.laws import Limits, pulses_of
from fesloop.models.linear_model import Recruitment

ALLOCATION = Allocation(recruitment=Recruitment(threshold_ma=(12.0, 9.0), spread=(0.35, 0.5)),
                        current_ma=(40.0, 30.0))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-6, 1e-3), st.floats(0.01, 1.0))
def test_whatever_comes_in_stays_inside(seed, charge_c, slew):
    limits = Limits(reach=np.array([0.9, 0.4]), slew=slew, allocation=ALLOCATION, charge_c=charge_c)
    drives = limits.within(np.random.default_rng(seed).normal(0.3, 0.6, (30, 2)))
    assert drives.min() >= 0.0
    assert (drives <= [0.9, 0.4]).all()
    assert np.abs(np.diff(drives, axis=0, prepend=np.zeros((1, 2)))).max() <= slew + 1e-12
    spent = sum(1e-3 * np.array([40.0, 30.0]) * ALLOCATION.stimulation(drive)[:, 1] for drive in drives)
    assert (spent <= charge_c * (1.0 + 1e-12)).all()


def test_drives_inside_are_left_alone():
    drives = np.full((10, 2), 0.2)
    limits = Limits(reach=np.ones(2), slew=0.2, allocation=ALLOCATION, charge_c=1.0)
    np.testing.assert_array_equal(limits.within(drives), drives)


def test_charge_is_current_times_width_and_its_slopes_are_exact_at_the_trial():
    drives = np.random.default_rng(0).uniform(0.1, 0.4, (10, 2))
    limits = Limits(reach=np.ones(2), slew=1.0, allocation=ALLOCATION, charge_c=1e-4)
    pulses = pulses_of(ALLOCATION, drives)
    np.testing.assert_allclose(limits.charges(drives), (pulses[:, :, 0] * pulses[:, :, 1]).sum(axis=0))
    np.testing.assert_allclose(limits.charge_slopes(drives) * drives.sum(axis=0), limits.charges(drives))
    half = 1e-3 * 40.0 * ALLOCATION.stimulation(np.array([0.5, 0.5]))[0, 1] / 0.5
    assert limits.charge_slopes(np.zeros((10, 2)))[0] == pytest.approx(half)

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import ndtri

from controllers.allocation import Allocation, allocate, normal_quantile, planned_charge, risen
from fesloop.errors import InputError
from fesloop.models.linear_model import Recruitment

CURVES = Recruitment(threshold_ma=(12.0, 8.0), spread=(0.35, 0.2))


@settings(deadline=None)
@given(st.floats(0.0, 1.0 - 1e-12, exclude_min=True))
@example(5e-324)
@example(1e-320)
def test_quantile_equals_cephes(p):
    """The least numbers, whose exponent overflows, have the quantile of 1e-300."""
    assert normal_quantile(p) == pytest.approx(ndtri(max(p, 1e-300)), rel=1e-10, abs=1e-12)


@settings(deadline=None)
@given(st.lists(st.floats(1e-4, 0.9), min_size=2, max_size=2))
def test_the_plant_recruits_what_was_asked_within_reach(drive):
    allocation = Allocation(recruitment=CURVES, current_ma=(40.0, 30.0), width_max_us=500.0)
    pulses = allocation.stimulation(np.array(drive))
    asked = np.minimum(drive, allocation.reach())
    np.testing.assert_allclose(CURVES.fraction(pulses), asked, rtol=1e-9)


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 400e-6), min_size=2, max_size=2), st.floats(0.5, 6.0))
def test_the_drive_after_a_rise_of_charge_is_what_the_plant_recruits_by_it(widths, rise_uc):
    """A pulse of the same current that holds just as much more charge."""
    allocation = Allocation(recruitment=CURVES, current_ma=(40.0, 30.0))
    current, drive = np.array([40e-3, 30e-3]), np.empty(2)
    risen(allocation.table(), np.stack([current, widths], axis=1), 1e-6 * rise_uc, drive)
    longer = np.stack([current, (current * widths + 1e-6 * rise_uc) / current], axis=1)
    np.testing.assert_allclose(drive, CURVES.fraction(longer), rtol=1e-9)
    np.testing.assert_array_equal(Allocation(recruitment=None, current_ma=(20.0,)).risen(1e-9), [np.inf])


@settings(deadline=None)
@given(st.lists(st.lists(st.floats(0.0, 0.9), min_size=2, max_size=2), min_size=1, max_size=5))
def test_planned_charge_is_the_sum_over_pulses_of_either_sign(drives):
    for curves, sign in ((CURVES, 1.0), (None, -1.0)):
        allocation = Allocation(recruitment=curves, current_ma=(40.0, 30.0))
        pulses = np.array([allocation.stimulation(sign * np.array(drive)) for drive in drives])
        total = planned_charge(allocation.table(), sign * np.array(drives))
        assert total == pytest.approx(np.abs(pulses.prod(axis=2)).sum(), rel=1e-12)


def test_saturates_at_the_longest_pulse():
    allocation = Allocation(recruitment=CURVES, current_ma=(14.0, 30.0), width_max_us=300.0)
    pulses = allocation.stimulation(np.array([0.99, 0.0]))
    np.testing.assert_allclose(pulses, [[14e-3, 300e-6], [0.0, 0.0]])
    for drive, saturated in (([0.1, 0.0], 0), ([0.99, 0.0], 1), ([0.99, 1.0 - 1e-12], 2), ([1.0, 1.0], 2)):
        assert allocate(allocation.table(), np.array(drive), pulses) == saturated


def test_linear_width_is_signed_and_unlimited():
    allocation = Allocation(recruitment=None, current_ma=(20.0, 20.0), full_scale_us=400.0)
    np.testing.assert_allclose(allocation.stimulation(np.array([-0.5, 3.0]))[:, 1], [-200e-6, 1200e-6])


@pytest.mark.parametrize("current_ma", [(), (20.0,), (20.0, 0.0), (20.0, float("nan")), (20.0, 0.01)])
def test_refuses_currents_that_cannot_work(current_ma):
    with pytest.raises(InputError, match="current_ma"):
        Allocation(recruitment=CURVES, current_ma=current_ma)

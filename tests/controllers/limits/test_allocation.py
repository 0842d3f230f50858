import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtri

from controllers.limits.allocation import Allocation, normal_quantile
from fesloop.errors import InputError
from fesloop.models.recruitment import Recruitment

CURVES = Recruitment(threshold_ma=(12.0, 8.0), spread=(0.35, 0.2))


@settings(deadline=None)
@given(st.floats(1e-12, 1.0 - 1e-12))
def test_quantile_equals_cephes(p):
    assert normal_quantile(p) == pytest.approx(ndtri(p), rel=1e-10, abs=1e-12)


@settings(deadline=None)
@given(st.lists(st.floats(1e-4, 0.9), min_size=2, max_size=2))
def test_the_plant_recruits_what_was_asked_within_reach(drive):
    allocation = Allocation(recruitment=CURVES, current_ma=(40.0, 30.0), width_max_us=500.0)
    pulses = allocation.stimulation(np.array(drive))
    asked = np.minimum(drive, allocation.reach())
    np.testing.assert_allclose(CURVES.fraction(pulses), asked, rtol=1e-9)


def test_saturates_at_the_longest_pulse():
    allocation = Allocation(recruitment=CURVES, current_ma=(14.0, 30.0), width_max_us=300.0)
    pulses = allocation.stimulation(np.array([0.99, 0.0]))
    np.testing.assert_allclose(pulses, [[14e-3, 300e-6], [0.0, 0.0]])


def test_linear_width_is_signed_and_unlimited():
    allocation = Allocation(recruitment=None, current_ma=(20.0, 20.0), full_scale_us=400.0)
    np.testing.assert_allclose(allocation.stimulation(np.array([-0.5, 3.0]))[:, 1], [-200e-6, 1200e-6])


@pytest.mark.parametrize("current_ma", [(), (20.0,), (20.0, 0.0), (20.0, float("nan")), (20.0, 0.01)])
def test_refuses_currents_that_cannot_work(current_ma):
    with pytest.raises(InputError, match="current_ma"):
        Allocation(recruitment=CURVES, current_ma=current_ma)

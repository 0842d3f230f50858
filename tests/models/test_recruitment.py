"""Recruitment: against scipy's lognormal distribution, and back again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import lognorm

from fesloop.errors import InputError
from fesloop.models import linear_model as recruitment
from fesloop.models.linear_model import Recruitment

CURVES = Recruitment(threshold_ma=(12.0, 8.0), spread=(0.35, 0.2), chronaxie_us=180.0)
current = st.floats(1e-4, 0.126)
width = st.floats(2e-5, 5e-4)


@given(current_a=current, width_s=width)
def test_the_fraction_is_the_lognormal_distribution_of_thresholds(current_a: float, width_s: float) -> None:
    found = CURVES.fraction(np.array([[current_a, width_s]] * 2))
    effective_ma = 1e3 * current_a / (1 + 180e-6 / width_s)
    expected = [lognorm.cdf(effective_ma, 0.35, scale=12.0), lognorm.cdf(effective_ma, 0.2, scale=8.0)]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-300)


@given(current_a=st.floats(0.02, 0.126), width_s=width)
def test_the_pulse_width_recruits_the_fraction_it_is_asked_for(current_a: float, width_s: float) -> None:
    asked = CURVES.fraction(np.array([[current_a, width_s]] * 2))
    asked = np.clip(asked, 1e-9, 1 - 1e-9)
    found = CURVES.pulse_width_s(asked, np.full(2, current_a))
    given_back = CURVES.fraction(np.column_stack([np.full(2, current_a), np.minimum(found, 1e9)]))
    reachable = np.isfinite(found)
    np.testing.assert_allclose(given_back[reachable], asked[reachable], rtol=1e-7)
    longest = CURVES.fraction(np.array([[current_a, 1e9]] * 2))
    assert (asked[~reachable] >= longest[~reachable] * (1 - 1e-9)).all()


def test_no_current_or_no_width_recruits_nothing() -> None:
    for pulse in ([0.0, 3e-4], [0.02, 0.0], [-0.02, 3e-4], [0.02, -3e-4]):
        assert not CURVES.fraction(np.array([pulse, pulse])).any()
    np.testing.assert_array_equal(CURVES.pulse_width_s(np.array([0.0, -1.0]), np.full(2, 0.02)), 0.0)
    assert np.isinf(CURVES.pulse_width_s(np.full(2, 0.5), np.array([0.012, 0.004]))).all()


def test_the_compiled_kernel_equals_plain_python() -> None:
    pulses = np.array([[0.02, 2e-4], [0.0, 1e-4]])
    plain = np.empty(2)
    recruitment.recruit.py_func(pulses, np.array([12.0, 8.0]), np.array([0.35, 0.2]), 180.0, plain)
    np.testing.assert_allclose(CURVES.fraction(pulses), plain, rtol=1e-14)


def test_bad_curves_and_pulses_are_named() -> None:
    with pytest.raises(InputError, match=r"recruitment\.spread"):
        Recruitment(threshold_ma=(1.0, 2.0), spread=(1.0,))
    with pytest.raises(InputError, match=r"recruitment\.threshold_ma"):
        Recruitment(threshold_ma=(0.0,), spread=(1.0,))
    with pytest.raises(InputError, match=r"recruitment\.chronaxie_us"):
        Recruitment(threshold_ma=(1.0,), spread=(1.0,), chronaxie_us=float("nan"))
    with pytest.raises(InputError, match="stimulation"):
        CURVES.fraction(np.zeros((3, 2)))

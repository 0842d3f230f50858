"""Units: factors to SI by definition, whatever the spelling, and what is no unit is refused."""

import math

import pytest

from fesloop.errors import InputError
from fesloop.streams.labels import SI, factor


@pytest.mark.parametrize(("quantity", "unit", "expected"), [
    ("gyr", "deg/s", math.tau / 360.0), ("gyr", "°/s", math.tau / 360.0), ("gyr", "RAD/S", 1.0),
    ("gyr", "mdps", math.tau / 360e3), ("acc", "g", 9.80665), ("acc", "mG", 9.80665e-3), ("acc", "m/s²", 1.0),
    ("mag", "G", 1e-4), ("mag", "mG", 1e-7), ("mag", "µT", 1e-6), ("mag", "μT", 1e-6), ("mag", " uT ", 1e-6),
    ("time", "ms", 1e-3), ("time", "ns", 1e-9), ("angle", "°", math.tau / 360.0), ("acc", "m s-2", 1.0)])
def test_factors_by_definition(quantity, unit, expected):
    assert factor(quantity, unit, "here") == pytest.approx(expected, rel=1e-15)


def test_units_of_si_change_no_bit():
    assert [factor(quantity, unit, "") for quantity, unit in SI.items()] == [1.0] * 5


@pytest.mark.parametrize(("unit", "words"), [("rpm", "'rpm' is no unit of gyr"), ("", "states no unit"),
                                             ("m/s^2", "is no unit of gyr")])
def test_what_is_no_unit_is_refused(unit, words):
    with pytest.raises(InputError, match=words) as caught:
        factor("gyr", unit, "lab.xdf: imu")
    assert "lab.xdf: imu" in str(caught.value)
    assert "deg/s" in str(caught.value)

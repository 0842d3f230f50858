"""Magnetometers whose unit is called another."""

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.streams.checks import plausible_mag


@pytest.mark.parametrize(("its", "taken", "factor"), [("uT", "gauss", 100.0), ("uT", "mT", 1000.0),
                                                      ("uT", "T", 1e6), ("nT", "uT", 1e3),
                                                      ("mgauss", "gauss", 1e3)])
@pytest.mark.parametrize("field_ut", [25.0, 48.0, 65.0])
def test_a_field_in_another_unit_is_refused_with_the_likely_one(its, taken, factor, field_ut):
    mag = np.tile([0.0, 0.6, -0.8], (50, 1)) * field_ut * 1e-6
    plausible_mag(mag, "mag")
    with pytest.raises(InputError, match=f"{its} read as {taken}"):
        plausible_mag(mag * factor, "mag")

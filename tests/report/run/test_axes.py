"""Axes of errors begin at 0 and hold all that is drawn."""

import numpy as np
import pytest

from fesloop.show.report.parts import Line
from fesloop.show.report.run.thinning import from_zero

NONE = np.full(3, np.nan)


def line(y, high=None):
    return Line(name="", role="plain", x=np.arange(float(len(y))), y=np.array(y), low=None, high=high)


@pytest.mark.parametrize(("lines", "high"), [
    ([line([1.0, 2.0, 3.0])], 3.15), ([line([1.0, np.nan, 3.0]), line([4.0, 2.0, np.inf])], 4.2),
    ([line([1.0, 2.0, 3.0], np.array([2.0, 9.0, np.nan])), line([8.0])], 9.45),
    ([line(NONE)], 1.0), ([], 1.0), ([line([0.0, 0.0])], 1.0)])
def test_they_begin_at_0_and_end_above_all_that_is_known(lines, high):
    assert from_zero(lines) == (0.0, pytest.approx(high))

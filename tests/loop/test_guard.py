"""What a block puts out that is not what its ports declare is told by names, as a newcomer gets it wrong."""

import numpy as np
import pytest

from fesloop.errors import RunError
from fesloop.loop.signals import Port, check_shapes

ANGLES, PHASE = Port("angles", (3,), "rad"), Port("phase")


@pytest.mark.parametrize(("values", "told"), [
    (None, "filter: put out NoneType, declared is a tuple of 2"),
    (np.zeros(2), "filter: put out ndarray, declared is a tuple of 2"),
    ((np.zeros(3),), "filter: put out 1 values for its 2 output ports"),
    ((np.zeros(2), 0.0), r"filter\.angles: put out float64 \(2,\), declared is float64 \(3,\)"),
    ((np.zeros(3, int), 0.0), r"filter\.angles: put out int64 \(3,\), declared"),
    (([0.0, 0.0, 0.0], 0.0), r"filter\.angles: put out list, declared"),
    ((np.zeros(3), 0), r"filter\.phase: put out int, declared is a float"),
])
def test_what_is_not_as_declared_is_told(values, told):
    with pytest.raises(RunError, match=told):
        check_shapes("filter", (ANGLES, PHASE), values)


def test_what_is_as_declared_passes():
    check_shapes("filter", (ANGLES, PHASE), (np.zeros(3), np.float64(1.0)))

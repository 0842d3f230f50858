import numpy as np
import pytest

from controllers.ilc.parameters import Point, point_mask
from fesloop.errors import InputError


def test_points_fall_on_the_nearest_tick_and_name_their_outputs():
    mask = point_mask((Point(at_s=0.049), Point(at_s=0.1, outputs=(1,))), 6, 3, 20_000_000)
    wanted = np.zeros((6, 3), dtype=bool)
    wanted[2], wanted[5, 1] = True, True
    np.testing.assert_array_equal(mask, wanted)
    assert point_mask((), 6, 3, 20_000_000).all()


@pytest.mark.parametrize(("point", "key"), [
    (Point(at_s=0.2), r"points\[0\].at_s"), (Point(at_s=0.0, outputs=(3,)), r"points\[0\].outputs")])
def test_names_the_point_that_cannot_be(point, key):
    with pytest.raises(InputError, match=key):
        point_mask((point,), 6, 3, 20_000_000)


@pytest.mark.parametrize("at_s", [-1.0, float("nan")])
def test_names_an_instant_that_is_none(at_s):
    with pytest.raises(InputError, match=r"points\.at_s"):
        Point(at_s=at_s)

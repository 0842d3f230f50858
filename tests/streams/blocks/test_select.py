"""Select: elements of a vector, and what is no vector or not in it."""

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.loop.block import Tick
from fesloop.loop.signals import Sample
from fesloop.streams.blocks.select import Select


def test_elements_come_in_the_order_of_the_indices():
    select = Select(indices=(2, 0, 2)).resolve({"vector": (3,)})
    elements, = select.step(None, (Sample(np.array([5.0, 6.0, 7.0]), 0, 0, 0),), Tick())
    np.testing.assert_array_equal(elements, [7.0, 5.0, 7.0])
    assert select.inputs[0].shape == select.outputs[0].shape == (3,)


@pytest.mark.parametrize(("shape", "found"), [((2,), "indices: 2; allowed: 0 to 1"), ((), r"shape \(\)"),
                                              ((4, 3), r"shape \(4, 3\)")])
def test_what_does_not_fit_the_wire_is_refused(shape, found):
    with pytest.raises(InputError, match=found):
        Select(indices=(2, 0)).resolve({"vector": shape})


@pytest.mark.parametrize("parameters", [{"indices": ()}, {"indices": (-1,)}, {"indices": (3,), "size": 3},
                                        {"indices": (0,), "size": -1}])
def test_indices_that_cannot_be_are_refused(parameters):
    with pytest.raises(InputError):
        Select(**parameters)

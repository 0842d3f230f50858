"""What breaks a ring in which nothing takes time, as docs/howto/own_experiment.md has it."""

import pytest
from loop_parts import Pass

from fesloop.errors import InputError
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.linear import StateSpace


def ring(d=((1.0,),), rate="100", offset_ms=0.0, latency_ms=0.0, execution=0.0):
    plant = StateSpace(a=((-1.0,),), b=((1.0,),), c=((1.0,),), d=d)
    block = Node("block", Pass(), rate, offset_ms, Duration(kind="fixed", ms=execution))
    return Wiring([Node("plant", plant), block], [Wire("plant.y", "block.u", latency_ms=latency_ms),
                                                  Wire("block.y", "plant.u")])


@pytest.mark.parametrize("without", [{}, {"rate": "10"}, {"offset_ms": 3.0}])
def test_neither_rate_nor_offset_breaks_a_ring(without):
    with pytest.raises(InputError, match="algebraic loop"):
        ring(**without)


@pytest.mark.parametrize("broken", [{"latency_ms": 1.0}, {"execution": 1.0}, {"d": ()}])
def test_latency_execution_or_a_plant_that_follows_later_do(broken):
    assert ring(**broken).order

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.reach import reach_of
from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger

MODEL = Finger().linear_model()
MOST = np.array([0.4, 0.3, 0.2, 0.5])


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_no_constant_drive_holds_an_angle_outside(shares):
    sampled, reach = MODEL.sampled(25_000_000), reach_of(MODEL, MOST)
    states = np.zeros(sampled.a.shape[0])
    for _ in range(2000):
        states = sampled.a @ states + sampled.b @ (np.array(shares) * MOST)
    held = sampled.c @ states + sampled.offset
    assert (reach.least - 1e-9 <= held).all()
    assert (held <= reach.greatest + 1e-9).all()


def test_the_ends_are_held_by_all_muscles_that_pull_that_way():
    reach = reach_of(MODEL, MOST)
    effects = np.linalg.solve(MODEL.a, -MODEL.b)
    for output in range(3):
        pulls = MODEL.c[output] @ effects
        ends = [MODEL.offset[output] + pulls @ (MOST * (sign * pulls > 0)) for sign in (-1, 1)]
        np.testing.assert_allclose([reach.least[output], reach.greatest[output]], ends)


def test_a_reference_beyond_is_reported_when_it_gets_there():
    reach, latch, tick = reach_of(MODEL, MOST), StatusLatch(), Tick()
    inside, outside = 0.5 * (reach.least + reach.greatest), reach.greatest + np.radians([0.0, 4.0, 6.0])
    for tick.index, reference in enumerate([inside] * 10 + [outside] * 30 + [inside] * 10 + [outside] * 10):
        reach.look(latch, tick, reference)
    assert [status for status, _ in tick.reports] == ["out_of_reach"] * 2
    assert "output 2" in tick.reports[0][1]


def test_an_unstable_model_has_no_ends():
    reach = reach_of(LinearModel(a=[[1.0]], b=[[1.0]], c=[[1.0]], offset=[0.0]), np.ones(1))
    assert (reach.least[0], reach.greatest[0]) == (-np.inf, np.inf)
    tick = Tick()
    reach.look(StatusLatch(), tick, np.array([1e6]))
    assert tick.reports == []

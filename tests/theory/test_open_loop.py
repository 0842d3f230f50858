"""The open-loop transfer of a loop against sampled plants, and against the loop when it is closed."""

import control
import numpy as np
import pytest
from linear_parts import PERIOD_S, scalar_loop, sensed_loop, uniform

from fesloop import load
from fesloop.analysis.theory import critical_latency_ms, linear_loop, open_loop
from fesloop.analysis.theory.period_map import period_map
from fesloop.errors import InputError

Z = np.exp(1j * np.logspace(-1, 2, 9) * PERIOD_S)


@pytest.mark.parametrize(("latency_ms", "periods"), [(0, 0), (20, 1), (30, 2), (100, 5)])
def test_a_latency_is_so_many_periods(latency_ms, periods):
    sampled = control.c2d(control.ss([[-1.0]], [[3.0]], [[1.0]], 0), PERIOD_S, "zoh")
    found = open_loop(scalar_loop(-1.0, 3.0, sensed={"latency_ms": latency_ms}))
    assert found.dt == PERIOD_S
    np.testing.assert_allclose(found(Z), sampled(Z) * Z**-periods, rtol=1e-9)


@pytest.mark.parametrize("wire", ["plant.y->sensor.y", "feedback.u->plant.u"])
def test_closed_again_it_has_the_poles_of_the_loop(wire):
    loop = linear_loop(sensed_loop(-1.0, 3.0, 0.0, {"latency_ms": 15}, sensor_rate=50))
    closed = control.feedback(open_loop(loop, wire), 1)
    own = np.linalg.eigvals(period_map(loop, read=False).matrix)
    for pole in closed.poles():
        assert abs(pole) < 1e-6 or abs(own - pole).min() < 1e-6


def test_the_latency_at_which_its_phase_margin_is_used_up_is_the_critical_one():
    experiment, wire = scalar_loop(0.0, 5.0), "plant.y->feedback.y"
    critical_ns = round(1e6 * critical_latency_ms(experiment, wire))
    for share, stable in ((0.9, True), (1.1, False)):
        late = linear_loop(experiment).with_latency(wire, round(share * critical_ns))
        closed = control.feedback(open_loop(late, wire), 1)
        assert (np.abs(closed.poles()).max() < 1.0) == stable


def test_the_shipped_loop_is_cut_where_its_slowest_block_reads():
    found = open_loop(load("linear_loop"))
    assert found.dt == pytest.approx(0.02)
    closed = control.feedback(found, np.eye(found.ninputs))
    assert np.abs(closed.poles()).max() < 1.0


def test_what_has_no_transfer_is_refused():
    with pytest.raises(InputError, match="jitter or loss"):
        open_loop(scalar_loop(-1.0, 3.0, sensed={"jitter": uniform(0, 5)}))
    with pytest.raises(InputError, match="delivers more than once"):
        open_loop(sensed_loop(-1.0, 3.0, 0.0, {}), "plant.y->sensor.y")
    with pytest.raises(InputError, match="not on the loop"):
        open_loop(scalar_loop(-1.0, 3.0), "plant.y->feedback.u")

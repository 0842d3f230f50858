"""Critical latencies against those of an integrator under sampled feedback, known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from linear_parts import PERIOD_S, oscillator_loop, scalar_loop, sensed_loop
from scipy.linalg import expm

from fesloop.analysis.theory import critical_latency_ms, linear_loop
from fesloop.analysis.theory.critical_latency import growth as growth_of_moments
from fesloop.apps.reproduce.linear_theory import SENSED, STIMULATED, Crossing, growth
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from plants.linear import StateSpace

OUT, BACK = "plant.y->feedback.y", "feedback.u->plant.u"


@pytest.mark.slow
@given(share=st.floats(0.51, 0.99))
@settings(max_examples=25, deadline=None)
def test_an_integrator_held_late_within_a_period_is_critical_at_one_over_its_gain(share):
    # z^2 - (1 - k (h - tau)) z + k tau has roots of modulus 1 where k tau = 1 (Astrom and Wittenmark 1997,
    # section 2.3, for the sampled system), for 1/h < k < 2/h.
    gain = 1.0 / (share * PERIOD_S)
    assert critical_latency_ms(scalar_loop(0.0, gain), BACK) == pytest.approx(1e3 / gain, abs=1.1e-6)


@pytest.mark.slow
@given(loop_gain=st.floats(0.05, 0.99))
@settings(max_examples=25, deadline=None)
def test_on_the_way_to_a_block_latency_acts_in_whole_ticks(loop_gain):
    # z^(m+1) - z^m + k h has roots of modulus 1 where k h = 2 sin(pi / (2 (2 m + 1))), m periods late.
    late = next(m for m in range(100) if 2.0 * math.sin(math.pi / (2.0 * (2 * m + 1))) <= loop_gain)
    found = critical_latency_ms(scalar_loop(0.0, loop_gain / PERIOD_S), OUT)
    assert found == pytest.approx(1e3 * PERIOD_S * (late - 1) + 1e-6, abs=1e-9)


def test_execution_time_and_fixed_jitter_count_as_latency():
    gain = 1.0 / (0.8 * PERIOD_S)
    slow = scalar_loop(0.0, gain, execution=Duration(kind="fixed", ms=4.5),
                       stimulated={"jitter": Duration(kind="fixed", ms=1.25)})
    assert critical_latency_ms(slow, BACK) == pytest.approx(16.0 - 4.5 - 1.25, abs=1.1e-6)


def test_latencies_that_jitter_would_take_below_zero_are_not_tried():
    gain = 1.0 / (0.8 * PERIOD_S)
    early = scalar_loop(0.0, gain, stimulated={"latency_ms": 5.0, "jitter": Duration(kind="fixed", ms=-1.25)})
    assert critical_latency_ms(early, BACK) == pytest.approx(16.0 + 1.25, abs=1.1e-6)


def test_a_loop_that_no_latency_upsets_has_none():
    # x' = -x - 0.5 x(t - tau): the delayed part is the weaker one.
    assert critical_latency_ms(scalar_loop(-1.0, 0.5), BACK) is None


def test_a_loop_that_is_unstable_anyway_has_no_room():
    assert critical_latency_ms(scalar_loop(0.0, 2.5 / PERIOD_S), BACK) == 0.0


@settings(max_examples=20, deadline=None)
@given(hidden=st.floats(0.0, 2.0), reached=st.booleans(), gain=st.floats(1.0, 20.0))
def test_a_mode_outside_the_loop_that_does_not_decay_is_told_apart(hidden, reached, gain):
    b, c = ((1.0,), (1.0 if reached else 0.0,)), ((1.0, 0.0 if reached else 1.0),)
    plant = StateSpace(a=((-1.0, 0.0), (0.0, hidden)), b=b, c=c, output_unit="rad")
    loop = scalar_loop(0.0, gain)
    loop = replace(loop, nodes=[Node("plant", plant), *(n for n in loop.nodes if n.name != "plant")])
    with pytest.raises(InputError, match="a mode that it does not reach"):
        critical_latency_ms(loop, BACK)


def test_losses_leave_less_room():
    gain = 0.4 / PERIOD_S
    sure = critical_latency_ms(scalar_loop(0.0, gain), BACK)
    lossy = critical_latency_ms(scalar_loop(0.0, gain, stimulated={"loss": 0.3}), BACK)
    assert 0.0 < lossy < sure


def test_a_wire_that_is_not_on_the_loop_is_named():
    with pytest.raises(InputError, match="not on the loop"):
        critical_latency_ms(scalar_loop(0.0, 1.0), "a.b->c.d")
    with pytest.raises(InputError, match="up_to_ms"):
        critical_latency_ms(scalar_loop(0.0, 1.0), BACK, up_to_ms=0.0)


def test_the_latency_of_the_experiment_itself_does_not_matter_to_the_wires_critical_one():
    near, far = (linear_loop(load("linear_loop", (f"actuation_ms={ms}",))) for ms in (0, 50))
    assert critical_latency_ms(near, STIMULATED) == critical_latency_ms(far, STIMULATED)


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "wire"), [
    (0.8, STIMULATED), (1.0, SENSED), (1.4, STIMULATED), (1.7, SENSED)])
def test_the_running_loop_decays_just_below_and_grows_just_above(gain, wire):
    """Within 0.1 ms; `fesloop reproduce linear_theory` finds the crossing by bisection at 20 gains."""
    crossing = Crossing(gain, wire)
    theory = critical_latency_ms(crossing.at(1.0), wire)
    assert growth(crossing.at(theory - 0.1)) < 0.0 < growth(crossing.at(theory + 0.1))


def oscillators_radius(omega, damping, gain, period_s, latency_s):
    """Spectral radius of x'' = -omega^2 x - damping x' + gain x(sampled, late), written out once more."""
    def held(time_s):
        step = expm(np.array([[0.0, 1.0, 0.0], [-omega**2, -damping, gain], [0.0, 0.0, 0.0]]) * time_s)
        return step[:2, :2], step[:2, 2]
    whole = int(latency_s / period_s)
    late = latency_s - whole * period_s
    newer, older = held(period_s - late), held(late)[1]
    step = np.zeros((3 + whole, 3 + whole))  # x, x', and x as sampled 1, ..., whole + 1 periods ago
    step[:2, :2] = held(period_s)[0]
    step[:2, 2 + whole] = newer[0] @ older
    step[:2, 1 + whole if whole else 0] += newer[1]
    step[2, 0] = 1.0
    step[range(3, 3 + whole), range(2, 2 + whole)] = 1.0
    return np.abs(np.linalg.eigvals(step)).max()


@given(omega=st.floats(60.0, 400.0), relative_gain=st.floats(0.05, 0.3), share=st.floats(0.7, 1.1),
       rate=st.sampled_from([50, 100, 200]))
@example(omega=300.0, relative_gain=0.1, share=0.9, rate=200)
@example(omega=100.0, relative_gain=0.02, share=0.94, rate=100)
@settings(max_examples=6, deadline=None)
def test_instability_that_ends_again_is_found_as_a_dense_scan_finds_it(omega, relative_gain, share, rate):
    """Damping is that share of what late feedback takes away at its worst, so windows come and go."""
    gain, most_s = relative_gain * omega**2, 0.08
    damping = share * gain / omega
    found = critical_latency_ms(oscillator_loop(omega, damping, gain, rate), BACK, 1e3 * most_s)

    def radius(latency_s):
        return oscillators_radius(omega, damping, gain, 1.0 / rate, latency_s)

    before_s = most_s if found is None else max(found / 1e3 - 2e-9, 0.0)
    if found != 0.0:
        assert max(radius(latency_s) for latency_s in np.linspace(0.0, before_s, 600)) < 1.0 + 1e-8
    if found is not None:
        assert radius(found / 1e3) >= 1.0 - 1e-8


@pytest.mark.parametrize("gain", [
    *(pytest.param(gain, marks=pytest.mark.slow) for gain in (12.0, 15.0, 18.0)), 21.0])
def test_latency_between_two_rates_is_searched_step_by_step(gain):
    """The steps lie a common divisor of the periods apart, 5/3 ms at 120 and 50 Hz."""
    loop, wire = linear_loop(sensed_loop(-1.0, gain, 1.0, {}, 120)), "sensor.y->feedback.y"
    found = critical_latency_ms(loop, wire, 200.0)
    first = next(ns for ns in range(0, 200_000_000, 400_000)
                 if growth_of_moments(loop.with_latency(wire, ns)) >= 1.0)
    assert found <= first / 1e6 <= found + 0.4

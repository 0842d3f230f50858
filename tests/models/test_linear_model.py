"""Sampled models: against python-control and an adaptive integrator of the delayed system."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fesloop.errors import InputError
from fesloop.models.linear_model import LinearModel, Recruitment

A = np.array([[0.0, 1.0, 0.0], [-200.0, -9.0, 30.0], [0.0, 0.0, -25.0]])
B = np.array([[0.0, 0.0], [0.0, 3.0], [25.0, 0.0]])
C = np.array([[1.0, 0.0, 0.0], [0.0, 0.2, 1.0]])
MS = 1_000_000


def model(delay_ns: int = 0) -> LinearModel:
    return LinearModel(a=A, b=B, c=C, offset=np.array([0.3, -1.0]), delay_ns=delay_ns)


def delayed_outputs(held: np.ndarray, period_ns: int, delay_ns: int) -> np.ndarray:
    """y at the samples, by integrating from one change of the delayed input to the next."""
    samples = held.shape[0]
    changes = {k * period_ns + delay_ns: held[k] for k in range(samples)}
    instants = sorted({*changes, *(k * period_ns for k in range(samples))})
    x, v, seen = np.zeros(3), np.zeros(2), []
    for now, after in zip(instants, [*instants[1:], instants[-1] + 1], strict=True):
        if now % period_ns == 0 and now // period_ns < samples:
            seen.append(C @ x + [0.3, -1.0])
        v = changes.get(now, v)
        x = solve_ivp(lambda _, x, v=v: A @ x + B @ v, (0.0, (after - now) * 1e-9), x, "DOP853",
                      rtol=1e-11, atol=1e-13).y[:, -1]
    return np.array(seen)


def sampled_outputs(delay_ns: int, extra_ns: int, period_ns: int, held: np.ndarray) -> np.ndarray:
    sampled = model(delay_ns).sampled(period_ns, extra_ns)
    x, seen = np.zeros(sampled.a.shape[0]), []
    for v in held:
        seen.append(sampled.c @ x + sampled.offset)
        x = sampled.a @ x + sampled.b @ v
    return np.array(seen)


@given(delay_ns=st.one_of(st.sampled_from([0, 20 * MS, 40 * MS]), st.integers(0, 70 * MS)),
       extra_ns=st.sampled_from([0, 1, 20 * MS, 13_333_333]))
@settings(max_examples=25, deadline=None)
def test_a_sampled_model_is_exact_for_any_delay(delay_ns: int, extra_ns: int) -> None:
    held = np.random.default_rng(1).normal(size=(9, 2))
    expected = delayed_outputs(held, 20 * MS, delay_ns + extra_ns)
    np.testing.assert_allclose(sampled_outputs(delay_ns, extra_ns, 20 * MS, held), expected, atol=1e-9)


def test_without_delay_it_is_the_zero_order_hold_of_control() -> None:
    sampled = model().sampled(50 * MS)
    expected = control.sample_system(control.ss(A, B, C, np.zeros((2, 2))), 0.05)
    np.testing.assert_allclose(sampled.a, expected.A, atol=1e-13)
    np.testing.assert_allclose(sampled.b, expected.B, atol=1e-13)


@pytest.mark.parametrize("delay_ns", [0, 20 * MS, 27 * MS])
def test_the_lifted_matrix_maps_an_input_history_to_the_outputs(delay_ns: int) -> None:
    held = np.random.default_rng(2).normal(size=(12, 2))
    lifted = model(delay_ns).sampled(20 * MS).lifted(12)
    expected = sampled_outputs(delay_ns, 0, 20 * MS, held) - [0.3, -1.0]
    np.testing.assert_allclose((lifted @ held.ravel()).reshape(12, 2), expected, atol=1e-12)


def test_an_input_first_shows_after_the_delay_steps() -> None:
    for delay_ns in (0, 5 * MS, 20 * MS, 65 * MS):
        sampled = model(delay_ns).sampled(20 * MS)
        held = np.zeros((8, 2))
        held[0, 1] = 1.0
        seen = np.flatnonzero(np.abs(sampled_outputs(delay_ns, 0, 20 * MS, held)[:, 1] + 1.0) > 1e-12)
        assert seen[0] == sampled.delay_steps + 1


def test_a_period_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="period_ns"):
        model().sampled(0)


@pytest.mark.parametrize(("changed", "told"), [
    ({"a": np.eye(2)}, r"b: shape \(3, 2\); allowed: shape \(2, 2\)"),
    ({"a": A[:, :2]}, r"a: shape \(3, 2\)"), ({"b": B[0]}, "b: shape"),
    ({"b": np.zeros((3, 0))}, "b: shape"), ({"c": C[:, :2]}, r"c: shape \(2, 2\)"),
    ({"offset": np.zeros(3)}, r"offset: shape \(3,\); allowed: shape \(2,\)"),
    ({"a": np.full((3, 3), np.nan)}, "a: numbers that are not finite"),
    ({"a": ((1.0, 2.0), (3.0,))}, "a: rows of unequal length"), ({"delay_ns": -1}, "delay_ns: -1"),
    ({"recruitment": Recruitment(threshold_ma=(1.0,), spread=(0.3,))}, "recruitment: 1 muscles; allowed: 2")])
def test_matrices_that_do_not_fit_each_other_are_refused(changed, told) -> None:
    with pytest.raises(InputError, match=told):
        LinearModel(**{"a": A, "b": B, "c": C, "offset": np.zeros(2)} | changed)

"""Exact linear systems: against matrix exponentials and an adaptive integrator."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from plants.linear.system import HeldLinearSystem


def stable_system(seed: int, states: int = 5, inputs: int = 2, outputs: int = 3) -> HeldLinearSystem:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(states, states)) * 20.0
    a -= np.eye(states) * (np.linalg.eigvals(a).real.max() + 1.0)
    return HeldLinearSystem(a, rng.normal(size=(states, inputs)), rng.normal(size=(outputs, states)),
                            rng.normal(size=(outputs, inputs)), rng.normal(size=outputs))


def by_exponential(system: HeldLinearSystem, z: np.ndarray, duration_ns: int) -> np.ndarray:
    states, inputs = system.b.shape
    stacked = np.zeros((states + inputs, states + inputs))
    stacked[:states] = np.hstack([system.a, system.b])
    return expm(stacked * (duration_ns * 1e-9)) @ z


@pytest.mark.slow
@given(seed=st.integers(0, 2**31), duration_ns=st.integers(1, 2_000_000_000))
@settings(max_examples=50, deadline=None)
def test_any_duration_is_one_matrix_exponential(seed: int, duration_ns: int) -> None:
    system = stable_system(seed)
    z = np.random.default_rng(seed + 1).normal(size=7)
    expected = by_exponential(system, z, duration_ns)
    system.advance(z, duration_ns)
    np.testing.assert_allclose(z, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@given(seed=st.integers(0, 2**31), parts_ns=st.lists(st.integers(0, 50_000_000), min_size=1, max_size=8))
@settings(max_examples=50, deadline=None)
def test_splitting_an_advance_changes_nothing(seed: int, parts_ns: list[int]) -> None:
    system = stable_system(seed)
    whole = np.random.default_rng(seed + 1).normal(size=7)
    split = whole.copy()
    system.advance(whole, sum(parts_ns))
    for part in parts_ns:
        system.advance(split, part)
    np.testing.assert_allclose(split, whole, rtol=1e-12, atol=1e-12)


def test_a_step_response_agrees_with_an_adaptive_integrator() -> None:
    system = stable_system(3)
    z = np.array([0.3, -1.0, 0.5, 2.0, 0.1, 1.5, -0.7])
    u = z[5:].copy()
    solution = solve_ivp(lambda _, x: system.a @ x + system.b @ u, (0.0, 0.234567891), z[:5],
                         method="DOP853", rtol=1e-12, atol=1e-13)
    system.advance(z, 234_567_891)
    np.testing.assert_allclose(z[:5], solution.y[:, -1], rtol=1e-9, atol=1e-10)
    np.testing.assert_array_equal(z[5:], u)


def test_outputs_ahead_are_the_outputs_once_there_bit_for_bit() -> None:
    system = stable_system(4)
    z = np.random.default_rng(0).normal(size=7)
    before = z.copy()
    times = np.array([1_000, 1_000, 5_123_456, 77_000_001], dtype=np.int64)
    rows = np.empty((4, 3))
    system.read_ahead(z, 1_000, times, rows)
    np.testing.assert_array_equal(z, before)
    for row, time_ns in zip(rows, times, strict=True):
        there = before.copy()
        system.advance(there, int(time_ns) - 1_000)
        np.testing.assert_array_equal(row, system.read(there))
        np.testing.assert_allclose(
            row, system.c @ there[:5] + system.d @ there[5:] + system.offset, rtol=1e-12, atol=1e-12)
        assert system.read_first(there) == row[0]


def test_bits_depend_neither_on_what_was_asked_before_nor_on_where_memory_lies() -> None:
    fresh, used = stable_system(5), stable_system(5)
    for duration in (7, 2_000_000_000, 13_000_001):
        used.advance(np.ones(7), duration)
    room = np.zeros(16)
    for shift in range(8):
        z, moved = np.arange(7.0), room[shift:shift + 7]
        moved[:] = z
        fresh.advance(z, 9_876_543)
        used.advance(moved, 9_876_543)
        np.testing.assert_array_equal(z, moved)


def test_pickling_keeps_the_bits() -> None:
    system = stable_system(6)
    again = pickle.loads(pickle.dumps(system))
    z, copy = np.ones(7), np.ones(7)
    system.advance(z, 123_456_789)
    again.advance(copy, 123_456_789)
    np.testing.assert_array_equal(z, copy)


def test_a_zero_duration_leaves_the_state() -> None:
    system = stable_system(7)
    z = np.arange(7.0)
    system.advance(z, 0)
    np.testing.assert_array_equal(z, np.arange(7.0))
    rows = np.empty((1, 3))
    system.read_ahead(z, 5, np.array([5], dtype=np.int64), rows)
    np.testing.assert_array_equal(rows[0], system.read(z))


def test_compiled_kernels_equal_plain_python() -> None:
    from plants.linear import system as linear

    system = stable_system(8)
    z, plain = np.ones(7), np.ones(7)
    system.advance(z, 10_000_019)
    linear.advance_digits.py_func(system._table, plain, 10_000_019, np.empty(5))
    np.testing.assert_allclose(z, plain, rtol=1e-14)

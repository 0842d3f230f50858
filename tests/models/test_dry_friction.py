"""Tests of the play operator: its defining properties."""

import hypothesis.extra.numpy as arrays
import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from fesloop.models.dry_friction import play

FORCES = arrays.arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)),
                       elements=st.floats(-10.0, 10.0, width=32))


def case(force, friction):
    width = np.full(force.shape[1], friction)
    return width, play(force, width, force[0])


@settings(deadline=None)
@given(force=FORCES, friction=st.floats(0.0, 3.0))
def test_stays_within_friction_and_moves_only_at_its_edge(force, friction):
    width, passed = case(force, friction)
    assert (np.abs(force - passed) <= width + 1e-12).all()
    before = np.vstack([force[:1], passed[:-1]])
    up, down = passed > before, passed < before
    np.testing.assert_allclose(passed[up], (force - width)[up], atol=1e-12)
    np.testing.assert_allclose(passed[down], (force + width)[down], atol=1e-12)


@settings(deadline=None)
@given(force=FORCES, friction=st.floats(0.0, 3.0), share=st.floats(0.0, 1.0))
def test_depends_on_extrema_alone(force, friction, share):
    """A row between two others on the way changes nothing: no rate, no time."""
    width, passed = case(force, friction)
    middle = force[:-1] + share * np.diff(force, axis=0)
    finer = np.empty((2 * len(force) - 1, force.shape[1]))
    finer[::2], finer[1::2] = force, middle
    np.testing.assert_allclose(play(finer, width, force[0])[::2], passed, atol=1e-12)


@settings(deadline=None)
@given(force=FORCES)
def test_without_friction_all_passes(force):
    assert np.array_equal(play(force, np.zeros(force.shape[1]), force[0]), force)

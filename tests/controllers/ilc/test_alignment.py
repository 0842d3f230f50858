import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.trajectories import posture_at

MS = 1_000_000
TICKS = np.arange(20) * 25 * MS


@settings(deadline=None)
@given(st.lists(st.integers(0, 24 * MS), min_size=20, max_size=20), st.integers(0, 2**32))
def test_a_cubic_motion_is_restored_whatever_the_ages(ages, seed):
    factors = np.random.default_rng(seed).standard_normal((4, 2))

    def motion(time_ns):
        return np.vander(np.asarray(time_ns) / 5e8, 4) @ factors

    captured = np.maximum(TICKS - np.array(ages), 0)
    posture, covered = posture_at(TICKS, captured, motion(captured), 100 * MS)
    assert covered[:-1].all()
    np.testing.assert_allclose(posture[covered], motion(TICKS[covered]), atol=1e-9)


def test_what_lies_outside_the_captures_or_in_a_gap_is_not_covered():
    captured = TICKS - 30 * MS
    captured[8:14] = captured[7]
    posture, covered = posture_at(TICKS, captured, np.ones((20, 1)), 100 * MS)
    # Captures span 20 ... 445 ms, with a hole from 145 to 320 ms.
    expected = ((TICKS >= 20 * MS) & (TICKS <= 145 * MS)) | ((TICKS >= 320 * MS) & (TICKS <= 445 * MS))
    np.testing.assert_array_equal(covered, expected)
    np.testing.assert_allclose(posture[:, 0], expected)


@pytest.mark.parametrize("captures", [0, 1, 2, 3])
def test_few_captures_are_enough(captures):
    captured = np.full(20, -1)
    captured[:captures] = TICKS[:captures]
    posture, covered = posture_at(TICKS, captured, 2.0 * TICKS[:, None] / MS, 100 * MS)
    np.testing.assert_array_equal(covered, np.arange(20) < captures)
    np.testing.assert_allclose(posture[:captures, 0], 2.0 * TICKS[:captures] / MS)


def test_ticks_that_were_skipped_are_not_covered():
    ticks = TICKS.copy()
    ticks[5] = -1
    _, covered = posture_at(ticks, TICKS, np.zeros((20, 1)), 100 * MS)
    np.testing.assert_array_equal(covered, np.arange(20) != 5)

"""How good a movement is, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand.movements import FREEDOMS, MOVEMENTS, Movement, movement_of


def moved(**degrees):
    """A movement of some freedoms, (23,), rad."""
    movement = np.zeros(len(FREEDOMS))
    for name, angle in degrees.items():
        movement[FREEDOMS.index(name)] = np.radians(angle)
    return movement


@pytest.mark.parametrize("name", MOVEMENTS)
def test_the_whole_movement_alone_is_one_rest_is_zero_and_the_opposite_minus_one(name):
    movement = movement_of(name)
    whole = moved(**movement.wanted_deg)
    assert movement.judge(whole).quality == pytest.approx(1.0)
    assert movement.judge(whole).selectivity == pytest.approx(1.0)
    assert movement.judge(np.zeros(len(FREEDOMS))) == (0.0, 0.0, 0.0)
    assert movement.judge(-whole).quality == pytest.approx(-1.0)
    assert movement.judge(-whole).selectivity == 0.0


def test_quality_by_hand():
    """Half of the extension; of six parts the wrist is off by 15 of 30 deg, the thumb by more than 40."""
    verdict = movement_of("wrist_extension").judge(
        moved(wrist_flexion=-20.0, wrist_abduction=15.0, F1_ip_flexion=90.0, F1_mcp_flexion=10.0))
    unwanted = np.sqrt((0.5**2 + 1.0**2) / 6.0)
    assert verdict == pytest.approx((0.5 - 0.5 * unwanted, 0.5, unwanted))
    assert verdict.selectivity == pytest.approx(0.5 / (0.5 + unwanted))


def test_a_hand_that_drops_is_no_opened_one():
    """Flexing the wrist opens the fingers passively."""
    dropped = moved(wrist_flexion=60.0, **{f"F{i}_mcp_flexion": -15.0 for i in range(2, 6)})
    opened = moved(wrist_flexion=-15.0, **{f"F{i}_mcp_flexion": -15.0 for i in range(2, 6)})
    judge = movement_of("finger_opening").judge
    assert judge(dropped).quality < 0.25 < judge(opened).quality


@given(st.lists(st.floats(-3.0, 3.0), min_size=23, max_size=23), st.sampled_from(sorted(MOVEMENTS)))
def test_quality_stays_within_its_bounds_and_what_is_left_alone_does_not_count(angles, name):
    movement, drawn = movement_of(name), np.array(angles)
    verdict = movement.judge(drawn)
    assert -1.5 <= verdict.quality <= 1.0
    assert 0.0 <= verdict.unwanted <= 1.0
    assert 0.0 <= verdict.selectivity <= 1.0
    other = drawn.copy()
    other[[FREEDOMS.index(freedom) for freedom in movement.left_alone]] = 0.0
    assert movement.judge(other) == verdict


def test_what_is_no_freedom_or_no_movement_is_refused():
    with pytest.raises(InputError, match="wrist_flexion"):
        Movement(wanted_deg={"wrist_flexon": 1.0})
    with pytest.raises(InputError, match="wanted_deg"):
        Movement(wanted_deg={})
    with pytest.raises(InputError, match="finger_opening"):
        movement_of("finger_open")

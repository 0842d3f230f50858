"""The constrained tracker on the whole hand for minutes; `tests/worn_hour.py` is the hour (25 s in all)."""

import math

import numpy as np
import pytest
from worn_hour import followed, rms
from worn_parts import EXACT, Worn, WornHand

from fesloop.hand import quaternion


def test_the_simulated_hand_feels_what_its_motion_says():
    """Rates against differences of the true postures; rests are rests."""
    hand = WornHand(3, EXACT)
    times = np.arange(4000, 4200) / 100
    step = 1e-4
    gyr, acc, _, _ = hand.chunk(4000, 200)
    before, after = (poses_of(hand, times + offset) for offset in (-step, step))
    turned = quaternion.relative(before, after)
    turned *= np.sign(turned[..., :1])
    np.testing.assert_allclose(gyr, turned[..., 1:] / step, atol=1e-5)
    gyr, acc, _, _ = hand.chunk(5100, 500)
    np.testing.assert_allclose(gyr, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(acc, axis=-1), 9.80665, rtol=1e-9)


def poses_of(hand, times):
    from fesloop.hand.kinematics import segment_poses

    motion = hand.script(times)[0]
    return segment_poses(hand.world, np.hstack([motion[:, :3], motion[:, 6:]])).orientation[:, 1:]


@pytest.mark.slow
def test_exact_sensors_give_exact_fingertips():
    rows, _ = followed(WornHand(0, EXACT), 1, drifting=False)
    first, _ = followed(WornHand(0, EXACT), 2, drifting=False)
    assert rms(first[1:], "tips", slice(0, 5)) < 5e-4
    np.testing.assert_array_equal(rows[0]["tips"], first[0]["tips"])


@pytest.mark.slow
def test_intervals_cover_the_fingertips_and_angles_of_many_hands():
    """Every error of `Worn` drawn anew for each hand; mounting dominates, and is constant for each."""
    tips, angles, errors = [], [], []
    for seed in range(100, 112):
        (row,), _ = followed(WornHand(seed), 1, drifting=False)
        tips.append(row["tip_inside"][1:])
        angles.append(row["inside"])
        errors.append(row["tips"])
    print(f"inside: tips {np.mean(tips):.3f}, angles {np.mean(angles):.3f}; rms, cm, F1 to F5:",
          (100 * np.sqrt(np.mean(np.square(errors), axis=0))).round(2))
    assert 0.90 <= np.mean(tips) <= 0.99
    assert 0.90 <= np.mean(angles) <= 0.99


@pytest.mark.slow
def test_it_stays_where_it_was_and_says_what_it_cannot_see_at_rest():
    """One minute of motion, two of rest, one of motion; a larger bias than in the hour makes it short."""
    hand = WornHand(5, Worn(bias_deg_s=1.0), long_rest=(60.0, 180.0))
    rows, reports = followed(hand, 4)
    for row in rows:
        print(f"{100 * rms([row], 'tips'):.2f} cm, salchow_m2 {100 * rms([row], 'drifting'):.2f};",
              "sd of the thumb's CMC", np.degrees(row["sd"][2:5]).round(1))
    assert rms(rows[3:], "tips") < 1.2 * rms(rows[1:2], "tips")
    thumb = slice(2, 5)
    # Mounting, which does not grow, is most of the sd in motion.
    assert rows[2]["sd"][thumb].max() > 1.1 * rows[1]["sd"][thumb].max()
    told = [status for at, status, detail in reports if at < 180.0 and "F1_cmc" in detail]
    assert told[-1] == "uncertain"
    assert rows[2]["sd"][thumb].max() > math.radians(15)

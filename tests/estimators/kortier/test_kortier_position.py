"""Position of a hand that reaches, by strapdown integration and by zero-velocity updates (K14, eq. 33)."""

import numpy as np
import pytest
from tracker_parts import RATE, run_tracker

from estimators.kortier import KortierTracker

SENSED = ("hand", "F2p", "F2m", "F2d")
START = RATE - 1
NEVER_STILL = {"still_rate": 1e-9, "still_acc": 1e-9}


def reaches(count, rest_s, seed, metres=0.3):
    """gyr, acc (ticks, 4, 3) of a flat hand that reaches for 1 s at a time, and its position (ticks,), m.

    Reaches are minimum-jerk movements. Errors of the sensors: white noise as in the paper's Table 1, and
    constant offsets of .05 deg/s and .02 m/s^2 (rms).
    """
    rng = np.random.default_rng(seed)
    position, ticks = [np.zeros(RATE)], RATE
    share = np.arange(1, ticks + 1) / ticks
    for k in range(count):
        path = metres * (10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5)
        forth = k % 2 == 0
        position += [path if forth else metres - path, np.full(round(rest_s * RATE), metres * forth)]
    place = np.concatenate(position)
    pushed = np.gradient(np.gradient(place, 1.0 / RATE), 1.0 / RATE)
    shape = (place.size, len(SENSED), 3)
    # A flat hand, palm down: segments' x up, y to the south (away from the fingertips), z to the east.
    true = np.zeros(shape)
    true[..., 0] = -9.81
    true[..., 2] = pushed[:, np.newaxis]
    gyr = rng.normal(0.0, np.radians(0.05), shape[1:]) + rng.normal(0.0, 5e-4, shape)
    acc = true + rng.normal(0.0, 0.02, shape[1:]) + rng.normal(0.0, 4e-2, shape)
    return gyr, acc, place


def errors_m(count, rest_s, seed, **ways):
    """Distance of the estimated position from the true one, (ticks,), from the first reach on."""
    gyr, acc, place = reaches(count, rest_s, seed)
    block = KortierTracker(sensors=len(SENSED), sensed=SENSED, magnetometers=False, **ways)
    outputs, _, _ = run_tracker(block, gyr, acc)
    moved = outputs[5] - outputs[5][START]
    moved[:, 0] -= place
    return np.linalg.norm(moved, axis=1)[START:]


@pytest.mark.parametrize("rest_s", [0.5, 1.0])
def test_zero_velocity_updates_hold_the_position_that_integration_loses(rest_s):
    """Ten reaches of 30 cm: integration alone is acceptable for a couple of seconds, as the paper says."""
    integrated = np.array([errors_m(10, rest_s, seed, **NEVER_STILL) for seed in range(3)])
    updated = np.array([errors_m(10, rest_s, seed, still_acc=0.1) for seed in range(3)])
    assert integrated[:, RATE].max() < 0.1
    assert np.median(integrated[:, -1]) > 1.0
    assert updated.max() < 0.08


def test_by_the_default_a_straight_reach_may_count_as_still():
    """A known limit: around its peak, an acceleration is as constant as gravity."""
    default = np.array([errors_m(1, 1.0, seed).max() for seed in range(4)])
    finer = np.array([errors_m(1, 1.0, seed, still_acc=0.1).max() for seed in range(4)])
    assert default.max() > 0.2
    assert finer.max() < 0.05

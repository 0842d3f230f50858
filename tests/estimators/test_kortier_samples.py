import numpy as np
import pytest

from estimators.kortier_samples import Arrivals
from fesloop.loop.signals import Sample

PERIOD_NS = 5_000_000


def noted(arrivals, k, gyr, acc, captured=None):
    """What is new at tick k, all stamps those of the gyroscopes unless told."""
    now = k * PERIOD_NS
    stamp = now if captured is None else captured
    mag = np.full((4, 3), 1e-5)
    return arrivals.note([Sample(gyr, now, now, now), Sample(acc, stamp, stamp, now),
                          Sample(mag, 0, 0, 0)])


def test_held_samples_behind_the_stamps_of_faster_gyroscopes_are_taken_once():
    rng = np.random.default_rng(0)
    arrivals, acc = Arrivals(5e-3), None
    elapsed = []
    for k in range(9):
        if k % 2 == 0:
            acc = rng.normal(size=(4, 3))
        elapsed.append(noted(arrivals, k, rng.normal(size=(4, 3)), acc)[1])
    assert elapsed == pytest.approx([5e-3, 0.0, 1e-2, 0.0, 1e-2, 0.0, 1e-2, 0.0, 1e-2])


def test_equal_samples_are_new_where_nothing_moves_and_where_stamps_say_so():
    arrivals, still, acc = Arrivals(5e-3), np.zeros((4, 3)), np.full((4, 3), 9.8)
    assert [noted(arrivals, k, still, acc)[1] for k in range(3)] == pytest.approx([5e-3] * 3)
    rng, arrivals = np.random.default_rng(0), Arrivals(5e-3)
    stamps = [0, 7_000_000, 14_000_000]
    told = [noted(arrivals, k, rng.normal(size=(4, 3)), acc, stamp)[1] for k, stamp in enumerate(stamps)]
    assert told == pytest.approx([5e-3, 7e-3, 7e-3])

"""Which instants are drawn."""

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.show.picture.draw import APART_M, candidates, most_different, requested_instants, spread_out


def test_postures_that_differ_most_are_taken_and_the_first_one():
    # A point that rests, goes to 1, rests, goes to -1, and comes back.
    place = np.concatenate([np.zeros(20), np.linspace(0, 1, 11), np.ones(20), np.linspace(1, -1, 21),
                            -np.ones(9)])
    values = np.zeros((len(place), 3, 3))
    values[:, 1, 2] = 0.1 * place
    rows = most_different(values, APART_M, shown=3)
    assert rows[0] == 0
    assert sorted(place[rows]) == pytest.approx([-1.0, 0.0, 1.0])
    assert rows == sorted(rows)


def test_each_is_far_from_all_that_are_chosen_already():
    values = 0.1 * np.array([0.0, 0.9, 1.0, 0.5, 0.1])[:, np.newaxis, np.newaxis]
    assert most_different(values, APART_M, shown=3) == [0, 2, 3]


def test_instants_next_to_a_chosen_one_are_not_drawn():
    # A hand springs to rest within two of a hundred rows, much later bends a little, and comes back.
    place = np.concatenate([[0.0, 0.6], np.ones(58), np.full(30, 1.3), np.ones(10)])
    values = 0.1 * place[:, np.newaxis, np.newaxis]
    rows = most_different(values, APART_M, shown=3)
    assert rows[0] == 0
    assert min(np.diff(rows)) >= 5
    assert sorted(place[rows]) == [0.0, 1.0, 1.3]


def test_what_hardly_moves_is_drawn_once_and_what_is_not_finite_never():
    values = np.full((50, 5, 3), 0.2)
    values[:, 0, 0] += np.linspace(0.0, 0.004, 50)
    assert most_different(values, APART_M) == [0]
    values[:10] = np.nan
    assert most_different(values, APART_M) == [10]
    values[:] = np.inf
    assert most_different(values, APART_M) == []


def test_candidates_cover_the_recording_in_whole_milliseconds():
    every = candidates(3_125_000, 3_996_875_000)
    assert (every % 1_000_000 == 0).all()
    assert every[0] <= 3_125_000
    assert every[-1] == 3_996_000_000
    np.testing.assert_array_equal(spread_out(0, 10), [0, 5, 10])
    np.testing.assert_array_equal(spread_out(7, 7), [7])


def test_instants_asked_for_keep_their_order_each_once():
    found = requested_instants([1.5, 0.25, 1.5], 2 * 10**9, 0)
    np.testing.assert_array_equal(found, [1_500_000_000, 250_000_000])


@pytest.mark.parametrize("second", [-0.1, 2.001, float("nan"), float("inf")])
def test_an_instant_outside_is_refused(second):
    with pytest.raises(InputError, match=r"--at .* 0 to 2 s"):
        requested_instants([1.0, second], 2 * 10**9, 0)

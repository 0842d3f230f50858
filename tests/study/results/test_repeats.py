import numpy as np
from hypothesis import given
from hypothesis import strategies as some

from fesloop.analysis.study.results.repeats import groups_of, unit_means

KEYS = some.integers(1, 5).flatmap(lambda axes: some.lists(
    some.tuples(*[some.integers(0, 3) | some.integers(10**9, 10**9 + 2)] * axes), min_size=1, max_size=30))


@given(KEYS)
def test_groups_are_numbered_in_the_order_of_their_keys(rows):
    order = sorted(set(rows))
    found = groups_of([np.array(key, dtype=np.int64) for key in zip(*rows, strict=True)])
    assert found.tolist() == [order.index(row) for row in rows]


@given(some.lists(some.tuples(some.integers(0, 4), some.floats(-1e3, 1e3)), min_size=1, max_size=20))
def test_a_unit_has_the_mean_of_its_values(rows):
    units, values = np.array([unit for unit, _ in rows]), np.array([value for _, value in rows])
    expected = [np.mean(values[units == unit]) for unit in sorted(set(units.tolist()))]
    assert np.allclose(unit_means(units, values), expected)

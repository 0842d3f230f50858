"""A table that rises, stays and sinks."""

import pytest

from plants.hand.scene import Table


def test_it_rises_to_its_height_and_sinks_by_the_same_distance():
    table = Table(raised_at_s=2.0, lowered_at_s=5.0, lowering_m=0.1, lowering_m_s=0.1)
    below = [table.drop(round(at_s * 1e9)) for at_s in (0.0, 2.0, 2.5, 3.0, 5.0, 5.5, 6.0, 9.0)]
    assert below == pytest.approx([0.1, 0.1, 0.05, 0.0, 0.0, 0.05, 0.1, 0.1])


def test_one_that_is_there_only_sinks():
    table = Table(lowered_at_s=5.0, lowering_m=0.1, lowering_m_s=0.1)
    assert [table.drop(round(at_s * 1e9)) for at_s in (0.0, 5.0, 7.0)] == [0.0, 0.0, 0.1]
    assert Table().drop(10**12) == 0.0

"""Few points stand for many rows: means between extremes, nothing lost, whatever the pieces."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.page import thinned_in_words
from fesloop.show.report.parts import Strips
from fesloop.show.report.run.thinning import course, thinned

VALUES = st.lists(st.floats(-1e6, 1e6) | st.just(np.nan), min_size=1, max_size=200)


def pieces_of(values, cuts):
    """The rows in pieces, some of them empty."""
    edges = [0, *sorted(min(cut, len(values)) for cut in cuts), len(values)]
    times = np.arange(len(values), dtype=np.int64) * 1_000_000
    return [(times[a:b], values[a:b]) for a, b in pairwise(edges)]


@given(VALUES, st.lists(st.integers(0, 200), max_size=4), st.integers(1, 50))
def test_no_peak_is_lost_and_the_mean_is_kept(values, cuts, points):
    rows = np.array(values)[:, np.newaxis]
    found = thinned(pieces_of(rows, cuts), len(rows), points)
    assert len(found.mean) <= points
    per_point = -(-len(rows) // points)
    groups = [rows[first:first + per_point, 0] for first in range(0, len(rows), per_point)]
    assert found.seconds == pytest.approx([0.001 * per_point * i for i in range(len(groups))])
    for i, group in enumerate(groups):
        known = group[~np.isnan(group)]
        if not known.size:
            assert np.isnan(found.mean[i, 0])
            continue
        assert found.mean[i, 0] == pytest.approx(known.mean(), rel=1e-9, abs=1e-9)
        if found.low is None:
            assert per_point == 1
        else:
            assert (found.low[i, 0], found.high[i, 0]) == (known.min(), known.max())


@given(st.lists(st.sampled_from([0.0, 0.022, 0.044]), min_size=1, max_size=200),
       st.lists(st.integers(0, 200), max_size=4), st.integers(1, 50))
def test_steps_have_no_value_that_never_was(values, cuts, points):
    """Pulses of 0 and 44 mA are none of 18 mA; each point is the row of its own instant."""
    rows = np.array(values)[:, np.newaxis]
    line = thinned(pieces_of(rows, cuts), len(rows), points).line("channel 0", "channel-0", 0, 1e3, "steps")
    assert line.y.tolist() == [1e3 * values[round(second * 1e3)] for second in line.x]


@given(st.integers(1, 60), st.integers(1, 50), st.sampled_from(["steps", "line"]))
def test_a_chart_says_how_it_was_thinned(count, points, style):
    line = thinned(pieces_of(np.zeros((count, 1)), []), count, points).line("a", "plain", 0, 1.0, style)
    text = thinned_in_words(Strips(key="k", title="", x_label="", y_label="", lines=[line]))
    per_point = -(-count // points)
    assert (text == "") == (per_point == 1)
    if text:
        assert f"up to {per_point} samples: a line is " in text
        assert ("the first of them" if style == "steps" else "their mean") in text


@pytest.mark.parametrize("cut", range(1, 10))
def test_a_point_of_rows_in_two_pieces_is_the_mean_of_all_of_them(cut):
    rows = np.arange(1.0, 11.0)[:, np.newaxis]
    found = thinned(pieces_of(rows, [cut]), 10, 2)
    assert found.mean[:, 0].tolist() == [3.0, 8.0]


def test_rows_that_are_few_stay_as_they_are():
    rows = np.array([[3.0], [1.0], [2.0]])
    found = thinned(pieces_of(rows, []), 3, 3)
    assert found.low is None
    assert (found.mean == rows).all()


def test_nothing_comes_of_nothing():
    assert thinned([], 0) is None


def test_a_line_is_one_component_in_another_unit(learning):
    with Recording(learning) as recording:
        angles = course(recording, "patient.angles", 1, 50)
        line = angles.line("PIP", "truth", 1, 2.0)
        every = recording.signal("patient.angles", 1).values[:, 1]
    assert line.low.min() == 2.0 * every.min()
    assert line.high.max() == 2.0 * every.max()
    assert (line.low <= line.y).all()
    assert (line.y <= line.high).all()


def test_a_point_has_the_extremes_of_all_pieces_that_it_is_made_of():
    pieces = [(np.array([0, 1]), np.array([5.0, 1.0])), (np.array([2]), np.array([3.0]))]
    found = thinned(pieces, 3, points=1)
    assert (found.low.tolist(), found.high.tolist()) == ([1.0], [5.0])

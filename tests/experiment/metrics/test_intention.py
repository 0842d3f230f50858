"""Triggers and attempts matched: by hand, and whatever they are."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.experiment.metrics.intention import answers

TIMES = np.arange(100, dtype=np.int64)


def attempted(*spans):
    """Number of the attempt under way at each instant, of spans (from, to)."""
    numbers = np.zeros(100)
    for number, (first, stop) in enumerate(spans, 1):
        numbers[first:stop] = number
    return numbers


def match(attempts, triggers, after=0, grace=0):
    return answers(TIMES, attempts, np.array(triggers, np.int64), after, grace)


def test_triggers_answer_attempts_miss_them_or_are_false():
    found = match(attempted((10, 20), (40, 50), (70, 80)), [5, 12, 15, 53, 90], grace=5)
    assert found.onsets_ns.tolist() == [10, 40, 70]
    assert found.triggers_ns.tolist() == [12, 53, -1]
    assert found.false == 3


def test_what_comes_before_the_scored_part_does_not_count():
    found = match(attempted((10, 20), (40, 50)), [12, 30, 45], after=35)
    assert (found.onsets_ns.tolist(), found.triggers_ns.tolist(), found.false) == ([40], [45], 0)


def test_attempts_that_touch_are_two_and_a_trigger_answers_the_later():
    found = match(attempted((10, 20), (20, 30)), [20], grace=50)
    assert found.onsets_ns.tolist() == [10, 20]
    assert found.triggers_ns.tolist() == [-1, 20]


@given(st.lists(st.integers(1, 9), max_size=9), st.lists(st.integers(0, 99), unique=True, max_size=12),
       st.integers(0, 99), st.integers(0, 30))
@settings(deadline=None)
def test_every_counted_trigger_answers_one_attempt_or_is_false(lengths, triggers, after, grace):
    edges = np.cumsum([0, *lengths])
    attempts = attempted(*[(int(a), int(b)) for a, b in zip(edges[:-1:2], edges[1::2], strict=False)])
    found = match(attempts, sorted(triggers), after, grace)
    answered = found.triggers_ns[found.triggers_ns >= 0]
    assert len(set(answered.tolist())) == len(answered)
    assert len(answered) + found.false == sum(each >= after for each in triggers)
    assert (answered >= found.onsets_ns[found.triggers_ns >= 0]).all()

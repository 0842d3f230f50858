"""Where a follower is: behind what is written, never ahead, and through every trial."""

from hypothesis import given
from hypothesis import strategies as st

from fesloop.show.view.followed import Head

MS, S = 10**6, 10**9


def test_it_goes_on_as_the_wall_clock_does_while_rows_come_in_bursts():
    head, seen = Head(), []
    for now in range(0, 20 * S, 33 * MS):
        written = now // (600 * MS) * 600 * MS
        head.move(now + 50 * S, (0, written), lambda trial: None)
        seen.append((now, head.time_ns))
    late = [now - at for now, at in seen if now > 3 * S]
    # .9 s behind what was written when it began, and never still from then on.
    assert max(late) - min(late) < 34 * MS
    assert max(late) <= 1500 * MS


def test_it_stops_where_nothing_more_is_known_and_goes_on_from_there():
    head = Head()
    for now in range(0, 10 * S, 100 * MS):
        head.move(now, (0, 2 * S), lambda trial: None)
    assert head.time_ns == 2 * S
    head.move(10 * S, (0, 3 * S), lambda trial: None)
    head.move(10 * S + 200 * MS, (0, 3 * S), lambda trial: None)
    assert head.time_ns == 2 * S + 300 * MS


def test_it_leaps_where_the_run_is_faster_than_the_clock():
    head = Head()
    head.move(0, (0, 0), lambda trial: None)
    head.move(100 * MS, (0, 60 * S), lambda trial: None)
    assert head.time_ns == 60 * S - 900 * MS


def test_a_trial_is_shown_to_its_end_before_the_next():
    head, seen = Head(), []
    head.move(0, (0, 5 * S), lambda trial: None)
    for now in range(33 * MS, 3 * S, 33 * MS):
        head.move(now, (1, now), {0: 5 * S, 1: now}.get)
        seen.append((head.trial, head.time_ns))
    assert [trial for trial, _ in seen] == sorted(trial for trial, _ in seen)
    last = max(time_ns for trial, time_ns in seen if trial == 0)
    assert 5 * S - 67 * MS < last <= 5 * S
    assert seen[-1][0] == 1


def test_a_trial_of_which_much_is_left_is_not_shown_to_its_end():
    head = Head()
    head.move(0, (0, 2 * S), lambda trial: None)
    head.move(33 * MS, (1, S // 2), {0: 4 * S, 1: S // 2}.get)
    assert (head.trial, head.time_ns) == (1, 0)  # 2.9 s were left, and .5 s are there of the next


@given(st.lists(st.tuples(st.integers(0, 2 * S), st.integers(0, 1), st.integers(0, 3 * S)), max_size=40))
def test_whatever_comes_it_is_at_something_known_and_goes_back_in_no_trial(steps):
    head, now, trial, ends = Head(), 0, 0, {0: 0}
    for elapsed, more_trials, more_ns in steps:
        now += elapsed
        if more_trials:
            trial += 1
            ends[trial] = 0
        ends[trial] += more_ns
        before = (head.trial, head.time_ns)
        head.move(now, (trial, ends[trial]), ends.get)
        assert 0 <= head.time_ns <= ends[head.trial]
        assert (head.trial, head.time_ns) >= before
        assert head.trial == trial or ends[head.trial] - head.time_ns + ends[trial] <= 2500 * MS

"""The pacer, on a wall clock that the test moves: never ahead of it, each tick once, late ones by policy."""

from contextlib import nullcontext

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live_parts import Wall, Worker
from loop_parts import Sink

from fesloop.errors import RunError
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import KEPT, LATE, SKIPPED, STOPPED, Pacer, Pacing
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

MS = 1_000_000
END = 400 * MS


def paced(nodes, wall, late="catch-up", end=END, wires=()):
    """(loop, pacer) after a trial."""
    loop = Loop(Wiring(nodes, wires), recorder=Recorder())
    pacer = Pacer(loop, Pacing(late=late), wall.clock, wall.sleep)
    pacer.begin_trial()
    assert pacer.now_ns() == 0
    run(pacer, end)
    return loop, pacer


def run(pacer, end):
    """A trial."""
    done = 0
    while done < end:
        done = pacer.advance(end)
        assert done <= pacer.now_ns() + 1, "ahead of the wall clock"


def worker(wall, *works_ms, rate="100", name="work"):
    return Node(name, Worker(wall=wall, works=tuple(round(work * MS) for work in works_ms)), rate)


def test_an_instant_is_never_run_early_and_sleep_never_adds_up():
    wall = Wall()
    loop, pacer = paced([worker(wall, 1)], wall)
    steps = loop.states()["work"].steps
    assert [(index, at) for index, at, _ in steps] == [(k, k * 10 * MS) for k in range(40)]
    assert all(0 <= wall_ns - at <= 80_000 for _, at, wall_ns in steps)
    assert (pacer.deadlines, pacer.missed) == (40, 0)
    assert wall.trial_ns == pytest.approx(END, abs=100_000), "a trial takes as long as it lasts"


def test_one_long_instant_is_made_up_for():
    wall = Wall()
    _, pacer = paced([worker(wall, *[2] * 10, 25, *[2] * 29)], wall)
    actions = [row[3] for row in pacer.rows]
    assert [k for k, action in enumerate(actions) if action == LATE] == [10, 11], "its own, 15 ms late, and 2"
    assert pacer.worst_late_ns == pytest.approx(15 * MS, abs=100_000)
    assert pacer.rows[14][1] <= 80_000


@pytest.mark.parametrize("late", ["catch-up", "skip"])
def test_what_is_always_too_slow_misses_every_deadline(late):
    wall = Wall()
    loop, pacer = paced([worker(wall, 12)], wall, late)
    assert pacer.missed == pacer.deadlines == 40
    steps = [index for index, _, _ in loop.states()["work"].steps]
    if late == "catch-up":
        assert steps == list(range(40))
        assert wall.trial_ns == pytest.approx(40 * 12 * MS, abs=100_000)
    else:
        assert len(steps) == pytest.approx(400 / 12, abs=1.5)
        assert wall.trial_ns < END + 24 * MS


def test_stop_ends_the_run_with_its_cause():
    wall = Wall()
    loop = Loop(Wiring([worker(wall, *[2] * 7, 25)], ()), recorder=Recorder())
    pacer = Pacer(loop, Pacing(late="stop"), wall.clock, wall.sleep)
    pacer.begin_trial()
    with pytest.raises(RunError, match=r"due at 70\.000 ms began 0\.080 ms late and took 25\.000 ms"):
        run(pacer, END)
    assert [row[3] for row in pacer.rows] == [KEPT] * 7 + [STOPPED]
    assert loop.recorder.events[-1][1:3] == ("loop", "failed")
    with pytest.raises(RunError, match="stopped"):
        loop.run_until(END)


def test_a_skipped_tick_is_an_event_and_its_readers_hold_what_they_had():
    wall = Wall()
    sink = Node("sink", Sink(), "100")
    nodes, wires = [worker(wall, 1, 1, 34, *[1] * 9), sink], [Wire("work.y", "sink.u")]
    loop, _ = paced(nodes, wall, "skip", 100 * MS, wires)
    skipped = [event for event in loop.recorder.events if event[2] == "skipped"]
    assert [(event[0], event[1]) for event in skipped] == [
        (t * MS, name) for name in ("work", "sink") for t in (30, 40)]
    assert skipped[0][3].startswith("tick 3: 24.")
    read = [(at // MS, sample.value) for at, sample in loop.states()["sink"].log]
    assert read == [(0, 0.0), (10, 1.0), (20, 2.0), (50, 5.0), *((10 * k, float(k)) for k in range(6, 10))]


def test_what_is_a_period_late_is_skipped_and_what_is_less_is_not():
    wall = Wall()
    loop, _ = paced([worker(wall, 1, 1, 24, *[1] * 9)], wall, "skip", 80 * MS)
    assert [index for index, _, _ in loop.states()["work"].steps] == [0, 1, 2, 4, 5, 6, 7]


@pytest.mark.parametrize(("late", "sent"), [("catch-up", range(6, 27)), ("skip", [26]), ("stop", [6])])
def test_what_a_stopped_process_missed_comes_at_once(late, sent):
    """A sleep that ends 200 ms late, as under SIGSTOP: what is sent when it goes on."""
    wall = Wall((*(80_000,) * 5, 200 * MS, *(80_000,) * 40))
    loop = Loop(Wiring([worker(wall, 0)], ()), recorder=Recorder())
    pacer = Pacer(loop, Pacing(late=late), wall.clock, wall.sleep)
    pacer.begin_trial()
    with pytest.raises(RunError) if late == "stop" else nullcontext():
        run(pacer, END)
    steps = loop.states()["work"].steps
    assert [index for index, _, wall_ns in steps if 260 * MS <= wall_ns < 265 * MS] == list(sent)
    assert all(at == 10 * index * MS for index, at, _ in steps), "each with the stamp of its own instant"


WORKS = st.lists(st.integers(0, 45 * MS) | st.integers(0, 9 * MS), min_size=1, max_size=12)


@settings(max_examples=150, deadline=None)
@given(works=WORKS, others=WORKS, over=st.lists(st.integers(0, 12 * MS), min_size=1, max_size=5),
       rate=st.sampled_from(["100", "60", "285.714"]), late=st.sampled_from(["catch-up", "skip"]))
def test_whatever_the_work_takes(works, others, over, rate, late):
    wall = Wall(tuple(over))
    nodes = [Node("work", Worker(wall=wall, works=tuple(works)), rate),
             Node("other", Worker(wall=wall, works=tuple(others)), "40")]
    loop, pacer = paced(nodes, wall, late)
    for node in nodes:
        skips = [event for event in loop.recorder.events if event[1] == node.name]
        steps = loop.states()[node.name].steps
        assert all(wall_ns >= at for _, at, wall_ns in steps), "no tick before its time"
        assert [at for _, at, _ in steps] == [node.clock.tick(index) for index, _, _ in steps]
        indices = [index for index, _, _ in steps]
        passed = [node.clock.first_at_or_after(event[0]) for event in skips]
        assert indices == sorted(set(indices))
        assert sorted(indices + passed) == list(range(node.clock.first_at_or_after(END))), "each tick once"
        assert late == "skip" or not passed
        for event in skips:
            late_by = float(event[3].partition(": ")[2].removesuffix(" ms late")) * MS
            assert late_by >= node.clock.shortest_ns - 1000, "only what is a period late"
    for _, late_ns, took_ns, action in pacer.rows:
        assert late_ns >= 0
        assert (action != KEPT) == (action == SKIPPED or late_ns + took_ns > pacer.period_ns)
    assert [row[0] for row in pacer.rows] == sorted({row[0] for row in pacer.rows})
    assert pacer.missed == sum(row[3] != KEPT for row in pacer.rows)
    assert pacer.deadlines == len(pacer.rows)

"""Live streams on a wall clock that the test moves: blocks tick as messages come, and stamps say when."""

import threading
import time
from dataclasses import dataclass

import pytest
from live_parts import Stream, Wall, Worker
from loop_parts import ImpulseProbe, Sink

from fesloop.loop.clock import FOREVER, RateClock, ticks_from
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import KEPT, SKIPPED, Pacer, Pacing
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

MS = 1_000_000
CAME = (3 * MS, 12 * MS, 12 * MS + 1, 31 * MS)


def wired(stream, *more, wires=()):
    """A stream, a sink on its clock, another at 50 Hz, and more."""
    nodes = [Node("glove", stream), Node("sink", Sink(), stream.clock), Node("watch", Sink(), "50"), *more]
    return Wiring(nodes, [Wire("glove.y", "sink.u"), Wire("glove.y", "watch.u"), *wires])


def run(wiring, wall, late="catch-up", end=60 * MS):
    loop = Loop(wiring, recorder=Recorder())
    pacer = Pacer(loop, Pacing(late=late), wall.clock, wall.sleep)
    pacer.begin_trial()
    while pacer.advance(end) < end:
        pass
    return loop, pacer


@pytest.fixture
def napping(monkeypatch):
    """Naps of .1 ms, as nothing rings on a made-up clock."""
    monkeypatch.setattr("fesloop.loop.realtime._NAP_NS", 100_000)


def test_a_clock_of_arrivals_counts_as_its_rate_and_ticks_when_told():
    clock = RateClock.from_rate("100", arrivals="glove")
    assert clock.period_s == 0.01
    assert clock.tick(3) == 30 * MS
    assert str(clock) == "100 Hz nominal, as glove arrives"
    assert clock != RateClock.from_rate("100")
    assert [ticks_from(clock, 0)() for _ in range(3)] == [FOREVER] * 3
    loop = Loop(wired(Stream(wall=Wall(), arrivals_ns=(0,) * 9)))
    loop.run_until(100 * MS)
    assert loop.states()["glove"].steps == []
    loop.arrive(clock, 101 * MS)
    loop.run_until(100 * MS + 5)
    assert loop.states()["glove"].steps == []
    loop.run_until(200 * MS)
    assert [at for _, at, _ in loop.states()["glove"].steps] == [101 * MS]
    with pytest.raises(ValueError, match="has been run"):
        loop.arrive(clock, 200 * MS)


def test_blocks_on_the_clock_tick_as_each_message_comes_and_others_as_ever(napping):
    wall = Wall((0,))
    loop, pacer = run(wired(Stream(wall=wall, arrivals_ns=CAME, age_ns=2 * MS)), wall)
    states = loop.states()
    assert [(index, at) for index, at, _ in states["glove"].steps] == list(enumerate(CAME))
    assert all(0 <= wall_ns - at <= 200_000 for _, at, wall_ns in states["glove"].steps)
    assert [(at, sample.value, sample.oldest_ns, sample.newest_ns) for at, sample in states["sink"].log] == [
        (at, float(k), at - 2 * MS, at - 2 * MS) for k, at in enumerate(CAME)]
    assert [(at, sample.value) for at, sample in states["watch"].log[1:]] == [(20 * MS, 2.0), (40 * MS, 3.0)]
    assert [row[0] for row in pacer.rows] == sorted([*CAME, 0, 20 * MS, 40 * MS])
    assert {row[3] for row in pacer.rows} == {KEPT}


def test_a_plant_is_sampled_for_them_then_and_there(napping):
    wall = Wall((0,))
    wiring = wired(Stream(wall=wall, arrivals_ns=CAME), Node("plant", ImpulseProbe(impulse_ns=CAME[1])),
                   Node("seen", Sink(), RateClock.from_rate("100", arrivals="glove")),
                   Node("input", Worker(wall=wall, works=(0,)), "50"),
                   wires=[Wire("plant.y", "seen.u"), Wire("input.y", "plant.u")])
    loop, _ = run(wiring, wall)
    assert [(at, sample.value) for at, sample in loop.states()["seen"].log] == [
        (at, float(at == CAME[1])) for at in CAME]


def test_a_message_is_due_a_period_after_the_last_until_that_has_passed(napping):
    """Or the collector, which works where nothing is due, would rest for as long as a stream is silent."""
    wall = Wall((0,))
    loop, pacer = run(wired(Stream(wall=wall, arrivals_ns=(3 * MS,))), wall, end=5 * MS)
    assert pacer.slack_ns() == 13 * MS - wall.trial_ns
    while pacer.advance(15 * MS) < 15 * MS:
        pass
    assert pacer.slack_ns() == 20 * MS - wall.trial_ns
    loop.next_trial()
    wall.origin = wall.now
    pacer.begin_trial()
    while pacer.advance(MS) < MS:
        pass
    assert pacer.slack_ns() == 20 * MS - wall.trial_ns


def test_what_came_while_the_loop_worked_is_taken_next_and_in_order(napping):
    """Work of 15 ms at t = 0: three messages wait, of which the first has its own instant still."""
    wall = Wall((0,))
    busy = Node("busy", Worker(wall=wall, works=(15 * MS, 0)), "50")
    loop, pacer = run(wired(Stream(wall=wall, arrivals_ns=CAME), busy), wall)
    assert [at for _, at, _ in loop.states()["glove"].steps] == list(CAME)
    assert pacer.rows[1][:2] == (3 * MS, 12 * MS)


def test_of_late_messages_only_the_streams_own_block_takes_note_when_skipping(napping):
    wall = Wall((0,))
    busy = Node("busy", Worker(wall=wall, works=(15 * MS, 0)), "50")
    loop, pacer = run(wired(Stream(wall=wall, arrivals_ns=CAME), busy), wall, "skip")
    assert [at for _, at, _ in loop.states()["glove"].steps] == list(CAME)
    assert [at for at, _ in loop.states()["sink"].log] == list(CAME[1:])
    assert [event[:3] for event in loop.recorder.events] == [(3 * MS, "sink", "skipped")]
    assert [row[0] for row in pacer.rows if row[3] == SKIPPED] == [3 * MS]


def test_a_bell_from_another_thread_wakes_the_loop_at_once():
    class Now:
        @property
        def trial_ns(self):
            return time.monotonic_ns() - began

    began = time.monotonic_ns()
    stream = Stream(wall=Now(), arrivals_ns=(50 * MS, 130 * MS))
    loop = Loop(Wiring([Node("glove", stream), Node("slow", Sink(), "2")], [Wire("glove.y", "slow.u")]))
    pacer = Pacer(loop, Pacing())
    pacer.begin_trial()
    state = loop.states()["glove"]
    assert abs(state.present.origin_ns - began) < 50 * MS
    began = state.present.origin_ns

    def ring():
        for arrival in stream.arrivals_ns:
            time.sleep(max(0, arrival - stream.wall.trial_ns) / 1e9)
            state.present.bell.set()

    ringer = threading.Thread(target=ring)
    ringer.start()
    moments = 1
    while pacer.advance(180 * MS) < 180 * MS:
        moments += 1
    ringer.join()
    assert moments < 40, "it sleeps between two rings"
    assert [at for _, at, _ in state.steps] == [50 * MS, 130 * MS]
    assert sorted(wall_ns - at for _, at, wall_ns in state.steps)[0] < 20 * MS


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Says:
    """Says that what it puts out was captured at a certain instant."""

    captured_ns: int
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        tick.captured_ns = self.captured_ns
        return (0.0,)


@pytest.mark.parametrize(("said_ns", "stamp_ns", "why"), [
    (-5 * MS, 0, "at -5 ms, which is before the trial"),
    (40 * MS, 20 * MS, "at 40 ms, which is yet to come"), (7 * MS, 7 * MS, None)])
def test_a_capture_lies_within_the_trial_and_not_ahead(said_ns, stamp_ns, why):
    recorder = Recorder()
    loop = Loop(Wiring([Node("says", Says(captured_ns=said_ns), "50")], []), recorder=recorder)
    loop.run_until(20 * MS)
    assert recorder.blocks["says"][-1][3:5] == (stamp_ns, stamp_ns)
    told = [event[2:] for event in recorder.events if event[0] == 20 * MS]
    assert told == ([("impossible_capture", why)] if why else [])

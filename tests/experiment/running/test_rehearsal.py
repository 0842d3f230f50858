"""When a run is rehearsed: once for loops of the same parts, and always where the wall clock counts."""

import pytest
from live_parts import Log, StandIn, Stream
from loop_parts import Sink

import fesloop
from fesloop.errors import InputError
from fesloop.experiment import running
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire

SHORT = ["experiment.duration_s=0.6"]


@pytest.fixture
def loops(monkeypatch):
    """Loops that rehearsals make, and no run."""
    made, under_way = [], []
    rehearse = running.Rehearsals.rehearse

    class Counted(running.Loop):
        def __init__(self, *given, **named):
            if under_way:
                made.append(given)
            super().__init__(*given, **named)

    def rehearsed(*given, **named):
        under_way.append(True)
        rehearse(*given, **named)
        under_way.pop()

    monkeypatch.setattr(running, "Loop", Counted)
    monkeypatch.setattr(running.Rehearsals, "rehearse", rehearsed)
    return made


def test_the_same_parts_are_rehearsed_once(loops, tmp_path):
    first, again = (fesloop.load("finger_pid_latency", [*SHORT, *more])
                    for more in ((), ("latency_ms=20",)))
    rehearsals = running.Rehearsals()
    for experiment in (first, first.with_seed(9), again):
        running.run(experiment, tmp_path, rehearsals=rehearsals)
    assert len(loops) == 1
    running.run(first, tmp_path)
    assert len(loops) == 2


@pytest.mark.slow
@pytest.mark.parametrize(("settings", "realtime"), [
    (["record.timed=['controller']"], False), (["blocks.controller.execution={kind='measured'}"], False),
    ([], True)])
def test_where_the_wall_clock_counts_every_run_is_rehearsed(loops, tmp_path, settings, realtime):
    experiment = fesloop.load("finger_pid_latency", [*SHORT, *settings])
    rehearsals = running.Rehearsals()
    for count in (1, 2):
        running.run(experiment, tmp_path, realtime=realtime, rehearsals=rehearsals)
        assert len(loops) == count


@pytest.mark.parametrize(("realtime", "latency_ms", "longest_s", "until_ms"), [
    (True, 30, 0.0, 100 + 30 + 5), (True, 1e6, 0.0, 2000), (False, 30, 0.0, 0), (False, 30, 60.0, 100)])
def test_where_the_wall_clock_counts_a_message_goes_all_the_way_round(
        loops, monkeypatch, realtime, latency_ms, longest_s, until_ms):
    """However long compiling takes: a run's first ticks would wait for what has not been called."""
    reached = []
    monkeypatch.setattr(running, "_LONGEST_WALL_S", longest_s)
    monkeypatch.setattr(running.Loop, "run_until", lambda loop, until_ns: reached.append(until_ns))
    experiment = fesloop.load("finger_pid_latency", [*SHORT, f"latency_ms={latency_ms}"])
    running.Rehearsals().rehearse(experiment, realtime)
    assert max(reached, default=0) == until_ms * 1_000_000


def test_a_rehearsal_changes_no_run(loops, tmp_path):
    experiment = fesloop.load("finger_pid_latency", SHORT)
    digests, rehearsals = set(), running.Rehearsals()
    for _ in range(2):
        path = running.run(experiment, tmp_path, rehearsals=rehearsals).recording
        with fesloop.Recording(path) as recording:
            digests.add(recording.digest())
    assert len(digests) == len(loops) == 1


def live_experiment(duration_s=0.3):
    stream = Stream(wall=None, arrivals_ns=())
    nodes = (Node("glove", stream), Node("sink", Sink(), stream.clock))
    return Experiment(name="live", nodes=nodes, wires=(Wire("glove.y", "sink.u"),), duration_s=duration_s)


def test_a_live_stream_is_rehearsed_with_its_stand_in(loops):
    experiment = live_experiment()
    assert [str(node.clock) for node in running.with_stand_ins(experiment.wiring).nodes] == ["100 Hz"] * 2
    running.Rehearsals().rehearse(experiment, realtime=True)
    (given,) = loops
    assert [type(node.part) for node in given[0].nodes] == [StandIn, Sink]
    plain = fesloop.load("finger_pid_latency", SHORT).wiring
    assert running.with_stand_ins(plain) is plain


@pytest.mark.slow
def test_what_is_to_be_heard_is_looked_for_before_the_rehearsal(monkeypatch, tmp_path):
    """It takes a while where kernels are yet to be compiled, and a mistyped name can be told at once."""
    done = []
    monkeypatch.setattr(running.Rehearsals, "rehearse", lambda *_: done.append("rehearse"))
    monkeypatch.setattr(Stream, "seek", lambda self: done.append("seek"), raising=False)
    monkeypatch.setattr(Stream, "init", lambda self, context: done.append("init") or Log())
    monkeypatch.setattr(Stream, "waiting", lambda self, state: None)
    running.run(live_experiment(duration_s=0.02), tmp_path, realtime=True)
    assert done == ["seek", "rehearse", "init"]


def test_a_device_without_a_stand_in_is_not_rehearsed(loops):
    class Device(StandIn):
        def close(self, state):
            """Let go."""

    node = Node("device", Device(clock=RateClock.from_rate("100")))
    running.Rehearsals().rehearse(Experiment(name="device", nodes=(node,), duration_s=1.0), realtime=True)
    assert not loops


def test_a_live_stream_is_refused_where_nothing_keeps_in_step(loops, tmp_path):
    with pytest.raises(InputError, match=r"^blocks\.glove: is live.*fesloop run --realtime$"):
        live_experiment().run(tmp_path)
    assert not loops
    assert list(tmp_path.iterdir()) == []

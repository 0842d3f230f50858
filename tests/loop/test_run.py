"""The loop against an exact trajectory, against itself, and against the rules that it promises."""

import importlib.util
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Pass, PeersPi, SecondOrder, Sink, Source

from fesloop.errors import InputError, RunError
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, RateClock, StampClock
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


def peers_wiring(grid=None, rate="1000"):
    return Wiring(
        [Node("plant", SecondOrder(grid=grid)), Node("pi", PeersPi(), rate="50")],
        [Wire("plant.y", "pi.y", latency_ms=30, rate=rate), Wire("pi.u", "plant.u")])


def recorded_output(recorder, name="plant"):
    rows = recorder.plants[name]
    times = np.array([t for row in rows for t in row[0]])
    return times, np.concatenate([np.asarray(row[2][0]) for row in rows])


@pytest.mark.parametrize("grid", [None, RateClock.from_rate("1000")])
def test_equals_the_peers_reference(peers, grid):
    spec = importlib.util.spec_from_file_location("peers_loop_common", peers / "loop" / "common.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    expected, expected_u = module.reference()
    recorder = Recorder("1000")
    Loop(peers_wiring(grid), recorder=recorder).run_until(10 * NS_PER_S)
    times, y = recorded_output(recorder)
    assert np.array_equal(times, np.arange(10_001) * NS_PER_MS)
    assert np.abs(y - expected).max() < 1e-12
    u = np.array([row[5][0] for row in recorder.blocks["pi"]])
    assert np.abs(u - expected_u[::20]).max() < 1e-12


@pytest.mark.parametrize("grid", [None, RateClock.from_rate("1000")])
@pytest.mark.parametrize("record_rate", [None, "7", "285.714", "1000"])
def test_an_observer_changes_no_bit(grid, record_rate):
    bare, watched = Recorder(None), Recorder(record_rate)
    Loop(peers_wiring(grid), recorder=bare).run_until(NS_PER_S // 2)
    nodes = [Node("plant", SecondOrder(grid=grid)), Node("pi", PeersPi(), rate="50"),
             Node("watch", Sink(), rate="30")]
    wires = [Wire("plant.y", "pi.y", latency_ms=30, rate="1000"), Wire("pi.u", "plant.u"),
             Wire("pi.u", "watch.u")]
    Loop(Wiring(nodes, wires), recorder=watched).run_until(NS_PER_S // 2)
    assert bare.blocks["pi"] == watched.blocks["pi"]


@pytest.mark.parametrize("grid", [None, RateClock.from_rate("1000")])
def test_a_stop_before_a_turn_shows_what_it_reads_and_changes_no_bit(grid):
    class Watched(PeersPi):
        def step(self, state, inputs, tick):
            read.append(tuple(inputs))
            return super().step(state, inputs, tick)

    read, given = [], []
    jitter = Duration(kind="uniform", low_ms=0, high_ms=30)
    wires = [Wire("plant.y", "pi.y", rate="1000", jitter=jitter, loss=0.1), Wire("pi.u", "plant.u"),
             Wire("pi.u", "watch.u")]
    nodes = [Node("plant", SecondOrder(grid=grid)), Node("pi", Watched(), rate="50"),
             Node("watch", Sink(), rate="50")]
    whole, parts = Recorder("1000"), Recorder("1000")
    Loop(Wiring(nodes, wires, seed=2), recorder=whole).run_until(NS_PER_S)
    there, read = read, []
    loop = Loop(Wiring(nodes, wires, seed=2), recorder=parts)
    for tick in range(51):
        given.append(loop.run_until_turn("pi", tick * 20 * NS_PER_MS))
        assert len(read) == tick
        assert loop.now == tick * 20 * NS_PER_MS - 1
        if tick == 25:  # stopped there, it is saved and restored like anywhere
            loop.restore(loop.snapshot())
    loop.run_until(NS_PER_S)
    assert given == read == there
    assert parts.blocks["pi"] == whole.blocks["pi"]
    for ours, theirs in zip(recorded_output(parts), recorded_output(whole), strict=True):
        assert np.array_equal(ours, theirs)


@given(rates=st.tuples(st.sampled_from(["1000", "50", "300"]), st.sampled_from(["1000", "50", "30"])),
       latency_ms=st.sampled_from([1e-6, 7.0, 25.0]),
       grid=st.sampled_from([None, RateClock.from_rate("1000")]))
@settings(max_examples=12, deadline=None)
def test_an_observer_that_never_steps_reads_what_a_stepping_one_does_and_changes_no_bit(
        rates, latency_ms, grid):
    class Watching(Sink):
        inputs = (Port("y"), Port("u"))

        def step(self, state, inputs, tick):
            stepped.append(tuple(inputs))
            return ()

    def loop(clock, record):
        nodes = [Node("plant", SecondOrder(grid=grid)), Node("watch", Watching(), clock),
                 Node("pi", PeersPi(), "50")]
        wires = [Wire("plant.y", "pi.y", latency_ms=30, rate=rates[0]), Wire("pi.u", "plant.u"),
                 Wire("plant.y", "watch.y", rate=rates[1]), Wire("pi.u", "watch.u", latency_ms=latency_ms)]
        return Loop(Wiring(nodes, wires), recorder=record)

    stepped, read, ticks = [], [], [k * 20 * NS_PER_MS for k in range(16)]
    bare, watched = Recorder(None), Recorder(None)
    loop("50", bare).run_until(ticks[-1])
    theirs, stepped = stepped, []
    observed = loop(StampClock(np.array([FOREVER])), watched)
    for time_ns in ticks:
        samples = observed.run_until_turn("pi", time_ns, "watch")
        assert samples[:1] == observed.run_until_turn("pi", time_ns)
        read.append(samples[1:])
    observed.run_until(ticks[-1])
    assert not stepped
    assert read == theirs
    assert watched.blocks["pi"] == bare.blocks["pi"]


@pytest.mark.parametrize(("name", "time_ns", "message"), [
    ("pi", 0, "pi has no tick to come at 0 ns; allowed: a tick from 20000000 ns on"),
    ("pi", 30_000_000, "pi has no tick to come at 30000000 ns"),
    ("plant", 20_000_000, "there is no block 'plant'; allowed: pi")])
def test_a_turn_that_does_not_come_is_refused(name, time_ns, message):
    loop = Loop(peers_wiring())
    loop.run_until(0)
    with pytest.raises(InputError, match=message):
        loop.run_until_turn(name, time_ns)
    with pytest.raises(InputError, match="there is no block 'nobody'; allowed: pi"):
        loop.run_until_turn("pi", 20_000_000, "nobody")
    loop.run_until_turn("pi", 20_000_000)


@pytest.mark.slow
@given(st.integers(0, 999_999_999), st.sampled_from([None, "1000", "250"]))
@settings(max_examples=25, deadline=None)
def test_a_snapshot_goes_on_identically(at_ns, grid_rate):
    grid = None if grid_rate is None else RateClock.from_rate(grid_rate)
    nodes = [Node("plant", SecondOrder(grid=grid)),
             Node("pi", PeersPi(), rate="50", execution=Duration(kind="uniform", low_ms=0.5, high_ms=30))]
    wires = [Wire("plant.y", "pi.y", latency_ms=30, rate="1000", loss=0.1,
                  jitter=Duration(kind="normal", mean_ms=0, sd_ms=5, low_ms=-20, high_ms=20)),
             Wire("pi.u", "plant.u", latency_ms=3)]
    recorder = Recorder("1000")
    loop = Loop(Wiring(nodes, wires, seed=3), recorder=recorder)
    loop.run_until(at_ns)
    recorder.drain()
    snapshot = loop.snapshot()
    loop.run_until(NS_PER_S)
    first = recorder.drain()
    loop.restore(snapshot)
    loop.run_until(NS_PER_S)
    second = recorder.drain()
    assert flat(first) == flat(second)
    assert first[0]["pi"]


def flat(rows):
    """Recorded rows as plain numbers, plant stacks one instant a row."""
    blocks, plants, inputs, events = rows
    instants = {name: [(t, float(y)) for times, _, (stack,) in stacks
                       for t, y in zip(times, stack, strict=True)] for name, stacks in plants.items()}
    return blocks, instants, inputs, events


def test_input_acts_from_its_arrival_on():
    recorder = Recorder("1000")
    wiring = Wiring([Node("plant", SecondOrder()), Node("one", Constant1(), rate="1")],
                    [Wire("one.y", "plant.u", latency_ms=12.3456789)])
    Loop(wiring, recorder=recorder).run_until(NS_PER_S // 2)
    assert recorder.inputs["plant"][0][0] == 12_345_679
    times, y = recorded_output(recorder)
    w, z = 2 * np.pi * 2.5, 0.9
    since = np.clip(times * 1e-9 - 0.012345679, 0, None)
    wd = w * np.sqrt(1 - z * z)
    step = 1 - np.exp(-z * w * since) * (np.cos(wd * since) + z * w / wd * np.sin(wd * since))
    assert np.abs(y - step).max() < 1e-12


class Constant1(Source):
    def step(self, state, inputs, tick):
        return (1.0,)


def test_same_instant_goes_in_topological_order_whatever_the_declaration():
    wires = [Wire("source.y", "double.u"), Wire("double.y", "sink.u")]
    nodes = [Node("sink", Sink(), rate="10"), Node("double", Pass(gain=2.0), rate="10"),
             Node("source", Source(), rate="10")]
    loop = Loop(Wiring(nodes, wires))
    loop.run_until(NS_PER_S)
    log = loop.states()["sink"].log
    assert [sample.value for _, sample in log] == [2.0 * k for k in range(11)]
    assert all(sample.arrived_ns == t == sample.oldest_ns for t, sample in log)


def test_stamps_carry_oldest_and_newest_through_blocks():
    wires = [Wire("a.y", "sum.a", latency_ms=10), Wire("b.y", "sum.b", latency_ms=25),
             Wire("sum.y", "sink.u", latency_ms=5)]
    nodes = [Node("a", Source(), rate="100"), Node("b", Source(), rate="100"),
             Node("sum", Pass(names=("a", "b")), rate="100"), Node("sink", Sink(), rate="100")]
    loop = Loop(Wiring(nodes, wires))
    loop.run_until(NS_PER_S)
    time, sample = loop.states()["sink"].log[50]
    assert time == 500 * NS_PER_MS
    # read at 490 by sum: a captured at 480, b at 460 (arrived 485); on the way until 495
    assert (sample.oldest_ns, sample.newest_ns, sample.arrived_ns) == tuple(
        t * NS_PER_MS for t in (460, 480, 495))
    assert sample.age_ns(time) == 40 * NS_PER_MS


def test_a_busy_block_skips_and_says_so():
    recorder = Recorder()
    nodes = [Node("source", Source(), rate="100", execution=Duration(kind="fixed", ms=25)),
             Node("sink", Sink(), rate="1000")]
    loop = Loop(Wiring(nodes, [Wire("source.y", "sink.u")]), recorder=recorder)
    loop.run_until(100 * NS_PER_MS)
    assert [row[0] for row in recorder.blocks["source"]] == [0, 3, 6, 9]
    assert [row[2] - row[1] for row in recorder.blocks["source"]] == [25 * NS_PER_MS] * 4
    assert [(t // NS_PER_MS, status) for t, _, status, _ in recorder.events] == [
        (t, "skipped") for t in (10, 20, 40, 50, 70, 80, 100)]


def test_keep_newest_drops_and_counts_what_was_overtaken_and_in_order_waits():
    def run(late):
        nodes = [Node("source", Source(), rate="1000"), Node("sink", Sink(), rate="1000")]
        wire = Wire("source.y", "sink.u", latency_ms=5, late=late,
                    jitter=Duration(kind="uniform", low_ms=-5, high_ms=5))
        loop = Loop(Wiring(nodes, [wire], seed=1))
        loop.run_until(NS_PER_S)
        values = [s.value for _, s in loop.states()["sink"].log if s.present]
        return values, loop.message_counts()["source.y->sink.u"]

    newest, counts = run("keep-newest")
    assert newest == sorted(newest)
    assert counts["late"] > 100
    waiting, counts = run("in-order")
    assert waiting == sorted(waiting)
    assert counts["late"] == 0
    assert sum(newest) > sum(waiting)


def test_loss_is_counted_and_another_block_changes_no_draw():
    def received(extra):
        nodes = [Node("source", Source(), rate="100"), Node("sink", Sink(), rate="100")]
        wires = [Wire("source.y", "sink.u", loss=0.3)]
        if extra:
            nodes.insert(0, Node("other", Sink(), rate="50"))
            wires.insert(0, Wire("source.y", "other.u", loss=0.5))
        loop = Loop(Wiring(nodes, wires, seed=7))
        loop.run_until(10 * NS_PER_S)
        return [s.value for _, s in loop.states()["sink"].log], loop.message_counts()["source.y->sink.u"]

    values, counts = received(False)
    assert values == received(True)[0]
    assert counts["sent"] == 1001
    assert 240 < counts["lost"] < 360


def test_a_non_finite_output_is_replaced_and_recorded():
    class Bad(Source):
        def step(self, state, inputs, tick):
            return (float("nan") if tick.index == 3 else 1.0,)

    recorder = Recorder()
    nodes = [Node("bad", Bad(), rate="10"), Node("sink", Sink(), rate="10")]
    loop = Loop(Wiring(nodes, [Wire("bad.y", "sink.u")]), recorder=recorder)
    loop.run_until(NS_PER_S)
    assert [s.value for _, s in loop.states()["sink"].log][2:5] == [1.0, 0.0, 1.0]
    assert recorder.events == [
        (300 * NS_PER_MS, "bad", "non_finite", "output y: its safe value takes its place")]


def test_an_unstable_plant_ends_the_run_by_name():
    nodes = [Node("plant", SecondOrder()), Node("gain", Pass(gain=-1e6, names=("y", "one")), rate="20"),
             Node("one", Constant1(), rate="1")]
    wires = [Wire("plant.y", "gain.y"), Wire("one.y", "gain.one"), Wire("gain.y", "plant.u")]
    recorder = Recorder()
    loop = Loop(Wiring(nodes, wires), recorder=recorder)
    with pytest.raises(RunError, match=r"plant\.y is not finite at .* ms"):
        loop.run_until(100 * NS_PER_S)
    assert recorder.blocks["gain"]


def test_measured_time_recorded_repeats_exactly():
    def run(execution):
        recorder = Recorder()
        nodes = [Node("source", Source(), rate="1000", execution=execution), Node("sink", Sink(), rate="500")]
        Loop(Wiring(nodes, [Wire("source.y", "sink.u")]), recorder=recorder).run_until(NS_PER_S // 10)
        return recorder.blocks

    first = run(Duration(kind="measured", scale=300.0))
    durations = tuple(row[2] - row[1] for row in first["source"])
    assert min(durations) > 0
    assert run(Duration(kind="recorded", recorded_ns=(durations,))) == first


def refused(nodes, wires):
    with pytest.raises(InputError) as caught:
        Wiring(nodes, wires)
    text = str(caught.value)
    assert text.count("\n") == len(getattr(caught.value, "faults", [None])) - 1
    return text


def test_refusals_name_the_wire_the_fault_and_the_remedy():
    source, sink = Node("source", Source(), rate="10"), Node("sink", Sink(), rate="10")
    plant, gain = Node("plant", SecondOrder()), Node("gain", Pass(), rate="10")
    other = Node("other", Pass(), rate="10")
    assert "did you mean 'y'" in refused([source, sink], [Wire("source.yy", "sink.u")])
    assert "no node 'sunk'" in refused([source, sink], [Wire("source.y", "sunk.u")])
    assert "already has a wire" in refused([source, sink, gain], [
        Wire("source.y", "gain.u"), Wire("source.y", "sink.u"), Wire("gain.y", "sink.u")])
    loop = refused([gain, other], [Wire("gain.y", "other.u"), Wire("other.y", "gain.u")])
    assert "algebraic loop" in loop
    assert "gain -> other -> gain" in loop
    assert "no wire" in refused([gain], [])
    assert "communication rate" in refused([plant, Node("second", SecondOrder())], [
        Wire("plant.y", "second.u"), Wire("second.y", "plant.u")])
    assert "is a block" in refused([source, sink], [Wire("source.y", "sink.u", rate="10")])
    for rate in ("-5", "0", "nan", True, "fast"):
        with pytest.raises(InputError, match="rate"):
            Node("source", Source(), rate=rate)
    with pytest.raises(InputError, match="sum of at least 0"):
        Wire("a.y", "b.u", latency_ms=1, jitter=Duration(kind="uniform", low_ms=-2, high_ms=2))


def test_a_latency_or_an_execution_time_opens_an_algebraic_loop():
    def wiring(latency_ms=0.0, execution=Duration()):  # noqa: B008
        gain = Node("gain", Pass(), rate="10", execution=execution)
        return Wiring([gain, Node("other", Pass(), rate="10")],
                      [Wire("gain.y", "other.u", latency_ms=latency_ms), Wire("other.y", "gain.u")])

    wiring(latency_ms=1e-6)
    wiring(execution=Duration(kind="fixed", ms=1))
    with pytest.raises(InputError, match="algebraic"):
        wiring(execution=Duration(kind="exponential", mean_ms=1, high_ms=2))


def test_coupled_plants_exchange_simultaneously():
    """Two first-order exchanges equal the hand-written Jacobi iteration, whatever the declaration."""
    def run(names):
        nodes = [Node(name, SecondOrder()) for name in names] + [Node("one", Constant1(), rate="1")]
        wires = [Wire("a.y", "b.u", rate="100"), Wire("b.y", "c.u", rate="100"), Wire("one.y", "a.u")]
        recorder = Recorder("100")
        Loop(Wiring(nodes, wires), recorder=recorder).run_until(NS_PER_S)
        return {name: recorded_output(recorder, name)[1] for name in names}

    first, second = run("abc"), run("cba")
    for name in "abc":
        assert np.array_equal(first[name], second[name])
    plant, states = SecondOrder(), {name: SecondOrder().init(None) for name in "abc"}
    for k in range(101):
        y = {name: plant.read(states[name], ())[0] for name in "abc"}
        for name in "abc":
            assert abs(first[name][k] - y[name]) < 1e-13
        for name, u in (("a", 1.0), ("b", y["a"]), ("c", y["b"])):
            plant.advance(states[name], [u], 0, 10 * NS_PER_MS)


def test_each_trial_loses_messages_of_its_own():
    nodes = [Node("source", Source(), rate="100"), Node("sink", Sink(), rate="100")]
    loop = Loop(Wiring(nodes, [Wire("source.y", "sink.u", loss=0.3)], seed=7))
    received = []
    for _ in range(2):
        loop.run_until(NS_PER_S)
        received.append([s.value for _, s in loop.states()["sink"].log])
        loop.next_trial()
    assert received[0] != received[1]


@pytest.mark.parametrize("value", [None, True, 1.5, 1.0, -1, 2**63, "1"])
def test_seeds_and_trials_are_whole_numbers(value):
    wiring = Wiring([Node("source", Source(), "10")], [])
    with pytest.raises(InputError, match="seed"):
        wiring.with_seed(value)
    with pytest.raises(InputError, match="trial"):
        Loop(wiring, trial=value)
    assert wiring.with_seed(3).seed == 3

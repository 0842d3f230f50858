"""Plants that are sampled ahead of those that hear of them, many instants at once: of themselves, too."""

from dataclasses import dataclass

import numpy as np
import pytest
from eager_loop import Ahead
from loop_parts import Memory, Sink

from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.order import upstream_first
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

TWO = (2,)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Source:
    """A level driven by `push`; says in its state how often it was called."""

    feedthrough = False
    inputs = (Port("push"), Port("back", TWO, optional=True))
    outputs = (Port("pair", TWO), Port("level"))
    grid = None

    def init(self, context):
        return Memory(x=[0, 0])

    def advance(self, state, inputs, start_ns, stop_ns):
        # Whole numbers: a plant that is split elsewhere ends up in the same bits.
        state.x[0] += int(inputs[0] + inputs[1].sum()) * (stop_ns - start_ns)
        state.x[1] += 1

    def read(self, state, inputs):
        return np.array([state.x[0], 1.0]), float(state.x[0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AheadSource(Ahead, Source):
    """The same, many instants at once."""

    def advance_through(self, state, inputs, times_ns):
        calls = state.x[1]
        # Not by super(): a dataclass with slots is another class than the one it was made of.
        stacks = Ahead.advance_through(self, state, inputs, times_ns)
        state.x[1] = calls + 1
        return stacks


class Deaf(AheadSource):
    """The same, and what comes back makes no difference."""

    ignores = ("back",)

    def advance(self, state, inputs, start_ns, stop_ns):
        super().advance(state, [inputs[0], np.zeros(2)], start_ns, stop_ns)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Follower:
    """Adds up what it is given, in steps of 1 ms."""

    feedthrough = False
    inputs = (Port("pair", TWO), Port("level"))
    outputs = (Port("sum", TWO),)
    grid = RateClock.from_rate("1000")

    def init(self, context):
        return Memory(x=np.zeros(2))

    def advance(self, state, inputs, start_ns, stop_ns):
        state.x = (3.0 * state.x + inputs[0] + inputs[1]) % 1_000_003

    def read(self, state, inputs):
        return (state.x.copy(),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pusher:
    inputs = ()
    outputs = (Port("push"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (float(tick.index % 5),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Integrator(Ahead):
    """x' = gain u from x = 1, put out twice: infinite above `most` each."""

    gain: float = -1.0
    most: tuple[float, float] = (np.inf, np.inf)
    feedthrough = False
    inputs = (Port("u"),)
    outputs = (Port("x"), Port("again"))
    grid = None

    def init(self, context):
        return Memory(x=1.0)

    def advance(self, state, inputs, start_ns, stop_ns):
        state.x += self.gain * inputs[0] * (stop_ns - start_ns) / NS_PER_S

    def read(self, state, inputs):
        return tuple(state.x if state.x <= most else np.inf for most in self.most)


class PairSink(Sink):
    @property
    def inputs(self):
        return (Port("u", TWO),)


def looped(source, *, back, plant_rate="300", stops=(100,), level_rate="1000"):
    nodes = [Node("pusher", Pusher(), rate="320"), Node("source", source), Node("follower", Follower()),
             Node("sink", PairSink(), rate="100")]
    wires = [Wire("pusher.push", "source.push"), Wire("source.pair", "follower.pair", rate="1000"),
             Wire("source.level", "follower.level", rate=level_rate, latency_ms=1.5),
             Wire("follower.sum", "sink.u"),
             *([Wire("follower.sum", "source.back", rate="1000")] if back else [])]
    recorder = Recorder(plant_rate)
    loop = Loop(Wiring(nodes, wires), recorder=recorder)
    for stop_ms in stops:
        loop.run_until(stop_ms * NS_PER_MS)
    return loop, recorder


def told(recorder):
    """All that was recorded, as plain values."""
    plants = {name: [(times, captured, [np.asarray(stack).tolist() for stack in stacks])
                     for times, captured, stacks in rows] for name, rows in recorder.plants.items()}
    flat = {name: ([t for row in rows for t in row[0]], [t for row in rows for t in row[1]],
                   [[value for row in rows for value in row[2][port]] for port in range(len(rows[0][2]))])
            for name, rows in plants.items()}
    inputs = {name: [(*row[:4], np.asarray(row[4]).tolist()) for row in rows]
              for name, rows in recorder.inputs.items()}
    blocks = {name: [(*row[:5], [np.asarray(value).tolist() for value in row[5]]) for row in rows]
              for name, rows in recorder.blocks.items()}
    return flat, inputs, blocks


def in_stretches(wiring, stretch_ms, until_ms=1000):
    loop = Loop(wiring)
    for stop_ms in [*range(0, until_ms, stretch_ms), until_ms]:
        loop.run_until(stop_ms * NS_PER_MS)
    return loop


@pytest.mark.parametrize("stretch_ms", [1000, 10, 7, 340])
@pytest.mark.parametrize("late", [0, 1, 3])
def test_a_plant_hears_itself_on_the_way(late, stretch_ms):
    """x' = -u, and u is x by a wire at 100 Hz, `late` samples ago: x(1 s) = 0.99^100 if at once."""
    wires = [Wire("plant.x", "plant.u", rate="100", latency_ms=10 * late)]
    x = [1.0]
    for k in range(100):
        x.append(x[k] - 0.01 * (x[k - late] if k >= late else 0.0))
    found = in_stretches(Wiring([Node("plant", Integrator())], wires), stretch_ms).states()["plant"].x
    assert found == pytest.approx(x[-1], rel=1e-12)
    if late == 0:
        assert found == pytest.approx(0.99**100, rel=1e-12)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("stretch_ms", [1000, 10, 7])
def test_a_ring_of_plants_goes_round(stretch_ms, count):
    """Each is fed by the one before it: over h = 10 ms, x becomes x - h (x, shifted round)."""
    nodes = [Node(f"p{k}", Integrator(gain=-1.0 - k)) for k in range(count)]
    wires = [Wire(f"p{k}.x", f"p{(k + 1) % count}.u", rate="100") for k in range(count)]
    states = in_stretches(Wiring(nodes, wires), stretch_ms).states()
    step = np.eye(count) - 0.01 * np.diag(np.arange(1.0, count + 1)) @ np.roll(np.eye(count), 1, axis=0)
    expected = np.linalg.matrix_power(step, 100) @ np.ones(count)
    assert [states[node.name].x for node in nodes] == pytest.approx(expected.tolist(), rel=1e-12)


@pytest.mark.parametrize("stretch_ms", [1000, 10])
def test_what_is_not_finite_first_is_what_ends_the_run(stretch_ms):
    nodes = [Node("pusher", Pusher(), rate="10"), Node("plant", Integrator(gain=100.0, most=(4.0, 2.0))),
             Node("one", Integrator()), Node("two", Integrator())]
    wires = [Wire("pusher.push", "plant.u"), Wire("plant.x", "one.u", rate="100"),
             Wire("plant.again", "two.u", rate="100")]
    with pytest.raises(RunError, match=r"plant\.again is not finite at 120\.000000 ms"):
        in_stretches(Wiring(nodes, wires), stretch_ms)


class OneByOne(Integrator):
    """Without `advance_through`, which `offers` would find."""

    def __getattribute__(self, name):
        if name == "advance_through":
            raise AttributeError(name)
        return super().__getattribute__(name)


@pytest.mark.parametrize("plant_rate", ["300", "20"])
@pytest.mark.parametrize("most", [(4.0, np.inf), (4.0, 6.0)])
def test_a_plant_that_fails_on_the_way_leaves_the_record_of_one_that_goes_from_sample_to_sample(
    most, plant_rate
):
    records = []
    for kind in (OneByOne, Integrator):
        nodes = [Node("pusher", Pusher(), rate="320"), Node("plant", kind(gain=100.0, most=most)),
                 Node("one", Integrator()), Node("sink", Sink(), rate="10")]
        wires = [Wire("pusher.push", "plant.u"), Wire("plant.x", "one.u", rate="1000"),
                 Wire("one.x", "sink.u", rate="1000")]
        recorder = Recorder(plant_rate)
        with pytest.raises(RunError, match="not finite"):
            Loop(Wiring(nodes, wires), recorder=recorder).run_until(NS_PER_S)
        records.append((recorder.events, recorder.inputs["plant"],
                        [times for times, _, _ in recorder.plants["plant"]]))
    (events, inputs, times), (events_of, inputs_of, times_of) = records
    assert (events_of, inputs_of) == (events, inputs)
    assert [t for row in times_of for t in row] == [t for row in times for t in row]


@pytest.mark.parametrize("stops", [(100,), (7, 31, 32, 100)])
@pytest.mark.parametrize("plant_rate", ["300", "1000", "77"])
@pytest.mark.parametrize("level_rate", ["1000", "700"])
def test_many_instants_at_once_are_what_one_after_another_are(plant_rate, stops, level_rate):
    (one, by_one), (many, by_many) = (
        looped(source, back=False, plant_rate=plant_rate, stops=stops, level_rate=level_rate)
        for source in (Source(), AheadSource()))
    assert told(by_many) == told(by_one)
    assert many.states()["source"].x[0] == one.states()["source"].x[0] > 0


def test_a_stretch_goes_from_one_reading_to_the_next():
    calls = [looped(source, back=False, plant_rate=None)[0].states()["source"].x[1]
             for source in (Source(), AheadSource())]
    # One after another: 100 samples and 32 changes of the input, four of them with a sample. At once: eleven
    # readings, and the two changes (at 40.625 and 90.625 ms) between a reading and the sample after it.
    assert calls == [100 + 32 - 4, 11 + 2]


def test_what_comes_back_ties_plants_to_each_other_unless_it_is_ignored():
    heard = {kind: told(looped(kind(), back=True)[1]) for kind in (Source, AheadSource, Deaf)}
    assert heard[AheadSource] == heard[Source]
    assert heard[Deaf][0]["source"] == told(looped(Source(), back=False)[1])[0]["source"]
    assert heard[Deaf][0]["source"] != heard[Source][0]["source"]


def test_what_is_ignored_is_not_sampled():
    loop, recorder = looped(Deaf(), back=True)
    counts = loop.message_counts()
    assert counts["follower.sum->source.back"]["sent"] == 0
    assert counts["source.pair->follower.pair"]["sent"] == 101
    assert {row[1] for row in recorder.inputs["source"]} == {0}


def test_plants_are_told_apart_by_whom_they_hear():
    nodes = [Node(name, Follower() if name == "last" else Source()) for name in ("a", "b", "last")]
    wires = [Wire("a.pair", "b.back", rate="100"), Wire("b.pair", "a.back", rate="100"),
             Wire("a.pair", "last.pair", rate="100"), Wire("a.level", "last.level", rate="100")]
    pushes = [Wire("pusher.push", "a.push"), Wire("pusher.push", "b.push")]
    wiring = Wiring([Node("pusher", Pusher(), rate="10"), *nodes], [*pushes, *wires])
    assert upstream_first({"a", "b", "last"}, wiring.connections) == [{"a", "b", "last"}]
    assert upstream_first({"a", "last"}, wiring.connections) == [{"a"}, {"last"}]
    assert upstream_first({"b"}, wiring.connections) == [{"b"}]

"""Join: rows under each other, their stamps through the loop, and what does not fit."""

import numpy as np
import pytest
from loop_parts import Memory

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Port, Sample, Sensors
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.join import Join


def sample(rows, arrived=0):
    return Sample(np.asarray(rows, dtype=float), arrived, arrived, arrived)


def test_rows_stand_in_the_order_of_the_inputs():
    join = Join(unit="T").resolve({"first": (2, 3), "second": (1, 3)})
    joined, = join.step(join.init(None), (sample([[1, 2, 3], [4, 5, 6]]), sample([[7, 8, 9]])), Tick())
    np.testing.assert_array_equal(joined, [[1, 2, 3], [4, 5, 6], [7, 8, 9]])
    assert [port.shape for port in (*join.inputs, *join.outputs)] == [(2, 3), (1, 3), (3, 3)]


def test_what_has_not_arrived_is_nan_and_named_once():
    join = Join(unit="T", sources=3, rows=(1, 1, 2))
    state, tick = join.init(None), Tick()
    nothing = Sample(np.zeros((1, 3)), NEVER, NEVER, NEVER)
    given = (sample([[1, 2, 3]]), nothing, sample(np.ones((2, 3))))
    for _ in range(2):
        joined, = join.step(state, given, tick)
    np.testing.assert_array_equal(np.isnan(joined).all(axis=1), [False, True, False, False])
    assert tick.reports == [("waiting", "nothing has arrived at second")]


class Stamped:
    """Sends its instant, ms, in every row."""

    inputs = ()

    def __init__(self, rows):
        self.outputs = (Port("y", (rows, 3), "T"),)

    def init(self, context):
        return Memory()

    def step(self, state, inputs, tick):
        return (np.full(self.outputs[0].shape, tick.time_ns / NS_PER_MS),)


def test_a_late_wireless_sensor_stands_beside_the_strips_and_stamps_say_so():
    """16 sensors by cable, one 10 ms late and with loss: the oldest stamp is the wireless one's."""
    nodes = [Node("strips", Stamped(16), rate="100"), Node("forearm", Stamped(1), rate="100"),
             Node("join", Join(unit="T"), rate="100")]
    wires = [Wire("strips.y", "join.first"), Wire("forearm.y", "join.second", latency_ms=10.0, loss=0.2)]
    recorder = Recorder()
    Loop(Wiring(nodes, wires, seed=4), recorder=recorder).run_until(1000 * NS_PER_MS)
    rows = recorder.blocks["join"]
    assert len(rows) == 101
    ages = []
    for _, time, _, oldest, newest, (joined,) in rows[3:]:
        assert joined.shape == (17, 3)
        assert newest == time
        assert joined[0, 0] == newest / NS_PER_MS
        assert joined[16, 0] == oldest / NS_PER_MS
        ages.append(time - oldest)
    assert min(ages) == 10 * NS_PER_MS
    assert max(ages) > 10 * NS_PER_MS
    assert np.isnan(rows[0][-1][0][16]).all()


@pytest.mark.parametrize(("parameters", "name"), [
    ({"sources": 1}, "sources"), ({"columns": -1}, "columns"), ({"rows": (1, 0)}, "rows"),
    ({"rows": (1, 2, 3)}, "rows")])
def test_parameters_that_cannot_be_are_named(parameters, name):
    with pytest.raises(InputError, match=name):
        Join(unit="T", **parameters)


def test_a_signal_that_has_no_such_rows_is_refused():
    with pytest.raises(InputError, match=r"second: a signal of shape \(3,\)"):
        Join(unit="T").resolve({"first": (2, 3), "second": (3,)})


def test_vectors_are_joined_where_there_are_no_columns():
    join = Join(unit="1", columns=0).resolve({"first": (2,), "second": (1,)})
    tick = Tick()
    here, nothing = Sample(np.array([1.0, 2.0]), 0, 0, 0), Sample(np.zeros(1), NEVER, NEVER, NEVER)
    joined, = join.step(join.init(Context("join")), (here, nothing), tick)
    np.testing.assert_array_equal(joined, [1.0, 2.0, np.nan])
    with pytest.raises(InputError, match=r"a vector: shape \(k,\)"):
        Join(unit="1", columns=0).resolve({"first": (2, 1), "second": (1,)})


class Worn:
    """Puts out samples of named sensors."""

    inputs = ()

    def __init__(self, names, pairs):
        sensors = Sensors(tuple(names), tuple(pairs)) if names else None
        self.outputs = (Port("y", (len(names) or 2, 3), "T", sensors=sensors),)

    def init(self, context):
        return Memory()


@pytest.mark.parametrize(("first", "second", "names", "pairs"), [
    ((("a", "b"), ((1, 0),)), (("c", "d"), ((0, 1),)), ("a", "b", "c", "d"), ((1, 0), (2, 3))),
    ((("imu",), ()), (("imu", "x"), ((1, 0),)), ("first.imu", "second.imu", "x"), ((2, 1),)),
    ((("hand",), ()), (("F2m", "F2p"), ((1, 0),)), ("hand", "F2m", "F2p"), ((2, 1), (0, 2))),
    ((("a",), ()), ((), ()), None, None)])
def test_sensors_of_all_inputs_are_stated(first, second, names, pairs):
    nodes = [Node("one", Worn(*first), rate=100), Node("two", Worn(*second), rate=100),
             Node("join", Join(unit="T"), rate=100)]
    wiring = Wiring(nodes, [Wire("one.y", "join.first"), Wire("two.y", "join.second")])
    (joined,) = next(node for node in wiring.nodes if node.name == "join").part.outputs
    assert joined.sensors == (None if names is None else Sensors(names, pairs))

"""What has ended does not go on, and an observer is one wherever it stands."""

import numpy as np
import pytest
from loop_parts import ImpulseProbe, Pass, PeersPi, SecondOrder, Sink

from fesloop.errors import InputError, RunError, SnapshotError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


class Glitch(ImpulseProbe):
    """Not finite at 20 ms alone."""

    def read(self, state, inputs):
        return (float("nan") if state.x == 20 * NS_PER_MS else 1.0,)


def feedback(plant, seed=0):
    nodes = [Node("plant", plant), Node("gain", Pass(), rate="100")]
    return Wiring(nodes, [Wire("plant.y", "gain.u"), Wire("gain.y", "plant.u", latency_ms=1)], seed)


def test_a_failed_loop_goes_on_from_a_snapshot_only():
    loop = Loop(feedback(Glitch()))
    loop.run_until(10 * NS_PER_MS)
    snapshot = loop.snapshot()
    with pytest.raises(RunError, match="not finite"):
        loop.run_until(NS_PER_S)
    for again in (lambda: loop.run_until(NS_PER_S), loop.next_trial):
        with pytest.raises(RunError, match="has failed"):
            again()
    with pytest.raises(SnapshotError, match="has failed"):
        loop.snapshot()
    loop.restore(snapshot)
    loop.run_until(15 * NS_PER_MS)


def test_a_closed_loop_does_not_run():
    loop = Loop(feedback(ImpulseProbe()))
    loop.close()
    loop.close()
    with pytest.raises(RunError, match="is closed"):
        loop.run_until(NS_PER_S)


def test_a_snapshot_of_another_wiring_is_refused():
    snapshot = Loop(feedback(ImpulseProbe())).snapshot()
    for other in (feedback(ImpulseProbe(), seed=1), feedback(SecondOrder())):
        with pytest.raises(SnapshotError, match="another wiring"):
            Loop(other).restore(snapshot)


@pytest.mark.slow
def test_a_block_that_watches_the_plant_itself_changes_no_bit():
    def rows(watched):
        nodes = [Node("plant", SecondOrder()), Node("pi", PeersPi(), rate="50")]
        wires = [Wire("plant.y", "pi.y", latency_ms=30, rate="100"), Wire("pi.u", "plant.u")]
        if watched:
            nodes += [Node("watch", Pass(), rate="30"), Node("end", Sink(), rate="285.714")]
            wires += [Wire("plant.y", "watch.u"), Wire("watch.y", "end.u", latency_ms=1)]
        recorder = Recorder("1000")
        Loop(Wiring(nodes, wires), recorder=recorder).run_until(2 * NS_PER_S)
        return recorder.blocks["pi"]

    assert rows(False) == rows(True)


@pytest.mark.slow
@pytest.mark.parametrize("stretch", [1_000_000, 333_333, 77_777_777])
def test_what_is_recorded_does_not_depend_on_stretches(stretch):
    """Of a plant without a way to observe it too."""
    def recorded(step):
        recorder = Recorder("1000")
        nodes = [Node("plant", SecondOrder()), Node("pi", PeersPi(), rate="50")]
        wires = [Wire("plant.y", "pi.y", rate="100"), Wire("pi.u", "plant.u", latency_ms=2)]
        loop, now = Loop(Wiring(nodes, wires), recorder=recorder), -1
        while now < NS_PER_S:
            now = min(NS_PER_S, now + step)
            loop.run_until(now)
        return np.concatenate([row[2][0] for row in recorder.plants["plant"]])

    np.testing.assert_array_equal(recorded(stretch), recorded(2 * NS_PER_S))


def test_a_block_that_leaves_its_size_open_is_refused():
    class Open(Sink):
        inputs = (Port("u", (None,)),)

        def resolve(self, shapes):
            return self

    class Vector(Pass):
        inputs = ()
        outputs = (Port("y", (3,)),)

    nodes = [Node("vector", Vector(), rate="10"), Node("open", Open(), rate="10")]
    with pytest.raises(InputError, match="open: leaves open a size"):
        Wiring(nodes, [Wire("vector.y", "open.u")])

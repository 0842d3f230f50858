"""The hand between what activates it and its sensors, on the loop's clock."""

from dataclasses import dataclass

import numpy as np
import pytest

import fesloop
from fesloop import Recording
from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.hand import Hand
from plants.imus import Imus


@dataclass(frozen=True)
class Activating:
    """Puts out an activation that is `level` from its tick `first` on, and a forearm's orientation."""

    level: float = 0.05
    first: int = 3
    forearm: tuple[float, ...] = (0.0, 0.6, 0.0, -0.8)
    inputs = ()
    outputs = (Port("activation", (29,), "1"), Port("forearm", (4,), "1"))

    def init(self, context):
        return [0]

    def step(self, state, inputs, tick):
        return np.full(29, self.level if tick.index >= self.first else 0.0), np.array(self.forearm)


def wiring(hand, **source):
    wires = [Wire("source.activation", "hand.activation", latency_ms=1.0)]
    wires += [Wire("source.forearm", "hand.forearm", latency_ms=1.0)] if hand.forearm_moves else []
    wires += [Wire(f"hand.site_{name}", f"imus.site_{name}")
              for name in ("orientation", "position", "rate", "force")]
    nodes = [Node("source", Activating(**source), rate="50"), Node("hand", hand),
             Node("imus", Imus(preset="ideal"), rate="100")]
    return Wiring(nodes, wires)


def gyr(recorder):
    return np.array([row[-1][0] for row in recorder.blocks["imus"]])


def test_who_else_looks_changes_no_bit_and_a_snapshot_goes_on_as_if_never_interrupted():
    hand, seen = Hand(forearm_moves=True), []
    for plant_rate in (None, "1000", "70"):
        recorder = Recorder(plant_rate=plant_rate)
        loop = Loop(wiring(hand), recorder=recorder)
        loop.run_until(100 * NS_PER_MS)
        snapshot = loop.snapshot()
        loop.run_until(200 * NS_PER_MS)
        seen.append(gyr(recorder))
    assert np.abs(seen[0][-1]).max() > 0.1
    assert all(np.array_equal(seen[0], other) for other in seen)
    again = Recorder(plant_rate=None)
    loop = Loop(wiring(hand), recorder=again)
    loop.restore(snapshot)
    loop.run_until(200 * NS_PER_MS)
    assert np.array_equal(gyr(again), seen[0][-len(gyr(again)):])


def test_activation_acts_from_the_step_after_it_arrives():
    recorder = Recorder(plant_rate="1000")
    loop = Loop(wiring(Hand()), recorder=recorder)
    loop.run_until(70 * NS_PER_MS)
    times = np.concatenate([row[0] for row in recorder.plants["hand"]])
    force = np.concatenate([row[2][9] for row in recorder.plants["hand"]])  # fibre velocities
    rest = Recorder(plant_rate="1000")
    Loop(wiring(Hand(), level=0.0), recorder=rest).run_until(70 * NS_PER_MS)
    idle = np.concatenate([row[2][9] for row in rest.plants["hand"]])
    differs = np.flatnonzero((force != idle).any(axis=1))
    # Tick 3 of 50 Hz is at 60 ms; a millisecond on the wire, and the step that ends at 62 ms is the first.
    assert times[differs[0]] == 62 * NS_PER_MS


def test_a_forearm_that_is_no_orientation_ends_the_run_by_name():
    loop = Loop(wiring(Hand(forearm_moves=True), forearm=(0.0, 0.0, 0.0, 0.0)))
    with pytest.raises(RunError, match=r"hand\.forearm"):
        loop.run_until(50 * NS_PER_MS)


def test_the_hand_of_a_recording_moves_as_it_did_bit_for_bit(tmp_path):
    """A recording keeps its tables in the order of their keys; constraints have one order all the same."""
    result = fesloop.load("open_close", ["experiment.duration_s=0.2"]).run(tmp_path)
    repeated = fesloop.load(result.recording).run(tmp_path)
    assert Recording(repeated.recording).digest() == Recording(result.recording).digest()

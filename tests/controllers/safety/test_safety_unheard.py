"""Stimulation that derives from no measurement is not fresh to the safety block."""

from dataclasses import dataclass

import numpy as np
import pytest
from loop_parts import Source

from controllers.safety import Safety
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

MAX_AGE_MS = 200.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Assuming:
    """Commands the same pulse whatever has arrived."""

    inputs = (Port("reference"), Port("measured"))
    outputs = (Port("stimulation", (1, 2), "A,s"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.array([[10e-3, 200e-6]]),)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tracker(Source):
    """Hears a sensor, and puts out a posture whether anything has come or not."""

    inputs = (Port("sensed"),)


def given(sensed_ms, tracked_ms):
    """Events of safety, and (instant, stamps, charge) of each of its outputs in a second."""
    nodes = [Node("reference", Source(), "40"), Node("sensor", Source(), "100"),
             Node("tracker", Tracker(), "100"), Node("controller", Assuming(), "40"),
             Node("safety", Safety(max_age_ms=MAX_AGE_MS, ramp_ms=0.0), "40")]
    wires = [Wire("reference.y", "controller.reference"),
             Wire("sensor.y", "tracker.sensed", latency_ms=sensed_ms),
             Wire("tracker.y", "controller.measured", latency_ms=tracked_ms),
             Wire("controller.stimulation", "safety.stimulation")]
    recorder = Recorder()
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(NS_PER_S)
    return ([(event[0], event[2]) for event in recorder.events if event[1] == "safety"],
            [(row[1], row[3:5], row[5][0].prod()) for row in recorder.blocks["safety"]])


@pytest.mark.parametrize(("sensed_ms", "tracked_ms"), [(0.0, 5000.0), (5000.0, 0.0)])
def test_a_command_of_a_controller_that_never_heard_a_sensor_is_withheld(sensed_ms, tracked_ms):
    """Whether its tracker, or the tracker's sensor, is the one that is never heard."""
    events, outputs = given(sensed_ms, tracked_ms)
    assert events == [(225 * NS_PER_MS, "stale_input")]
    assert all((charge > 0.0) == (at <= MAX_AGE_MS * NS_PER_MS) for at, _, charge in outputs)
    assert all(stamps[0] == 0 for _, stamps, _ in outputs)


def test_it_is_fresh_once_the_first_measurement_has_come():
    events, outputs = given(30.0, 60.0)
    assert events == []
    for at, stamps, _ in outputs:
        assert stamps[0] == max(0, at - (90 + at // NS_PER_MS % 10) * NS_PER_MS)

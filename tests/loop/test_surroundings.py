"""What a block is told of its place before a run, held against the run itself."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.reference import MinimumJerk
from controllers.safety import Safety
from estimators.ideal import IdealTracker
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.loop.cautions import faults_in_place
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.finger import Finger

NS_PER_MS = 1_000_000
MOVES = MinimumJerk(times_s=(0.1, 0.4), angles_deg=((20.0, 25.0, 15.0), (40.0, 55.0, 25.0)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """Tells what it was told; its stimulation is none."""

    told: list = field(default_factory=list)

    @property
    def inputs(self):
        return Port("reference", (3,), "rad", optional=True), Port("measured", (3,), "rad")

    @property
    def outputs(self):
        return (Port("stimulation", (4, 2), "A,s"),)

    def faults(self, context, surroundings):
        self.told.append((context, surroundings))
        return (InputError("gain", "1", "2", "set it to 2"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.zeros((4, 2)),)


def wiring(block, upstream_ms=7.0, downstream_ms=5.0, rate="40"):
    nodes = [Node("reference", MOVES, "50"), Node("asked", block, rate), Node("safety", Safety(), rate),
             Node("finger", Finger()), Node("tracker", IdealTracker(noise_deg=0.0), "100")]
    wires = [Wire("reference.angles", "asked.reference"), Wire("asked.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=downstream_ms),
             Wire("finger.angles", "tracker.angles"),
             Wire("tracker.angles", "asked.measured", latency_ms=upstream_ms)]
    return Wiring(nodes, wires, seed=1)


def test_faults_are_named_by_the_key_of_an_experiment_file():
    block = Asked()
    (fault,) = faults_in_place(wiring(block), 10**9)
    assert str(fault) == "blocks.asked.gain: 1; allowed: 2; set it to 2"
    ((context, surroundings),) = block.told
    assert (context.name, str(context.clock)) == ("asked", str(wiring(block).nodes[1].clock))
    assert surroundings.way == "finger.angles -> tracker -> asked -> safety -> finger.stimulation"


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 120), st.integers(0, 40), st.sampled_from(["40", "50", "100"]))
def test_the_delay_of_the_loop_is_the_least_sum_of_wires_and_waits(upstream_ms, downstream_ms, rate):
    block = Asked()
    if upstream_ms + downstream_ms == 0:
        downstream_ms = 1
    faults_in_place(wiring(block, upstream_ms, downstream_ms, rate), 10**9)
    period_ms = 1000 // int(rate)
    # A sample of the tracker's tick k (every 10 ms) waits for the next tick of the controller.
    waits = [-(-(10 * k + upstream_ms) // period_ms) * period_ms - 10 * k for k in range(100)]
    assert block.told[0][1].loop_ns == (min(waits) + downstream_ms) * NS_PER_MS


@pytest.mark.slow
def test_what_a_source_will_put_out_is_what_it_puts_out():
    block = Asked()
    faults_in_place(wiring(block), 500 * NS_PER_MS)
    recorder = Recorder("100")
    loop = Loop(wiring(block), recorder=recorder)
    loop.run_until(500 * NS_PER_MS)
    put_out = np.array([row[5][0] for row in recorder.blocks["reference"]])
    coming = block.told[0][1].coming
    assert set(coming) == {"reference"}
    np.testing.assert_array_equal(coming["reference"], put_out[:coming["reference"].shape[0]])
    assert coming["reference"].shape[0] == 25


@pytest.mark.parametrize(("setting", "named"), [
    ("latency_ms=250", "blocks.controller.horizon: 12 periods of 20 ms end before the delay of 275 ms does"),
    ("blocks.controller.angle_max_deg=[30, 50, 50]", "blocks.controller.angle_max_deg: the box of output 0"),
    ("blocks.controller.drive_max=0.001", "blocks.controller.drive_max: 0.001"),
    ("blocks.controller.charge_rise_uc=0.02", "blocks.controller.charge_rise_uc: 0.02 uC a tick")])
def test_check_refuses_in_one_line_what_cannot_work(setting, named, capsys):
    assert main(["check", "finger_mpc", "--set", setting]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    (line,) = told.err.strip().splitlines()
    assert named in line

"""FMUs in the loop: in the finger's place, saved and resumed, failing in mid-run."""

import math
from dataclasses import replace

import numpy as np
import pytest
from loop_parts import Pass, Sink, Source

from fesloop.errors import RunError, SnapshotError
from fesloop.experiment.files.parse import load
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.fmu import Fmu
from plants.fmu.ports import FmuPort


def recorded(wiring, time_ns):
    """Rows of every block over a run."""
    recorder = Recorder(None)
    loop = Loop(wiring, recorder=recorder)
    try:
        loop.run_until(time_ns)
    finally:
        loop.close()
    return recorder.blocks


def in_the_fingers_place(plant):
    """The shipped PID experiment on another plant."""
    experiment = load("finger_pid_latency")
    nodes = [replace(node, part=plant) if node.name == "finger" else node for node in experiment.nodes]
    return Wiring(nodes, experiment.wires, experiment.seed)


def feedback(plant, rate="100"):
    """A plant with input u and output y under proportional feedback."""
    nodes = [Node("plant", plant), Node("gain", Pass(gain=-2.0), rate=rate), Node("sink", Sink(), rate=rate)]
    return Wiring(nodes, [Wire("plant.y", "gain.u", latency_ms=20), Wire("gain.y", "plant.u"),
                          Wire("plant.y", "sink.u")])


@pytest.mark.slow
@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_an_fmu_takes_the_fingers_place(finger_fmu, interface):
    experiment = load("finger_pid_latency")
    expected = recorded(Wiring(experiment.nodes, experiment.wires, experiment.seed), 3 * NS_PER_S)
    found = recorded(in_the_fingers_place(Fmu(path=str(finger_fmu), interface=interface)), 3 * NS_PER_S)
    one, other = (np.array([row[5][0] for row in blocks["tracker"]]) for blocks in (expected, found))
    assert np.ptp(one, axis=0).max() > 0.2
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-8)
    assert [row[:5] for row in found["controller"]] == [row[:5] for row in expected["controller"]]


@pytest.mark.slow
def test_a_snapshot_in_the_loop_is_exact():
    loop = Loop(in_the_fingers_place(Fmu(path="shipped:finger")), recorder=Recorder(None))
    loop.run_until(1_234 * NS_PER_MS)
    snapshot = loop.snapshot()
    loop.recorder.drain()
    loop.run_until(2 * NS_PER_S)
    through = [(row[1], np.asarray(row[5][0]).tolist()) for row in loop.recorder.drain()[0]["tracker"]]
    loop.restore(snapshot)
    loop.run_until(2 * NS_PER_S)
    again = [(row[1], np.asarray(row[5][0]).tolist()) for row in loop.recorder.drain()[0]["tracker"]]
    loop.close()
    assert len(through) == 77
    assert again == through


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_python_made_fmus_run_in_the_loop(python_fmu, version):
    plant = Fmu(path=str(python_fmu(version)), step_rate="500")
    nodes = [Node("ramp", Source(), rate="100"), Node("plant", plant), Node("read", Pass(), rate="100")]
    rows = recorded(Wiring(nodes, [Wire("ramp.y", "plant.u"), Wire("plant.y", "read.u")]), NS_PER_S)["read"]
    y, expected = 0.0, []
    for k in range(101):
        expected.append(y)
        y = k + (y - k) * math.exp(-0.01 / 0.1)
    np.testing.assert_allclose([row[5][0] for row in rows], expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("scale", [1.0, 57.3])
def test_the_start_value_of_an_input_holds_until_its_first_message(small2, scale):
    plant = Fmu(path=str(small2()), starts={"u": 3.0}, isolate=False,
                input_ports=(FmuPort(name="u", variables=("u",), scale=scale),))
    nodes = [Node("source", Pass(gain=0.0), rate="100"), Node("plant", plant),
             Node("read", Pass(), rate="100")]
    wires = [Wire("read.y", "source.u"), Wire("source.y", "plant.u", latency_ms=50),
             Wire("plant.y", "read.u")]
    rows = recorded(Wiring(nodes, wires), 200 * NS_PER_MS)["read"]
    times = 0.01 * np.arange(len(rows))
    reached = 3.0 * (1.0 - math.exp(-0.5))
    expected = np.where(times <= 0.05, 3.0 * (1.0 - np.exp(-times / 0.1)),
                        reached * np.exp(-(times - 0.05) / 0.1))
    np.testing.assert_allclose([row[5][0] for row in rows], expected, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_an_fmu_that_cannot_replay_refuses_the_snapshot(python_fmu):
    loop = Loop(feedback(Fmu(path=str(python_fmu(3)), step_rate="500")))
    loop.run_until(100 * NS_PER_MS)
    with pytest.raises(SnapshotError, match="plant: the state of LagPython3"):
        loop.snapshot()
    loop.run_until(200 * NS_PER_MS)
    loop.close()


@pytest.mark.slow
def test_a_failure_in_mid_run_leaves_what_was_recorded(small2):
    recorder = Recorder(None)
    plant = Fmu(path=str(small2("ERROR_AT_S=0.25")), step_rate="100")
    loop = Loop(feedback(plant), recorder=recorder)
    with pytest.raises(RunError, match=r"plant: fmi2DoStep returned fmi2Error at 0\.25 s: dry at 0\.250 s"):
        loop.run_until(NS_PER_S)
    loop.close()
    assert len(recorder.blocks["sink"]) == 26

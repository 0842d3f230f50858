"""Whatever is wired to an input whose size is open works, or is refused in one line."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.pid import Pid
from estimators.error_replay import ErrorReplay
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.metrics.joints import joint_rmse_deg, split_error
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.models.error_process import ErrorProcess, ErrorSeries
from plants.linear import StateSpace

shapes = st.one_of(st.just(()), st.lists(st.integers(1, 4), min_size=1, max_size=3).map(tuple))


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """Puts out a value of some shape."""

    shape: tuple[int, ...]
    unit: str
    inputs = ()

    @property
    def outputs(self):
        return (Port("y", self.shape, self.unit),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (0.1 * tick.index if self.shape == () else np.full(self.shape, 0.1 * tick.index),)


def open_blocks():
    """A block of each kind that has inputs of open size and needs no parameter."""
    found = []
    for kind in registry.kinds():
        try:
            part = registry.find(kind)()
        except (TypeError, InputError):
            continue
        outside = any(hasattr(part, member) for member in ("close", "attach"))
        if not outside and any(not port.resolved for port in part.inputs):
            found.append((kind, part))
    return found


OPEN = open_blocks()


def test_there_are_such_blocks():
    assert {"ideal", "safety", "grip_force", "stimulator"} <= {kind for kind, _ in OPEN}


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_any_shape_at_any_open_input_is_taken_or_refused_in_one_line(data):
    _, part = data.draw(st.sampled_from(OPEN), label="block")
    rate = None if getattr(part, "clock", None) is not None or hasattr(part, "advance") else "50"
    nodes, wires = [Node("block", part, rate)], []
    for port in part.inputs:
        if port.optional and not data.draw(st.booleans()):
            continue
        shape = data.draw(shapes) if None in port.shape else port.shape
        nodes.append(Node(port.name, Numbers(shape=shape, unit=port.unit), "50"))
        wires.append(Wire(f"{port.name}.y", f"block.{port.name}"))
    wiring = None
    try:
        wiring = Wiring(nodes, wires)
        Loop(wiring)
    except InputError as fault:
        faults = getattr(fault, "faults", [fault])
    if wiring is None:
        assert all(str(fault).count("\n") == 0 and "allowed" in str(fault) for fault in faults)
        return
    for connection in wiring.connections:
        given_, taken = (connection.source.part.outputs[0].shape,
                         connection.target.part.inputs[connection.target_port].shape)
        assert given_ == taken or (given_, taken) == ((), (1,))


def loop_of_one(tracker, through):
    plant = StateSpace(a=((-2.0,),), b=((2.0,),), c=((1.0,),), output_unit="rad",
                       initial_state=(0.5,))
    control = Pid(kp=(1.0,), ki=(0.0,), kd=(0.0,), mixing=((1.0,),), current_ma=(20.0,),
                  recruitment_curve="linear")
    nodes = [Node("plant", plant), Node("tracker", tracker, "100"), Node("control", control, "100"),
             Node("wanted", Numbers(shape=(), unit="rad"), "100"),
             Node("u", Numbers(shape=(), unit="1"), "10")]
    wires = [Wire("plant.y", "tracker.angles"), Wire("wanted.y", "control.reference"), Wire("u.y", "plant.u"),
             Wire("tracker.angles" if through else "plant.y", "control.measured")]
    return Wiring(nodes, wires)


@pytest.mark.parametrize("through", [True, False])
def test_a_plant_of_one_output_is_tracked_and_controlled(through):
    recorder = Recorder("100")
    Loop(loop_of_one(IdealTracker(), through), recorder=recorder).run_until(500_000_000)
    rows = recorder.blocks["tracker"]
    tracked = np.array([row[5][0] for row in rows])
    assert tracked.shape == (51, 1)
    assert tracked[0, 0] == pytest.approx(0.5)
    wanted = np.array([row[5][0] for row in recorder.blocks["wanted"]])
    pulses = np.array([row[5][0] for row in recorder.blocks["control"]])
    np.testing.assert_allclose(pulses[:, 0, 1], 500e-6 * (wanted - tracked[:, 0]))


def test_error_replay_takes_a_plant_of_one_output():
    process = ErrorProcess(series=(ErrorSeries(name="a.z", fast_deg=1.0, fast_s=0.2),))
    recorder = Recorder("100")
    Loop(loop_of_one(ErrorReplay(process=process), True), recorder=recorder).run_until(100_000_000)
    assert {row[5][0].shape for row in recorder.blocks["tracker"]} == {(1,)}


def test_a_number_is_scored_against_a_vector_of_one():
    times = np.arange(100) * 10_000_000
    truth, wanted = np.linspace(0.0, 1.0, 100), np.linspace(0.5, 1.5, 100)
    column = (times, wanted[:, None])
    np.testing.assert_allclose(joint_rmse_deg([((times, truth), column)]), np.degrees(0.5))
    split = split_error((times, truth), (times, truth[:, None]), column)
    np.testing.assert_allclose([split.total, split.tracker, split.controller], np.degrees([0.5, 0.0, 0.5]))

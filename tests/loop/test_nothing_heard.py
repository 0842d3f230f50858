"""Until something has been heard nothing is said: no value stands in for one that nobody measured."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Memory, Sink, Source

import fesloop
from fesloop.loop.clock import FOREVER, NS_PER_MS
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Port, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@given(st.integers(0, 2**61), st.integers(0, 10**12))
def test_an_input_that_was_never_heard_is_older_than_any_limit(now_ns, age_ns):
    assert Sample(0.0, NEVER, NEVER, NEVER).age_ns(now_ns) == FOREVER
    assert Sample(0.0, now_ns, now_ns, now_ns).age_ns(now_ns + age_ns) == age_ns


class Waiting:
    """Passes on what it has heard."""

    inputs = (Port("u"),)
    outputs = (Port("y"),)

    def init(self, context):
        return Memory()

    def step(self, state, inputs, tick):
        return (inputs[0].value,) if inputs[0].present else ()


@settings(deadline=None, max_examples=40)
@given(st.floats(0.0, 80.0), st.floats(0.0, 80.0), st.floats(0.0, 0.9), st.floats(0.0, 30.0))
def test_a_step_without_outputs_sends_nothing_and_leaves_no_row(before_ms, behind_ms, loss, executes_ms):
    recorder = Recorder()
    loop = Loop(Wiring(
        [Node("source", Source(), "50"), Node("sink", Sink(), "1000"),
         Node("waiting", Waiting(), "100", execution=Duration(kind="fixed", ms=executes_ms))],
        [Wire("source.y", "waiting.u", latency_ms=before_ms, loss=loss),
         Wire("waiting.y", "sink.u", latency_ms=behind_ms)]), recorder=recorder)
    loop.run_until(300 * NS_PER_MS)
    rows = recorder.blocks["waiting"]
    assert all(row[3] >= 0 and row[1] - row[3] >= round(before_ms * NS_PER_MS) for row in rows)
    assert loop.message_counts()["waiting.y->sink.u"]["sent"] == len(rows)
    seen = [sample for _, sample in loop.states()["sink"].log]
    first = rows[0][2] + round(behind_ms * NS_PER_MS) if rows else 300 * NS_PER_MS + 1
    assert [sample.present for sample in seen] == [k * NS_PER_MS >= first for k in range(301)]


@settings(deadline=None, max_examples=8)
@given(st.sampled_from(["pid", "mpc", "tuned_pid"]), st.floats(10.1, 300.0), st.floats(0.0, 60.0))
def test_no_controller_acts_on_an_angle_that_nobody_measured(tmp_path_factory, control, late_ms, latency_ms):
    wire = 'wires."patient.angles->tracker.angles"'
    experiment = fesloop.load("finger_control", [
        f"control={control}", "experiment.duration_s=0.7", f"{wire}.latency_ms={late_ms}",
        f"latency_ms={latency_ms}"])
    result = experiment.run(tmp_path_factory.mktemp("run"))
    with fesloop.Recording(result.recording) as recording:
        seen = recording.signal("tracker.angles")
        pulses = recording.signal("controller.stimulation")
        events = [(event.where, event.status, event.time_ns) for event in recording.events]
    assert seen.times_ns[0] >= late_ms * NS_PER_MS
    assert np.degrees(seen.values[0]) == pytest.approx([20.0, 25.0, 15.0], abs=6.0)
    heard = seen.times_ns[0] + latency_ms * NS_PER_MS
    assert not pulses.values[pulses.times_ns < heard - 1].any()
    assert pulses.values.any()
    assert ("tracker", "no_sample", 0) in events
    assert ("controller", "no_input", 0) in events

"""What a block puts out is as declared at every tick, and stays as it was put out."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Memory, Sink

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.experiment.running import Experiment, run
from fesloop.loop import assembly
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

WRONG = {"shape": (np.ones(3), 0.0), "kind": ([0.0] * 8, 0.0), "type": (np.ones((4, 2), int), 0.0),
         "scalar": (np.ones((4, 2)), np.ones(1)), "integer": (np.ones((4, 2)), 1), "nothing": None,
         "short": (np.ones((4, 2)),), "long": (np.ones((4, 2)), 0.0, 0.0), "list": [np.ones((4, 2)), 0.0]}


@dataclass(frozen=True, slots=True, kw_only=True)
class Faulty:
    """Puts out what is wrong in one way, from the tick of this number on."""

    wrong: str
    tick: int
    inputs = ()
    outputs = (Port("array", (4, 2)), Port("phase"))

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return WRONG[self.wrong] if tick.index >= self.tick else (np.full((4, 2), 1.0 * tick.index), 1.0)


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("tick", [0, 7])
def test_a_wrong_output_ends_the_run_by_its_name_and_every_row_before_is_kept(tmp_path, wrong, tick):
    experiment = Experiment(name="wrong", nodes=(Node("faulty", Faulty(wrong=wrong, tick=tick), "100"),),
                            duration_s=0.5)
    result = run(experiment, tmp_path)
    assert result.status == "failed"
    assert result.cause.startswith("faulty")
    if wrong == "shape":
        assert result.cause == "faulty.array: put out float64 (3,), declared is float64 (4, 2)"
    with Recording(result.recording) as recording:
        assert recording.status == "failed"
        if tick:
            assert recording.signal("faulty.array").values[:, 0, 0].tolist() == [1.0 * k for k in range(tick)]


def test_a_recording_whose_rows_cannot_be_written_says_that_its_run_failed(tmp_path, monkeypatch):
    def break_off(*given):
        raise ValueError("no rows")

    monkeypatch.setattr(RecordingWriter, "write", break_off)
    nodes = (Node("play", Playing(numbers=(1.0,)), "100"),)
    experiment = Experiment(name="broken", nodes=nodes, duration_s=0.1)
    with pytest.raises(ValueError, match="no rows"):
        run(experiment, tmp_path)
    with Recording(tmp_path / "broken-1.h5") as recording:
        assert recording.status == "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Playing:
    """Puts out given numbers, in arrays of its own or in one that it writes to again."""

    numbers: tuple[float, ...]
    reuses: str = ""
    inputs = ()
    outputs = (Port("y", (2,)),)

    def init(self, context):
        return Memory(x=np.zeros(2))

    def step(self, state, inputs, tick):
        state.x[:] = self.numbers[tick.index % len(self.numbers)]
        return ({"": state.x.copy(), "same": state.x, "view": state.x[:]}[self.reuses],)


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrays(Sink):
    """Keeps what it reads, as it reads it and as it is at the end."""

    @property
    def inputs(self):
        return (Port("u", (2,)),)

    def step(self, state, inputs, tick):
        value = inputs[0].value
        state.x = state.x or []
        state.x.append(value.tolist())
        state.log.append(value)
        return ()


def played(numbers, reuses, pause_ms):
    recorder = Recorder(None)
    playing = Playing(numbers=tuple(numbers), reuses=reuses)
    nodes = [Node("play", playing, "100"), Node("end", Arrays(), "200")]
    loop = Loop(Wiring(nodes, [Wire("play.y", "end.u", latency_ms=23)]), recorder=recorder)
    loop.run_until(pause_ms * NS_PER_MS)
    loop.restore(loop.snapshot())
    loop.run_until(400 * NS_PER_MS)
    state = loop.states()["end"]
    assert state.x == [value.tolist() for value in state.log]
    return state.x, [row[5][0].tolist() for row in recorder.blocks["play"]], recorder.events


@given(st.lists(st.sampled_from([0.0, -0.0, 1.0, 2.0, float("nan")]), min_size=1, max_size=6),
       st.sampled_from(["same", "view"]), st.integers(0, 400))
@settings(max_examples=25, deadline=None)
def test_a_block_may_write_to_its_outputs_again(numbers, reuses, pause_ms):
    assert played(numbers, reuses, pause_ms) == played(numbers, "", pause_ms)


def test_what_is_put_out_again_unchanged_is_the_same_object(monkeypatch):
    """Our plants know by it that nothing has changed; in a loop restored from a snapshot too."""
    monkeypatch.setattr(assembly, "is_ours", lambda part: True)  # others get views
    nodes = [Node("play", Playing(numbers=(1.0,), reuses="same"), "100"), Node("end", Arrays(), "100")]
    loop = Loop(Wiring(nodes, [Wire("play.y", "end.u")]))
    loop.run_until(50 * NS_PER_MS)
    loop.restore(loop.snapshot())
    loop.run_until(100 * NS_PER_MS)
    assert len({id(value) for value in loop.states()["end"].log}) == 1


@pytest.mark.parametrize("time_ns", [1_500_000_000.5, float("nan"), float("inf"), "1", None, True])
def test_the_end_of_a_stretch_is_a_whole_number_of_nanoseconds(time_ns):
    loop = Loop(Wiring([Node("play", Playing(numbers=(1.0,)), "100")], []))
    with pytest.raises(InputError, match=r"run_until: .* a whole number of ns"):
        loop.run_until(time_ns)
    assert loop.now == -1
    loop.run_until(1.5e8)
    assert loop.now == 150 * NS_PER_MS
    assert isinstance(loop.now, int)


def test_events_are_those_of_the_last_stretch_or_all_that_a_recorder_holds():
    def events(recorder):
        loop = Loop(Wiring([Node("play", Playing(numbers=(float("nan"),)), "100")], []), recorder=recorder)
        loop.run_until(0)
        loop.run_until(15 * NS_PER_MS)
        told = [(time_ns, *what) for time_ns, *what in loop.events]
        loop.restore(loop.snapshot())
        return told, len(loop.events)

    each = ("play", "non_finite", "output y: its safe value takes its place")
    assert events(None) == ([(10 * NS_PER_MS, *each)], 0)
    assert events(Recorder()) == ([(0, *each), (10 * NS_PER_MS, *each)], 2)

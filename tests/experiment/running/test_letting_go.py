"""Devices of a run are let go before anything is written, and what goes wrong there is its outcome."""

from dataclasses import dataclass

import pytest

from fesloop.errors import RunError
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.experiment.running import Experiment, run
from fesloop.loop.nodes import Node
from fesloop.loop.signals import Port

TOLD = []


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """Breaks at a step, and where it is closed, as it is told to."""

    breaks: str = ""
    sticks: str = ""
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        TOLD.clear()

    def step(self, state, inputs, tick):
        if self.breaks and tick.index == 3:
            raise {"run": RunError, "value": ValueError}[self.breaks]("broke")
        return (0.0,)

    def close(self, state):
        TOLD.append("let go")
        if self.sticks:
            raise RunError("dev: gives current still")


@pytest.fixture
def written(monkeypatch):
    """Notes when rows are written."""
    write = RecordingWriter.write
    monkeypatch.setattr(RecordingWriter, "write", lambda *given: (TOLD.append("written"), write(*given)))


def experiment(**device):
    return Experiment(name="ends", nodes=(Node("dev", Device(**device), "100"),), duration_s=0.1)


def ended(folder):
    with Recording(folder / "ends-1.h5") as recording:
        assert recording.signal("dev.y").times_ns.size
        return recording.status, [event.detail for event in recording.events if event.status == "failed"]


@pytest.mark.parametrize(("device", "cause"), [
    ({}, ""), ({"breaks": "run"}, "broke"), ({"sticks": "yes"}, "dev: gives current still"),
    ({"breaks": "run", "sticks": "yes"}, "broke")])
def test_what_goes_wrong_with_a_device_at_the_end_is_the_outcome(tmp_path, written, device, cause):
    result = run(experiment(**device), tmp_path)
    assert (result.status, result.cause) == ("failed" if cause else "done", cause)
    status, told = ended(tmp_path)
    assert status == result.status
    assert told == [text for key, text in (("breaks", "broke"), ("sticks", "dev: gives current still"))
                    if key in device]
    assert TOLD[TOLD.index("let go"):] == ["let go", "written"]


def test_a_block_that_breaks_is_not_hidden_by_a_device_that_does_too(tmp_path):
    with pytest.raises(ValueError, match="broke"):
        experiment(breaks="value", sticks="yes").run(tmp_path)
    status, told = ended(tmp_path)
    assert (status, told) == ("failed", ["ValueError: broke", "dev: gives current still"])

"""When a run is rehearsed: once for loops of the same parts, and always where the wall clock counts."""

import pytest

import fesloop
from fesloop.experiment import rehearsal, trial

SHORT = ["experiment.duration_s=0.6"]


@pytest.fixture
def loops(monkeypatch):
    """Loops that rehearsals make, in a process that has rehearsed nothing."""
    made = []

    class Counted(rehearsal.Loop):
        def __init__(self, *given, **named):
            made.append(given)
            super().__init__(*given, **named)

    monkeypatch.setattr(rehearsal, "_rehearsed", set())
    monkeypatch.setattr(rehearsal, "Loop", Counted)
    return made


def test_the_same_parts_are_rehearsed_once(loops, tmp_path):
    first, again = (fesloop.load("finger_pid_latency", [*SHORT, *more])
                    for more in ((), ("latency_ms=20",)))
    for experiment in (first, first.with_seed(9), again):
        trial.run(experiment, tmp_path)
    assert len(loops) == 1


@pytest.mark.parametrize(("settings", "realtime"), [
    (["record.timed=['controller']"], False), (["blocks.controller.execution={kind='measured'}"], False),
    ([], True)])
def test_where_the_wall_clock_counts_every_run_is_rehearsed(loops, tmp_path, settings, realtime):
    experiment = fesloop.load("finger_pid_latency", [*SHORT, *settings])
    for count in (1, 2):
        trial.run(experiment, tmp_path, realtime=realtime)
        assert len(loops) == count


def test_a_rehearsal_changes_no_run(loops, tmp_path):
    experiment = fesloop.load("finger_pid_latency", SHORT)
    digests = set()
    for _ in range(2):
        with fesloop.Recording(trial.run(experiment, tmp_path).recording) as recording:
            digests.add(recording.digest())
    assert len(digests) == len(loops) == 1

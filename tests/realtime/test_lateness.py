"""What a run in step with the wall clock says of how it kept time; about 5 s."""

import json
import time
from pathlib import Path

import numpy as np
import pytest
from live_parts import StandIn
from loop_parts import Sink

import fesloop
from fesloop.apps.cli import main
from fesloop.experiment.metrics.lateness import EDGES_MS, histogram, quantiles
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire

SMALL = str(Path(__file__).parent.parent / "experiment" / "small.toml")


class Slow(StandIn):
    """Takes 25 ms at its tenth tick."""

    def step(self, state, inputs, tick):
        if tick.index == 10:
            time.sleep(0.025)
        return (float(tick.index),)


def experiment():
    slow = Slow(clock=RateClock.from_rate("100"))
    nodes = (Node("slow", slow), Node("sink", Sink(), "100"))
    return Experiment(name="slow", nodes=nodes, wires=(Wire("slow.y", "sink.u"),), duration_s=0.3)


def test_a_run_collects_where_it_has_leisure(tmp_path, monkeypatch):
    monkeypatch.setattr("fesloop.loop.machine._OFTEN_NS", 0)
    monkeypatch.setattr("fesloop.loop.machine._AT_LAST_NS", 0)
    told = experiment().run(tmp_path, realtime=True).realtime
    assert told["collections"] > 10
    assert told["worst_collection_ms"] > 0.0


def test_the_longest_write_is_told(tmp_path, monkeypatch):
    from fesloop.experiment.recording.writing import RecordingWriter

    pieces = RecordingWriter.write_in_pieces

    def slowly(writer, recorder, trial):
        for piece in pieces(writer, recorder, trial):
            time.sleep(0.004)
            yield piece

    monkeypatch.setattr(RecordingWriter, "write_in_pieces", slowly)
    monkeypatch.setattr("fesloop.experiment.running._FLUSH_WALL_S", 0.1)
    result = experiment().run(tmp_path, realtime=True)
    assert result.realtime["worst_write_ms"] >= 4.0
    with Recording(result.recording) as recording:
        assert recording.wall["worst_write_ms"] == result.realtime["worst_write_ms"]


def test_a_late_instant_is_in_the_rows_the_summary_and_the_counts(tmp_path):
    result = experiment().run(tmp_path, realtime=True)
    with Recording(result.recording) as recording:
        rows, wall = recording.instants, recording.wall
    np.testing.assert_array_equal(rows["time_ns"], np.arange(30) * 10_000_000)
    assert (rows["late_ns"] >= 0).all()
    assert rows["took_ns"][10] >= 25_000_000
    assert rows["action"][10] == b"run late"
    assert rows["late_ns"][11] >= 15_000_000
    missed = (rows["late_ns"] + rows["took_ns"] > 10_000_000)
    np.testing.assert_array_equal(rows["action"] != b"kept", missed)
    told = result.realtime
    assert (told["deadlines"], told["missed"]) == (30, missed.sum())
    assert told["late_ms"]["worst"] == pytest.approx(rows["late_ns"].max() / 1e6)
    assert told["took_ms"]["p50"] == pytest.approx(np.median(rows["took_ns"]) / 1e6)
    assert sum(told["histogram"]["instants"]) == 30
    assert told["done"] == {"kept": 30 - missed.sum(), "run late": missed.sum()}
    assert (told["policy"], told["period_ms"]) == ("catch-up", 10.0)
    assert wall["worst_late_s"] == pytest.approx(told["late_ms"]["worst"] / 1e3)
    assert wall["missed_deadlines"] == result.missed_deadlines == missed.sum()


def test_ticks_that_are_skipped_are_events(tmp_path):
    result = experiment().run(tmp_path, realtime=fesloop.Pacing(late="skip"))
    with Recording(result.recording) as recording:
        skipped = [event for event in recording.events if event.status == "skipped"]
        rows = recording.instants
        ticks = recording.signal("slow.y").indices
    assert {event.where for event in skipped} == {"slow", "sink"}
    assert {event.time_ns for event in skipped} == set(rows["time_ns"][rows["action"] == b"skipped"])
    # On a busy machine the long tick itself may be skipped.
    assert not {10, 11} <= set(ticks.tolist())
    assert len(ticks) == 30 - len(skipped) // 2
    assert result.status == "done"


def test_stop_ends_a_run_with_its_cause_and_what_was_recorded(tmp_path):
    with pytest.raises(fesloop.RunError, match=r"due at \d+\.000 ms .*--late stop\); recorded until then: "):
        experiment().run(tmp_path, realtime=fesloop.Pacing(late="stop"))
    with Recording(tmp_path / "slow-1.h5") as recording:
        assert recording.status == "failed"
        assert recording.instants["action"][-1] == b"stopped"
        assert recording.events[-1].status == "failed"


def test_a_histogram_counts_each_value_once():
    late = np.array([0.0, 0.04, 0.05, 3.0, 99.9, 100.0, 1e6])
    counts = histogram(late)
    assert counts.sum() == late.size
    assert dict(zip(EDGES_MS, counts, strict=True)) == {
        **dict.fromkeys(EDGES_MS, 0), 0.0: 2, 0.05: 1, 2.0: 1, 50.0: 1, 100.0: 2}
    assert quantiles(np.arange(101.0)) == {"p50": 50.0, "p99": 99.0, "worst": 100.0}


@pytest.mark.slow
def test_the_command_tells_it_in_the_summary_and_under_a_key_of_its_own(capsys, tmp_path):
    arguments = ["run", SMALL, "--realtime", "--late", "skip", "--json", "--out", str(tmp_path),
                 "--set", "experiment.trials=1"]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)["realtime"]
    assert told["policy"] == "skip"
    assert told["deadlines"] == 50
    assert {"late_ms", "took_ms", "histogram", "done", "memory", "scheduling", "collections"} <= set(told)
    for words in ("missed deadlines", "begun late, ms", "late by", "memory", "scheduling"):
        assert words in err
    with Recording(json.loads(out)["recording"]) as recording:
        assert recording.wall["memory"] == told["memory"]


@pytest.mark.parametrize("options", [("--late", "skip"), ("--priority", "5"),
                                     ("--realtime", "--priority", "100")])
def test_options_that_make_no_sense_are_refused_in_a_line(capsys, tmp_path, options):
    assert main(["run", SMALL, "--out", str(tmp_path), *options]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []

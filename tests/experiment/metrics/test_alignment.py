"""A tracker is scored on what it measures, not on the pose that it was given."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import fesloop
from fesloop.apps.cli.run_command import _summarise
from fesloop.experiment.metrics.scoring import _from_aligned
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.result import split_section

SHORT = ["experiment.duration_s=1.6", "score.after_s=0"]


@pytest.mark.parametrize("align_s", [0.2, 0.5, 1.1])
def test_the_error_of_a_tracker_counts_from_its_alignment_on(align_s, tmp_path):
    done = fesloop.load("finger_mpc", [*SHORT, f"blocks.tracker.align_s={align_s}"]).run(tmp_path)
    with fesloop.Recording(done.recording) as recording:
        truth, seen = recording.signal("patient.angles"), recording.signal("tracker.angles")
    own = seen.times_ns >= round(align_s * 1e9)
    newest = np.searchsorted(truth.times_ns, seen.newest_ns[own], side="right") - 1
    error = np.degrees(seen.values[own] - truth.values[newest])
    assert done.metrics["tracker_rmse_deg"] == pytest.approx([np.sqrt(np.mean(error**2))], rel=1e-9)


@pytest.mark.parametrize(("align_s", "latency_ms", "after_s"), [
    (0.5, 10, 0.0), (1.1, 10, 0.0), (0.0, 150, 0.0), (0.5, 300, 0.0), (0.5, 300, 0.6), (0.5, 300, 1.0)])
def test_the_span_of_the_split_error_is_said(align_s, latency_ms, after_s, tmp_path, capsys):
    """Over the instants of the span that is said, the total is the tracking error, and it is not over all.

    It begins when what the aligned tracker put out has travelled, or where scoring begins.
    """
    settings = [*SHORT[:1], f"score.after_s={after_s}", f"latency_ms={latency_ms}",
                f"blocks.tracker.align_s={align_s}", "blocks.controller.horizon=20",
                "blocks.reference.preview=20"]
    done = fesloop.load("finger_mpc", settings).run(tmp_path)
    (since_s,) = done.metrics["split_from_s"]
    with fesloop.Recording(done.recording) as recording:
        flag = recording.signal("tracker.aligned")
    left_ns = flag.left_ns[(flag.values[:, 0] > 0.5) & (flag.newest_ns >= 0)][0]
    arrival_s = left_ns / 1e9 + latency_ms / 1e3
    assert since_s == pytest.approx(max(after_s, arrival_s), abs=1.1e-3)
    with fesloop.Recording(done.recording) as recording:
        truth, wanted = recording.signal("patient.angles"), recording.signal("reference.angles")
        counted = truth.times_ns >= round(since_s * 1e9)
        times = truth.times_ns[counted]
        then = np.searchsorted(wanted.times_ns, times, side="right") - 1
        error = np.degrees(truth.values[counted] - wanted.values[then])
        page = split_section(known_of(recording))
    assert done.metrics["split_rmse_deg"]["total"] == pytest.approx([np.sqrt(np.mean(error**2))], rel=1e-9)
    text = page.parts[1].text
    assert f"count from {since_s:.3g} s" in text
    assert ("where scoring begins (`score.after_s`)" in text) == (arrival_s < after_s)
    assert ("on, when an estimate of an aligned tracker had reached" in text) == (arrival_s > after_s)
    assert ("counts what was before" in text) == (done.metrics["split_rmse_deg"]["total"]
                                                  != pytest.approx(done.metrics["joint_rmse_deg"], rel=1e-9))
    _summarise(done, (), "")
    row = next(line for line in capsys.readouterr().err.splitlines() if line.startswith("split_from_s "))
    assert float(row.split()[1]) == pytest.approx(since_s, abs=1e-3)


def test_what_a_tracker_put_out_before_it_was_aligned_does_not_count_where_it_arrives_late():
    """Behind another block, which passes it on when the tracker has long been aligned."""
    signal = SimpleNamespace(times_ns=np.arange(8) * 10, newest_ns=np.arange(8) * 10 - 30)
    flags = SimpleNamespace(times_ns=np.arange(8) * 10, newest_ns=np.arange(8) * 10,
                            values=np.array([0, 0, 1, 1, 1, 1, 1, 1.0]))
    recording = SimpleNamespace(units={"tracker.aligned": "1", "tracker.angles": "rad", "select.out": "rad"},
                                experiment={"wires": [{"from": "tracker.angles", "to": "select.in"}]},
                                signal=lambda name, trial: flags)
    told = _from_aligned(recording, "select.out", signal, 0)
    np.testing.assert_array_equal(told, signal.newest_ns >= 20)


def test_a_tracker_that_never_aligned_has_no_error_and_a_reason(tmp_path):
    metrics = fesloop.load("finger_mpc", [*SHORT, "blocks.tracker.align_s=9"]).run(tmp_path).metrics
    numbers = {"tracker_rmse_deg": metrics["tracker_rmse_deg"]}
    numbers |= {f"split_rmse_deg.{part}": values for part, values in metrics["split_rmse_deg"].items()}
    numbers |= {f"joints.MCP.{name}": values for name, values in metrics["joints"]["MCP"].items()
                if name != "joint_rmse_deg"}
    for name, (value,) in numbers.items():
        assert value is None or math.isnan(value)
        assert metrics["missing"][name] == [
            "tracker never took its initial pose, or learnt its joints' axes: what it put out is the pose "
            "that it was given, or zero"]
    assert math.isfinite(metrics["joint_rmse_deg"][0])


def test_an_exact_tracker_beside_one_that_aligns_is_scored_throughout(tmp_path):
    """The estimate's own tracker counts, not another one that the loop leads to."""
    done = fesloop.load("finger_control", ["experiment.duration_s=1", "score.after_s=0"]).run(tmp_path)
    assert "missing" not in done.metrics
    assert math.isfinite(done.metrics["tracker_rmse_deg"][0])

def test_orientations_count_from_when_the_axes_of_the_joints_are_learnt(recordings, tmp_path):
    """Before, both are as if the joint were straight; the recording's reference is known all the time."""
    played = recordings / "wrist" / "circle-250.npz"
    hinge = [f"recording={played}", "tracker=constrained", "joints=hinge"]
    learnt = fesloop.load("replay", hinge).run(tmp_path)
    with fesloop.Recording(learnt.recording) as recording:
        aligned = recording.signal("tracker.aligned")
        (status,) = [event for event in recording.events if event.status == "axes_learnt"]
    since_s = learnt.metrics["orientation_from_s"]
    assert since_s == aligned.times_ns[aligned.values[:, 0] > 0.5][0] / 1e9
    assert since_s == pytest.approx(status.time_ns / 1e9, abs=0.05)
    assert since_s > 2.0
    late = fesloop.load("replay", [*hinge, f"score.after_s={since_s}"]).run(tmp_path)
    assert late.metrics["relative_angle_rmse_deg"] == learnt.metrics["relative_angle_rmse_deg"]


def test_a_tracker_that_never_learns_its_joints_has_no_error_of_orientations(recordings, tmp_path):
    played = recordings / "wrist" / "circle-250.npz"
    short = fesloop.load("replay", [f"recording={played}", "tracker=constrained", "joints=hinge",
                                    "experiment.duration_s=1.0"]).run(tmp_path)
    assert "relative_angle_rmse_deg" not in short.metrics
    assert "never took its initial pose" in short.metrics["missing"]["orientation_rmse_deg"][0]

"""Which signals go into which metric: held against the run itself."""

import tracemalloc
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fesloop
from fesloop import Experiment, InputError, Node, Recording, Wire
from fesloop.experiment.metrics import joints as metrics
from fesloop.experiment.metrics.grasp_outcome import GraspScore
from fesloop.experiment.metrics.joints import held
from fesloop.experiment.metrics.missing import give_reasons, reasons_of
from fesloop.experiment.metrics.scoring import _arrived, _seen, _trace, metrics_of
from fesloop.experiment.recording import reading
from fesloop.experiment.score_spec import Score
from plants.linear import StateSpace

LATENCY = "finger_pid_latency"
WIRE = 'wires."tracker.angles->controller.measured"'
ROUGH = [f"{WIRE}.loss=0.2", f"{WIRE}.jitter.kind=uniform", f"{WIRE}.jitter.low_ms=0",
         f"{WIRE}.jitter.high_ms=25", "experiment.duration_s=6", "experiment.trials=2"]


@pytest.mark.parametrize("more", ["late=keep-newest", "late=in-order", "burst_messages=4"])
def test_what_stood_at_the_controller_is_what_it_read_at_every_tick(tmp_path, more):
    """The controller's own stamps say which estimate it used; jitter and loss are those of the run."""
    result = fesloop.load(LATENCY, [*ROUGH, f"{WIRE}.{more}"]).run(tmp_path)
    with Recording(result.recording) as recording:
        for trial in range(2):
            arrived = _arrived(recording, recording.signal("tracker.angles", trial), trial)
            estimate = recording.signal("tracker.angles", trial)
            steps = recording.signal("controller.stimulation", trial)
            told = steps.times_ns > 200_000_000
            used = np.searchsorted(estimate.newest_ns, steps.oldest_ns[told])
            np.testing.assert_array_equal(estimate.newest_ns[used], steps.oldest_ns[told])
            np.testing.assert_array_equal(held(arrived, steps.times_ns[told]), estimate.values[used])
        assert recording.messages[0]["tracker.angles->controller.measured"]["lost"] > 80


def test_an_exact_tracker_has_no_error_of_its_own_but_latency_costs_the_controller(tmp_path):
    """The stamps of a capture are those of the truth, so the tracker's error is nil at any latency."""
    result = fesloop.load(LATENCY, ["blocks.tracker.noise_deg=0", "latency_ms=100"]).run(tmp_path)
    metrics = result.metrics
    assert metrics["tracker_rmse_deg"][0] < 1e-9
    assert metrics["split_rmse_deg"]["tracker"][0] > 0.5
    assert metrics["split_rmse_deg"]["total"] == pytest.approx(metrics["joint_rmse_deg"], rel=1e-3)


def test_a_bias_of_the_tracker_is_its_error(tmp_path):
    settings = ["blocks.tracker.noise_deg=0", "blocks.tracker.bias_deg=[3.0, 0.0, -4.0]"]
    metrics = fesloop.load(LATENCY, settings).run(tmp_path).metrics
    joints = metrics["joints"]
    assert [joints[name]["tracker_rmse_deg"][0] for name in ("MCP", "PIP", "DIP")] == pytest.approx([3, 0, 4])
    assert metrics["tracker_rmse_deg"][0] == pytest.approx(np.sqrt(25 / 3))


def test_one_joint_without_an_axis_is_scored_under_its_name(tmp_path):
    """x' = -x from 1 rad, as an FMU of one angle or a model of one state gives it."""
    plant = Node("plant", StateSpace(a=((-1.0,),), b=((1.0,),), c=((1.0,),), initial_state=(1.0,),
                                     input_unit="rad", output_unit="rad"))
    score = Score(truth="plant.y", joints=("elbow",))
    nothing = Wire("plant.y", "plant.u", latency_ms=1500, rate="1000")
    experiment = Experiment(name="one", nodes=(plant,), wires=(nothing,), duration_s=1.0, score=score)
    metrics = experiment.run(tmp_path).metrics
    assert metrics["joints"]["elbow"]["range_deg"] == [pytest.approx(np.degrees(1.0 - np.exp(-0.999)))]


def test_what_comes_after_until_s_does_not_count(tmp_path):
    drifting = ["blocks.tracker.noise_deg=0", "blocks.tracker.drift_deg_s=1", "experiment.duration_s=6"]
    whole, begun = (fesloop.load(LATENCY, [*drifting, *more]).run(tmp_path).metrics
                    for more in ((), ("score.until_s=2",)))
    after_s = fesloop.load(LATENCY).score.after_s
    for found, until_s in ((whole, 6.0), (begun, 2.0)):
        # The error is 1 deg for each second.
        wanted = np.sqrt((until_s**3 - after_s**3) / (3.0 * (until_s - after_s)))
        assert found["tracker_rmse_deg"][0] == pytest.approx(wanted, rel=0.02)
    assert begun["joint_rmse_deg"] != whole["joint_rmse_deg"]


@pytest.mark.parametrize("make", [Score, partial(GraspScore, object="o", from_s=0.0)])
@pytest.mark.parametrize("until_s", [1e300, 1e10, float("inf"), float("nan")])
def test_what_is_scored_ends_with_every_run_at_the_latest(make, until_s):
    with pytest.raises(InputError, match="until_s"):
        make(until_s=until_s)


def test_scoring_reads_a_long_recording_in_pieces(tmp_path, monkeypatch):
    """An hour is 3.6 million rows of the plant; of each but its instants may be in memory at once."""
    result = fesloop.load(LATENCY, ["experiment.duration_s=60", *ROUGH[:4]]).run(tmp_path)
    monkeypatch.setattr(metrics, "_ROWS_AT_ONCE", 1024)
    with Recording(result.recording) as recording:
        rows = recording.signal("finger.angles").times_ns.size
        tracemalloc.start()
        try:
            found = metrics_of(recording)
            _, most = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert rows == 60_000
    assert most < 60 * rows + reading._KEPT_BYTES, "a row of the plant is 124 bytes"
    assert found["joint_rmse_deg"] == pytest.approx(result.metrics["joint_rmse_deg"], rel=1e-12)


def test_a_column_is_the_signal_slice_by_slice(tmp_path):
    result = fesloop.load(LATENCY, ["experiment.duration_s=1", "experiment.trials=2"]).run(tmp_path)
    with Recording(result.recording) as recording:
        for trial in range(2):
            whole = recording.signal("finger.angles", trial)
            times, values = recording.column("finger.angles", trial, after_ns=123_000_001)
            assert times[0] == 124_000_000
            np.testing.assert_array_equal(times, whole.times_ns[124:])
            assert values.shape == whole.values[124:].shape
            for rows in (slice(0, 10), slice(500, 5000), slice(None), slice(7, 7)):
                np.testing.assert_array_equal(values[rows], whole.values[124:][rows])


def test_metrics_come_from_the_recording_alone(tmp_path):
    result = fesloop.load(LATENCY, ["experiment.duration_s=3"]).run(tmp_path)
    moved = result.recording.rename(tmp_path / "elsewhere.h5")
    with Recording(moved) as recording:
        assert metrics_of(recording) == result.metrics


def test_an_experiment_without_a_score_has_no_metrics(tmp_path):
    document = fesloop.load(Path(__file__).parents[1] / "small.toml").document()
    del document["score"]
    from fesloop.experiment.files.parse import from_document

    assert from_document(document).run(tmp_path).metrics == {}


def test_a_run_that_broke_off_at_once_gives_no_number_but_no_error_either(tmp_path):
    result = fesloop.load(LATENCY, ["experiment.duration_s=0.6"]).run(tmp_path)
    with Recording(result.recording) as recording:
        recording.experiment["score"]["after_s"] = 0.7
        metrics = metrics_of(recording)
    assert np.isnan(metrics["joint_rmse_deg"]).all()
    assert np.isnan(metrics["split_rmse_deg"]["total"]).all()


def test_an_error_that_cannot_be_divided_says_that_nothing_of_the_tracker_had_arrived():
    told = {"split_rmse_deg": {"total": [1.0, np.nan]}, "joints": {"MCP": {"split_total_deg": [np.nan]}}}
    give_reasons(told)
    reasons = dict(reasons_of(told))
    assert set(reasons) == {"split_rmse_deg.total, trial 1", "joints.MCP.split_total_deg"}
    assert all(why.startswith("nothing of the tracker had arrived") for why in reasons.values())


@pytest.mark.parametrize(("after_s", "until_s"), [(0.067, 1.001), (0.0, 2.0), (0.134, 1.019)])
def test_the_instants_at_both_ends_of_what_is_scored_count(after_s, until_s):
    """Of 1.001 s floats make 1000999999.9999999 ns."""
    times, values = np.arange(0, 3_000_000_000, 1_000_000), np.zeros((3000, 1))
    ends = round(1000 * after_s), round(1000 * until_s)
    values[list(ends)] = 1.0
    signal = SimpleNamespace(times_ns=times, newest_ns=times, values=values)
    held_back = SimpleNamespace(
        units={"a": "rad"}, experiment={"wires": []}, signal=lambda name, trial: signal,
        column=lambda name, trial, after, until: (times[(times >= after) & (times <= until)], None))
    cut, _ = _trace(held_back, "a", 0, after_s, until_s)
    (seen, told), _ = _seen(held_back, Score(truth="a", estimate="a", after_s=after_s, until_s=until_s), 0)
    assert [cut[0], cut[-1]] == [1_000_000 * end for end in ends]
    assert [seen[0], seen[-1]] == [1_000_000 * end for end in ends]
    assert [told[0, 0], told[-1, 0]] == [1.0, 1.0]

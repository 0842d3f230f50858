"""What a grasp and a fading contraction are said to be, against signals made up for it."""

from types import SimpleNamespace

import numpy as np
import pytest

from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.metrics.cycles import CycleScore, cycle_metrics, cycle_peaks
from fesloop.experiment.metrics.grasp import grasp_metrics
from fesloop.experiment.metrics.grasp_outcome import GraspScore
from fesloop.experiment.metrics.joints import range_deg
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import RateClock

TIMES_NS = np.arange(0, 1000) * 10_000_000


def told(*values_of_trials, times_ns=TIMES_NS):
    signals = [SimpleNamespace(times_ns=times_ns[:len(values)], values=values) for values in values_of_trials]
    return SimpleNamespace(trials=len(signals), signal=lambda name, trial: signals[trial], signals=(),
                           experiment={"blocks": {}})


def test_what_stays_is_held_and_what_slides_or_breaks_off_is_not():
    still, sliding = np.zeros((1000, 3)), np.zeros((1000, 3))
    still[:200, 2] = 0.5
    sliding[:, 1] = np.linspace(0.0, 0.1, 1000)
    recording = told(still, sliding, still[:600])
    metrics = grasp_metrics(recording, GraspScore(object="o", from_s=3.0, until_s=8.0, within_mm=20.0))
    assert metrics["held"] == [True, False, None]
    assert metrics["object_moved_mm"][:2] == pytest.approx([0.0, 1e3 * 0.1 * 500 / 999])
    assert np.isnan(metrics["object_moved_mm"][2])
    assert metrics["held_s"][:2] == pytest.approx([5.0, 0.02 / (0.1 / 9.99)], abs=0.011)
    assert np.isnan(metrics["held_s"][2])


def test_an_object_that_leaves_and_comes_back_was_not_held():
    places = np.zeros((1000, 3))
    places[500, 0] = 0.03
    score = GraspScore(object="o", from_s=3.0, until_s=8.0)
    assert grasp_metrics(told(places), score) == {
        "object_outcome": ["slipped"], "held": [False], "object_moved_mm": [30.0], "held_s": [2.0]}


def test_grip_forces_are_means_over_the_while():
    forces = np.zeros((1000, 5))
    forces[300:801, 1] = 2.0
    forces[:300, 0] = 9.0
    recording = told(forces)
    recording.signal = lambda name, trial: SimpleNamespace(
        times_ns=TIMES_NS, values=forces if name == "f" else np.zeros((1000, 3)))
    metrics = grasp_metrics(recording, GraspScore(object="o", from_s=3.0, until_s=8.0, forces="f"))
    assert metrics["grip_force_n"] == {"F1": [0.0], "F2": [2.0], "F3": [0.0], "F4": [0.0], "F5": [0.0]}


def test_a_decline_is_that_of_the_peaks():
    wave = np.maximum(np.sin(2.0 * np.pi * TIMES_NS / 2e9), 0.0)
    values = np.stack([wave, wave], axis=1) * np.repeat([1.0, 0.9, 0.8, 0.6, 0.1], 200)[:, np.newaxis]
    score = CycleScore(signal="a", cycle_s=2.0, count=4)
    assert cycle_metrics(told(values), score)["decline_pct"] == pytest.approx([40.0])
    peaks = cycle_peaks(told(values[:500]).signal("a", 0), score)
    assert peaks[:2] == pytest.approx([2.0, 1.8])
    assert np.isnan(peaks[2:]).all()


@pytest.mark.parametrize("rate", ["30", "300", "120", "70", "2000/7", "50"])
@pytest.mark.parametrize("duration_s", [1.0, 4.4, 10.0])
def test_a_while_that_ends_with_the_trial_is_whole_at_any_rate(rate, duration_s):
    """Instants are rounded down to whole ns, so that the last interval may be one longer than that before."""
    clock, end_ns = RateClock.from_rate(rate), round(duration_s * 1e9)
    times_ns = np.array([clock.tick(k) for k in range(clock.first_at_or_after(end_ns))])
    still = told(np.zeros((times_ns.size, 3)), times_ns=times_ns)
    score = GraspScore(object="o", from_s=0.5, until_s=duration_s)
    assert grasp_metrics(still, score)["held"] == [True]
    halves = CycleScore(signal="a", cycle_s=duration_s / 2, count=2)
    whole, cut = (told(np.ones(times_ns.size - gone), times_ns=times_ns) for gone in (0, 1))
    assert cycle_metrics(whole, halves) == {"decline_pct": [0.0]}
    assert np.isnan(cycle_peaks(cut.signal("a", 0), halves)).tolist() == [False, True]


def test_a_decline_may_be_of_one_muscle():
    values = np.zeros((1000, len(MUSCLES)))
    values[::100] = 1.0
    values[500:, MUSCLES.index("FDS3")] *= 0.4
    score = CycleScore(signal="a", cycle_s=5.0, count=2, muscle="FDS3")
    assert cycle_metrics(told(values), score)["decline_pct"] == pytest.approx([60.0])
    assert [fault.where for fault in score.faults({"a": (29,)})] == []
    assert [fault.where for fault in score.faults({"a": (28,)})] == ["score.cycles.muscle"]


def test_a_range_is_from_the_least_to_the_greatest_angle():
    angles = np.radians(np.stack([np.linspace(-10.0, 50.0, 20000), np.full(20000, 7.0)], axis=1))
    assert range_deg((np.arange(20000), angles)) == pytest.approx([60.0, 0.0])
    assert np.isnan(range_deg((np.empty(0, np.int64), np.empty((0, 2))))).all()


@pytest.mark.parametrize(("make", "where"), [
    (lambda: GraspScore(object="o", from_s=3.0, until_s=3.0), "until_s"),
    (lambda: GraspScore(object="o", from_s=-1.0, until_s=3.0), "until_s"),
    (lambda: GraspScore(object="o", from_s=1.0, until_s=3.0, within_mm=0.0), "within_mm"),
    (lambda: CycleScore(signal="a", cycle_s=0.0, count=3), "cycle_s"),
    (lambda: CycleScore(signal="a", cycle_s=1.0, count=1), "count"),
    (lambda: CycleScore(signal="a", cycle_s=1.0, count=3, muscle="FDS"), "muscle")])
def test_scores_that_cannot_be_are_named(make, where):
    with pytest.raises(InputError) as fault:
        make()
    assert fault.value.where == where


def test_signals_that_do_not_exist_or_fit_are_named():
    document = {
        "experiment": {"name": "grasp", "duration_s": 0.1},
        "blocks": {"hand": {"kind": "moving_hand", "phases": [{"duration_s": 0.1}]}},
        "score": {"grasp": {"object": "hand.fingertips", "forces": "hand.none", "from_s": 0, "until_s": 1},
                  "cycles": {"signal": "hand.nothing", "cycle_s": 0.05, "count": 2}}}
    with pytest.raises(InputErrors) as fault:
        from_document(document)
    for where in ("score.grasp.object", "score.grasp.forces", "score.cycles.signal"):
        assert where in str(fault.value)
    document["score"] = {"cycles": {"signal": "hand.angles", "cycle_s": 0.05, "count": 2}}
    document["record"] = {"leave_out": ["hand.angles"]}
    with pytest.raises(InputError, match=r"score\.cycles"):
        from_document(document)


def test_a_run_without_a_reference_tells_how_far_each_joint_goes(tmp_path):
    document = {
        "experiment": {"name": "wave", "duration_s": 1.0},
        "blocks": {"hand": {"kind": "moving_hand", "phases": [
            {"duration_s": 1.0, "posture_deg": {"F2_pip_flexion": 60.0}}]}},
        "score": {"truth": "hand.angles"}}
    joints = from_document(document).run(tmp_path).metrics["joints"]
    assert len(joints) == 23
    assert joints["F2_pip_flexion"]["range_deg"][0] > 50.0
    assert joints["F3_pip_flexion"] == {"range_deg": [0.0]}

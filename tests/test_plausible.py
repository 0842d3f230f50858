"""The script that doubts the results of shipped experiments finds what cannot be."""

import importlib.util
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

PATH = Path(__file__).resolve().parents[1] / ".ci" / "plausible.py"


@pytest.fixture(scope="module")
def plausible():
    spec = importlib.util.spec_from_file_location("plausible", PATH)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def event(status, detail=""):
    return SimpleNamespace(status=status, where="tracker", detail=detail)


def test_failed_poses_and_events_without_a_row_are_doubted(plausible):
    events = [event("aligned"), event("initial_pose_failed", "moved"), event("no_such_status")]
    doubts = list(plausible.events_doubted(SimpleNamespace(events=events)))
    assert doubts == ["initial_pose_failed (tracker): moved",
                      "event no_such_status is not explained in docs/events.md"]


@pytest.mark.parametrize(("first_pulse", "doubted"), [(20, True), (49, True), (50, False), (None, False)])
def test_a_pulse_before_alignment_is_doubted(plausible, first_pulse, doubted):
    times = np.arange(100) * 10_000_000
    widths = np.zeros((100, 2, 2))
    if first_pulse is not None:
        widths[first_pulse:, 1] = 1e-4
    signals = {"safety.stimulation": SimpleNamespace(times_ns=times, values=widths),
               "tracker.aligned": SimpleNamespace(times_ns=times, values=(np.arange(100) >= 50)[:, None])}
    recording = SimpleNamespace(trials=1, signals=list(signals), signal=lambda name, trial: signals[name])
    nodes = [SimpleNamespace(name="safety", part=SimpleNamespace(guards=True)),
             SimpleNamespace(name="tracker", part=SimpleNamespace(needs_stillness="aligned"))]
    assert bool(list(plausible.pulses_doubted(recording, nodes))) == doubted


def test_metrics_without_a_reason_or_beyond_what_is_possible_are_doubted(plausible):
    metrics = {"joint_rmse_deg": [1.0, 95.0], "held": [True, False], "time_to_grasp_s": [None, None],
               "aperture_mm": {"hold": [30.0, float("nan")]}, "missing": {"time_to_grasp_s": ["why", None]},
               "unheard_of": [1.0, 2.0]}
    assert list(plausible.metrics_doubted(metrics)) == [
        "unheard_of has no definition",
        "joint_rmse_deg of trial 1 is 95, possible is 0 to 90",
        "time_to_grasp_s of trial 1 is none, without a reason",
        "aperture_mm.hold of trial 1 is none, without a reason"]


def test_an_error_that_falls_beyond_its_interval_is_doubted(plausible):
    falling = [[1.43, 1.41, 1.45], [1.28, 1.27, 1.31]]
    assert len(list(plausible.falls([0.0, 30.0], falling, "error"))) == 1
    assert not list(plausible.falls([0.0, 30.0], falling[::-1], "error"))
    scattered = [[1.4, 2.0, 0.9], [1.3, 1.0, 1.5]]
    assert not list(plausible.falls([0.0, 30.0], scattered, "error"))


def test_every_shipped_experiment_is_run_or_left_out(plausible):
    from fesloop.experiment.files.source import shipped

    run = {case.name for case in plausible.cases([])}
    assert run | plausible.LEFT_OUT == set(shipped())
    assert not run & plausible.LEFT_OUT

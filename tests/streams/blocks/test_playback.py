"""Signals of earlier runs, played again: values, stamps, and the twin that they drive."""

import numpy as np
import pytest

import fesloop
from fesloop.errors import InputError
from fesloop.experiment.playback import Playback
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Tick
from fesloop.loop.signals import NEVER


@pytest.fixture(scope="module")
def finger(tmp_path_factory):
    """A run of a stimulated finger, two trials."""
    settings = ["experiment.duration_s=2.5", "experiment.trials=2", "jitter_ms=15"]
    return fesloop.load("finger_control", settings).run(tmp_path_factory.mktemp("finger")).recording


def test_values_leave_when_they_left_and_carry_their_captures(finger):
    played = Playback(recording=str(finger), signal="safety.stimulation", trial=1)
    with Recording(finger) as run:
        signal = run.signal("safety.stimulation", 1)
    np.testing.assert_array_equal(played.clock.stamps_ns, signal.left_ns)
    port, = played.outputs
    assert (port.name, port.shape, port.unit, port.gaps) == ("signal", (4, 2), "A,s", False)
    tick = Tick()
    for index in (0, 7, len(signal.values) - 1):
        tick.index, tick.captured_ns = index, NEVER
        value, = played.step(played.init(None), (), tick)
        np.testing.assert_array_equal(value, signal.values[index])
        assert tick.captured_ns == signal.newest_ns[index]
        with pytest.raises(ValueError, match="read-only"):
            value[0] = 0.0


def test_trials_differ(finger):
    both = [Playback(recording=str(finger), signal="tracker.angles", trial=trial) for trial in (0, 1)]
    assert not np.array_equal(both[0].played.values, both[1].played.values)


@pytest.mark.parametrize(("change", "told"), [
    ({"signal": "safety.stimulatoin"}, "safety.stimulation"),
    ({"trial": 2}, "trial: 2, but .* has 2; allowed: 0 to 1"),
    ({"recording": "absent.h5"}, "there is no such recording")])
def test_misuse(change, told, finger):
    with pytest.raises(InputError, match=told):
        Playback(**{"recording": str(finger), "signal": "safety.stimulation", **change})


@pytest.mark.parametrize("trial", [0, 1])
def test_a_twin_of_the_same_finger_takes_the_same_posture(finger, tmp_path, trial):
    result = fesloop.load("hil_twin", [f"recording={finger}", f"trial={trial}"]).run(tmp_path)
    with Recording(result.recording) as twin, Recording(finger) as run:
        theirs, ours = run.signal("patient.angles", trial), twin.signal("twin.angles")
        shared = min(ours.times_ns.size, theirs.times_ns.size)
        assert shared > 2400
        np.testing.assert_array_equal(ours.times_ns[:shared], theirs.times_ns[:shared])
        np.testing.assert_allclose(ours.values[:shared], theirs.values[:shared], atol=1e-12)
    assert result.metrics["joint_rmse_deg"][0] < 1e-9


def test_another_finger_does_not(finger, tmp_path):
    result = fesloop.load("hil_twin", [f"recording={finger}", "strength=1.0"]).run(tmp_path)
    assert result.metrics["joint_rmse_deg"][0] > 0.3
    assert set(result.metrics["joints"]) == {"MCP", "PIP", "DIP"}


def test_it_is_held_against_what_the_tracker_said_just_as_well(finger, tmp_path):
    result = fesloop.load("hil_twin", [f"recording={finger}", "posture=tracker.angles"]).run(tmp_path)
    assert 0.05 < result.metrics["joint_rmse_deg"][0] < 1.0


@pytest.mark.slow
def test_a_twin_of_a_whole_hand_takes_the_same_posture(tmp_path):
    settings = ["scene=free", "experiment.duration_s=3.5", "score.until_s=3.4"]
    run = fesloop.load("grasp_mpc", settings).run(tmp_path)
    twin = fesloop.load("hil_twin", ["twin=hand", f"recording={run.recording}"]).run(tmp_path)
    with Recording(twin.recording) as recording:
        assert np.ptp(np.degrees(recording.signal("hand.angles").values), axis=0).max() > 5.0
    assert twin.metrics["joint_rmse_deg"][0] < 1e-9

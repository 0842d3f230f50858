"""The shipped `grasp_ilc`: a whole hand learns through its tracker, and holds; about 15 s."""

import numpy as np
import pytest

from fesloop import Recording
from fesloop.errors import InputErrors
from fesloop.experiment.files.parse import load


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    # Muscles that are equally strong in all trials: variation bounds what learning reaches.
    same = load("grasp_ilc", ["trials=3", "blocks.muscles.variation.scale=0"])
    result = same.run(tmp_path_factory.mktemp("grasp"))
    with Recording(result.recording) as recording:
        yield result, recording


@pytest.mark.slow
def test_the_second_trial_holds_the_cylinder_and_the_error_falls(learnt):
    result, _ = learnt
    metrics = result.metrics
    assert metrics["held"] == [False, True, True]
    first, second, third = metrics["joint_rmse_deg"]
    assert second < 0.5 * first
    assert third < second
    assert max(metrics["tracker_rmse_deg"]) < 2.0


def test_what_grasps_keeps_its_drives_from_the_first_touch_on(learnt):
    _, recording = learnt
    (touch,) = [event for event in recording.events
                if (event.where, event.status, event.trial) == ("controller", "contact", 1)]
    pulses = [recording.signal("controller.stimulation", trial) for trial in (1, 2)]
    late = pulses[0].times_ns > touch.time_ns + 200_000_000
    grasping = [1, 3, 4, 5, 6, 7]
    np.testing.assert_allclose(pulses[1].values[late][:, grasping, 1], pulses[0].values[late][:, grasping, 1],
                               atol=1e-6)
    assert np.abs(pulses[1].values[late][:, 0, 1] - pulses[0].values[late][:, 0, 1]).max() > 1e-6


def test_angles_are_scored_until_the_object_may_be_touched(learnt):
    result, recording = learnt
    truth, wanted = (recording.signal(name, 2) for name in ("truth.synergies", "reference.angles"))
    inside = (truth.times_ns >= 2.0e9) & (truth.times_ns <= 4.4e9)
    held = np.searchsorted(wanted.times_ns, truth.times_ns[inside], side="right") - 1
    error = np.degrees(truth.values[inside] - wanted.values[held])
    assert result.metrics["joint_rmse_deg"][2] == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.02)


def test_a_model_of_another_patient_is_refused_with_its_remedy():
    with pytest.raises(InputErrors, match=r"model is of 'sci_c6'.*'able_bodied'.*identify this one"):
        load("grasp_ilc", ["patient=able_bodied"])


def test_an_unknown_model_is_refused_with_those_that_are_shipped():
    with pytest.raises(InputErrors, match="grasp_sci_c6"):
        load("grasp_ilc", ["model=grasp_sci_c5"])

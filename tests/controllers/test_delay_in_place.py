"""Controllers that reckon with a delay say so where the wires have another one."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.apps.cli.check_command import _cautions
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import Experiment
from fesloop.loop.cautions import cautions_in_place

ACTUATION = 'wires."safety.stimulation->patient.stimulation".latency_ms'
PERIOD_MS = 20.0


def cautions(experiment: Experiment):
    """What blocks fear of their place."""
    return cautions_in_place(experiment.wiring, experiment.duration_ns)


@settings(deadline=None, max_examples=8)
@given(control=st.sampled_from(["mpc", "ilc"]), told_ms=st.integers(0, 120), latency_ms=st.integers(0, 120))
def test_a_delay_that_is_not_the_wires_is_named_with_what_to_set(control, told_ms, latency_ms):
    experiment = load("finger_control", [f"control={control}", f"{ACTUATION}={latency_ms}",
                                         f"blocks.controller.actuation_delay_ms={told_ms}"])
    found = cautions(experiment)
    if abs(latency_ms - told_ms) <= PERIOD_MS:
        assert found == []
    else:
        ((node, status, detail),) = found
        assert (node, status) == ("controller", "delay_differs")
        assert f"actuation_delay_ms is {told_ms}, " in detail
        assert f"set actuation_delay_ms = {latency_ms}" in detail
        assert ("may diverge" in detail) == (control == "ilc")


@pytest.mark.slow
def test_check_and_the_trials_themselves_agree_that_the_law_diverges(tmp_path):
    linear = "recruitment_curve=linear"
    late = ["control=ilc", "tracker=ideal", "experiment.trials=10", f"{ACTUATION}=150",
            "blocks.patient.speed=1", "blocks.patient.strength=1", f"blocks.patient.{linear}",
            f"blocks.controller.model.{linear}", "blocks.controller.law=noilc", "blocks.controller.slew=1",
            "blocks.controller.change_weight=0.02"]
    stopped = load("finger_control", late).run(out=tmp_path).metrics["joint_rmse_deg"]
    assert stopped[-1] < 1.5 * min(stopped)
    late.append("blocks.controller.stop_after=0")
    errors = {}
    for told_ms in (0, 150):
        experiment = load("finger_control", [*late, f"blocks.controller.actuation_delay_ms={told_ms}"])
        errors[told_ms] = experiment.run(out=tmp_path).metrics["joint_rmse_deg"]
        assert any("may diverge" in detail for *_, detail in _cautions(experiment)) == (told_ms == 0)
    assert errors[150][-1] == min(errors[150])
    assert errors[0][-1] > 4.0 * min(errors[0])


@pytest.mark.parametrize(("aligned", "age_ms", "named"), [
    (True, 100, False), (False, 100, True), (False, 10, False)])
def test_the_age_of_samples_counts_where_captures_are_not_aligned(aligned, age_ms, named):
    experiment = load("finger_control", [
        "control=ilc", f"latency_ms={age_ms}", f"blocks.controller.align_captures={str(aligned).lower()}"])
    details = [detail for *_, detail in cautions(experiment)]
    assert len(details) == named
    assert all("align_captures = false" in detail and "may diverge" in detail for detail in details)


@pytest.mark.parametrize("name", ["finger_control", "finger_ilc", "finger_mpc", "grasp_ilc", "grasp_mpc",
                                  "hil_dry_stimulator", "open_close_ilc", "pinch_mpc"])
def test_shipped_controllers_know_their_delays(name):
    assert cautions(load(name)) == []

"""Identification of the virtual hand through IMUs and tracker, shortened. About 25 s."""

import json

import pytest

import fesloop
from fesloop import Recording
from fesloop.apps.cli import main

SHORT = ("duration_s=56", "blocks.excitation.stair_s=0.4", "blocks.excitation.rest_s=1.0",
         "blocks.excitation.prbs_s=24")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return fesloop.load("identify_patient", SHORT).run(tmp_path_factory.mktemp("runs")).recording


def identified(recording, capsys, *options):
    path = recording.parent / "model.toml"
    path.unlink(missing_ok=True)
    assert main(["identify", str(recording), "--out", str(path), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.slow
def test_the_watchdog_lets_a_moving_hand_alone_and_no_sensor_is_taken_for_late(recording):
    with Recording(recording) as read:
        assert not [event for event in read.events
                    if event.status.startswith("posture_") or event.status == "late_sensor"]


@pytest.mark.slow
def test_through_the_tracker_as_from_the_hand_itself(recording, capsys):
    """What the tracker adds to the model's own error, with drift, is small beside it; curves agree."""
    seen = identified(recording, capsys)
    true = identified(recording, capsys, "--measured", "truth.synergies")
    for name, least in (("mcp_flexion", 75.0), ("pip_flexion", 60.0), ("thumb_flexion", 75.0)):
        assert seen["fit_percent"]["free_run"][name] > least
        assert seen["fit_percent"]["free_run"][name] > true["fit_percent"]["free_run"][name] - 8.0
        assert seen["fit_percent"]["one_step"][name] > 90.0
    for ours, theirs in zip(seen["channels"], true["channels"], strict=True):
        assert ours["threshold_us"] == pytest.approx(theirs["threshold_us"], rel=0.25)


@pytest.mark.slow
def test_the_file_is_taken_for_this_patient_and_no_other(recording, capsys):
    identified(recording, capsys)
    model = f'{{ file = "{recording.parent / "model.toml"}" }}'
    capsys.readouterr()
    for patient, taken in (("able_bodied", True), ("sci_c6", False)):
        path = recording.parent / f"{patient}.toml"
        path.write_text(_controlled(patient, model))
        assert (main(["check", str(path)]) == 0) is taken
    assert "the model is of 'able_bodied'; allowed: 'sci_c6'" in capsys.readouterr().err


def _controlled(patient, model):
    """An experiment in which MPC has the model, open loop."""
    return f"""
[experiment]
name = "controlled"
duration_s = 1.0
[patient]
file = "{patient}"
[blocks.reference]
kind = "minimum_jerk"
rate = "40"
times_s = [0.1]
angles_deg = [[40.0, 40.0, 15.0]]
[blocks.controller]
kind = "mpc"
rate = "40"
model = {model}
[[wires]]
from = "reference.angles"
to = "controller.reference"
[[wires]]
from = "reference.angles"
to = "controller.measured"
"""

"""One loop from reference to tracker around five plants. About 15 s."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import fesloop
from fesloop import Recording
from fesloop.apps.cli import main

WHOLE_HAND = Path(__file__).parents[1] / "whole_hand.toml"


def plants():
    marks = {"myohand": lambda: pytest.importorskip("myo_sim"),
             "fmu": lambda: shutil.which("gcc") or pytest.skip("no gcc")}
    return [pytest.param(name, marks.get(name), id=name)
            for name in ("hand", "myohand", "finger", "fmu", "state_space")]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs an option of the plant, once."""
    done = {}

    def result(name):
        if name not in done:
            # Muscles that vary from trial to trial hide what a single one has taught.
            same = ["blocks.muscles.variation.scale=0"] if name in ("hand", "myohand") else []
            done[name] = fesloop.load(WHOLE_HAND, [f"plant={name}", *same]).run(tmp_path_factory.mktemp(name))
        return done[name]

    return result


@pytest.mark.slow
@pytest.mark.parametrize(("plant", "need"), plants())
def test_every_plant_is_learnt_through_the_same_blocks(run, plant, need):
    """What a trial teaches shows in the next; controller, safety and score are the file's."""
    if need:
        need()
    result = run(plant)
    seen = result.metrics["split_rmse_deg"]["controller"]
    assert seen[0] > 4.0
    assert seen[1] < 0.5 * seen[0]
    with Recording(result.recording) as recording:
        blocks = recording.experiment["blocks"]
        assert blocks["controller"]["law"] == "noilc_constrained"
        assert blocks["safety"]["watchdog"]["recover_s"] == 0.2
        assert recording.experiment["score"]["reference"] == "reference.angles"
        known = set(blocks)
        for wire in recording.experiment["wires"]:
            assert {end.partition(".")[0] for end in (wire["from"], wire["to"])} <= known


def test_the_fmu_is_the_finger_and_both_are_controlled_in_their_joints(run):
    """The exported finger steps at 1 kHz, on which every instant of this wiring lies."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    with Recording(run("finger").recording) as finger, Recording(run("fmu").recording) as fmu:
        for trial in (0, 1):
            one, other = (each.signal("truth.synergies", trial).values for each in (finger, fmu))
            assert one.shape[1] == 3
            assert np.ptp(one) > (0.2 if trial else 0.0)
            np.testing.assert_allclose(other, one, rtol=0, atol=1e-6)


def test_of_a_plant_that_is_the_model_one_trial_teaches_all(run):
    """Reference, controller, limits and score are the whole hand's; what is left is the tracker's noise."""
    assert run("state_space").metrics["joint_rmse_deg"][1] < 0.7
    told, whole = (fesloop.load(WHOLE_HAND, settings).document() for settings in (["plant=state_space"], []))
    assert told["blocks"]["reference"] == whole["blocks"]["reference"]
    assert told["blocks"]["controller"] == whole["blocks"]["controller"]
    assert told["score"] == whole["score"]


def test_a_recording_repeats_its_plant_to_the_bit(run, tmp_path, capsys):
    result = run("finger")
    assert main(["run", str(result.recording), "--out", str(tmp_path), "--json"]) == 0
    capsys.readouterr()
    again, = tmp_path.glob("*.h5")
    with Recording(result.recording) as one, Recording(again) as other:
        assert one.fingerprint == other.fingerprint
        for signal in ("finger.angles", "tracker.angles", "controller.stimulation"):
            assert np.array_equal(one.signal(signal, 1).values, other.signal(signal, 1).values)


def test_an_alias_of_the_hand_alone_is_none_of_the_finger(capsys):
    assert main(["check", str(WHOLE_HAND), "--set", "brace={}"]) == 0
    assert main(["check", str(WHOLE_HAND), "--set", "plant=finger", "--set", "brace={}"]) == 2
    assert "--set brace: is no key of" in capsys.readouterr().err
    assert main(["check", str(WHOLE_HAND), "--set", "plant=finger", "--set", "patient=sci_c6"]) == 2
    assert "with plant=finger; allowed: plant, latency_ms, model, strength, speed" in capsys.readouterr().err
    assert main(["check", str(WHOLE_HAND), "--set", "strength=1.3", "--set", "plant=finger"]) == 0

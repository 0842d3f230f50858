"""Variants of shipped experiments: every option makes an experiment; plants are identified by one door.

About 35 s.
"""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import fesloop
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import read
from fesloop.experiment.files.source import shipped
from fesloop.experiment.files.variants import listed
from fesloop.hand.movements import FREEDOMS
from fesloop.loop.block import Context
from fesloop.models.error_process import ErrorProcess, ErrorSeries

WHOLE_HAND = Path(__file__).parents[1] / "whole_hand.toml"
OPTIONS = [(name, variant, option) for name in shipped() for variant, table in listed(read(name)[1]).items()
           for option in table["options"]]


def need(option):
    if option == "myohand":
        pytest.importorskip("myo_sim")
    if option == "fmu" and shutil.which("gcc") is None:
        pytest.skip("no gcc")


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    """Some seconds of three sums of a hand, for what follows a recording."""
    experiment = fesloop.load("identify_grasp", ["duration_s=5.5"])
    return experiment.run(tmp_path_factory.mktemp("moved")).recording


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Model with channels of its own, from a sweep over some elements."""
    folder = tmp_path_factory.mktemp("swept")
    elements = [16, 17, 9, 28, 29, 43, 44, 46, 49, 50, 51, 53]
    settings = [f"blocks.sweep.elements={elements}", "experiment.duration_s=35"]
    recording = fesloop.load("sweep_grasp", settings).run(folder).recording
    fesloop.identify(recording).save(folder / "swept.toml")
    return folder / "swept.toml"


@pytest.fixture(scope="module")
def given(moved, swept, tmp_path_factory):
    """Settings that name the files which an option of an experiment cannot do without."""
    folder = tmp_path_factory.mktemp("given")
    finger = fesloop.load("finger_control", ["experiment.duration_s=1"]).run(folder).recording
    ErrorProcess(series=(ErrorSeries(name="a", fast_deg=1.0, fast_s=0.1),)).save(folder / "error.toml")

    def files(name, option):
        if option == "error_replay" or (name == "hil_error_replay" and option != "ideal"):
            return [f"error={folder / 'error.toml'}"]
        if option == "model":
            return [f"model={swept}", "follow=fingers"]
        if name == "hil_twin":
            return [f"recording={moved if option == 'hand' else finger}"]
        return [f"reference_file={moved}"] if option == "recorded" else []

    return files


@pytest.mark.slow
@pytest.mark.parametrize(("name", "variant", "option"), OPTIONS)
def test_every_option_makes_an_experiment_and_says_what_it_is(name, variant, option, given):
    need(option)
    if name == "array_search_gp":
        pytest.importorskip("sklearn", reason="the extra `search`")
    experiment = fesloop.load(name, [f"{variant}={option}", *given(name, option)])
    table = listed(read(name)[1])[variant]
    told = table["options"][option]
    assert told
    assert experiment.description.endswith(f"; {variant} {option}: {told}") is (option != table["default"])


@pytest.mark.slow
def test_a_finger_is_identified_as_a_hand_is(tmp_path, capsys):
    """Thresholds are those that the finger is made with; ILC learns by the model, which is no hand's."""
    recording = fesloop.load("identify_grasp", ["plant=finger"]).run(tmp_path).recording
    assert main(["identify", str(recording), "--out", str(tmp_path / "model.toml"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["patient"], told["outputs"]) == ("", ["MCP", "PIP", "DIP"])
    for channel, threshold_ma in zip(told["channels"], (12.0, 10.0, 10.0, 8.0), strict=True):
        # The same pulse recruits half: the finger's chronaxie is 200 us, the identification's 122.
        half_us = 200.0 * threshold_ma / (40.0 - threshold_ma)
        assert channel["half_ma"] == pytest.approx(40.0 / (1.0 + 122.0 / half_us), rel=0.15)
    for joint, least in (("MCP", 85.0), ("PIP", 85.0), ("DIP", 65.0)):
        assert told["fit_percent"]["free_run"][joint] > least
        assert told["fit_percent"]["one_step"][joint] > 95.0
    model = f'model={{file = "{tmp_path / "model.toml"}"}}'
    errors = fesloop.load(WHOLE_HAND, ["plant=finger", model]).run(tmp_path).metrics["joint_rmse_deg"]
    assert errors[1] < 0.5 * errors[0]
    with pytest.raises(InputError, match="patient: the model is of ''; allowed: 'able_bodied'"):
        fesloop.load(WHOLE_HAND, [model])


@pytest.mark.slow
@pytest.mark.parametrize("plant", ["finger", "fmu"])
def test_a_finger_learns_the_phases_of_a_grasp_from_the_model_that_was_identified(plant, tmp_path):
    """From trial to trial better, through IMUs and tracker, in its own joints."""
    need(plant)
    metrics = fesloop.load("grasp_ilc", [f"plant={plant}", "trials=5"]).run(tmp_path).metrics
    errors = metrics["joint_rmse_deg"]
    assert errors[0] > 4.0
    assert errors[-1] < 1.2
    assert list(metrics["joints"]) == ["MCP", "PIP", "DIP"]
    assert "held" not in metrics


@pytest.mark.parametrize("settings", [("plant=finger", "tracker=ideal"), ("plant=finger", "scene=free")])
def test_what_a_finger_has_none_of_is_refused_beside_it(settings):
    with pytest.raises(InputError, match="does not go with") as refused:
        fesloop.load("grasp_ilc", settings)
    assert "variants.plant.finger" in str(refused.value)


@pytest.mark.slow
@pytest.mark.parametrize("plant", ["finger", "fmu"])
def test_a_finger_is_led_through_a_grasp_by_prediction_at_once(plant, tmp_path):
    need(plant)
    metrics = fesloop.load("grasp_mpc", [f"plant={plant}"]).run(tmp_path).metrics
    assert metrics["joint_rmse_deg"][0] < 1.0
    assert list(metrics["joints"]) == ["MCP", "PIP", "DIP"]


@pytest.mark.parametrize("experiment", ["grasp_ilc", "grasp_mpc"])
def test_myohand_takes_the_hands_place_and_all_else_but_its_stated_pose_is_the_same(experiment):
    need("myohand")
    whole, other = (fesloop.load(experiment, [f"plant={plant}"]).document() for plant in ("hand", "myohand"))
    assert other["blocks"]["hand"]["kind"] == "myohand"
    stated = [tables["blocks"]["tracker"].pop("mounting_sd_deg") for tables in (whole, other)]
    stated += [tables["blocks"]["tracker"]["initial_angles_deg"].pop("F1_cmc_pronation")
               for tables in (whole, other)]
    assert stated == [5.0, 8.0, 100.0, 110.0]
    (note,) = other["experiment"].pop("notes")
    assert "was identified on another hand" in note
    for tables in (whole, other):
        del tables["blocks"]["hand"], tables["experiment"]["description"]
    assert other == whole


@pytest.mark.parametrize("experiment", ["grasp_mpc", "key_mpc"])
def test_the_tracker_of_myohand_is_told_the_pose_that_its_brace_holds(experiment):
    """To within 2 deg: a tracked thumb turns by 110 deg at most, MyoHand's by 112."""
    need("myohand")
    parts = {node.name: node.part for node in fesloop.load(experiment, ["plant=myohand"]).nodes}
    hand = parts["hand"]
    angles = dict(zip(FREEDOMS, np.degrees(hand.read(hand.init(Context("hand")), [])[0]), strict=True))
    told = parts["tracker"].initial_angles_deg
    held = [name for name in told if name in hand.splint_deg]
    assert "F1_cmc_pronation" in held
    assert max(abs(angles[name] - told[name]) for name in held) < 2.0

"""Elements and model from a sweep: on hands that are what the method assumes, and on a virtual person."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from controllers.identification.elements import (
    CHRONAXIE_US,
    THUMB,
    WRIST,
    Responses,
    choose_elements,
    curve_of,
    model_of,
)
from controllers.identification.file import identify_recording
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.models.patient_model import load_patient_model

OUTPUTS = (WRIST, "F2_flexion", "F3_flexion", "F4_flexion", "F5_flexion", THUMB)
CURRENTS = np.array([5.0, 8.0, 12.0, 17.0, 23.0, 29.0])
WIDTH_US = 250.0
EFFECTIVE = CURRENTS * WIDTH_US / (WIDTH_US + CHRONAXIE_US)
REST = np.radians([0.0, 40.0, 40.0, 40.0, 40.0, 20.0])
SHARES = st.floats(-1.0, 1.0)
MODEL = ["follow=fingers", "channels=model", "any_patient=true"]


def moved_by(gain, threshold_ma=8.0, spread=0.45):
    """Responses (currents, outputs) of an element whose whole recruitment moves the hand by `gain`, rad."""
    return np.outer(ndtr(np.log(EFFECTIVE / threshold_ma) / spread), gain)


@given(st.floats(4.0, 14.0), st.sampled_from([0.3, 0.45, 0.6]), st.lists(SHARES, min_size=6, max_size=6))
@settings(deadline=None)
def test_a_curve_is_found_that_gives_the_responses(threshold_ma, spread, gain):
    seen = moved_by(np.array(gain), threshold_ma, spread)
    if np.abs(seen).max() < 0.1:
        return
    curve = curve_of(EFFECTIVE, seen)
    told = moved_by(curve.gain, curve.threshold_ma, curve.spread)
    assert np.abs(told - seen).max() < 0.03 * np.abs(seen).max()
    assert curve.fit_percent > 60.0


def test_currents_that_were_left_out_do_not_count():
    seen = moved_by(np.ones(6), 6.0)
    seen[4:] = np.nan
    curve = curve_of(EFFECTIVE, seen)
    assert math.isclose(curve.threshold_ma, 6.0, rel_tol=0.2)


def hand(others=0):
    """Gains (elements, outputs), deg, of one element for each motion, then of `others` useless ones."""
    motions = np.array([
        [90.0, 24.0, 24.0, 24.0, 24.0, 24.0], [0.0, -40.0, -40.0, -40.0, -40.0, 0.0],
        [-10.0, 90.0, 0.0, 0.0, 0.0, 0.0], [-10.0, 0.0, 90.0, 0.0, 0.0, 0.0],
        [-10.0, 0.0, 0.0, 90.0, 0.0, 0.0], [-10.0, 0.0, 0.0, 0.0, 90.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 60.0], [-60.0, -16.0, -16.0, -16.0, -16.0, -16.0]])
    return np.concatenate([motions, np.full((others, 6), 1.0)])


@given(st.permutations(range(12)), st.floats(5.0, 9.0))
@settings(deadline=None, max_examples=20)
def test_elements_that_reach_all_postures_are_chosen_wherever_they_are(order, threshold_ma):
    gains = hand(others=4)[list(order)]
    moved = np.array([moved_by(np.radians(gain), threshold_ma) for gain in gains])
    choice = choose_elements(Responses(currents_ma=CURRENTS, width_us=WIDTH_US, moved=moved, rest=REST,
                                       outputs=OUTPUTS), 8, 34.0)
    assert sorted(np.array(order)[list(choice.elements)]) == list(range(8))
    assert np.abs(choice.missed_deg[:2]).max() < 8.0
    named = [order[element] for element in choice.elements]
    assert {named[c] for c in choice.closing} == {2, 3, 4, 5, 6}
    assert {named[c] for c in range(8) if c not in choice.grasping} == {0, 7}


def test_a_hand_that_hardly_any_element_moves_is_refused():
    moved = np.array([moved_by(np.radians(gain)) for gain in hand()[:3]])
    with pytest.raises(InputError, match=r"3 of 3 move the hand .* 8, one a channel"):
        choose_elements(Responses(currents_ma=CURRENTS, width_us=WIDTH_US, moved=moved, rest=REST,
                                  outputs=OUTPUTS), 8, 34.0)


def test_the_model_settles_at_the_gains():
    moved = np.array([moved_by(np.radians(gain)) for gain in hand()])
    choice = choose_elements(Responses(currents_ma=CURRENTS, width_us=WIDTH_US, moved=moved, rest=REST,
                                       outputs=OUTPUTS), 8, 34.0)
    model = model_of(choice, REST, np.full(6, 0.1))
    static = model.c @ np.linalg.solve(-model.a, model.b)
    np.testing.assert_allclose(static.T, [curve.gain for curve in choice.curves], atol=1e-12)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Sweep of a person's best-placed elements, and its model's file."""
    folder = tmp_path_factory.mktemp("sweep")
    elements = [16, 17, 9, 10, 28, 29, 43, 44, 46, 49, 50, 51, 53, 55]
    chosen = [f"blocks.sweep.elements={elements}", "experiment.duration_s=40"]
    found = run(load("sweep_grasp", chosen), folder)
    identified = identify_recording(str(found.recording))
    identified.model.save(folder / "own.toml")
    return identified, folder / "own.toml", set(elements)


def test_a_sweep_gives_a_model_that_a_grasp_takes(swept, tmp_path):
    identified, file, elements = swept
    assert set(identified.choice.elements) <= elements
    assert json.loads(json.dumps(identified.report()))["usable"]
    again = load_patient_model(file)
    assert (again.closing, again.grasping) == (identified.choice.closing, identified.choice.grasping)
    experiment = load("grasp_mpc", [*MODEL, f"model={file}"])
    blocks = experiment.document()["blocks"]
    assert [each["elements"] for each in blocks["stimulator"]["electrodes"]] == [
        [element] for element in identified.choice.elements]
    assert blocks["grip"]["closing"] == list(again.closing)
    assert blocks["controller"]["grasping_channels"] == list(again.grasping)
    assert run(experiment, tmp_path).status == "done"


def test_a_posture_that_no_element_reaches_is_said(swept):
    identified, *_ = swept
    far = {f"{name} nearer than {abs(value):.0f} deg to the {posture.name} hand"
           for posture, row in zip(identified.task, identified.choice.missed_deg, strict=True)
           for name, value in zip(OUTPUTS, row, strict=True) if abs(value) > 8.0}
    assert far
    told = {doubt.removeprefix("no elements bring ").partition(":")[0] for doubt in identified.doubts()}
    assert told == far


@pytest.mark.parametrize(("member", "told"), [([], False), (["cohort=1", "member=3"], True)])
def test_a_model_of_another_person_is_taken_with_a_word(member, told):
    notes = load("grasp_mpc", [*member, "any_patient=true"]).notes
    assert any("is of another person: of sci_c6" in note for note in notes) is told


@pytest.mark.parametrize(("line", "becomes", "message"), [
    ("electrodes = [", 'electrodes = ["fifty", ', "electrodes: 'fifty'; allowed: numbers of elements"),
    ("closing = [", "closing = [11, ", "closing: channel 11; allowed: 0 to 7"),
    ("closing = ", "# closing = ", "no channel of .* closes the hand")])
def test_channels_that_cannot_be_are_named(swept, tmp_path, line, becomes, message):
    text = swept[1].read_text()
    assert text.count(line) == 1
    spoilt = tmp_path / "spoilt.toml"
    text = text.replace(line, becomes)
    if "fifty" in becomes:  # one electrode too many is another fault
        head, _, rest = text.partition('"fifty", ')
        text = f'{head}"fifty", {rest.partition(", ")[2]}'
    spoilt.write_text(text)
    with pytest.raises(InputError, match=message):
        load("grasp_mpc", [*MODEL, f"model={spoilt}"])


def test_a_model_without_channels_of_its_own_is_refused():
    with pytest.raises(InputError, match=r"model.channels: true, and grasp_sci_c6 has no channels"):
        load("grasp_mpc", ["channels=model"])

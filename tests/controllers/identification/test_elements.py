"""Elements and model from a sweep: on hands that are what the method assumes, and on a virtual person."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from scipy.special import ndtr

import fesloop
from controllers.identification.elements import (
    CHRONAXIE_US,
    GRASP,
    LAGS_S,
    THUMB,
    WEIGHTS,
    WRIST,
    Responses,
    choose_elements,
    curve_of,
    grasp_task,
    model_of,
)
from controllers.identification.file import identify_recording
from controllers.identification.sweep import Swept, lags_of, responses_of
from controllers.trajectories import response
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


@given(st.floats(0.5, 120.0), st.sampled_from([0.1, 0.3, 0.45, 0.6, 1.2]))
@settings(deadline=None)
def test_a_fit_at_the_end_of_what_is_tried_is_marked_and_no_other(threshold_ma, spread):
    """Values 2 to 60 mA are tried, and spreads of .3, .45 and .6."""
    effective = np.geomspace(0.2, 300.0, 60)
    curve = curve_of(effective, np.outer(ndtr(np.log(effective / threshold_ma) / spread), np.ones(6)))
    half, width = curve.at_bound.get("half_ma"), curve.at_bound.get("spread")
    found = curve.threshold_ma
    assert half == ("or less" if found < 2.05 else "or more" if found > 58.0 else None)
    tried = spread in (0.3, 0.45, 0.6)  # another one moves the threshold that fits best
    if 2.5 < threshold_ma < 50.0:
        assert half is None or not tried
        assert width == ("or less" if spread < 0.4 else "or more" if spread > 0.5 else None)
    if tried and not 1.9 < threshold_ma < 64.0:
        assert half


def test_edges_and_weak_fits_are_marked_in_the_table_and_explained(swept, capsys):
    from fesloop.apps.cli.identify_command import _print

    identified, *_ = swept
    report = identified.report()
    report["channels"][0] |= {"fit_percent": 41.0, "at_bound": {"half_ma": "or more"}, "half_ma": 60.0}
    _print(report)
    told = capsys.readouterr().err
    assert re.search(r"^ +0 .* 60\.00 or more .* 41 weak", told, re.MULTILINE)
    assert "'weak': a fit below 50 %" in told
    assert "the patient's value may lie beyond" in told
    for row in report["channels"]:
        row |= {"fit_percent": 50.0, "at_bound": {}}
    _print(report)
    told = capsys.readouterr().err
    assert "weak" not in told
    assert "lie beyond" not in told


@given(st.floats(3.0, 14.0), st.sampled_from([0.3, 0.45, 0.6]))
@settings(deadline=None)
def test_a_pulse_of_400_us_at_the_current_of_a_channel_recruits_84_percent(threshold_ma, spread):
    curve = curve_of(EFFECTIVE, moved_by(np.ones(6), threshold_ma, spread))
    effective = curve.current_ma * 400.0 / (400.0 + CHRONAXIE_US)
    recruited = ndtr(math.log(effective / curve.threshold_ma) / curve.spread)
    assert recruited == pytest.approx(0.841, abs=0.05)  # currents are in steps of .5 mA


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
    assert np.abs(choice.missed_deg[:2]).max() < 9.0
    named = [order[element] for element in choice.elements]
    assert {named[c] for c in choice.closing} == {2, 3, 4, 5, 6}
    assert {named[c] for c in range(8) if c not in choice.grasping} == {0, 7}


def test_a_hand_that_hardly_any_element_moves_is_refused():
    moved = np.array([moved_by(np.radians(gain)) for gain in hand()[:3]])
    with pytest.raises(InputError, match=r"3 of 3 move the hand .* 8, one a channel"):
        choose_elements(Responses(currents_ma=CURRENTS, width_us=WIDTH_US, moved=moved, rest=REST,
                                  outputs=OUTPUTS), 8, 34.0)


def seen_of(gains_deg, threshold_ma=6.0):
    """Responses of elements with these gains (elements, outputs), deg, and one threshold."""
    return Responses(currents_ma=CURRENTS, width_us=WIDTH_US, rest=REST, outputs=OUTPUTS,
                     moved=np.array([moved_by(np.radians(gain), threshold_ma) for gain in gains_deg]))


def test_an_element_whose_responses_are_no_curve_is_not_chosen():
    seen = seen_of([*hand(), *hand()[:1]])
    seen.moved[8] = np.radians(90.0) * np.outer([1.0, 0.0, 1.0, 0.0, 1.0, 0.0], np.eye(6)[0])
    seen.moved[0] *= 0.5
    assert 8 not in choose_elements(seen, 8, 34.0).elements


def test_no_channel_has_more_than_the_greatest_current_and_weaker_elements_count_less():
    seen = seen_of(hand(), threshold_ma=12.0)
    choice = choose_elements(seen, 8, 14.0)
    assert set(choice.currents_ma) == {14.0}
    assert min(choose_elements(seen, 8, 60.0).currents_ma) > 14.0
    with pytest.raises(InputError, match="0 of 8 move the hand"):
        choose_elements(seen, 8, 3.0)


@pytest.mark.parametrize("opened_deg", [-31.0, 60.5, math.nan])
def test_a_hand_cannot_be_asked_to_open_in_any_way(opened_deg):
    with pytest.raises(InputError, match=r"^opened_deg: .*-30 to 60 deg"):
        grasp_task(opened_deg)


def test_a_hand_that_opens_wider_misses_what_its_elements_cannot_extend():
    """One element extends all fingers by up to 34 deg from 40: more is not there."""
    gains = np.array([[20.0, *[-57.0] * 4, 0.0], [-20.0, *[60.0] * 4, 20.0], [30.0, *[0.0] * 4, 0.0]])
    missed = [choose_elements(seen_of(gains), 3, 34.0, grasp_task(deg)).missed_deg for deg in (18.0, 8.0)]
    assert np.all(missed[1][0][1:5] > missed[0][0][1:5] + 3.0)
    np.testing.assert_array_equal(missed[0][1:], missed[1][1:])


def cost(gains_deg, threshold_ma):
    """Cost of a choice, written out."""
    rest, total = np.degrees(REST), 0.0
    weight = np.array([WEIGHTS[name] for name in OUTPUTS])[:, np.newaxis]
    for posture in GRASP:
        wanted = np.array([posture.deg.get(name, at) - at for name, at in zip(OUTPUTS, rest, strict=True)])
        effort = 4.0 * (0.5 + threshold_ma / 12.0) * np.eye(len(gains_deg))
        found = lsq_linear(np.vstack([weight * gains_deg.T, effort]),
                           np.concatenate([weight[:, 0] * wanted, np.zeros(len(gains_deg))]),
                           (0.0, posture.most))
        total += 2.0 * posture.weight * found.cost
    return total


@given(st.integers(0, 2**31))
@settings(deadline=None, max_examples=15)
def test_no_other_single_element_makes_a_choice_better(seed):
    gains = np.random.default_rng(seed).normal(0.0, 40.0, (14, 6))
    seen = seen_of(gains)
    choice = choose_elements(seen, 3, 34.0)
    curves = [curve_of(EFFECTIVE, each) for each in seen.moved]
    longest = 400.0 / (400.0 + CHRONAXIE_US)
    recruited = [ndtr(math.log(min(curve.current_ma, 34.0) * longest / curve.threshold_ma) / curve.spread)
                 for curve in curves]
    fitted = np.degrees([share * curve.gain for share, curve in zip(recruited, curves, strict=True)])
    threshold_ma = choice.curves[0].threshold_ma
    chosen = list(choice.elements)
    least = cost(fitted[chosen], threshold_ma)
    others = [[*chosen[:i], e, *chosen[i + 1:]] for i in range(3) for e in range(14) if e not in chosen]
    assert min(cost(fitted[other], threshold_ma) for other in others) > 0.97 * least - 1.0


def sweep_of(lag_s, passed=True):
    """Course of a sweep on `hand`, whose outputs have one lag; `passed`: whether safety passed all of it."""
    choice = choose_elements(seen_of(hand()), 8, 34.0)
    turn, stairs = np.arange(120), np.repeat([0, 1, 2, 3, 4, 5, -1], [12] * 6 + [48])
    element = np.repeat(choice.elements, turn.size)
    stair, pulses = np.tile(stairs, 8), np.zeros((element.size, 2))
    pulses[stair >= 0] = np.column_stack([1e-3 * CURRENTS[stair[stair >= 0]],
                                          np.full((stair >= 0).sum(), 1e-6 * WIDTH_US)])
    if not passed:
        pulses[stair == 4] = 0.0
    model, measured = model_of(choice, REST, np.full(6, lag_s)), []
    for c in range(8):
        given_to = np.zeros((turn.size, 8, 2))
        given_to[:, c] = pulses[c * turn.size:(c + 1) * turn.size]
        drives = np.array([model.recruitment.fraction(row) for row in given_to])
        measured.append(REST + response(model.sampled(25_000_000, 0), drives))
    return choice, Swept(times_s=0.025 * np.arange(element.size), element=element, stair=stair,
                         stimulation=pulses, measured=np.concatenate(measured))


@pytest.mark.parametrize("lag_s", LAGS_S[1:])
def test_the_lag_of_a_sweep_is_found(lag_s):
    choice, swept = sweep_of(lag_s)
    lags_s, fit = lags_of(swept, choice, REST)
    assert lags_s.tolist() == [lag_s] * 6
    assert min(fit) > 99.0


def test_a_current_that_safety_did_not_pass_is_no_response():
    swept = sweep_of(0.05, passed=False)[1]
    seen = responses_of(swept, CURRENTS, WIDTH_US, 8, OUTPUTS)
    assert np.isnan(seen.moved[:, 4]).all()
    assert np.isfinite(seen.moved[:, [0, 1, 2, 3, 5]]).all()


def test_a_recording_without_a_turn_is_refused():
    swept = sweep_of(0.05)[1]
    with pytest.raises(InputError, match="stimulated no element"):
        responses_of(replace(swept, stair=np.full_like(swept.stair, -1)), CURRENTS, WIDTH_US, 8, OUTPUTS)


def test_a_recording_without_a_pulse_names_what_may_have_withheld_it():
    swept = sweep_of(0.05)[1]
    silent = replace(swept, stimulation=np.zeros_like(swept.stimulation))
    with pytest.raises(InputError, match=r"no pulse passed safety .* `pose_contradicted`"):
        responses_of(silent, CURRENTS, WIDTH_US, 8, OUTPUTS)


def test_a_sweep_of_other_outputs_is_refused(tmp_path):
    found = run(load("recruitment_sweep", ["elements=[16, 43]", "duration_s=1"]), tmp_path)
    with pytest.raises(InputError, match=r"hand.angles: has no F2_flexion, .*; sweep with sweep_grasp"):
        identify_recording(str(found.recording), measured="hand.angles")


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


def test_elements_are_chosen_for_the_opening_that_is_asked_for(swept):
    recording = next(swept[1].parent.glob("sweep_grasp-*.h5"))
    usual, wider = (identify_recording(str(recording), opened_deg=deg) for deg in (18.0, 8.0))
    assert usual.report() == swept[0].report()
    missed = [each.report()["missed_deg"]["opened"] for each in (usual, wider)]
    reached = [deg + np.mean([row[f"F{i}_flexion"] for i in range(2, 6)])
               for deg, row in zip((18.0, 8.0), missed, strict=True)]
    assert reached[1] < reached[0] - 3.0
    with pytest.raises(InputError, match=r"^opened_deg: 61; allowed: -30 to 60 deg"):
        fesloop.identify(recording, opened_deg=61.0)


def test_a_sweep_gives_a_model_that_a_grasp_takes(swept, tmp_path):
    identified, file, elements = swept
    assert set(identified.choice.elements) <= elements
    assert json.loads(json.dumps(identified.report()))["usable"]
    again = load_patient_model(file)
    assert (again.closing, again.grasping) == (identified.choice.closing, identified.choice.grasping)
    assert again.plant == "hand"
    assert again.misses() == identified.model.misses()
    experiment = load("grasp_mpc", [*MODEL, f"model={file}"])
    blocks = experiment.document()["blocks"]
    assert [each["elements"] for each in blocks["stimulator"]["electrodes"]] == [
        [element] for element in identified.choice.elements]
    assert blocks["grip"]["closing"] == list(again.closing)
    assert blocks["controller"]["grasping_channels"] == list(again.grasping)
    assert run(experiment, tmp_path).status == "done"
    pid = load("grasp_mpc", [*MODEL, f"model={file}", "control=tuned_pid"]).document()["blocks"]
    assert pid["stimulator"] == blocks["stimulator"]
    assert pid["grip"]["closing"] == list(again.closing)
    assert pid["controller"]["current_ma"] == blocks["controller"]["current_ma"]


def test_a_posture_that_no_element_reaches_is_said(swept):
    identified, *_ = swept
    far = {f"{name} nearer than {abs(value):.0f} deg to the {posture.name} hand"
           for posture, row in zip(GRASP, identified.choice.missed_deg, strict=True)
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

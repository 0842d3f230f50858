import json
import shlex
import tomllib
from dataclasses import replace
from importlib import resources

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from fesloop.experiment.files.patients import describe, drawn_patient, patient_fingerprint
from fesloop.experiment.registry import find
from fesloop.models.patient_model import PatientModel, load_patient_model


def a_model(**changed):
    nominal = find("finger")().linear_model()
    values = {"patient": "", "source": "a test", "outputs": ("MCP", "PIP", "DIP"), "electrodes": (),
              "current_ma": (40.0,) * 4, "rate": "50", "model": nominal, "operating_drive": np.full(4, 0.3),
              "operating_outputs": np.array([0.3, 0.4, 0.2]), "fit": {"free_run": {"MCP": 97.0}}}
    return PatientModel(**values | changed)


def controlled(model, **blocks):
    return {"experiment": {"name": "controlled", "duration_s": 1.0},
            "blocks": {"mpc": {"kind": "mpc", "rate": "50", "model": model},
                       "reference": {"kind": "minimum_jerk", "rate": "50", "times_s": [0.1],
                                     "angles_deg": [[20.0, 25.0, 15.0]]},
                       "finger": {"kind": "finger"}, **blocks},
            "wires": [{"from": "reference.angles", "to": "mpc.reference"},
                      {"from": "mpc.stimulation", "to": "finger.stimulation", "latency_ms": 1.0},
                      {"from": "finger.angles", "to": "mpc.measured"}]}


def test_a_file_comes_back_as_it_was(tmp_path):
    model = a_model(patient="sci_c6, member 3 of cohort 1, day 2",
                    electrodes=("16", "43+44 (0.3, 0.7)", "1", "2"))
    model.save(tmp_path / "model.toml")
    again = load_patient_model(tmp_path / "model.toml")
    assert again.table() == model.table()
    for name in ("a", "b", "c", "offset"):
        np.testing.assert_array_equal(getattr(again.model, name), getattr(model.model, name))
    assert again.model.recruitment == model.model.recruitment
    assert again.model.delay_ns == model.model.delay_ns == 20_000_000


def test_a_controller_takes_the_model_and_its_currents_and_the_recording_needs_no_file(tmp_path):
    a_model().save(tmp_path / "model.toml")
    experiment = from_document(controlled({"file": str(tmp_path / "model.toml")}))
    mpc = next(node.part for node in experiment.nodes if node.name == "mpc")
    assert mpc.current_ma == (40.0,) * 4
    np.testing.assert_array_equal(mpc.model.a, a_model().model.a)
    (tmp_path / "model.toml").unlink()
    assert from_document(experiment.document()) == experiment


@pytest.mark.parametrize(("changed", "blocks", "named"), [
    ({"patient": "sci_c6"}, {}, r"blocks.mpc.model: .*: patient: the model is of 'sci_c6'; allowed: ''"),
    ({"current_ma": (10.0, 40.0, 40.0, 40.0)}, {"current": [40.0] * 4},
     r"current_ma: the model is of \(10, 40, 40, 40\); allowed: \(40, 40, 40, 40\)"),
    ({"electrodes": ("16", "24", "9", "20")}, {"stimulator": {"kind": "stimulator", "electrodes": [
        {"elements": [n]} for n in (16, 24, 9, 21)]}},
     r"electrodes: the model is of \(16, 24, 9, 20\); allowed: \(16, 24, 9, 21\)"),
    ({}, {"synergies": {"kind": "synergies", "rate": "50", "rows": ["F2_flexion"]}},
     r"outputs: the model is of \(MCP, PIP, DIP\); allowed: \(F2_flexion\)"),
])
def test_names_both_where_a_model_is_for_something_else(tmp_path, changed, blocks, named):
    a_model(**changed).save(tmp_path / "model.toml")
    document = controlled({"file": str(tmp_path / "model.toml")}, **{
        name: table for name, table in blocks.items() if name != "current"})
    if "current" in blocks:
        document["blocks"]["mpc"]["current_ma"] = blocks["current"]
    with pytest.raises(InputError, match=named):
        from_document(document)


@pytest.mark.parametrize(("model_day", "day", "told"), [
    ({}, {}, None), ({"day": 2}, {"day": 2}, None), ({"day": 2, "error_scale": 2.0}, {"day": 2}, None),
    ({"day": 2}, {"day": 3}, "was identified on day 2, and this is day 3: "),
    ({"day": 12}, {}, "was identified on day 12, and this is no day in particular: "),
    ({}, {"day": 1}, "was identified on no day in particular, and this is day 1: ")])
def test_a_model_of_another_day_is_taken_with_a_caution(tmp_path, model_day, day, told):
    who = {"file": str(patient_file(tmp_path)), "member": 1}
    a_model(patient=describe(who | model_day)).save(tmp_path / "model.toml")
    model = {"file": str(tmp_path / "model.toml")}
    notes = from_document({**controlled(model), "patient": {**who, **day}}).notes
    assert [told in note for note in notes] == ([True] if told else [])
    anyone = controlled({**model, "any_patient": True})
    assert not from_document({**anyone, "patient": {**who, **day}}).notes


@given(st.lists(st.floats(-40.0, 40.0), min_size=6, max_size=6))
def test_what_a_model_says_that_its_elements_miss_is_noted_the_farthest_first(tmp_path_factory, angles):
    missed = {posture: dict(zip(("MCP", "PIP", "DIP"), angles[3 * i:3 * i + 3], strict=True))
              for i, posture in enumerate(("opened", "closed"))}
    path = tmp_path_factory.mktemp("missed") / "model.toml"
    a_model(missed_deg={**missed, "pressing": dict.fromkeys(missed["closed"], 50.0)}).save(path)
    notes = from_document(controlled({"file": str(path)})).notes
    far = sorted((f"{name} {abs(deg):.0f} deg from the {posture} hand" for posture, row in missed.items()
                  for name, deg in row.items() if abs(deg) > 8.0), key=lambda text: -int(text.split()[1]))
    begin = "the model mpc.model predicts that its elements leave "
    assert [note.startswith(begin) for note in notes] == [True] * bool(far)
    for note in notes:
        assert far[0].split()[1] in note.split(",")[0]
        assert sum(text in note for text in set(far)) >= min(3, len(set(far)))
        assert (f", and {len(far) - 3} more" in note) == (len(far) > 3)


@pytest.mark.parametrize(("identified_on", "hand", "told"), [
    ("hand", "myohand", True), ("myohand", "hand", True), ("hand", "hand", False), ("", "myohand", False)])
def test_a_model_of_another_hand_is_taken_with_a_word(identified_on, hand, told, tmp_path):
    if hand == "myohand":
        pytest.importorskip("myo_sim")
    model = load_patient_model("grasp_sci_c6")
    replace(model, plant=identified_on).save(tmp_path / "model.toml")
    notes = load("grasp_mpc", [f"plant={hand}", f"model={tmp_path / 'model.toml'}"]).notes
    assert [f"was identified on another hand, {identified_on}, and this is {hand}" in each
            for each in notes] == [True] * told


@pytest.mark.parametrize("name", ["sweep.h5", "my sweep.toml"])
def test_a_recording_in_place_of_a_model_is_to_be_identified_first(name, tmp_path):
    path = tmp_path / name
    with h5py.File(path, "w") as file:
        file["status"] = b"done"
    with pytest.raises(InputError) as refused:
        from_document(controlled({"file": str(path)}))
    assert str(refused.value) == (
        f"experiment: blocks.mpc.model: {path}: is a recording (HDF5); allowed: a model file, made by "
        f"fesloop identify; identify it first: fesloop identify {shlex.quote(str(path))} "
        "--out own_model.toml")


def test_any_patient_may_be_asked_for(tmp_path):
    a_model().save(tmp_path / "own.toml")
    a_model(patient="sci_c6").save(tmp_path / "model.toml")
    asked = from_document(controlled({"file": str(tmp_path / "model.toml"), "any_patient": True}))
    own = from_document(controlled({"file": str(tmp_path / "own.toml")}))
    controllers = [next(node.part for node in each.nodes if node.name == "mpc") for each in (asked, own)]
    assert np.array_equal(controllers[0].model.a, controllers[1].model.a)


def with_bank(tmp_path, *more, **changed):
    """`grasp_ilc` with a bank of one model, its own but for what is changed."""
    path = tmp_path / "other.toml"
    replace(load_patient_model("grasp_sci_c6"), **changed).save(path)
    return load("grasp_ilc", [f'blocks.controller.bank=[{{ file = "{path}" }}]', *more])


@pytest.mark.parametrize(("changed", "named"), [
    ({"patient": "stroke_mild", "patient_fingerprint": ""},
     "patient: the model is of 'stroke_mild'; allowed: 'sci_c6', as this experiment has; identify this one, "
     "or say --set any_patient=true"),
    ({"current_ma": (10.0, 16.0, 16.0, 28.0, 28.0, 28.0, 28.0, 34.0)},
     "current_ma: the model is of (10, 16, 16, 28, 28, 28, 28, 34); allowed: (14, 16, 16, 28, 28, 28, 28, "
     "34), as this experiment has; identify with these, or change the experiment"),
    ({"electrodes": tuple("12345678")},
     "electrodes: the model is of (1, 2, 3, 4, 5, 6, 7, 8); allowed: (22+29, 16+9, 35+36, 44, 50, 46+45, "
     "56+55, 40), as this experiment has; identify with these, or change the experiment"),
    ({"outputs": ("wrist_extension", "thumb_flexion", "finger_flexion")},
     "outputs: the model is of (wrist_extension, thumb_flexion, finger_flexion); allowed: (wrist_extension, "
     "finger_flexion, thumb_flexion), as this experiment has; identify with these, or choose those of the "
     "model: --set follow=...")])
def test_a_bank_of_models_of_something_else_is_refused_in_a_line(tmp_path, changed, named):
    with pytest.raises(InputError) as refused:
        with_bank(tmp_path, **changed)
    assert str(refused.value) == f"grasp_ilc: blocks.controller.bank[0]: {tmp_path / 'other.toml'}: {named}"


def test_any_patient_holds_for_the_bank_and_is_noted(tmp_path):
    other = {"patient": "stroke_mild, member 1 of cohort 6", "patient_fingerprint": ""}
    experiment = with_bank(tmp_path, "any_patient=true", **other)
    assert [note for note in experiment.notes if "controller.bank[0] is of another person: of stroke_mild, "
            "member 1 of cohort 6, and this is sci_c6" in note]
    with pytest.raises(InputError, match="current_ma"):
        with_bank(tmp_path, "any_patient=true", current_ma=(10.0,) * 8, **other)


@pytest.mark.parametrize(("text", "named"), [
    ("", "format"), ("not toml", "is not TOML"), (None, "cannot be read"),
    ('format = "fesloop patient model 1"\npatient = 3', "source|patient")])
def test_a_file_of_another_form_is_refused_with_a_line_a_fault(tmp_path, text, named):
    path = tmp_path / "model.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=named) as refused:
        from_document(controlled({"file": str(path)}))
    assert all(line.startswith("experiment: blocks.mpc.model: ") for line in str(refused.value).splitlines())


def test_numbers_that_do_not_belong_together_are_refused(tmp_path):
    a_model().save(tmp_path / "model.toml")
    table = tomllib.loads((tmp_path / "model.toml").read_text())
    assert table["recruitment"]["threshold_ma"] == [12.0, 10.0, 10.0, 8.0]
    with pytest.raises(InputError, match="current_ma"):
        a_model(current_ma=(40.0,) * 3)
    with pytest.raises(InputError, match="outputs"):
        a_model(outputs=("MCP",))


@pytest.mark.parametrize(("was", "told", "where"), [
    ("delay_ms = 20.0", "delay_ms = nan", "delay_ms: nan"),
    ("delay_ms = 20.0", "delay_ms = -1.0", "delay_ms: -1.0 is negative"),
    ("offset = [", "offset = [0.0, ", r"offset: shape \(4,\); allowed: shape \(3,\)"),
    ("\nb = [[", "\nb = [[1.0, ", "b: rows of unequal length")])
def test_a_file_that_a_hand_has_spoilt_is_refused_by_its_key(tmp_path, was, told, where):
    a_model().save(tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text()
    assert was in text
    (tmp_path / "model.toml").write_text(text.replace(was, told, 1))
    with pytest.raises(InputError, match=where):
        load_patient_model(tmp_path / "model.toml")


@pytest.mark.parametrize("current_ma", [0.0, -3.0, float("inf"), float("nan")])
def test_a_current_that_cannot_be_is_named_with_its_file(tmp_path, current_ma):
    a_model().save(path := tmp_path / "model.toml")
    path.write_text(path.read_text().replace("current_ma = [40.0", f"current_ma = [{current_ma}"))
    with pytest.raises(InputError, match=r"model.toml: current_ma(\[0\])?: .* allowed: a finite"):
        load_patient_model(path)


def test_a_model_written_into_the_experiment_is_refused_by_its_key():
    good = {name: getattr(a_model().model, name).tolist() for name in ("a", "b", "c", "offset")}
    for key, value, told in (("b", [[1.0], [1.0, 2.0]], "rows of unequal length"), ("c", [[1.0]], "shape")):
        document = controlled({**good, key: value})
        document["blocks"]["mpc"]["current_ma"] = [40.0] * 4
        with pytest.raises(InputError, match=rf"blocks.mpc.model.{key}: {told}"):
            from_document(document)


def patient_file(tmp_path, hand_mm="190.0"):
    """A patient of one's own, with a hand of this length."""
    path = tmp_path / "me.toml"
    text = (resources.files("plants") / "patients" / "sci_c6.toml").read_text()
    assert "hand_mm = 190.0 " in text
    path.write_text(text.replace("hand_mm = 190.0 ", f"hand_mm = {hand_mm} "))
    return path


@pytest.mark.parametrize("who", [{}, {"member": 3}, {"member": 3, "cohort": 2}, {"day": 4},
                                 {"member": 1, "day": 2}])
def test_the_fingerprint_is_that_of_the_contents_whatever_the_day(tmp_path, who):
    choice = {"file": str(patient_file(tmp_path)), **who}
    found = patient_fingerprint(choice)
    recorded = json.loads(json.dumps({**choice, "drawn": drawn_patient(choice).table()}))
    assert patient_fingerprint(recorded) == found
    assert patient_fingerprint({key: item for key, item in choice.items() if key != "day"}) == found
    patient_file(tmp_path, "191.0")
    assert patient_fingerprint(choice) != found
    assert patient_fingerprint(recorded) == ("" if "day" in who else found)


@pytest.mark.parametrize("day", [{}, {"day": 3}])
def test_a_model_of_a_patient_whose_file_has_changed_is_refused(tmp_path, day):
    who = {"file": str(patient_file(tmp_path))}
    a_model(patient=describe(who), patient_fingerprint=patient_fingerprint(who)).save(tmp_path / "model.toml")
    document = {**controlled({"file": str(tmp_path / "model.toml")}), "patient": {**who, **day}}
    made = from_document(document)
    assert from_document(json.loads(made.as_json())) == made
    patient_file(tmp_path, "191.0")
    with pytest.raises(InputError, match="that patient has changed since") as refused:
        from_document(document)
    assert len(str(refused.value).splitlines()) == 1
    document["blocks"]["mpc"]["model"]["any_patient"] = True
    from_document(document)

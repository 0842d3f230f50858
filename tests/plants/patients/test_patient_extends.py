"""Patient files that extend a preset or another file."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fesloop
from fesloop import InputError
from fesloop.apps.cli import main
from fesloop.experiment.files.patients import patient_fingerprint
from fesloop.experiment.recording.reading import Recording
from plants.patients.files import load, names

CHAIN = str(Path(__file__).parents[2] / "experiment/files/patient_chain.toml")


def written(folder, name, text):
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("preset", names())
def test_a_file_that_states_nothing_is_its_preset(preset, tmp_path):
    assert load(written(tmp_path, "own", f'extends = "{preset}"')).table() == load(preset).table()


@given(overall=st.floats(0.01, 3.0), limit=st.floats(0.0, 1.0), preset=st.sampled_from(names()))
def test_what_a_file_states_overrides_and_all_else_is_the_bases(overall, limit, preset, tmp_path_factory):
    path = written(tmp_path_factory.mktemp("own"), "own", f'extends = "{preset}"\n[strength]\n'
                   f"overall = {overall!r}\n[voluntary.muscles]\nFCR = {limit!r}\n")
    made, expected = load(path).table(), load(preset).table()
    expected["strength"]["overall"] = overall
    expected.setdefault("voluntary", {}).setdefault("muscles", {})["FCR"] = limit
    assert made == expected


def test_a_chain_is_followed_from_the_folder_of_each_file(tmp_path):
    (tmp_path / "bases").mkdir()
    written(tmp_path / "bases", "weak", 'extends = "sci_c6"\nname = "weak"\n[strength.muscles]\nECRL = 0.5')
    path = written(tmp_path, "own", 'extends = "bases/weak.toml"\n[strength.muscles]\nECRB = 0.25')
    patient, preset = load(path), load("sci_c6")
    assert patient.name == "weak"
    assert patient.strength.muscles == {**preset.strength.muscles, "ECRL": 0.5, "ECRB": 0.25}
    assert patient.passive == preset.passive


def test_sections_and_keys_are_removed(tmp_path):
    path = written(tmp_path, "own", 'extends = "sci_c6"\nremove = ["fatigue", "strength.muscles.ECRL"]')
    assert load("sci_c6").fatigue is not None
    assert load(path).fatigue is None
    assert "ECRL" not in load(path).strength.muscles


def test_with_the_bases_name_members_are_the_same_persons(tmp_path):
    same = load(written(tmp_path, "own", 'extends = "sci_c6"\n[voluntary]\nlimit = 0.5'))
    other = load(written(tmp_path, "other", 'extends = "sci_c6"\nname = "other"'))
    person = load("sci_c6").member(cohort=1, number=3)
    assert same.member(cohort=1, number=3).hand_size == person.hand_size
    assert other.member(cohort=1, number=3).hand_size != person.hand_size


@pytest.mark.parametrize(("text", "told"), [
    ('extends = "own.toml"', "own.toml: extends: refers back to this file; allowed: a file that extends"),
    ('extends = "sci_c7"', "own.toml: extends: sci_c7: there is no shipped patient of this name; allowed: "
     "able_bodied, sci_c6, stroke_mild, stroke_severe_spastic; did you mean 'sci_c6'?"),
    ('extends = "no.toml"', "own.toml: extends: no.toml: cannot be read: No such file or directory"),
    ('extends = ""', "own.toml: extends: '': there is no shipped patient"),
    ("extends = 3", "own.toml: extends: 3 is no text; allowed: name or path of a patient file"),
    ('extends = "sci_c6"\nremove = ["tremr"]', "own.toml: remove[0]: there is no 'tremr'; allowed: name, "),
    ('extends = "sci_c6"\nremove = "day"', "own.toml: remove: 'day'; allowed: a list of key paths"),
    ('extends = "sci_c6"\n[strength]\noverall = 9.0',
     "own.toml over what it extends: strength.overall: 9; allowed: 0.01 to 3"),
    ('extends = "sci_c6"\nstrength = 3', "own.toml over what it extends: strength: 3 is an integer"),
    ('extends = "sci_c6"\n[strenth]\noverall = 1.0', "own.toml over what it extends: strenth: unknown key"),
    ('name = "own"\nremove = ["day"]', "own.toml: remove: unknown key"),
    ("extends = ", "own.toml: is not TOML"),
])
def test_a_wrong_base_is_refused_in_one_line(text, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path, "own", text)
    assert main(["check", "open_close", "--set", "patient=own.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"fesloop: open_close: patient: {told}")


def test_a_circle_of_two_is_refused(tmp_path):
    written(tmp_path, "one", 'extends = "two.toml"')
    path = written(tmp_path, "two", 'extends = "one.toml"')
    with pytest.raises(InputError, match="extends: refers back to this file"):
        load(path)


@given(values=st.dictionaries(st.sampled_from(["extends", "remove", "name", "strength", "day"]), st.one_of(
    st.text(max_size=8), st.integers(), st.lists(st.text(max_size=4), max_size=2), st.booleans())))
def test_any_values_make_a_patient_or_are_refused_on_purpose(values, tmp_path_factory):
    text = "\n".join(f"{key} = {json.dumps(value)}" for key, value in values.items())
    path = written(tmp_path_factory.mktemp("own"), "own", text)
    try:
        made = load(path).name
    except InputError as fault:
        made = str(fault)
    assert made


def test_a_run_holds_the_patient_and_is_repeated_without_the_base(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    base = written(tmp_path, "base", 'extends = "sci_c6"\n[strength]\noverall = 0.5')
    written(tmp_path, "own", 'extends = "base.toml"\nname = "own"')
    settings = ["patient.file=own.toml", "experiment.duration_s=0.1"]
    first = fesloop.load(CHAIN, settings).run(tmp_path / "runs")
    choice = {"file": "own.toml"}
    before = patient_fingerprint(choice)
    base.write_text('extends = "sci_c6"\n[strength]\noverall = 0.6')
    assert patient_fingerprint(choice) != before
    with Recording(first.recording) as recording:
        held = recording.experiment["patient"]
    assert patient_fingerprint(held) == before
    assert held["drawn"]["strength"]["overall"] == 0.5
    base.unlink()
    again = fesloop.load(str(first.recording))
    assert again.patient["drawn"] == held["drawn"]
    assert again.fingerprint() == fesloop.load(str(first.recording)).fingerprint()

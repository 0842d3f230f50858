"""[patient] in an experiment: who is told what, what wins, what is recorded, and how faults are told."""

import importlib.metadata
import json
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import fesloop
from fesloop import InputError
from fesloop.apps.cli import main
from fesloop.experiment import registry
from fesloop.experiment.files.layout import json_schema
from fesloop.experiment.files.parse import from_document, read
from fesloop.experiment.recording.reading import Recording
from plants.patients.files import from_table
from plants.patients.files import load as load_patient

CHAIN = str(Path(__file__).parent / "patient_chain.toml")


def parts_with(*settings):
    """Blocks of the chain by name, some keys changed."""
    return {node.name: node.part for node in fesloop.load(CHAIN, settings).nodes}


def refusal(*settings):
    """Lines of the refusal of the chain with some keys changed."""
    with pytest.raises(InputError) as refused:
        fesloop.load(CHAIN, settings)
    return str(refused.value).splitlines()


@pytest.mark.parametrize("name", ["able_bodied", "sci_c6", "stroke_mild", "stroke_severe_spastic"])
def test_every_block_is_told_of_the_patient(name):
    parts = parts_with(f"patient.file={name}", "patient.member=3", "patient.cohort=1", "patient.day=2")
    patient = load_patient(name).member(cohort=1, number=3).on_day(2)
    for block, told in (("hand", patient.hand()), ("muscles", patient.muscles()),
                        ("electrodes", patient.electrodes())):
        for key, value in told.items():
            assert getattr(parts[block], key) == value, (block, key)
    assert parts["tracker"].hand == patient.measured_hand


def test_what_the_experiment_says_of_a_block_wins():
    parts = parts_with("patient.file=stroke_severe_spastic", "blocks.hand.contracture=1.5",
                       'blocks.tracker.hand.side="left"', "blocks.muscles.fatigue.recovery_s=60.0",
                       "blocks.hand.rest_deg.F2_mcp_flexion=10.0", "blocks.muscles.model=riener")
    patient = load_patient("stroke_severe_spastic")
    assert parts["hand"].contracture == 1.5
    assert parts["hand"].passive_tension == patient.passive.tension
    assert parts["hand"].rest_deg == {**patient.passive.rest_deg, "F2_mcp_flexion": 10.0}
    assert parts["tracker"].hand.side == "left"
    assert parts["tracker"].hand.hand_mm == patient.hand_size.hand_mm
    assert parts["muscles"].model == "riener"
    assert parts["muscles"].fatigue.recovery_s == 60.0
    assert parts["muscles"].fatigue.fatigue_s == patient.fatigue.of_muscles.fatigue_s


def test_a_patient_who_tires_does_so_under_a_model_that_has_its_own_fatigue():
    muscles = parts_with("patient.file=sci_c6", "blocks.muscles.model=ding2003")["muscles"]
    assert muscles.fatigue is None
    assert muscles.ding2003.fatigue is not None


def test_skin_is_drawn_for_as_many_elements_as_the_experiment_has():
    arrays = "blocks.electrodes.arrays=[{rows=2, columns=3}]"
    electrodes = parts_with("patient.day=4", arrays, "blocks.stimulator.elements=6")["electrodes"]
    whole = parts_with("patient.day=4")["electrodes"]
    assert electrodes.skin_gain == whole.skin_gain[:6]


def test_a_file_of_ones_own_is_a_patient_too(tmp_path):
    file = tmp_path / "anna.toml"
    file.write_text('name = "anna"\n[anthropometry]\nside = "left"\nhand_mm = 171.0\n')
    parts = parts_with(f'patient.file="{file}"')
    assert parts["hand"].hand.side == parts["tracker"].hand.side == "left"
    assert parts["hand"].hand.hand_mm == 171.0


def test_without_a_patient_nothing_is_told():
    document = read(CHAIN)[1]
    del document["patient"]
    experiment = from_document(document)
    assert experiment.patient is None
    assert "patient" not in experiment.document()


def test_the_resolved_experiment_is_the_same_experiment():
    experiment = fesloop.load(CHAIN, ["patient.member=3", "patient.day=1"])
    again = from_document(json.loads(experiment.as_json()))
    assert again == experiment
    assert from_table(again.patient["drawn"]) == load_patient("sci_c6").member(cohort=0, number=3).on_day(1)


def test_a_recording_is_repeated_without_the_patients_file(tmp_path):
    file = tmp_path / "anna.toml"
    file.write_text('name = "anna"\n[strength]\noverall = 0.7\n[cohort]\nstrength = 0.2\n')
    experiment = fesloop.load(CHAIN, [f'patient.file="{file}"', "patient.member=5"])
    first = experiment.run(tmp_path / "first").recording
    file.unlink()
    repeated = fesloop.load(first)
    assert repeated == experiment
    second = repeated.run(tmp_path / "second").recording
    with Recording(first) as one, Recording(second) as other:
        assert one.experiment["patient"]["member"] == 5
        assert one.experiment["patient"]["drawn"]["name"] == "anna.0.5"
        for name in ("hand.angles", "muscles.activation", "tracker.angles"):
            assert np.array_equal(one.signal(name).values, other.signal(name).values), name


def test_a_recordings_patient_cannot_be_another_one(tmp_path):
    recording = fesloop.load(CHAIN).run(tmp_path).recording
    with pytest.raises(InputError, match="already contains the patient of its run; set it on the"):
        fesloop.load(recording, ["patient.member=4"])


def test_axons_are_the_persons_and_not_the_runs(tmp_path):
    """Under the same pulses another seed of the run recruits the same, another member does not."""
    def recruited(*settings, seed=3):
        strong = "blocks.programme.current_ma=[[40.0]]"
        experiment = fesloop.load(CHAIN, [strong, *settings], seed=seed)
        with Recording(experiment.run(tmp_path).recording) as recording:
            return recording.signal("electrodes.recruitment").values

    one = recruited("patient.member=1")
    assert one.any()
    assert np.array_equal(one, recruited("patient.member=1", seed=4))
    assert not np.array_equal(one, recruited("patient.member=2"))


@pytest.mark.parametrize(("settings", "starts"), [
    (("patient.file=sci_c7",), ["patient: sci_c7: there is no shipped patient of this name"]),
    (("patient.file=nobody.toml",), ["patient: nobody.toml: cannot be read"]),
    (("patient.member=-1",), ["patient: member: -1"]),
    (("patient.member=1.5",), ["patient.member: 1.5"]),
    (("patient.cohort=1",), ["patient.member: is missing beside cohort"]),
    (("patient.age=70",), ["patient.age: unknown key"]),
    (("patient.file=sci_c7", "blocks.hand.step_ms=true"),
     ["patient: sci_c7: there is no shipped", "blocks.hand.step_ms: true is a boolean"]),
    (("patient.file=sci_c6", "blocks.electrodes.arrays=3"), ["blocks.electrodes.arrays: 3 is an integer"]),
    (("patient.drawn={name=3}",), ["patient.drawn: name: 3 is an integer"]),
])
def test_faults_of_the_patient_are_told_with_all_others(settings, starts):
    lines = refusal(*settings)
    assert len(lines) == len(starts)
    for line, start in zip(lines, starts, strict=True):
        assert line.startswith(f"{CHAIN}: {start}"), line


def test_all_faults_of_a_patients_file_are_told(tmp_path):
    file = tmp_path / "anna.toml"
    file.write_text('name = "anna"\n[anthropometry]\nhand_mm = 20\n[strength]\noverall = -1\n')
    lines = refusal(f'patient.file="{file}"', "blocks.hand.step_ms=true")
    assert [each.removeprefix(f"{CHAIN}: ").removeprefix(f"patient: {file}: ").partition(":")[0]
            for each in lines] == ["anthropometry.hand_mm", "strength.overall", "blocks.hand.step_ms"]


@pytest.mark.slow
def test_the_schema_knows_the_table():
    schema = json_schema()
    document = read(CHAIN)[1]
    jsonschema.validate(document, schema)
    document["patient"]["member"] = "three"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema)


def test_commands_name_patients(capsys, tmp_path):
    assert main(["check", CHAIN, "--set", "patient.member=3", "--set", "patient.day=1"]) == 0
    assert "sci_c6, member 3 of cohort 0, day 1" in " ".join(capsys.readouterr().out.split())
    assert main(["list", "--json"]) == 0
    assert "sci_c6" in json.loads(capsys.readouterr().out)["patients"]
    assert main(["patient", "sci_c6", "--member", "3", "--day", "1"]) == 0
    file = tmp_path / "drawn.toml"
    file.write_text(capsys.readouterr().out)
    assert load_patient(file) == load_patient("sci_c6").member(cohort=0, number=3).on_day(1)
    assert main(["patient", "sci_c6", "--json"]) == 0
    assert from_table(json.loads(capsys.readouterr().out)) == load_patient("sci_c6")
    assert main(["patient", "sci_c6", "--cohort", "1"]) == 2


@dataclass(frozen=True)
class Entry:
    """An entry point of the group."""

    name: str
    fault: Exception
    value: str = "broken.patients"

    def load(self):
        raise self.fault


@pytest.mark.parametrize(("entries", "found"), [
    ((), "no installed package reads patients"),
    ((Entry("broken", ImportError("no numpy")),), "'broken' .* does not import: no numpy")])
def test_a_reader_that_is_not_there_is_named(monkeypatch, entries, found):
    monkeypatch.setattr(registry, "entry_points", lambda group: entries)
    registry._first.cache_clear()
    try:
        with pytest.raises(InputError, match=found):
            fesloop.load(CHAIN)
    finally:
        registry._first.cache_clear()


def test_the_group_has_a_reader():
    assert [entry.value for entry in importlib.metadata.entry_points(group=registry.PATIENTS)] == [
        "plants.patients.files"]


def test_a_patient_of_whom_no_block_is_told_is_refused():
    """Results of a finger alone would be said to be theirs."""
    with pytest.raises(InputError, match="patient: 'sci_c6' would change nothing") as refused:
        fesloop.load("finger_control", ["patient.file=sci_c6"])
    assert len(str(refused.value).splitlines()) == 1

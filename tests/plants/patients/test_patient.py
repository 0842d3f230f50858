"""What a patient's file says reaches the blocks; what cannot be is refused by name, all at once."""

import math
import tomllib
from importlib import resources

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError, InputErrors
from fesloop.forms.toml import toml_text
from fesloop.hand.movements import INTRINSIC, MUSCLES, muscle
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from fesloop.models.arm_responses import DELAY_UNIT_S, ArmResponses
from plants.electrodes import Electrodes
from plants.hand import Hand
from plants.hand.model import moment_arms
from plants.hand.model import muscles as hand_muscles
from plants.muscles import Muscles
from plants.patients.files import from_table, load, names
from plants.patients.patient import ADULT_FOREARM_MM, Patient
from plants.patients.sections import LIMITS, Anthropometry, Fatigue, Placement, Recruitment, Strength

PRESETS = names()
FINGER_MOVERS = [name for name in MUSCLES if name[:3] in ("EDC", "FDS", "FDP", "EIP", "EDM", "INT")]


def told(**sections):
    """The patient of plain tables."""
    return from_table({"name": "anna", **sections})


def refused(**sections):
    """Lines of the refusal of plain tables."""
    with pytest.raises(InputErrors) as found:
        told(**sections)
    return str(found.value).splitlines()


@pytest.mark.parametrize(("section", "key", "limits"), [
    ("muscle", "natural_rad_s", "0 rad/s; allowed: 4 to 125 rad/s"),
    ("muscle", "delay_ms", "0 ms; allowed: 5 to 200 ms"),
    ("passive", "mcp_n_m_per_rad", "0 N m/rad; allowed: 0.02 to 1.3 N m/rad"),
    ("tolerance", "charge_max_uc", "0 uC; allowed: 0.1 to 63 uC"),
    ("tolerance", "charge_per_s_max_uc", "0 uC/s; allowed: 0.1 to 3150 uC/s"),
])
def test_limits_are_told_in_the_unit_of_the_number(section, key, limits):
    assert refused(**{section: {key: 0.0}}) == [f"patient: {section}.{key}: {limits}"]


def test_the_presets_are_those_that_are_promised():
    assert PRESETS == ["able_bodied", "sci_c6", "stroke_mild", "stroke_severe_spastic"]


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_makes_blocks(name):
    patient = load(name)
    assert patient.name == name
    assert patient.description
    assert Hand(**patient.hand()).hand.hand_mm == patient.anthropometry.hand_mm
    assert Muscles(**patient.muscles()).delay_ms == patient.muscle.delay_ms
    assert Electrodes(**patient.electrodes()).elements == 59


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("model", ["hammerstein", "riener", "ding2003", "ding2007"])
def test_every_preset_takes_every_model_of_muscle(name, model):
    muscles = Muscles(**load(name).muscles(model))
    assert muscles.model == model
    tires = muscles.fatigue if model != "ding2003" else muscles.ding2003.fatigue
    assert tires is not None


@pytest.mark.parametrize("name", PRESETS)
def test_a_printed_patient_is_read_back_the_same(name):
    for patient in (load(name), load(name).member(cohort=7, number=11).on_day(5)):
        assert from_table(tomllib.loads(toml_text(patient.table()))) == patient


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_a_preset_has_a_source_or_says_that_it_is_chosen(name):
    text = (resources.files("plants") / "patients" / f"{name}.toml").read_text()
    block = ""
    for line in text.splitlines():
        if line.startswith("["):
            block = line.partition("#")[2]
        elif line.startswith("#"):
            block = line
        elif "=" in line and '"' not in line.partition("#")[0]:
            assert line.partition("#")[2] or block, line


def test_delay_and_speed_are_those_of_the_recorded_people():
    people, preset, block = ArmResponses.shipped(), load("able_bodied"), Muscles()
    delay, speed, unit_ms = people.delay, people.log_frequency, 1e3 * DELAY_UNIT_S
    for delay_ms, rad_s in ((preset.muscle.delay_ms, preset.muscle.natural_rad_s),
                            (block.delay_ms, block.natural_rad_s),
                            (block.delay_ms, block.hammerstein.activation_rad_s)):
        assert delay_ms == pytest.approx(unit_ms * delay.mean, abs=1.0)
        assert rad_s == pytest.approx(math.exp(speed.mean), rel=0.02)
    assert preset.cohort.muscle_delay_ms == pytest.approx(
        unit_ms * math.hypot(delay.among, delay.within), abs=0.5)
    assert preset.cohort.natural == pytest.approx(speed.between, abs=0.01)
    assert preset.cohort.muscle_natural == pytest.approx(math.hypot(speed.among, speed.within), abs=0.01)
    assert load("sci_c6").muscle.natural_rad_s == pytest.approx(120.0 / 80.0 * preset.muscle.natural_rad_s)


def test_an_able_bodied_adult_is_what_the_blocks_are_without_a_patient():
    patient, hand, electrodes = load("able_bodied"), Hand(), Electrodes()
    own = patient.hand()
    assert own["strength"] == (1.0,) * len(MUSCLES)
    assert own["contracture"] == pytest.approx(hand.contracture)
    assert own["hand"] == hand.hand
    theirs = patient.electrodes()
    assert theirs["axons"] == electrodes.axons
    scale = theirs["length_mm"] / electrodes.length_mm
    assert scale == pytest.approx(256.9 / ADULT_FOREARM_MM, abs=0.01)


def test_c6_extends_the_wrist_at_will_and_moves_no_finger():
    muscles = Muscles(**load("sci_c6").muscles())
    state, zero, seconds = muscles.init(Context("muscles")), np.zeros(len(MUSCLES)), 2 * 10**9
    inputs = (zero, zero, zero, np.ones(len(MUSCLES)))
    muscles.advance(state, inputs, 0, seconds)
    activation, _ = muscles.read(state, inputs)
    assert activation[muscle("ECRL")] > 0.5
    assert activation[muscle("ECRB")] > 0.5
    assert not any(activation[muscle(name)] for name in FINGER_MOVERS)


def test_c6_has_less_force_in_the_hand_than_denervation_leaves():
    strength = load("sci_c6").hand()["strength"]
    for name in INTRINSIC:
        assert strength[muscle(name)] == pytest.approx(0.5 * 0.5)


def test_contracture_after_stroke_is_the_measured_stiffness():
    """MCP stiffness about .52 N m/rad at MAS 2, of which tendons make .01 (PMC7775510): by a small moment."""
    hand = Hand(**load("stroke_severe_spastic").hand() | {"passive_tension": 1.0, "rest_deg": {}})
    joint = hand.model.joint("F3_mcp_flexion")
    assert joint.stiffness[0] == pytest.approx(0.51, rel=0.01)


def test_a_spastic_finger_that_is_turned_resists_by_flexors_alone():
    """300 deg/s of extension at the MCP joint: .2 N m, the number that the preset's reflex is chosen for."""
    patient = load("stroke_severe_spastic")
    muscles = Muscles(**patient.muscles())
    state, zero = muscles.init(Context("muscles")), np.zeros(len(MUSCLES))
    tree = hand_tree(patient.hand_size)
    arms = moment_arms(tree, 0.0)[:, tree.freedom("F3_mcp_flexion")]
    rows = hand_muscles()
    stretch = math.radians(300.0) * arms / (1e-3 * np.array([row.fibre_mm for row in rows]))
    inputs = (zero, zero, stretch, zero)
    muscles.advance(state, inputs, 0, 10**9)
    activation, _ = muscles.read(state, inputs)
    force = activation * patient.hand()["strength"] * np.array([row.force_n for row in rows])
    assert {MUSCLES[i] for i in np.flatnonzero(activation)} == {"FDP3", "FDS3"}
    assert force @ arms == pytest.approx(0.2, rel=0.1)


def test_another_hand_of_its_own_size_is_told_all_but_its_size():
    patient = load("stroke_mild")
    ours, theirs = (patient.parameters(kind, {}) for kind in ("hand", "myohand"))
    assert ours.pop("hand")["hand_mm"] == patient.anthropometry.hand_mm
    assert theirs == ours
    assert patient.parameters("pid", {}) == {}


def test_a_longer_forearm_carries_motor_points_and_arrays_further_down():
    short, long = (told(anthropometry={"forearm_mm": length}).electrodes() for length in (208.0, 312.0))
    for point, other in zip(short["motor_points"], long["motor_points"], strict=True):
        assert other.along_mm == pytest.approx(1.5 * point.along_mm)
    assert long["shift_mm"] - short["shift_mm"] == pytest.approx(106.0 * 0.4)


@pytest.mark.parametrize(("sections", "where"), [
    ({"anthropometry": {"hand_mm": 20.0}}, "anthropometry.hand_mm: 20"),
    ({"anthropometry": {"side": "both"}}, "anthropometry.side"),
    ({"strength": {"overall": -1.0}}, "strength.overall: -1"),
    ({"strength": {"muscles": {"FDX": 1.0}}}, "strength.muscles.FDX: no muscle is named"),
    ({"strength": {"denervated": {"FDP2": 1.2}}}, "strength.denervated.FDP2: 1.2"),
    ({"recruitment": {"threshold": 0.0}}, "recruitment.threshold: 0"),
    ({"recruitment": {"axon_seed": -1}}, "recruitment.axon_seed: -1"),
    ({"muscle": {"model": "hill"}}, "muscle.model"),
    ({"muscle": {"delay_ms": math.inf}}, "muscle.delay_ms"),
    ({"fatigue": {"condition": "old"}}, "fatigue.condition"),
    ({"fatigue": {"floor": 1.1}}, "fatigue.floor"),
    ({"voluntary": {"limit": 2.0}}, "voluntary.limit: 2"),
    ({"voluntary": {"muscles": {"": 0.5}}}, "voluntary.muscles"),
    ({"passive": {"rest_deg": {"F2_mcp_flexion": 170.0}}}, "passive.rest_deg.F2_mcp_flexion: 170"),
    ({"passive": {"rest_deg": {"F9": 1.0}}}, "passive.rest_deg"),
    ({"passive": {"mcp_n_m_per_rad": 0.0}}, "passive.mcp_n_m_per_rad: 0"),
    ({"spasticity": {"muscles": ["FDS9"]}}, "spasticity.muscles"),
    ({"spasticity": {"gain_s": 0.0}}, "spasticity: the reflex has no effect"),
    ({"tremor": {"frequency_hz": 40.0}}, "tremor.frequency_hz: 40"),
    ({"placement": {"along_mm": 400.0}}, "placement.along_mm: 400"),
    ({"cohort": {"strength": -0.1}}, "cohort.strength: -0.1"),
    ({"day": {"skin": 3.0}}, "day.skin: 3"),
    ({"name": ""}, "name: is empty"),
    ({"strenght": {}}, "strenght: unknown key"),
    ({"tremor": {"activation": "much"}}, "tremor.activation"),
    ({"strength": 3}, "strength"),
    ({"": "anna"}, '"": unknown key'),
    ({"strength.overall": 0.5}, '"strength.overall": unknown key'),
    ({"day[0]": {}}, '"day[0]": unknown key'),
])
def test_impossible_patients_are_refused_by_name(sections, where):
    lines = refused(**sections)
    assert len(lines) == 1
    assert lines[0].startswith(f"patient: {where}")
    assert "allowed" in lines[0]


@pytest.mark.parametrize(("sections", "where"), [
    ({"spasticity": {"muscles": ["FDP2"]}}, "spasticity.muscles: FDP2 is completely denervated"),
    ({"tremor": {"muscles": ["FDP2"]}}, "tremor.muscles: FDP2 is completely denervated"),
    ({"voluntary": {"muscles": {"FDP2": 0.1}}}, "voluntary.muscles.FDP2: has voluntary effort"),
])
def test_what_contradicts_itself_is_refused(sections, where):
    lines = refused(strength={"denervated": {"FDP2": 1.0}}, **sections)
    assert [line.startswith(f"patient: {where}") for line in lines] == [True]


def test_all_faults_are_named_at_once():
    lines = refused(anthropometry={"hand_mm": 20.0, "forearm_radius_mm": -1.0}, tremor={"activation": "much"},
                    strength={"overall": -1.0, "muscles": {"FDX": 1.0}}, age=70)
    starts = ["tremor.activation", "age", "anthropometry.hand_mm", "anthropometry.forearm_radius_mm",
              "strength.overall", "strength.muscles.FDX"]
    assert [line.partition(":")[2].strip().partition(":")[0] for line in lines] == starts


@pytest.mark.parametrize(("content", "found"), [
    (b"name = ", "is not TOML"), (b"\xff\xfe", "is not UTF-8"), (b"", "name: is missing")])
def test_a_file_that_is_none_is_refused(tmp_path, content, found):
    file = tmp_path / "anna.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=found):
        load(file)


def test_a_patient_who_is_not_there_is_refused():
    with pytest.raises(InputError, match="cannot be read"):
        load("nobody.toml")
    with pytest.raises(InputError, match="did you mean 'sci_c6'"):
        load("sci_c7")


def test_python_says_the_same_as_a_file():
    made = Patient(name="anna", strength=Strength(overall=0.5), fatigue=Fatigue(condition="sci_acute"),
                   anthropometry=Anthropometry(side="left"))
    assert made == told(strength={"overall": 0.5}, fatigue={"condition": "sci_acute"},
                        anthropometry={"side": "left"})


@given(st.floats(*LIMITS["anthropometry"]["hand_mm"]), st.floats(0.1, 1.2), st.floats(-10.0, 10.0),
       st.integers(0, 2**53))
def test_whoever_is_accepted_can_wear_electrodes(hand_mm, skin, along_mm, seed):
    patient = Patient(
        name="anna", anthropometry=Anthropometry(hand_mm=hand_mm),
        placement=Placement(along_mm=along_mm, skin=skin, element_sd=0.1, skin_seed=seed),
        recruitment=Recruitment(axon_seed=seed))
    electrodes = Electrodes(**patient.electrodes())
    assert np.median(electrodes.skin_gain) == pytest.approx(skin, rel=0.15)

"""`[variants]`: one file, several experiments: picked by `--set`, refused by name, repeated."""

import json
import tomllib
from contextlib import suppress
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fesloop
from fesloop import Recording
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.layout import json_schema
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.files.variants import pick

SMALL = (Path(__file__).parents[1] / "small.toml").read_text().partition("[aliases]")[0]
TABLES = ["experiment", "patient", "record", "blocks", "wires", "score", "aliases"]
KEYS = [*TABLES, "plant", "default", "finger", "like", "remove", "from", "to", "leave_out", "kind", "a.b"]
VARIANTS = """
[variants.plant]
default = "finger"

[variants.plant.finger]

[variants.plant.weak]
description = "half as strong"
blocks.finger.strength = 0.5

[variants.plant.fmu]
like = "weak"
description = "the finger as an FMU"
remove = ["blocks.finger"]
record.plant_rate = "100"
blocks.fmu = { kind = "fmu", path = "shipped:finger" }
wires = [
    { from = "fmu.angles", to = "pid.measured", latency_ms = 20 },
    { from = "pid.stimulation", to = "fmu.stimulation", latency_ms = 5 },
]
score.truth = "fmu.angles"
aliases.fmu = "blocks.fmu.path"

[variants.link]
default = "radio"

[variants.link.radio]

[variants.link.cable]
wires = [{ from = "finger.angles", to = "pid.measured", latency_ms = 1 }]
remove = ['wires."finger.angles->pid.measured".jitter']

[variants.patient]
default = "healthy"

[variants.patient.healthy]

[variants.patient.strong]
blocks.finger.strength = 2.0

[variants.patient.faster]
blocks.finger.speed = 1.5

[variants.watched]
default = "no"

[variants.watched.no]

[variants.watched.yes]
blocks.watch = { kind = "select", rate = "50", indices = [0] }
wires = [{ from = "finger.angles", to = "watch.vector" }]
"""


@pytest.fixture
def file(tmp_path):
    def write(text=VARIANTS, *changes):
        text = SMALL + text
        for before, after in changes:
            assert before in text
            text = text.replace(before, after, 1)
        path = tmp_path / "small.toml"
        path.write_text(text)
        return path

    return write


def fault(*given):
    with pytest.raises(InputError) as refused:
        fesloop.load(*given)
    return str(refused.value)


def test_the_default_is_the_file_as_it_stands(file, tmp_path):
    plain = tmp_path / "plain.toml"
    plain.write_text(SMALL)
    assert fesloop.load(file()) == fesloop.load(plain)
    assert from_document(tomllib.loads(SMALL + VARIANTS)) == fesloop.load(plain)


@pytest.mark.slow
def test_an_option_is_what_could_be_written_by_hand(file, tmp_path):
    by_hand = tmp_path / "hand.toml"
    by_hand.write_text("""
[experiment]
name = "small"
description = "PID on a virtual finger; plant fmu: the finger as an FMU"
duration_s = 1
trials = 2
seed = 3
[blocks.reference]
kind = "minimum_jerk"
rate = "50"
times_s = [0.1, 0.6]
angles_deg = [[20, 25, 15], [35, 45, 25]]
""" + SMALL[SMALL.index("[blocks.pid]"):SMALL.index("[blocks.finger]")] + """
[blocks.fmu]
kind = "fmu"
path = "shipped:finger"
[[wires]]
from = "reference.angles"
to = "pid.reference"
[[wires]]
from = "fmu.angles"
to = "pid.measured"
latency_ms = 20
[[wires]]
from = "pid.stimulation"
to = "fmu.stimulation"
latency_ms = 5
[score]
truth = "fmu.angles"
reference = "reference.angles"
[record]
plant_rate = "100"
""")
    assert fesloop.load(file(), ["plant=fmu"]) == fesloop.load(by_hand)


@pytest.mark.parametrize("settings", [
    ("plant=weak", "patient=faster", "link=cable", "blocks.pid.kp.0=0.9", "watched=yes"),
    ("blocks.pid.kp.0=0.9", "link=cable", "plant=finger", "plant=weak", 'patient="faster"')])
def test_options_go_together_in_any_order_and_settings_come_after_them(file, settings):
    told = fesloop.load(file(), settings).document()
    assert (told["blocks"]["finger"]["strength"], told["blocks"]["finger"]["speed"]) == (0.5, 1.5)
    measured = next(wire for wire in told["wires"] if wire["to"] == "pid.measured")
    assert (measured["latency_ms"], measured["jitter"]["kind"]) == (1.0, "zero")
    assert told["blocks"]["pid"]["kp"][0] == 0.9


@pytest.mark.parametrize(("settings", "found"), [
    (["plant=weak", "patient=strong"],
     "variants.plant.weak: does not go with variants.patient.strong: both change blocks.finger.strength"),
    (["patient=faster", "plant=fmu"],
     "variants.plant.fmu: does not go with variants.patient.faster: both change blocks.finger"),
    (["plant=fmu", "watched=yes"], 'both change wires."finger.angles->watch.vector"'),
    (["plant=fmu", "link=cable"], 'both change wires."finger.angles->pid.measured"'),
    (["plant=fmi"], "--set plant=fmi: "),
    (["plant=fmi"], "has no plant of this name; allowed: finger, weak, fmu; did you mean 'fmu'?"),
    (["plan=fmu"], "allowed: plant, link, patient, watched, experiment.KEY"),
    (["plan=fmu"], "did you mean 'plant'?"),
    (["fmu=x.fmu"], "is no key of"),
    (["plant=fmu", "blocks.finger.strength=2"], "small.toml with plant=fmu has no 'finger' there"),
    (["plant=weak", "blocks.finger.strenth=2"], "small.toml with plant=weak: blocks.finger.strenth: unknown"),
    (["variants.plant.weak.blocks.finger.strength=2"], "is no key of"),
])
def test_what_cannot_be_picked_is_refused_in_one_line(file, settings, found):
    line = fault(file(), settings)
    assert found in line
    assert "\n" not in line


@pytest.mark.parametrize(("change", "found"), [
    (('default = "finger"\n', ""), "variants.plant.default: is missing; allowed: finger, weak, fmu; add it"),
    (('default = "finger"', 'default = "fingr"'), "'fingr' is no option of plant; allowed: finger,"),
    (('default = "finger"', "default = 3"), "variants.plant.default: 3 is no option of plant"),
    (('like = "weak"', 'like = "week"'), "variants.plant.fmu.like: 'week' is no option of plant"),
    (('like = "weak"', 'like = "fmu"'), "variants.plant.fmu.like: refers back to itself"),
    (("score.truth", "scores.truth"), "variants.plant.fmu.scores: unknown key; allowed: aliases, blocks,"),
    (("latency_ms = 20 }", "latency = 20 }"), "variants.plant.fmu.wires[0].latency: unknown key; allowed:"),
    (('{ from = "fmu.angles", to', "{ to"), "variants.plant.fmu.wires[0].from: is missing"),
    (('record.plant_rate = "100"', "record.leave_out = 3"), "plant.fmu.record.leave_out: 3 is an integer"),
    (('remove = ["blocks.finger"]', 'remove = ["blocks.fingr"]'),
     "plant.fmu.remove[0]: there is no 'blocks.fingr'; allowed: reference, pid, finger; did you mean"),
    (('remove = ["blocks.finger"]', 'remove = "blocks.finger"'), "variants.plant.fmu.remove: "),
    (("\n\n[variants.plant.finger]", "\nfinger = 3"), "variants.plant.finger: 3 is an integer"),
    (("[variants.plant.finger]", "[aliases]\nplant = 'blocks.finger.kind'\n[variants.plant.finger]"),
     "aliases.plant: is the name of a variant too"),
    (("[variants.plant.finger]", "[aliases]\nlate = 'wires.1.latency_ms'\n[variants.plant.finger]"),
     "aliases.late: names a wire by its number"),
    (('aliases.fmu = "blocks.fmu.path"', "aliases.late = 'wires[1].latency_ms'"),
     "variants.plant.fmu.aliases.late: names a wire by its number"),
    (("aliases.fmu =", "aliases.link ="), "variants.plant.fmu.aliases.link: is the name of a variant too"),
    (("[variants.link.radio]", "[variants.'a b']\ndefault='x'\n[variants.'a b'.x]\n[variants.link.radio]"),
     'variants."a b": is no name for --set'),
])
def test_what_is_wrong_with_any_option_is_said_before_it_is_picked(file, change, found):
    line = fault(file(VARIANTS, change))
    assert found in line
    assert "\n" not in line
    assert "small.toml: " in line


def test_faults_of_several_options_are_named_at_once(file):
    changes = (('default = "finger"', 'default = "fin"'), ("score.truth", "scores.truth"))
    assert len(fault(file(VARIANTS, *changes)).splitlines()) == 2


def test_a_file_of_the_wrong_form_is_left_for_its_check(file):
    line = fault(file(VARIANTS, ('from = "reference.angles"', "from = 3")), ["plant=weak"])
    assert "wires[0].from: 3 is an integer" in line


def test_a_removed_key_is_no_setting_any_more(file):
    text = VARIANTS + '[aliases]\nstrength = "blocks.finger.strength"\n'
    assert fesloop.load(file(text), ["strength=2"])
    assert "--set strength: is no key of" in fault(file(text), ["plant=fmu", "strength=2"])


def test_the_recording_is_of_what_was_picked_and_repeats_it(file, tmp_path, capsys):
    first = fesloop.load(file(), ["plant=weak", "patient=faster"]).run(tmp_path)
    with Recording(first.recording) as recording:
        assert recording.experiment["blocks"]["finger"]["strength"] == 0.5
        assert recording.experiment["experiment"]["description"].endswith("; plant weak: half as strong")
    again = fesloop.load(str(first.recording))
    assert again == fesloop.load(file(), ["plant=weak", "patient=faster"])
    assert again.run(tmp_path).metrics == first.metrics
    assert "is no key of" in fault(str(first.recording), ["plant=weak"])


def test_check_shows_the_options_and_what_is_picked(file, capsys):
    assert main(["check", str(file()), "--set", "plant=fmu", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["variants"]["plant"] == {"default": "finger", "options": {
        "finger": "", "weak": "half as strong", "fmu": "the finger as an FMU"}}
    assert told["aliases"] == {"fmu": "blocks.fmu.path"}
    assert main(["check", str(file()), "--set", "plant=weak"]) == 0
    out = capsys.readouterr().out
    assert "weak (picked)" in out
    assert "half as strong" in out


@pytest.mark.slow
def test_the_schema_has_variants():
    document, schema = tomllib.loads(SMALL + VARIANTS), json_schema()
    jsonschema.validate(document, schema)
    document["variants"]["plant"]["weak"]["bloks"] = {}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema)


def test_a_wire_that_suits_another_option_names_the_options_without_it(capsys):
    """Another block in the place of MPC: the wire of MPC's preview leads nowhere."""
    own = 'blocks.controller={kind = "select", rate = "50", indices = [0]}'
    wire = "wire reference.preview->controller.reference_preview: 'controller' has no input port"
    for picked in ([], ["control=mpc_memory"]):
        assert main(["check", "finger_control", "--set", own, *(f"--set={each}" for each in picked)]) == 2
        printed = next(line for line in capsys.readouterr().err.splitlines() if "reference_preview" in line)
        option = picked[0].partition("=")[2] if picked else "mpc"
        assert wire in printed
        assert f"the wire is there with control={option}; without it: control=pid, control=ilc" in printed
        assert "did you mean" not in printed
    assert main(["check", "finger_control", "--set", own, "--set", "control=pid"]) == 2
    assert "wire reference.preview" not in capsys.readouterr().err  # the remedy removes this fault


def test_what_is_picked_is_told_with_it():
    picked = pick(tomllib.loads(SMALL + VARIANTS), ["patient=faster", "pid=3"], "small")
    assert picked.options == {"plant": "finger", "link": "radio", "patient": "faster", "watched": "no"}
    assert picked.settings == ("pid=3",)
    assert picked.name == "small with patient=faster"
    assert "variants" not in picked.document


anything = st.recursive(
    st.none() | st.booleans() | st.integers(-1, 2) | st.sampled_from(["", "a", "finger", "blocks.pid"]),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=4),
    max_leaves=12)


@given(st.dictionaries(st.sampled_from(TABLES), anything, max_size=4), anything)
def test_whatever_a_file_says_is_an_experiment_or_refused(tables, variants):
    document = {**tomllib.loads(SMALL), **tables, "variants": variants}
    with suppress(InputError):
        assert "variants" not in pick(document, ["plant=finger"], "file").document


@given(st.dictionaries(st.sampled_from(["finger", "weak"]), st.dictionaries(st.sampled_from(
    ["like", "remove", "blocks", "wires", "record", "aliases", "description"]), anything, max_size=3)))
def test_whatever_an_option_says_is_made_or_refused(options):
    document = {**tomllib.loads(SMALL), "variants": {"plant": {"default": "finger", **options}}}
    with suppress(InputError):
        assert "variants" not in pick(document, ["plant=weak"], "file").document


OF_PID = {"kp": 1, "ki": 2, "delay": {"file": "a"}}


@given(gone=st.sets(st.sampled_from(list(OF_PID)), min_size=1), said=st.sampled_from(list(OF_PID)),
       value=st.one_of(st.integers(), st.just({"file": "b"})), turned=st.booleans(), replaced=st.booleans())
def test_a_parameter_that_goes_with_its_blocks_kind_is_gone_whatever_others_make_of_it(
        gone, said, value, turned, replaced):
    """In either order of the variants; without another kind, the options change one key in two ways."""
    other = {"remove": [f"blocks.pid.{key}" for key in sorted(gone)],
             "blocks": {"pid": {"kind": "other" if replaced else "pid"}}}
    variants = {"control": {"default": "pid", "pid": {}, "other": other},
                "follow": {"default": "all", "all": {}, "some": {"blocks": {"pid": {said: value}}}}}
    if turned:
        variants = dict(reversed(variants.items()))
    document = {"blocks": {"pid": {"kind": "pid", **OF_PID}}, "variants": variants}
    if said in gone and not replaced and value != OF_PID[said]:
        with pytest.raises(InputError, match=f"both change blocks.pid.{said};"):
            pick(document, ["control=other", "follow=some"], "small")
        return
    made = pick(document, ["control=other", "follow=some"], "small").document["blocks"]["pid"]
    kept = {key: given for key, given in {**OF_PID, said: value}.items() if key not in gone}
    assert made == {"kind": "other" if replaced else "pid", **kept}

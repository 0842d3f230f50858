"""Every mistake in a file is named, with its key and what is allowed, and all of them at once."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import settings as tried
from hypothesis import strategies as st

import fesloop
from controllers.pid import Pid
from controllers.reference import MinimumJerk
from fesloop import Duration, Experiment, InputError, Node, Score, Wire
from fesloop.analysis.study.design.study_file import read_study
from fesloop.experiment.files.parse import from_document, read
from fesloop.experiment.files.source import shipped
from fesloop.forms.faults import wire_place
from fesloop.forms.schema import make
from fesloop.models.linear_model import LinearModel, Recruitment
from plants.finger import Finger

SMALL = Path(__file__).parents[1] / "small.toml"


def faults_with(*settings):
    """Lines of the refusal of the small experiment with some keys changed."""
    with pytest.raises(InputError) as refused:
        fesloop.load(SMALL, settings)
    return str(refused.value).splitlines()


def faults_of(tmp_path, *changes):
    """Lines of the refusal of the small experiment with some text replaced."""
    text = SMALL.read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after, 1)
    file = tmp_path / "changed.toml"
    file.write_text(text)
    with pytest.raises(InputError) as refused:
        fesloop.load(file)
    return str(refused.value).splitlines()


@pytest.mark.parametrize(("setting", "place", "allowed"), [
    ('wires.1.latency_ms="0.01"', 'wires."finger.angles->pid.measured".latency_ms', "a number"),
    ("wires.1.latency_ms=true", 'wires."finger.angles->pid.measured".latency_ms', "a number"),
    ("wires.1.latency_ms=-1", "latency_ms", "zero or more"),
    ("wires.1.loss=1.5", "loss", "[0, 1)"),
    ("wires.1.late=never", 'wires."finger.angles->pid.measured".late', "keep-newest"),
    ("wires.1.jitter.kind=gauss", 'wires."finger.angles->pid.measured".jitter.kind', "normal"),
    ("wires.1.jitter.low_ms=9", "jitter.low_ms", "at most high_ms"),
    ("wires.1.jitter.low_ms=-30", "jitter", "at least 0"),
    ("wires.1.from=finger.angle", "finger.angle", "angles"),
    ("wires.1.from=fingers.angles", "fingers.angles", "finger"),
    ("wires.1.to=pid.measure", "pid.measure", "measured"),
    ("wires.1.to=pid", "'pid'", "node.port"),
    ("blocks.pid.rate=-50", "pid.rate", "a positive rate"),
    ("blocks.pid.rate=true", "blocks.pid.rate", "a positive rate"),
    ("blocks.pid.kind=pidd", "blocks.pid.kind", "did you mean 'pid'?"),
    ("blocks.pid.kp.1=big", "blocks.pid.kp[1]", "a number"),
    ("blocks.pid.kp=0.3", "blocks.pid.kp", "a list; write a list of one as [0.3]"),
    ("blocks.pid.kp=[0.1, 0.2]", "blocks.pid", "one a joint"),
    ("blocks.pid.gain=0.1", "blocks.pid.gain", "kp"),
    ("blocks.pid.recruitment.chronaxie_us=-1", "blocks.pid.recruitment.chronaxie_us", "above 0"),
    ("blocks.pid.execution.kind=fixed", "blocks.pid.execution.ms", "fixed: ms"),
    ("blocks.finger.rate=100", "blocks.finger.rate", "stiffness"),
    ("blocks.finger.stiffness=[1.0, 2.0]", "blocks.finger.stiffness", "a"),
    ("experiment.duration_s=0", "experiment.duration_s", "above 0"),
    ("experiment.duration_s=nan", "experiment.duration_s", "a finite number"),
    ("experiment.duration_s=inf", "experiment.duration_s", "a finite number"),
    ("experiment.duration_s=1e300", "experiment.duration_s", "below 4.6e+09"),
    ("experiment.trials=3000000000", "experiment.trials", "at most 2147483647"),
    ("experiment.seed=9223372036854775808", "experiment.seed", "at most 9223372036854775807"),
    (f"experiment.name={'x' * 300}", "experiment.name", "at most 100"),
    ('record.timed=["pid", "pid"]', "record.timed", "each block once"),
    ("experiment.trials=0", "experiment.trials", "1 or more"),
    ("experiment.trials=2.5", "experiment.trials", "an integer"),
    ("experiment.seed=-1", "experiment.seed", "0 or more"),
    ("experiment.duration_s=2020-01-01", "experiment.duration_s", "a number"),
    ("score.after_s=1.0", "score.after_s", "below 1 s"),
    ("score.truth=finger.angel", "score.truth", "finger.angles"),
    ('score.joints=["MCP"]', "score.joints", "as many as the signals have values"),
    ('score.joints=["MCP", "MCP", "DIP"]', "score.joints", "each joint once"),
    ("score.truth=finger.rates", "score.truth", "'rad'"),
    ("score.estimate=pid.stimulation", "score.estimate", "'rad'"),
    ("record.plant_rate=0", "record.plant_rate", "a positive rate"),
])
def test_a_wrong_value_is_one_line_with_file_key_and_what_is_allowed(setting, place, allowed):
    lines = faults_with(setting)
    assert len(lines) == 1
    assert str(SMALL) in lines[0]
    assert place in lines[0]
    assert allowed in lines[0]


def test_all_faults_are_named_at_once():
    lines = faults_with("blocks.pid.gain=1", "wires.0.latency_ms=true", "experiment.trials=x",
                        "blocks.finger.damping=1")
    places = ("blocks.pid.gain", 'wires."reference.angles->pid.reference".latency_ms', "experiment.trials",
              "blocks.finger.damping")
    assert len(lines) == len(places)
    for place in places:
        assert any(place in line for line in lines)


ENDS = ("reference.angles->pid.reference", "finger.angles->pid.measured",
        "pid.stimulation->finger.stimulation")


@pytest.mark.parametrize("wrong", ['latency_ms = "late"', "latency_ms = -1", "lost = 0.1",
                                   'jitter = { kind = "x" }'])
@pytest.mark.parametrize("ends", ENDS)
def test_a_wire_of_a_file_that_extends_others_is_named_by_its_ends(tmp_path, ends, wrong):
    """Its number is that among the wires of all files, which stand nowhere together."""
    source, target = ends.split("->")
    (tmp_path / "base.toml").write_text(SMALL.read_text())
    (tmp_path / "middle.toml").write_text('extends = "base.toml"\n')
    (tmp_path / "own.toml").write_text(
        f'extends = "middle.toml"\n[[wires]]\nfrom = "{source}"\nto = "{target}"\n{wrong}\n')
    with pytest.raises(InputError) as refused:
        fesloop.load(tmp_path / "own.toml")
    line, = str(refused.value).splitlines()
    assert f'own.toml: wires."{ends}"' in line
    assert "wires[" not in line


def test_wires_without_ends_of_their_own_are_named_by_number():
    assert [wire_place(i, [{"from": "a.b"}, {"from": "a.b", "to": "c.d"}, {"from": "a.b", "to": "c.d"}, 3])
            for i in range(4)] == [f"wires[{i}]" for i in range(4)]


def test_names_of_joints_are_not_held_against_a_signal_that_is_not_there():
    line, = faults_with('score.joints=["MCP", "PIP", "DIP"]', "score.truth=finger.angel")
    assert "score.truth" in line


def test_signals_that_are_compared_have_as_many_values():
    """Angles of another number of joints would only come to light once the run is over."""
    line, = faults_with('blocks.other={kind="minimum_jerk", rate="50", times_s=[0.5], angles_deg=[[20, 25]]}',
                        "score.reference=other.angles")
    assert "score.reference" in line
    assert "'other.angles' has shape (2,); allowed: (3,), as 'finger.angles'" in line


def with_clocks(**clocks):
    """The small experiment's document with more references, each on the clock of another block."""
    document = dict(read(SMALL)[1])
    other = {key: value for key, value in document["blocks"]["reference"].items() if key != "rate"}
    followers = {name: {**other, "clock": owner} for name, owner in clocks.items()}
    return {**document, "blocks": {**followers, **document["blocks"]}}


@pytest.mark.parametrize("clocks", [
    {"a": "b", "b": "c", "c": "pid"}, {"c": "pid", "b": "c", "a": "b"}, {"b": "c", "a": "b", "c": "pid"}])
def test_clocks_are_followed_in_any_order(clocks):
    """And the file of the recording of such a run can be loaded."""
    experiment = from_document(with_clocks(**clocks))
    nodes = {node.name: node for node in experiment.nodes}
    assert nodes["a"].clock == nodes["b"].clock == nodes["c"].clock == nodes["pid"].clock
    assert from_document(experiment.document()) == experiment


@pytest.mark.parametrize(("clocks", "circle"), [
    ({"a": "a"}, "a follows a"), ({"a": "b", "b": "a"}, "a follows b follows a"),
    ({"d": "b", "a": "b", "b": "c", "c": "a", "e": "pid"}, "a follows b follows c follows a")])
def test_clocks_that_go_round_in_a_circle_are_named(clocks, circle):
    with pytest.raises(InputError) as refused:
        from_document(with_clocks(**clocks))
    assert str(refused.value) == (f"experiment: blocks.a.clock: there is no clock to follow: {circle}; "
                                  "allowed: a block with a rate or a clock of its own")


def test_a_block_that_follows_one_that_is_refused_is_no_fault_of_its_own():
    document = with_clocks(a="b", b="c", c="pid")
    document["blocks"]["c"]["angles_deg"] = []
    with pytest.raises(InputError) as refused:
        from_document(document)
    assert len(str(refused.value).splitlines()) == 1


def test_faults_that_only_the_objects_know_are_all_named():
    lines = faults_with("blocks.finger.density=-1", "blocks.pid.width_max_us=-5", "wires.0.loss=2")
    assert len(lines) == 3


def test_a_wrong_value_of_the_only_kind_is_named_with_its_key():
    """pydantic tells the kind of a block where it has several to choose from, and there alone."""
    about = read(SMALL)[1]["experiment"]
    with pytest.raises(InputError) as refused:
        from_document({"experiment": about, "blocks": {"finger": {"kind": "finger", "strength": True}}})
    assert refused.value.where == "experiment: blocks.finger.strength"


def test_an_experiment_without_blocks_is_refused():
    with pytest.raises(InputError, match="blocks: there is none"):
        from_document({"experiment": {"name": "nothing", "duration_s": 1.0}, "blocks": {}})


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_a_file_may_come_from_another_system(tmp_path, encoding):
    """Byte order mark and carriage returns, as editors of another system write them."""
    file = tmp_path / "other.toml"
    file.write_bytes(SMALL.read_text().replace("\n", "\r\n").encode(encoding))
    assert fesloop.load(file) == fesloop.load(SMALL)


def test_two_wires_into_a_port_are_refused(tmp_path):
    line, = faults_of(tmp_path, ('to = "pid.reference"', 'to = "pid.measured"'),
                      ("[score]", '[[wires]]\nfrom = "reference.angles"\nto = "pid.reference"\n\n[score]'))
    assert "already has a wire" in line
    assert "changed.toml" in line


@pytest.mark.parametrize("rate", ["true", "[50]", "0", "-0.5", '"fast"', "1e12"])
def test_a_rate_is_text_or_a_number_above_zero(tmp_path, rate):
    line, = faults_of(tmp_path, ('rate = "50"\nkp', f"rate = {rate}\nkp"))
    assert "pid.rate" in line
    assert "a number" in line or "positive rate" in line or "1 ns" in line


def test_an_input_without_a_wire_is_refused(tmp_path):
    line, = faults_of(tmp_path, ('[[wires]]\nfrom = "reference.angles"\nto = "pid.reference"\n', ""))
    assert "pid.reference" in line
    assert "no wire" in line


def test_a_unit_mismatch_is_refused(tmp_path):
    line, = faults_of(tmp_path, ('from = "finger.angles"', 'from = "finger.rates"'))
    assert "'rad/s'" in line
    assert "'rad'" in line


def test_a_shape_mismatch_is_refused(tmp_path):
    line, = faults_of(tmp_path, ("angles_deg = [[20, 25, 15], [35, 45, 25]]", "angles_deg = [[20], [35]]"))
    assert "(1,)" in line
    assert "(3,)" in line


@pytest.mark.parametrize(("content", "found"), [
    (b"[experiment\n", "line 1"),
    (b"a = 1\na = 2\n", "line 2"),
    (b"\xff\xfe", "UTF-8"),
    (b"", "experiment: is missing"),
])
def test_a_file_that_is_no_toml_says_where(tmp_path, content, found):
    file = tmp_path / "bad.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"bad\.toml") as refused:
        fesloop.load(file)
    assert found in str(refused.value)


def test_missing_files_and_names_are_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read: No such"):
        fesloop.load(tmp_path / "absent.toml")
    with pytest.raises(InputError, match="Is a directory"):
        fesloop.load(tmp_path)
    with pytest.raises(InputError, match="did you mean"):
        fesloop.load("finger_icl")


def test_a_setting_in_python_and_in_toml_makes_the_same_experiment():
    recruitment = Recruitment(threshold_ma=(12, 10, 10, 8), spread=(0.35,) * 4)
    pid = Pid(kp=(0.3, 0.3, 0), ki=(1, 1, 0), kd=(0, 0, 0),
              mixing=((0, 1, 0), (1, 0, 0), (0, 0, 0), (0, 0, 0)),
              current_ma=(30,) * 4, recruitment=recruitment)
    made = Experiment(
        name="small", description="PID on a virtual finger", duration_s=1, trials=2, seed=3,
        nodes=(
            Node("reference", MinimumJerk(times_s=(0.1, 0.6), angles_deg=((20, 25, 15), (35, 45, 25))), "50"),
            Node("pid", pid, "50"),
            Node("finger", Finger()),
        ),
        wires=(
            Wire("reference.angles", "pid.reference"),
            Wire("finger.angles", "pid.measured", latency_ms=15,
                 jitter=Duration(kind="uniform", low_ms=0, high_ms=4)),
            Wire("pid.stimulation", "finger.stimulation", latency_ms=5),
        ),
        score=Score(truth="finger.angles", reference="reference.angles"),
    )
    assert made == fesloop.load(SMALL)
    assert made != fesloop.load(SMALL, ["blocks.pid.kp.0=0.31"])


def test_a_rate_is_the_same_as_a_ratio_and_as_its_text():
    reference = MinimumJerk(times_s=(0.1, 0.6), angles_deg=((20, 25, 15), (35, 45, 25)))
    one, other = (Experiment(name="x", duration_s=1.0, nodes=(Node("reference", reference, rate),))
                  for rate in (Fraction(2000, 7), "2000/7"))
    assert one == other
    assert from_document(one.document()) == other


@pytest.mark.parametrize("name", [SMALL, "finger_ilc", "finger_mpc", "finger_pid_latency"])
def test_the_resolved_document_makes_the_same_experiment_again(name):
    experiment = fesloop.load(name)
    again = from_document(experiment.document())
    assert again == experiment
    assert again.fingerprint() == experiment.fingerprint()


def test_a_model_can_be_given_as_a_plant_or_as_matrices():
    from fesloop.forms.schema import build, plain

    told = build(LinearModel, {"kind": "finger", "strength": 1.2}, {"finger": Finger}, "model")
    matrices = build(LinearModel, plain(told), {}, "model")
    assert (told.b == Finger(strength=1.2).linear_model().b).all()
    assert (matrices.a == told.a).all()
    assert matrices.recruitment == told.recruitment


def test_shipped_experiments_describe_themselves():
    assert {"finger_ilc", "finger_mpc", "finger_pid_latency", "finger_fmu", "replay"} <= set(shipped())
    for name in shipped():
        about = read(name)[1]["experiment"]
        assert about["name"] == name
        assert about["description"]


@pytest.mark.parametrize(("name", "alias"), [
    ("hil_replay", "recording"), ("hil_twin", "recording"), ("hil_error_replay", "error")])
def test_what_must_be_given_is_told_by_its_short_name(name, alias):
    with pytest.raises(InputError, match=f"is missing; give it with --set {alias}="):
        fesloop.load(name)


@dataclass(kw_only=True)
class Spacious:
    """As long as its number."""

    length: int

    def __post_init__(self):
        self.zeros = [0] * self.length


def test_what_needs_more_memory_than_there_is_is_refused_by_name():
    with pytest.raises(InputError, match=r"blocks.wide: its numbers cannot be computed with: .*memory"):
        make(Spacious, {"length": 2**62}, {}, "blocks.wide")


@tried(deadline=None, max_examples=30)
@given(alias=st.sampled_from(["tracker_latency_ms", "loss", "silence_ms", "mass_kg", "move_weight",
                              "jitter_ms", "misalignment_deg"]),
       value=st.floats(-1e3, -1e-3).map(lambda value: round(value, 3)))
def test_a_fault_at_an_alias_names_the_setting_and_the_key_that_it_wrote(alias, value):
    """One line for each wrong key, and one for a link of several wires; other settings are not named."""
    setting, keys = f"{alias}={value}", {
        "tracker_latency_ms": ["links.radio.latency_ms"], "loss": ["links.radio.loss"],
        "silence_ms": ["blocks.safety.watchdog.silence_ms"], "jitter_ms": ["links.radio.jitter.low_ms"],
        "mass_kg": ["blocks.hand.object.mass_kg", "blocks.grip.mass_kg"],
        "move_weight": ["blocks.controller.move_weight"],
        "misalignment_deg": ["blocks.imus.mounting_angle_deg"]}
    with pytest.raises(InputError) as refused:
        fesloop.load("grasp_mpc", ["error_scale=1", setting, "day=2", "brace={ wrist_abduction = 0.0 }"])
    starts = [line.partition(f" (--set {setting}): ") for line in str(refused.value).splitlines()]
    assert [place.rpartition(": ")[2] for place, *_ in starts] == keys[alias]
    assert all(rest for *_, rest in starts)
    written = [f"{key.replace('low_ms', 'high_ms')}={value}" for key in keys[alias]]
    if alias != "misalignment_deg":
        with pytest.raises(InputError) as refused:
            fesloop.load("grasp_mpc", written)
        assert "--set" not in str(refused.value)


def test_a_study_and_another_file_in_place_of_an_experiment_are_named(tmp_path):
    study, other = tmp_path / "st.toml", tmp_path / "pid.py"
    study.write_text('[study]\nname = "mine"\nexperiment = "finger_control"\n')
    other.write_text("pass\n")
    with pytest.raises(InputError, match=r"st.toml: is a study; .*fesloop study .*st.toml"):
        fesloop.load(str(study))
    own = tmp_path / "ex.toml"
    own.write_text('[experiment]\nname = "x"\nduration_s = 1\n[blocks.a]\nkind = "pid"\n')
    with pytest.raises(InputError, match=r"ex.toml: is an experiment; .*fesloop run .*ex.toml"):
        read_study(str(own))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        with pytest.raises(InputError, match=r"pid.py: is not an experiment file"):
            fesloop.load("pid.py")

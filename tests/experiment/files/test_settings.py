"""`--set` changes what a file says, by alias or by path, and refuses keys that lead nowhere."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop import load
from fesloop.errors import InputError
from fesloop.experiment.files.settings import apply_settings

DOCUMENT = {
    "experiment": {"name": "x", "seed": 1},
    "blocks": {"pid": {"kind": "pid", "rate": "50", "kp": [1.0, 2.0]},
               "play": {"kind": "replay", "file": "a"}},
    "wires": [{"from": "a.b", "to": "c.d"}, {"from": "e.f", "to": "g.h", "latency_ms": 1}],
    "aliases": {"recording": "blocks.play.file", "gains": ["blocks.pid.kp.0", "blocks.pid.kp.1"]},
}


def changed(*settings):
    return apply_settings(DOCUMENT, settings, "x.toml")


@pytest.mark.parametrize(("setting", "path", "value"), [
    ("experiment.seed=7", ("experiment", "seed"), 7),
    ("blocks.pid.kp.1=2.5", ("blocks", "pid", "kp", 1), 2.5),
    ("blocks.pid.kp[1]=2.5", ("blocks", "pid", "kp", 1), 2.5),
    ("blocks.pid.kp=[3, 4]", ("blocks", "pid", "kp"), [3, 4]),
    ("blocks.pid.rate=60", ("blocks", "pid", "rate"), "60"),
    ("wires.1.latency_ms=30", ("wires", 1, "latency_ms"), 30),
    ('wires."a.b->c.d".loss=0.1', ("wires", 0, "loss"), 0.1),
    ("recording=/data/trial 1.mat", ("blocks", "play", "file"), "/data/trial 1.mat"),
    ("recording=2024", ("blocks", "play", "file"), "2024"),
    ('recording="b=c"', ("blocks", "play", "file"), "b=c"),
    ("gains=5", ("blocks", "pid", "kp"), [5, 5]),
    ("score.truth=a.b", ("score", "truth"), "a.b"),
])
def test_a_setting_lands_where_its_key_points(setting, path, value):
    here = changed(setting)
    for key in path:
        here = here[key]
    assert here == value
    assert "score" not in DOCUMENT


@pytest.mark.parametrize(("setting", "told"), [
    ('blocks.pid={kind="own.py:Pid", rate="50"}', "A PID holds a finger; by --set pid is own.py:Pid"),
    ("blocks.play.kind=stream", "A PID holds a finger; by --set play is stream"),
    ("blocks.pid.rate=60", "A PID holds a finger"),
    ('blocks.pid={kind="pid"}', "A PID holds a finger")])
def test_the_description_says_which_blocks_it_does_not_speak_of(setting, told):
    about = {**DOCUMENT["experiment"], "description": "A PID holds a finger"}
    document = {**DOCUMENT, "experiment": about}
    assert apply_settings(document, [setting], "x.toml")["experiment"]["description"] == told
    assert about["description"] == "A PID holds a finger"


@pytest.mark.parametrize(("setting", "found"), [
    ("blocks.pidd.kp=1", "did you mean 'pid'"),
    ("recordin=1", "did you mean 'recording'"),
    ("seed=1", "did you mean 'experiment.seed'?"),
    ("kp=1", "did you mean 'blocks.pid.kp'?"),
    ("nothing=1", "recording, gains, experiment.KEY"),
    ("wires.7.loss=0", "0 to 1"),
    ("wires.².loss=0", "no '²' there; allowed: 0 to 1"),
    ('wires."a.b->c.e".loss=0', "a.b->c.d"),
    ("blocks.pid.kp.9=0", "no '9' there; allowed: 0 to 1"),
    ("experiment.seed.x=0", "no further keys"),
    ("seed", "has no '='; allowed: KEY=VALUE"),
    ("=3", "has no key; allowed: KEY=VALUE"),
])
def test_a_key_that_leads_nowhere_is_refused(setting, found):
    with pytest.raises(InputError, match="--set") as refused:
        changed(setting)
    assert found in str(refused.value)


def test_one_text_in_place_of_a_list_is_refused():
    """Its letters are no settings."""
    with pytest.raises(InputError, match=r"settings: 'latency_ms=3' is one text; allowed: a list"):
        load("finger_mpc", "latency_ms=3")


def test_lists_and_tables_with_text_in_them_are_set_as_such():
    """A value is text where the parameter is, not where some of its items or keys are."""
    document = {"experiment": {"name": "set", "duration_s": 1}, "blocks": {
        "hand": {"kind": "moving_hand", "script": "P1"},
        "tracker": {"kind": "constrained", "rate": "100"}}}
    settings = ["blocks.hand.rest_deg={F2_pip_flexion=10.0}", 'blocks.tracker.sensed=["hand", "F2p"]',
                "blocks.hand.script=A-F1"]
    blocks = apply_settings(document, settings, "set")["blocks"]
    assert blocks["hand"]["rest_deg"] == {"F2_pip_flexion": 10.0}
    assert blocks["tracker"]["sensed"] == ["hand", "F2p"]
    assert blocks["hand"]["script"] == "A-F1"


@given(st.lists(st.sampled_from(["rest", "open", "close", "back again"]), min_size=1, max_size=6), st.data())
def test_a_member_of_a_list_is_found_by_its_name_unless_several_have_it(names, data):
    """Truth: the place of the name in the list."""
    document = {"blocks": {"reference": {"phases": [{"name": each} for each in names]}}}
    name = data.draw(st.sampled_from(names))
    setting = f'blocks.reference.phases."{name}".duration_s=2.5'
    if names.count(name) > 1:
        with pytest.raises(InputError, match=f"no {name!r} there; allowed: 0 to {len(names) - 1}"):
            apply_settings(document, [setting], "x.toml")
        return
    phases = apply_settings(document, [setting], "x.toml")["blocks"]["reference"]["phases"]
    assert [each.get("duration_s") for each in phases] == [2.5 if each == name else None for each in names]

"""What hangs on what has one source: trackers take it from the samples' source, or are refused by name."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from estimators.constrained.block import ConstrainedTracker
from estimators.fusion.trackers import VqfTracker
from estimators.salchow.block import SalchowM2
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from fesloop.loop.wiring_checks import resolved
from fesloop.streams.live.inlet import LslInlet
from plants.imus.block import Imus

RATE, SECONDS = 50, 6
LETTERS = "abcdefgh"


def written(folder, angles_rad, pairs, names=LETTERS):
    """A recording of sensors that turn about one level axis by angles (n, sensors), with these pairs."""
    rates = np.gradient(angles_rad, 1.0 / RATE, axis=0)
    zero, g = np.zeros(len(angles_rad)), 9.80665
    rows, text = [], f"rate = {RATE}\n[text]\nheader = 0\n"
    stated = [[names[p], names[c]] for p, c in pairs]
    text = f"pairs = {stated}\n" * bool(stated) + text
    for k in range(angles_rad.shape[1]):
        bent = angles_rad[:, k]
        rows += [zero, zero, rates[:, k], g * np.sin(bent), g * np.cos(bent), zero]
        text += f"[sensors.{names[k]}]\ngyr = {[6 * k + i for i in (1, 2, 3)]}\n" \
                f"acc = {[6 * k + i for i in (4, 5, 6)]}\n"
    table = np.column_stack(rows)
    table += np.random.default_rng(0).normal(0.0, 1e-3, table.shape)
    np.savetxt(folder / "lab.csv", table, delimiter=",")
    (folder / "layout.toml").write_text(text)
    return [f"recording={folder / 'lab.csv'}", f"blocks.recording.layout={folder / 'layout.toml'}"]


def bends(sensors, seed=0):
    """Angles (n, sensors) that each rise to another value and stay, rad."""
    times = np.arange(RATE * SECONDS) / RATE
    ends = np.radians(np.random.default_rng(seed).permutation(np.linspace(-50.0, 60.0, sensors)))
    return np.clip((times[:, np.newaxis] - 1.0) / 2.0, 0.0, 1.0) * ends


@st.composite
def trees(draw, least=2, most=7):
    """(pairs, sensors): a parent for each but one, in any order of the sensors."""
    sensors = draw(st.integers(least, most))
    order = draw(st.permutations(range(sensors)))
    pairs = [(order[draw(st.integers(0, k - 1))], order[k]) for k in range(1, sensors)]
    return draw(st.permutations(pairs)), sensors


@pytest.mark.slow
@given(tree=trees(), experiment=st.sampled_from(["replay", "hil_replay"]), seed=st.integers(0, 9))
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_angles_are_those_of_the_pairs_that_a_layout_states(tmp_path, tree, experiment, seed):
    pairs, sensors = tree
    angles = bends(sensors, seed)
    result = load(experiment, written(tmp_path, angles, pairs)).run(tmp_path / "runs")
    with Recording(result.recording) as run:
        seen = np.degrees(run.signal("tracker.angles").values)
    true = np.degrees([angles[-1, child] - angles[-1, parent] for parent, child in pairs])
    assert seen.shape[1] == len(pairs)
    np.testing.assert_allclose(seen[-50:].mean(axis=0), true, atol=2.0)


@pytest.mark.slow
@given(tree=trees(least=3), chosen=st.data(), kind=st.sampled_from(["vqf", "vqf9", "seel_ruppin"]))
@settings(max_examples=4, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_pairs_of_a_tracker_are_of_those_that_a_layout_states_or_are_refused(tmp_path, tree, chosen, kind):
    pairs, sensors = tree
    given_ = written(tmp_path, bends(sensors), pairs)
    some = chosen.draw(st.lists(st.sampled_from(pairs), min_size=1, max_size=3, unique=True))
    if kind == "vqf":
        experiment = load("replay", [*given_, f"blocks.tracker.pairs={[list(pair) for pair in some]}"])
        (tracker,) = (node.part for node in experiment.wiring.nodes if node.name == "tracker")
        assert tracker.pairs == tuple(some)
    ends = st.integers(0, sensors - 1)
    other = chosen.draw(st.tuples(ends, ends))
    assume(other[0] != other[1] and other not in pairs)
    wrong = [list(pair) for pair in (*some, other)]
    if kind == "vqf":
        with pytest.raises(InputError, match=re.escape(f"{list(other)} ({LETTERS[other[0]]}-")) as caught:
            load("replay", [*given_, f"blocks.tracker.pairs={wrong}"])
        assert "tracker.pairs" in str(caught.value)
        assert f"{LETTERS[pairs[0][0]]}-{LETTERS[pairs[0][1]]}" in str(caught.value)


def test_three_sensors_of_which_nothing_is_stated_are_no_chain(tmp_path):
    given_ = written(tmp_path, bends(3), [])
    with pytest.raises(InputError, match=r"tracker\.pairs: which of the sensors a, b, c are neighbours"):
        load("hil_replay", given_)
    load("hil_replay", [*given_, "pairs=[[0, 1], [0, 2]]"])
    load("hil_replay", written(tmp_path, bends(2), []))


HAND = ("forearm", "hand", "F1m", "F1p", "F1d", "F2p", "F2m", "F2d", "F3p", "F3m", "F3d", "F4p", "F5p")
PARENTS = {"hand": "forearm", "F1p": "F1m", "F1d": "F1p", "F2m": "F2p", "F2d": "F2m", "F3m": "F3p",
           "F3d": "F3m"}


def nearest(name, names):
    """The nearest segment towards the forearm that has a sensor."""
    parent = PARENTS.get(name, None if name == "forearm" else "hand")
    while parent is not None and parent not in names:
        parent = PARENTS.get(parent, None if parent == "forearm" else "hand")
    return parent


@given(names=st.lists(st.sampled_from(HAND), min_size=2, max_size=6, unique=True),
       kind=st.sampled_from(["vqf", "constrained", "salchow_m2", "kortier"]))
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_sensors_named_after_segments_hang_as_the_hand_does_in_every_tracker(tmp_path, names, kind):
    given_ = written(tmp_path, bends(len(names)), [], names)
    extra = ["blocks.tracker.magnetometers=false"] if kind == "kortier" else []
    expected = {(nearest(name, names), name) for name in names if nearest(name, names)}
    if kind == "vqf" and not expected:
        # No two of them share a joint: three or more are refused, two are taken as a joint by themselves.
        if len(names) > 2:
            with pytest.raises(InputError, match=r"tracker\.pairs: which of the sensors"):
                load("replay", [*given_, f"tracker={kind}"])
        return
    experiment = load("replay", [*given_, f"tracker={kind}", *extra])
    (tracker,) = (node.part for node in experiment.wiring.nodes if node.name == "tracker")
    if kind == "vqf":
        assert {(names[p], names[c]) for p, c in tracker.pairs} == expected
        return
    assert tracker.sensed == tuple(names)
    turned = [*names[1:], names[0]]
    with pytest.raises(InputError, match=r"tracker\.sensed: names"):
        load("replay", [*given_, f"tracker={kind}", *extra, f"blocks.tracker.sensed={turned}"])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["constrained", "kortier"])
def test_five_sensors_are_the_published_chain_only_where_that_is_stated(tmp_path, kind):
    settings_given = [f"tracker={kind}"] + ["blocks.tracker.magnetometers=false"] * (kind == "kortier")
    chain, star = [(0, 1), (1, 2), (2, 3), (3, 4)], [(0, 1), (0, 2), (0, 3), (0, 4)]
    names = ["seg1", "seg2", "seg3", "seg4", "seg5"]
    load("replay", [*written(tmp_path, bends(5), [*chain, (1, 3)], names), *settings_given])
    with pytest.raises(InputError, match="joins seg3 to seg2; allowed: as the recording states it: seg1-"):
        load("replay", [*written(tmp_path, bends(5), star, names), *settings_given])
    for other in (LETTERS, names[::-1]):
        with pytest.raises(InputError, match=f"which joints are between {other[0]}, {other[1]}"):
            load("replay", [*written(tmp_path, bends(5), chain, other), *settings_given])
    with pytest.raises(InputError, match="which of a, b, c, d, e are neighbours is not stated"):
        load("replay", [*written(tmp_path, bends(5), []), *settings_given])


@given(names=st.lists(st.sampled_from(HAND), min_size=3, max_size=6, unique=True),
       kind=st.sampled_from([VqfTracker, ConstrainedTracker, SalchowM2]), live=st.booleans())
@settings(max_examples=20, deadline=None)
def test_trackers_take_simulated_and_live_sensors_as_they_are_named(names, kind, live):
    source = LslInlet(stream="imus", sensors=len(names), sensor_names=tuple(names)) if live else Imus(
        sites=tuple(names), measures=("gyr", "acc"))
    nodes = [Node("imus", source, rate=None if live else 100), Node("tracker", kind(), rate=100)]
    wires = [Wire(f"imus.{port}", f"tracker.{port}") for port in ("gyr", "acc")]
    expected = {(nearest(name, names), name) for name in names if nearest(name, names)}
    if kind is VqfTracker and not expected:
        with pytest.raises(InputError, match="which of the sensors"):
            resolved(nodes, wires)
        return
    tracker = resolved(nodes, wires)[1].part
    if kind is VqfTracker:
        assert {(names[p], names[c]) for p, c in tracker.pairs} == expected
    else:
        assert tracker.sensed == tuple(names)


def test_pairs_of_live_sensors_of_any_names_reach_the_tracker():
    given_ = {"stream": "imus", "sensors": 3, "sensor_names": ("a", "b", "c")}
    source = LslInlet(**given_, pairs=(("c", "a"), ("c", "b")))
    wires = [Wire(f"imus.{port}", f"tracker.{port}") for port in ("gyr", "acc")]
    nodes = [Node("imus", source), Node("tracker", VqfTracker(), rate=100)]
    assert resolved(nodes, wires)[1].part.pairs == ((2, 0), (2, 1))
    for pairs, words in (((("c", "d"),), "'d' is none of sensor_names"), ((("c", "a"), ("a", "c")), "loop")):
        with pytest.raises(InputError, match=f"pairs: .*{words}"):
            LslInlet(**given_, pairs=pairs)

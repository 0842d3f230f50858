"""What became of an object, against courses made up of what can become of one, by the laws of free fall."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop.experiment.metrics.grasp import grasp_metrics
from fesloop.experiment.metrics.grasp_outcome import OUTCOMES, GraspScore
from fesloop.experiment.metrics.missing import MISSING, give_reasons, numbers, reasons_of
from fesloop.loop.block import Context
from plants.hand.contract import FLOOR_M, advance_to
from plants.hand.plant import Hand
from plants.hand.scene import GraspObject

G = 9.81
FROM_S, UNTIL_S, LOWERED_S = 6.0, 8.5, 5.0
FATES = ("held", "slipped", "dropped", "thrown", "on_table", "knocked_off", "not_touched", "not_given",
         "given_late")
GRASPED = ("held", "slipped", "dropped", "thrown")


class Scene(tuple):
    """Printed by its fate alone."""

    def __repr__(self):
        return f"<{self[0]} {self[3]}>"


@st.composite
def scenes(draw, fates=FATES):
    """A fate, and times and places of an object of 60 mm that stands on a table, which sinks by 200 mm."""
    fate = draw(st.sampled_from(fates))
    rate = draw(st.floats(40.0, 400.0))
    times_s = np.arange(0.0, 9.0, 1.0 / rate)
    height_m = draw(st.floats(-0.2, 0.0))
    start = np.array([draw(st.floats(-0.05, 0.05)), draw(st.floats(0.05, 0.12)), height_m + 0.03])
    given_s = draw(st.sampled_from([0.0, 2.0, 3.6]))
    if fate in ("not_given", "given_late"):
        given_s = {"not_given": 3.6, "given_late": draw(st.floats(FROM_S + 0.05, UNTIL_S - 0.2))}[fate]
    sunk = np.clip(0.1 * (times_s - LOWERED_S), 0.0, 0.2)
    places = np.tile(start, (times_s.size, 1))
    if fate not in GRASPED and fate != "given_late":
        places[:, 2] -= sunk
    left_s = draw(st.floats(FROM_S + 0.3, UNTIL_S - 0.4))
    flown_s = np.clip(times_s - left_s, 0.0, None)
    half_m = 0.3
    if fate == "slipped":
        places[:, 2] -= np.clip(0.05 * (times_s - left_s), 0.0, draw(st.floats(0.026, 0.06)))
        places[times_s > UNTIL_S - 0.2, 2] -= 0.022 * (left_s > UNTIL_S - 0.9)
    elif fate in ("dropped", "thrown"):
        sideways = draw(st.floats(1.3, 4.0)) if fate == "thrown" else draw(st.floats(0.0, 0.4))
        places[:, 0] += sideways * flown_s
        bottom = start[2] - sunk if fate == "dropped" else -1e9
        places[:, 2] = np.maximum(start[2] - 0.5 * G * flown_s**2, bottom)
    elif fate == "on_table":
        places[:, 0] += np.clip(0.1 * (times_s - given_s - 0.2), 0.0, draw(st.floats(0.004, 0.1)))
    elif fate == "knocked_off":
        half_m = 0.02
        over_s = given_s + 0.2 + half_m / 0.1
        places[:, 0] += np.clip(0.1 * (times_s - given_s - 0.2), 0.0, None)
        places[:, 2] -= 0.5 * G * np.clip(times_s - over_s, 0.0, None) ** 2
    if fate in ("on_table", "knocked_off", "not_touched") and draw(st.booleans()):  # given too high, it falls
        high = np.where(times_s >= given_s, 0.03 - 0.5 * G * (times_s - given_s) ** 2, 0.0)
        places[:, 2] += np.clip(high, 0.0, None)
    waits = np.array([0.0, draw(st.floats(0.1, 0.4)), 0.0])
    if fate == "not_given":
        places += waits
    elif given_s:
        before = times_s < given_s
        places[before] = start + waits - np.outer(sunk, [0.0, 0.0, 1.0])[before]
    hand = {"object": {"shape": "ball", "size_mm": [60.0], "orientation": [1.0, 0.0, 0.0, 0.0],
                       "mass_kg": 0.2, "friction": 0.8, "position_m": start.tolist(), "given_at_s": given_s,
                       "waits_m": waits.tolist()},
            "table": {"height_m": height_m, "centre_m": start[:2].tolist(), "half_m": [half_m, half_m],
                      "lowered_at_s": LOWERED_S, "lowering_m": 0.2, "lowering_m_s": 0.1}}
    return Scene((fate, times_s, places, hand))


def scored(scene, forces=None):
    _, times_s, places, hand = scene
    signals = {"hand.object": places, "hand.forces": forces}
    recording = SimpleNamespace(trials=1, signals=(), experiment={"blocks": {"hand": hand}},
                                signal=lambda name, trial: SimpleNamespace(
                                    times_ns=np.round(times_s * 1e9).astype(np.int64), values=signals[name]))
    return grasp_metrics(recording, GraspScore(
        object="hand.object", from_s=FROM_S, until_s=UNTIL_S, starts_s=4.0,
        forces=None if forces is None else "hand.forces"))


@settings(deadline=None, max_examples=60)
@given(scenes())
def test_the_word_says_what_became_of_the_object(scene):
    metrics = scored(scene)
    assert metrics["object_outcome"] == [scene[0]]
    assert metrics["held"] == [scene[0] == "held"]


@settings(deadline=None, max_examples=60)
@given(scenes(), st.booleans())
def test_every_number_is_possible_or_missing_with_a_reason(scene, pressing):
    """What sank with its table did not move in the hand, and no fall is a motion in it."""
    metrics = scored(scene, np.full((scene[1].size, 5), 2.0 if pressing else 0.0))
    (moved,), (held_s,) = metrics["object_moved_mm"], metrics["held_s"]
    assert 0.0 <= held_s <= UNTIL_S - FROM_S + 1e-9
    assert math.isnan(moved) == (scene[0] not in GRASPED)
    if scene[0] in ("held", "slipped"):
        assert (moved <= 20.0) == (scene[0] == "held")
    assert math.isnan(moved) or moved < 150.0
    for path, values in numbers(metrics):
        reasons = metrics.get(MISSING, {}).get(".".join(path), [None])
        known = values[0] is not None and math.isfinite(values[0])
        assert (reasons[0] is None) == known
        assert known or len(reasons[0]) > 10


@settings(deadline=None, max_examples=60)
@given(scenes(GRASPED), st.sampled_from(["both", "fingers", "thumb", "neither"]), st.floats(0.0, 5.5))
def test_a_held_object_was_gripped_at_some_time(scene, sides, touches_s):
    """One side is enough where the object is held: the other is met by parts of the hand without sensors."""
    forces = np.zeros((scene[1].size, 5))
    forces[:, 0] = 1.0 * (sides in ("both", "thumb")) * (scene[1] >= touches_s)
    forces[:, 2] = 1.0 * (sides in ("both", "fingers")) * (scene[1] >= touches_s)
    (found_s,) = scored(scene, forces)["time_to_grasp_s"]
    if sides == "both" or (scene[0] == "held" and sides != "neither"):
        assert found_s == pytest.approx(max(touches_s - 4.0, 0.0), abs=1.0 / 40.0)
    else:
        assert math.isnan(found_s)


@given(st.recursive(st.lists(st.none() | st.floats() | st.booleans(), max_size=3),
                    lambda inner: st.dictionaries(st.text("abc", min_size=1, max_size=3), inner, max_size=3),
                    max_leaves=8))
def test_no_number_is_missing_without_a_word(value):
    metrics = {"held": value}
    give_reasons(metrics)
    for path, values in numbers(metrics):
        reasons = metrics.get(MISSING, {}).get(".".join(path), [None] * len(values))
        for item, reason in zip(values, reasons, strict=True):
            assert (reason is None) == (item is not None and math.isfinite(item))
    assert all(reason for _, reason in reasons_of(metrics))


@settings(deadline=None, max_examples=10)
@given(st.floats(0.01, 3.0), st.floats(0.0, 500.0))
def test_what_nothing_holds_falls_no_farther_than_the_floor(above_m, speed_m_s):
    """A fall without end would be as fast as no stable simulation is."""
    plant = HAND
    state = plant.init(Context("hand"))
    state.views.qpos[-5], state.views.qvel[-4] = above_m - FLOOR_M, -speed_m_s
    advance_to(plant.model, plant._bounds, plant.object, None, None, state, 1_000_000_000, 1_000_000)
    assert state.views.qpos[-5] == -FLOOR_M
    assert not state.views.qvel[-6:].any()


HAND = Hand(object=GraspObject(position_m=(0.0, 0.4, 0.0)))


@pytest.mark.slow
def test_a_hand_that_stays_closed_is_given_nothing(tmp_path):
    metrics = fesloop.load("grasp_ilc", ["trials=1"]).run(tmp_path).metrics
    assert metrics["object_outcome"] == ["not_given"]
    assert OUTCOMES["not_given"] in metrics[MISSING]["object_moved_mm"][0]


@pytest.mark.slow
def test_a_held_object_has_a_time_to_grasp(tmp_path):
    metrics = fesloop.load("grasp_mpc").run(tmp_path).metrics
    assert metrics["object_outcome"] == ["held"]
    assert 0.0 < metrics["time_to_grasp_s"][0] < 2.0
    assert metrics["aperture_mm"]["hold"][0] < metrics["aperture_mm"]["contact"][0] \
        < metrics["aperture_mm"]["opening"][0]
    assert MISSING not in metrics

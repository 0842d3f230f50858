"""What a clinician reads first, against recordings made up so that the answers are known."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.metrics.grasp import (
    charge_c,
    fitness_ratio,
    grasp_metrics,
    grasps_until_fatigue,
    unwanted_motion_deg,
)
from fesloop.experiment.metrics.grasp_outcome import (
    FREEDOMS,
    GraspScore,
    contact_s,
    needed_grip_n,
)
from fesloop.hand.anthropometry import FINGERTIPS, PARTS
from fesloop.hand.grip import grip_force
from fesloop.hand.movements import muscle

TIMES_NS = np.arange(0, 1000) * 10_000_000
TIMES_S = TIMES_NS / 1e9
CYLINDER = {"object": {"mass_kg": 0.2, "friction": 0.8}}


def recording(blocks=None, trials=1, **signals):
    """One recording whose every trial is the same; signals by name, underscores for dots."""
    told = {name.replace("__", "."): np.asarray(values, dtype=float) for name, values in signals.items()}
    told.setdefault("hand.object", np.zeros((len(TIMES_NS), 3)))
    return SimpleNamespace(
        trials=trials, signals=(), experiment={"blocks": blocks or {}},
        signal=lambda name, trial: SimpleNamespace(times_ns=TIMES_NS[:len(told[name])], values=told[name]))


def score(**keys):
    return GraspScore(object="hand.object", **{"from_s": 4.0, "until_s": 8.0, "starts_s": 1.0, **keys})


def pressing(thumb_from_s, fingers_from_s, newton=2.0):
    forces = np.zeros((1000, 5))
    forces[:, 0] = np.where(thumb_from_s <= TIMES_S, newton, 0.0)
    forces[:, 2] = np.where(fingers_from_s <= TIMES_S, newton, 0.0)
    return forces


def test_time_to_grasp_ends_when_both_sides_touch_and_go_on_touching():
    forces = pressing(2.0, 2.5)
    forces[(TIMES_S > 1.19) & (TIMES_S < 1.25)] = 2.0
    metrics = grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces"))
    assert metrics["time_to_grasp_s"] == pytest.approx([1.5])
    assert math.isnan(contact_s(TIMES_S, pressing(2.0, 20.0), 1.0, 0.5))
    assert contact_s(TIMES_S, pressing(0.0, 0.0), 1.0, 0.5) == pytest.approx(1.0)


def on_parts(**newton):
    """Forces (1000, 16) of parts of the hand, N."""
    forces = np.zeros((1000, len(PARTS)))
    for part, values in newton.items():
        forces[:, PARTS.index(part)] = values
    return forces


def test_a_cylinder_between_fingers_and_palm_is_gripped():
    """The thumb need not touch it, and fingertips need not: a clinician sees a grasp."""
    held = on_parts(F3p=np.where(TIMES_S >= 2.0, 2.0, 0.0), palm=np.where(TIMES_S >= 2.5, 2.0, 0.0))
    metrics = grasp_metrics(recording({"hand": CYLINDER}, hand__forces=held), score(forces="hand.forces"))
    assert metrics["time_to_grasp_s"] == pytest.approx([1.5])
    assert metrics["grip_force_n"]["F3"] == pytest.approx([2.0])
    assert metrics["grip_force_n"]["palm"] == pytest.approx([2.0])
    assert metrics["grip_force_n"]["F1"] == [0.0]
    assert metrics["grip_margin"] == pytest.approx([2.0 / needed_grip_n(CYLINDER)])
    assert math.isnan(contact_s(TIMES_S, on_parts(F2m=3.0, F3d=3.0), 1.0, 0.5))


@pytest.mark.parametrize("forces", [
    {"palm": np.where(TIMES_S >= 2.5, 0.3, 0.0)}, {"palm": np.where(TIMES_S >= 2.5, 2.0, 0.0)},
    {"palm": np.where(TIMES_S >= 2.5, 2.0, 0.0), "F3m": np.where(TIMES_S >= 5.0, 2.0, 0.0)}])
def test_a_held_object_was_grasped_when_it_was_first_pressed(forces):
    """However lightly, or from one side until after the hold (from 4 s) has begun."""
    metrics = grasp_metrics(recording({"hand": CYLINDER}, hand__forces=on_parts(**forces)),
                            score(forces="hand.forces"))
    assert metrics["held"] == [True]
    assert metrics["time_to_grasp_s"] == pytest.approx([1.5])


@given(st.lists(st.floats(0.0, 20.0), min_size=16, max_size=16))
def test_grip_of_two_opposing_sides_is_the_force_of_each(newton):
    """What one side presses with is met from the other, so half of the sum is the force of a side."""
    forces = np.array([newton])
    total = forces[0, 1:].sum()
    forces[0, 0] = total  # the palm meets what all digits press with
    assert grip_force(forces, PARTS)[0] == pytest.approx(total)


def test_margin_is_grip_over_what_friction_needs():
    needed = needed_grip_n(CYLINDER)
    assert needed == pytest.approx(0.2 * 9.80665 / 1.6)
    forces = np.tile([needed, 0.0, needed / 2, needed / 2, 0.0], (1000, 1))
    assert grip_force(forces, FINGERTIPS) == pytest.approx(np.full(1000, needed))
    pinches = np.array([[1.0, 0.5, 0.5, 0.5, 0.5], [3.0, 0.1, 0.0, 0.2, 0.0]])
    assert grip_force(pinches, FINGERTIPS).tolist() == [2.0, 3.0]
    of_object = grasp_metrics(recording({"hand": CYLINDER}, hand__forces=3.0 * forces),
                              score(forces="hand.forces"))
    assert of_object["grip_margin"] == pytest.approx([3.0])
    of_score = grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces", needed_n=needed / 7))
    assert of_score["grip_margin"] == pytest.approx([7.0])
    assert "grip_margin" not in grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces"))


def test_force_is_held_against_what_is_wanted():
    forces, wanted = pressing(0.0, 0.0, 3.0), np.where(TIMES_S < 6.0, 4.0, 2.0)
    metrics = grasp_metrics(recording(hand__forces=forces, r__target=wanted),
                            score(forces="hand.forces", target_n="r.target"))
    assert metrics["grip_force_rmse_n"] == pytest.approx([1.0])


def test_aperture_is_the_mean_way_from_thumb_to_the_opposed_fingers():
    tips = np.zeros((1000, 5, 3))
    tips[:, 1, 0], tips[:, 2, 1] = 0.08, 0.10
    tips[TIMES_S >= 2.0, 1, 0], tips[TIMES_S >= 2.0, 2, 1] = 0.04, 0.06
    given_signals = {"hand__tips": tips, "hand__forces": pressing(2.0, 3.0),
                     "r__aperture": np.full(1000, 0.06)}
    metrics = grasp_metrics(recording(**given_signals), score(
        fingertips="hand.tips", forces="hand.forces", aperture="r.aperture"))
    ways = metrics["aperture_mm"]
    assert (ways["opening"], ways["contact"], ways["hold"]) == ([90.0], [50.0], [50.0])
    # 30 mm off for 100 of the 201 rows from 1 s to 3 s, 10 mm for the others.
    assert ways["rmse"] == pytest.approx([math.sqrt((100 * 30**2 + 101 * 10**2) / 201)])
    index_only = grasp_metrics(recording(**given_signals), score(fingertips="hand.tips", opposed=("F2",)))
    assert index_only["aperture_mm"]["opening"] == pytest.approx([80.0])
    assert math.isnan(index_only["aperture_mm"]["contact"][0])
    assert "rmse" not in index_only["aperture_mm"]


def test_apertures_may_be_wanted_as_fingertips():
    tips = np.zeros((1000, 5, 3))
    tips[:, 1:3, 0] = 0.05
    wanted = tips + np.array((0.0, 0.0, 1.0))
    wanted[:, 1:3, 0] += 0.004
    metrics = grasp_metrics(recording(hand__tips=tips, r__tips=wanted),
                            score(fingertips="hand.tips", aperture="r.tips"))
    assert metrics["aperture_mm"]["rmse"] == pytest.approx([4.0])


def test_wrist_extension_and_unwanted_motion():
    angles = np.zeros((1000, 23))
    angles[:, FREEDOMS.index("wrist_flexion")] = -math.radians(20.0)
    angles[:, FREEDOMS.index("F2_pip_flexion")] = TIMES_S
    angles[TIMES_S > 1.0, FREEDOMS.index("F5_mcp_flexion")] = math.radians(12.0)
    metrics = grasp_metrics(recording(hand__angles=angles), score(angles="hand.angles", intended=(
        "F2", "F3", "F4", "wrist_flexion")))
    assert metrics["wrist_extension_deg"] == pytest.approx([20.0])
    others = sum(not name.startswith(("F2", "F3", "F4", "wrist_flexion")) for name in FREEDOMS)
    assert metrics["unwanted_motion_deg"] == pytest.approx([12.0 / math.sqrt(others)], rel=1e-3)
    assert math.isnan(unwanted_motion_deg(angles, ("F", "wrist")))


def test_what_goes_where_the_hand_goes_is_held():
    """The hand turns by 90 deg about the wrist and takes along what then slides by 5 mm in it."""
    turn = 0.5 * np.pi * np.clip((TIMES_S - 4.0) / 4.0, 0.0, 1.0)
    along = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    sites, poses = np.zeros((1000, 17, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (1000, 17, 1))
    sites[:, 1] = 0.08 * along
    poses[:, 1, 0], poses[:, 1, 3] = np.cos(0.5 * turn), np.sin(0.5 * turn)
    places = 0.1 * along
    places[TIMES_S > 7.0, 2] = 0.005
    told = recording(hand__object=places, hand__sites=sites, hand__poses=poses)
    in_hand = grasp_metrics(told, score(hand_position="hand.sites", hand_orientation="hand.poses"))
    assert in_hand["held"] == [True]
    assert in_hand["object_moved_mm"] == pytest.approx([5.0])
    in_room = grasp_metrics(told, score())
    assert in_room["object_moved_mm"] == pytest.approx([math.hypot(100.0 * math.sqrt(2.0), 5.0)], rel=1e-3)
    assert in_room["held"] == [False]


def test_what_is_carried_along_is_held():
    """Hand and object go 10 cm together, the hand turned."""
    carried = 0.1 * np.clip((TIMES_S - 4.0) / 4.0, 0.0, 1.0)[:, np.newaxis] * np.array([1.0, 2.0, 0.0])
    sites, poses = np.zeros((1000, 17, 3)), np.tile([math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)], (1000, 17, 1))
    sites[:, 1] = carried
    told = recording(hand__object=carried + np.array([0.0, 0.1, 0.0]), hand__sites=sites, hand__poses=poses)
    metrics = grasp_metrics(told, score(hand_position="hand.sites", hand_orientation="hand.poses"))
    assert metrics["object_moved_mm"] == pytest.approx([0.0], abs=1e-9)


def test_charge_counts_every_pulse():
    pulses = np.zeros((1000, 2, 2))
    pulses[:, 0] = 10e-3, 300e-6
    pulses[TIMES_S >= 5.0, 1] = 20e-3, 200e-6
    metrics = grasp_metrics(recording({"safety": {"frequency_hz": 40.0}}, safety__stimulation=pulses),
                            score(pulses="safety.stimulation"))
    assert metrics["charge_uc"] == pytest.approx([400 * 3.0 + 200 * 4.0])
    charges = pulses[..., 0] * pulses[..., 1]
    of_device = grasp_metrics(recording({"stimulator": {"frequency_hz": "40"}}, stimulator__charge=charges),
                              score(pulses="stimulator.charge"))
    assert of_device["charge_uc"] == pytest.approx(metrics["charge_uc"])
    assert math.isnan(charge_c(TIMES_S[:1], charges[:1], 40.0))


@given(st.integers(1, 50))
def test_charge_is_that_of_pulses_that_were_given(every):
    """A stimulator leaves out pulses that are too short for it."""
    pulses = np.tile([10e-3, 300e-6], (1000, 1, 1))
    gives = np.arange(1000) % every == 0
    charges = np.where(gives, 3e-6, 0.0)[:, np.newaxis]
    told = recording({"safety": {"frequency_hz": 40.0}, "stimulator": {"frequency_hz": "40"}},
                     safety__stimulation=pulses, stimulator__charge=charges)
    told.signals = ("safety.stimulation", "stimulator.charge")
    told.experiment["wires"] = [{"from": "safety.stimulation", "to": "stimulator.stimulation"}]
    assert grasp_metrics(told, score(pulses="safety.stimulation"))["charge_uc"] == pytest.approx(
        [1.2 * gives.sum()])


@given(margin=st.floats(0.1, 50.0), ratio=st.floats(0.2, 0.999))
def test_grasps_until_fatigue_are_those_counted_one_by_one(margin, ratio):
    counted, left = 0, margin
    while left >= 1.0:
        counted, left = counted + 1, left * ratio
    assert abs(grasps_until_fatigue(margin, ratio) - counted) <= (1 if math.isclose(left / ratio, 1.0)
                                                                 or math.isclose(left, 1.0) else 0)


def test_fitness_counts_by_what_is_active_and_closes():
    activation, before, after = np.zeros(29), np.ones(29), np.full(29, 0.1)
    activation[[muscle("FDS3"), muscle("FPL"), muscle("EDC3")]] = 0.2, 0.6, 1.0
    after[[muscle("FDS3"), muscle("FPL")]] = 0.5, 0.9
    assert fitness_ratio(activation, before, after) == pytest.approx((0.2 * 0.5 + 0.6 * 0.9) / 0.8)
    assert math.isnan(fitness_ratio(np.zeros(29), before, after))
    assert math.isinf(grasps_until_fatigue(2.0, 1.0))
    assert grasps_until_fatigue(0.99, 0.9) == 0.0
    fitness = np.linspace(np.ones(29), np.where(np.arange(29) == muscle("FDS3"), 0.5, 1.0), 1000)
    needed = needed_grip_n(CYLINDER)
    held = grasp_metrics(
        recording({"hand": CYLINDER}, hand__forces=pressing(0.0, 0.0, 4.5 * needed), m__fitness=fitness,
                  m__activation=np.tile(np.eye(29)[muscle("FDS3")], (1000, 1))),
        score(forces="hand.forces", fitness="m.fitness", activation="m.activation"))
    assert held["grasps_until_fatigue"] == [3.0]


@pytest.mark.parametrize(("slips_m", "newton", "count"), [
    (0.0, 4.5, 3.0), (0.1, 4.5, 0.0), (0.0, 0.5, math.nan), (0.1, 0.5, 0.0)])
def test_a_grasp_that_failed_counts_none_and_one_that_fingertips_do_not_explain_is_not_told(
        slips_m, newton, count):
    needed = needed_grip_n(CYLINDER)
    metrics = grasp_metrics(
        recording({"hand": CYLINDER}, hand__forces=pressing(0.0, 0.0, newton * needed),
                  hand__object=np.linspace(np.zeros(3), np.full(3, slips_m), 1000),
                  m__fitness=np.linspace(np.ones(29), np.full(29, 0.5), 1000),
                  m__activation=np.tile(np.eye(29)[muscle("FDS3")], (1000, 1))),
        score(forces="hand.forces", fitness="m.fitness", activation="m.activation"))
    assert metrics["grasps_until_fatigue"] == pytest.approx([count], nan_ok=True)


def test_trials_that_broke_off_are_told_as_such():
    short = {"hand__object": np.zeros((600, 3)), "hand__forces": pressing(2.0, 2.0)[:600],
             "hand__angles": np.zeros((600, 23)), "hand__tips": np.ones((600, 5, 3)),
             "r__target": np.ones(600)}
    metrics = grasp_metrics(recording({"hand": CYLINDER}, trials=2, **short), score(
        forces="hand.forces", angles="hand.angles", intended=("F2",), fingertips="hand.tips",
        target_n="r.target"))
    assert metrics["held"] == [None, None]
    for name in ("grip_margin", "wrist_extension_deg", "unwanted_motion_deg", "grip_force_rmse_n", "held_s"):
        assert np.isnan(metrics[name]).tolist() == [True, True]
    assert metrics["time_to_grasp_s"] == pytest.approx([1.0, 1.0])


@given(st.integers(2, 999))
def test_of_a_trial_that_ended_before_the_hold_nothing_is_claimed_that_it_could_not_show(rows):
    """Before the hold is over one side that presses may still make a grip: there is no never."""
    tips = np.ones((rows, 5, 3))
    tips[:, 0] = 0.0
    metrics = grasp_metrics(
        recording(hand__object=np.zeros((rows, 3)), hand__forces=pressing(2.0, 20.0)[:rows], hand__tips=tips,
                  r__target=np.full(rows, 0.05)),
        score(forces="hand.forces", fingertips="hand.tips", aperture="r.target"))
    why = {name: reasons[0] for name, reasons in metrics.get("missing", {}).items()}
    over, begun = rows >= 800, rows > 100
    assert np.isfinite(metrics["aperture_mm"]["opening"][0]) == begun
    assert ("aperture_mm.opening" in why) == (not begun)
    assert np.isfinite(metrics["aperture_mm"]["rmse"][0]) == over
    for name in ("time_to_grasp_s", "aperture_mm.contact", "aperture_mm.rmse"):
        assert over or why[name].startswith("the trial ended before 8 s")


@pytest.mark.parametrize(("keys", "where"), [
    ({"starts_s": 5.0}, "starts_s"), ({"intended": ("F2",)}, "intended"), ({"needed_n": 0.0}, "needed_n"),
    ({"intended": ("F7",), "angles": "a"}, "intended"), ({"opposed": ("F1",)}, "opposed"),
    ({"contact_n": math.nan}, "contact_n"), ({"target_n": "w"}, "target_n"),
    ({"touching": ("F6",), "forces": "f"}, "touching"), ({"touching": ("F1",)}, "touching"),
    ({"aperture": "w"}, "aperture"),
    ({"fitness": "f"}, "fitness"), ({"fitness": "f", "activation": "a"}, "activation")])
def test_scores_that_cannot_be_are_named(keys, where):
    with pytest.raises(InputError) as fault:
        score(**keys)
    assert fault.value.where == where


def test_signals_that_do_not_fit_are_named_before_the_run():
    document = {
        "experiment": {"name": "grasp", "duration_s": 0.1},
        "blocks": {"hand": {"kind": "moving_hand", "phases": [{"duration_s": 0.1}]},
                   "p": {"kind": "programme", "rate": 40, "times_s": [0.0], "current_ma": [[1.0]],
                         "width_us": [[1.0]]}},
        "score": {"grasp": {"object": "hand.site_position", "from_s": 0, "until_s": 1,
                            "pulses": "p.stimulation", "angles": "hand.angle", "fingertips": "hand.angles"}}}
    with pytest.raises(InputErrors) as fault:
        from_document(document)
    for words in ("score.grasp.object", "score.grasp.angles", "score.grasp.fingertips", "score.grasp.pulses"):
        assert words in str(fault.value)


def test_fingertips_are_placed_where_others_say_but_for_their_distance():
    tips = np.zeros((1000, 5, 3))
    wanted = tips.copy()
    wanted[:, 0], wanted[:, 1] = (0.003, 0.0, 0.0), (0.0, 0.0, 0.004)
    wanted[:, 4] = 1.0  # is not opposed
    metrics = grasp_metrics(recording(hand__tips=tips, r__tips=wanted),
                            score(fingertips="hand.tips", aperture="r.tips", opposed=("F2",)))
    assert metrics["fingertip_placement_mm"] == pytest.approx([math.sqrt((9.0 + 16.0) / 2.0)])


def test_contact_is_unwanted_before_closing_and_then_of_other_parts():
    """From .2 to .5 s by anything, and from 2 to 3.5 s by another finger; after the hold nothing counts."""
    forces = on_parts(
        F2d=np.where((TIMES_S >= 0.2) & (TIMES_S < 0.5) | (TIMES_S >= 1.0), 2.0, 0.0),
        F4m=np.where((TIMES_S >= 2.0) & (TIMES_S < 3.5) | (TIMES_S > 8.0), 2.0, 0.0), palm=0.4)
    found = grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces", touching=("F1", "F2")))
    assert found["unwanted_contact_s"] == pytest.approx([0.3 + 1.5])
    wanted = grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces", touching=("F2", "F4")))
    assert wanted["unwanted_contact_s"] == pytest.approx([0.3])
    usual = grasp_metrics(recording(hand__forces=forces), score(forces="hand.forces"))
    assert "unwanted_contact_s" not in usual

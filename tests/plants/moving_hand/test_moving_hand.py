from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import contact_points, hand_tree
from fesloop.loop.block import Context
from plants.moving_hand import MovingHand
from plants.moving_hand.script import ArmSway, Contact, Phase
from plants.patients.files import load
from plants.patients.sections import CohortSpread

GRIP = {"F1_cmc_flexion": 30.0, "F1_cmc_abduction": -30.0, "F1_cmc_pronation": 70.0, "F1_mcp_flexion": 20.0,
        "F1_ip_flexion": 20.0, "F2_mcp_flexion": 50.0, "F2_pip_flexion": 40.0, "F2_dip_flexion": 20.0}
SWAY = ArmSway(turn_deg=(40.0, 30.0, 50.0), shift_m=(0.2, 0.1, 0.15), period_s=3.0)
NAMES = ("angles", "rates", "accelerations", "fingertips", "orientation", "position", "rate", "force")


def own_hand(side="left", number=1, **spreads):
    """Hand of a person with own bones, joints and axes."""
    spread = CohortSpread(**(spreads or {"length": 0.03, "joint_mm": 3.0, "axis_deg": 7.6}))
    person = replace(load("able_bodied"), cohort=spread).member(cohort=1, number=number)
    return replace(person.hand_size, side=side)


def rows_of(plant, times_s, seed=1, trial=0):
    state = plant.init(Context("hand", seed, trial))
    times = [round(1e9 * t) for t in times_s]
    return dict(zip(NAMES, plant.observe(state, (), 0, times), strict=True))


def bone_ends(plant, angles):
    """Distal poses of the person in the wrist's frame, by dual quaternions."""
    tree = hand_tree(plant.hand)
    poses = segment_poses(tree, angles)
    tips = [tree.index(f"F{i}d") for i in range(1, 6)]
    return poses.orientation[..., tips, :], poses.position[..., tips, :]


@pytest.mark.parametrize("duration_s", [0.5, 1.0, 1.013])
def test_knots_reach_to_the_end_of_the_last_phase(duration_s):
    path = MovingHand(phases=(Phase(name="bent", duration_s=duration_s, posture_deg=GRIP),)).path(0, "hand")
    (span,) = path.spans
    last_s = path.knot_s * (len(path.knots) - 1)
    assert span.stop - 1e-9 <= last_s < span.stop + 1.01 * path.knot_s


@settings(deadline=None, max_examples=12)
@given(st.sampled_from(["left", "right"]), st.integers(0, 1000))
def test_sites_feel_what_their_own_path_says(side, seed):
    phases = (Phase(duration_s=0.6, posture_deg={"F1_cmc_pronation": 50.0, "wrist_flexion": -30.0}, arm=SWAY),
              Phase(duration_s=0.8, cycles=2, vary=0.2, posture_deg=GRIP, arm=SWAY))
    plant = MovingHand(hand=own_hand(side, seed), phases=phases)
    step = 1e-4
    times = np.array([0.31, 0.77, 1.23, 1.9])
    before, now, after = (rows_of(plant, times + shift, seed) for shift in (-step, 0.0, step))
    acceleration = (after["position"] - 2.0 * now["position"] + before["position"]) / step**2
    force = quaternion.rotate(now["orientation"], now["force"]) - [0.0, 0.0, 9.80665]
    assert np.abs(acceleration - force).max() < 2e-4 * max(1.0, np.abs(force).max())
    turn = quaternion.multiply(quaternion.conjugate(before["orientation"]), after["orientation"])
    assert np.abs(turn[..., 1:] / step - now["rate"]).max() < 1e-4 * max(1.0, np.abs(now["rate"]).max())
    rates = (after["angles"] - before["angles"]) / (2.0 * step)
    assert np.abs(rates - now["rates"]).max() < 1e-4 * max(1.0, np.abs(rates).max())


def test_fingertips_are_those_of_the_person_in_the_wrists_frame_however_the_arm_moves():
    plant = MovingHand(hand=own_hand(), phases=(Phase(duration_s=2.0, posture_deg=GRIP, arm=SWAY),))
    rows = rows_of(plant, np.linspace(0.0, 2.0, 21))
    assert np.abs(bone_ends(plant, rows["angles"])[1] - rows["fingertips"]).max() < 1e-12


def test_by_eye_palm_down_fingers_point_north_and_the_thumb_lies_inwards():
    for side, inwards in (("left", 1.0), ("right", -1.0)):
        plant = MovingHand(hand=HandSize(side=side), phases=(Phase(duration_s=1.0),))
        rows = rows_of(plant, [0.5])
        sites = dict(zip(hand_tree(HandSize()).names, rows["position"][0], strict=True))
        assert sites["F3d"][1] > sites["F3p"][1] > sites["hand"][1] > sites["forearm"][1]
        assert inwards * (sites["F1p"][0] - sites["F5p"][0]) > 0.02
        force = quaternion.rotate(rows["orientation"][0], rows["force"][0])
        assert np.allclose(force, [0.0, 0.0, 9.80665])


@pytest.mark.parametrize("contact", [
    Contact(first="F1 bottom", second="F2 bottom", distance_mm=30.0, facing=True),
    Contact(first="F1 distal", second="F2 distal"),
    Contact(first="F1 tip", second="F2 tip", distance_mm=53.0)])
def test_contacts_hold_while_fingers_play_and_the_arm_moves(contact):
    size = own_hand()
    plant = MovingHand(
        hand=size,
        rest_deg={"F1_cmc_abduction": -45.0},
        phases=(Phase(duration_s=1.0), Phase(name="held", duration_s=4.0, contacts=(contact,), arm=SWAY,
                                             posture_deg=GRIP, play_deg=3.0)))
    (span,) = plant.path(3, "hand").spans
    assert (span.name, span.start, span.stop) == ("held", 2.0, 6.0)
    rows = rows_of(plant, np.linspace(span.start, span.stop, 101), seed=3)
    orientation, position = bone_ends(plant, rows["angles"])
    points = contact_points(size)
    names = ("tip", "bottom", "top", "left", "right", "distal")
    ends = [position[:, int(text[1]) - 1] + quaternion.rotate(
        orientation[:, int(text[1]) - 1], points[int(text[1]) - 1, names.index(text.split()[1])])
        for text in (contact.first, contact.second)]
    gap = np.linalg.norm(ends[1] - ends[0], axis=1)
    assert np.abs(gap - 1e-3 * contact.distance_mm).max() < 3e-4
    assert np.ptp(rows["angles"][:, 7:11]) > 0.02


def test_cycles_go_there_and_back_and_last_as_long_as_declared():
    phase = Phase(name="flex", duration_s=2.0, cycles=3, stay_s=0.3, posture_deg={"F2_pip_flexion": 80.0})
    plant = MovingHand(phases=(Phase(duration_s=1.0), phase))
    (span,) = plant.path(0, "hand").spans
    assert (span.start, span.stop) == (1.0, 7.0)
    flexion = np.degrees(rows_of(plant, 1.0 + np.linspace(0.0, 6.0, 601), seed=0)["angles"][:, 9])
    tops = [i for i, (a, b) in enumerate(pairwise(flexion > 79.99)) if b > a]
    assert len(tops) == 3
    assert flexion.max() == pytest.approx(80.0, abs=1e-3)
    assert abs(flexion[[0, 200, 400, 600]]).max() < 1e-3


def test_circles_keep_their_radius():
    posture = {"F2_mcp_flexion": 20.0, "F2_mcp_abduction": 15.0}
    plant = MovingHand(phases=(Phase(duration_s=1.0, cycles=5, circle=True, posture_deg=posture),))
    angles = np.degrees(rows_of(plant, np.linspace(0.6, 4.4, 200))["angles"])
    assert np.allclose(np.hypot(angles[:, 7] / 20.0, angles[:, 8] / 15.0), 1.0, atol=1e-3)


def test_a_hand_is_the_same_in_every_trial_and_its_path_is_not():
    plant = MovingHand(hand=own_hand(), phases=(Phase(duration_s=1.0, cycles=4, vary=0.2, posture_deg=GRIP),))
    state = plant.init(Context("hand", 1, 0))
    again = plant.next_trial(state, Context("hand", 1, 1))
    assert again.wearer is state.wearer
    assert np.array_equal(state.wearer.tree.geometry[2:], hand_tree(plant.hand).geometry[1:])
    assert not np.array_equal(again.path.knots, state.path.knots)
    assert np.array_equal(plant.init(Context("hand", 1, 0)).path.knots, state.path.knots)
    other = plant.init(Context("hand", 2, 0))
    assert not np.array_equal(other.path.knots, state.path.knots)
    assert np.array_equal(other.wearer.tree.geometry, state.wearer.tree.geometry)


def test_the_error_of_the_pose_is_added_to_the_posture_at_the_start():
    plant = MovingHand(script="P1", pose_error_deg={"F1_cmc_abduction": 5.0, "F2_pip_flexion": -3.0})
    names = hand_tree(plant.hand).freedoms
    for trial in range(2):
        at_rest = dict(zip(names, np.degrees(rows_of(plant, [1.0], trial=trial)["angles"][0]), strict=True))
        assert at_rest.pop("F1_cmc_abduction") == pytest.approx(-40.0)
        assert at_rest.pop("F2_pip_flexion") == pytest.approx(-3.0)
        assert max(map(abs, at_rest.values())) < 1e-9


def test_postures_scatter_between_repetitions_and_are_held_in_between():
    phase = Phase(name="flex", duration_s=2.0, cycles=200, stay_s=0.5, posture_deg={"F2_pip_flexion": 40.0})
    rows = rows_of(MovingHand(phases=(phase,), repeat_sd_deg=1.5), np.arange(200) * 2.0 + 1.9)
    later = rows_of(MovingHand(phases=(phase,), repeat_sd_deg=1.5), np.arange(200) * 2.0 + 1.6)
    away = rows_of(MovingHand(phases=(phase,), repeat_sd_deg=1.5), np.arange(200) * 2.0 + 0.9)
    angles = np.degrees(rows["angles"])
    np.testing.assert_allclose(np.degrees(later["angles"]), angles, atol=0.01)
    assert angles.std(axis=0) == pytest.approx(1.5, rel=0.25)
    assert np.degrees(away["angles"]).std(axis=0) == pytest.approx(1.5, rel=0.25)
    assert np.degrees(away["angles"])[:, 9].mean() == pytest.approx(40.0, abs=0.5)
    assert abs(np.corrcoef(angles[1:, 9], angles[:-1, 9])[0, 1]) < 0.25


@pytest.mark.parametrize(("change", "text"), [
    ({"phases": ()}, "name of a script"),
    ({"phases": (Phase(duration_s=1.0, posture_deg={"F2_pip": 1.0}),)}, "F2_pip"),
    ({"rest_deg": {"thumb": 1.0}}, "thumb"), ({"forearm_orientation": (1.0, 1.0, 0.0, 0.0)}, "length 1"),
    ({"knot_ms": 0.0}, "knot_ms")])
def test_what_no_hand_can_do_is_named(change, text):
    with pytest.raises(InputError, match=text):
        MovingHand(**({"phases": (Phase(duration_s=1.0),)} | change))


@pytest.mark.parametrize("fault", [
    {"duration_s": 0.0}, {"duration_s": 1.0, "cycles": -1}, {"duration_s": 1.0, "cycles": 1, "stay_s": 0.5},
    {"duration_s": 1.0, "circle": True}, {"duration_s": 1.0, "posture_deg": {"F2_pip_flexion": 200.0}},
    {"duration_s": 1.0, "vary": 0.5}])
def test_phases_that_make_no_sense_are_refused(fault):
    with pytest.raises(InputError):
        Phase(**fault)


def test_a_contact_out_of_reach_is_refused():
    far = Contact(first="F2 tip", second="F3 tip", distance_mm=300.0)
    plant = MovingHand(phases=(Phase(duration_s=1.0, contacts=(far,)),))
    with pytest.raises(InputError, match="reach"):
        plant.init(Context("hand", 1))
    with pytest.raises(InputError, match="F6"):
        Contact(first="F6 tip", second="F2 tip")


def test_a_missed_rest_is_missed_anew_in_each_trial_by_what_is_stated():
    plant = MovingHand(phases=(Phase(duration_s=1.0),), rest_sd_deg=4.0, rest_deg={"F2_pip_flexion": 30.0})
    starts = np.degrees([plant.path(1, "hand", trial).knots[0, 0, 3:-3] for trial in range(60)])
    assert np.std(starts) == pytest.approx(np.hypot(4.0, np.std(np.eye(23)[9] * 30.0)), rel=0.1)
    assert starts[:, 9].mean() == pytest.approx(30.0, abs=2.0)

"""A therapist's hands: a pose is reached, held and released; a hand that resists does not get there."""

import copy

import mujoco
import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.hand.movements import FREEDOMS, MUSCLES
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.assist import MOST_N_M, Assistance, most_n_m
from plants.patients.files import load

STRAIGHT = {f"{finger}_{joint}_flexion": 0.0 for finger in ("F2", "F3", "F4", "F5")
            for joint in ("mcp", "pip", "dip")}
RELAXED = [np.zeros(len(MUSCLES))]
BRACED = {"wrist_flexion": 0.0, "wrist_abduction": 0.0}
ROWS = [FREEDOMS.index(name) for name in STRAIGHT]


def held(seconds=0.0, **parameters):
    """Angles of the fingers, deg, that long after the start."""
    plant = Hand(settle_s=2.0, splint_deg=BRACED, **parameters)
    state = plant.init(Context("hand"))
    if seconds:
        plant.advance(state, RELAXED, 0, round(seconds * 1e9))
    return np.degrees(plant.read(state, RELAXED)[0])[ROWS]


def assisted(**changes):
    return Assistance(**{"pose_deg": STRAIGHT, "until_s": 1.0, "release_s": 0.3, **changes})


def test_a_relaxed_hand_is_brought_into_the_pose_and_held():
    for seconds in (0.0, 0.9):
        assert np.abs(held(seconds, assist=assisted())).max() < 3.0
    assert held().min() > 10.0  # it rests bent


def test_after_the_release_it_rests_as_if_nobody_had_held_it():
    np.testing.assert_allclose(held(6.0, assist=assisted()), held(6.0), atol=0.5)


def test_the_pose_is_held_with_its_error():
    errors = {"F2_mcp_flexion": 8.0, "F4_pip_flexion": -5.0}
    moved = held(assist=assisted(error_deg=errors)) - held(assist=assisted())
    by_name = dict(zip(STRAIGHT, moved, strict=True))
    for name, error in errors.items():
        assert by_name[name] == pytest.approx(error, abs=1.5)
    assert max(abs(by_name[name]) for name in STRAIGHT if name[:2] in ("F3", "F5")) < 1.0


def test_a_severely_spastic_hand_resists_and_moments_are_bounded():
    patient = load("stroke_severe_spastic").hand()
    del patient["rest_deg"]["wrist_flexion"]
    parameters = {key: value for key, value in patient.items() if key != "hand"}
    angles = held(assist=assisted(), **parameters)
    assert 3.0 < angles.max() < 10.0  # it does not get there
    assert held(**parameters).max() > 50.0
    plant = Hand(settle_s=2.0, splint_deg=BRACED, assist=assisted(), **parameters)
    data = plant.init(Context("hand")).data
    mujoco.mj_forward(plant.model, data)
    drives = {name.removeprefix("hold "): data.actuator_force[number]
              for number, name in enumerate(plant.model.actuator(i).name for i in range(plant.model.nu))
              if name.startswith("hold ")}
    assert drives.keys() >= STRAIGHT.keys()
    for name, moment in drives.items():
        assert abs(moment) <= most_n_m(name) + 1e-12


def test_a_snapshot_in_the_release_goes_on_to_the_bit():
    plant = Hand(settle_s=1.0, splint_deg=BRACED, assist=assisted())
    whole, parted = plant.init(Context("hand")), plant.init(Context("hand"))
    plant.advance(whole, RELAXED, 0, 2_000_000_000)
    plant.advance(parted, RELAXED, 0, 1_150_000_000)
    plant.read(parted, RELAXED)
    parted = copy.deepcopy(parted)
    plant.advance(parted, RELAXED, 1_150_000_000, 2_000_000_000)
    for one, other in zip(plant.read(whole, RELAXED), plant.read(parted, RELAXED), strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(whole.data.ctrl) >= len(STRAIGHT)
    assert not whole.data.ctrl.any()


@pytest.mark.parametrize(("changes", "words"), [
    ({"until_s": -1.0}, "until_s"),
    ({"release_s": 0.0}, "release_s")])
def test_what_cannot_be_held_is_named(changes, words):
    with pytest.raises(InputError, match=words):
        assisted(**changes)


@pytest.mark.parametrize(("pose", "words"), [
    ({"F2_mcp": 0.0}, "assist.pose_deg.F2_mcp: is not a freedom"),
    ({"F2_pip_flexion": 150.0}, "assist.pose_deg.F2_pip_flexion: 150")])
def test_a_pose_that_no_hand_has_is_named(pose, words):
    with pytest.raises(InputError, match=words):
        Hand(assist=assisted(pose_deg=pose), settle_s=2.0)


def test_too_little_time_is_named():
    with pytest.raises(InputError, match=r"settle_s: 0\.2 s; allowed: 1 s or more with `assist`"):
        Hand(assist=assisted(), settle_s=0.2)


def test_every_freedom_has_a_greatest_moment():
    assert {most_n_m(name) for name in FREEDOMS} <= set(MOST_N_M.values())

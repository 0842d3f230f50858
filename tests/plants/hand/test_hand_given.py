"""An object that is given to the hand, a hand that settles first, and springs at its joints; about 10 s."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.scene import _OFFSETS, OVERLAP_M, GraspObject, Table, deepest, give

THUMB_UP = (0.0, 0.0, 0.0, 1.0)
NONE = np.zeros(len(MUSCLES))
SPLINT = {"wrist_abduction": 0.0, "F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0,
          "F1_cmc_pronation": 100.0}
OPEN = {f"F{i}_{joint}_flexion": angle for i in range(2, 6) for joint, angle in (("mcp", 0.0), ("pip", 5.0))}
WRIST = hand_tree(Hand().hand).freedom("wrist_flexion")


def hand(**changes):
    thing = GraspObject(size_mm=(50.0, 120.0), position_m=(-0.006, 0.112, 0.0), given_at_s=0.5)
    table = Table(height_m=-0.0601, centre_m=(0.0, 0.15))
    return Hand(**{"forearm_orientation": THUMB_UP, "splint_deg": {**SPLINT, **OPEN, "wrist_flexion": -25.0},
                   "object": thing, "table": table, **changes})


OPENED = hand()


def place_after(plant, seconds, state=None, start_s=0.0):
    state = state or plant.init(Context("hand"))
    plant.advance(state, [NONE], round(start_s * 1e9), round(seconds * 1e9))
    return state, plant.read(state, [])[10]


@pytest.mark.parametrize("changes", [{}, {"settle_s": 0.5}, {"table": None, "settle_s": 0.5},
                                     {"table": Table(height_m=-0.0601, half_m=(0.06, 0.06))}])
def test_it_waits_in_its_place_and_is_given_when_it_is_time(changes):
    """On a table or not, from when the hand begins to settle."""
    plant = hand(**changes)
    state, waiting = place_after(plant, 0.0)
    assert waiting.tolist() == [-0.006, 0.362, 0.0]
    state, waiting = place_after(plant, 0.499, state)
    assert waiting.tolist() == [-0.006, 0.362, 0.0]
    _, given = place_after(plant, 0.52, state, 0.499)
    assert np.linalg.norm(given[:2] - (-0.006, 0.112)) <= 0.021
    assert abs(given[2]) < 2.2e-3  # falls for at most 20 ms


def test_it_stays_away_while_the_hand_is_closed_and_comes_when_it_opens():
    closed = dict.fromkeys(OPEN, 60.0)
    plant = hand(splint_deg={**SPLINT, **closed, "wrist_flexion": -25.0})
    state, place = place_after(plant, 1.0)
    np.testing.assert_allclose(place, (-0.006, 0.362, 0.0), atol=1e-3)
    assert not state.given


def first_free_place(model, thing, data):
    """Number of the first offset at which MuJoCo finds no contact that is too deep; None if none is free."""
    table_m = data.mocap_pos.copy()
    for number, offset in enumerate(_OFFSETS):
        data.mocap_pos[:] = table_m + offset
        data.qpos[-7:] = (*(np.array(thing.position_m) + offset), *thing.orientation)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        if deepest(model, data, ("object", "table")).distance_m >= -OVERLAP_M:
            return number
    return None


@pytest.fixture(scope="module")
def places():
    """Numbers of the offsets at which objects were given; None for none."""
    found = []
    yield found
    assert {*found} > {0, None}  # at the first, at another, and at none


@settings(deadline=None, max_examples=120)
@given(st.floats(0.0, 60.0), st.floats(0.0, 15.0), st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))
def test_it_is_given_at_the_first_place_that_is_free(places, closed_deg, spread_deg, right_m, up_m):
    """As a search finds it that has MuJoCo look for every contact of every place."""
    thing = GraspObject(size_mm=(50.0, 120.0), position_m=(-0.006 + right_m, 0.112, up_m), given_at_s=0.5)
    model, data = OPENED.model, mujoco.MjData(OPENED.model)
    tree = hand_tree(OPENED.hand)
    for name in OPEN:
        data.qpos[tree.freedom(name)] = math.radians(closed_deg + spread_deg * (name[1] in "24"))
    data.qpos[WRIST] = math.radians(-25.0)
    apart = mujoco.MjData(model)
    apart.qpos[:] = data.qpos
    before, number = (data.qpos.copy(), data.mocap_pos.copy()), first_free_place(model, thing, apart)
    assert give(model, thing, data) == (number is not None)
    expected = before if number is None else (apart.qpos, apart.mocap_pos)
    np.testing.assert_array_equal(data.qpos, expected[0])
    np.testing.assert_array_equal(data.mocap_pos, expected[1])
    places.append(number)


@pytest.mark.parametrize(("asked_m", "beside"), [((-0.006, 0.112), False), ((0.014, 0.096), True),
                                                 ((-0.026, 0.098), True)])
def test_an_object_that_finds_room_beside_its_place_does_not_fall_off_a_small_table(asked_m, beside):
    thing = GraspObject(size_mm=(50.0, 120.0), position_m=(*asked_m, 0.0), given_at_s=0.5)
    plant = hand(object=thing, table=Table(height_m=-0.0601, centre_m=asked_m, half_m=(0.01, 0.01)))
    state, given = place_after(plant, 0.502)
    assert state.given
    assert (np.abs(given[:2] - asked_m).max() > 0.0101) == beside
    _, later = place_after(plant, 1.0, state, 0.502)
    np.testing.assert_allclose(later, given, atol=2e-3)


def test_a_hand_that_settles_first_begins_at_rest():
    def fastest(plant):
        state = plant.init(Context("hand"))
        rates = []
        for k in range(20):
            plant.advance(state, [NONE], 10_000_000 * k, 10_000_000 * (k + 1))
            rates.append(np.abs(plant.read(state, [])[1]).max())
        return max(rates)

    loose = {"object": None, "table": None, "splint_deg": SPLINT}
    assert fastest(hand(**loose)) > 0.3
    assert fastest(hand(**loose, settle_s=2.0)) < 0.02


@pytest.mark.parametrize("stiffness", [0.5, 2.0])
def test_a_spring_at_the_wrist_gives_way_as_a_spring(stiffness):
    """An extensor's moment turns a free wrist by about moment over stiffness."""
    plants = [hand(object=None, table=None, splint_deg=SPLINT, elastic_deg={"wrist_flexion": -20.0},
                   elastic_n_m_rad=each, settle_s=2.0) for each in (stiffness, 2.0 * stiffness)]
    drive = np.array([0.03 * (name == "ECRB") for name in MUSCLES])
    turned = []
    for plant in plants:
        state = plant.init(Context("hand"))
        before = plant.read(state, [])[0][WRIST]
        plant.advance(state, [drive], 0, 2_000_000_000)
        turned.append(before - plant.read(state, [])[0][WRIST])
    assert 0.0 < turned[1] < turned[0]
    # Tendons and the joint itself are stiff as well, so that doubling the spring does less than halve it.
    assert 1.2 < turned[0] / turned[1] < 2.05


@pytest.mark.parametrize("angle_deg", [-30.0, 25.0])
def test_a_stiff_spring_holds_the_wrist_where_it_is_told(angle_deg):
    plant = hand(object=None, table=None, splint_deg=SPLINT, elastic_deg={"wrist_flexion": angle_deg},
                 elastic_n_m_rad=10.0, settle_s=2.0)
    found = plant.read(plant.init(Context("hand")), [])[0][WRIST]
    assert math.degrees(found) == pytest.approx(angle_deg, abs=2.0)


@pytest.mark.parametrize(("changes", "where"), [
    ({"settle_s": -1.0}, "settle_s"), ({"elastic_n_m_rad": -0.5}, "elastic_n_m_rad"),
    ({"elastic_deg": {"wrist": 0.0}}, "elastic_deg")])
def test_names_what_cannot_be(changes, where):
    with pytest.raises(InputError, match=where):
        hand(**changes)


@pytest.mark.parametrize("changes", [{"given_at_s": -1.0}, {"waits_m": (math.nan, 0.0, 0.0)}])
def test_names_an_object_that_cannot_be_given(changes):
    with pytest.raises(InputError, match=next(iter(changes))):
        GraspObject(**changes)

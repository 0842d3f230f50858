"""MyoHand behind the hand's contract; about 15 s."""

import copy
import pickle
import sys

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError, RunError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERTIPS, PARTS, HandSize
from fesloop.hand.kinematics import joint_angles, placed, relative_of_segments
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS
from plants.hand import Hand
from plants.hand.assist import Assistance
from plants.hand.contract import parts_of_geoms
from plants.hand.scene import GraspObject, Table
from plants.myohand import MyoHand
from plants.myohand import model as myohand_model
from plants.myohand.anatomy import JOINTS, REPRESENTS

pytest.importorskip("myo_sim", reason="the extra `myohand` is not installed")

NAMES = ("angles", "rates", "accelerations", "fingertips", "orientation", "position", "rate", "force",
         "contact", "velocity", "object_position", "object_orientation")
BALL = {"object": GraspObject(shape="ball", size_mm=(50.0,), position_m=(0.01, 0.08, -0.06)),
        "table": Table(height_m=-0.09)}
MOVES = {"FDP2": 0.3, "EDC3": 0.2, "OP": 0.05, "THENAR": 0.3, "ECRL": 0.3, "INT5": 0.1, "EPL": 0.1}
GRAVITY = np.array([0.0, 0.0, 9.80665])


def active(**levels):
    rows = np.zeros(len(MUSCLES))
    for name, level in levels.items():
        rows[muscle(name)] = level
    return rows


def outputs(plant, state):
    return dict(zip(NAMES, plant.read(state, []), strict=False))


def run(plant, activation, seconds, state=None, every=None):
    """State and outputs after some seconds; every so many steps read in between, if given."""
    state = plant.init(Context("hand")) if state is None else state
    inputs = [activation, np.array([0.0, 0.6, 0.0, 0.8])]
    for k in range(round(1e3 * seconds / plant.step_ms)):
        now = state.time_ns
        plant.advance(state, inputs, now, now + plant.grid.period_num)
        if every and k % every == 0:
            plant.read(state, [])
    return state, outputs(plant, state)


@pytest.fixture(scope="module", params=[False, True], ids=["held", "turned"])
def moving(request):
    """A hand in full motion, its forearm held or turned: plant, state, what it puts out."""
    plant = MyoHand(forearm_moves=request.param)
    levels = active(**{name: level for name, level in MOVES.items() if name != "OP"})
    state, seen = run(plant, levels, 0.04)
    assert np.abs(seen["rates"]).max() > 5.0
    return plant, state, seen


def near(plant, state, seconds):
    """Site positions, orientations and angles a little later, by position, rate and acceleration of now."""
    data = copy.deepcopy(state.data)
    data.qpos[:] += seconds * data.qvel + 0.5 * seconds**2 * data.qacc
    mujoco.mj_kinematics(plant.model, data)
    seen = [data.xquat[plant.model.body(name).id] for name in hand_tree(plant.size).names]
    places = [data.site(f"imu {name}").xpos.copy() for name in hand_tree(plant.size).names]
    return np.array(places), np.array(seen), angles_of(plant, np.array(seen))


def angles_of(plant, orientation):
    tree = hand_tree(plant.size)
    return joint_angles(tree, relative_of_segments(tree, orientation))


def test_ports_are_those_of_hand():
    things = {**BALL, "forearm_moves": True}
    for ours, theirs in zip(Hand(**things).outputs, MyoHand(**things).outputs, strict=True):
        assert (ours.name, ours.shape, ours.unit) == (theirs.name, theirs.shape, theirs.unit)
    assert [port.name for port in MyoHand(**things).inputs] == ["activation", "forearm"]


def test_angles_are_those_between_the_segments(moving):
    plant, _, seen = moving
    assert np.allclose(seen["angles"], angles_of(plant, seen["orientation"]), rtol=0, atol=1e-9)


def test_rates_and_accelerations_are_the_derivatives_of_the_angles(moving):
    plant, state, seen = moving
    step = 1e-4
    before, now, after = (near(plant, state, t)[2] for t in (-step, 0.0, step))
    assert np.allclose(seen["rates"], (after - before) / (2 * step), rtol=1e-4, atol=1e-4)
    assert np.allclose(seen["accelerations"], (after - 2 * now + before) / step**2, rtol=1e-4, atol=0.1)


def test_sensor_sites_feel_how_they_move(moving):
    plant, state, seen = moving
    step = 1e-4
    (before, turned_before, _), (now, _, _), (after, turned_after, _) = (
        near(plant, state, t) for t in (-step, 0.0, step))
    turn = quaternion.relative(turned_before, turned_after)
    rate = 2.0 * np.where(turn[:, :1] < 0.0, -1.0, 1.0) * turn[:, 1:] / (2 * step)
    assert np.allclose(seen["rate"], rate, rtol=0, atol=2e-3)
    force = (after - 2 * now + before) / step**2 + GRAVITY
    felt = quaternion.rotate(quaternion.conjugate(seen["orientation"]), force)
    assert np.abs(felt - GRAVITY).max() > 3.0
    assert np.allclose(seen["force"], felt, rtol=1e-3, atol=0.02)


def test_a_trackers_chain_reaches_the_fingertips_of_myohand(moving):
    plant, state, seen = moving
    tree, data = hand_tree(plant.size), state.data
    chain = placed(tree, seen["orientation"])
    firsts = ("cmc_flexion_r", *(f"mcp{i}_flexion_r" for i in range(2, 6)))
    for i, (first, tip) in enumerate(zip(firsts, ("TH", "IF", "MF", "RF", "LF"), strict=True)):
        k = tree.index(f"F{i + 1}{'m' if i == 0 else 'p'}")
        near_end = chain.position[k] - quaternion.rotate(seen["orientation"][k], tree.geometry[k, 4])
        ours = chain.position[tree.index(f"F{i + 1}d")] - near_end
        place = data.site(f"{tip}tip_r").xpos
        assert np.allclose(ours, place - data.xanchor[plant.model.joint(first).id], rtol=0, atol=2e-5)
        local = quaternion.rotate(quaternion.conjugate(seen["orientation"][0]), place)
        assert np.allclose(seen["fingertips"][i], local, rtol=0, atol=1e-9)


def test_sensors_lie_on_the_back_of_a_flat_hand():
    straight = {f"F{i}_{joint}_flexion": 0.0 for i in range(2, 6) for joint in ("mcp", "pip", "dip")}
    plant = MyoHand(start_deg=straight)
    state = plant.init(Context("hand"))
    seen = outputs(plant, state)
    for k, name in enumerate(hand_tree(plant.size).names[5:], 5):
        skin = state.data.geom(name)
        above = seen["position"][k, 2] - skin.xpos[2]
        assert 0.5 * plant.model.geom(name).size[0] < above < 0.02, name


@pytest.mark.parametrize("things", [{}, BALL, {"forearm_moves": True}], ids=["free", "grasp", "turned"])
def test_copies_and_pickles_go_on_bit_for_bit_and_reading_changes_nothing(things):
    plant, activation = MyoHand(**things), active(FDP2=0.2, FDP3=0.2, FDS4=0.2, FPL=0.1, THENAR=0.3)
    state, _ = run(plant, activation, 0.1)
    saved, copied = pickle.dumps(state), copy.deepcopy(state)
    _, seen = run(plant, activation, 0.15, state)
    read_often, _ = run(plant, activation, 0.15, pickle.loads(saved), every=1)
    for other in (pickle.loads(saved), copied, read_often):
        if other is not read_often:
            run(pickle.loads(pickle.dumps(plant)), activation, 0.15, other)
        again = outputs(plant, other)
        assert all(np.array_equal(seen[name], again[name]) for name in seen)
    if things is BALL:
        assert state.data.ncon > 0


@settings(deadline=None, max_examples=10)
@given(st.floats(0.05, 1.0), st.lists(st.lists(st.sampled_from([0.0, 0.02, 0.3, 1.0, 1.5]), min_size=29,
                                              max_size=29), min_size=5, max_size=5))
def test_any_activation_leaves_it_a_hand_in_steps_of_a_millisecond(strength, levels):
    plant, state = MyoHand(strength=(strength,) * 29), None
    low, high = np.degrees(plant.model.jnt_range[:22].T)
    for row in levels:
        state, seen = run(plant, np.array(row), 0.03, state)
        angles = np.degrees(state.data.qpos[:22])
        assert np.maximum(low - angles, angles - high).max() < 10.0
        assert np.isfinite(seen["force"]).all()


def test_parts_of_the_hand_feel_what_they_press():
    plant = MyoHand(**BALL)
    state, seen = run(plant, active(FDP2=0.2, FDP3=0.2, FDP4=0.2, FPL=0.2, THENAR=0.5), 0.4)
    parts = np.zeros(len(PARTS))
    for i, contact in enumerate(state.data.contact):
        force = np.zeros(6)
        mujoco.mj_contactForce(plant.model, state.data, i, force)
        for geom in contact.geom:
            name = plant.model.geom(geom).name
            if name not in ("object", "table"):
                parts[PARTS.index(name if name in PARTS else "palm")] += force[0]
    assert max(parts[PARTS.index(tip)] for tip in FINGERTIPS) > 0.2
    assert np.allclose(seen["contact"], parts, rtol=0, atol=1e-9)


def test_a_posture_is_taken_as_near_as_its_joints_come():
    wanted = {"wrist_flexion": -20.0, "wrist_abduction": 5.0, "F2_mcp_flexion": 50.0, "F2_mcp_abduction": 0.0,
              "F3_pip_flexion": 70.0, "F1_cmc_flexion": 50.0, "F1_cmc_abduction": -5.0, "F1_ip_flexion": 0.0}
    plant = MyoHand(start_deg=wanted)
    tree, angles = hand_tree(plant.size), np.degrees(plant.outputs[0].initial)
    for name, angle in wanted.items():
        assert angles[tree.freedom(name)] == pytest.approx(angle, abs=0.3), name
    pronated = MyoHand(rest_deg={"F1_cmc_pronation": 80.0, "F5_dip_flexion": 0.0})
    thumb = np.degrees(pronated.outputs[0].initial)[tree.freedom("F1_cmc_pronation")]
    assert thumb == pytest.approx(80.0, abs=2.0)


def test_a_splint_holds_what_it_names():
    plant = MyoHand(splint_deg={"wrist_flexion": -15.0, "wrist_abduction": 0.0})
    _, seen = run(plant, active(FCR=0.3, FCU=0.3, FDP3=0.3), 0.3)
    assert np.degrees(seen["angles"][:2]) == pytest.approx([-15.0, 0.0], abs=1.0)


def test_fibres_lengthen_as_the_tendons_do(moving):
    plant, state, seen = moving
    data, after = copy.deepcopy(state.data), []
    for step in (-1e-6, 1e-6):
        data.qpos[:] = state.data.qpos + step * state.data.qvel
        mujoco.mj_forward(plant.model, data)
        after.append(data.actuator_length.copy())
    for name, fibre_mm in (("FDP2", 66.0), ("EPL", 54.0), ("INT4", 40.0)):
        rows = [plant.model.actuator(theirs).id for theirs in REPRESENTS[name]]
        change = np.mean((after[1] - after[0])[rows]) / 2e-6
        assert seen["velocity"][muscle(name)] == pytest.approx(1e3 * change / fibre_mm, abs=1e-5)


@pytest.mark.parametrize(("change", "text"), [
    ({"hand": HandSize(side="left")}, "right one, 178 mm"), ({"hand": HandSize(hand_mm=170.0)}, "right one"),
    ({"strength": (1.0,)}, "strength"), ({"rest_deg": {"F2_pip": 1.0}}, "F2_pip"),
    ({"start_deg": {"F2_mcp_flexion": -40.0}}, r"start_deg.F2_mcp_flexion: -40; .*such as -3 deg"),
    ({"splint_deg": {"F1_cmc_pronation": 90.0}}, "no joint"), ({"as_shipped": ("inertias",)}, "inertia"),
    ({"splint_deg": {"F3_pip_flexion": 140.0}}, r"splint_deg.F3_pip_flexion: 140"),
    ({"start_deg": {"F3_pip_flexion": float("nan")}}, "nan"),
    ({"object": GraspObject(position_m=(0.0, 0.05, 0.0))}, "mm into"), ({"step_ms": 0.0}, "step_ms")])
def test_what_cannot_be_is_named(change, text):
    with pytest.raises(InputError, match=text):
        MyoHand(**change)


def test_its_own_measures_are_taken_for_a_hand():
    size = MyoHand().size
    assert MyoHand(hand=size).size == MyoHand(hand=HandSize()).size == size
    assert 170.0 < size.hand_mm < 190.0


def test_without_its_package_one_line_names_the_extra(monkeypatch):
    myohand_model.loaded.cache_clear()
    monkeypatch.setitem(sys.modules, "myo_sim", None)
    with pytest.raises(InputError, match="extra `myohand`") as fault:
        MyoHand()
    assert "\n" not in str(fault.value)


def test_an_unstable_simulation_is_found_at_once_and_named():
    plant = MyoHand()
    state, _ = run(plant, active(), 0.01)
    state.data.qvel[plant.model.joint(JOINTS["F2_pip_flexion"]).id] = 1e5
    with pytest.raises(RunError, match="unstable at 11 ms: pm2_flexion_r moves"):
        plant.advance(state, [active()], 10 * NS_PER_MS, 20 * NS_PER_MS)


@pytest.mark.parametrize(("stiffness", "off_deg"), [(0.5, 7.0), (50.0, 4.0)])
def test_a_spring_pulls_the_wrist_as_it_does_that_of_our_hand(stiffness, off_deg):
    """Thumb upwards, so that gravity does not bend the wrist; off by what relaxed tendons pull."""
    row = hand_tree(HandSize()).freedom("wrist_flexion")
    for plant in (Hand, MyoHand):
        pulled = plant(forearm_orientation=(0.0, 0.0, 0.0, 1.0), elastic_deg={"wrist_flexion": -20.0},
                       elastic_n_m_rad=stiffness)
        free = plant(forearm_orientation=(0.0, 0.0, 0.0, 1.0), start_deg={"wrist_flexion": -20.0})
        _, held = run(pulled, active(), 1.0)
        _, loose = run(free, active(), 1.0)
        assert np.rad2deg(held["angles"][row]) == pytest.approx(-20.0, abs=off_deg)
        assert np.rad2deg(loose["angles"][row]) > 0.0


def test_a_therapist_brings_it_into_a_pose_and_lets_it_go():
    """Its joints' own angles are not the hand's: at 0, fingers would be spread by up to 15 deg."""
    pose = {f"F{i}_{joint}_flexion": 10.0 for i in range(2, 6) for joint in ("mcp", "pip", "dip")}
    rows = [hand_tree(HandSize()).freedom(name) for name in pose]
    ways = {"settle_s": 2.0, "splint_deg": {"wrist_flexion": 0.0, "wrist_abduction": 0.0}}
    assisted = MyoHand(assist=Assistance(pose_deg=pose, until_s=0.5), **ways)
    _, held = run(assisted, active(), 0.4)
    assert np.rad2deg(held["angles"][rows]) == pytest.approx(10.0, abs=6.0)
    spread = [hand_tree(HandSize()).freedom(f"F{i}_mcp_abduction") for i in range(2, 6)]
    assert np.rad2deg(held["angles"][spread]) == pytest.approx(0.0, abs=2.0)
    _, released = run(assisted, active(), 4.0)
    _, alone = run(MyoHand(**ways), active(), 4.0)
    resting = np.rad2deg(alone["angles"][rows])
    assert np.abs(resting - 10.0).max() > 20.0
    np.testing.assert_allclose(np.rad2deg(released["angles"][rows]), resting, atol=2.0)


@pytest.mark.parametrize("flexion_deg", [20.0, 50.0])
def test_a_therapist_holds_the_thumbs_base_in_freedoms_and_not_in_myohands_joints(flexion_deg):
    """The joints at its base turn about other axes, and have another zero."""
    pose = {"F1_cmc_flexion": flexion_deg, "F1_cmc_abduction": -15.0, "F1_cmc_pronation": 92.0}
    _, held = run(MyoHand(assist=Assistance(pose_deg=pose, until_s=0.5), settle_s=2.0), active(), 0.4)
    rows = [hand_tree(HandSize()).freedom(name) for name in ("F1_cmc_flexion", "F1_cmc_abduction")]
    assert np.rad2deg(held["angles"][rows]) == pytest.approx([flexion_deg, -15.0], abs=10.0)


def test_what_an_object_is_pressed_by_is_the_palm_and_the_digits():
    assert parts_of_geoms(MyoHand().model).max() == len(PARTS) - 1
    assert set(range(len(PARTS))) <= set(parts_of_geoms(MyoHand().model).tolist())


def test_no_spring_pulls_where_there_is_no_joint():
    with pytest.raises(InputError, match=r"myohand.elastic_deg.F1_cmc_pronation: has no joint"):
        MyoHand(elastic_deg={"F1_cmc_pronation": 90.0})


@pytest.mark.parametrize("plant", [Hand, MyoHand])
def test_a_hand_that_settles_begins_where_one_gets_to_that_is_left_alone(plant):
    held = {"forearm_orientation": (0.0, 0.0, 0.0, 1.0), "elastic_deg": {"wrist_flexion": -20.0},
            "start_deg": {"F2_mcp_flexion": 40.0}}
    settled = plant(**held, settle_s=1.0)
    begun = settled.init(Context("hand"))
    state, _ = run(plant(**held), active(), 1.0)
    np.testing.assert_array_equal(begun.data.qpos, state.data.qpos)
    assert begun.time_ns == begun.data.time == 0
    moved, _ = run(settled, active(), 0.5, begun)
    later, _ = run(plant(**held), active(), 1.5)
    np.testing.assert_array_equal(moved.data.qpos, later.data.qpos)

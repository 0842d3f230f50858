import copy
import pickle

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError, RunError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses, segment_poses
from fesloop.hand.motion import root_motion, sensed, sensor_points
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import dorsal_points, hand_tree
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS
from plants.hand import Hand
from plants.hand.contract import PALM_DOWN
from plants.hand.model import muscles
from plants.hand.scene import GraspObject, Table
from plants.hand.tendons import STRAIN

TREE = hand_tree(HandSize())
NAMES = ("angles", "rates", "accelerations", "fingertips", "orientation", "position", "rate", "force",
         "contact", "velocity", "object_position", "object_orientation")
BALL = {"object": GraspObject(shape="ball", size_mm=(50.0,), position_m=(0.03, 0.08, -0.07)),
        "table": Table(height_m=-0.096)}


def active(**levels):
    rows = np.zeros(len(MUSCLES))
    for name, level in levels.items():
        rows[muscle(name)] = level
    return rows


def run(plant, activation, seconds, state=None, every=None):
    """State and outputs after some seconds; every so many steps read in between, if given."""
    state = plant.init(Context("hand")) if state is None else state
    inputs = [activation, np.array([0.0, 0.6, 0.0, 0.8])]
    steps = round(1e3 * seconds / plant.step_ms)
    for k in range(steps):
        now = state.time_ns
        plant.advance(state, inputs, now, now + plant.grid.period_num)
        if every and k % every == 0:
            plant.read(state, [activation])
    return state, outputs(plant, state, activation)


def outputs(plant, state, activation):
    return dict(zip(NAMES, plant.read(state, [activation]), strict=False))


@pytest.fixture(scope="module", params=["left", "right"])
def moving(request):
    """A hand in full motion: plant, and what it puts out."""
    plant = Hand(hand=HandSize(side=request.param))
    state, seen = run(plant, active(FDP2=0.05, EDC3=0.2, THENAR=0.05, ECRL=0.1, INT5=0.1), 0.06)
    return plant, state, seen


@pytest.mark.slow
def test_sensor_sites_feel_what_the_chain_says(moving):
    plant, _, seen = moving
    tree, root = hand_tree(plant.hand), root_motion(PALM_DOWN[plant.hand.side])
    points = sensor_points(tree, tree.names, dorsal_points(plant.hand))
    samples = sensed(tree, points, seen["angles"], seen["rates"], seen["accelerations"], root)
    assert np.abs(seen["rates"]).max() > 3.0
    assert np.allclose(seen["rate"], samples.gyr, rtol=0, atol=1e-8)
    assert np.allclose(seen["force"], samples.acc, rtol=0, atol=1e-8)


def test_sites_and_fingertips_are_where_kinematics_has_them(moving):
    plant, _, seen = moving
    tree, down = hand_tree(plant.hand), np.array(PALM_DOWN[plant.hand.side])
    poses = segment_poses(tree, seen["angles"], Poses(down, np.zeros(3)))
    same = np.abs(np.sum(seen["orientation"] * poses.orientation, axis=1))
    assert np.allclose(same, 1.0, rtol=0, atol=1e-12)
    places = poses.position + quaternion.rotate(poses.orientation, dorsal_points(plant.hand))
    assert np.allclose(seen["position"], places, rtol=0, atol=1e-12)
    tips = [tree.index(f"F{i}d") for i in range(1, 6)]
    ends = segment_poses(tree, seen["angles"]).position[tips]
    assert np.allclose(seen["fingertips"], ends, rtol=0, atol=1e-12)


def test_stiff_tendons_fibres_lengthen_as_mujocos_tendons_do():
    plant = Hand(tendon_strain=0.0)
    state, seen = run(plant, active(EDC3=0.2, ECRL=0.1), 0.06)
    mujoco.mj_forward(plant.model, state.data)
    for name, row in zip(MUSCLES, muscles(), strict=True):
        lengthening = state.data.ten_velocity[plant.model.tendon(name).id]
        assert seen["velocity"][muscle(name)] == pytest.approx(1e3 * lengthening / row.fibre_mm, abs=1e-9)
    assert np.abs(seen["velocity"]).max() > 2.0


def test_sites_feel_the_forearm_turn_and_it_arrives():
    plant = Hand(forearm_moves=True)
    start = np.array(PALM_DOWN["right"])
    wanted = quaternion.multiply(start, quaternion.from_axis_angle([0.3, 0.8, 0.5], 1.2))
    forearm = Segment(name="forearm", parent="room", joint="ball", joint_name="arm")
    tree = SegmentTree((Segment(name="room"), forearm, *TREE.segments[1:]))
    points = sensor_points(tree, TREE.names, dorsal_points(plant.hand))
    state = plant.init(Context("hand"))
    for stop_ms in (30, 400):
        plant.advance(state, [active(FDP2=0.05), wanted], state.time_ns, stop_ms * NS_PER_MS)
        seen, data = outputs(plant, state, active()), state.data
        if stop_ms == 30:
            assert np.abs(seen["rate"][0]).max() > 5.0
        samples = sensed(tree, points, data.qpos, data.qvel, data.qacc, root_motion(start))
        assert np.allclose(seen["rate"], samples.gyr, rtol=0, atol=1e-8)
        assert np.allclose(seen["force"], samples.acc, rtol=0, atol=1e-8)
    left = quaternion.rotation_angle(quaternion.relative(seen["orientation"][0], wanted))
    assert np.degrees(left) < 0.5


@settings(deadline=None, max_examples=12)
@given(st.sampled_from(["left", "right"]), st.floats(120.0, 230.0), st.floats(0.05, 1.0),
       st.lists(st.sampled_from([0.0, 0.02, 0.3, 1.0, 1.5]), min_size=29, max_size=29))
def test_any_hand_under_any_activation_stays_a_hand(side, hand_mm, strength, levels):
    step_ms = 1.0 if hand_mm > 180.0 else 0.5
    plant = Hand(hand=HandSize(side=side, hand_mm=hand_mm), strength=(strength,) * 29, step_ms=step_ms)
    state = None
    for share in np.linspace(0.05, 1.0, 20):
        state, seen = run(plant, share * np.array(levels), 0.02, state)
    low, high = np.degrees(TREE.ranges).T
    beyond = np.maximum(low - np.degrees(seen["angles"]), np.degrees(seen["angles"]) - high)
    beyond[TREE.freedom("wrist_flexion")] -= 20.0
    assert beyond.max() < 20.0
    assert np.allclose(np.linalg.norm(seen["orientation"], axis=1), 1.0, rtol=0, atol=1e-12)


def test_left_hand_is_the_mirror_of_the_right():
    activation = active(FDP2=0.03, EDC3=0.1, THENAR=0.05, ECRL=0.1, FCU=0.05)
    left, right = (run(Hand(hand=HandSize(side=side)), activation, 0.15)[1] for side in ("left", "right"))
    assert np.allclose(left["angles"], right["angles"], rtol=0, atol=1e-9)
    assert np.allclose(left["position"], right["position"] * [-1.0, 1.0, 1.0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("things", [{}, BALL, {"forearm_moves": True}], ids=["free", "grasp", "turned"])
def test_copies_and_pickles_go_on_bit_for_bit_and_reading_changes_nothing(things):
    plant, activation = Hand(**things), active(FDP2=0.05, FDP3=0.05, FDS4=0.05, FPL=0.1, THENAR=0.05)
    state, _ = run(plant, activation, 0.1)
    saved, copied = pickle.dumps(state), copy.deepcopy(state)
    _, seen = run(plant, activation, 0.15, state)
    read_often, _ = run(plant, activation, 0.15, pickle.loads(saved), every=1)
    for other in (pickle.loads(saved), copied, read_often):
        if other is not read_often:
            run(plant, activation, 0.15, other)
        again = outputs(plant, other, activation)
        assert all(np.array_equal(seen[name], again[name]) for name in seen)
    if things is BALL:
        assert state.data.ncon > 0


@pytest.mark.parametrize("things", [{}, BALL, {"forearm_moves": True}], ids=["free", "grasp", "turned"])
def test_a_glance_gives_what_reading_gives_and_evaluates_nothing(things):
    plant, activation = Hand(**things), active(FDP2=0.05, FDS4=0.05)
    state, _ = run(plant, activation, 0.05)
    forearm = np.array([0.0, 0.6, 0.0, 0.8])
    plant.advance(state, [activation, forearm], state.time_ns, state.time_ns + NS_PER_MS)
    seen = plant.glance(state)
    assert not state.evaluated
    read = plant.read(state, [activation])
    assert [plant.outputs[port].name for port in seen] == ["angles", "rates", "velocity"]
    assert all(np.array_equal(values, read[port]) for port, values in seen.items())


@pytest.mark.parametrize("strain", [0.0, STRAIN])
def test_a_step_is_that_of_mujoco_itself(strain):
    plant = Hand(**BALL, tendon_strain=strain)
    activation = active(FDP2=0.05, FDS3=0.05, ECRL=0.1)
    state = plant.init(Context("hand"))
    data = copy.deepcopy(state.data)
    run(plant, activation, 0.1, state)
    for _ in range(100):
        plant.pull(data, activation)
        mujoco.mj_step(plant.model, data)
    assert np.array_equal(data.qpos, state.data.qpos)
    assert np.array_equal(data.qvel, state.data.qvel)


@pytest.mark.parametrize(("change", "text"), [
    ({"strength": (1.0,)}, "strength"), ({"rest_deg": {"F2_pip": 1.0}}, "F2_pip"),
    ({"rest_deg": {"F2_pip_flexion": 170.0}}, "F2_pip_flexion"), ({"stiffness": -1.0}, "stiffness"),
    ({"forearm_orientation": (1.0, 1.0, 0.0, 0.0)}, "length 1"), ({"step_ms": 0.0}, "step_ms"),
    ({"step_ms": 1e-6}, "step_ms"), ({"splint_deg": {"wrist_flexion": 90.0}}, "wrist_flexion"),
    ({"object": GraspObject(position_m=(0.0, 0.05, 0.0))}, "mm into"),
    ({"forearm_orientation": (np.nan, 0.0, 0.0, 0.0)}, "length 1"),
    ({"table": Table(height_m=-0.01, half_m=(0.02, 0.02))}, "hand.table: reaches"),
    ({"contracture": float("nan")}, "contracture"), ({"tendon_strain": 0.001}, "tendon_strain: 0.001"),
    ({"tendon_strain": float("nan")}, "tendon_strain"), ({"tendon_strain": -0.03}, "tendon_strain")])
def test_what_cannot_be_is_named(change, text):
    with pytest.raises(InputError, match=text):
        Hand(**change)


@pytest.mark.parametrize("fault", [{"shape": "egg"}, {"size_mm": (1.0,)}, {"mass_kg": 0.0},
                                   {"orientation": (1.0, 1.0, 0.0, 0.0)}, {"orientation": (np.nan,) * 4},
                                   {"position_m": (0.0, 0.0, np.inf)}])
def test_objects_that_make_no_sense_are_refused(fault):
    with pytest.raises(InputError):
        GraspObject(**fault)


@pytest.mark.parametrize(("angle", "speed", "told"), [
    (0.5, 1e5, "F2_pip_flexion moves"), (0.5, np.nan, "arm_flexion moves at nan"),
    (np.deg2rad(175.0), 0.0, "F2_pip_flexion is at 1[67].* deg, far beyond its range")])
def test_an_unstable_simulation_is_found_at_once_and_named(angle, speed, told):
    plant = Hand(object=BALL["object"], forearm_moves=True)
    state, _ = run(plant, active(), 0.01)
    state.data.qpos[12], state.data.qvel[12] = angle, speed
    with pytest.raises(RunError, match=f"unstable at 11 ms: {told}"):
        plant.advance(state, [active(), np.array(PALM_DOWN["right"])], 10 * NS_PER_MS, 20 * NS_PER_MS)


@pytest.mark.parametrize("change", [
    {"stiffness": 1e3}, {"stiffness": 1e6}, {"contracture": 1e4},
    {"strength": (1e3,) * 29, "step_ms": 5.0}])
def test_what_blows_up_is_found_within_10_ms_of_looking_wrong(change):
    """From the first step after which a joint is 50 deg beyond its range or moves at 200 rad/s."""
    plant, closing = Hand(**change), active(**dict.fromkeys(("FDP2", "FDS3", "FPL", "THENAR", "FDP5"), 0.5))
    state, wrong_ns = plant.init(Context("hand")), None
    low, high = TREE.ranges.T + np.deg2rad([[-50.0], [50.0]])
    low[0], high[0] = np.deg2rad((-140.0, 140.0))

    def steps():
        while state.time_ns < 1000 * NS_PER_MS:
            plant.advance(state, [closing], state.time_ns, state.time_ns + plant.grid.period_num)
            yield state.data.qpos, state.data.qvel

    def go_on():
        nonlocal wrong_ns
        for angles, speeds in steps():
            if (angles < low).any() or (angles > high).any() or np.abs(speeds).max() > 200.0:
                wrong_ns = wrong_ns or state.time_ns

    with pytest.raises(RunError, match="unstable"):
        go_on()
    assert wrong_ns is None or state.time_ns - wrong_ns <= 10 * NS_PER_MS

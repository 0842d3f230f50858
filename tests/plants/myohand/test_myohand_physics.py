"""MyoHand beside `hand`, and its patches against published numbers; about 15 s."""

import mujoco
import numpy as np
import pytest

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from plants.electrodes import Electrodes
from plants.hand import Hand
from plants.hand.scene import GraspObject, Table
from plants.myohand import MyoHand
from plants.myohand.anatomy import JOINTS
from plants.myohand.patches import NAMES

pytest.importorskip("myo_sim", reason="the extra `myohand` is not installed")

FREEDOMS = hand_tree(HandSize()).freedoms
SPLINT = {"wrist_flexion": 0.0, "wrist_abduction": 0.0}
GROUPS = {
    "wrist extensors": ("ECRL", "ECRB", "ECU"), "wrist flexors": ("FCR", "PL", "FCU"),
    "radial": ("ECRL", "FCR"), "ulnar": ("ECU", "FCU"),
    "finger extensors": ("EDC2", "EDC3", "EDC4", "EDC5", "EDM", "EIP"),
    "thumb extensors": ("EPL", "EPB", "APL"),
    "superficial flexors": ("FDS2", "FDS3", "FDS4", "FDS5"), "deep flexors": ("FDP2", "FDP3", "FDP4", "FDP5"),
    "thumb flexor": ("FPL",), "thenar": ("THENAR",), "intrinsic": ("INT2", "INT3", "INT4", "INT5")}
WRIST = {*GROUPS["wrist extensors"], *GROUPS["wrist flexors"]}
DIFFERENT = {
    ("APL", "F1_cmc_abduction"): "its path crosses the axis of the thumb's base in MyoHand: no arm about it",
    ("FCR", "wrist_abduction"): "MyoHand's wrist flexes about an axis tilted by 17 deg, towards the ulna",
    ("PL", "wrist_abduction"): "the same"}
"""Where a muscle alone moves a joint one way in `hand` and the other way in MyoHand, and why."""


def weightless(kind, **parameters):
    plant = kind(**parameters)
    plant.model.opt.gravity[:] = 0.0
    return plant


def moved(plant, activation, seconds=0.15):
    """How far the joints are moved from rest, deg."""
    state = plant.init(Context("hand"))
    start = plant.read(state, [])[0]
    plant.advance(state, [activation], 0, round(1e9 * seconds))
    return np.degrees(plant.read(state, [])[0] - start)


def active(names, level=0.1):
    return np.array([level * (name in names) for name in MUSCLES])


def noticeable(moves):
    """Joints that move by more than 1 deg and a tenth of the joint that moves most."""
    return np.abs(moves) > max(1.0, 0.1 * np.abs(moves).max())


def opposed(one, other):
    """Freedoms that both hands move noticeably, but to different sides."""
    return {FREEDOMS[i] for i in np.flatnonzero(noticeable(one) & noticeable(other) & (one * other < 0.0))}


@pytest.fixture(scope="module")
def pairs():
    """`hand` and MyoHand, their wrists free, and splinted."""
    return {held: [weightless(kind, splint_deg=SPLINT if held else {}) for kind in (Hand, MyoHand)]
            for held in (False, True)}


def test_each_muscle_alone_moves_the_same_joints_to_the_same_side(pairs):
    found = set()
    for name in MUSCLES:
        one, other = (moved(plant, active((name,))) for plant in pairs[name not in WRIST])
        found |= {(name, freedom) for freedom in opposed(one, other)}
        most = FREEDOMS[int(np.argmax(np.abs(one)))]
        if name not in ("APL", "THENAR"):
            assert one[FREEDOMS.index(most)] * other[FREEDOMS.index(most)] > 1.0, (name, most)
    assert found == DIFFERENT.keys()


@pytest.mark.parametrize("group", GROUPS)
def test_each_group_moves_the_same_joints_to_the_same_side(pairs, group):
    names = GROUPS[group]
    one, other = (moved(plant, active(names)) for plant in pairs[not set(names) <= WRIST])
    assert not opposed(one, other)
    assert (noticeable(one) & noticeable(other)).any()


def test_each_element_of_the_arrays_moves_the_same_joints_to_the_same_side(pairs):
    electrodes, reached = Electrodes(axon_seed=1), 0
    for element in range(electrodes.elements):
        recruited = recruitment(electrodes, element, 0.02)
        if recruited.max() < 0.05:
            continue
        one, other = (moved(plant, 0.15 * recruited) for plant in pairs[False])
        assert opposed(one, other) <= {"wrist_abduction"}, element
        reached += 1
    assert reached > 40


def recruitment(electrodes, element, current, width=3e-4):
    """Shares (29,) that one pulse train on one element recruits."""
    state = electrodes.init(Context("electrodes", 1, 0, RateClock.from_rate("320")))
    pulses = np.zeros((electrodes.elements, 3))
    pulses[element] = current, width, 40.0
    others = [Sample(port.initial_value(), NEVER, NEVER, NEVER) for port in electrodes.inputs[1:]]
    return electrodes.step(state, (Sample(pulses, 0, 0, 0), *others), Tick())[0]


def wrist_moments(plant, wrist_deg):
    """Largest moments of flexion and extension, N m: every muscle that helps, fully active."""
    model, data = plant.model, plant.init(Context("hand")).data
    wrist = model.joint("flexion_r").id
    data.qpos[wrist] = np.radians(wrist_deg)
    found = []
    for sign in (1.0, -1.0):
        mujoco.mj_forward(model, data)
        arms = np.zeros((model.nu, model.nv))
        mujoco.mju_sparse2dense(arms, data.actuator_moment.ravel(), data.moment_rownnz, data.moment_rowadr,
                                data.moment_colind)
        data.ctrl[:] = sign * arms[:, wrist] < 0.0
        mujoco.mj_forward(model, data)
        found.append(sign * data.qfrc_actuator[wrist])
        data.ctrl[:] = 0.0
    return found


@pytest.mark.parametrize("wrist_deg", [-40.0, -20.0, 0.0, 20.0, 40.0])
def test_the_wrists_largest_moments_are_within_measured_ranges(wrist_deg):
    flexion, extension = wrist_moments(MyoHand(), wrist_deg)
    assert 5.2 < flexion < 18.7
    assert 3.4 < extension < 9.4
    flexion, extension = wrist_moments(MyoHand(as_shipped=NAMES), wrist_deg)
    assert flexion > 25.0
    assert extension > 9.4


@pytest.mark.parametrize(("contracture", "low", "high"), [
    (1.0, 0.033, 0.047), (2.6, 0.085, 0.093), (17.0, 0.5, 0.54), (21.0, 0.61, 0.67)])
def test_mcp_stiffness_tendons_included_is_as_measured(contracture, low, high):
    plant = MyoHand(contracture=contracture)
    data = plant.init(Context("hand")).data
    for finger in range(2, 6):
        joint, moments = plant.model.joint(JOINTS[f"F{finger}_mcp_flexion"]).id, []
        for angle in (-0.02, 0.02):
            data.qpos[joint] += angle
            mujoco.mj_forward(plant.model, data)
            moments.append((data.qfrc_passive + data.qfrc_actuator)[joint])
            data.qpos[joint] -= angle
        assert low < -(moments[1] - moments[0]) / 0.04 < high


def test_tenodesis_the_extended_wrist_closes_the_fingers_and_the_flexed_one_opens_them():
    joints = (f"F{i}_{joint}_flexion" for i in range(2, 6) for joint in ("mcp", "pip", "dip"))
    flexions = [FREEDOMS.index(joint) for joint in joints]
    for wrist, sign in ((-30.0, 1.0), (30.0, -1.0)):
        plant = weightless(MyoHand, splint_deg={**SPLINT, "wrist_flexion": wrist})
        change = sign * moved(plant, active(()), 1.0)[flexions].reshape(4, 3)
        assert (change.sum(axis=1) > 10.0).all()


def test_without_gravity_the_hand_rests_where_it_is_told_to():
    plant = weightless(MyoHand, rest_deg={"F2_pip_flexion": 50.0, "wrist_flexion": -20.0})
    assert np.abs(moved(plant, active(()), 1.0)).max() < 1e-6
    rest = np.degrees(plant.outputs[0].initial)
    assert rest[FREEDOMS.index("F2_pip_flexion")] == pytest.approx(50.0, abs=0.1)
    assert rest[FREEDOMS.index("wrist_flexion")] == pytest.approx(-20.0, abs=0.1)


def test_the_index_fingers_first_phalanx_is_as_heavy_to_turn_as_published():
    def inertia(**parameters):
        return MyoHand(**parameters).model.body("2proxph_r").inertia.max()

    assert inertia() == pytest.approx(2e-6, rel=0.4)
    assert inertia(as_shipped=("inertia",)) > 40.0 * inertia()


@pytest.mark.parametrize("lengths", [True, False])
def test_tendons_stay_within_their_ranges_of_lengths_in_any_posture(lengths):
    plant = MyoHand() if lengths else MyoHand(as_shipped=("lengths",))
    model, data, rng = plant.model, mujoco.MjData(plant.model), np.random.default_rng(1)
    low, high = model.jnt_range[:22].T
    beyond = np.zeros(model.nu)
    for _ in range(500):
        data.qpos[:22] = rng.uniform(low, high)
        mujoco.mj_fwdPosition(model, data)
        over = np.maximum(model.actuator_lengthrange[:, 0] - data.actuator_length,
                          data.actuator_length - model.actuator_lengthrange[:, 1])
        beyond = np.maximum(beyond, over / np.ptp(model.actuator_lengthrange, axis=1))
    assert (beyond.max() < 0.1) == lengths


def test_no_path_of_a_muscle_that_is_left_jumps():
    plant = MyoHand()
    model, data, rng = plant.model, mujoco.MjData(plant.model), np.random.default_rng(2)
    low, high = model.jnt_range[:22].T
    for _ in range(30):
        ends = rng.uniform(low, high, (2, 22))
        lengths = []
        for share in np.linspace(0.0, 1.0, 101):
            data.qpos[:22] = ends[0] + share * (ends[1] - ends[0])
            mujoco.mj_fwdPosition(model, data)
            lengths.append(data.actuator_length.copy())
        steps = np.diff(lengths, axis=0)
        assert np.abs(np.diff(steps, axis=0)).max() < 3e-4


def grasping(step_ms):
    """Angles (200, 23), deg, and the cylinder's places, every 20 ms: the hand closes, the table sinks."""
    place = (-0.008, 0.105, 0.0)
    straight = {f"F{i}_{joint}_flexion": 0.0 for i in range(2, 6) for joint in ("mcp", "pip", "dip")}
    plant = MyoHand(
        forearm_orientation=(0.0, 0.0, 0.0, 1.0), step_ms=step_ms,
        splint_deg={**SPLINT, "wrist_flexion": -20.0},
        start_deg={**straight, "F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0, "F1_mcp_flexion": 0.0,
                   "F1_ip_flexion": 0.0},
        object=GraspObject(size_mm=(50.0, 120.0), mass_kg=0.2, position_m=place),
        table=Table(height_m=-0.0601, centre_m=place[:2], half_m=(0.04, 0.04), lowered_at_s=1.5))
    state, angles, places = plant.init(Context("hand")), [], []
    closing = active([name for name in MUSCLES if name.startswith(("FDP", "FDS"))], 0.05)
    closing += active(("FPL", "THENAR"), 0.1)
    for k in range(200):
        plant.advance(state, [min(1.0, 0.02 * k) * closing], 20_000_000 * k, 20_000_000 * (k + 1))
        seen = plant.read(state, [])
        angles.append(np.degrees(seen[0]))
        places.append(seen[10])
    return np.array(angles), np.array(places)


def test_it_holds_a_cylinder_and_halving_the_step_changes_that_by_less_than_two_degrees():
    (usual, places), (fine, _) = (grasping(step_ms) for step_ms in (1.0, 0.5))
    assert np.abs(places[:, 2]).max() < 0.02
    assert np.ptp(usual, axis=0).max() > 30.0
    assert np.abs(usual - fine).max() < 2.0  # its fingers tremble on the cylinder


def test_a_stronger_muscle_pulls_harder():
    weak, strong = (weightless(MyoHand, splint_deg=SPLINT, strength=tuple(
        factor if name == "FDP3" else 1.0 for name in MUSCLES)) for factor in (0.5, 1.0))
    pulls = [moved(plant, active(("FDP3",), 0.02), 0.1)[FREEDOMS.index("F3_pip_flexion")]
             for plant in (weak, strong)]
    assert 1.3 < pulls[1] / pulls[0] < 2.2

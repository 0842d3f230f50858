"""The hand's mechanics against published behaviour and conservation laws; about 10 s."""

import mujoco
import numpy as np
import pytest

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.model import moment_arms, muscles, resting_posture

TREE = hand_tree(HandSize())
INDEX = [TREE.freedom(f"F2_{joint}_flexion") for joint in ("mcp", "pip", "dip")]
FLEXION = [TREE.freedom(f"F{i}_{joint}_flexion") for i in range(2, 6) for joint in ("mcp", "pip", "dip")]
STRAIGHT = {"wrist_flexion": 0.0, "wrist_abduction": 0.0}
DOES = {
    "ECRL": {"wrist_flexion": -1, "wrist_abduction": -1}, "ECRB": {"wrist_flexion": -1},
    "ECU": {"wrist_flexion": -1, "wrist_abduction": 1}, "FCR": {"wrist_flexion": 1},
    "PL": {"wrist_flexion": 1}, "FCU": {"wrist_flexion": 1, "wrist_abduction": 1},
    **{f"EDC{i}": {f"F{i}_mcp_flexion": -1, f"F{i}_pip_flexion": -1} for i in range(2, 6)},
    "EDM": {"F5_mcp_flexion": -1}, "EIP": {"F2_mcp_flexion": -1},
    **{f"FDS{i}": {f"F{i}_mcp_flexion": 1, f"F{i}_pip_flexion": 1} for i in range(2, 6)},
    **{f"FDP{i}": {f"F{i}_{joint}_flexion": 1 for joint in ("mcp", "pip", "dip")} for i in range(2, 6)},
    **{f"INT{i}": {f"F{i}_mcp_flexion": 1, f"F{i}_pip_flexion": -1} for i in range(2, 6)},
    "EPL": {"F1_ip_flexion": -1, "F1_cmc_flexion": -1}, "EPB": {"F1_mcp_flexion": -1},
    "APL": {"F1_cmc_abduction": -1}, "FPL": {"F1_ip_flexion": 1, "F1_mcp_flexion": 1},
    "THENAR": {"F1_cmc_flexion": 1, "F1_cmc_abduction": 1}}
"""What anatomy texts say of each muscle, as signs of the hand's freedoms."""


def newtons(**loads):
    """Activations at which muscles of optimal length pull with these forces."""
    rows = np.zeros(len(MUSCLES))
    for name, force in loads.items():
        rows[muscle(name)] = force / muscles()[muscle(name)].force_n
    return rows


def weightless(**parameters):
    plant = Hand(**parameters)
    plant.model.opt.gravity[:] = 0.0
    return plant


def settled(plant, activation, seconds=2.0):
    """Angles after a while, deg."""
    state = plant.init(Context("hand"))
    plant.advance(state, [activation], 0, round(1e9 * seconds))
    return np.degrees(plant.read(state, [activation])[0])


def pulled(plant, data, activation):
    """Moments (d,), N m, of muscles at rest at the posture in the data, their fibres in equilibrium."""
    data.qvel[:] = 0.0
    for _ in range(1000):
        plant.pull(data, activation)
    mujoco.mj_forward(plant.model, data)
    return data.qfrc_actuator + data.qfrc_applied


def turned(plant, seconds=2.0, **loads):
    """How far loads turn the index finger's joints, deg."""
    return (settled(plant, newtons(**loads), seconds) - settled(plant, newtons(), 0.1))[INDEX]


@pytest.mark.parametrize("side", ["left", "right"])
def test_each_muscle_alone_moves_its_joints_as_anatomy_says(side):
    plant = weightless(hand=HandSize(side=side))
    rest = np.degrees(plant.init(Context("hand")).data.qpos)
    assert DOES.keys() == set(MUSCLES)
    for name, signs in DOES.items():
        moved = settled(plant, newtons(**{name: 2.0}), 0.15) - rest
        for freedom, sign in signs.items():
            assert sign * moved[TREE.freedom(freedom)] > 0.5, (name, freedom)


def test_without_gravity_the_hand_rests_where_it_is_told_to():
    plant = weightless(rest_deg={"F2_pip_flexion": 50.0, "wrist_flexion": -20.0})
    rest = np.degrees(resting_posture(TREE, plant.rest_deg))
    assert np.abs(settled(plant, newtons(), 1.0) - rest).max() < 1e-6


def test_nimbarte_one_newton_on_each_tendon_turns_the_joints_in_the_published_proportions():
    plant = weightless(splint_deg=STRAIGHT)
    profundus, superficialis = turned(plant, FDP2=1.0), turned(plant, FDS2=1.0)
    assert profundus[1] / profundus[0] == pytest.approx(41.8 / 19.7, rel=0.25)
    assert profundus[2] / profundus[0] == pytest.approx(29.4 / 19.7, rel=0.25)
    assert superficialis[1] / superficialis[0] == pytest.approx(47.9 / 24.8, rel=0.25)
    assert abs(superficialis[2]) < 3.0
    assert (turned(plant, EDC2=1.0) < [-10.0, -4.0, -0.5]).all()


def test_kamper_with_passive_moments_the_long_flexors_bend_all_three_joints():
    bent = turned(weightless(splint_deg=STRAIGHT), FDP2=3.0, FDS2=1.0)
    published = np.array([43.0, 75.0, 63.0])
    assert (np.abs(bent - published) < np.maximum(10.0, 0.25 * published)).all(), bent


def test_kamper_without_passive_moments_pip_flexes_and_mcp_extends():
    """From the resting posture, 1 N on either tendon, which takes 2 ms to stretch: within 30 ms from then FDP
    shortens by 9 mm and FDS by 6, that is .3 and .2 m/s. The DIP joint, which extended by 8 deg in Kamper's
    model, flexes by 10 deg (12 with stiff tendons).
    """
    loose = weightless(splint_deg=STRAIGHT, stiffness=0.0, damping=0.0, passive_tension=0.0)
    bent = turned(loose, 0.032, FDP2=1.0, FDS2=1.0)
    shortened = moment_arms(TREE, 0.0)[[muscle("FDP2"), muscle("FDS2")]][:, INDEX] @ np.deg2rad(bent)
    assert bent[1] > 40.0
    assert bent[0] < -3.0
    assert bent[2] == pytest.approx(12.0, abs=3.0)
    assert shortened == pytest.approx([0.009, 0.006], abs=5e-4)


@pytest.mark.parametrize(("contracture", "low", "high"), [
    (1.0, 0.033, 0.047), (2.6, 0.085, 0.093), (17.0, 0.5, 0.54), (21.0, 0.61, 0.67)])
def test_mcp_stiffness_tendons_included_is_as_measured(contracture, low, high):
    plant = weightless(splint_deg=STRAIGHT, contracture=contracture)
    data = plant.init(Context("hand")).data
    moments = []
    for angle in (-0.02, 0.02):
        data.qpos[INDEX[0]] += angle
        moments.append((pulled(plant, data, newtons()) + data.qfrc_passive)[INDEX[0]])
        data.qpos[INDEX[0]] -= angle
    assert low < -(moments[1] - moments[0]) / 0.04 < high


def test_tenodesis_the_extended_wrist_closes_the_fingers_and_the_flexed_one_opens_them():
    postures = {wrist: settled(weightless(splint_deg={**STRAIGHT, "wrist_flexion": wrist}), newtons(), 1.0)
                for wrist in (-30.0, 0.0, 30.0)}
    for wrist, sign in ((-30.0, 1.0), (30.0, -1.0)):
        change = sign * (postures[wrist] - postures[0.0])[FLEXION].reshape(4, 3)
        assert (change.sum(axis=1) > 10.0).all()
        assert (change > 0.0).all()


@pytest.mark.parametrize(("wrist", "moment"), [(-90.0, 1.2), (-60.0, 0.1), (60.0, -0.1), (90.0, -0.5)])
def test_the_relaxed_wrists_moment_is_as_measured(wrist, moment):
    plant = weightless()
    model, data = plant.model, plant.init(Context("hand")).data
    # Held by next to infinite damping, the fingers free.
    model.dof_damping[0], data.qpos[0] = 1e6, np.deg2rad(wrist)
    model.jnt_limited[0] = 0
    for _ in range(1000):
        plant.pull(data, newtons())
        mujoco.mj_step(model, data)
    muscle_moment = pulled(plant, data, newtons())[0]
    assert data.qfrc_passive[0] + muscle_moment == pytest.approx(moment, abs=0.1)


@pytest.mark.parametrize(("freedom", "sign", "low", "high"), [
    ("wrist_flexion", 1, 5.2, 18.7), ("wrist_flexion", -1, 3.4, 9.4), ("wrist_abduction", -1, 7.9, 15.3),
    ("wrist_abduction", 1, 5.9, 11.9)])
def test_the_wrists_largest_moments_are_within_measured_ranges(freedom, sign, low, high):
    """All muscles that turn the hand one way pull, at the angle where they do most (Delp 1996)."""
    plant, joint = weightless(), TREE.freedom(freedom)
    data, pulling = plant.init(Context("hand")).data, sign * moment_arms(TREE, 0.0)[:, joint] > 0.0
    moments = []
    for angle in np.linspace(*TREE.ranges[joint], 15):
        data.qpos[joint] = angle
        moments.append(sign * pulled(plant, data, pulling)[joint])
    assert low < max(moments) < high


@pytest.mark.parametrize("strain", [0.0, 0.033])
def test_held_moments_are_those_in_which_a_held_hand_ends(strain):
    plant = Hand(tendon_strain=strain)
    data, activation = plant.init(Context("hand")).data, newtons(FDP2=20.0, EDC3=5.0, ECRB=10.0, FPL=30.0)
    data.qpos[INDEX] = 0.4, 0.6, 0.3
    found = plant.held_moments(data.qpos.copy(), activation)
    assert found == pytest.approx(pulled(plant, data, activation), abs=1e-6)
    assert np.abs(found).max() > 0.2


@pytest.mark.parametrize(("wrist", "mcp", "pip", "dip"), [
    (60.0, 27.0, 19.0, 12.0), (0.0, 45.0, 44.5, 21.5), (-60.0, 63.0, 70.0, 31.0)])
def test_the_relaxed_fingers_rest_where_those_of_people_do(wrist, mcp, pip, dip):
    """Means of 50 people whose relaxed fingers were led by the wrist, from 60 deg of flexion to 60 deg of
    extension, near linear in between (Su 2005, doi 10.1016/j.clinbiomech.2005.01.002).

    The mean of the fingers is within 20 deg (chosen: how people differ is not in the abstract); the hand is
    held palm down, and fingers curl more towards the little one where the wrist is neutral.
    """
    rested = settled(Hand(splint_deg={**STRAIGHT, "wrist_flexion": wrist}), newtons(), 3.0)
    fingers = rested[FLEXION].reshape(4, 3)
    assert (np.abs(fingers.mean(axis=0) - (mcp, pip, dip)) < 20.0).all(), fingers.mean(axis=0)
    if wrist == 0.0:
        assert (np.diff(fingers[:, 1]) > 0.0).all()


def test_ranges_hold_under_full_force():
    ranges = np.degrees(TREE.ranges)
    for names in (("FDP", "FDS", "FPL", "THENAR", "FCU"), ("ED", "EP", "EI", "APL", "ECR")):
        activation = np.array([float(name.startswith(names)) for name in MUSCLES])
        angles = settled(weightless(), activation, 1.0)
        ranges[TREE.freedom("wrist_flexion")] = -90.0, 90.0
        assert (angles > ranges[:, 0] - 5.0).all()
        assert (angles < ranges[:, 1] + 5.0).all()


@pytest.mark.slow
def test_undamped_and_unforced_energy_stays():
    plant = Hand(damping=0.0, passive_tension=0.0)
    model, data = plant.model, plant.init(Context("hand")).data
    # Ends of range and contact take energy by design; the fixed steps' own integrator relies on damping.
    model.jnt_limited[:] = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 2.5e-4

    def energy():
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        return data.energy.copy()

    mujoco.mj_forward(model, data)
    start, seen = energy().sum(), []
    for _ in range(400):
        mujoco.mj_step(model, data, nstep=100)
        seen.append(energy())
    kinetic = np.max(seen, axis=0)[1]
    assert kinetic > 0.05
    assert np.abs(np.sum(seen, axis=1) - start).max() < 1e-3 * kinetic


def closing_and_opening(step_ms):
    """Angles (200, 23), deg, over 4 s: thumb and fingers close within .5 s and open at 3 s within .2 s."""
    plant = Hand(step_ms=step_ms, splint_deg={**STRAIGHT, "wrist_flexion": -20.0})
    state, rows = plant.init(Context("hand")), []
    full = np.array([0.05 * name.startswith(("FDP", "FDS", "FPL", "THENAR")) for name in MUSCLES])
    for k in range(200):
        level = np.interp(0.02 * k, (0.0, 0.5, 3.0, 3.2), (0.0, 1.0, 1.0, 0.0))
        plant.advance(state, [level * full], 20_000_000 * k, 20_000_000 * (k + 1))
        rows.append(plant.read(state, [full])[0])
    return np.degrees(rows)


def test_halving_the_step_changes_a_fist_by_less_than_a_degree_and_converges():
    usual, fine, finest = (closing_and_opening(step_ms) for step_ms in (1.0, 0.5, 0.25))
    assert np.ptp(usual, axis=0).max() > 30.0
    assert np.abs(usual - fine).max() < 1.0
    assert np.abs(fine - finest).max() < 0.75 * np.abs(usual - fine).max()


def test_a_splint_holds_every_freedom_against_the_muscles():
    """Full force of all that flexes, and of all that extends: it gives by some degrees at most."""
    splint = {"wrist_flexion": -20.0, "wrist_abduction": 0.0, "F1_mcp_flexion": 10.0, "F1_ip_flexion": 15.0,
              "F2_mcp_flexion": 30.0, "F2_pip_flexion": 30.0, "F2_dip_flexion": 10.0}
    for names in (("FDP", "FDS", "FPL", "FCU"), ("ED", "EP", "EI", "ECR")):
        activation = np.array([float(name.startswith(names)) for name in MUSCLES])
        angles = settled(Hand(splint_deg=splint), activation, 1.0)
        held = angles[[TREE.freedom(freedom) for freedom in splint]]
        assert np.abs(held - list(splint.values())).max() < 5.0

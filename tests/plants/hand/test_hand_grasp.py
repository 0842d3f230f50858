"""A cylinder of 0.2 kg in the hand, thumb upwards; about 5 s."""

import math

import mujoco
import numpy as np
import pytest

from fesloop.hand.anthropometry import FINGERTIPS, PARTS
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.model import PALM, TOUCHES, compiled, empty_spec
from plants.hand.scene import GraspObject, Table, add_object

THUMB_UP = (0.0, 0.0, 0.0, 1.0)
OPEN = {**{f"F{i}_{joint}_flexion": angle for i in range(2, 6)
           for joint, angle in (("mcp", 0.0), ("pip", 10.0), ("dip", 5.0))},
        "F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0, "F1_cmc_pronation": 80.0, "F1_mcp_flexion": 0.0,
        "F1_ip_flexion": 0.0}
CLOSING = np.array([1.0 * name.startswith(("FDP", "FDS")) + 2.0 * name.startswith(("FPL", "THENAR"))
                    for name in MUSCLES])


FOREARM = np.where([name == "THENAR" for name in MUSCLES], 0.0, CLOSING)
OPPOSED = {"F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0, "F1_cmc_pronation": 110.0}
"""As an opponens splint holds the thumb."""


def holding(level, seconds, step_ms=1.0, release_s=1e3, ramp_s=1.0, closing=CLOSING, held=None, **parameters):
    """(plant, state, angles, object's places) every 20 ms: fingers close, the table sinks at 1.5 s."""
    place = (-0.008, 0.105, 0.0)
    plant = Hand(
        forearm_orientation=THUMB_UP, rest_deg=OPEN,
        splint_deg={"wrist_flexion": -20.0, "wrist_abduction": 0.0, **(held or {})}, step_ms=step_ms,
        object=GraspObject(size_mm=(50.0, 120.0), mass_kg=0.2, position_m=place),
        table=Table(height_m=-0.0601, centre_m=place[:2], half_m=(0.04, 0.04), lowered_at_s=1.5),
        **parameters)
    state, angles, places = plant.init(Context("hand")), [], []
    for k in range(round(50 * seconds)):
        share = np.interp(0.02 * k, (0.0, ramp_s, release_s, release_s + 0.2), (0.0, 1.0, 1.0, 0.0))
        plant.advance(state, [level * share * closing], 20_000_000 * k, 20_000_000 * (k + 1))
        seen = plant.read(state, [])
        angles.append(np.degrees(seen[0]))
        places.append(seen[10])
    return plant, state, np.array(angles), np.array(places)


@pytest.fixture(scope="module")
def held():
    return holding(0.1, 7.5, release_s=7.0)


def test_a_cylinder_is_held_for_five_seconds_without_the_table_and_dropped_when_muscles_relax(held):
    _, _, _, places = held
    assert np.abs(places[100:350, 2]).max() < 0.02
    assert places[-1, 2] < -0.1


def test_what_the_fingers_carry_is_the_cylinders_weight():
    plant, state, _, places = holding(0.1, 4.0)
    assert np.abs(places[-1] - places[-25]).max() < 0.002
    model, data = plant.model, state.data
    carried, parts = np.zeros(3), dict.fromkeys(PARTS, 0.0)
    for i, contact in enumerate(data.contact):
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, i, force)
        names = [model.geom(geom).name for geom in contact.geom]
        for name in names:
            part = name if name in PARTS else "palm"
            parts[part] += force[0] * (name not in ("object", "table"))
        if "object" in names:
            # The contact's frame points from the first geom to the second.
            sign = 1.0 if names[1] == "object" else -1.0
            carried += sign * contact.frame.reshape(3, 3).T @ force[:3]
    assert np.allclose(carried, [0.0, 0.0, 0.2 * 9.80665], rtol=0, atol=0.1)
    assert np.allclose(plant.read(state, [])[8], list(parts.values()), rtol=0, atol=1e-9)
    assert max(parts[tip] for tip in FINGERTIPS) > 0.5
    assert parts["palm"] > 0.5


def test_the_object_is_pressed_by_the_parts_that_it_touches():
    """By MuJoCo's own account; the object presses a part by no more than all that touches it."""
    plant, state, *_ = holding(0.1, 4.0)
    values = dict(zip([port.name for port in plant.outputs], plant.read(state, []), strict=True))
    model, data, force = plant.model, state.data, np.zeros(6)
    total = 0.0
    for i in range(data.ncon):
        names = {model.geom(geom).name for geom in data.contact[i].geom}
        if "object" in names and "table" not in names:
            mujoco.mj_contactForce(model, data, i, force)
            total += force[0]
    assert values["object_force"].sum() == pytest.approx(total, rel=1e-12)
    assert total > 2.0
    parts = dict(zip(PARTS, values["object_force"], strict=True))
    assert parts["palm"] > 0.5
    assert (values["object_force"] <= values["contact_force"] + 1e-9).all()


@pytest.mark.parametrize("stiffness", [10.0, 100.0])
def test_what_friction_holds_creeps_at_a_speed_inversely_proportional_to_its_stiffness(stiffness):
    """A block on a slope of 25 deg, whose friction would hold it to 38 deg."""
    speeds = []
    for each in (stiffness, 2.0 * stiffness):
        spec = empty_spec(1e-3)
        spec.worldbody.add_geom(name="slope", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1.0, 1.0, 0.1],
                                contype=PALM, conaffinity=TOUCHES[PALM])
        add_object(spec, GraspObject(shape="block", size_mm=(60.0, 60.0, 40.0), position_m=(0.0, 0.0, 0.02),
                                     friction_stiffness=each))
        slope = math.radians(25.0)
        spec.option.gravity = [9.80665 * math.sin(slope), 0.0, -9.80665 * math.cos(slope)]
        model = compiled(spec)
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 1000)
        start = data.qpos[0]
        mujoco.mj_step(model, data, 1000)
        speeds.append(data.qpos[0] - start)
    assert speeds[0] / speeds[1] == pytest.approx(2.0, rel=0.05)


def test_without_contact_nothing_presses():
    plant = Hand(object=GraspObject(position_m=(0.0, 0.1, -0.3)), table=Table(height_m=-0.37))
    state = plant.init(Context("hand"))
    plant.advance(state, [np.zeros(len(MUSCLES))], 0, 20_000_000)
    assert not plant.read(state, [])[-1].any()


def test_halving_the_step_changes_a_grasp_by_less_than_a_degree():
    usual, fine = (holding(0.05, 4.0, step_ms)[2] for step_ms in (1.0, 0.5))
    assert np.ptp(usual, axis=0).max() > 30.0
    assert np.abs(usual - fine).max() < 1.0


def test_in_an_opponens_splint_the_long_flexor_alone_sets_the_thumb_against_the_fingers():
    """Without a splint, and without the thenar group, the thumb bends past the cylinder's side."""
    free, opposed = (holding(0.1, 4.0, closing=FOREARM, held=held) for held in ({}, OPPOSED))
    tips = [PARTS.index(tip) for tip in FINGERTIPS]
    pressed = [plant.read(state, [])[8][tips] for plant, state, *_ in (free, opposed)]
    assert pressed[0][0] < 0.5
    assert pressed[1][0] > 3.0
    assert pressed[1][1:].max() > 0.5
    assert np.abs(opposed[3][-1] - opposed[3][-25]).max() < 0.002


@pytest.mark.parametrize(("shape", "size_mm", "half_height"), [
    ("cylinder", (40.0, 60.0), 0.03), ("block", (40.0, 50.0, 60.0), 0.03), ("ball", (50.0,), 0.025),
    ("card", (54.0, 86.0, 1.0), 0.0005)])
def test_every_object_stands_on_the_table(shape, size_mm, half_height):
    plant = Hand(object=GraspObject(shape=shape, size_mm=size_mm, position_m=(0.0, 0.1, -0.3 + half_height)),
                 table=Table(height_m=-0.3))
    state = plant.init(Context("hand"))
    plant.advance(state, [np.zeros(len(MUSCLES))], 0, 500_000_000)
    seen = plant.read(state, [])
    assert np.allclose(seen[10], [0.0, 0.1, -0.3 + half_height], rtol=0, atol=2e-3)
    assert np.allclose(np.abs(seen[11]), [1.0, 0.0, 0.0, 0.0], rtol=0, atol=0.02)
    # The table is hard: skin would let it sink by millimetres.
    assert abs(seen[10][2] - (half_height - 0.3)) < 2e-4

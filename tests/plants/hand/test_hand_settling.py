"""Hands that settle before the start, against MuJoCo that is stepped for each of them anew."""

import mujoco
import numpy as np
import pytest

from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.contract import HandState, evaluate, step
from plants.hand.plant import settled
from plants.hand.tendons import Tendons

STEPS = 200


def stepped(plant, positions, steps):
    data = mujoco.MjData(plant.model)
    data.qpos[:] = positions
    tendons = Tendons.of(plant.model)
    if tendons is not None:
        tendons.rest(data)
    for _ in range(steps):
        plant.pull(data, np.zeros(29))
        mujoco.mj_step(plant.model, data)
    data.time = 0.0
    return data


def gone_on(plant, data, steps=300):
    """Where data get to under half activation, and what is sensed there."""
    state = HandState(data)
    for _ in range(steps):
        plant.pull(data, np.full(29, 0.5))
        step(plant.model, state)
    evaluate(plant.model, state)
    return np.concatenate([data.qpos, data.qvel, data.qacc, data.sensordata])


@pytest.mark.parametrize("parameters", [
    {}, {"tendon_strain": 0.0}, {"strength": (0.5,) * 29}, {"step_ms": 0.5},
    {"elastic_deg": {"wrist_flexion": -20.0}}])
def test_a_hand_that_settles_again_goes_on_as_one_that_was_stepped(parameters):
    plant = Hand(**parameters)
    positions = plant.model.qpos0.copy()
    for _ in range(2):
        found, true = settled(plant.model, positions, STEPS), stepped(plant, positions, STEPS)
        assert found.time == true.time == 0.0
        assert np.array_equal(gone_on(plant, found), gone_on(plant, true))


def test_hands_that_differ_in_one_number_settle_apart():
    def posture(**parameters):
        hand = Hand(settle_s=0.3, **parameters)
        return hand.init(Context("hand")).data.qpos.copy()

    usual = posture()
    for changed in ({"stiffness": 1.01}, {"passive_tension": 1.01}, {"tendon_strain": 0.034},
                    {"start_deg": {"wrist_flexion": 5.0}},
                    {"forearm_orientation": (1.0, 0.0, 0.0, 0.0)}):
        assert not np.array_equal(posture(**changed), usual)
        assert np.array_equal(posture(), usual)
    longer = Hand(settle_s=0.4).init(Context("hand")).data.qpos
    assert not np.array_equal(longer, usual)


def test_each_start_is_a_state_of_its_own():
    hand = Hand(settle_s=0.1)
    one, other = hand.init(Context("hand")), hand.init(Context("hand"))
    before = other.data.qpos.copy()
    one.data.qpos[:] = 1.0
    assert np.array_equal(other.data.qpos, before)
    assert np.array_equal(hand.init(Context("hand")).data.qpos, before)

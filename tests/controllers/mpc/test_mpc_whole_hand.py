"""Predictive control of three synergies by eight channels, from a patient's model file."""

from time import thread_time

import numpy as np
import pytest
from scipy.linalg import expm

from controllers.mpc import Mpc
from controllers.mpc.strength_adaptation import StrengthAdaptation
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.linear_model import LinearModel, Recruitment
from fesloop.models.patient_model import PatientModel, load_patient_model

MS, PERIOD_S, HORIZON, CHANNELS = 1_000_000, 0.025, 20, 8
OUTPUTS = ("wrist_extension", "finger_flexion", "thumb_flexion")
GAIN_DEG = np.array([  # at full recruitment: two wrist extensors, two of fingers, three flexors, thumb
    [55.0, 45.0, 30.0, 20.0, -35.0, -30.0, -25.0, -5.0],
    [10.0, 5.0, -50.0, -40.0, 60.0, 70.0, 50.0, 5.0],
    [0.0, 3.0, -10.0, -5.0, 5.0, 15.0, 10.0, 55.0]])
REST_DEG = np.array([-20.0, 30.0, 10.0])
TOLD_DRIVE = np.array([0.5, 0.3, 0.1, 0.1, 0.3, 0.4, 0.2, 0.4])
GOAL_DEG = REST_DEG + GAIN_DEG @ TOLD_DRIVE


def hand(factors=None, late_ms=37.5):
    """Activation of second order a channel, joints of second order an output; `factors` on each gain."""
    gain = np.radians(GAIN_DEG) * (np.ones_like(GAIN_DEG) if factors is None else factors)
    muscles, joints = 2 * CHANNELS, 2 * len(OUTPUTS)
    a, b = np.zeros((muscles + joints, muscles + joints)), np.zeros((muscles + joints, CHANNELS))
    for i in range(CHANNELS):
        rate = 14.0 + i
        a[2 * i:2 * i + 2, 2 * i:2 * i + 2] = [[0.0, 1.0], [-rate**2, -2.0 * rate]]
        b[2 * i + 1, i] = rate**2
    for j in range(len(OUTPUTS)):
        rate, at = 9.0 + 2.0 * j, muscles + 2 * j
        a[at:at + 2, at:at + 2] = [[0.0, 1.0], [-rate**2, -1.6 * rate]]
        a[at + 1, 0:muscles:2] = rate**2 * gain[j]
    c = np.zeros((len(OUTPUTS), muscles + joints))
    c[:, muscles::2] = np.eye(len(OUTPUTS))
    return LinearModel(a=a, b=b, c=c, offset=np.radians(REST_DEG), delay_ns=round(late_ms * MS),
                       recruitment=Recruitment(threshold_ma=(9.0,) * CHANNELS, spread=(0.3,) * CHANNELS))


@pytest.fixture
def told(tmp_path):
    """The model as a controller gets it: from a file."""
    PatientModel(patient="p", source="s", outputs=OUTPUTS, electrodes=(), current_ma=(30.0,) * CHANNELS,
                 rate="40", model=hand(), operating_drive=TOLD_DRIVE,
                 operating_outputs=np.radians(GOAL_DEG)).save(tmp_path / "model.toml")
    return load_patient_model(tmp_path / "model.toml")


def controller(told, **changes):
    return Mpc(**{"model": told.model, "current_ma": told.current_ma, "horizon": HORIZON} | changes)


def closed_loop(mpc, patient, goal_deg=GOAL_DEG, seconds=8.0, late_ticks=2, wall_deg=np.inf, felt=None):
    """Outputs in deg and drives a tick, times of the steps in s, statuses; samples `late_ticks` old.

    Fingers flex up to `wall_deg`; how far they would go beyond it is felt at 1 N a deg, times `felt`.
    """
    clock = RateClock.from_rate("40")
    state, tick = mpc.init(Context("mpc", clock=clock)), Tick()
    states = patient.a.shape[0]
    stacked = np.zeros((states + CHANNELS,) * 2)
    stacked[:states, :states], stacked[:states, states:] = patient.a, patient.b
    # Half a period at a time: the delay is a whole number of halves.
    half, waiting = expm(stacked * PERIOD_S / 2), round(patient.delay_ns / (12.5 * MS))
    x, sent, seen, drives, took = np.zeros(states), [np.zeros(CHANNELS)] * waiting, [], [], []
    unwired = Sample(np.zeros((HORIZON, 3)), NEVER, NEVER, NEVER)
    for k in range(round(seconds / PERIOD_S)):
        now = tick.time_ns = clock.tick(k)
        seen.append(patient.c @ x + patient.offset)
        beyond_deg = max(np.degrees(seen[-1][1]) - wall_deg, 0.0)
        seen[-1][1] -= np.radians(beyond_deg)
        force = unwired if felt is None else Sample(np.full(5, felt * beyond_deg), now, now, now)
        captured = clock.tick(max(k - late_ticks, 0))
        inputs = (unwired, Sample(np.radians(goal_deg), now, now, now),
                  Sample(seen[max(k - late_ticks, 0)], captured, captured, now), force)
        started = thread_time()
        pulses = mpc.step(state, inputs, tick)[0]
        took.append(thread_time() - started)
        drives.append(patient.recruitment.fraction(pulses))
        for _ in range(2):
            sent.append(drives[-1])
            x = (half @ np.concatenate([x, sent.pop(0)]))[:states]
    return np.degrees(seen), np.array(drives), np.array(took), {status for status, _ in tick.reports}


def mismatches():
    rng = np.random.default_rng(3)
    yield "all 30 % weaker", np.full((3, CHANNELS), 0.7)
    yield "all 30 % stronger", np.full((3, CHANNELS), 1.3)
    yield "each channel its own way", np.tile(np.array([0.7, 1.3] * 4), (3, 1))
    for i in range(3):
        yield f"each gain at random, {i}", rng.uniform(0.7, 1.3, (3, CHANNELS))


@pytest.mark.parametrize("adaptation", [None, StrengthAdaptation()], ids=["fixed", "adapted"])
@pytest.mark.parametrize(("how", "factors"), list(mismatches()))
def test_leaves_less_than_half_a_degree_with_gains_30_per_cent_off(told, how, factors, adaptation):
    outputs, _, _, statuses = closed_loop(controller(told, adaptation=adaptation), hand(factors))
    assert np.abs(outputs[-40:] - GOAL_DEG).max() < 0.5
    assert statuses <= {"saturated"}


@pytest.mark.slow
def test_is_well_posed_and_quick(told):
    mpc = controller(told)
    plan = mpc.init(Context("mpc", clock=RateClock.from_rate("40"))).candidates[0].plan
    assert np.linalg.cond(plan.hessian) < 1e6
    _, _, took, _ = closed_loop(mpc, hand(), seconds=3.0)
    assert np.median(took[20:]) < 0.1 * PERIOD_S


@pytest.mark.slow
def test_cocontraction_goes_where_it_moves_nothing(told):
    """Five of eight directions of drive move no output; what is left of them costs no accuracy."""
    free = {"cocontraction_weight": 0.0}
    _, wasteful, _, _ = closed_loop(controller(told, **free), hand(), goal_deg=GOAL_DEG)
    outputs, spare, _, _ = closed_loop(controller(told, cocontraction_weight=1e-3), hand(), goal_deg=GOAL_DEG)
    assert np.linalg.norm(spare[-1]) < np.linalg.norm(wasteful[-1])
    assert np.abs(outputs[-1] - GOAL_DEG).max() < 0.1


def test_an_output_of_great_weight_is_kept_where_not_all_can_be(told):
    beyond = GOAL_DEG + np.array([60.0, 60.0, 0.0])
    errors = {}
    for name, weights in (("wrist", (100.0, 1.0, 1.0)), ("fingers", (1.0, 100.0, 1.0))):
        outputs, _, _, _ = closed_loop(controller(told, output_weight=weights), hand(), goal_deg=beyond)
        errors[name] = np.abs(outputs[-1] - beyond)
    assert errors["wrist"][0] < 0.2 * errors["fingers"][0]
    assert errors["fingers"][1] < 0.2 * errors["wrist"][1]


WALL = {"wall_deg": GOAL_DEG[1] - 15.0}
GRASPING = {"grasping_outputs": (1, 2)}


def test_what_an_object_blocks_winds_nothing_up(told):
    """Where contact is felt the drives are those of free motion; where not, they end at their limits."""
    _, free, _, _ = closed_loop(controller(told), hand())
    held, grasping, _, statuses = closed_loop(controller(told, **GRASPING), hand(), felt=1.0, **WALL)
    _, unfelt, _, _ = closed_loop(controller(told, **GRASPING), hand(), **WALL)
    assert np.abs(grasping[-1] - free[-1]).max() < 0.15
    assert unfelt[-1].max() > 0.9 > 1.5 * grasping[-1].max()
    assert held[-1, 1] == pytest.approx(WALL["wall_deg"])
    assert statuses == {"contact"}


def test_a_wrist_stays_controlled_while_fingers_are_blocked(told):
    weaker = np.ones((3, CHANNELS))
    weaker[0] = 0.7
    outputs, _, _, _ = closed_loop(controller(told, **GRASPING), hand(weaker), felt=1.0, **WALL)
    assert np.abs(outputs[-40:, 0] - GOAL_DEG[0]).max() < 0.5


def test_strengths_are_not_learnt_from_what_is_blocked(told):
    mpc = controller(told, adaptation=StrengthAdaptation(), **GRASPING)
    _, drives, _, _ = closed_loop(mpc, hand(), felt=1.0, **WALL)
    _, misled, _, _ = closed_loop(mpc, hand(), **WALL)
    _, free, _, _ = closed_loop(mpc, hand())
    assert np.abs(drives[-1] - free[-1]).max() < 0.15 < np.abs(misled[-1] - free[-1]).max()


def test_forces_that_are_not_finite_are_told(told):
    _, _, _, statuses = closed_loop(controller(told, **GRASPING), hand(), seconds=1.0, felt=np.nan)
    assert statuses == {"no_force"}


@pytest.mark.slow
def test_channels_that_grasp_do_not_lift_a_wrist(told):
    """They are given what the model alone needs, whatever the wrist does; the others lift it."""
    weaker = np.ones((3, CHANNELS))
    weaker[0] = 0.6
    mpc = controller(told, grasping_channels=tuple(range(2, CHANNELS)), **GRASPING)
    outputs, drives, _, statuses = closed_loop(mpc, hand(weaker), felt=1.0, **WALL)
    _, of_model, _, _ = closed_loop(mpc, hand(), felt=1.0, **WALL)
    np.testing.assert_allclose(drives[-1, 2:], drives[-40, 2:], atol=0.01)
    assert np.abs(drives[-1, :2] - of_model[-1, :2]).max() > 0.1
    assert np.abs(outputs[-40:, 0] - GOAL_DEG[0]).max() < 0.5
    assert statuses == {"contact"}


@pytest.mark.parametrize(("where", "value"), [
    ("grasping_channels", (8,)), ("grasping_outputs", (3,)), ("contact_places", ("F9",)),
    ("touching_s", 0.0)])
def test_contact_that_cannot_be_is_named(told, where, value):
    with pytest.raises(InputError) as fault:
        controller(told, **{where: value})
    assert fault.value.where == where

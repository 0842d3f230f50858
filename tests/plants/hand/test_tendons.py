"""Tendons that yield: against MuJoCo's own muscles and an adaptive integrator, and limits; about 15 s."""

import copy
import math
import pickle
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.block import Context
from plants.hand import Hand
from plants.hand.model import ECCENTRIC, FASTEST, FIBRES_MM, LONGEST, SHORTEST
from plants.hand.model import muscles as hand_muscles
from plants.hand.tendons import (
    DAMPING,
    STRAIN,
    TENDON_MM,
    TOE,
    advance,
    fibre_rates,
    fibres,
    passive,
    rate,
    stretched,
    tendon,
)

STEP_S = 1e-3
ROWS = {name: (1e-3 * row.fibre_mm, row.passive_n_m * 1e-3 * row.fibre_mm / (0.12 * row.force_n))
        for name, row in zip(MUSCLES, hand_muscles(), strict=True)}
"""Fibre length, m, and passive share of each muscle."""


def mujocos(length, velocity, active, share):
    """Force of MuJoCo's muscle at a relative length and velocity, over the greatest one."""
    knee = 0.5 * (LONGEST - 1.0)
    parameters = np.array([1.0, 2.0, 1.0, 1.0, SHORTEST, LONGEST, 1.0, max(1e-12, 2.0 * share * knee**2),
                           ECCENTRIC])
    gain = mujoco.mju_muscleGain(length, velocity, np.array([1.0, 2.0]), 1.0, parameters)
    return -active * gain - mujoco.mju_muscleBias(length, np.array([1.0, 2.0]), 1.0, parameters)


def pull(stretch):
    """Tendon force by the docstring's words."""
    end = 2.0 * TOE / (1.0 + TOE)
    return TOE * (max(0.0, stretch) / end) ** 2 if stretch < end else TOE + (1.0 + TOE) * (stretch - end)


def exact(times, whole, level, fibre, yields, share, start):
    """Tendon forces (n,) by an adaptive integrator; `whole` linear, `level` constant between `times`."""
    forces, length = [pull((whole[0] - fibre * start) / yields)], start
    for k, (a, b) in enumerate(pairwise(times)):
        def slope(t, y, a=a, b=b, k=k):
            at = whole[k] + (whole[k + 1] - whole[k]) * (t - a) / (b - a)
            borne = pull((at - fibre * y[0]) / yields)
            return [FASTEST * brentq(lambda v: mujocos(y[0], v, level[k], share) + DAMPING * v - borne,
                                     -1e4, 1e4, xtol=1e-13)]

        with np.errstate(divide="ignore"):  # where its error is 0
            length = solve_ivp(slope, (a, b), [length], "Radau", rtol=1e-6, atol=1e-8).y[0, -1]
        forces.append(pull((whole[k + 1] - fibre * length) / yields))
    return np.array(forces)


@st.composite
def courses(draw):
    """A muscle and 40 ms of it: two ramps below the fastest shortening, activation that switches twice."""
    name = draw(st.sampled_from(MUSCLES))
    fibre, share = ROWS[name]
    yields = 1e-3 * TENDON_MM[name] * draw(st.floats(0.02, 0.06))
    on = draw(st.integers(0, 20))
    off = draw(st.integers(on + 1, 40))
    level = np.where((np.arange(41) >= on) & (np.arange(41) < off), draw(st.floats(0.02, 1.0)), 0.0)
    start, turn = draw(st.floats(0.7, 1.4)), draw(st.integers(5, 35))
    speeds = draw(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
    relative = start + STEP_S * FASTEST * np.where(
        np.arange(41) < turn, speeds[0] * np.arange(41),
        speeds[0] * turn + speeds[1] * (np.arange(41) - turn))
    return fibre, yields, share, STEP_S * np.arange(41), fibre * relative, level, min(start, 1.0)


def stepped(fibre, yields, share, whole, level, start):
    """Tendon forces (n,) by the kernel's steps."""
    length, forces = start, [pull((whole[0] - fibre * start) / yields)]
    for before, after, active in zip(whole[:-1], whole[1:], level[:-1], strict=True):
        length = advance(length, before, after, active, share, fibre, yields, STEP_S)
        forces.append(tendon((after - fibre * length) / yields)[0])
    return np.array(forces)


def at_rest(fibre, yields, share, whole):
    """Relative length of relaxed fibres in equilibrium."""
    slack = whole / fibre
    if slack <= 1.0:
        return slack
    return brentq(lambda x: pull((whole - fibre * x) / yields) - passive(x, share)[0], 1.0, slack, xtol=1e-15)


@settings(max_examples=12, deadline=None)
@given(courses())
def test_force_is_within_the_stated_error_of_an_adaptive_integrator(course):
    fibre, yields, share, times, whole, level, _ = course
    start = at_rest(fibre, yields, share, whole[0])
    error = (stepped(fibre, yields, share, whole, level, start)
             - exact(times, whole, level, fibre, yields, share, start))
    assert np.abs(error).max() < 0.1
    assert np.sqrt(np.mean(error**2)) < 0.02


@given(st.floats(0.0, 2.0))
def test_a_tendon_has_the_published_strain_and_a_smooth_curve(stretch):
    assert tendon(1.0)[0] == pytest.approx(1.0)
    assert tendon(1.0)[1] / STRAIN == pytest.approx(37.393, rel=0.01)  # MoBL-ARMS 4.1
    force, slope = tendon(stretch)
    assert force == pytest.approx(pull(stretch), abs=1e-12)
    assert stretched(force) == pytest.approx(stretch, abs=1e-9)
    assert (tendon(stretch + 1e-6)[0] - force) / 1e-6 == pytest.approx(slope, abs=1e-4)


@given(st.floats(0.05, 1.9), st.floats(0.0, 3.0), st.floats(0.0, 1.5), st.floats(0.001, 0.3))
@settings(max_examples=300)
def test_a_rate_of_the_fibres_is_where_mujocos_muscle_bears_the_force(length, force, active, share):
    speed, over_length, over_force = rate(length, force, active, share)
    borne = mujocos(length, speed / FASTEST, active, share) + DAMPING * speed / FASTEST
    assert borne == pytest.approx(force, abs=1e-9 * max(1.0, abs(speed)))
    assert over_force > 0.0
    for place, slope in ((np.array([1e-7, 0.0]), over_length), (np.array([0.0, 1e-7]), over_force)):
        high, low = (rate(length + side * place[0], force + side * place[1], active, share)[0]
                     for side in (1.0, -1.0))
        if abs((high - speed) - (speed - low)) < 1e-3 * abs(high - low):  # no kink between them
            assert (high - low) / 2e-7 == pytest.approx(slope, rel=1e-2, abs=1e-2)


@settings(max_examples=100)
@given(st.sampled_from(MUSCLES), st.lists(st.tuples(st.floats(-1.0, 3.0), st.floats(0.0, 1.0)), min_size=2,
                                          max_size=40),
       st.floats(0.003, 0.2), st.floats(1e-4, 3.0), st.sampled_from([1e-5, 1e-3, 1e-2]))
def test_force_stays_finite_and_pulls_whatever_the_course(name, course, strain, strength, step):
    """Jumps of length in one step, fibres of no length, next to no strength and three times the usual one."""
    fibre, share = ROWS[name]
    yields, whole, length = 1e-3 * TENDON_MM[name] * strain, 0.0, 1.0
    for relative, level in course:
        length = advance(length, whole, fibre * relative, strength * level, share, fibre, yields, step)
        whole = fibre * relative
        force = tendon((whole - fibre * length) / yields)[0]
        assert math.isfinite(length)
        assert 0.0 <= force < 1e3


@settings(max_examples=60)
@given(st.sampled_from(MUSCLES), st.floats(0.6, 1.4), st.floats(0.01, 0.3), st.floats(2.0, 25.0),
       st.floats(0.0, 1.0))
def test_a_muscle_that_is_moved_to_and_fro_takes_work(name, middle, swing, hertz, level):
    """Held active, it gives none back over whole periods, once it has the same force again."""
    fibre, share = ROWS[name]
    yields = 1e-3 * TENDON_MM[name] * STRAIN
    count = round(1.0 / (hertz * STEP_S))
    whole = fibre * (middle + 0.5 * swing * np.sin(2.0 * np.pi * np.arange(8 * count + 1) / count))
    length = at_rest(fibre, yields, share, whole[0])
    forces = [tendon((whole[0] - fibre * length) / yields)[0]]
    for before, after in pairwise(whole):
        length = advance(length, before, after, level, share, fibre, yields, STEP_S)
        forces.append(tendon((after - fibre * length) / yields)[0])
    last = slice(6 * count, 8 * count + 1)
    work = np.trapezoid(forces[last], whole[last]) / fibre
    assert work > -1e-4 * swing


def test_relaxed_fibres_begin_in_equilibrium_and_stay_there():
    """Without gravity the hand rests, whatever its strength, by the forces of the resting fibres."""
    plant = Hand(strength=(0.5,) * 29, rest_deg={"wrist_flexion": -20.0})
    plant.model.opt.gravity[:] = 0.0
    state = plant.init(Context("hand"))
    start = fibres(state.data.userdata).copy()
    assert start == pytest.approx(1.06, abs=1e-9)
    plant.advance(state, [np.zeros(29)], 0, 100_000_000)
    np.testing.assert_allclose(fibres(state.data.userdata), start, rtol=0, atol=1e-9)
    np.testing.assert_allclose(state.data.qvel, 0.0, atol=1e-8)


def test_fibres_elsewhere_begin_in_equilibrium_too():
    plant = Hand(start_deg={"F2_mcp_flexion": 80.0, "wrist_flexion": -50.0})
    data = plant.init(Context("hand")).data
    start, rates = fibres(data.userdata).copy(), fibre_rates(data.userdata)
    assert np.ptp(start) > 0.3
    for _ in range(100):
        plant.pull(data, np.zeros(29))
    np.testing.assert_allclose(fibres(data.userdata), start, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rates, 0.0, atol=1e-9)


def bent(step_ms, seconds, name, level, **parameters):
    plant = Hand(step_ms=step_ms, **parameters)
    state, rows = plant.init(Context("hand")), []
    activation = np.array([level * each.startswith(name) for each in MUSCLES])
    for k in range(round(1e2 * seconds)):
        plant.advance(state, [activation], 10_000_000 * k, 10_000_000 * (k + 1))
        rows.append(np.degrees(plant.glance(state)[0]))
    return np.array(rows), plant, state


def test_fibres_and_tendons_make_up_the_whole_muscle():
    """Fibres shorten as their rates say, and further than the whole muscle as the tendon stretches."""
    _, plant, state = bent(1.0, 0.5, ("FDP", "FDS"), 0.3, splint_deg={"wrist_flexion": 0.0})
    before, lengths = fibres(state.data.userdata).copy(), state.data.ten_length.copy()
    plant.advance(state, [np.zeros(29)], 500_000_000, 501_000_000)
    moved = fibres(state.data.userdata) - before
    np.testing.assert_allclose(moved, STEP_S * plant.read(state, [])[9], rtol=0, atol=1e-12)
    row, start = plant.model.tendon("FDP3").id, plant.init(Context("hand")).data
    mujoco.mj_forward(plant.model, start)
    whole = lengths[row] - start.ten_length[row]
    shortened = 1e-3 * FIBRES_MM["FDP3"] * (fibres(start.userdata) - before)[muscle("FDP3")]
    assert 1e-3 < shortened + whole < 1e-3 * TENDON_MM["FDP3"] * STRAIN


def test_the_stiffer_the_tendons_the_more_the_hand_moves_as_with_mujocos_muscles():
    mujocos_own = bent(0.5, 0.6, ("FDP", "FDS", "FPL"), 0.1, tendon_strain=0.0)[0]
    apart = [np.abs(bent(0.5, 0.6, ("FDP", "FDS", "FPL"), 0.1, tendon_strain=strain)[0] - mujocos_own).max()
             for strain in (0.033, 0.01, 0.003)]
    assert apart[0] > apart[1] > apart[2]
    assert apart[2] < 4.0


@pytest.mark.slow
@pytest.mark.parametrize(("strain", "level", "most"), [
    (STRAIN, 0.05, 0.7), (STRAIN, 0.3, 2.0), (0.049, 0.3, 2.0)])
def test_a_step_of_a_millisecond_is_near_one_of_a_tenth(strain, level, most):
    """In a sudden fist, whose fibres are all activated at once."""
    usual, fine = (bent(step, 0.5, ("FDP", "FDS", "FPL"), level, tendon_strain=strain)[0]
                   for step in (1.0, 0.1))
    assert np.ptp(usual, axis=0).max() > 60.0
    assert np.abs(usual - fine).max() < most
    assert np.sqrt(np.mean((usual - fine) ** 2)) < 0.2 * most


def test_a_snapshot_has_the_fibres():
    plant = Hand()
    activation = np.array([0.2 * name.startswith("FD") for name in MUSCLES])
    state = plant.init(Context("hand"))
    plant.advance(state, [activation], 0, 60_000_000)
    others = pickle.loads(pickle.dumps(state)), copy.deepcopy(state)
    memory = state.data.userdata.copy()
    plant.advance(state, [activation], 60_000_000, 120_000_000)
    assert np.abs(fibres(state.data.userdata) - fibres(memory)).max() > 0.02
    for other in others:
        np.testing.assert_array_equal(other.data.userdata, memory)
        plant.advance(other, [activation], 60_000_000, 120_000_000)
        np.testing.assert_array_equal(other.data.userdata, state.data.userdata)
        np.testing.assert_array_equal(other.data.qpos, state.data.qpos)


def test_a_weak_muscle_pulls_as_a_strong_one_that_is_less_active():
    """Its tendon is that of the healthy muscle."""
    posture, level = np.array(Hand().outputs[0].initial_value()), np.full(29, 0.3)
    strong, weak = (Hand(strength=(factor,) * 29).held_moments(posture, level / factor)
                    for factor in (1.0, 0.5))
    np.testing.assert_allclose(weak, strong, rtol=0, atol=1e-9)
    assert np.abs(strong - Hand().held_moments(posture, 0.5 * level)).max() > 0.1

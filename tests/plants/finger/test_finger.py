"""The finger plant: against an adaptive integrator of its physics, closed forms and published behaviour."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.models.linear_model import Recruitment
from plants.finger import Finger
from plants.finger.dynamics import chain_mass_matrix
from plants.muscles.lags import Fatigue

CONTEXT = Context("finger")
MS = 1_000_000


def stimulation(*levels_ma: float, width_us: float = 300.0) -> np.ndarray:
    return np.array([[1e-3 * level, 1e-6 * width_us] for level in levels_ma])


PULSES = {0: stimulation(14, 4, 0, 0), 13 * MS + 1: stimulation(0, 18, 9, 12),
          40 * MS: stimulation(30, 30, 0, 3, width_us=80), 61 * MS + 77: stimulation(0, 0, 25, 0)}


def simulate(finger: Finger, schedule: dict, stops_ns: list[int], state=None):
    """Outputs at each stop, the inputs of the schedule latched at their instants."""
    state = state or finger.init(CONTEXT)
    now, held, seen = 0, [np.zeros((4, 2))], []
    for stop in stops_ns:
        for instant in sorted(t for t in schedule if now <= t < stop):
            if instant > now:
                finger.advance(state, held, now, instant)
                now = instant
            held = [schedule[instant]]
        finger.advance(state, held, now, stop)
        now = stop
        seen.append(np.concatenate(finger.read(state, held)))
    return np.array(seen)


def integrate(finger: Finger, schedule: dict, stop_ns: int) -> np.ndarray:
    """Angles, rates, accelerations, activation at `stop_ns`, from the physics as text books write it."""
    delay = round(finger.delay_ms * MS)
    arms, force = np.array(finger.moment_arms_mm) / 1000, np.array(finger.force_n)
    mass = chain_mass_matrix(np.array(finger.lengths_mm) / 1000, np.array(finger.radii_mm) / 1000,
                             finger.density, np.radians(finger.rest_deg))
    rest, wn = np.radians(finger.rest_deg), np.array(finger.activation_rad_s)

    def acceleration(y):
        alpha, q, rate = y[:4], y[8:11], y[11:14]
        torque = sum(arms[m] * force[m] * alpha[m] for m in range(4))
        torque = torque - np.array(finger.damping) * rate - np.array(finger.stiffness) * (q - rest)
        return np.linalg.solve(mass, torque)

    def slope(_, y, v):
        return np.concatenate([y[4:8], wn**2 * (v - y[:4]) - 2 * wn * y[4:8], y[11:14], acceleration(y)])

    y, now, v = np.concatenate([np.zeros(8), rest, np.zeros(3)]), 0, np.zeros(4)
    arrivals = {t + delay: finger.recruited(u) for t, u in schedule.items()}
    for instant in [*sorted(t for t in arrivals if t < stop_ns), stop_ns]:
        if instant > now:
            y = solve_ivp(slope, (0.0, (instant - now) * 1e-9), y, "DOP853", args=(v,),
                          rtol=1e-12, atol=1e-14).y[:, -1]
            now = instant
        v = arrivals.get(instant, v)
    return np.concatenate([y[8:14], acceleration(y), y[:4]])


@pytest.mark.parametrize("parameters", [
    {}, {"delay_ms": 0.0}, {"delay_ms": 33.333333, "activation_rad_s": (20.0, 22.0, 25.0, 30.0)},
    {"rest_deg": (0.0, 40.0, -5.0), "recruitment_curve": "linear"}])
def test_it_agrees_with_an_adaptive_integrator(parameters: dict) -> None:
    finger = Finger(**parameters)
    found = simulate(finger, PULSES, [31 * MS, 150 * MS + 3])[-1]
    expected = integrate(finger, PULSES, 150 * MS + 3)
    np.testing.assert_allclose(found[:6], expected[:6], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[6:9], expected[6:9], rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[9:], expected[9:], rtol=0, atol=1e-9)


def test_activation_is_the_critically_damped_step_response_delayed_to_the_nanosecond() -> None:
    finger = Finger(recruitment_curve="linear", full_scale_us=300.0)
    for late_ns in (0, 1, 1_000, 25 * MS, 300 * MS):
        activation = simulate(finger, {7: stimulation(10, 0, 0, 0)}, [7 + 20 * MS + late_ns])[-1, 9]
        wt = 25.0 * late_ns * 1e-9
        assert activation == pytest.approx(-math.expm1(-wt) - wt * math.exp(-wt), rel=1e-6, abs=1e-15)


instants = st.lists(st.integers(1, 199 * MS), max_size=8)


@pytest.mark.slow
@pytest.mark.parametrize("fatigue", [None, Fatigue(fatigue_s=1.0)])
@given(cuts=instants)
@settings(max_examples=8, deadline=None)
def test_splitting_an_advance_changes_nothing(fatigue: Fatigue | None, cuts: list[int]) -> None:
    finger = Finger(fatigue=fatigue)
    whole = simulate(finger, PULSES, [200 * MS])[-1]
    split = simulate(finger, PULSES, [*sorted(cuts), 200 * MS])[-1]
    np.testing.assert_allclose(split[:6], whole[:6], rtol=0, atol=1e-12)
    np.testing.assert_allclose(split[6:9], whole[6:9], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(split[9:], whole[9:], rtol=0, atol=1e-12)


@pytest.mark.parametrize("fatigue", [None, Fatigue(fatigue_s=1.0)])
@given(start=st.integers(1, 90 * MS), later=st.lists(st.integers(0, 120 * MS), min_size=1, max_size=12))
@settings(max_examples=8, deadline=None)
def test_observing_equals_advancing_a_copy_and_touches_nothing(
    fatigue: Fatigue | None, start: int, later: list[int]
) -> None:
    finger = Finger(fatigue=fatigue)
    state = finger.init(CONTEXT)
    simulate(finger, PULSES, [start], state)
    new = stimulation(3, 22, 11, 0)
    before = pickle.dumps(state)
    times = [start + step for step in sorted(later)]
    stacks = finger.observe(state, [new], start, times)
    assert pickle.dumps(state) == before
    for k, time_ns in enumerate(times):
        copy = pickle.loads(before)
        finger.advance(copy, [new], start, time_ns)
        for stack, value in zip(stacks, finger.read(copy, [new]), strict=True):
            np.testing.assert_array_equal(stack[k], value)


@given(stop=st.integers(1, 120 * MS))
@settings(max_examples=8, deadline=None)
def test_a_pickled_state_goes_on_with_the_same_bits(stop: int) -> None:
    finger = Finger(fatigue=Fatigue())
    state = finger.init(CONTEXT)
    held = [stimulation(14, 4, 2, 0)]
    finger.advance(state, held, 0, stop)
    twin, again, held_again = pickle.loads(pickle.dumps((finger, state, [held[0].copy()])))
    finger.advance(state, held, stop, 200 * MS + 1)
    twin.advance(again, held_again, stop, 200 * MS + 1)
    for value, other in zip(finger.read(state, held), twin.read(again, held_again), strict=True):
        np.testing.assert_array_equal(value, other)


def test_an_equal_input_sent_again_splits_nothing() -> None:
    finger = Finger()
    once, often = finger.init(CONTEXT), finger.init(CONTEXT)
    finger.advance(once, [PULSES[0]], 0, 30 * MS)
    finger.advance(often, [PULSES[0]], 0, 30 * MS)
    finger.advance(once, [PULSES[0]], 30 * MS, 100 * MS)
    finger.advance(often, [PULSES[0].copy()], 30 * MS, 100 * MS)
    assert not often.arriving
    np.testing.assert_array_equal(once.z, often.z)


def test_speed_scales_time_and_leaves_statics() -> None:
    schedule = {0: PULSES[0]}
    slow = simulate(Finger(delay_ms=0.0), schedule, [100 * MS, 5_000 * MS])
    fast = simulate(Finger(delay_ms=0.0, speed=1.25), schedule, [80 * MS, 4_000 * MS])
    np.testing.assert_allclose(fast[:, :3], slow[:, :3], atol=1e-11)
    np.testing.assert_allclose(fast[:, 3:6], 1.25 * slow[:, 3:6], atol=1e-10)


def test_strength_scales_the_excursion() -> None:
    weak, strong = (simulate(Finger(strength=s), PULSES, [150 * MS])[-1, :3] for s in (1.0, 1.2))
    rest = np.radians(Finger().rest_deg)
    np.testing.assert_allclose(strong - rest, 1.2 * (weak - rest), atol=1e-12)


def test_the_mass_matrix_of_the_straight_chain_is_that_of_parallel_axes() -> None:
    lengths, radii = np.array([0.045, 0.027, 0.018]), np.array([0.008, 0.007, 0.006])
    masses = 1100 * math.pi * radii**2 * lengths
    joints, centres = np.array([0.0, 0.045, 0.072]), np.array([0.0225, 0.0585, 0.081])
    expected = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(max(i, j), 3):
                spin = masses[k] * (lengths[k]**2 / 12 + radii[k]**2 / 4)
                expected[i, j] += spin + masses[k] * (centres[k] - joints[i]) * (centres[k] - joints[j])
    np.testing.assert_allclose(chain_mass_matrix(lengths, radii, 1100, np.zeros(3)), expected, rtol=1e-13)


@given(angles=st.tuples(*[st.floats(-1.5, 1.5)] * 3), rates=st.tuples(*[st.floats(-5, 5)] * 3))
@settings(max_examples=30, deadline=None)
def test_the_mass_matrix_gives_the_kinetic_energy_of_the_moving_cylinders(angles, rates) -> None:
    lengths, radii = np.array([0.045, 0.027, 0.018]), np.array([0.008, 0.007, 0.006])
    q, w, h = np.array(angles), np.array(rates), 1e-6
    masses = 1100 * math.pi * radii**2 * lengths

    def centres(time):
        turned, end, found = 0.0, 0j, []
        for k in range(3):
            turned += q[k] + w[k] * time
            along = lengths[k] * np.exp(1j * turned)
            found.append(end + along / 2)
            end += along
        return np.array(found)

    velocities = (centres(h) - centres(-h)) / (2 * h)
    spin = masses * (3 * radii**2 + lengths**2) / 12
    energy = 0.5 * (masses @ abs(velocities)**2 + spin @ np.cumsum(w)**2)
    found = 0.5 * w @ chain_mass_matrix(lengths, radii, 1100, q) @ w
    assert found == pytest.approx(energy, rel=1e-6, abs=1e-15)


def settled_deg(finger: Finger, *recruited: float) -> np.ndarray:
    model = finger.linear_model()
    return np.degrees(model.offset - model.c @ np.linalg.solve(model.a, model.b @ np.array(recruited)))


@pytest.mark.parametrize(("muscle", "published_deg"), [
    (0, (19.7, 41.8, 29.4)), (1, (24.8, 47.9, 0.0)), (2, (-18.3, -15.2, -4.0))])
def test_each_extrinsic_muscle_moves_the_joints_in_the_published_proportions(muscle, published_deg) -> None:
    """Nimbarte 2008, a tendon load at a time; the load itself is scaled away."""
    moved = settled_deg(Finger(), *np.eye(4)[muscle]) - Finger().rest_deg
    published = np.array(published_deg)
    scaled = moved * np.linalg.norm(published) / np.linalg.norm(moved)
    np.testing.assert_allclose(scaled, published, atol=0.15 * np.linalg.norm(published))


def test_full_recruitment_covers_a_grasp_and_an_opening() -> None:
    finger = Finger()
    assert 70 < settled_deg(finger, 1, 1, 0, 1)[0] < 80
    assert 80 < settled_deg(finger, 1, 1, 0, 0)[1] < 100
    opened = settled_deg(finger, 0, 0, 1, 0)
    assert opened[0] < 0
    assert opened[1] < 5
    intrinsic = settled_deg(finger, 0, 0, 0, 1) - finger.rest_deg
    assert intrinsic[0] > 0
    assert intrinsic[1] < 0
    assert intrinsic[2] < 0


def test_the_proximal_phalanx_has_its_published_inertia() -> None:
    length, radius = 1e-3 * Finger().lengths_mm[0], 1e-3 * Finger().radii_mm[0]
    inertia = 1100 * math.pi * radius**2 * length * (3 * radius**2 + length**2) / 12
    assert inertia == pytest.approx(2e-6, rel=0.05)


def test_equations_and_linear_model_are_the_plant() -> None:
    finger = Finger(strength=1.3, speed=0.8)
    equations, model = finger.equations(), finger.linear_model("accelerations")
    stacked = (equations.a, equations.b, equations.c[6:9], equations.offset[6:9])
    for given_a, given_b, given_c, offset in (stacked, (model.a, model.b, model.c, model.offset)):
        v = finger.recruited(PULSES[0])
        x = solve_ivp(lambda _, x, a=given_a, b=given_b, v=v: a @ x + b @ v, (0, 0.1), np.zeros(14), "DOP853",
                      rtol=1e-12, atol=1e-14).y[:, -1]
        found = simulate(finger, {0: PULSES[0]}, [120 * MS])[-1, 6:9]
        np.testing.assert_allclose(given_c @ x + offset, found, atol=1e-6)
    assert model.delay_ns == equations.delay_ns == 20 * MS
    assert Finger(recruitment_curve="linear").linear_model().recruitment is None


def test_linear_recruitment_is_signed_and_unlimited() -> None:
    finger = Finger(recruitment_curve="linear", full_scale_us=200.0)
    np.testing.assert_allclose(finger.recruited(np.array([[1, -1e-4], [0, 6e-4], [2, 0], [3, 2e-4]])),
                               [-0.5, 3.0, 0.0, 1.0])


@pytest.mark.parametrize(("change", "named"), [
    ({"delay_ms": -1.0}, "delay_ms"), ({"stiffness": (0.1, 0.0, 0.1)}, "stiffness"),
    ({"force_n": (1.0, 1.0)}, "force_n"), ({"strength": math.nan}, "strength"), ({"speed": 0.0}, "speed"),
    ({"moment_arms_mm": ((1.0, 2.0, 3.0),)}, "moment_arms_mm"),
    ({"rest_deg": (math.inf, 0.0, 0.0)}, "rest_deg"),
    ({"recruitment": Recruitment(threshold_ma=(1.0,), spread=(1.0,))}, "recruitment"),
    ({"full_scale_us": 0.0}, "full_scale_us")])
def test_bad_parameters_are_named(change: dict, named: str) -> None:
    with pytest.raises(InputError, match=rf"finger\.{named}"):
        Finger(**change)

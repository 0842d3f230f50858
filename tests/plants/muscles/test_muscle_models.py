"""Muscle models: against adaptive integrators of the published equations, closed forms, published figures."""

import math

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st
from muscle_parts import COUNT, MODELS, MS, contractions, given, simulate, tiring
from scipy.integrate import solve_ivp

from fesloop.errors import InputError
from fesloop.hand.movements import muscle
from plants.muscles import Muscles
from plants.muscles.ding import Ding2003, Ding2003Fatigue, Ding2007
from plants.muscles.lags import Hammerstein, MuscleFatigue, Riener, TwoLags

PULSES = {0: (0.6, 40.0), 130 * MS: (0.2, 25.0), 260 * MS: (0.0, 25.0), 401 * MS + 77: (0.9, 50.0)}
SCHEDULE = {instant: given(*pulses) for instant, pulses in PULSES.items()}
STOPS = [20 * MS, 99 * MS + 1, 131 * MS, 300 * MS, 420 * MS, 700 * MS]


def fused(frequency):
    return (0.1 * frequency) ** 2 / (1.0 + (0.1 * frequency) ** 2)


def integrate_held(slope, y, schedule, stops_ns, delay_ns):
    """y at each stop, `slope(y, v, f)` integrated from change to change of what is held."""
    arrivals, now, held, rows = {t + delay_ns: u for t, u in schedule.items()}, 0, (0.0, 0.0), []
    for instant in sorted({*arrivals, *stops_ns}):
        if instant > stops_ns[-1]:
            break
        if instant > now:
            y = solve_ivp(lambda _, x, u=held: slope(x, *u), (0.0, (instant - now) * 1e-9), y, "DOP853",
                          rtol=1e-12, atol=1e-14).y[:, -1]
            now = instant
        held = arrivals.get(instant, held)
        if instant in stops_ns:
            rows.append(y)
    return np.array(rows)


def test_hammerstein_agrees_with_an_adaptive_integrator() -> None:
    """In muscles that have the usual delay and natural frequency, and in those that have their own."""
    def integrated(rad_s, delay_ns):
        def slope(y, v, f):
            return [y[1], rad_s**2 * (v * fused(f) - y[0]) - 2 * rad_s * y[1]]

        return integrate_held(slope, [0.0, 0.0], PULSES, STOPS, delay_ns)[:, 0]

    expected = np.tile(integrated(20.0, 40 * MS)[:, None], COUNT)
    for name, rad_s, delay_ns in (("FCR", 25.0, 7 * MS), ("FPL", 20.0, 33_333_333), ("EDC3", 9.0, 40 * MS)):
        expected[:, muscle(name)] = integrated(rad_s, delay_ns)
    muscles = Muscles(delays_ms={"FCR": 7.0, "FPL": 33.333333}, hammerstein=Hammerstein(
        activation_rad_s=20.0, activations_rad_s={"FCR": 25.0, "EDC3": 9.0}))
    found = simulate(muscles, SCHEDULE, STOPS)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("lags_ms", [(40.0, 70.0), (70.0, 40.0), (50.0, 50.0), (50.0, 50.0 + 1e-9)])
def test_riener_agrees_with_an_adaptive_integrator(lags_ms: tuple[float, float]) -> None:
    calcium, activation = lags_ms

    def slope(y, v, f):
        return [1e3 / calcium * (v * fused(f) - y[0]), 1e3 / activation * (y[0] - y[1])]

    muscles = Muscles(model="riener", delay_ms=33.3,
                      riener=Riener(calcium_ms=calcium, activation_ms=activation))
    found = simulate(muscles, SCHEDULE, STOPS)[:, 0]
    expected = integrate_held(slope, [0.0, 0.0], PULSES, STOPS, 33_300_000)[:, 1]
    np.testing.assert_allclose(found, np.tile(expected[:, None], COUNT), rtol=0, atol=1e-10)


@pytest.mark.parametrize("elapsed_s", [1e-9, 0.3, 1e4])
@pytest.mark.parametrize("lags_s", [(1e-3, 1.0), (1.0, 1e-3)])
def test_lags_far_apart_stay_finite_and_settle(lags_s: tuple[float, float], elapsed_s: float) -> None:
    lags = TwoLags(*(np.full(COUNT, lag) for lag in lags_s))
    state = lags.start()
    lags.change(state, 0, np.zeros((2, COUNT)), np.full(COUNT, 0.7))
    after, _ = lags.look(state, round(elapsed_s * 1e9))
    exact = 0.7 * (1 - (lags_s[0] * math.exp(-elapsed_s / lags_s[0]) - lags_s[1] * math.exp(
        -elapsed_s / lags_s[1])) / (lags_s[0] - lags_s[1]))
    np.testing.assert_allclose(after, exact, rtol=0, atol=1e-13)


def integrate_pulses(model, schedule, stops_ns, delay_ns):
    """(CN, F, A, tau1, Km) at each stop by the papers' equations, calcium summed over all pulses."""
    tauc, tau2 = 1e-3 * model.calcium_ms, 1e-3 * model.friction_ms
    rest = np.array([model.scaling_n_s, 1e-3 * model.relaxation_ms, model.sensitivity])
    tires = getattr(model, "fatigue", None)
    drift = np.array([-0.4, 2.1e-5, 1.9e-5]) if tires else np.zeros(3)
    pulses, first, rate, fired = [], 0, -1.0, 0
    arrivals = [(t + delay_ns, *u) for t, u in sorted(schedule.items())]
    ends = [t for t, *_ in arrivals[1:]] + [stops_ns[-1] + 1]
    for (start, v, f), end in zip(arrivals, ends, strict=True):
        # A new frequency waits for an interval after the newest pulse; an old one goes on counting.
        if f != rate:
            first, rate, fired = max([start, *(int(t) + int(1e9 / f) for t in pulses[-1:])]), f, 0
        while (instant := first + int(fired * 1e9 / f)) < end:
            if instant >= start and v > 0:
                pulses.append(instant)
            fired += 1
    held = {t: v for t, v, _ in arrivals}
    y, now, v, weights, rows = np.concatenate([[0.0, 0.0], rest]), 0, 0.0, [], []

    def slope(time_s, y, v):
        calcium = sum(r * math.exp(-(time_s - 1e-9 * t) / tauc) for t, r in weights)
        bound = y[0] / (y[4] + y[0])
        force = v * y[2] * bound - y[1] / (y[3] + tau2 * bound)
        return [(calcium - y[0]) / tauc, force, *((rest - y[2:]) / 127.0 * bool(tires) + drift * y[1])]

    for instant in sorted({*pulses, *held, *stops_ns}):
        if instant > now:
            y = solve_ivp(slope, (1e-9 * now, 1e-9 * instant), y, "DOP853", args=(v,),
                          rtol=1e-9, atol=1e-10).y[:, -1]
            now = instant
        v = held.get(instant, v)
        if instant in pulses:
            enhanced = (y[4] + 0.04) * math.exp(-1e-9 * (instant - weights[-1][0]) / tauc) if weights else 0
            weights.append((instant, 1.0 + enhanced))
        if instant in stops_ns:
            rows.append(y)
    return np.array(rows)


@pytest.mark.parametrize("model", [Ding2003(), Ding2003(fatigue=Ding2003Fatigue()), Ding2007()])
def test_ding_agrees_with_an_adaptive_integrator(model) -> None:
    name = type(model).__name__.lower()
    found = simulate(Muscles(model=name, delay_ms=20.0, **{name: model}), SCHEDULE, STOPS)
    expected = integrate_pulses(model, PULSES, STOPS, 20 * MS)
    full_n = model.scaling_n_s * 1e-3 * (model.relaxation_ms + model.friction_ms)
    np.testing.assert_allclose(found[:, 0], np.tile(expected[:, 1:2] / full_n, COUNT), rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[:, 1], np.tile(expected[:, 2:3] / model.scaling_n_s, COUNT), atol=1e-8)
    assert expected[:, 1].max() > 50.0


def test_a_slow_force_is_that_of_one_twitch_after_the_other() -> None:
    """At 1 Hz calcium is gone between pulses: every contraction is the first one again."""
    muscles = Muscles(model="ding2007", delay_ms=0.0)
    found = simulate(muscles, {0: given(1.0, 1.0)}, [50 * MS, 1050 * MS, 2050 * MS])[:, 0, 0]
    assert found[0] > 0.01
    np.testing.assert_allclose(found[1:], found[0], rtol=1e-4)


@pytest.mark.parametrize(("width_us", "published_n"), [(150, 21), (300, 134), (500, 196)])
def test_ding2007_gives_the_published_force_at_each_pulse_width(width_us: int, published_n: int) -> None:
    """Peaks of the fused train at 40 Hz."""
    model = Ding2007()
    muscles = Muscles(model="ding2007", delay_ms=0.0)
    train = given(model.recruitment(1e-6 * width_us), 40.0)
    activation = muscles.observe(muscles.init(None), train, 0, range(900 * MS, 1000 * MS, MS))[0]
    assert activation.max() * 4920 * 0.061601 == pytest.approx(published_n, abs=0.5)


@pytest.mark.parametrize(("rad_s", "rise_s"), [(25.0, 0.133), (20.0, 0.133 * 25 / 20)])
def test_hammerstein_rises_as_fast_as_published(rad_s: float, rise_s: float) -> None:
    muscles = Muscles(hammerstein=Hammerstein(activation_rad_s=rad_s), delay_ms=0.0)
    times = np.arange(0, 600 * MS, MS)
    seen = muscles.observe(muscles.init(None), given(1.0, 40.0), 0, times.tolist())[0][:, 0] / fused(40.0)
    low, high = (np.interp(share, seen, times) for share in (0.1, 0.9))
    assert (high - low) * 1e-9 == pytest.approx(rise_s, rel=0.015)


@pytest.mark.parametrize("frequency", [5.0, 20.0, 50.0, 100.0])
@pytest.mark.parametrize("model", ["hammerstein", "riener"])
def test_steady_activation_is_the_published_function_of_frequency(model: str, frequency: float) -> None:
    steady = simulate(Muscles(model=model), {0: given(0.8, frequency)}, [3000 * MS])[0, 0]
    np.testing.assert_allclose(steady, 0.8 * fused(frequency), rtol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_force_grows_with_frequency_and_saturates(model: str) -> None:
    muscles, peaks = Muscles(model=model, delay_ms=0.0), []
    for frequency in (10.0, 20.0, 40.0, 80.0, 160.0):
        times = range(1400 * MS, 1500 * MS, 2 * MS)
        peaks.append(muscles.observe(muscles.init(None), given(1.0, frequency), 0, times)[0].max())
    gains = np.diff(peaks)
    assert (gains > 0).all()
    assert (np.diff(gains) < 0).all()
    assert 0.9 < peaks[-1] < 1.0


@drawn(drives=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4), frequency=st.floats(1.0, 100.0))
@settings(max_examples=20, deadline=None)
def test_fitness_solves_its_equation(drives: list[float], frequency: float) -> None:
    span, fatigue = 4_000 * MS, MuscleFatigue(fatigue_s=18.0, recovery_s=40.0)
    schedule = {k * span: (v, frequency) for k, v in enumerate(drives)}
    stop = span * len(drives)

    def slope(y, v, f):
        effort = v * fused(f) * (1.0 - 0.6 + 0.6 * (f / 100.0) ** 2)
        return [(0.2 - y[0]) * effort / 18.0 + (1.0 - y[0]) * (1.0 - effort) / 40.0]

    inputs = {instant: given(*drive) for instant, drive in schedule.items()}
    found = simulate(Muscles(fatigue=fatigue, delay_ms=0.0), inputs, [stop])
    expected = integrate_held(slope, [1.0], schedule, [stop], 0)[0]
    np.testing.assert_allclose(found[0, 1], expected[0], rtol=0, atol=1e-9)


def test_fatigue_settles_where_its_equation_does() -> None:
    """Under full recruitment at 100 Hz, w is near 1: fitness goes to its floor; at 40 Hz, not so far."""
    fatigue = MuscleFatigue(fatigue_s=24.0, recovery_s=45.0)
    for frequency in (40.0, 100.0):
        effort = fused(frequency) * (0.4 + 0.6 * (frequency / 100.0) ** 2)
        wear, repair = effort / 24.0, (1.0 - effort) / 45.0
        settled = simulate(Muscles(fatigue=fatigue), {0: given(1.0, frequency)}, [400_000 * MS])[0]
        np.testing.assert_allclose(settled[1], (0.2 * wear + repair) / (wear + repair), rtol=1e-4)
        np.testing.assert_allclose(settled[0], settled[1] * fused(frequency), rtol=1e-9)
    assert settled[1, 0] < 0.21


def test_without_recovery_what_is_lost_stays_lost() -> None:
    for muscles in (Muscles(fatigue=MuscleFatigue(recovers=False)),
                    Muscles(model="ding2003", ding2003=Ding2003(fatigue=Ding2003Fatigue(recovers=False)))):
        work = {0: given(1.0, 40.0), 5_000 * MS: given(0.0, 40.0)}
        fitness = simulate(muscles, work, [1_000 * MS, 7_000 * MS, 20_000 * MS])[:, 1, 0]
        assert fitness[0] > fitness[1] + 0.05
        assert fitness[2] == pytest.approx(fitness[1], rel=1e-4)


@pytest.mark.slow
def test_ding2003_tires_to_the_balance_of_its_equations() -> None:
    """Force in tetanus solves F = A B (tau1 + tau2 B) with A, tau1 and Km where F holds them."""
    settled = simulate(tiring("ding2003"), {0: given(1.0, 100.0)}, [600_000 * MS])[0]
    force = settled[0, 0] * 3009 * 0.110957
    scaling, relaxation, sensitivity = np.array([3009, 0.050957, 0.103]) + 127 * force * np.array(
        [-0.4, 2.1e-5, 1.9e-5])
    assert settled[1, 0] == pytest.approx(scaling / 3009, rel=1e-3)
    interval = math.exp(-0.01 / 0.02)
    calcium = (1 + (sensitivity + 0.04) * interval) * 0.02 / 0.01
    bound = calcium / (sensitivity + calcium)
    assert force == pytest.approx(scaling * bound * (relaxation + 0.06 * bound), rel=0.01)
    assert force == pytest.approx(53, abs=2)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "decline"), [("riener", 0.18), ("ding2003", 0.57), ("ding2007", 0.18)])
def test_180_contractions_beside_those_of_bickel(model: str, decline: float) -> None:
    """Six pulses 70 ms apart, half of the time at rest (Bickel 2004: 44, 56, 67 % of quadriceps' torque in
    able-bodied people, acute and chronic spinal cord injury).

    Ding's values of 2003 decline as the acute group; the fitness equation with values of the literature
    only by 18 %: it stops short of every group, for its effort falls with the low frequency of 14.3 Hz.
    """
    peaks = contractions(tiring(model), 420, 420, 1e3 / 70.0, 180)
    assert 1.0 - peaks[-1] / peaks[0] == pytest.approx(decline, abs=0.02)


def test_the_values_of_2007_have_no_fatigue_of_2003_to_be_given() -> None:
    assert "fatigue" not in Ding2007.__dataclass_fields__
    with pytest.raises(TypeError):
        Ding2007(fatigue=Ding2003Fatigue())  # type: ignore[call-arg]
    with pytest.raises(InputError, match=r"muscles\.fatigue.*ding2003\.fatigue"):
        Muscles(model="ding2003", fatigue=MuscleFatigue())


@pytest.mark.parametrize(("make", "named"), [
    (lambda: Hammerstein(activation_rad_s=0.0), "hammerstein.activation_rad_s"),
    (lambda: Riener(calcium_ms=-1.0), "riener.calcium_ms"),
    (lambda: Ding2003(sensitivity=math.nan), "ding2003.sensitivity"),
    (lambda: Ding2007(friction_ms=0.0), "ding2007.friction_ms"),
    (lambda: Ding2003Fatigue(recovery_s=0.0), "fatigue.recovery_s"),
    (lambda: Ding2003Fatigue(scaling_per_s2=0.4), "fatigue.scaling_per_s2"),
    (lambda: MuscleFatigue(floor=1.1), "fatigue.floor"),
    (lambda: MuscleFatigue(fatigue_s=math.inf), "fatigue.fatigue_s")])
def test_bad_parameters_are_named(make, named: str) -> None:
    with pytest.raises(InputError, match=named):
        make()

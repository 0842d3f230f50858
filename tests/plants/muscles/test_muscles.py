"""The muscles as a plant: delay, splits, observers, trials, loop; the same for every model."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st
from muscle_parts import CONTEXT, COUNT, MODELS, MS, given, patient, simulate, tiring

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.block import Context
from plants.muscles import Muscles
from plants.muscles.lags import Hammerstein, MuscleFatigue
from plants.muscles.patient_drive import MuscleTremor, StretchReflex

RNG = np.random.default_rng(7)
SCHEDULE = {
    0: given(RNG.random(COUNT), 40.0), 13 * MS + 1: given(0.4, 40.0, 2.0 * RNG.random(COUNT), 0.3),
    40 * MS: given(RNG.random(COUNT), 25.0, -1.0, 0.1),
    61 * MS + 77: given(0.0, 50.0, 1.0, RNG.random(COUNT)),
    90 * MS: given(RNG.random(COUNT), 50.0, 0.0, 0.0)}
instants = st.lists(st.integers(1, 199 * MS), max_size=8)


@pytest.mark.parametrize("model", MODELS)
@drawn(cuts=instants)
@settings(max_examples=15, deadline=None)
def test_splitting_an_advance_changes_no_bit(model: str, cuts: list[int]) -> None:
    muscles = patient(model)
    whole = simulate(muscles, SCHEDULE, [200 * MS])[-1]
    split = simulate(muscles, SCHEDULE, [*sorted(cuts), 200 * MS])[-1]
    np.testing.assert_array_equal(split, whole)


@pytest.mark.parametrize("model", MODELS)
@drawn(start=st.integers(1, 90 * MS), later=st.lists(st.integers(0, 120 * MS), min_size=1, max_size=9))
@settings(max_examples=15, deadline=None)
def test_observing_equals_advancing_a_copy_and_touches_nothing(
    model: str, start: int, later: list[int]
) -> None:
    muscles = patient(model)
    state = muscles.init(CONTEXT)
    simulate(muscles, SCHEDULE, [start], state)
    new, before = given(0.7, 33.0, 1.0, 0.2), pickle.dumps(state)
    times = [start + step for step in sorted(later)]
    stacks = muscles.observe(state, new, start, times)
    assert pickle.dumps(state) == before
    for k, time_ns in enumerate(times):
        copy = pickle.loads(before)
        muscles.advance(copy, new, start, time_ns)
        for stack, value in zip(stacks, muscles.read(copy, new), strict=True):
            np.testing.assert_array_equal(stack[k], value)


@pytest.mark.parametrize("model", MODELS)
def test_a_pickled_state_goes_on_with_the_same_bits(model: str) -> None:
    muscles, state = patient(model), None
    for stop in (1, 33 * MS + 5, 75 * MS):
        state = patient(model).init(CONTEXT)
        simulate(muscles, SCHEDULE, [stop], state)
        twin, again, held = pickle.loads(pickle.dumps((muscles, state, given(0.5, 30.0))))
        muscles.advance(state, given(0.5, 30.0), stop, 200 * MS)
        twin.advance(again, held, stop, 200 * MS)
        for value, other in zip(muscles.read(state, held), twin.read(again, held), strict=True):
            np.testing.assert_array_equal(value, other)


@pytest.mark.parametrize("model", MODELS)
def test_an_equal_input_sent_again_splits_nothing(model: str) -> None:
    muscles = Muscles(model=model)
    again = {t * MS: given(0.5, 40.0) for t in range(0, 200, 7)}
    once = simulate(muscles, {0: given(0.5, 40.0)}, [200 * MS])
    np.testing.assert_array_equal(simulate(muscles, again, [200 * MS]), once)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("delay_ms", [0.0, 20.0, 33.333333])
def test_the_delay_is_exact_to_the_nanosecond(model: str, delay_ms: float) -> None:
    late, sent = round(delay_ms * MS), 7 * MS + 3
    delayed = simulate(Muscles(model=model, delay_ms=delay_ms), {sent: given(0.8, 40.0)},
                       [sent + late, sent + late + 1, sent + late + 30 * MS])[:, 0]
    prompt = simulate(Muscles(model=model, delay_ms=0.0), {0: given(0.8, 40.0)}, [1, 30 * MS])[:, 0]
    assert not delayed[0].any()
    assert (delayed[1] > 0.0).all()
    np.testing.assert_allclose(delayed[1:], prompt, rtol=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_a_muscle_with_its_own_delay_gets_what_changes_for_it(model: str) -> None:
    """To the nanosecond, and without a trace in it of what changes for others."""
    late = Muscles(model=model, delays_ms={"FCR": 33.333333, "FCU": 0.0})
    rest, some = given(0.0, 0.0), given(0.8, 40.0)
    some[0][muscle("FCR")] = 0.3
    stops = [60 * MS + ns for ns in (0, 1, 33_333_333, 33_333_334, 40 * MS, 40 * MS + 1, 90 * MS)]
    seen = simulate(late, {0: rest, 60 * MS: some}, stops)[:, 0]
    begins = {"FCR": 33_333_334, "FCU": 1, "FPL": 40 * MS + 1}
    for name, ns in begins.items():
        first = next(stop for stop, row in zip(stops, seen, strict=True) if row[muscle(name)] > 0.0)
        assert first == 60 * MS + ns
    again = simulate(late, {0: rest, 60 * MS: some, 70 * MS: given(0.8, 40.0)}, stops)[:, 0]
    assert again[-1, muscle("FCR")] > 1.01 * seen[-1, muscle("FCR")]
    others = np.arange(COUNT) != muscle("FCR")
    np.testing.assert_allclose(again[:, others], seen[:, others], rtol=1e-6)


@pytest.mark.parametrize("model", ["riener", "ding2003"])
def test_the_delay_grows_with_what_a_muscle_has_lost(model: str) -> None:
    """Half of the muscles are worked; a second later all are called at once."""
    worked, called = np.arange(COUNT) % 2 == 0, 20_000 * MS
    schedule = {0: given(np.where(worked, 1.0, 0.0), 50.0), 19_000 * MS: given(0.0, 50.0),
                called: given(0.5, 50.0)}
    muscles = tiring(model, delay_ms=20.0, delay_growth=1.5)
    (late,) = {round(20 * MS * (1.0 + 1.5 * (1.0 - fitness)))
               for fitness in simulate(muscles, schedule, [called])[-1, 1, worked]}
    assert late > 25 * MS
    stops = [called, called + 20 * MS, called + 25 * MS, called + late, called + late + 5 * MS]
    seen = simulate(muscles, schedule, stops)[:, 0]
    fresh, tired = seen[:, ~worked], seen[:, worked]
    assert (np.diff(fresh, axis=0)[1:] > 0.0).all()
    assert not fresh[1].any()
    assert (np.diff(tired, axis=0)[:3] <= 0.0).all()
    assert (tired[4] > tired[3]).all()


def test_nothing_overtakes_as_a_muscle_recovers() -> None:
    """Called while it is tired, which takes .31 s, and called off .15 s later when it is not, after .1 s."""
    quick = MuscleFatigue(recovery_s=0.02, fatigue_s=0.02)
    calls = {at * MS: given(level, 50.0) for at, level in ((0, 1.0), (1000, 0.0), (1300, 1.0), (1450, 0.0))}
    muscles = Muscles(fatigue=quick, delay_ms=100.0, delay_growth=5.0)
    seen = simulate(muscles, calls, [1250 * MS, 1450 * MS, 10_000 * MS])
    assert (seen[0, 1] < 0.6).all()
    assert (seen[1, 1] > 0.99).all()
    assert (seen[2, 0] < 1e-9).all()


@pytest.mark.parametrize("late_ns", [1, 1_000, 25 * MS, 300 * MS])
def test_activation_is_the_critically_damped_step_response(late_ns: int) -> None:
    activation = simulate(Muscles(), {7: given(1.0, 30.0)}, [7 + 40 * MS + late_ns])[-1, 0]
    wt = 16.0 * late_ns * 1e-9
    expected = 0.9 * (-math.expm1(-wt) - wt * math.exp(-wt))
    np.testing.assert_allclose(activation, expected, rtol=1e-6, atol=1e-15)


schedules = st.lists(st.tuples(st.integers(0, 300), st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
                     min_size=1, max_size=6, unique_by=lambda change: change[0])


@pytest.mark.parametrize("model", MODELS)
@drawn(changes=schedules, frequency=st.floats(1.0, 120.0))
@settings(max_examples=20, deadline=None)
def test_more_recruitment_never_gives_less_activation(model: str, changes, frequency: float) -> None:
    muscles, stops = Muscles(model=model), [100 * MS, 250 * MS, 2000 * MS]
    less, more = (
        simulate(muscles, {at * MS: given(v * share, frequency) for at, v, part in changes
                           for share in (part if fewer else 1.0,)}, stops)[:, 0]
        for fewer in (True, False))
    assert (less <= more + 1e-12).all()
    assert less.min() >= 0.0
    assert more.max() <= 1.0


@pytest.mark.parametrize("model", MODELS)
@drawn(changes=st.lists(st.tuples(st.integers(0, 300), *[st.floats(-2.0, 3.0)] * 3, st.floats(-10.0, 1e4)),
                        min_size=1, max_size=6, unique_by=lambda change: change[0]))
@settings(max_examples=15, deadline=None)
def test_whatever_comes_in_activation_stays_in_its_range(model: str, changes) -> None:
    """With everything on; a muscle has no more than all of itself."""
    schedule = {at * MS: given(v, f, velocity, effort) for at, v, velocity, effort, f in changes}
    seen = simulate(patient(model), schedule, [150 * MS, 310 * MS, 600 * MS])
    assert np.isfinite(seen).all()
    assert seen.min() >= 0.0
    assert seen[:, 0].max() <= 1.0
    assert seen[:, 1].max() <= 1.0


@pytest.mark.parametrize("model", MODELS)
def test_every_muscle_is_its_own(model: str) -> None:
    recruited, frequency = np.linspace(0.0, 1.0, COUNT), np.linspace(20, 50, COUNT)
    together = simulate(Muscles(model=model), {0: given(recruited, frequency)}, [150 * MS])[0, 0]
    for k in (0, 9, COUNT - 1):
        alone = given(recruited * (np.arange(COUNT) == k), frequency)
        seen = simulate(Muscles(model=model), {0: alone}, [150 * MS])[0, 0]
        assert seen[k] == together[k]
        assert not np.delete(seen, k).any()


@pytest.mark.parametrize("model", MODELS)
def test_fatigue_is_carried_to_the_next_trial_less_the_rest(model: str) -> None:
    worked = {}
    for rest_s in (0.0, 30.0, 1e5):
        muscles = tiring(model, rest_between_trials_s=rest_s)
        state = muscles.init(CONTEXT)
        tired = simulate(muscles, {0: given(1.0, 50.0)}, [20_000 * MS], state)[0]
        again = muscles.next_trial(state, Context("muscles", trial=1))
        activation, worked[rest_s] = muscles.read(again, given())
        assert not activation.any()
        assert again.now_ns == 0
        if rest_s == 0.0:
            np.testing.assert_allclose(worked[rest_s], tired[1], rtol=1e-4)
    assert worked[0.0][0] < 0.8
    assert (worked[0.0] < worked[30.0]).all()
    np.testing.assert_allclose(worked[1e5], 1.0, rtol=1e-9)
    fresh = Muscles(model=model)
    assert (fresh.read(fresh.next_trial(fresh.init(CONTEXT), CONTEXT), given())[1] == 1.0).all()


@pytest.mark.parametrize("model", ["ding2003", "ding2007"])
def test_a_pulse_takes_the_recruitment_of_its_own_instant(model: str) -> None:
    """A stimulator at 40 Hz that begins at its fifth slot is not a slot late."""
    muscles = Muscles(model=model, delay_ms=0.0)
    found = simulate(muscles, {0: given(0.0, 40.0), 125 * MS: given(1.0, 40.0)}, [135 * MS])[0, 0]
    first = simulate(muscles, {0: given(1.0, 40.0)}, [10 * MS])[0, 0]
    np.testing.assert_allclose(found, first, rtol=1e-12)


def test_without_pulses_recruitment_is_nothing() -> None:
    for model in MODELS:
        assert not simulate(Muscles(model=model), {0: given(1.0, 0.0)}, [200 * MS])[0, 0].any()


def test_it_declares_any_instant_and_no_feedthrough() -> None:
    for model in MODELS:
        muscles = Muscles(model=model)
        assert muscles.grid is None
        assert not muscles.feedthrough
        assert [port.name for port in muscles.inputs if not port.optional] == ["recruitment", "frequency"]
        assert all(port.shape == (len(MUSCLES),) for port in (*muscles.inputs, *muscles.outputs))


@pytest.mark.parametrize(("change", "named"), [
    ({"model": "hill"}, r"muscles\.model.*ding2007"), ({"delay_ms": -1.0}, r"muscles\.delay_ms"),
    ({"delays_ms": {"FCR": -1.0}}, r"muscles\.delays_ms\.FCR"),
    ({"delays_ms": {"FDP": 1.0}}, r"muscles\.delays_ms.*did you mean 'FDP"),
    ({"naturals_rad_s": {"FCR": 0.0}}, r"muscles\.naturals_rad_s\.FCR"),
    ({"fusion_hz": 0.0}, r"muscles\.fusion_hz"), ({"voluntary_limit": 1.5}, r"muscles\.voluntary_limit"),
    ({"voluntary_limits": {"FDP2": -0.1}}, r"muscles\.voluntary_limits"),
    ({"voluntary_limits": {"FDP": 0.1}}, r"muscles\.voluntary_limits.*did you mean 'FDP"),
    ({"rest_between_trials_s": -1.0}, r"muscles\.rest_between_trials_s"),
    ({"wear_per_trial": 1.0}, r"muscles\.wear_per_trial"),
    ({"natural_rad_s": math.nan}, r"muscles\.natural_rad_s")])
def test_bad_parameters_are_named(change: dict, named: str) -> None:
    with pytest.raises(InputError, match=named):
        Muscles(**change)


def step_and_hold(velocity, voluntary=0.0, recruited=0.0, **parameters):
    """Activation after a second of it."""
    held = given(recruited, 1e9, velocity, voluntary)
    return simulate(Muscles(**parameters), {0: held}, [1_500 * MS])[0, 0]


@pytest.mark.parametrize(("velocity", "expected"), [
    (-2.0, 0.0), (0.1, 0.0), (0.4, 0.15), (0.6, 0.25), (9.0, 0.5)])
def test_the_reflex_has_a_threshold_a_gain_and_a_limit(velocity: float, expected: float) -> None:
    np.testing.assert_allclose(step_and_hold(velocity, reflex=StretchReflex()), expected, atol=1e-9)
    assert not step_and_hold(velocity).any()


def test_the_reflex_comes_after_both_delays_in_spastic_muscles_alone() -> None:
    spastic = Muscles(reflex=StretchReflex(muscles=("FDP2", "FCR"), delay_ms=45.0), delay_ms=15.0)
    before, after = simulate(spastic, {0: given(0.0, 0.0, 1.0)}, [60 * MS, 61 * MS])[:, 0]
    assert not before.any()
    assert set(np.flatnonzero(after)) == {muscle("FDP2"), muscle("FCR")}


@pytest.mark.parametrize(("voluntary", "recruited", "limit", "expected"), [
    (0.3, 0.0, 1.0, 0.3), (0.3, 0.5, 1.0, 0.8), (0.8, 0.5, 1.0, 1.0), (0.8, 0.1, 0.2, 0.3),
    (0.8, 0.4, 0.0, 0.4)])
def test_effort_adds_what_stimulation_leaves(voluntary, recruited, limit, expected) -> None:
    found = step_and_hold(0.0, voluntary, recruited, voluntary_limit=limit, fusion_hz=1e-3)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    with_ding = step_and_hold(0.0, voluntary, 0.0, voluntary_limit=limit, model="ding2007")
    np.testing.assert_allclose(with_ding, min(voluntary, limit), atol=1e-9)


def test_effort_has_no_fibre_that_stimulation_has_recruited_however_little_it_is_fused() -> None:
    """At 40 Hz, half fused: 0.6 recruited give 0.3, and effort of 0.7 has the 0.4 that are left."""
    found = simulate(Muscles(fusion_hz=40.0), {0: given(0.6, 40.0, 0.0, 0.7)}, [1_500 * MS])[0, 0]
    np.testing.assert_allclose(found, 0.3 + 0.4, atol=1e-9)


def test_single_muscles_have_limits_of_their_own() -> None:
    found = step_and_hold(0.0, 0.8, voluntary_limit=0.0, voluntary_limits={"ECRL": 0.7, "ECRB": 1.0})
    expected = np.zeros(len(MUSCLES))
    expected[[muscle("ECRL"), muscle("ECRB")]] = 0.7, 0.8
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_effort_rises_as_a_critically_damped_muscle() -> None:
    muscles = Muscles(model="ding2003", delay_ms=20.0, natural_rad_s=20.0, delays_ms={"FCR": 50.0},
                      naturals_rad_s={"FCR": 10.0, "FCU": 30.0})
    found = simulate(muscles, {0: given(voluntary=0.5)}, [90 * MS])[0, 0]
    wt = np.full(COUNT, 20.0 * 0.07)
    wt[muscle("FCR")], wt[muscle("FCU")] = 10.0 * 0.04, 30.0 * 0.07
    np.testing.assert_allclose(found, 0.5 * (1.0 - (1.0 + wt) * np.exp(-wt)), rtol=1e-9)


def trembling(trial=0, seed=3, **parameters):
    """Activation by tremor alone, each ms of 30 s."""
    muscles = Muscles(tremor=MuscleTremor(**parameters))
    state = muscles.init(Context("muscles", seed=seed, trial=trial))
    return muscles.observe(state, given(0.0, 0.0), 0, range(0, 30_000 * MS, MS))[0]


def test_tremor_drives_flexors_and_extensors_in_turn_at_the_patients_frequency() -> None:
    centres = []
    for seed in (1, 2, 3):
        seen = trembling(seed=seed)
        flexor, extensor = seen[:, muscle("FCR")], seen[:, muscle("ECRB")]
        assert not (flexor * extensor).any()
        assert np.sqrt(np.mean((flexor - extensor) ** 2)) == pytest.approx(0.03, rel=0.1)
        power = abs(np.fft.rfft(flexor - extensor)) ** 2
        hz = np.fft.rfftfreq(len(seen), 1e-3)
        centres.append((power @ hz) / power.sum())
        assert 3.5 < centres[-1] < 12.5
        assert power[abs(hz - centres[-1]) < 1.2].sum() > 0.95 * power.sum()
    assert np.ptp(centres) > 0.1


def test_tremor_keeps_its_frequency_and_changes_its_phase_from_trial_to_trial() -> None:
    first, second = (trembling(trial, spread_hz=1e-3)[:, muscle("FCR")] for trial in (0, 1))
    peaks = [np.argmax(abs(np.fft.rfft(seen))[1:]) for seen in (first, second)]
    assert peaks[0] == peaks[1]
    assert abs(first - second).max() > 0.003
    np.testing.assert_array_equal(first, trembling(0, spread_hz=1e-3)[:, muscle("FCR")])
    assert set(np.flatnonzero(trembling(muscles=("FPL",)).any(axis=0))) == {muscle("FPL")}


@pytest.mark.parametrize(("make", "named"), [
    (lambda: StretchReflex(gain_s=-1.0), r"reflex\.gain_s"),
    (lambda: StretchReflex(limit=2.0), r"reflex\.limit"),
    (lambda: MuscleTremor(spread_hz=0.0), r"tremor\.spread_hz"),
    (lambda: StretchReflex(delay_ms=-3.0), r"reflex\.delay_ms"),
    (lambda: StretchReflex(muscles=("FDP1",)), r"reflex\.muscles.*FDP1.*did you mean"),
    (lambda: MuscleTremor(band_hz=(8.0, 4.0)), r"tremor\.band_hz"),
    (lambda: MuscleTremor(muscles=("biceps",)), r"tremor\.muscles"),
    (lambda: Hammerstein(activations_rad_s={"FCR": math.inf}), r"hammerstein\.activations_rad_s\.FCR"),
    (lambda: Muscles(hammerstein=Hammerstein(activation_rad_s=-1.0)), r"hammerstein\.activation_rad_s")])
def test_bad_patients_are_named(make, named: str) -> None:
    with pytest.raises(InputError, match=named):
        make()


def test_many_instants_at_once_are_what_going_to_each_and_reading_there_is():
    for muscles in (Muscles(fatigue=MuscleFatigue()), Muscles(model="riener", delay_growth=1.0,
                    fatigue=MuscleFatigue(fatigue_s=2.0)), Muscles(model="ding2003"),
                    Muscles(tremor=MuscleTremor())):
        one, many = (muscles.init(Context("muscles", seed=1)) for _ in range(2))
        rng, now = np.random.default_rng(5), 0
        for k in range(12):
            inputs = [rng.uniform(0.0, 1.0, 29), np.full(29, 40.0), np.zeros(29),
                      rng.uniform(0.0, 0.5, 29) * (k > 6)]
            times = [now + int(step) for step in np.cumsum(rng.integers(0, 9_000_000, 5))]
            later = [inputs[0] * (k % 2), np.full(29, 30.0), *inputs[2:]]
            changes = [(now, inputs), (times[1], later), (times[3] - 1, [later[0], inputs[1], *later[2:]])]
            together = muscles.advance_through(many, changes, times)
            for i, instant in enumerate(times):
                while len(changes) > 1 and changes[1][0] < instant:
                    _, inputs = changes.pop(0)
                    muscles.advance(one, inputs, now, changes[0][0])
                    now, inputs = changes[0]
                muscles.advance(one, inputs, now, instant)
                now = instant
                for stack, value in zip(together, muscles.read(one, inputs), strict=True):
                    assert stack[i].tobytes() == value.tobytes()


def test_velocity_is_ignored_without_a_reflex_alone():
    assert Muscles().ignores == ("velocity",)
    assert Muscles(reflex=StretchReflex()).ignores == ()


@drawn(wear=st.floats(0.0, 0.5), trials=st.integers(1, 10))
def test_what_trials_wear_off_stays_lost(wear: float, trials: int) -> None:
    muscles, fresh = Muscles(wear_per_trial=wear), Muscles()
    state = muscles.init(CONTEXT)
    for trial in range(1, trials + 1):
        state = muscles.next_trial(state, Context("muscles", trial=trial))
    worn, whole = (simulate(each, {0: given(0.6, 40.0)}, [500 * MS], at)[0]
                   for each, at in ((muscles, state), (fresh, fresh.init(CONTEXT))))
    np.testing.assert_allclose(worn, (1.0 - wear) ** trials * whole, rtol=1e-12)

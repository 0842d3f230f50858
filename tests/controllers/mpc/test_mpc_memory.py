"""What predictive control learns from trial to trial."""

import pickle

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from controllers.mpc import Mpc
from controllers.mpc.memory import Course, Memory
from controllers.mpc.strength_adaptation import StrengthAdaptation
from controllers.reference import MinimumJerk
from controllers.safety import Safety
from controllers.trajectories import response
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.finger import Finger

MS = 1_000_000
PERIOD = 25 * MS
MODEL = Finger().linear_model()
SAMPLED = MODEL.sampled(PERIOD)
MOVES = MinimumJerk(times_s=(1.0, 2.0, 3.0, 4.0), preview=20, preview_period_ms=25.0, angles_deg=(
    (20.0, 25.0, 15.0), (40.0, 55.0, 25.0), (40.0, 55.0, 25.0), (25.0, 32.0, 18.0)))


def rms_by_trial(finger, trials=4, latency_ms=20.0, **changes):
    """RMS error of the joints, deg, from trial to trial."""
    mpc = Mpc(model=MODEL, current_ma=(40.0,) * 4, actuation_delay_ms=5.0, **changes)
    nodes = [Node("reference", MOVES, "40"), Node("mpc", mpc, "40"), Node("safety", Safety(), "40"),
             Node("finger", finger), Node("tracker", IdealTracker(), "100")]
    wires = [Wire("reference.preview", "mpc.reference_preview"),
             Wire("mpc.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("finger.angles", "tracker.angles"),
             Wire("tracker.angles", "mpc.measured", latency_ms=latency_ms)]
    found, loop = [], Loop(Wiring(nodes, wires, seed=1), recorder=(recorder := Recorder("200")))
    for trial in range(trials):
        if trial:
            loop.next_trial()
        before = len(recorder.plants["finger"])
        loop.run_until(5 * 10**9)
        rows = recorder.plants["finger"][before:]
        times = np.concatenate([row[0] for row in rows]) / 1e9
        angles = np.concatenate([np.asarray(row[2][0]) for row in rows])
        error = angles - MOVES.angles_at(times)
        found.append(float(np.degrees(np.sqrt(np.mean(error[times > 0.5] ** 2)))))
    loop.close()
    return found


@pytest.mark.parametrize(("strength", "latency_ms"), [
    (0.6, 20.0), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((1.6, 20.0), (0.7, 150.0)))])
def test_an_error_that_comes_back_in_each_trial_goes(strength, latency_ms):
    finger = Finger(strength=strength)
    without = rms_by_trial(finger, latency_ms=latency_ms)
    learnt = rms_by_trial(finger, latency_ms=latency_ms, memory=Memory())
    print(np.round([without, learnt], 3))
    assert learnt[0] == without[0]
    assert learnt[1] < 0.7 * without[1]
    assert learnt[3] < 0.3 * without[3]


def test_without_an_error_nothing_is_learnt():
    found = rms_by_trial(Finger(), memory=Memory(share=1.0))
    assert max(found[1:]) <= 1.05 * found[0]


def trial_of(samples, disturbance, drives, age_ticks=1, touched=-1, expected=None):
    """Record of a trial on the exact model, with a disturbance added to its outputs."""
    outputs = SAMPLED.c.shape[0]
    measured = response(SAMPLED, drives) + SAMPLED.offset + disturbance
    course = Course(np.empty((0, outputs)) if expected is None else expected)
    for k in range(samples):
        seen = k - age_ticks
        course.note(k, drives[k], np.full(outputs, np.nan), PERIOD * seen if seen >= 0 else NEVER,
                    measured[max(seen, 0)], touched >= 0 and k >= touched)
    return course


def following(offsets, memory, touched=-1, blocked=(), weights=(1.0, 1.0, 1.0)):
    """Course of the first trial, and those after trials on the exact model that miss by (3,) rad each."""
    samples, courses = 80, [Course(np.empty((0, 3)))]
    for k, offset in enumerate(offsets):
        course = trial_of(samples, np.full((samples, 3), 0.01 * k), np.zeros((samples, 4)), touched=touched)
        course.wanted = [SAMPLED.offset + 0.01 * k + np.asarray(offset)] * samples
        course.expected, course.progress = courses[-1].expected, courses[-1].progress
        courses.append(memory.next_course(course, SAMPLED, PERIOD, blocked, np.array(weights)))
    return courses


@given(st.lists(st.integers(0, 350).map(lambda k: 0.01 * 1.013**k), min_size=1, max_size=10, unique=True))
@settings(deadline=None, max_examples=50)
def test_after_two_worse_trials_the_best_ones_expectations_are_used(errors):
    courses = following([[error] * 3 for error in errors], Memory(share=1.0))
    worse = [k > 0 and errors[k] > min(2.0 * (least := min(errors[:k])), max(1.5 * least, errors[k - 1]))
             for k in range(len(errors))]
    stops = next((k for k in range(1, len(errors)) if worse[k - 1] and worse[k]), None)
    assert [bool(course.pending) for course in courses] == [k - 1 == stops for k in range(len(courses))]
    if stops is not None:
        best = courses[int(np.argmin(errors[:stops + 1]))].expected
        for course in courses[stops + 1:]:
            np.testing.assert_array_equal(course.expected, best)
    assert not any(course.pending for course in following([[e] * 3 for e in errors], Memory(stop_after=0)))


def test_the_report_of_learning_that_stops_tells_errors():
    ((status, detail),) = following([[0.4] * 3, [0.1] * 3, [0.3] * 3, [0.3] * 3], Memory())[-1].pending
    assert status == "learning_stopped"
    assert detail == ("trials became worse (errors 23, 5.7, 17, 17 deg): from now on the expectations of the "
                      "one with 5.7 deg are used")


@given(st.tuples(*[st.floats(-0.5, 0.5)] * 3), st.tuples(*[st.floats(0.1, 2.0)] * 3))
@settings(deadline=None, max_examples=30)
def test_the_error_of_a_trial_is_weighted_and_leaves_out_what_an_object_blocks(offset, weights):
    (_, course) = following([offset], Memory(), weights=weights)
    told = np.sqrt(np.average(np.square(offset), weights=weights))
    assert course.progress.errors == [pytest.approx(told, abs=1e-9)]
    (_, course) = following([offset], Memory(), touched=0, blocked=(0, 2), weights=weights)
    assert course.progress.errors == [pytest.approx(abs(offset[1]), abs=1e-9)]
    assert following([offset], Memory(), touched=0)[1].progress.errors == []


def test_an_error_counts_until_the_tick_of_the_first_contact():
    samples, touched, memory = 80, 40, Memory()
    course = trial_of(samples, np.zeros((samples, 3)), np.zeros((samples, 4)), touched=touched)
    # The reference of a tick is that of the next one.
    course.wanted = [SAMPLED.offset + (0.2 if k + 1 < touched else 5.0) for k in range(samples)]
    following = memory.next_course(course, SAMPLED, PERIOD, (), np.ones(3))
    assert following.progress.errors == [pytest.approx(0.2, abs=1e-9)]


def test_a_trial_may_be_followed_by_more_than_one():
    memory, course = Memory(), trial_of(80, np.full((80, 3), 0.1), np.zeros((80, 4)))
    course.wanted = [SAMPLED.offset] * 80
    first, second = (memory.next_course(course, SAMPLED, PERIOD, (), np.ones(3)) for _ in range(2))
    assert first.progress.errors == second.progress.errors
    assert len(first.progress.errors) == 1
    assert course.progress.errors == []


def test_a_controller_notes_what_it_controls_and_tells_of_learning_that_has_stopped_once():
    mpc = Mpc(model=MODEL, current_ma=(40.0,) * 4, memory=Memory(), begin_s=0.1)
    state, tick = mpc.init(Context("mpc", clock=RateClock.from_rate("40"))), Tick()
    state.course.pending = (("learning_stopped", "trials became worse"),)
    for tick.index in range(8):
        tick.time_ns = tick.index * PERIOD
        ahead = np.tile(MODEL.offset + 0.01 * tick.index, (mpc.horizon, 1))
        preview, measured = (Sample(each, *[tick.time_ns] * 3) for each in (ahead, MODEL.offset))
        unwired = Sample(np.zeros(3), NEVER, NEVER, NEVER)
        mpc.step(state, [preview, unwired, measured, unwired], tick)
    told = [row for row in tick.reports if row[0] == "learning_stopped"]
    assert told == [("learning_stopped", "trials became worse")]
    wanted = np.array(state.course.wanted)
    assert np.isnan(wanted[:4]).all()  # 0.1 s
    np.testing.assert_allclose(wanted[4:, 0] - MODEL.offset[0], 0.01 * np.arange(4, 8))


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 1.0))
@settings(deadline=None, max_examples=30)
def test_the_disturbance_is_found_exactly_at_the_capture(seed, share):
    """One slower than the cut-off, read a tick late: expected again at the instant when it was captured."""
    rng, samples = np.random.default_rng(seed), 240
    times = np.arange(samples)[:, None] / 40.0
    disturbance = rng.normal(size=(1, 3)) + rng.normal(size=(1, 3)) * np.sin(2 * np.pi * 0.2 * times)
    drives = rng.uniform(0.0, 0.3, size=(samples, 4))
    memory = Memory(share=share, cutoff_hz=4.0)
    learnt = memory.learnt(trial_of(samples, disturbance, drives), SAMPLED, PERIOD, ())
    # No capture shows the last tick.
    np.testing.assert_allclose(learnt[:-20], share * disturbance[:-20], atol=0.02 * np.abs(disturbance).max())
    again = memory.learnt(trial_of(samples, disturbance, drives, expected=disturbance), SAMPLED, PERIOD, ())
    np.testing.assert_allclose(again, disturbance, atol=0.02 * np.abs(disturbance).max())


def test_what_an_object_blocks_is_not_learnt():
    samples, touched = 200, 120
    disturbance = np.full((samples, 3), 0.1)
    disturbance[touched:] = 0.5
    course = trial_of(samples, disturbance, np.zeros((samples, 4)), touched=touched)
    learnt = Memory(share=1.0).learnt(course, SAMPLED, PERIOD, (0, 1))
    np.testing.assert_allclose(learnt[:, :2], 0.1, atol=1e-6)
    assert learnt[touched + 40, 2] == pytest.approx(0.5, abs=0.02)


def test_gaps_non_finite_samples_and_missed_ticks_are_bridged():
    samples = 200
    drives = np.zeros((samples, 4))
    course = trial_of(samples, np.full((samples, 3), 0.2), drives)
    course.measured[50:80] = [np.full(3, np.nan)] * 30
    course.captured_ns[50:80] = [NEVER] * 30
    for kept in (course.indices, course.drives, course.captured_ns, course.measured):
        del kept[100:110]
    learnt = Memory(share=1.0).learnt(course, SAMPLED, PERIOD, ())
    assert learnt.shape == (samples, 3)
    np.testing.assert_allclose(learnt, 0.2, atol=1e-6)
    empty = Course(np.empty((0, 3)))
    assert Memory().learnt(empty, SAMPLED, PERIOD, ()).shape == (0, 3)


def test_stop_save_restore_continue_equals_uninterrupted():
    mpc = Mpc(model=MODEL, current_ma=(40.0,) * 4, memory=Memory())
    context = Context("mpc", clock=RateClock.from_rate("40"))
    rng = np.random.default_rng(1)

    def run(state, first, last):
        pulses, tick = [], Tick()
        for k in range(first, last):
            tick.index, tick.time_ns = k, k * PERIOD
            angles = MODEL.offset + 0.1 * np.sin(0.1 * k + np.arange(3))
            preview = np.tile(MODEL.offset + 0.2, (20, 1))
            inputs = [Sample(value, tick.time_ns, tick.time_ns, arrived) for value, arrived in (
                (preview, tick.time_ns), (np.zeros(3), NEVER), (angles, tick.time_ns), (np.zeros(0), NEVER))]
            pulses.append(mpc.step(state, inputs, tick)[0].copy())
        return np.array(pulses)

    state = mpc.init(context)
    run(state, 0, 100)
    state = mpc.next_trial(state, context)
    stopped = pickle.loads(pickle.dumps(state))
    whole = run(state, 0, 80)
    begun = run(stopped, 0, int(rng.integers(1, 79)))
    rest = run(pickle.loads(pickle.dumps(stopped)), len(begun), 80)
    np.testing.assert_array_equal(np.concatenate([begun, rest]), whole)


@pytest.mark.parametrize(("changes", "key"), [
    ({"share": 0.0}, "memory.share"), ({"share": 1.5}, "memory.share"),
    ({"share": float("nan")}, "memory.share"),
    ({"cutoff_hz": 0.0}, "memory.cutoff_hz"), ({"max_gap_ms": float("inf")}, "memory.max_gap_ms")])
def test_bad_parameters_are_named(changes, key):
    with pytest.raises(InputError, match=key):
        Memory(**changes)


@given(st.floats(0.1, 100.0), st.sampled_from(["25", "50", "100"]))
@example(25.0, "50")
def test_a_cut_off_beyond_half_the_rate_is_refused(cutoff_hz, rate):
    mpc = Mpc(model=MODEL, current_ma=(40.0,) * 4, horizon=40, memory=Memory(cutoff_hz=cutoff_hz))
    context = Context("control", clock=RateClock.from_rate(rate))
    if cutoff_hz < 0.5 * float(rate):
        mpc.init(context)
        return
    told = rf"control.memory.cutoff_hz: .* Hz; allowed: below {float(rate) / 2:g} Hz"
    with pytest.raises(InputError, match=told):
        mpc.init(context)


def test_memory_and_adaptation_exclude_each_other():
    with pytest.raises(InputError, match="memory: given beside adaptation"):
        Mpc(model=MODEL, current_ma=(40.0,) * 4, memory=Memory(), adaptation=StrengthAdaptation())

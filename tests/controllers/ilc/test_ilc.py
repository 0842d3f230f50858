import pickle
from itertools import pairwise

import numpy as np
import pytest

from controllers.ilc import Ilc
from controllers.ilc.parameters import Point
from controllers.reference import MinimumJerk
from controllers.safety import Safety
from estimators.fusion import VqfTracker
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.models.linear_model import LinearModel
from plants.finger import Finger
from plants.imus import FingerImus

RATE, SECONDS = "40", 4.0
CONTEXT = Context("ilc", clock=RateClock.from_rate(RATE))
NOMINAL = Finger()
ONE_MUSCLE = LinearModel(a=-np.eye(1), b=np.eye(1), c=np.eye(1), offset=np.zeros(1))
GRASP = MinimumJerk(times_s=(1.0, 2.0, 2.6, 3.6), angles_deg=(
    (20.0, 25.0, 15.0), (40.0, 55.0, 25.0), (40.0, 55.0, 25.0), (25.0, 32.0, 18.0)))


def learner(**changes):
    return Ilc(**{"model": NOMINAL.linear_model(), "current_ma": (40.0,) * 4, "duration_s": SECONDS,
                  "actuation_delay_ms": 5.0} | changes)


def loop_of(ilc, finger, *, latency_ms=20.0, tracker="vqf", recorder=None):
    nodes = [Node("reference", GRASP, RATE), Node("ilc", ilc, RATE), Node("safety", Safety(), RATE),
             Node("finger", finger)]
    wires = [Wire("reference.angles", "ilc.reference"), Wire("ilc.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("tracker.angles", "ilc.measured", latency_ms=latency_ms)]
    if tracker == "vqf":
        nodes += [Node("imus", FingerImus(), "100"),
                  Node("tracker", VqfTracker(initial_angles_deg=NOMINAL.rest_deg), "100")]
        wires += [Wire(f"finger.{port}", f"imus.{port}") for port in ("angles", "rates", "accelerations")]
        wires += [Wire(f"imus.{port}", f"tracker.{port}") for port in ("gyr", "acc")]
        wires.append(Wire("tracker.aligned", "safety.aligned"))
    else:
        nodes.append(Node("tracker", IdealTracker(), "100"))
        wires.append(Wire("finger.angles", "tracker.angles"))
    return Loop(Wiring(nodes, wires, seed=1), recorder=recorder)


def run_trials(loop, recorder, trials):
    """Joint RMSE of each trial, deg."""
    rmse = []
    for trial in range(trials):
        if trial:
            loop.next_trial()
        recorder.drain()
        loop.run_until(round(SECONDS * 1e9))
        rows = recorder.plants["finger"]
        times = np.concatenate([row[0] for row in rows]) / 1e9
        angles = np.concatenate([np.asarray(row[2][0]) for row in rows])
        error = np.degrees(angles - GRASP.angles_at(times))[times > 0.5]
        rmse.append(float(np.sqrt(np.mean(error**2))))
    return rmse


@pytest.mark.parametrize(("strength", "speed"), [(1.2, 1.15), (0.8, 0.85)])
def test_tracks_within_two_degrees_after_five_trials_with_a_tracker_and_a_wrong_model(strength, speed):
    recorder = Recorder("200")
    loop = loop_of(learner(), Finger(strength=strength, speed=speed), recorder=recorder)
    rmse = run_trials(loop, recorder, 6)
    loop.close()
    assert rmse[0] > 10.0
    assert rmse[5] < 2.0
    assert all(later < 1.1 * earlier + 0.1 for earlier, later in pairwise(rmse))


@pytest.mark.slow
def test_capture_stamps_take_latency_out_of_what_is_learnt():
    errors = {}
    for align in (True, False):
        recorder = Recorder("200")
        loop = loop_of(learner(align_captures=align), Finger(strength=0.8, speed=0.9), latency_ms=120.0,
                       tracker="ideal", recorder=recorder)
        errors[align] = run_trials(loop, recorder, 5)[-1]
        loop.close()
    assert errors[True] < 0.5
    assert errors[False] > 3.0 * errors[True]


def sample(value, captured_ns, now_ns):
    return Sample(np.asarray(value, dtype=float), captured_ns, captured_ns, now_ns)


UNWIRED_SD, UNWIRED_TRUST = Sample(np.zeros(3), NEVER, NEVER, NEVER), Sample(1.0, NEVER, NEVER, NEVER)
UNWIRED_FORCE = Sample(np.zeros(5), NEVER, NEVER, NEVER)


def at_rest(k):
    return np.radians(NOMINAL.rest_deg)


def steps(ilc, state, ticks, measured=at_rest, sd=lambda k: np.zeros(3), trusted=lambda k: 1.0,
          force=lambda k: np.zeros(5)):
    """Pulses (ticks, muscles, 2) and reports of steps with fresh samples."""
    tick, pulses = Tick(), []
    for k in range(*ticks):
        tick.index, now = k, CONTEXT.clock.tick(k)
        tick.time_ns = now
        goal = sample(GRASP.angles_at(np.array([now / 1e9]))[0], now, now)
        others = sample(measured(k), now, now), sample(sd(k), now, now), Sample(trusted(k), now, now, now), \
            sample(force(k), now, now)
        pulses.append(ilc.step(state, (goal, *others), tick)[0])
    return np.array(pulses), tick.reports


def test_an_early_end_leaves_the_rest_of_the_drives_alone():
    ilc = learner(first_drive=(0.2, 0.2, 0.2, 0.2), slew=1.0, law="noilc")
    state = ilc.init(CONTEXT)
    steps(ilc, state, (0, 60))
    after = ilc.next_trial(state, CONTEXT)
    np.testing.assert_allclose(after.drives[60:], state.drives[60:], atol=1e-9)
    assert np.abs(after.drives[:60] - state.drives[:60]).max() > 0.01


def test_a_trial_without_measurements_is_told_and_changes_nothing():
    ilc, tick = learner(first_drive=(0.1, 0.1, 0.1, 0.1)), Tick()
    state = ilc.init(CONTEXT)
    absent = Sample(np.zeros(3), NEVER, NEVER, NEVER)
    ilc.step(state, (sample(np.zeros(3), 0, 0), absent, UNWIRED_SD, UNWIRED_TRUST, UNWIRED_FORCE), tick)
    after = ilc.next_trial(state, CONTEXT)
    np.testing.assert_array_equal(after.drives, state.drives)
    _, reports = steps(ilc, after, (0, 2))
    assert [status for status, _ in reports] == ["no_valid_samples"]


def test_non_finite_measurements_are_told_and_left_out():
    ilc = learner()
    sound, broken = ilc.init(CONTEXT), ilc.init(CONTEXT)
    steps(ilc, sound, (0, 161))
    _, reports = steps(ilc, broken, (0, 161),
                       lambda k: np.full(3, np.nan) if k in (50, 51) else np.radians(NOMINAL.rest_deg))
    assert [status for status, _ in reports] == ["non_finite"]
    learnt = ilc.next_trial(sound, CONTEXT).drives
    np.testing.assert_allclose(ilc.next_trial(broken, CONTEXT).drives, learnt, atol=1e-6)


def test_last_drive_is_held_past_the_end_and_that_is_told():
    ilc = learner(first_drive=(0.1, 0.2, 0.3, 0.1))
    pulses, reports = steps(ilc, ilc.init(CONTEXT), (0, 164))
    np.testing.assert_array_equal(pulses[160:], np.tile(pulses[160], (4, 1, 1)))
    assert [status for status, _ in reports] == ["past_end"]


def test_state_pickles_and_learns_alike():
    ilc = learner()
    state = ilc.init(CONTEXT)
    steps(ilc, state, (0, 80))
    twin = pickle.loads(pickle.dumps(state))
    for each in (state, twin):
        steps(ilc, each, (80, 161))
    np.testing.assert_array_equal(ilc.next_trial(state, CONTEXT).pulses, ilc.next_trial(twin, CONTEXT).pulses)


@pytest.mark.parametrize(("faulty", "key"), [
    ({"current_ma": (40.0,)}, "current_ma"), ({"first_drive": (0.1,)}, "first_drive"),
    ({"change_weight": 0.0}, "change_weight"), ({"duration_s": float("nan")}, "duration_s"),
    ({"lead_ms": -1.0}, "lead_ms"), ({"cutoff_hz": -1.0}, "cutoff_hz"),
    ({"output_weight": (1.0,)}, "output_weight"), ({"forgetting": 1.0}, "forgetting"),
    ({"reject_share": 1.5}, "reject_share"), ({"gradient_step": 0.0}, "gradient_step"),
    ({"trial_charge_max_uc": 0.0}, "trial_charge_max_uc"), ({"sd_max_deg": float("inf")}, "sd_max_deg"),
    ({"law": "point_to_point"}, "points"), ({"points": (Point(at_s=1.0),)}, "points"),
    ({"strength_margin": 0.0}, "strength_margin"), ({"bank": (ONE_MUSCLE,)}, r"bank\[0\]")])
def test_names_the_faulty_key(faulty, key):
    with pytest.raises(InputError, match=key):
        learner(**faulty)


def test_low_pass_must_fit_the_rate():
    with pytest.raises(InputError, match="cutoff_hz"):
        learner(cutoff_hz=20.0).init(CONTEXT)


def test_a_point_after_the_trial_is_named():
    with pytest.raises(InputError, match=r"points\[1\].at_s"):
        learner(law="point_to_point", points=(Point(at_s=1.0), Point(at_s=4.1))).init(CONTEXT)


BROKEN = {
    "non_finite": {"measured": lambda k: np.full(3, np.nan) if k % 3 == 0 else at_rest(k)},
    "uncertain": {"sd": lambda k: np.full(3, np.pi if k % 3 == 0 else 0.01)},
    "untrusted": {"trusted": lambda k: float(k % 3 > 0)},
}


@pytest.mark.parametrize("status", BROKEN)
def test_a_bad_trial_is_rejected_and_told(status):
    ilc = learner(first_drive=(0.1,) * 4)
    state = ilc.init(CONTEXT)
    _, reports = steps(ilc, state, (0, 161), **BROKEN[status])
    assert {told for told, _ in reports} == {status}
    after = ilc.next_trial(state, CONTEXT)
    np.testing.assert_array_equal(after.drives, state.drives)
    _, reports = steps(ilc, after, (0, 1))
    assert [told for told, _ in reports] == ["trial_rejected"]
    assert "34 %" in reports[0][1]
    lenient = learner(first_drive=(0.1,) * 4, reject_share=0.5)
    assert np.abs(lenient.next_trial(state, CONTEXT).drives - state.drives).max() > 0.01


def test_nothing_is_learnt_from_the_first_touch_on():
    learnt = []
    for pressing in ({}, {"force": lambda k: np.full(5, 0.6 if k == 80 else 0.0)}):
        ilc = learner(law="noilc")
        state = ilc.init(CONTEXT)
        _, reports = steps(ilc, state, (0, 161), **pressing)
        assert [status for status, _ in reports] == ["contact"] * len(pressing)
        learnt.append(ilc.next_trial(state, CONTEXT).drives)
    assert np.abs(learnt[0][80:]).max() > 0.01
    np.testing.assert_allclose(learnt[1][80:], 0.0, atol=1e-9)
    assert np.abs(learnt[1][:80]).max() > 0.01


def test_nothing_is_learnt_or_driven_before_it_begins():
    ilc = learner(law="noilc_constrained", first_drive=(0.1,) * 4, begin_s=1.0)
    state = ilc.init(CONTEXT)
    begins = ilc.begins(CONTEXT.clock.tick(1))
    assert not state.drives[:begins].any()
    assert (state.drives[begins + 20:] == 0.1).all()
    wrong = lambda k: np.full(3, 3.0 if k < begins else np.nan)  # noqa: E731
    pulses, _ = steps(ilc, state, (0, 161), measured=wrong)
    assert not pulses[:begins].any()
    np.testing.assert_array_equal(ilc.next_trial(state, CONTEXT).drives, state.drives)
    steps(ilc, state := ilc.init(CONTEXT), (0, 161))
    after = ilc.next_trial(state, CONTEXT)
    assert not after.drives[:begins].any()
    assert np.abs(after.drives - state.drives).max() > 0.01
    found = learner(begin_s=4.0).faults(CONTEXT, Surroundings())
    assert [str(fault) for fault in found] == ["begin_s: 4 s; allowed: less than duration_s, 4 s"]


def test_in_contact_a_share_is_learnt_and_what_grasps_stays():
    changes = []
    for step in (1.0, 0.5):
        ilc = learner(law="noilc", slew=1.0, first_drive=(0.3,) * 4, grasping_outputs=(0,),
                      grasping_channels=(0,), grasping_step=step)
        state = ilc.init(CONTEXT)
        steps(ilc, state, (0, 161), force=lambda k: np.full(5, 0.6 if k == 80 else 0.0))
        changes.append(ilc.next_trial(state, CONTEXT).drives - state.drives)
    whole, half = changes
    assert np.abs(whole[90:150, 1:]).max() > 0.01
    np.testing.assert_allclose(half[80:161, 1:], 0.5 * whole[80:161, 1:], atol=1e-9)
    np.testing.assert_allclose(half[:80], whole[:80], atol=1e-9)
    np.testing.assert_array_equal(whole[80:161, 0], 0.0)


def test_one_doubtful_output_leaves_the_others_to_learn_from():
    ilc = learner(reject_share=0.4, law="noilc", slew=1.0)
    states = [ilc.init(CONTEXT) for _ in range(2)]
    for state, odd in zip(states, (0.5, -0.5), strict=True):
        steps(ilc, state, (0, 161), measured=lambda k, odd=odd: at_rest(k) + np.array([0.0, 0.0, odd]),
              sd=lambda k: np.array([0.01, 0.01, 3.0]))
    learnt = [ilc.next_trial(state, CONTEXT).drives for state in states]
    assert np.abs(learnt[0]).max() > 0.01
    np.testing.assert_array_equal(*learnt)


def test_forgetting_goes_back_to_the_first_drives_where_nothing_is_left_to_learn():
    ilc = learner(first_drive=(0.2,) * 4, slew=1.0, forgetting=0.25)
    state = ilc.init(CONTEXT)
    state.drives = state.drives + 0.1
    steps(ilc, state, (0, 161), measured=lambda k: GRASP.angles_at(np.array([k / 40.0]))[0])
    np.testing.assert_allclose(ilc.next_trial(state, CONTEXT).drives, 0.275, atol=1e-3)


def test_a_law_that_may_diverge_says_so_at_the_first_tick_and_only_then():
    ilc = learner(law="phase_lead", lead_ms=0.0, cutoff_hz=10.0)
    state = ilc.init(CONTEXT)
    _, reports = steps(ilc, state, (0, 161))
    ((status, detail),) = reports
    assert status == "may_diverge"
    assert "up to 0.00 times as strong" in detail
    assert steps(ilc, ilc.next_trial(state, CONTEXT), (0, 161))[1] == []
    assert learner().cautions(CONTEXT) == ()
    ((status, detail),) = learner(law="gradient", gradient_step=1.8).cautions(CONTEXT)
    assert status == "low_margin"
    assert "up to 1.11 times" in detail


def test_charge_of_a_trial_stays_within_its_budget():
    free, kept = (learner(slew=1.0, trial_charge_max_uc=budget) for budget in (np.inf, 150.0))
    spent = []
    for ilc in (free, kept):
        state = ilc.init(CONTEXT)
        steps(ilc, state, (0, 161))
        pulses = ilc.next_trial(state, CONTEXT).pulses
        spent.append(1e6 * np.prod(pulses, axis=2).sum(axis=0))
    assert spent[0].max() > 300.0
    assert spent[1].max() <= 150.0
    assert spent[1].max() > 100.0


@pytest.mark.slow
def test_the_bank_finds_the_patient_and_learns_faster_by_it():
    patient = Finger(strength=1.6, speed=0.8)
    bank = tuple(Finger(strength=strength, speed=speed).linear_model()
                 for strength in (0.6, 1.6) for speed in (0.8, 1.2))
    rmse, told = {}, []
    for name, models in (("alone", ()), ("bank", bank)):
        recorder = Recorder("200")
        loop = loop_of(learner(bank=models, first_drive=(0.1,) * 4), patient, tracker="ideal",
                       recorder=recorder)
        rmse[name] = run_trials(loop, recorder, 3)
        told += [event for event in recorder.events if "model_selected" in event]
        loop.close()
    assert rmse["bank"][1] < 0.7 * rmse["alone"][1]
    assert all(any("model 3: share 1.00" in str(part) for part in event) for event in told)
    assert len(told) == 1


@pytest.mark.parametrize("law", ["phase_lead", "gradient", "noilc", "newton", "point_to_point"])
def test_every_law_brings_the_finger_closer(law):
    points = tuple(Point(at_s=at) for at in (1.0, 2.0, 2.6, 3.6)) if law == "point_to_point" else ()
    recorder = Recorder("200")
    loop = loop_of(learner(law=law, points=points), Finger(strength=1.1, speed=0.95), tracker="ideal",
                   recorder=recorder)
    rmse = run_trials(loop, recorder, 4)
    loop.close()
    assert rmse[3] < 0.75 * rmse[0]

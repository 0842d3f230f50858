import pickle

import numpy as np
import pytest

from controllers.mpc import Mpc
from controllers.mpc.plan import Limits, Weights, free_optimum, make_plan
from controllers.reference import MinimumJerk
from controllers.safety import Safety
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
RATE = "40"
CONTEXT = Context("mpc", clock=RateClock.from_rate(RATE))
NOMINAL = Finger()
UNBOUNDED = Limits(np.full(3, -np.inf), np.full(3, np.inf), np.empty(0))
CURRENT_MA = (40.0, 40.0, 40.0, 40.0)
MOVES = MinimumJerk(times_s=(1.0, 2.0, 3.0, 4.0, 5.0), preview=20, angles_deg=(
    (20.0, 25.0, 15.0), (40.0, 55.0, 25.0), (40.0, 55.0, 25.0), (25.0, 32.0, 18.0), (25.0, 32.0, 18.0)))


def controller(**changes):
    return Mpc(model=NOMINAL.linear_model(), current_ma=CURRENT_MA, actuation_delay_ms=5.0, **changes)


def closed_loop(mpc, finger, *, latency_ms=20.0, reference=MOVES, seconds=6.0, noise_deg=0.2):
    """Times s, angles and reference in deg every 5 ms, drives, and events of a closed loop."""
    source = "preview" if reference.preview else "angles"
    target = "reference_preview" if reference.preview else "reference"
    nodes = [Node("reference", reference, RATE), Node("mpc", mpc, RATE), Node("safety", Safety(), RATE),
             Node("finger", finger), Node("tracker", IdealTracker(noise_deg=noise_deg), "100")]
    wires = [Wire(f"reference.{source}", f"mpc.{target}"), Wire("mpc.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("finger.angles", "tracker.angles"),
             Wire("tracker.angles", "mpc.measured", latency_ms=latency_ms)]
    recorder = Recorder("200")
    loop = Loop(Wiring(nodes, wires, seed=1), recorder=recorder)
    loop.run_until(round(seconds * 1e9))
    loop.close()
    rows = recorder.plants["finger"]
    times = np.concatenate([row[0] for row in rows]) / 1e9
    angles = np.degrees(np.concatenate([np.asarray(row[2][0]) for row in rows]))
    pulses = np.array([row[5][0] for row in recorder.blocks["mpc"]])
    return times, angles, np.degrees(reference.angles_at(times)), pulses, recorder.events


def sample(value, captured_ns, now_ns):
    return Sample(np.asarray(value, dtype=float), captured_ns, captured_ns, now_ns)


def test_unconstrained_equals_the_riccati_recursion():
    model, horizon = NOMINAL.linear_model().sampled(25 * MS, 5 * MS), 15
    weights = Weights(np.array([1.0, 2.0, 0.5]), 0.03, 0.01, 0.0)
    plan = make_plan(model, horizon, weights, UNBOUNDED)
    rng = np.random.default_rng(1)
    states, muscles = model.a.shape[0], 4
    x, previous = 0.1 * rng.standard_normal(states), rng.uniform(size=4)
    best = np.empty(horizon * muscles)
    free_optimum(plan.free, x, np.zeros(3), np.zeros((horizon, 3)), previous, best)
    a = np.block([[model.a, model.b], [np.zeros((muscles, states)), np.eye(muscles)]])
    b = np.vstack([model.b, np.eye(muscles)])
    shows = np.hstack([model.c, np.zeros((3, muscles))])
    drives = np.hstack([np.zeros((muscles, states)), np.eye(muscles)])
    stage = shows.T @ np.diag(weights.outputs) @ shows + weights.effort * drives.T @ drives
    value = stage
    for _ in range(horizon):
        gain = np.linalg.solve(weights.move * np.eye(muscles) + b.T @ value @ b, b.T @ value @ a)
        value = stage + a.T @ value @ (a - b @ gain)
    np.testing.assert_allclose(best[:muscles], previous - gain @ np.concatenate([x, previous]), atol=1e-8)


@pytest.mark.parametrize(("strength", "speed"), [(1.2, 1.15), (0.8, 0.85), (1.2, 0.85), (0.8, 1.15)])
def test_tracks_within_three_degrees_at_20_ms_with_a_wrong_model(strength, speed):
    times, angles, reference, _, _ = closed_loop(controller(), Finger(strength=strength, speed=speed))
    error = (angles - reference)[times > 0.5]
    assert np.sqrt(np.mean(error**2)) < 3.0


def test_leaves_no_offset_with_a_wrong_model():
    still = MinimumJerk(times_s=(0.0,), angles_deg=((38.0, 50.0, 24.0),))
    _, angles, reference, _, _ = closed_loop(controller(), Finger(strength=0.8, speed=0.85), reference=still,
                                             seconds=8.0, noise_deg=0.0)
    np.testing.assert_allclose(angles[-1], reference[-1], atol=1e-3)


@pytest.mark.slow
def test_daqp_and_osqp_steer_alike():
    runs = [closed_loop(controller(solver=name), Finger(strength=0.9), seconds=3.0)[1]
            for name in ("daqp", "osqp")]
    np.testing.assert_allclose(runs[0], runs[1], atol=0.05)


def test_drives_keep_their_box_and_slew():
    mpc = controller(slew=0.03, drive_max=0.25)
    far = MinimumJerk(times_s=(0.0,), angles_deg=((60.0, 80.0, 40.0),))
    _, _, _, pulses, _ = closed_loop(mpc, Finger(), reference=far, seconds=2.0)
    drives = np.array([NOMINAL.recruitment.fraction(pulse) for pulse in pulses])
    assert drives.max() == pytest.approx(0.25, abs=1e-6)
    assert np.abs(np.diff(drives, axis=0)).max() <= 0.03 + 1e-6


def steps(mpc, measured_at, ticks, state=None):
    """Pulses per tick and the reports; `measured_at(k, now)` gives the sample read at tick k."""
    state, tick, pulses = state or mpc.init(CONTEXT), Tick(), []
    unwired = Sample(np.zeros((20, 3)), NEVER, NEVER, NEVER)
    for k in range(*ticks):
        now = tick.time_ns = CONTEXT.clock.tick(k)
        goal = sample(np.radians([40.0, 55.0, 25.0]), now, now)
        pulses.append(mpc.step(state, (unwired, goal, measured_at(k, now), unwired), tick)[0])
    return np.array(pulses), state, tick.reports


def rest(_k, now):
    return sample(np.radians(NOMINAL.rest_deg), now, now)


def test_no_stimulation_before_the_first_measurement():
    pulses, _, reports = steps(controller(), lambda k, now: Sample(np.zeros(3), NEVER, NEVER, NEVER), (0, 3))
    assert not pulses.any()
    assert [status for status, _ in reports] == ["no_input"]


def test_it_commands_nothing_before_it_begins_and_knows_that():
    pulses, state, _ = steps(controller(begin_s=0.5), rest, (0, 20))
    assert not pulses.any()
    later, _, _ = steps(controller(begin_s=0.5), rest, (20, 40), state)
    fresh, _, _ = steps(controller(), rest, (0, 20))
    np.testing.assert_allclose(later[5], fresh[5], atol=2e-5)


@pytest.mark.parametrize("trouble", ["non_finite", "stale_input"])
def test_trouble_holds_then_ramps_to_zero_and_control_comes_back(trouble):
    mpc = controller(hold_ms=50.0, ramp_ms=100.0, max_age_ms=60.0)
    before, state, _ = steps(mpc, rest, (0, 20))
    readings = {"non_finite": lambda k, now: sample([0.1, np.nan, 0.1], now, now),
                "stale_input": lambda k, now: sample([0.1, 0.1, 0.1], now - 61 * MS, now)}
    during, _, reports = steps(mpc, readings[trouble], (20, 30), state)
    drives = np.array([NOMINAL.recruitment.fraction(pulse) for pulse in during])
    last = NOMINAL.recruitment.fraction(before[-1])
    expected = np.array([1.0, 1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0])[:, None] * last
    np.testing.assert_allclose(drives, expected, atol=1e-9)
    assert [status for status, _ in reports] == [trouble]
    after, _, reports = steps(mpc, rest, (30, 33), state)
    assert after[-1].any()
    assert reports == []


def test_state_pickles_and_goes_on_bit_for_bit():
    mpc, rng = controller(), np.random.default_rng(4)
    noise = 0.05 * rng.standard_normal((200, 3))

    def noisy(k, now):
        return sample(np.radians(NOMINAL.rest_deg) + noise[k], now - (k % 7) * 3 * MS, now)

    _, state, _ = steps(mpc, noisy, (0, 150))
    twin = pickle.loads(pickle.dumps(state))
    first, _, _ = steps(mpc, noisy, (150, 200), state)
    second, _, _ = steps(mpc, noisy, (150, 200), twin)
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(("faulty", "key"), [
    ({"current_ma": (40.0,)}, "current_ma"), ({"output_weight": (1.0,)}, "output_weight"),
    ({"horizon": 0}, "horizon"), ({"horizon": 501}, "horizon: 501; allowed: 1 to 500"),
    ({"max_age_ms": 60001.0}, "max_age_ms: 60001; allowed: at most 60000"),
    ({"begin_s": -1.0}, "begin_s: -1.0"),
    ({"move_weight": 0.0}, "move_weight"), ({"hold_ms": -1.0}, "hold_ms"),
    ({"cocontraction_weight": float("nan")}, "cocontraction_weight")])
def test_names_the_faulty_key(faulty, key):
    with pytest.raises(InputError, match=key):
        Mpc(**{"model": NOMINAL.linear_model(), "current_ma": CURRENT_MA} | faulty)


def test_takes_the_longest_horizon_and_age_that_it_names():
    longest = Mpc(model=NOMINAL.linear_model(), current_ma=CURRENT_MA, horizon=500, max_age_ms=60000.0)
    assert (longest.horizon, longest.max_age_ms) == (500, 60000.0)

"""Limits of predictive control: soft boxes, a budget of charge, programmes without an answer, bad input."""

import numpy as np
import osqp
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import linprog

from controllers.allocation import posture_within
from controllers.mpc import Mpc
from controllers.mpc.plan import KNEE_RAD, Limits, Weights, free_optimum, limits, make_plan
from controllers.quadratic_programme import Qp
from controllers.reference import MinimumJerk
from controllers.safety import Safety
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.finger import Finger

RATE, MS, N, MUSCLES, OUTPUTS = "40", 1_000_000, 20, 4, 3
CONTEXT = Context("mpc", clock=RateClock.from_rate(RATE))
NOMINAL = Finger()
MODEL = NOMINAL.linear_model()
SAMPLED = MODEL.sampled(25 * MS, 5 * MS)
WEIGHTS = Weights(np.ones(OUTPUTS), 0.01, 0.0, 1e-5)
FREE = np.full(OUTPUTS, np.inf)
FLEXED = MinimumJerk(times_s=(0.5, 1.5), preview=N, angles_deg=((20.0, 25.0, 15.0), (40.0, 55.0, 25.0)))


def controller(**changes):
    given = {"model": MODEL, "current_ma": (40.0,) * MUSCLES, "horizon": N, "actuation_delay_ms": 5.0}
    return Mpc(**given | changes)


def nodes_and_wires(mpc, *, latency_ms=20.0, reference=FLEXED, finger=NOMINAL):
    nodes = [Node("reference", reference, RATE), Node("mpc", mpc, RATE), Node("safety", Safety(), RATE),
             Node("finger", finger), Node("tracker", IdealTracker(noise_deg=0.0), "100")]
    wires = [Wire("reference.preview", "mpc.reference_preview"),
             Wire("mpc.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("finger.angles", "tracker.angles"),
             Wire("tracker.angles", "mpc.measured", latency_ms=latency_ms)]
    return nodes, wires


def closed_loop(mpc, seconds=4.0, **circumstances):
    """Angles in deg every 5 ms, and pulses a tick."""
    nodes, wires = nodes_and_wires(mpc, **circumstances)
    recorder = Recorder("200")
    Loop(Wiring(nodes, wires, seed=1), recorder=recorder).run_until(round(seconds * 1e9))
    angles = np.concatenate([np.asarray(row[2][0]) for row in recorder.plants["finger"]])
    return np.degrees(angles), np.array([row[5][0] for row in recorder.blocks["mpc"]]), recorder.events


def answer(greatest, x, reference, previous):
    """What the controller's programme answers: drives (N, muscles) and excesses (N, outputs)."""
    plan = make_plan(SAMPLED, N, WEIGHTS, Limits(-FREE, greatest, np.empty(0)))
    qp = Qp(plan.hessian, plan.rows, centred=True)
    best, (lower, upper) = np.empty(qp.size), np.empty((2, qp.constraints))
    free_optimum(plan.free, x, SAMPLED.offset, reference, previous, best)
    limits(np.ones(MUSCLES), np.full(MUSCLES, 0.2), previous, previous + 0.2, np.empty(0), plan.boxes,
           reference, best, lower, upper)
    result = qp.solve(best, lower, upper)
    assert result.solved
    return result.x[:N * MUSCLES].reshape(N, MUSCLES), result.x[N * MUSCLES:].reshape(N, OUTPUTS)


def predicted(x, drives):
    """Outputs at the N coming steps, step by step."""
    outputs = []
    for drive in drives:
        x = SAMPLED.a @ x + SAMPLED.b @ drive
        outputs.append(SAMPLED.c @ x + SAMPLED.offset)
    return np.array(outputs)


def hard_optimum(greatest, x, reference, previous):
    """Drives (N, muscles) within a hard box, by OSQP from a programme in states and drives; None if none."""
    states = SAMPLED.a.shape[0]
    drives, later = N * MUSCLES, N * states
    difference = sparse.eye(drives) - sparse.eye(drives, k=-MUSCLES)
    steady = SAMPLED.c @ np.linalg.solve(np.eye(states) - SAMPLED.a, SAMPLED.b)
    _, _, right = np.linalg.svd(steady)
    idle = right[OUTPUTS:].T @ right[OUTPUTS:]
    hessian = sparse.block_diag([WEIGHTS.move * difference.T @ difference + WEIGHTS.cocontraction *
                                 sparse.kron(sparse.eye(N), idle),
                                 sparse.kron(sparse.eye(N), SAMPLED.c.T @ SAMPLED.c)], format="csc")
    q = np.concatenate([np.zeros(drives), (-(reference - SAMPLED.offset) @ SAMPLED.c).ravel()])
    q[:MUSCLES] -= WEIGHTS.move * previous
    first = np.concatenate([-SAMPLED.a @ x, np.zeros(later - states)])
    rows = sparse.vstack([
        sparse.hstack([sparse.kron(sparse.eye(N), SAMPLED.b),
                       sparse.kron(sparse.eye(N, k=-1), SAMPLED.a) - sparse.eye(later)]),
        sparse.hstack([difference, sparse.csc_matrix((drives, later))]),
        sparse.hstack([sparse.eye(drives), sparse.csc_matrix((drives, later))]),
        sparse.hstack([sparse.csc_matrix((N * OUTPUTS, drives)), sparse.kron(sparse.eye(N), SAMPLED.c)]),
    ], format="csc")
    slew = np.full(drives, 0.2)
    moved = np.concatenate([previous, np.zeros(drives - MUSCLES)])
    boxes = np.tile(greatest - SAMPLED.offset, N)
    boxes[:SAMPLED.delay_steps * OUTPUTS] = np.inf
    solver = osqp.OSQP()
    solver.setup(sparse.triu(hessian, format="csc"), q, rows,
                 np.concatenate([first, moved - slew, np.zeros(drives), np.full(N * OUTPUTS, -np.inf)]),
                 np.concatenate([first, moved + slew, np.ones(drives), boxes]),
                 eps_abs=1e-9, eps_rel=1e-9, max_iter=200_000, polishing=True, verbose=False)
    found = solver.solve(raise_error=False)
    return found.x[:drives].reshape(N, MUSCLES) if found.info.status_val == 1 else None


@pytest.mark.slow
@settings(deadline=None, max_examples=15)
@given(st.lists(st.floats(0.0, 0.6), min_size=OUTPUTS, max_size=OUTPUTS), st.floats(0.05, 0.5),
       st.integers(0, 2**32))
def test_the_price_of_a_box_is_exact_where_the_box_can_be_kept(beyond, room, seed):
    rng = np.random.default_rng(seed)
    previous = rng.uniform(0.0, 0.3, MUSCLES)
    x = np.linalg.solve(np.eye(SAMPLED.a.shape[0]) - SAMPLED.a, SAMPLED.b @ previous)
    at_rest = SAMPLED.c @ x + SAMPLED.offset
    greatest = at_rest + room
    reference = np.tile(greatest + np.array(beyond), (N, 1))
    drives, excess = answer(greatest, x, reference, previous)
    assert excess.max() < 1e-6
    assert (predicted(x, drives)[SAMPLED.delay_steps:] <= greatest + 1e-6).all()
    hard = hard_optimum(greatest, x, reference, previous)
    np.testing.assert_allclose(predicted(x, drives), predicted(x, hard), atol=1e-4)


def test_a_posture_outside_its_box_comes_back_as_fast_as_it_can():
    previous = np.array([0.4, 0.4, 0.0, 0.0])
    x = np.linalg.solve(np.eye(SAMPLED.a.shape[0]) - SAMPLED.a, SAMPLED.b @ previous)
    outside = SAMPLED.c @ x + SAMPLED.offset
    greatest = outside - np.radians([15.0, 400.0, 400.0]) * [1.0, -1.0, -1.0]
    assert hard_optimum(greatest, x, np.tile(outside, (N, 1)), previous) is None
    drives, excess = answer(greatest, x, np.tile(outside, (N, 1)), previous)
    left = predicted(x, drives)[:, 0] - greatest[0]
    np.testing.assert_allclose(excess[SAMPLED.delay_steps:, 0],
                               np.maximum(left[SAMPLED.delay_steps:], 0.0), atol=1e-6)
    assert left[0] > 0.2
    assert left[-1] < 1e-3
    assert KNEE_RAD > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_angles_keep_their_box_in_the_loop_and_the_others_follow_their_reference(solver):
    boxed, _, events = closed_loop(controller(angle_max_deg=(30.0, np.inf, np.inf), solver=solver))
    freely, _, _ = closed_loop(controller())
    assert freely[:, 0].max() > 39.0
    assert 29.5 < boxed[:, 0].max() < 30.1
    assert boxed[-1, 1] == pytest.approx(55.0, abs=3.0)
    assert {status for _, _, status, _ in events} <= {"no_input", "saturated"}


@pytest.mark.parametrize("share", [0.9, 0.6])
def test_a_budget_of_charge_is_kept_over_every_horizon(share):
    _, pulses, _ = closed_loop(controller())
    unlimited_uc = 1e6 * (pulses[:, :, 0] * pulses[:, :, 1]).sum(axis=1)
    budget_uc = share * np.convolve(unlimited_uc, np.ones(N), "valid").max()
    _, pulses, events = closed_loop(controller(horizon_charge_max_uc=budget_uc))
    given_uc = 1e6 * (pulses[:, :, 0] * pulses[:, :, 1]).sum(axis=1)
    over_horizons = np.convolve(given_uc, np.ones(N), "valid")
    assert 0.9 * budget_uc < over_horizons.max() < 1.02 * budget_uc
    assert {status for _, _, status, _ in events} <= {"no_input", "saturated"}


def stepped(mpc, state, ticks):
    """Drives a tick (ticks, muscles) of a patient who lies at rest, and the reports."""
    tick, drives = Tick(), []
    unwired = Sample(np.zeros((N, OUTPUTS)), NEVER, NEVER, NEVER)
    goal, lying = np.radians([40.0, 55.0, 25.0]), np.radians(NOMINAL.rest_deg)
    for k in range(*ticks):
        now = tick.time_ns = CONTEXT.clock.tick(k)
        mpc.step(state, (unwired, Sample(goal, now, now, now), Sample(lying, now, now, now), unwired), tick)
        drives.append(state.drive.copy())
    return np.array(drives), tick.reports


def test_without_an_answer_the_last_plan_goes_on_to_its_end_and_is_then_ramped_to_zero():
    ample = controller(slew=0.02, horizon_charge_max_uc=1e3, hold_ms=50.0, ramp_ms=100.0)
    scant = controller(slew=0.02, horizon_charge_max_uc=45.0, hold_ms=50.0, ramp_ms=100.0)
    state = ample.init(CONTEXT)
    before, _ = stepped(ample, state, (0, 30))
    plan = state.fallback.planned[:N * MUSCLES].reshape(N, MUSCLES).copy()
    least_uc = sum(1e6 * ample.allocation().charge(np.maximum(before[-1] - 0.02 * (k + 1), 0.0)).sum()
                   for k in range(N))
    assert least_uc > 2.0 * 45.0  # no drives within the slew limit keep the budget
    during, reports = stepped(scant, state, (30, 30 + N + 12))
    assert [status for status, _ in reports if status != "saturated"] == ["infeasible"]
    np.testing.assert_allclose(during[:N - 1], plan[1:], atol=1e-6)
    np.testing.assert_allclose(during[N - 1:N + 5], plan[-1] * np.array([1, 1, 1, 0.75, 0.5, 0.25])[:, None],
                               atol=1e-6)
    assert during[N + 5:].max() < 1e-6
    again, reports = stepped(ample, state, (72, 75))
    assert again[-1].any()
    assert [status for status, _ in reports if status != "saturated"] == []


def test_a_budget_that_is_overspent_leaves_nothing_and_has_an_answer():
    """No drive at all keeps a budget as well as can be; it comes back when the window has room again."""
    ample, scant = (controller(slew=1.0, horizon_charge_max_uc=budget_uc) for budget_uc in (1e3, 45.0))
    state = ample.init(CONTEXT)
    before, _ = stepped(ample, state, (0, 30))
    during, reports = stepped(scant, state, (30, 30 + 2 * N))
    assert [status for status, _ in reports if status != "saturated"] == []
    given_uc = [1e6 * scant.allocation().charge(drive).sum() for drive in (*before, *during)]
    spent = np.array([sum(given_uc[k - N + 1:k]) >= 45.0 for k in range(30, 30 + 2 * N)])
    assert spent[0]
    assert not spent[-1]
    assert during[spent].max() < 1e-6
    assert during[~spent].max() > 0.01


@settings(deadline=None, max_examples=50)
@given(st.integers(1, 6), st.integers(1, 4), st.integers(0, 2**32), st.floats(0.01, 1.0))
def test_a_posture_is_within_a_box_if_a_linear_programme_in_states_finds_one(muscles, outputs, seed, wide):
    rng = np.random.default_rng(seed)
    states = muscles + outputs
    a = rng.standard_normal((states, states)) - 4.0 * np.eye(states)
    b, c = rng.standard_normal((states, muscles)), rng.standard_normal((outputs, states))
    model = type(MODEL)(a=a, b=b, c=c, offset=rng.standard_normal(outputs))
    reach = rng.uniform(0.1, 1.0, muscles)
    middle = model.offset + rng.standard_normal(outputs)
    found = posture_within(model, reach, middle - wide, middle + wide)
    # Unknowns x and v: a x + b v = 0, the outputs in their box.
    told = linprog(np.zeros(states + muscles), A_eq=np.hstack([a, b]), b_eq=np.zeros(states),
                   A_ub=np.block([[c, np.zeros((outputs, muscles))], [-c, np.zeros((outputs, muscles))]]),
                   b_ub=np.concatenate([middle + wide - model.offset, model.offset - middle + wide]),
                   bounds=[(None, None)] * states + [(0.0, most) for most in reach])
    assert (found is not None) == (told.status == 0)


def experiment(mpc, **circumstances):
    nodes, wires = nodes_and_wires(mpc, **circumstances)
    return Experiment(name="limits", nodes=tuple(nodes), wires=tuple(wires), duration_s=3.0)


def test_a_horizon_shorter_than_the_delay_of_model_and_loop_is_refused_when_the_experiment_is_made():
    experiment(controller(horizon=8), latency_ms=100.0, reference=preview(8))
    with pytest.raises(InputError) as told:
        experiment(controller(horizon=5), latency_ms=100.0, reference=preview(5))
    assert str(told.value) == (
        "blocks.mpc.horizon: 5 periods of 25 ms end before the delay of 125 ms does: 20 ms of the model, 105 "
        "ms of finger.angles -> tracker -> mpc -> safety -> finger.stimulation; allowed: 6 or more; lengthen "
        "the horizon by the duration of the movement")


def preview(periods):
    return MinimumJerk(times_s=(0.5, 1.5), preview=periods,
                       angles_deg=((20.0, 25.0, 15.0), (40.0, 55.0, 25.0)))


def test_a_horizon_shorter_than_the_delay_of_the_model_is_refused_without_a_loop():
    named = "mpc.horizon: 2 periods of 25 ms end before the delay of 65 ms does: .* 3 or more; lengthen"
    with pytest.raises(InputError, match=named):
        controller(horizon=2, actuation_delay_ms=45.0).init(CONTEXT)
    controller(horizon=3, actuation_delay_ms=45.0).init(CONTEXT)


def test_a_box_that_excludes_the_reference_is_refused_and_named():
    with pytest.raises(InputError) as told:
        experiment(controller(angle_max_deg=(30.0, 60.0, 40.0)))
    assert str(told.value) == (
        "blocks.mpc.angle_max_deg: the box of output 0 ends at 30 deg, its reference goes to 40 deg; "
        "allowed: boxes that hold the reference; widen the box or change the reference")
    experiment(controller(angle_max_deg=(40.0, 60.0, 40.0)))


def test_a_box_without_a_posture_that_can_be_kept_is_refused():
    mpc = controller(angle_min_deg=(-20.0, 80.0, -20.0), angle_max_deg=(-10.0, 90.0, -10.0), drive_max=0.2)
    with pytest.raises(InputError, match=r"angle_min_deg: .* no posture that the model can keep .*; widen"):
        mpc.init(CONTEXT)


def test_a_posture_at_rest_outside_its_box_is_a_caution():
    ((status, detail),) = controller(angle_min_deg=(25.0, 0.0, 0.0)).cautions(CONTEXT)
    assert (status, "output 0 at 20 deg" in detail) == ("rest_outside_limits", True)
    assert controller(angle_min_deg=(5.0, 0.0, 0.0)).cautions(CONTEXT) == ()
    assert controller().faults(CONTEXT, Surroundings()) == ()


@pytest.mark.parametrize(("faulty", "message"), [
    ({"angle_min_deg": (0.0, 0.0)}, "angle_min_deg: 2 angles; allowed: 3"),
    ({"angle_min_deg": (9.0,) * 3, "angle_max_deg": (8.0,) * 3}, "output 0 from 9 to 8 deg; .*; widen"),
    ({"angle_max_deg": (float("nan"),) * 3}, "angle_min_deg"),
    ({"drive_max": 0.001}, "drive_max: 0.001; allowed: 0.01 or more; raise"),
    ({"width_max_us": 20.0}, "recruits less than 0.01 of muscle .*; raise"),
    ({"charge_rise_uc": 0.02}, "charge_rise_uc: 0.02 uC a tick never brings muscle 0 from rest .* raise"),
    ({"horizon_charge_max_uc": 10.0}, "10 uC over 20 pulses recruit less than 0.01 of any muscle; .*; raise"),
    ({"horizon_charge_max_uc": 90.0, "solver": "osqp"}, "solver: 'osqp' .*; allowed: daqp"),
    ({"output_weight": (0.0,) * 3}, "output_weight")])
def test_limits_that_contradict_each_other_are_named_with_a_remedy(faulty, message):
    with pytest.raises(InputError, match=message):
        controller(**faulty)


@pytest.mark.parametrize("rate", [0.0, 1e-13, -1e-14])
def test_a_model_that_sums_up_its_input_is_refused(rate):
    a = np.diag([-5.0, rate])
    a[1, 0] = 1.0
    model = type(MODEL)(a=a, b=np.array([[5.0], [0.0]]), c=np.array([[0.0, 1.0]]), offset=np.zeros(1))
    with pytest.raises(InputError, match=r"model: a pole at .* 1/s: it never comes to rest"):
        controller(model=model, current_ma=(40.0,))

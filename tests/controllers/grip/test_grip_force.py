"""Grip force control against the linear loop that it is in logarithms, and whatever may come in."""

import math
import pickle

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.grip import Contact, ForceLoop, GripForce, Slip
from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERTIPS
from fesloop.hand.grip import grip_force
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

CONTEXT = Context("grip", clock=RateClock.from_rate("40"))
PERIOD_S, PERIOD_NS, MS = 0.025, 25_000_000, 1_000_000
BASE = np.array([[10e-3, 200e-6], [12e-3, 250e-6], [20e-3, 300e-6]])
NOTHING = Sample(0.0, NEVER, NEVER, NEVER)


def sample(value, time_ns):
    value = value if isinstance(value, float) else np.asarray(value, dtype=float)
    return Sample(value, time_ns, time_ns, time_ns)


def block(**changes):
    return GripForce(**{"channels": 3, "places": FINGERTIPS, "closing": (0, 1), "target_n": 4.0} | changes)


def fingertips(grip_n):
    return np.array([grip_n, 0.3 * grip_n, 0.2 * grip_n, 0.1 * grip_n, 0.0])


class Feed:
    """Steps a block, tick by tick."""

    def __init__(self, grip, state=None, tick=0):
        self.grip, self.state, self.number = grip, state or grip.init(CONTEXT), tick
        self.tick = Tick()

    def step(self, force, base=BASE, reference=NOTHING, age_ms=0):
        self.tick.index, self.tick.time_ns = self.number, self.number * PERIOD_NS
        self.number += 1
        now = self.tick.time_ns
        return self.grip.step(self.state, (sample(base, now), sample(force, now - age_ms * MS), reference),
                              self.tick)

    @property
    def statuses(self):
        return [status for status, _ in self.tick.reports]


def muscle_loop(grip, seconds, strength=lambda t: 2.0, exponent=3.0, lag_s=0.21, delay_ticks=3):
    """Grip force by tick of a muscle: force strength s^exponent, its logarithm behind a lag and a delay."""
    feed, log_force, scales, rows = Feed(grip), math.log(strength(0.0)), [0.0] * delay_ticks, []
    kept = math.exp(-PERIOD_S / lag_s)
    for k in range(round(seconds / PERIOD_S)):
        pulses, _, wanted, scale = feed.step(fingertips(math.exp(log_force)))
        rows.append((math.exp(log_force), wanted, scale, pulses[0, 1]))
        scales.append(math.log(scale))
        target = math.log(strength(k * PERIOD_S)) + exponent * scales.pop(0)
        log_force = kept * log_force + (1.0 - kept) * target
    return np.array(rows), feed


def closed_by_theory(gains, ticks, exponent=3.0, lag_s=0.21, delay_ticks=3):
    """Step response of the loop in logarithms, by python-control alone."""
    z = control.tf([1.0, 0.0], [1.0], PERIOD_S)
    plant = control.c2d(control.tf([exponent], [lag_s, 1.0]), PERIOD_S, "zoh") * z**-delay_ticks
    pi = gains.kp + gains.kp * PERIOD_S / gains.integral_s / (z - 1.0)
    return control.step_response(control.feedback(plant * pi), T=np.arange(ticks) * PERIOD_S)[1]


def test_force_follows_the_linear_loop_in_logarithms():
    contact = Contact(lasts_ms=0.0)
    rows, _ = muscle_loop(block(rise_n_per_s=1e6, contact=contact, slip=Slip(change_n=math.inf)), 3.0)
    gains = ForceLoop().gains(PERIOD_S)
    wanted = 2.0 * 2.0 ** closed_by_theory(gains, len(rows))
    np.testing.assert_allclose(rows[:, 0], wanted, rtol=1e-9)
    assert rows[-1, 0] == pytest.approx(4.0, rel=1e-3)


@pytest.mark.parametrize("exponent", [2.0, 3.0, 4.0])
def test_it_settles_with_a_third_more_and_less_gain(exponent):
    rows, _ = muscle_loop(block(), 8.0, exponent=exponent)
    assert rows[-80:, 0] == pytest.approx(4.0, rel=0.02)
    assert rows[:, 0].max() < 1.35 * 4.0


def test_fatigue_leaves_the_error_of_a_type_one_loop():
    """Strength falls by 3 % a second: e = rate Ti / (kp exponent) at rest, less while scale has room."""
    rows, _ = muscle_loop(block(), 30.0, strength=lambda t: 4.0 * math.exp(-0.03 * t))
    gains = ForceLoop().gains(PERIOD_S)
    expected = 0.03 * gains.integral_s / (gains.kp * 3.0)
    assert np.log(4.0 / rows[-1, 0]) == pytest.approx(expected, rel=0.02)
    open_loop = 4.0 * math.exp(-0.03 * 30.0)
    assert rows[-1, 0] > 2.0 * open_loop


def test_strength_that_is_spent_winds_nothing_up():
    grip = block(contact=Contact(force_n=0.2), slip=Slip(change_n=math.inf))
    rows, _ = muscle_loop(grip, 20.0, strength=lambda t: 0.4 if t < 10.0 else 2.0)
    assert rows[390, 2] == 2.0
    # The step response of the loop is over 1.5 s after the muscle is strong again.
    assert rows[400:, 0].max() > 1.7 * 4.0
    assert rows[460:, 0] == pytest.approx(4.0, rel=0.1)


def test_before_contact_what_comes_in_goes_out():
    feed = Feed(block())
    for grip_n in (0.0, 0.3, 0.45, 0.9, 0.9, 0.0, 0.9, 0.9):
        pulses, _, wanted, scale = feed.step(fingertips(grip_n))
        np.testing.assert_array_equal(pulses, BASE)
        assert (wanted, scale) == (0.0, 1.0)
    assert feed.statuses == []


def test_hand_over_is_without_a_jump_and_others_are_left_alone():
    feed = Feed(block())
    before = BASE
    for _ in range(20):
        pulses, _, wanted, _ = feed.step(fingertips(1.0))
        assert np.abs(pulses[:2, 1] / before[:2, 1] - 1.0).max() < 0.06
        np.testing.assert_array_equal(pulses[2], BASE[2])
        np.testing.assert_array_equal(pulses[:, 0], BASE[:, 0])
        before = pulses
    assert feed.statuses == ["contact"]
    assert wanted == pytest.approx(1.0 + 4.0 * 0.025 * 16)


def test_wanted_force_is_that_of_the_weight_or_of_a_wire():
    assert grip_force(fingertips(2.0), FINGERTIPS) == 2.0
    assert grip_force(np.array([0.5, 1.0, 1.0, 0.5, 0.0]), FINGERTIPS) == 2.5
    feed = Feed(block(target_n=None, mass_kg=0.3, friction=0.6, margin=1.4))
    for _ in range(200):
        wanted = feed.step(fingertips(3.0))[2]
    assert wanted == pytest.approx(1.4 * 0.3 * 9.80665 / 1.2)
    feed = Feed(block())
    for _ in range(300):
        wanted = feed.step(fingertips(3.0), reference=sample(50.0, 0))[2]
    assert wanted == 20.0


def test_slips_raise_what_is_wanted_and_noise_does_not():
    rng = np.random.default_rng(1)
    feed = Feed(block())
    for _ in range(400):
        feed.step(fingertips(4.0) + 0.02 * rng.standard_normal(5))
    assert "slip" not in feed.statuses
    for k in range(40):
        wanted = feed.step(fingertips(4.0) + (0.3 if k % 2 else 0.0))[2]
    assert feed.statuses.count("slip") == 3
    assert wanted > 4.0 * 1.15**2
    for _ in range(600):
        wanted = feed.step(fingertips(4.0))[2]
    assert wanted == pytest.approx(4.0 * 1.15 ** feed.statuses.count("slip"))


@pytest.mark.parametrize("settling", [
    lambda t: [min(t, 0.8), 0.0], lambda t: [10.0 * t, 0.0], lambda t: [2.5 * (t > 0.5), -0.5 * (t > 0.5)],
    lambda t: [1.5 * math.sin(4.0 * math.pi * t) * math.exp(-t), 0.0],
    lambda t: [2.0 * (0.5 < t < 0.6), -0.5 * (0.5 < t < 0.6)]],
    ids=["reaches its target", "rises fast", "another part takes over", "a loop that rings", "a bounce"])
def test_a_grip_that_settles_does_not_slip(settling):
    """Force of 4 N on five sensors, with noise, and what settling adds to two of them."""
    rng, feed = np.random.default_rng(2), Feed(block())
    for _ in range(200):
        feed.step(fingertips(4.0))
    for k in range(80):
        extra = np.concatenate([settling(k * PERIOD_S), np.zeros(3)])
        feed.step(np.maximum(fingertips(4.0) + extra + 0.02 * rng.standard_normal(5), 0.0))
    assert feed.statuses == ["contact"]


@settings(max_examples=60, deadline=None)
@given(hz=st.floats(11.0, 18.0), swing_n=st.floats(0.35, 2.0), sensor=st.integers(0, 2),
       phase=st.floats(0.0, 6.0))
def test_a_tremble_faster_than_muscles_is_a_slip_wherever_it_is_felt(hz, swing_n, sensor, phase):
    feed = Feed(block())
    for _ in range(200):
        feed.step(fingertips(4.0))
    for k in range(40):
        force = fingertips(4.0)
        force[sensor] += swing_n * (1.0 + math.sin(2.0 * math.pi * hz * k * PERIOD_S + phase))
        feed.step(force)
    slips = [detail for status, detail in feed.tick.reports if status == "slip"]
    assert len(slips) >= 2
    assert f"on {FINGERTIPS[sensor]} turned 4 times" in slips[0]


def test_letting_go_is_not_opposed():
    feed = Feed(block())
    for _ in range(40):
        _, _, _, before = feed.step(fingertips(3.0))
    for share in np.linspace(0.85, 0.0, 20):
        base = BASE * (1.0, share)
        pulses, _, _, scale = feed.step(fingertips(3.0 * share), base)
        assert scale <= before + 1e-12
        assert (pulses[:2, 1] <= before * base[:2, 1] + 1e-12).all()
    for _ in range(40):
        pulses, _, wanted, scale = feed.step(fingertips(0.0))
    assert feed.statuses == ["contact", "contact_lost"]
    assert (wanted, scale) == (0.0, 1.0)
    np.testing.assert_array_equal(pulses, BASE)


def test_posture_control_that_gives_less_while_the_hand_closes_does_not_release():
    """As learnt drives do that overshoot as the fingers arrive: the force is controlled all the same."""
    feed = Feed(block())
    for _ in range(10):
        feed.step(fingertips(1.0))
    for _ in range(60):
        pulses, _, wanted, scale = feed.step(fingertips(1.0), BASE * (1.0, 0.75))
    assert wanted == 4.0
    assert scale == 2.0
    np.testing.assert_allclose(pulses[:2, 1], np.minimum(2.0 * 0.75 * BASE[:2, 1], 500e-6))
    for share in np.linspace(0.6, 0.0, 20):
        before, scale = scale, feed.step(fingertips(1.0), BASE * (1.0, share))[3]
        assert scale <= before + 1e-12


@pytest.mark.parametrize(("how", "status"), [
    ({"force": fingertips(math.nan)}, "non_finite_force"), ({"force": fingertips(3.0), "age_ms": 250},
                                                            "stale_force"),
    ({"force": fingertips(5e3)}, "implausible_force")])
def test_forces_that_fail_end_in_what_comes_in(how, status):
    feed = Feed(block())
    for _ in range(80):
        feed.step(fingertips(3.0))
    scales = [feed.step(**how)[3] for _ in range(20)]
    assert (np.diff(scales) <= 0.0).all()
    assert scales[-1] == 1.0
    np.testing.assert_array_equal(feed.step(**how)[0], BASE)
    assert feed.statuses == ["contact", status]


def test_without_forces_reference_or_stimulation_a_status_says_so():
    grip, tick = block(target_n=None), Tick()
    state = grip.init(CONTEXT)
    never = Sample(np.zeros(5), NEVER, NEVER, NEVER)
    np.testing.assert_array_equal(grip.step(state, (sample(BASE, 0), never, NOTHING), tick)[0], BASE)
    grip.step(state, (sample(BASE, 0), sample(fingertips(3.0), 0), NOTHING), tick)
    bad = sample(BASE * np.nan, 0)
    assert not grip.step(state, (bad, sample(fingertips(3.0), 0), NOTHING), tick)[0].any()
    assert [status for status, _ in tick.reports] == ["no_force", "no_reference", "no_stimulation"]


@pytest.mark.slow
@given(data=st.data(), cap=st.floats(2.0, 20.0))
@settings(max_examples=20, deadline=None)
def test_limits_are_kept_whatever_comes_in(data, cap):
    """Sane numbers and any others, in any order; what is not closing is never more than what comes in."""
    grip = block(charge_max_uc=cap, width_max_us=400.0, contact=Contact(lasts_ms=0.0))
    feed = Feed(grip)
    numbers = st.one_of(st.floats(0.0, 30.0), st.floats(allow_nan=True, allow_infinity=True))
    widths = st.one_of(st.floats(0.0, 1e-3), st.floats(allow_nan=True, allow_infinity=True))
    for _ in range(12):
        force = data.draw(st.lists(numbers, min_size=5, max_size=5))
        base = np.column_stack([[10e-3, 60e-3, 30e-3], data.draw(st.lists(widths, min_size=3, max_size=3))])
        pulses, grip_n, wanted, scale = feed.step(force, base)
        assert np.isfinite(pulses).all()
        assert (pulses >= 0.0).all()
        assert (pulses[:, 1] <= 400e-6 * (1.0 + 1e-12)).all()
        assert (pulses[:, 0] * pulses[:, 1] <= 1e-6 * cap * (1.0 + 1e-12)).all()
        assert 0.3 - 1e-12 <= scale <= 2.0 + 1e-12
        assert 0.0 <= wanted <= max(grip.force_max_n, grip_n)
        if np.isfinite(base).all():
            assert pulses[2, 1] <= max(base[2, 1], 0.0)


def test_saved_and_restored_it_goes_on_bit_for_bit():
    grip, rng = block(), np.random.default_rng(3)
    one = Feed(grip)
    for _ in range(10):
        one.step(fingertips(3.0 + rng.standard_normal()))
    other = Feed(grip, pickle.loads(pickle.dumps(one.state)), one.number)
    for _ in range(20):
        force = fingertips(3.0 + rng.standard_normal())
        told, again = one.step(force), other.step(force)
        np.testing.assert_array_equal(told[0], again[0])
        assert told[1:] == again[1:]


@pytest.mark.parametrize(("make", "where"), [
    (lambda: block(closing=(0, 0)), "closing"), (lambda: block(closing=(3,)), "closing"),
    (lambda: block(places=("F9",)), "places"), (lambda: block(mass_kg=0.2), "target_n"),
    (lambda: block(margin=0.0), "margin"), (lambda: block(target_n=math.inf), "target_n"),
    (lambda: ForceLoop(scale_min=1.2), "loop.scale_max"), (lambda: ForceLoop(exponent=0.0), "loop.exponent"),
    (lambda: Contact(force_n=0.0), "contact.force_n"), (lambda: Slip(raise_by=0.9), "slip.raise_by"),
    (lambda: Slip(change_n=math.nan), "slip.change_n"), (lambda: Slip(turns=0), "slip.turns"),
    (lambda: Slip(within_ms=-1.0), "slip.within_ms")])
def test_parameters_that_cannot_be_are_named(make, where):
    with pytest.raises(InputError) as fault:
        make()
    assert fault.value.where == where


def test_a_scale_that_is_set_once_stays():
    rows, _ = muscle_loop(block(set_within_s=3.0), 10.0, strength=lambda t: 3.0 * math.exp(-0.05 * t))
    assert rows[110, 0] == pytest.approx(4.0, rel=0.1)
    assert np.ptp(rows[130:, 2]) == 0.0
    assert rows[-1, 0] == pytest.approx(rows[160, 0] * math.exp(-0.05 * 239 / 40), rel=1e-3)


def test_a_scale_that_is_set_once_reacts_to_no_slip():
    feed = Feed(block(set_within_s=1.0))
    for k in range(200):
        wanted = feed.step(fingertips(4.0) + (0.5 if k % 2 and k > 60 else 0.0))[2]
    assert feed.statuses == ["contact"]
    assert wanted == 4.0

"""The search for currents and the answers to stairs, on hands whose answer is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.identification.excitation import RESTING, SEARCHING, Answers, CurrentSearch, Excitation
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Sample

RATE_HZ = 50
SHORT = {"lead_s": 0.5, "stairs": 4, "stair_s": 0.2, "rest_s": 0.4, "prbs_s": 4.0, "bit_s": 0.2,
         "width_us": ((60.0, 300.0),) * 2, "current_ma": (10.0, 10.0)}
SEARCH = CurrentSearch(stair_s=0.2, rest_s=0.2, above_threshold=(2.0,), step_ma=0.5)


def played(block, gains_deg_per_mc, moved_at_ma=0.0):
    """(pulses, phases) against a hand that moves at once, with charge above a threshold."""
    block = block.resolve({"measured": (len(gains_deg_per_mc),)})
    state, tick, seen = block.init(Context("excitation", 0)), Tick(), []
    angles = np.zeros(len(gains_deg_per_mc))
    for k in range(int((block.duration_s + 0.5) * RATE_HZ)):
        tick.index, tick.time_ns = k, k * 10**9 // RATE_HZ
        pulses, phase = block.step(state, (Sample(angles, tick.time_ns, tick.time_ns, tick.time_ns),), tick)
        over_ma = np.maximum(1e3 * pulses[:, 0] - moved_at_ma, 0.0) * (pulses[:, 1] > 0.0)
        angles = np.radians(gains_deg_per_mc * over_ma * 1e6 * pulses[:, 1] / 200.0)
        seen.append((pulses, phase))
    return np.array([pulses for pulses, _ in seen]), np.array([phase for _, phase in seen])


@pytest.mark.slow
@given(threshold_ma=st.floats(1.0, 6.0))
def test_the_current_found_is_so_many_times_the_threshold(threshold_ma):
    block = Excitation(**SHORT, current_search=SEARCH, prbs_us=((100.0, 200.0),) * 2)
    pulses, phase = played(block, np.array([20.0, 20.0]), threshold_ma)
    # 5 deg are .25 mA above the threshold: the first stair beyond that answers.
    answering = np.arange(2.0, 10.1, 0.5)
    first = answering[answering - threshold_ma > 0.25][0]
    used = 1e3 * pulses[phase >= 0.0, :, 0].max(axis=0)
    np.testing.assert_allclose(used, min(10.0, 2.0 * first))
    assert not pulses[phase == SEARCHING, 1].any() or (1e3 * pulses[phase == SEARCHING, :, 0].max() <= 10.0)


def test_a_hand_that_never_answers_gets_the_greatest_current_and_every_turn_lasts_as_long():
    block = Excitation(**SHORT, current_search=SEARCH, prbs_us=((100.0, 200.0),) * 2)
    deaf, phase = played(block, np.zeros(2))
    assert 1e3 * deaf[phase == 2.0, :, 0].max() == 10.0
    _, quick = played(block, np.full(2, 1e3))
    np.testing.assert_array_equal(phase, quick)
    assert phase[0] == RESTING


def test_binary_widths_are_those_that_move_weak_and_strong_hands_alike():
    block = Excitation(**SHORT, answer_deg=(2.0, 10.0))
    pulses, phase = played(block, np.array([1.0, 4.0]))
    binary = 1e6 * pulses[phase == 2.0, :, 1]
    # 10 mA for w us are gain * 10 * w / 200 deg: 10 deg at 200 and 50 us; stairs begin at 60 us, answered by
    # 3 and 12 deg.
    assert binary[:, 0].max() == pytest.approx(200.0, rel=0.02)
    assert binary[:, 1].max() < 120.0
    assert (binary.min(axis=0) <= 0.8 * binary.max(axis=0) + 1e-9).all()


@given(st.lists(st.floats(0.0, 0.5), min_size=3, max_size=8), st.floats(0.01, 0.1), st.floats(0.11, 0.4))
def test_widths_stay_within_their_bounds_whatever_the_answers(moved, least, most):
    answers = Answers.none(1, len(moved))
    for stair, angle in enumerate([0.0, *moved]):
        answers.note(0, max(stair - 1, 0), np.array([angle]))
    ((low, high),) = answers.widths(np.array([[50e-6, 300e-6]]), np.array([least, most]))
    assert 0.0 < low <= 0.8 * high + 1e-15
    assert high <= 300e-6 + 1e-15


@pytest.mark.parametrize(("changes", "key"), [
    ({"answer_deg": (5.0, 2.0)}, "answer_deg"),
    ({"answer_deg": (2.0, 10.0), "recruitment": "ramp"}, "answer_deg"),
    ({"answer_deg": (2.0, 10.0), "prbs_us": ((100.0, 200.0),) * 2}, "answer_deg"),
    ({"current_search": CurrentSearch(above_threshold=(1.0, 2.0, 3.0))}, "above_threshold")])
def test_names_what_cannot_be(changes, key):
    with pytest.raises(InputError, match=key):
        Excitation(**SHORT | changes)


@pytest.mark.parametrize("changes", [{"width_us": 0.0}, {"step_ma": -1.0}, {"above_threshold": (0.5,)},
                                     {"stair_s": 0.0}, {"response_deg": float("nan")}])
def test_names_a_faulty_search(changes):
    with pytest.raises(InputError, match=next(iter(changes))):
        CurrentSearch(**changes)

"""Steps of the hand in one call of compiled code against `mj_step`'s own, one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import RunError
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS
from plants.hand.assist import Assistance
from plants.hand.plant import Hand
from plants.hand.scene import GraspObject, Table

SCENES = {
    "free": Hand(),
    "falling": Hand(object=GraspObject(position_m=(0.3, 0.3, -99.99))),
    "table": Hand(object=GraspObject(position_m=(0.2, 0.1, -0.06)),
                  table=Table(height_m=-0.121, lowered_at_s=0.01)),
    "held": Hand(assist=Assistance(until_s=0.02, release_s=0.01), settle_s=1.0),
    "given": Hand(object=GraspObject(given_at_s=0.01)),
}


def bits(state):
    """Everything that the next step depends on."""
    views = state.views
    return [array.tobytes() for array in (views.qpos, views.qvel, views.qacc_warmstart, views.userdata)], \
        state.time_ns, state.given


@given(st.sampled_from(sorted(SCENES)), st.lists(st.integers(1, 12), min_size=1, max_size=5),
       st.lists(st.booleans(), min_size=5, max_size=5), st.integers(0, 99))
@settings(max_examples=40, deadline=None)
def test_steps_at_once_are_steps_one_by_one_to_the_bit(scene, counts, reads, seed):
    hand, rng = SCENES[scene], np.random.default_rng(seed)
    one, many, now, taken = hand.init(Context("hand")), hand.init(Context("hand")), 0, 0
    for count, reading in zip(counts, reads, strict=False):
        activation = list(rng.uniform(-0.1, 1.1, (count, len(MUSCLES))))
        times = [now + (k + 1) * NS_PER_MS for k in range(count)]
        for values, instant in zip(activation, times, strict=True):
            hand.advance(one, [values], instant - NS_PER_MS, instant)
        if hand.advance_steps(many, [activation], now, times):
            taken += count
        else:
            hand.advance(many, [activation[0]], now, times[0])
            for values, instant in zip(activation[1:], times[1:], strict=True):
                hand.advance(many, [values], instant - NS_PER_MS, instant)
        now = times[-1]
        assert bits(one) == bits(many)
        if reading:
            for value, other in zip(hand.read(one, ()), hand.read(many, ()), strict=True):
                assert np.asarray(value).tobytes() == np.asarray(other).tobytes()
    assert taken == now // NS_PER_MS or (scene in ("given", "held") and now > 10 * NS_PER_MS)


def step_through(hand, state, activation, times):
    """Take the steps that end at `times` one by one."""
    for before, instant in zip([0, *times], times, strict=False):
        hand.advance(state, [activation], before, instant)


def test_an_unstable_simulation_is_left_to_single_steps_which_say_when_it_fails():
    hand = Hand(strength=(1000.0,) * len(MUSCLES), step_ms=5.0)
    one, many = hand.init(Context("hand")), hand.init(Context("hand"))
    full, step = np.ones(len(MUSCLES)), 5 * NS_PER_MS
    times = [(k + 1) * step for k in range(100)]
    before = bits(many)
    assert not hand.advance_steps(many, [[full] * 100], 0, times)
    assert bits(many) == before
    faults = []
    for state in (one, many):
        with pytest.raises(RunError) as fault:
            step_through(hand, state, full, times)
        faults.append(str(fault.value))
    assert faults[0] == faults[1]
    assert "became unstable" in faults[0]

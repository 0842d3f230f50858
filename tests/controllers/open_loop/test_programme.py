"""Open-loop stimulation: way-points against numpy's interpolation, the sweep against its own timetable."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.open_loop import ElementSweep, Programme
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import NEVER, Sample


def given_at(block, times_ns, measured=None):
    """Every output at some instants, (instants, ...); `measured`, (instants, m), is read at each."""
    state, tick, rows = block.init(Context("block")), Tick(), []
    for tick.index, time_ns in enumerate(times_ns):
        tick.time_ns = now = int(time_ns)
        sample = (Sample(np.zeros(1), NEVER, NEVER, NEVER) if measured is None
                  else Sample(measured[tick.index], now, now, now))
        rows.append(block.step(state, [sample] * len(block.inputs), tick))
    return [np.stack([row[i] for row in rows]) for i in range(len(rows[0]))]


@settings(max_examples=60)
@given(st.lists(st.integers(0, 9000), min_size=1, max_size=6, unique=True), st.integers(1, 4),
       st.integers(0, 3000), st.integers(0, 2**31))
def test_pulses_are_linear_between_way_points_and_come_again_every_cycle(times_ms, channels, pause_ms, seed):
    times_s = np.sort(times_ms) / 1e3
    rng = np.random.default_rng(seed)
    current, width = rng.uniform(0.0, 50.0, (2, len(times_s), channels))
    cycle_ms = max(times_ms) + pause_ms
    block = Programme(times_s=tuple(times_s), current_ma=tuple(map(tuple, current)),
                      width_us=tuple(map(tuple, width)), cycle_s=cycle_ms / 1e3)
    at_ms = rng.integers(0, 40_000, 50)
    pulses, = given_at(block, at_ms * 1_000_000)
    seen = at_ms % cycle_ms / 1e3 if cycle_ms else at_ms / 1e3
    for channel in range(channels):
        assert np.allclose(pulses[:, channel, 0], np.interp(seen, times_s, current[:, channel]) / 1e3)
        assert np.allclose(pulses[:, channel, 1], np.interp(seen, times_s, width[:, channel]) / 1e6)


def test_one_row_stands_for_all_points_and_what_is_given_is_nobodys_else():
    block = Programme(times_s=(0.0, 1.0), current_ma=((20.0, 10.0),), width_us=((0.0, 100.0), (300.0, 50.0)))
    state = block.init(Context("block"))
    first, = block.step(state, [], Tick())
    assert np.allclose(first, [[0.02, 0.0], [0.01, 1e-4]])
    first[:] = 7.0
    again, = block.step(state, [], Tick())
    assert np.allclose(again, [[0.02, 0.0], [0.01, 1e-4]])


@pytest.mark.parametrize(("change", "where"), [
    ({"times_s": ()}, "times_s"), ({"times_s": (1.0, 1.0)}, "times_s"), ({"times_s": (-1.0, 1.0)}, "times_s"),
    ({"times_s": (0.0, float("nan"))}, "times_s"), ({"current_ma": ((5.0,),) * 3}, "current_ma"),
    ({"current_ma": ((-5.0,),)}, "current_ma[0][0]"),
    ({"width_us": ((300.0,), (float("inf"),))}, "width_us[1][0]"),
    ({"width_us": ((1.0, 2.0),)}, "current_ma, width_us"), ({"current_ma": ((),)}, "current_ma, width_us"),
    ({"cycle_s": 0.5}, "cycle_s"), ({"cycle_s": -1.0}, "cycle_s")])
def test_programmes_that_cannot_be_are_named(change, where):
    with pytest.raises(InputError) as fault:
        Programme(**{"times_s": (0.0, 1.0), "current_ma": ((5.0,),), "width_us": ((300.0,),), **change})
    assert fault.value.where == where


def test_the_sweep_climbs_on_one_element_after_another_and_rests_between():
    block = ElementSweep(count=5, elements=(3, 1), current_ma=(5.0, 8.0, 20.0), stair_s=0.2, rest_s=0.4)
    assert block.duration_s == pytest.approx(2.0)
    pulses, shares, element, stair = given_at(block, np.arange(12) * NS_PER_S // 5)
    assert element.tolist() == [3] * 5 + [1] * 5 + [-1] * 2
    assert stair.tolist() == [0, 1, 2, -1, -1] * 2 + [-1] * 2
    assert np.allclose(pulses[:, 0, 0], [0.005, 0.008, 0.02, 0, 0] * 2 + [0] * 2)
    assert np.allclose(pulses[:, 0, 1], [3e-4, 3e-4, 3e-4, 0, 0] * 2 + [0] * 2)
    assert (shares.argmax(axis=2)[:10, 0] == element[:10]).all()
    assert shares.sum(axis=(1, 2)).tolist() == [1.0] * 10 + [0.0] * 2


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**31), st.floats(1.0, 30.0), st.integers(1, 5))
def test_an_element_that_has_moved_the_hand_enough_gets_no_more_current(seed, enough_deg, elements):
    """Against the timetable written out: a turn ends one rest after its response, or after all its stairs."""
    block = ElementSweep(count=5, elements=tuple(range(elements)), current_ma=(5.0, 8.0, 20.0), stair_s=0.2,
                         rest_s=0.3, enough_deg=enough_deg, begin_s=0.4)
    rng = np.random.default_rng(seed)
    ticks = np.arange(round(block.duration_s * 40) + 40)
    measured = np.radians(np.cumsum(rng.normal(0.0, enough_deg / 4.0, (ticks.size, 2)), axis=0))
    pulses, _, element, _ = given_at(block, ticks * 25_000_000, measured)
    at = 16
    for turn in range(elements):
        moved = np.degrees(np.abs(measured[at:at + 24] - measured[at]).max(axis=1)) >= enough_deg
        stimulated = int(np.argmax(moved)) if moved.any() else 24
        assert (pulses[at:at + stimulated, 0, 0] > 0.0).all()
        assert (pulses[at + stimulated:at + stimulated + 12, 0, 0] == 0.0).all()
        assert (element[at:at + stimulated + 12] == turn).all()
        at += stimulated + 12
    assert (element[at:] == -1.0).all()
    assert at * 0.025 <= block.duration_s + 1e-9


def test_a_sweep_that_hears_nothing_says_so_and_goes_through_all_currents():
    block = ElementSweep(count=2, current_ma=(5.0, 8.0), stair_s=0.2, rest_s=0.2, enough_deg=10.0)
    state, tick, given = block.init(Context("block")), Tick(), []
    for tick.index in range(6):
        tick.time_ns = tick.index * NS_PER_S // 5
        given.append(block.step(state, [Sample(np.zeros(2), NEVER, NEVER, NEVER)], tick)[3])
    assert given == [0.0, 1.0, -1.0] * 2
    assert [report[0] for report in tick.reports] == ["no_input"]


@pytest.mark.parametrize(("change", "where"), [
    ({"enough_deg": -1.0}, "enough_deg"), ({"begin_s": -1.0}, "begin_s"),
    ({"count": 0}, "count"), ({"elements": (59,)}, "elements"), ({"elements": (-1,)}, "elements"),
    ({"current_ma": ()}, "current_ma"), ({"current_ma": (0.0, 5.0)}, "current_ma"),
    ({"current_ma": (5.0, 4.0)}, "current_ma"), ({"width_us": 0.0}, "width_us"),
    ({"stair_s": 0.0}, "stair_s"),
    ({"rest_s": -1.0}, "rest_s")])
def test_sweeps_that_cannot_be_are_named(change, where):
    with pytest.raises(InputError) as fault:
        ElementSweep(**change)
    assert fault.value.where == where

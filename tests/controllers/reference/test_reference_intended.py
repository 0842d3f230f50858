"""References that follow a person's effort: triggers by the rule spelt out, postures within two."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from controllers.reference.proportional import ProportionalPosture
from controllers.reference.triggered import TriggeredPhase, TriggeredPhases
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

ROWS = ("wrist_extension", "finger_flexion")
REST = TriggeredPhase(name="rest", deg={"wrist_extension": -10.0, "finger_flexion": 30.0})
PHASES = (REST, TriggeredPhase(name="open", move_s=0.3, deg={"wrist_extension": 20.0}),
          TriggeredPhase(name="close", move_s=0.2, deg={"finger_flexion": 70.0}),
          TriggeredPhase(name="release", move_s=0.4, back=True))
CLOCK = RateClock.from_rate("40")
BURSTS = st.lists(st.tuples(st.integers(1, 30), st.floats(0.0, 1.0)), min_size=1, max_size=25)


def follow(block, efforts, detections=None, measured=None):
    """Outputs of each tick, as arrays by port, and all reports."""
    state, tick, rows = block.init(Context("reference", clock=CLOCK)), Tick(), []
    for index, effort in enumerate(efforts):
        now = tick.time_ns = CLOCK.tick(index)
        tick.index = index
        noise = None if detections is None else detections[index]
        inputs = [Sample(effort, now, now, now), Sample(noise or 0.0, *[now if noise else NEVER] * 3)]
        if measured is not None:
            inputs.append(Sample(np.radians(measured[index]), now, now, now))
        rows.append(block.step(state, tuple(inputs), tick))
    names = [port.name for port in block.outputs]
    return {name: np.array([row[k] for row in rows]) for k, name in enumerate(names)}, tick.reports


def triggers(efforts, on, off, hold, wait):
    """Ticks of triggers by the rule, waits and holds in ticks; `wait` is a function of the new phase."""
    found, phase, locked = [], 0, 0
    for now in range(len(efforts)):
        # The newest tick at which the effort was at `off` or below, and the first one at `on` since.
        below = max((k for k in range(now + 1) if efforts[k] <= off), default=None)
        if below is None or now < locked or (found and below < found[-1]):
            continue
        begun = next((k for k in range(below, now + 1) if efforts[k] >= on), None)
        if begun is not None and now - begun >= hold:
            phase = phase + 1 if phase < 3 else 1
            found.append(now)
            locked = now + wait(phase)
    return found


@given(bursts=BURSTS, on=st.floats(0.1, 0.9), share=st.floats(0.0, 0.95), hold=st.integers(0, 12),
       refractory=st.integers(0, 60))
@settings(max_examples=150, deadline=None)
def test_phases_begin_where_the_rule_says_and_never_within_the_refractory_time(bursts, on, share, hold,
                                                                               refractory):
    efforts = [effort for length, effort in bursts for _ in range(length)]
    block = TriggeredPhases(phases=PHASES, rows=ROWS, on=on, off=share * on, hold_ms=25.0 * hold,
                            refractory_s=0.025 * refractory)
    out, _ = follow(block, efforts)
    moves = {1: 12, 2: 8, 3: 16}
    expected = triggers(efforts, on, share * on, hold, lambda phase: max(refractory, moves[phase]))
    found = np.flatnonzero(np.diff(out["phase"], prepend=0.0))
    assert found.tolist() == expected
    assert (np.diff(found) >= refractory).all()
    low, high = np.radians([[-10.0, 30.0], [20.0, 70.0]])
    assert (out["angles"] >= low - 1e-12).all()
    assert (out["angles"] <= high + 1e-12).all()


def test_a_triggered_move_is_the_minimum_jerk_move_from_that_tick():
    efforts = np.where((np.arange(80) >= 20) & (np.arange(80) < 30), 1.0, 0.0)
    block = TriggeredPhases(phases=PHASES, rows=ROWS, hold_ms=100.0, preview=3)
    out, _ = follow(block, efforts)
    assert np.flatnonzero(out["phase"])[0] == 24
    s = np.clip((np.arange(80) - 24) / 12.0, 0.0, 1.0)
    expected = -10.0 + 30.0 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    np.testing.assert_allclose(np.degrees(out["angles"][:, 0]), expected, atol=1e-9)
    np.testing.assert_allclose(out["preview"][24:70, 1], out["angles"][26:72], atol=1e-12)
    assert (out["preview"][:24] == out["angles"][0]).all()


def test_noise_at_rest_raises_both_thresholds_and_says_so():
    efforts = [0.0] * 10 + [0.5] * 20 + [0.1] * 10 + [0.7] * 20
    out, reports = follow(TriggeredPhases(phases=PHASES, rows=ROWS, on=0.3, off=0.15, hold_ms=0.0),
                          efforts, [0.6] * 60)
    assert np.flatnonzero(np.diff(out["phase"])).tolist() == [39]
    assert [status for status, _ in reports] == ["threshold_raised"]
    assert "0.60" in reports[0][1]


def test_without_effort_nothing_is_triggered_and_it_says_so():
    block, tick = TriggeredPhases(phases=PHASES, rows=ROWS), Tick()
    block.step(block.init(Context("reference", clock=CLOCK)), (Sample(0.0, *[NEVER] * 3),) * 2, tick)
    assert [status for status, _ in tick.reports] == ["no_effort"]


def test_rows_that_the_first_phase_leaves_out_start_where_the_hand_is():
    phases = (TriggeredPhase(name="rest", deg={"wrist_extension": 0.0}), *PHASES[1:])
    measured = [(99.0, 40.0 + 0.1 * k) for k in range(60)]
    out, _ = follow(TriggeredPhases(phases=phases, rows=ROWS, hold_ms=0.0),
                    [0.0] * 20 + [1.0] * 40, measured=measured)
    degrees = np.degrees(out["angles"])
    np.testing.assert_allclose(degrees[:20], [(0.0, each[1]) for each in measured[:20]], atol=1e-9)
    np.testing.assert_allclose(degrees[20:, 1], measured[20][1], atol=1e-9)


@given(bursts=BURSTS, dead_band=st.floats(0.01, 0.5), more=st.floats(0.05, 0.5), travel=st.floats(0.1, 3.0),
       rest=st.floats(-15.0, 60.0), active=st.floats(-15.0, 60.0))
@settings(max_examples=100, deadline=None)
def test_a_proportional_reference_stays_between_its_postures_and_within_its_rate(bursts, dead_band, more,
                                                                                  travel, rest, active):
    efforts = [effort for length, effort in bursts for _ in range(length)]
    block = ProportionalPosture(rest_deg={"wrist_extension": rest, "finger_flexion": 0.0}, rows=ROWS,
                                active_deg={"wrist_extension": active}, dead_band=dead_band,
                                full=dead_band + more, travel_s=travel, preview=4)
    out, _ = follow(block, efforts)
    degrees = np.degrees(np.concatenate([out["angles"][:, np.newaxis], out["preview"]], axis=1))
    low, high = sorted((rest, active))
    assert (degrees[..., 0] >= low - 1e-9).all()
    assert (degrees[..., 0] <= high + 1e-9).all()
    assert not degrees[..., 1].any()
    fastest = abs(active - rest) * 0.025 / travel
    assert (np.abs(np.diff(degrees[:, 0, 0])) <= fastest + 1e-9).all()
    assert (out["phase"] == (np.array(efforts) > dead_band)).all()


@given(effort=st.floats(0.0, 1.0))
@settings(deadline=None)
def test_an_effort_that_stays_leads_to_its_share_of_the_way_as_previewed(effort):
    block = ProportionalPosture(rest_deg={"finger_flexion": 10.0, "wrist_extension": 0.0}, rows=ROWS,
                                active_deg={"finger_flexion": 60.0}, dead_band=0.2, full=0.7, travel_s=0.5,
                                preview=10)
    out, _ = follow(block, [effort] * 60)
    share = min(max((effort - 0.2) / 0.5, 0.0), 1.0)
    np.testing.assert_allclose(np.degrees(out["angles"][-1, 1]), 10.0 + 50.0 * share, atol=1e-9)
    np.testing.assert_allclose(out["preview"][0], out["angles"][1:11], atol=1e-9)


@given(noise=st.floats(0.0, 0.99), efforts=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=30))
@settings(deadline=None)
def test_an_effort_below_the_detection_moves_nothing(noise, efforts):
    assume(max(efforts) <= noise)
    block = ProportionalPosture(rest_deg={"finger_flexion": 10.0, "wrist_extension": 0.0}, rows=ROWS,
                                active_deg={"finger_flexion": 60.0}, dead_band=0.2)
    block = block if noise > 0.2 else ProportionalPosture(
        rest_deg=block.rest_deg, rows=ROWS, active_deg=block.active_deg, dead_band=0.99, full=1.0)
    out, _ = follow(block, efforts, [noise] * len(efforts))
    assert not out["phase"].any()
    np.testing.assert_allclose(np.degrees(out["angles"][:, 1]), 10.0, atol=1e-9)


@pytest.mark.parametrize(("parameters", "says"), [
    ({"on": 0.2, "off": 0.3}, r"off: 0\.3; allowed: 0 or more, below on, 0\.2"), ({"on": 1.5}, "on: 1.5"),
    ({"phases": (REST,)}, "phases: 1; allowed: two or more"), ({"hold_ms": -1.0}, "hold_ms"),
    ({"phases": (REST, TriggeredPhase(name="a", deg={"finger_flexio": 1.0}))},
     r"phases\[1\]\.deg\.finger_flexio.*did you mean 'finger_flexion'"),
    ({"phases": (REST, TriggeredPhase(name="a", deg={"wrist_extension": 400.0}))}, r"phases\[1\]\.deg")])
def test_wrong_phases_and_thresholds_are_refused_in_one_line(parameters, says):
    with pytest.raises(InputError, match=says) as refused:
        TriggeredPhases(**{"phases": PHASES, "rows": ROWS} | parameters)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("parameters", "says"), [
    ({"dead_band": 0.5, "full": 0.4}, r"full: 0\.4; allowed: above dead_band, 0\.5"),
    ({"dead_band": 0.0}, "dead_band"), ({"travel_s": 0.0}, "travel_s"),
    ({"active_deg": {}}, "active_deg: names no row"), ({"active_deg": {"thumb": 1.0}}, r"active_deg\.thumb")])
def test_wrong_postures_are_refused_in_one_line(parameters, says):
    with pytest.raises(InputError, match=says) as refused:
        ProportionalPosture(**{"active_deg": {"finger_flexion": 1.0}, "rows": ROWS} | parameters)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("parameters", [{"name": ""}, {"name": "a", "move_s": 0.0}])
def test_wrong_phase_tables_are_refused(parameters):
    with pytest.raises(InputError):
        TriggeredPhase(**parameters)

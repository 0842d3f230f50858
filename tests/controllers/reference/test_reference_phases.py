import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from controllers.reference.phases import GraspPhase, GraspPhases
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import NEVER, Sample

ROWS = ("wrist_extension", "finger_flexion")
PHASES = (
    GraspPhase(name="rest", duration_s=1.0, deg={"wrist_extension": -20.0, "finger_flexion": 30.0}),
    GraspPhase(name="open", duration_s=1.5, move_s=1.0,
               deg={"wrist_extension": 20.0, "finger_flexion": 10.0}),
    GraspPhase(name="approach", duration_s=0.5),
    GraspPhase(name="close", duration_s=1.0, deg={"finger_flexion": 60.0}),
    GraspPhase(name="hold", duration_s=2.0),
)


def stepped(block, time_s):
    tick = Tick()
    tick.time_ns = round(time_s * 1e9)
    return block.step(block.init(Context("reference")), (), tick)


def degrees(block, times_s):
    return np.degrees([stepped(block, time)[0] for time in times_s])


def test_each_named_row_moves_as_a_quintic_that_rests_at_its_ends_and_the_others_stay():
    block = GraspPhases(phases=PHASES, rows=ROWS)
    times = np.linspace(1.0, 2.0, 21)
    opening = BPoly.from_derivatives([1.0, 2.0], [[[-20.0, 30.0], [0.0] * 2, [0.0] * 2],
                                                  [[20.0, 10.0], [0.0] * 2, [0.0] * 2]])
    np.testing.assert_allclose(degrees(block, times), opening(times), atol=1e-9)
    np.testing.assert_allclose(degrees(block, [0.0, 0.99]), [[-20.0, 30.0]] * 2)
    np.testing.assert_allclose(degrees(block, [2.0, 2.4, 2.99]), [[20.0, 10.0]] * 3)
    np.testing.assert_allclose(degrees(block, [3.5, 4.0, 5.9, 100.0]), [[20.0, 35.0]] + [[20.0, 60.0]] * 3,
                               atol=1e-9)


def test_says_which_phase_it_is():
    block = GraspPhases(phases=PHASES, rows=ROWS)
    told = [stepped(block, time)[1] for time in (0.0, 0.999, 1.0, 2.499, 2.5, 3.0, 4.0, 6.0, 60.0)]
    assert told == [0, 0, 1, 1, 2, 3, 4, 4, 4]
    assert block.duration_s == 6.0


def test_a_repeat_begins_with_the_move_back():
    block = GraspPhases(phases=PHASES, rows=ROWS, repeats=2)
    np.testing.assert_allclose(degrees(block, [6.0, 6.5, 7.0]), [[20.0, 60.0], [0.0, 45.0], [-20.0, 30.0]],
                               atol=1e-9)
    np.testing.assert_allclose(degrees(block, [8.2, 10.5]), degrees(block, [2.2, 4.5]), atol=1e-9)
    assert [stepped(block, time)[1] for time in (5.9, 6.0, 7.0, 50.0)] == [4, 0, 1, 4]


@settings(deadline=None)
@given(st.floats(0.0, 13.0), st.integers(1, 30), st.floats(1.0, 200.0))
def test_preview_is_what_it_will_say_then(time, preview, period_ms):
    block = GraspPhases(phases=PHASES, rows=ROWS, repeats=2, preview=preview, preview_period_ms=period_ms)
    ahead = stepped(block, time)[2]
    later = np.radians(degrees(block, time + period_ms / 1e3 * np.arange(1, preview + 1)))
    np.testing.assert_allclose(ahead, later, atol=1e-7)


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(0.01, 3.0), st.floats(0.1, 1.0),
                          st.dictionaries(st.sampled_from(ROWS), st.floats(-30.0, 60.0))), max_size=6))
def test_stands_where_each_phase_said_at_its_end_and_never_leaves_what_it_moves_between(told):
    phases = PHASES[:1] + tuple(GraspPhase(name="any", duration_s=length, move_s=share * length, deg=deg)
                                for length, share, deg in told)
    block = GraspPhases(phases=phases, rows=ROWS)
    now, where = 1.0, dict(PHASES[0].deg)
    for phase in phases[1:]:
        before, where = where, {**where, **phase.deg}
        between = degrees(block, now + phase.duration_s * np.linspace(0.0, 1.0, 7))
        now += phase.duration_s
        for row, values in zip(ROWS, between.T, strict=True):
            low, high = sorted((before[row], where[row]))
            assert (values > low - 1e-6).all()
            assert (values < high + 1e-6).all()
            assert values[-1] == pytest.approx(where[row], abs=1e-5)


def an_experiment(**changed):
    phases = [{"name": "rest", "duration_s": 1, "deg": {"wrist_extension": -20, "finger_flexion": 30}},
              {"name": "open", "duration_s": 1.5, "move_s": 1.0, "deg": {"wrist_extension": 20}}]
    return {"experiment": {"name": "told", "duration_s": 3.0},
            "blocks": {"reference": {"kind": "grasp_phases", "rate": "40", "rows": list(ROWS),
                                     "phases": phases} | changed}}


def test_a_file_and_python_make_the_same_object():
    experiment = from_document(an_experiment(range_deg={"finger_flexion": [0, 90]}))
    phases = (PHASES[0], GraspPhase(name="open", duration_s=1.5, move_s=1.0, deg={"wrist_extension": 20.0}))
    assert experiment.nodes[0].part == GraspPhases(phases=phases, rows=ROWS,
                                                    range_deg={"finger_flexion": (0.0, 90.0)})
    assert experiment.document()["blocks"]["reference"]["range_deg"] == {"finger_flexion": [0.0, 90.0]}
    assert from_document(experiment.document()) == experiment


@settings(deadline=None)
@given(st.lists(st.floats(-80.0, 120.0), min_size=2, max_size=5), st.booleans(), st.floats(0.0, 12.0))
def test_rows_that_the_first_phase_leaves_out_start_where_the_hand_is_and_come_back(measured, named, later_s):
    deg = {"wrist_extension": 5.0} if named else {}
    phases = (GraspPhase(name="rest", duration_s=1.0, deg=deg), *PHASES[1:],
              GraspPhase(name="release", duration_s=1.0, back=True))
    block, tick = GraspPhases(phases=phases, rows=ROWS, preview=2), Tick()
    state, seen = block.init(Context("reference")), []
    times_s = [*(0.2 * np.arange(len(measured))), 1.0 + later_s]
    for time_s, angle in zip(times_s, [*measured, 999.0], strict=True):
        now = tick.time_ns = round(1e9 * time_s)
        sample = Sample(np.radians([angle, angle]), now, now, now)
        seen.append(np.degrees(block.step(state, (sample,), tick)[0]))
    start = [5.0 if named else measured[-1], measured[-1]]
    rest = GraspPhase(name="rest", duration_s=1.0, deg=dict(zip(ROWS, start, strict=True)))
    wide = dict.fromkeys(ROWS, (-100.0, 150.0))
    spelt_out = GraspPhases(phases=(rest, *phases[1:]), rows=ROWS, range_deg=wide)
    np.testing.assert_allclose(seen[:-1], [[5.0 if named else angle, angle] for angle in measured], atol=1e-9)
    np.testing.assert_allclose(seen[-1], degrees(spelt_out, [1.0 + later_s])[0], atol=1e-9)
    np.testing.assert_allclose(degrees(spelt_out, [7.0])[0], start, atol=1e-9)


def test_a_row_without_a_first_angle_needs_the_measured_one():
    block = GraspPhases(phases=(GraspPhase(name="rest", duration_s=1.0),), rows=ROWS)
    assert [(port.name, port.optional) for port in block.inputs] == [("measured", False)]
    tick, state = Tick(), block.init(Context("reference"))
    for value in (Sample(np.zeros(2), NEVER, NEVER, NEVER), Sample(np.full(2, np.nan), 0, 0, 0)):
        np.testing.assert_array_equal(block.step(state, (value,), tick)[0], 0.0)
    assert GraspPhases(phases=PHASES, rows=ROWS).inputs == ()


@pytest.mark.parametrize(("changed", "named"), [
    ({"rows": ["wrist_extention", "finger_flexion"]},
     "rows: 'wrist_extention'.*did you mean 'wrist_extension'"),
    ({"rows": ["wrist_extension", "mine"]}, "rows: 'mine'.*give range_deg"),
    ({"rows": ["finger_flexion", "finger_flexion"]}, "rows: .*each once"),
    ({"rows": ["wrist_extension"]}, r"phases\[0\].deg.finger_flexion: is no row"),
    ({"range_deg": {"finger_flexion": [0, 25]}},
     r"phases\[0\].deg.finger_flexion: 30 deg is outside the range of motion of .*; allowed: 0 to 25 deg"),
    ({"range_deg": {"finger_flexion": [25, 0]}}, "range_deg.finger_flexion"),
    ({"range_deg": {"thumb_flexion": [0, 25]}}, "range_deg.thumb_flexion: is no row"),
    ({"phases": []}, "phases: there is none"),
    ({"repeats": 0}, "repeats"),
    ({"preview": -1}, "preview"),
])
def test_names_what_cannot_be(changed, named):
    with pytest.raises(InputError, match=f"blocks.reference.{named}"):
        from_document(an_experiment(**changed))


@pytest.mark.parametrize(("changed", "named"), [
    ({"duration_s": 0.0}, "duration_s"), ({"duration_s": float("nan")}, "duration_s"), ({"name": ""}, "name"),
    ({"move_s": 0.0}, "move_s"), ({"move_s": 1.1}, "move_s: 1.1; allowed: above 0, at most 1, the phase"),
])
def test_names_what_a_phase_cannot_be(changed, named):
    with pytest.raises(InputError, match=named):
        GraspPhase(**{"name": "open", "duration_s": 1.0} | changed)


def test_an_angle_outside_the_range_of_motion_is_refused_by_phase_and_row():
    # Extension is what flexion of the wrist ends at on the other side: -70 deg.
    too_far = GraspPhase(name="open", duration_s=1.0, deg={"wrist_extension": 71.0})
    with pytest.raises(InputError, match=r"phases\[1\].deg.wrist_extension: 71 deg .* -75 to 70 deg"):
        GraspPhases(phases=(PHASES[0], too_far), rows=ROWS)
    GraspPhases(phases=(PHASES[0], too_far), rows=ROWS, range_deg={"wrist_extension": (-75.0, 75.0)})

"""Trackers that fail in mid-grasp, each in its way: in a loop, and one tick at a time."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from controllers.open_loop import Programme
from controllers.safety import SOUND, Safety, Watchdog, WatchState
from estimators.ideal import IdealTracker
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Port, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.finger import Finger

MS = 1_000_000
PERIOD_MS, RAMP_MS, FAILS_MS = 25, 200, 1010
ABSENT = Sample(np.zeros(3), NEVER, NEVER, NEVER)


@dataclass(frozen=True, slots=True, kw_only=True)
class FailingTracker:
    """Passes angles on until FAILS_MS; then it freezes, jumps by 60 deg, returns NaN, or is lost."""

    how: str
    gaps: bool = False

    @property
    def inputs(self):
        return (Port("angles", (3,), "rad"),)

    @property
    def outputs(self):
        return (Port("angles", (3,), "rad", gaps=self.gaps),)

    def init(self, context):
        return [np.zeros(3)]

    def step(self, state, inputs, tick):
        if self.how == "nothing" or tick.time_ns < FAILS_MS * MS:
            state[0] = inputs[0].value.copy()
            return (state[0],)
        return ({"freezes": state[0].copy(), "jumps": inputs[0].value + math.radians(60.0),
                 "nan": np.full(3, np.nan)}[self.how],)


def grasp(how, gaps=False, **safety):
    """Times ms, largest pulse width at each, and events of a grasp whose tracker fails."""
    programme = Programme(times_s=(0.2, 0.6), current_ma=((30.0,) * 4,), width_us=((0.0,) * 4, (200.0,) * 4))
    nodes = [Node("programme", programme, "40"), Node("safety", Safety(**safety), "40"),
             Node("finger", Finger()), Node("ideal", IdealTracker(noise_deg=0.3), "100"),
             Node("tracker", FailingTracker(how=how, gaps=gaps), "100")]
    wires = [Wire("programme.stimulation", "safety.stimulation"), Wire("tracker.angles", "safety.posture"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("finger.angles", "ideal.angles"), Wire("ideal.angles", "tracker.angles")]
    recorder = Recorder("200")
    loop = Loop(Wiring(nodes, wires, seed=1), recorder=recorder)
    loop.run_until(2_000 * MS)
    loop.close()
    times, widths = np.array([(row[1] / MS, row[5][0][:, 1].max()) for row in recorder.blocks["safety"]]).T
    return times, widths, [status for _, where, status, _ in recorder.events if where == "safety"]


@pytest.mark.parametrize(("how", "gaps", "status"), [
    ("freezes", False, "posture_frozen"), ("jumps", False, "posture_jumped"),
    ("nan", True, "posture_non_finite"), ("nan", False, "posture_")])
def test_a_tracker_that_fails_ends_stimulation_within_two_periods_and_the_ramp(how, gaps, status):
    """NaN that the loop replaces by the port's safe value shows as a jump or as a frozen posture."""
    times, widths, told = grasp(how, gaps)
    assert widths[times < FAILS_MS].max() == pytest.approx(200e-6)
    assert (widths[times >= FAILS_MS + 2 * PERIOD_MS + RAMP_MS] == 0.0).all()
    assert told[0].startswith(status)


def test_a_tracker_that_does_not_fail_is_left_alone():
    times, widths, told = grasp("nothing")
    np.testing.assert_allclose(widths[times > 600], 200e-6)
    assert told == []


def test_a_tracker_that_jumped_is_believed_again_only_where_that_is_allowed():
    times, widths, _ = grasp("jumps", watchdog=Watchdog(recover_s=0.5))
    assert widths[(times > 1260) & (times < 1500)].max() == 0.0
    assert widths[-1] == pytest.approx(200e-6)


def test_silence_is_told_by_arrival_so_that_latency_is_none():
    """Samples that are 150 ms old but keep coming are sound; 60 ms without any are not."""
    dog, state = Watchdog(), WatchState()

    def look(now_ms, captured_ms, arrived_ms):
        value = np.array([0.3 + 1e-3 * captured_ms])
        posture = Sample(value, captured_ms * MS, captured_ms * MS, arrived_ms * MS)
        return dog.look(state, posture, ABSENT, now_ms * MS, 500.0, True)

    assert [look(now, now - 150, now) for now in (200, 225, 250)] == [SOUND] * 3
    assert look(300, 100, 250) == SOUND
    assert look(310, 100, 250)[0] == "posture_silent"
    assert look(325, 150, 325)[0] == "posture_silent"


@pytest.mark.parametrize(("moved_deg", "elapsed_ms", "sound"), [
    (45.0, 25, True), (50.0, 25, False), (9.0, 0, True), (11.0, 0, False), (24.0, 10, True),
    (26.0, 10, False)])
def test_a_jump_is_what_no_hand_does_in_the_time(moved_deg, elapsed_ms, sound):
    """1500 deg/s, and 10 deg beside."""
    dog, state = Watchdog(), WatchState()
    for at, angle in ((100, 0.0), (100 + elapsed_ms, math.radians(moved_deg))):
        posture = Sample(np.array([0.2, angle]), at * MS, at * MS, 130 * MS)
        found = dog.look(state, posture, ABSENT, 130 * MS, 500.0, True)
    assert (found == SOUND) is sound


@settings(deadline=None, max_examples=100)
@given(st.lists(st.floats() | st.floats(0.0, 0.5), min_size=1, max_size=5))
@example([0.4, math.nan])
@example([-math.inf, 0.1])
@example([0.1, -1e-9])
@example([0.0, math.radians(30.0)])
def test_an_sd_that_is_none_or_too_great_says_that_posture_is_not_known(sd):
    """NaN and infinities, and what lies below 0, are no standard deviations."""
    dog, posture = Watchdog(sd_max_deg=30.0), Sample(np.zeros(len(sd)), 0, 0, 0)
    found = dog.look(WatchState(), posture, Sample(np.array(sd), 0, 0, 0), 0, 500.0, True)
    known = all(0.0 <= each <= math.radians(30.0) for each in sd)
    assert found[0] == ("" if known else "posture_uncertain")


@pytest.mark.parametrize(("late_ns", "silent", "stale"), [
    (0, "", ""), (1, "posture_silent", "posture_stale")])
def test_a_posture_may_be_as_old_as_stated_to_the_nanosecond(late_ns, silent, stale):
    now = 1000 * MS + late_ns
    for captured, arrived, status in ((950, 950, silent), (500, 990, stale)):
        posture = Sample(np.zeros(1), captured * MS, 990 * MS, arrived * MS)
        assert Watchdog().look(WatchState(), posture, ABSENT, now, 500.0, True)[0] == status


def test_what_a_tracker_does_while_nothing_is_stimulated_passes():
    dog, state = Watchdog(), WatchState()
    seen = []
    for k, angle in enumerate((0.0, 1.5, 1.51, 1.5)):
        posture = Sample(np.array([angle]), 25 * k * MS, 25 * k * MS, 25 * k * MS)
        seen.append(dog.look(state, posture, ABSENT, 25 * k * MS, 500.0, False)[0])
    assert seen == ["", "posture_jumped", "", ""]


def test_a_jump_between_the_greatest_numbers_is_one():
    dog, state = Watchdog(), WatchState()
    seen = []
    for k, angle in enumerate((1.7e308, -1.7e308)):
        posture = Sample(np.array([angle]), 25 * k * MS, 25 * k * MS, 25 * k * MS)
        seen.append(dog.look(state, posture, ABSENT, 25 * k * MS, 500.0, True)[0])
    assert seen == ["", "posture_jumped"]


def test_a_posture_is_frozen_once_fresh_captures_have_held_it_for_so_long():
    """To the nanosecond; a bit that changes begins anew, and messages without a new capture tell nothing."""
    dog, state, seen = Watchdog(frozen_ms=20.0), WatchState(), []
    rows = [(0, 0.4), (10 * MS, 0.4), (20 * MS - 1, 0.4), (20 * MS - 1, 0.4), (21 * MS, 0.5), (40 * MS, 0.5),
            (41 * MS, 0.5)]
    for captured, angle in rows:
        posture = Sample(np.array([angle]), captured, captured, 41 * MS)
        seen.append(dog.look(state, posture, ABSENT, 41 * MS, 500.0, True)[0])
    assert seen == [""] * 6 + ["posture_frozen"]


def test_frozen_can_be_left_unwatched():
    for frozen_ms, last in ((20.0, "posture_frozen"), (0.0, "")):
        dog, state = Watchdog(frozen_ms=frozen_ms), WatchState()
        for at in (0, 25):
            posture = Sample(np.array([0.4]), at * MS, at * MS, at * MS)
            found = dog.look(state, posture, ABSENT, at * MS, 500.0, True)
        assert found[0] == last


@pytest.mark.parametrize(("recover_s", "sound_again_ms"), [(0.0, []), (0.1, [375, 400]), (0.2, [])])
def test_a_tracker_is_believed_again_after_so_long_of_sound_samples_on_end(recover_s, sound_again_ms):
    """It jumps at 50 ms and again at 250; 0 is never in this trial."""
    dog, state, sound = Watchdog(recover_s=recover_s), WatchState(), []
    angle = 0.0
    for at in range(0, 425, 25):
        angle += 1e-3 + (1.0 if at in (50, 250) else 0.0)
        found = dog.look(state, Sample(np.array([angle]), *[at * MS] * 3), ABSENT, at * MS, 500.0, True)
        if found == SOUND:
            sound.append(at)
    first = [175, 200, 225] if recover_s == 0.1 else []
    assert sound == [0, 25, *first, *sound_again_ms]

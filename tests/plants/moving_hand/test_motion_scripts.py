from dataclasses import replace

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.loop.block import Context
from plants.moving_hand import MovingHand
from plants.moving_hand.scripts import SCRIPTS, script
from plants.patients.files import load
from plants.patients.sections import CohortSpread

ALONE = ("A-F1", "A-F2", "A-F3", "AF-F1", "AF-F2", "AF-F3", "F-F2", "F-F3")
SPREAD = CohortSpread(length=0.03, joint_mm=3.0, axis_deg=7.6)


def of(name, seed):
    person = replace(load("able_bodied"), cohort=SPREAD).member(cohort=0, number=seed)
    return MovingHand(hand=replace(person.hand_size, side="left"), script=name).path(seed, "hand")


@pytest.mark.parametrize("name", ALONE)
def test_isolated_movements_keep_to_what_the_paper_states(name):
    """S19, section 3.1.3: 10-15 repetitions in 30-50 s, below 2 rad/s; initial pose of 3 s or more."""
    pose, task = of(name, 1).spans
    assert pose.stop - pose.start >= 3.0
    assert 30.0 <= task.stop - task.start <= 50.0
    rates = max(np.abs(of(name, seed).knots[:, 1, 3:-3]).max() for seed in range(5))
    assert rates < 2.0
    assert 10 <= script(name).phases[1].cycles <= 15


@pytest.mark.parametrize("name", ["P1", "P2", "P3", "P4"])
def test_contacts_last_as_long_as_the_papers_trials(name):
    spans = [span for span in of(name, 1).spans if span.name == "task"]
    assert 15.0 <= sum(span.stop - span.start for span in spans) <= 35.0
    assert len(spans) == (2 if name == "P3" else 1)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", [name for name in SCRIPTS if name != "hour"])
def test_every_person_can_do_every_script(name, seed):
    assert np.isfinite(of(name, seed).knots).all()


def test_an_hour_lasts_an_hour_with_ten_still_minutes():
    plant = MovingHand(script="hour", knot_ms=50.0)
    assert plant.length_s == pytest.approx(3600.0)
    (still,) = [span for span in plant.path(0, "hand").spans if span.name == "still"]
    assert still.stop - still.start == 600.0
    # The spline rings for a few knots where movement ends.
    knots = plant.path(0, "hand").knots[int(still.start / 0.05) + 20:int(still.stop / 0.05) - 20]
    assert np.abs(knots[:, 1]).max() < 1e-9


def test_an_unknown_script_is_named_with_the_nearest():
    with pytest.raises(InputError, match="kortier_pinch"):
        MovingHand(script="kortier_pinsh")
    with pytest.raises(InputError, match="is given with a script"):
        MovingHand(script="P1", rest_deg={"F2_pip_flexion": 1.0})


def test_tips_of_a_pinch_travel_as_far_as_in_the_paper():
    """K14: index 65.6 +- 2.2, thumb 15.7 +- 2.5 mm; widest opening 6.5 mm / 3.7 % = 176 mm."""
    plant = MovingHand(hand=HandSize(side="left"), script="kortier_pinch")
    touch = next(span for span in plant.spans if span.name == "task")
    (wide,) = (span for span in plant.spans if span.name == "widest")
    state = plant.init(Context("hand", 1, 0))
    times = (wide.stop, touch.start - 0.75, touch.start + 0.5)
    tips = plant.observe(state, (), 0, [int(1e9 * time) for time in times])[3]
    widest, before, touching = 1e3 * tips[:, :2]
    thumb, index = np.linalg.norm(touching - before, axis=1)
    assert index == pytest.approx(65.6, abs=4.4)
    assert thumb == pytest.approx(15.7, abs=2.5)
    assert np.linalg.norm(widest[1] - widest[0]) == pytest.approx(176.0, rel=0.03)

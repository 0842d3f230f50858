"""Limits and delays with which nothing can be learnt, named before the first trial."""

import pytest

from controllers.ilc import Ilc
from controllers.ilc.parameters import Point
from controllers.reference import MinimumJerk
from controllers.safety import Safety
from estimators.ideal import IdealTracker
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from plants.finger import Finger

RATE = "40"
NOMINAL = Finger()
STILL = MinimumJerk(times_s=(0.0,), angles_deg=((20.0, 25.0, 15.0),))


def learner(**changes):
    return Ilc(**{"model": NOMINAL.linear_model(), "current_ma": (40.0,) * 4, "duration_s": 2.0} | changes)


def experiment(ilc, latency_ms=20.0):
    nodes = (Node("reference", STILL, RATE), Node("ilc", ilc, RATE), Node("safety", Safety(), RATE),
             Node("finger", NOMINAL), Node("tracker", IdealTracker(noise_deg=0.0), "100"))
    wires = (Wire("reference.angles", "ilc.reference"), Wire("ilc.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "finger.stimulation", latency_ms=5.0),
             Wire("finger.angles", "tracker.angles"),
             Wire("tracker.angles", "ilc.measured", latency_ms=latency_ms))
    return Experiment(name="limits", nodes=nodes, wires=wires, duration_s=2.0, trials=2)


def test_a_trial_that_ends_before_the_delay_of_model_and_loop_is_refused():
    experiment(learner(duration_s=0.2))
    with pytest.raises(InputError) as told:
        experiment(learner(duration_s=0.2), latency_ms=300.0)
    # From the tracker's tick every 10 ms to the controller's every 25 ms nothing waits at t = 0.
    assert str(told.value) == (
        "blocks.ilc.duration_s: 0.2 s end before the delay of 325 ms of model and loop does; allowed: above "
        "0.325 s; lengthen the trial")


def test_a_point_before_any_drive_shows_is_refused():
    points = (Point(at_s=0.02), Point(at_s=1.0))
    with pytest.raises(InputError, match=r"blocks.ilc.points\[0\].at_s: 0.02 s .* above 0.02 s; set"):
        experiment(learner(law="point_to_point", points=points))
    experiment(learner(law="point_to_point", points=points[1:]))


@pytest.mark.parametrize(("faulty", "message"), [
    ({"drive_max": 0.001}, "drive_max: 0.001; allowed: 0.01 or more; raise"),
    ({"width_max_us": 20.0}, "recruits less than 0.01 of muscle .*; raise"),
    ({"trial_charge_max_uc": 0.5}, "trial_charge_max_uc: 0.5 uC; .* 0.01 of muscle 0; raise"),
    ({"first_drive": (0.1, 0.1, 0.1, 0.9), "charge_max_uc": 3.0},
     "first_drive: 0.9 of muscle 3; allowed: up to 0.[0-9]+, which its channel can recruit; lower")])
def test_limits_that_leave_nothing_to_learn_with_are_named_with_a_remedy(faulty, message):
    with pytest.raises(InputError, match=message):
        learner(**faulty)

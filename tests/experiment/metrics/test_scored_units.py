"""What is scored is in the unit that its score takes it for."""

from types import SimpleNamespace

import pytest

from fesloop.errors import InputError
from fesloop.experiment.metrics.grasp_outcome import GraspScore
from fesloop.experiment.metrics.search import SearchScore
from fesloop.experiment.score_spec import Score
from fesloop.loop.nodes import Node
from fesloop.loop.signals import Port
from plants.linear import StateSpace

UNITS = ("1", "rad", "m", "N", "A", "rad/s", "A,s")
HOLD = {"object": "hand.object_position", "from_s": 1.0, "until_s": 2.0}
SCORED = {
    "truth": ((3,), "rad", lambda name: Score(truth=name)),
    "reference": ((3,), "rad", lambda name: Score(reference=name)),
    "estimate": ((3,), "rad", lambda name: Score(estimate=name)),
    "orientation": ((2, 4), "1", lambda name: Score(orientation=name, recording="made")),
    "fingertips": ((5, 3), "m", lambda name: Score(fingertips=name, trackers=("tracker",))),
    "trackers": ((5, 3), "m", lambda name: Score(fingertips="hand.fingertips", trackers=("made",))),
    "grasp.object": ((3,), "m", lambda name: Score(grasp=GraspScore(**HOLD | {"object": name}))),
    "grasp.forces": ((5,), "N", lambda name: Score(grasp=GraspScore(**HOLD, forces=name))),
    "grasp.angles": ((23,), "rad", lambda name: Score(grasp=GraspScore(**HOLD, angles=name))),
    "search.truth": ((23,), "rad", lambda name: Score(
        search=SearchScore(search="search", truth=name, movement="wrist_extension"))),
}


def node(name, *ports):
    """One that plays a recording, with some outputs."""
    return SimpleNamespace(name=name, part=SimpleNamespace(outputs=ports, source=None))


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("key", SCORED)
def test_a_signal_in_another_unit_than_its_score_takes_is_refused(key, unit):
    shape, right, score = SCORED[key]
    port = Port("fingertips", shape, unit)  # the name that trackers' outputs have
    nodes = [node("made", port), node("tracker", Port("fingertips", (5, 3), "m")),
             node("hand", Port("fingertips", (5, 3), "m"), Port("object_position", (3,), "m"))]
    faults = [fault for fault in score("made.fingertips").faults(nodes) if fault.where == f"score.{key}"]
    assert bool(faults) == (unit != right), faults
    assert all(f"a signal in {right!r}" in str(fault) for fault in faults)


def test_a_signal_without_a_unit_is_refused_with_where_to_declare_it():
    plant = Node("tank", StateSpace(a=((-1.0,),), b=((1.0,),), c=((1.0,),)))
    (fault,) = Score(truth="tank.y").faults([plant])
    assert isinstance(fault, InputError)
    assert str(fault) == (
        "score.truth: 'tank.y' has no unit; allowed: a signal in 'rad'; if its values are in 'rad', set that "
        "as the unit of the port (`unit` in an FMU's output_ports, `output_unit` of state_space); else leave "
        "it out")

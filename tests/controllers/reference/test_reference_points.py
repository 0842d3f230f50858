"""A point-to-point law takes its points from a reference in phases: their ends, and where it stands there."""

import numpy as np
import pytest

from controllers.ilc import Ilc
from controllers.ilc.parameters import Point
from controllers.reference.phases import GraspPhase, GraspPhases
from fesloop import Experiment, Node, Recording, Wire
from plants.finger import Finger

ROWS = ("F2_mcp_flexion", "F2_pip_flexion", "F2_dip_flexion")
RATE, TRIALS = 50, 5


def phase(name, duration_s, *degrees):
    return GraspPhase(name=name, duration_s=duration_s, deg=dict(zip(ROWS, degrees, strict=True)))


REFERENCE = GraspPhases(rows=ROWS, phases=(
    phase("rest", 0.5, 20.0, 25.0, 15.0), phase("close", 1.0, 34.0, 45.0, 22.0),
    phase("open", 1.0, 22.0, 29.0, 17.0)))
WAY = GraspPhase(name="detour", duration_s=0.5, deg={"F2_pip_flexion": 10.0})


def learnt(tmp_path, law, reference, points=()):
    """Error of each trial, deg, (trials, samples, joints), against the reference."""
    ilc = Ilc(model=Finger().linear_model(), current_ma=(40.0,) * 4, duration_s=2.6, law=law, points=points)
    experiment = Experiment(
        name=law.replace("_", "-"), duration_s=2.6, trials=TRIALS,
        nodes=(Node("reference", reference, RATE), Node("ilc", ilc, RATE), Node("finger", Finger())),
        wires=(Wire("reference.angles", "ilc.reference"), Wire("finger.angles", "ilc.measured"),
               Wire("ilc.stimulation", "finger.stimulation", latency_ms=1.0)))
    with Recording(experiment.run(out=tmp_path).recording) as recording:
        trials = []
        for trial in range(TRIALS):
            wanted, had = (recording.signal(name, trial) for name in ("reference.angles", "finger.angles"))
            at = np.searchsorted(had.times_ns, wanted.times_ns)
            trials.append(np.degrees(had.values[at] - wanted.values))
    return np.array(trials)


def test_the_ends_of_phases_are_met_and_the_way_between_is_free(tmp_path):
    assert REFERENCE.ends_s == (0.5, 1.5, 2.5)
    ends = REFERENCE.ends_s[1:]
    ticks = [round(end * RATE) for end in ends]
    points = tuple(Point(at_s=end) for end in ends)
    errors = learnt(tmp_path, "point_to_point", REFERENCE, points)
    at_ends = np.abs(errors[:, ticks]).max(axis=(1, 2))
    assert at_ends[0] > 3.0
    assert at_ends[-1] < 0.5
    # The whole way takes more than its ends: a law that heeds all of it keeps closer to it in between.
    followed = learnt(tmp_path, "noilc_constrained", REFERENCE)
    between = np.sqrt(np.mean(np.stack([errors[-1], followed[-1]])[:, 30:70] ** 2, axis=(1, 2)))
    assert between[0] > 2.0 * between[1]


def test_what_the_reference_does_between_the_points_does_not_matter(tmp_path):
    points = tuple(Point(at_s=end) for end in REFERENCE.ends_s[1:])
    rest, close, release = REFERENCE.phases
    detour = GraspPhases(rows=ROWS, phases=(rest, WAY, phase("close", 0.5, 34.0, 45.0, 22.0), release))
    straight, around = (learnt(tmp_path, "point_to_point", reference, points)
                        for reference in (REFERENCE, detour))
    tick = round(1.5 * RATE)
    np.testing.assert_allclose(around[:, tick], straight[:, tick], atol=1e-9)
    assert close.duration_s == pytest.approx(WAY.duration_s + 0.5)

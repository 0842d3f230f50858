"""Experiments made for `hand`, run on MyoHand; about 20 s."""

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop

pytest.importorskip("myo_sim", reason="the extra `myohand` is not installed")

MYOHAND = "blocks.hand.kind=myohand"
ANGLES, FORCE, VELOCITY = 0, 7, 9
TREE = hand_tree(HandSize())


def looped(name, *settings, plant_rate="100"):
    recorder = Recorder(plant_rate=plant_rate)
    return Loop(load(name, settings).wiring, recorder=recorder), recorder


def column(recorder, port):
    """All values of one of the hand's outputs."""
    return np.concatenate([row[2][port] for row in recorder.plants["hand"]])


@pytest.mark.parametrize("settings", [
    ("open_close",), ("grasp_cylinder",), ("recruitment_sweep",), ("grasp_cylinder", "patient.file=sci_c6"),
    ("grasp_cylinder", "patient.file=stroke_mild"), ("grasp_cylinder", "patient.file=stroke_severe_spastic")])
def test_experiments_and_patients_made_for_hand_run(settings):
    loop, recorder = looped(*settings, MYOHAND)
    loop.run_until(60 * NS_PER_MS)
    for port in (ANGLES, FORCE, VELOCITY):
        assert np.isfinite(column(recorder, port)).all()
    assert np.abs(np.diff(column(recorder, ANGLES), axis=0)).max() > 0.0


def test_stimulation_through_the_skin_opens_and_closes_both_hands_alike():
    moves = []
    for settings in ((), (MYOHAND,)):
        loop, recorder = looped("open_close", *settings)
        loop.run_until(5000 * NS_PER_MS)
        moves.append(np.degrees(column(recorder, ANGLES)))
    for finger in range(2, 6):
        rows = [TREE.freedom(f"F{finger}_{joint}_flexion") for joint in ("mcp", "pip", "dip")]
        one, other = (each[:, rows].sum(axis=1) for each in moves)
        assert np.ptp(one) > 60.0
        assert np.corrcoef(one, other)[0, 1] > 0.8, finger


def test_a_snapshot_goes_on_as_if_never_interrupted_whoever_else_looks():
    seen = []
    for plant_rate in ("1000", "70"):
        loop, recorder = looped("grasp_cylinder", MYOHAND, plant_rate=plant_rate)
        loop.run_until(300 * NS_PER_MS)
        snapshot = loop.snapshot()
        loop.run_until(700 * NS_PER_MS)
        again = Recorder(plant_rate=plant_rate)
        loop = Loop(load("grasp_cylinder", (MYOHAND,)).wiring, recorder=again)
        loop.restore(snapshot)
        loop.run_until(700 * NS_PER_MS)
        after = column(again, ANGLES)
        assert np.array_equal(after, column(recorder, ANGLES)[-len(after):])
        seen.append(after[-1])
    assert np.array_equal(*seen)


def test_a_hand_of_another_size_is_refused_by_name():
    with pytest.raises(InputError, match=r"blocks\.hand\.hand.*right one"):
        load("open_close", (MYOHAND, "blocks.hand.hand.side=left"))

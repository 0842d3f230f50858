"""A recording of what a test makes up: a hand on a script, and what a tracker would have said of it."""

from types import SimpleNamespace

import numpy as np

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from plants.moving_hand import MovingHand

PERIOD_NS = 10_000_000


class ToldRecording:
    """As `Recording` as far as the scores of reproductions read it; every trial is the same.

    A left hand on a script; `told` has each signal's values and captures, ns.
    """

    def __init__(self, script, trials=1, seed=1):
        told = {name: {"hand": {"side": "left"}}
                for name in ("tracker", "salchow_b", "salchow_m1", "salchow_m2")}
        self.experiment = {"blocks": {**told, "hand": {
            "kind": "moving_hand", "script": script, "hand": {"side": "left"}}}}
        self.seed, self.trials = seed, trials
        self.plant = MovingHand(script=script, hand=HandSize(side="left"))
        self.tree = hand_tree(self.plant.hand)
        self.times_ns = np.arange(0, int(self.plant.length_s * 1e9), PERIOD_NS)
        self.angles = self._read(self.times_ns)
        self.events = []
        self.told = {}
        self.tell("hand.angles", self.angles)
        self.tell("hand.fingertips", self.tips(self.angles))

    def _read(self, times_ns):
        context = SimpleNamespace(seed=self.seed, name="hand", trial=0)
        state = self.plant.init(context)
        return self.plant.observe(state, (), 0, tuple(int(t) for t in times_ns))[0]

    def tips(self, angles):
        """Fingertips (n, 5, 3), m, of the textbook's hand."""
        return segment_poses(self.tree, angles).position[:, [4, 7, 10, 13, 16]]

    def tell(self, name, values, captured_ns=None):
        """Add a signal; by default captured when it is put out."""
        self.told[name] = np.asarray(values), self.times_ns if captured_ns is None else captured_ns

    def signal(self, name, trial=0):
        values, captured = self.told[name]
        return SimpleNamespace(times_ns=self.times_ns, values=values, newest_ns=captured)

    def column(self, name, trial=0):
        return self.times_ns, self.told[name][0]


def summed(recording):
    """A scoring that other processes find."""
    return {"trials": recording.trials, "sum": float(recording.signal("finger.angles").values.sum())}


def broken(recording):
    raise ValueError("cannot be scored")

"""Numbers beside the hand of a view."""

from types import SimpleNamespace

import numpy as np

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.cast import Cast, Player
from fesloop.show.view.readout import readout_of

FREEDOMS = hand_tree(HandSize()).freedoms
TIMES = np.array([0, 1000], dtype=np.int64)


class Told:
    """Signals that somebody thought of."""

    def __init__(self, **columns):
        self.columns = {name.replace("__", "."): values for name, values in columns.items()}
        self.signals = list(self.columns)

    def column(self, name, trial=0):
        return TIMES, self.columns[name]


def cast(hand=False, stimulation=""):
    player = Player("hand", SimpleNamespace(hand=HandSize()))
    tracker = Player("tracker", SimpleNamespace(hand=HandSize()))
    return Cast(player if hand else None, (tracker,) if hand else (), None, None, "", stimulation, "", "")


def test_angles_of_a_whole_hand_are_in_degrees_by_digit_and_pulses_in_ma_and_us():
    truth, estimate = np.zeros((2, len(FREEDOMS))), np.zeros((2, len(FREEDOMS)))
    truth[1, 0], estimate[1, 0], estimate[1, 1] = np.deg2rad(30.0), np.deg2rad(31.24), np.nan
    pulses = np.array([[[0.0, 0.0]], [[0.02, 250e-6]]])
    signals = Told(hand__angles=truth, tracker__angles=estimate, safety__stimulation=pulses)
    found = readout_of(signals, cast(hand=True, stimulation="safety.stimulation"), {})
    assert [each["title"] for each in found.groups][:2] == ["wrist", "F1, thumb"]
    assert sum(len(each["joints"]) for each in found.groups) == len(FREEDOMS)
    assert found.groups[2]["joints"] == ["MCP flexion", "MCP abduction", "PIP flexion", "DIP flexion"]
    assert found.nodes == ["hand", "tracker", "safety"]
    now = found.at(signals, 0, np.array([500, 1500]))[1]
    assert now["angles"]["truth"][0] == 30.0
    assert now["angles"]["estimate"][:2] == [31.2, None]
    assert now["pulses"] == [[20.0, 250.0]]


def test_of_a_finger_scored_angles_are_read():
    signals = Told(patient__angles=np.full((2, 3), 0.5), tracker__angles=np.full((2, 3), 0.5))
    score = {"truth": "patient.angles", "estimate": "tracker.angles", "joints": ["MCP", "PIP", "DIP"]}
    found = readout_of(signals, cast(), score)
    assert found.groups == [{"title": "joints", "joints": ["MCP", "PIP", "DIP"]}]
    assert found.at(signals, 0, TIMES)[0]["angles"]["truth"] == [28.6] * 3


def test_what_is_not_recorded_or_has_another_shape_is_left_out():
    signals = Told(hand__angles=np.zeros((2, 3)), safety__stimulation=np.zeros((2, 4)))
    found = readout_of(signals, cast(hand=True, stimulation="safety.stimulation"), {"truth": None})
    assert (found.groups, found.channels, found.nodes) == ([], 0, [])
    assert found.at(signals, 0, TIMES) == [{"angles": {}, "pulses": []}] * 2

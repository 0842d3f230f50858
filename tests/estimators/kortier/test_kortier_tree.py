"""Which chains a body's sensors leave of its tree."""

import numpy as np
import pytest

from estimators.body.body import body_of
from estimators.kortier.tree import CHAIN5, chains_of
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import Segment

HAND = HandSize()
FINGERS = [["hand", f"F{i}{'mpd'[0] if i == 1 else 'p'}", f"F{i}{'p' if i == 1 else 'm'}", f"F{i}d"]
           for i in range(1, 6)]


def named(body, base):
    """The chains by names of segments, and the held ones."""
    chains, names = chains_of(body, body.tree.index(base)), body.tree.names
    found = [[names[body.sensed[s]] for s in chains.sensors[chains.first[c] + c:chains.first[c + 1] + c + 1]]
             for c in range(len(chains.first) - 1)]
    return chains, found, [names[k] for k in chains.held]


def test_a_hand_is_five_fingers_and_the_forearm_a_chain_of_its_own():
    _, found, held = named(body_of(16, HAND, (), ()), "hand")
    assert found == FINGERS
    assert held == ["hand"]
    chains, found, held = named(body_of(17, HAND, (), ()), "hand")
    assert found == [["forearm", "hand"], *FINGERS]
    assert held == ["hand"]
    assert chains.freedoms.tolist() == [2, 3, 1, 1] + [2, 1, 1] * 4
    assert chains.first_angle.tolist() == [0, 2, 5, 6, 7, 9, 10, 11, 13, 14, 15, 17, 18, 19, 21, 22]


def test_a_chain_ends_at_the_base_even_where_nothing_branches():
    worn = ("F2d", "F2m", "F2p", "hand", "forearm")
    _, found, _ = named(body_of(5, HAND, (), worn), "hand")
    assert found == [["forearm", "hand"], ["hand", "F2p", "F2m", "F2d"]]
    _, found, held = named(body_of(5, HAND, (), worn), "F2m")
    assert found == [["forearm", "hand", "F2p", "F2m"], ["F2m", "F2d"]]
    assert held == ["F2m"]


def test_what_a_sensor_left_off_cuts_apart_is_held_apart():
    body = body_of(6, HAND, (), ("hand", "F2p", "F2d", "F3m", "F3d", "F5m"))
    chains, found, held = named(body, "hand")
    assert found == [["hand", "F2p"], ["F3m", "F3d"]]
    assert held == ["hand", "F2d", "F3m", "F5m"]
    parts = {body.tree.names[k]: part for k, part in enumerate(chains.part_of) if part >= 0}
    assert parts == {"hand": 0, "F2p": 0, "F2d": 1, "F3m": 2, "F3d": 2, "F5m": 3}


def test_a_single_sensor_has_no_chain():
    chains, found, held = named(body_of(1, HAND, (), ("hand",)), "hand")
    assert (found, held) == ([], ["hand"])
    assert chains.axes.shape == (0, 3, 3)


def test_chain5_is_one_chain_with_hinges_about_x_y_and_z():
    chains, found, _ = named(body_of(5, HAND, CHAIN5, ()), "seg1")
    assert found == [["seg1", "seg2", "seg3", "seg4", "seg5"]]
    assert chains.freedoms.tolist() == [3, 1, 1, 1]
    np.testing.assert_array_equal(chains.axes[1:, 0], np.eye(3))
    assert np.diff(chains.first_entry).tolist() == [27 ** 2]


@pytest.mark.parametrize("base", ["a", "b", "c"])
def test_every_joint_is_in_one_chain(base):
    tree = (Segment(name="a"), Segment(name="b", parent="a", joint="hinge"), Segment(name="c", parent="b"),
            Segment(name="d", parent="b", joint="ball"), Segment(name="e", parent="d", joint="saddle"))
    chains, found, _ = named(body_of(5, HAND, tree, ()), base)
    assert sorted(chains.segments.tolist()) == [1, 2, 3, 4]
    assert found == [["a", "b"], ["b", "c"], ["b", "d", "e"]]

"""Elements of signals are called by what they are of, as far as a recording says."""

import pytest

from fesloop.experiment.export.channels import channels, quantity, row_names
from fesloop.experiment.recording.reading import TableSignal
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree

HAND = hand_tree(HandSize())
CHAIN = {"segments": [{"name": "radius", "joint": "fixed", "base": [0.0, 0.0, 0.0], "axes": [], "ranges": []},
                      {"name": "carpus", "parent": "radius", "joint": "saddle", "joint_name": "wrist",
                       "offset": [0.0, 0.1, 0.0], "ranges": [[-1.0, 1.0], [-0.5, 0.5]]}]}


@pytest.mark.parametrize(("port", "unit", "shape", "block", "names"), [
    ("angles", "rad", (23,), {}, HAND.freedoms),
    ("rates", "rad/s", (23,), {"hand": {}}, HAND.freedoms),
    ("angles", "rad", (2,), CHAIN, ("wrist_flexion", "wrist_abduction")),
    ("angles", "rad", (2,), {"rows": ["a", "b"]}, ("a", "b")),
    ("angles", "rad", (2,), {"rows": [[0, 1], [1, 2], [2, 0]]}, ("0", "1")),
    ("synergies", "rad", (2,), {"rows": ["wrist_extension", "finger_flexion"]},
     ("wrist_extension", "finger_flexion")),
    ("activation", "1", (29,), {}, MUSCLES),
    ("fingertips", "m", (5, 3), {"hand": {}}, ("F1", "F2", "F3", "F4", "F5")),
    ("fingertips", "m", (1, 3), CHAIN, ("0",)),
    ("orientation", "1", (17, 4), {"hand": {}}, HAND.names),
    ("gyr", "rad/s", (16, 3), {"hand": {}}, HAND.names[1:]),
    ("orientation", "1", (2, 4), CHAIN, ("radius", "carpus")),
    ("orientation", "1", (2, 4), {**CHAIN, "sensed": ["carpus", "radius"]}, ("carpus", "radius")),
    ("gyr", "rad/s", (2, 3), {"sites": ["hand", "F2p"]}, ("hand", "F2p")),
    ("gyr", "rad/s", (16, 3), {"kind": "replay"}, tuple(map(str, range(16)))),
    ("stimulation", "A,s", (2, 2), {}, ("0", "1")),
    ("phase", "1", (), {}, ()),
])
def test_rows_are_named(port, unit, shape, block, names):
    assert row_names(TableSignal(f"node.{port}", unit, shape), block) == tuple(names)


@pytest.mark.parametrize(("port", "unit", "shape", "what", "labels", "units"), [
    ("stimulation", "A,s", (1, 2), "other", ["0.current", "0.width"], ["A", "s"]),
    ("elements", "A,s,Hz", (1, 3), "other", ["0.current", "0.width", "0.frequency"], ["A", "s", "Hz"]),
    ("object_orientation", "1", (4,), "orientation", ["w", "x", "y", "z"], ["1"] * 4),
    ("object_position", "m", (3,), "position", ["x", "y", "z"], ["m"] * 3),
    ("fingertip_sd", "m", (1, 3), "other", ["0.x", "0.y", "0.z"], ["m"] * 3),
    ("angle_sd", "rad", (1,), "other", ["0"], ["rad"]),
    ("angles", "rad", (1,), "joint_angle", ["0"], ["rad"]),
    ("rates", "rad/s", (3,), "other", ["0", "1", "2"], ["rad/s"] * 3),
    ("acc", "m/s^2", (1, 3), "acceleration", ["0.x", "0.y", "0.z"], ["m/s^2"] * 3),
    ("preview", "rad", (2, 2), "other", ["0.0", "0.1", "1.0", "1.1"], ["rad"] * 4),
    ("level", "N", (), "other", [""], ["N"]),
    ("cube", "1", (2, 1, 2), "other", ["0.0.0", "0.0.1", "1.0.0", "1.0.1"], ["1"] * 4),
])
def test_channels_are_named_in_the_order_of_values(port, unit, shape, what, labels, units):
    signal = TableSignal(f"node.{port}", unit, shape)
    found = channels(signal, {})
    assert quantity(signal) == what
    assert [channel.label for channel in found] == labels
    assert [channel.unit for channel in found] == units

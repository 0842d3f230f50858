import math

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Sample
from fesloop.streams.blocks.synergies import Synergies

FREEDOMS = hand_tree(HandSize()).freedoms


def put_out(block, **degrees):
    angles, sd = np.zeros(23), np.full(23, 0.01)
    for name, angle in degrees.items():
        angles[FREEDOMS.index(name)] = math.radians(angle)
    samples = [Sample(value, 0, 0, 0) for value in (angles, sd)]
    return block.step(block.init(Context("synergies")), samples, Tick())


def test_ready_rows_are_what_their_names_say():
    block = Synergies(rows=("wrist_extension", "finger_flexion", "F3_flexion", "thumb_flexion"))
    values, sd = put_out(block, wrist_flexion=-20.0, F2_mcp_flexion=40.0, F3_pip_flexion=40.0,
                         F1_ip_flexion=30.0)
    np.testing.assert_allclose(np.degrees(values), [20.0, 10.0, 20.0, 15.0], atol=1e-12)
    np.testing.assert_allclose(sd, 0.01 / np.sqrt([1, 8, 2, 2]))


def test_rows_of_ones_own_with_an_offset():
    block = Synergies(rows=("claw",), weights={"claw": {"F2_pip_flexion": 1.0, "F2_mcp_flexion": -0.5}},
                      offset_deg={"claw": 5.0})
    values, _ = put_out(block, F2_pip_flexion=30.0, F2_mcp_flexion=10.0)
    assert math.degrees(values[0]) == pytest.approx(30.0)


def test_ranges_are_those_of_the_postures_at_the_ends_of_the_joints_ranges():
    tree = hand_tree(HandSize())
    block = Synergies(rows=("wrist_extension", "pip_flexion", "claw"), offset_deg={"claw": 5.0},
                      weights={"claw": {"F2_pip_flexion": 1.0, "F2_mcp_flexion": -0.5}})
    corners = np.random.default_rng(0).integers(0, 2, (400, 23))
    corners[:, FREEDOMS.index("F2_mcp_flexion")] = 1 - corners[:, FREEDOMS.index("F2_pip_flexion")]
    for finger in ("F3", "F4", "F5"):
        corners[:, FREEDOMS.index(f"{finger}_pip_flexion")] = corners[:, FREEDOMS.index("F2_pip_flexion")]
    postures = np.take_along_axis(tree.ranges[np.newaxis], corners[..., np.newaxis], -1)[..., 0]
    values = postures @ block.matrix.T
    reached = np.stack([values.min(axis=0), values.max(axis=0)], axis=-1) + block.offset[:, np.newaxis]
    np.testing.assert_allclose(block.ranges, reached, atol=1e-12)


@pytest.mark.parametrize(("given", "named"), [
    ({"rows": ("wrist_extention",)}, "did you mean 'wrist_extension'"),
    ({"rows": ("finger_flexion",) * 2}, "each once"),
    ({"rows": ("a",), "weights": {"a": {"F9_flexion": 1.0}}}, "weights.a: freedom 'F9_flexion'"),
    ({"rows": ("a",), "weights": {"a": {"wrist_flexion": 0.0}}}, "no weight"),
    ({"offset_deg": {"claw": 1.0}}, "offset_deg"),
])
def test_names_what_cannot_be(given, named):
    with pytest.raises(InputError, match=named):
        Synergies(**given)


def test_an_angle_itself_is_a_row_by_its_name():
    values, sd = put_out(Synergies(rows=("F4_dip_flexion", "wrist_extension")), F4_dip_flexion=12.0)
    np.testing.assert_allclose(np.degrees(values), [12.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(sd, 0.01)
    finger = Synergies(rows=("DIP", "MCP"), freedoms=("MCP", "PIP", "DIP"))
    np.testing.assert_array_equal(finger.matrix, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])

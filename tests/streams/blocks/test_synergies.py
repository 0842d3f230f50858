import math

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st

from controllers.reference import FingertipPath, GraspPhases
from controllers.reference.phases import GraspPhase
from fesloop.errors import InputError
from fesloop.experiment.metrics.grasp import aperture
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.kinematics import points, segment_poses
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


TREE = hand_tree(HandSize())
APERTURE = Synergies(rows=("wrist_extension", "grip_aperture"), offset_deg={"grip_aperture": 3.0})


def rows_and_sd(tips, tip_sd, angles=None):
    """Rows of the aperture's block, deg, which are mm of the aperture."""
    given = (np.zeros(23) if angles is None else angles, np.full(23, 0.01), tips, tip_sd)
    values, sd = APERTURE.step(APERTURE.init(Context("s")), [Sample(each, 0, 0, 0) for each in given], Tick())
    return np.degrees(values), np.degrees(sd)


@settings(deadline=None, max_examples=50)
@drawn(share=st.lists(st.floats(0.0, 1.0), min_size=23, max_size=23), seed=st.integers(0, 1000))
def test_the_aperture_is_that_of_the_posture_in_whatever_frame_its_fingertips_are(share, seed):
    """It is below the score's mean distance of the two tips by less than half of what lies between them."""
    random = np.random.default_rng(seed)
    angles = TREE.ranges[:, 0] + np.array(share) * np.ptp(TREE.ranges, axis=1)
    poses = segment_poses(TREE, angles[np.newaxis])
    tips = np.array([points(TREE, poses, f"{finger}d")[0] for finger in FINGERS])
    turn = quaternion.normalized(random.normal(size=4))
    moved = np.array([quaternion.rotate(turn, tip) for tip in tips]) + random.normal(size=3)
    thumb, index, middle = tips[:3]
    (wrist, opening), _ = rows_and_sd(moved, np.zeros((5, 3)), angles)
    assert wrist == pytest.approx(-np.degrees(angles[0]))
    assert opening - 3.0 == pytest.approx(500.0 * math.dist(index + middle, 2.0 * thumb), abs=1e-9)
    scored = 1e3 * float(aperture(tips[np.newaxis], ("F2", "F3"))[0])
    assert scored - 500.0 * math.dist(index, middle) - 1e-9 <= opening - 3.0 <= scored + 1e-9


@settings(deadline=None, max_examples=30)
@drawn(seed=st.integers(0, 10_000))
def test_the_apertures_sd_is_that_of_independent_tips(seed):
    random = np.random.default_rng(seed)
    tips, tip_sd = random.normal(0.0, 0.1, (5, 3)), random.uniform(0.0, 0.02, (5, 3))
    variance = 0.0
    for place in np.ndindex(5, 3):
        step = np.zeros((5, 3))
        step[place] = 1e-7
        slope = (rows_and_sd(tips + step, tip_sd)[0][1] - rows_and_sd(tips - step, tip_sd)[0][1]) / 2e-7
        variance += (slope * tip_sd[place])**2
    _, (of_angle, of_aperture) = rows_and_sd(tips, tip_sd)
    assert of_aperture == pytest.approx(math.sqrt(variance), rel=1e-4)
    assert of_angle == pytest.approx(math.degrees(0.01))


def test_fingertips_are_read_for_the_aperture_alone():
    assert [port.name for port in Synergies().inputs] == ["angles", "angle_sd"]
    assert [(port.name, port.optional) for port in APERTURE.inputs[2:]] == [
        ("fingertips", False), ("fingertip_sd", True)]
    missing = [Sample(np.zeros(23), 0, 0, 0)] * 2 + [Sample(np.zeros((5, 3)), -1, -1, -1)] * 2
    assert APERTURE.step(APERTURE.init(Context("s")), missing, Tick()) == ()
    with pytest.raises(InputError, match="grip_aperture"):
        APERTURE.linear_form(Context("s"))


def test_references_of_the_aperture_have_its_range():
    def phases(opening):
        return GraspPhases(rows=("grip_aperture",), phases=(
            GraspPhase(name="open", duration_s=1.0, deg={"grip_aperture": opening}),))

    assert np.degrees(phases(95.0).course(np.zeros(1)).values[0]) == pytest.approx(95.0)
    with pytest.raises(InputError, match="0 to 200 deg"):
        phases(-1.0)
    with pytest.raises(InputError, match="no sum of angles"):
        FingertipPath(rows=("grip_aperture",), points=())

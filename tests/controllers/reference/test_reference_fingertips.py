import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from controllers.reference.fingertips import FingertipPath, FingertipPoint
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import points, segment_poses
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.streams.blocks.synergies import Synergies

TREE = hand_tree(HandSize())
REST = np.radians(list(RESTING_DEG.values()))
BENT = (FingertipPoint(at_s=0.5),
        FingertipPoint(at_s=1.1, by_mm={"F1": (0.0, 8.0, 0.0), "F2": (0.0, 25.0, 0.0)}),
        FingertipPoint(at_s=1.6), FingertipPoint(at_s=2.2, by_mm={"F2": (-5.0, -25.0, 0.0)}))


def stepped(block, times_s):
    """Outputs at instants, each stacked."""
    told = []
    for time in np.atleast_1d(times_s):
        tick = Tick()
        tick.time_ns = round(time * 1e9)
        told.append(block.step(block.init(Context("reference")), (), tick))
    return [np.array(each) for each in zip(*told, strict=True)]


def tips_of(angles, fingers):
    poses = segment_poses(TREE, angles)
    return np.stack([points(TREE, poses, f"{finger}d") for finger in fingers], axis=-2)


@pytest.fixture(scope="module")
def bent():
    return FingertipPath(points=BENT, preview=3, preview_period_ms=40.0)


def test_fingertips_go_straight_as_quintics_and_postures_follow_them(bent):
    times = np.linspace(0.4, 2.4, 401)
    angles, wanted, _ = stepped(bent, times)
    # 0.1 mm, of which the straight lines between postures take most.
    assert np.linalg.norm(tips_of(angles, bent.fingers) - wanted, axis=-1).max() < 1e-4
    start = wanted[0, 1]
    goals = start + np.array([[0.0, 0.0, 0.0], [0.0, 0.025, 0.0], [0.0, 0.025, 0.0], [-0.005, 0.0, 0.0]])
    quintics = BPoly.from_derivatives([0.5, 1.1, 1.6, 2.2], [[goal, [0.0] * 3, [0.0] * 3] for goal in goals])
    within = (times >= 0.5) & (times <= 2.2)
    np.testing.assert_allclose(wanted[within, 1], quintics(times[within]), atol=1e-12)
    np.testing.assert_array_equal(angles[times < 0.5], angles[:1].repeat((times < 0.5).sum(), axis=0))
    assert (angles >= TREE.ranges[:, 0] - 1e-9).all()
    assert (angles <= TREE.ranges[:, 1] + 1e-9).all()


def test_what_does_not_move_keeps_the_preferred_posture(bent):
    angles, _, _ = stepped(bent, [0.0, 1.3])
    still = [k for k, name in enumerate(TREE.freedoms) if name[:2] not in ("F1", "F2")]
    np.testing.assert_allclose(angles[:, still], np.broadcast_to(REST[still], (2, len(still))))


def test_preview_is_what_it_will_say_then(bent):
    np.testing.assert_allclose(stepped(bent, 0.7)[2][0], stepped(bent, [0.74, 0.78, 0.82])[0], atol=1e-12)


def test_rows_are_sums_of_the_same_angles(bent):
    rows = ("F2_flexion", "thumb_flexion", "wrist_extension", "F2_dip_flexion")
    told, _ = stepped(FingertipPath(points=BENT, rows=rows), [0.8, 1.7])
    angles = stepped(bent, [0.8, 1.7])[0]
    synergies = angles @ Synergies(rows=rows[:3]).matrix.T
    np.testing.assert_allclose(told[:, :3], synergies, atol=1e-12)
    np.testing.assert_allclose(told[:, 3], angles[:, TREE.freedom("F2_dip_flexion")], atol=1e-12)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_two_reachable_places_are_joined_or_the_way_is_named(seed):
    posture = REST.copy()
    for finger in ("F2", "F4"):
        first = TREE.freedom(f"{finger}_mcp_flexion")
        rng = np.random.default_rng(seed)
        low, high = TREE.ranges[first:first + 4].T
        posture[first:first + 3] = rng.uniform(low, high)[:3]
        posture[first + 3] = 2.0 / 3.0 * posture[first + 2]
    places = {finger: tuple(1e3 * tip) for finger, tip in zip(
        ("F2", "F4"), tips_of(posture, ("F2", "F4")), strict=True)}
    path = (FingertipPoint(at_s=0.0), FingertipPoint(at_s=2.0, mm=places))
    refused = None
    try:
        angles, _ = stepped(FingertipPath(points=path), [2.0])
        np.testing.assert_allclose(1e3 * tips_of(angles[0], ("F2", "F4")), list(places.values()), atol=0.1)
    except InputError as fault:
        refused = fault
    assert refused is None or refused.where == "points[1]"
    assert refused is None or "mm off its path" in refused.found or "deg/s" in refused.found


def test_what_stays_off_its_path_within_the_tolerance_is_told():
    straight = FingertipPoint(at_s=1.0, mm={"F2": (0.0, -186.0, 23.0)})
    with pytest.raises(InputError, match=r"points\[1\]: F2 stays [\d.]+ mm off its path at 1 s.*tolerance"):
        FingertipPath(points=(FingertipPoint(at_s=0.0), straight))
    block = FingertipPath(points=(FingertipPoint(at_s=0.0), straight), tolerance_mm=50.0)
    angles, wanted = stepped(block, 1.0)
    off = 1e3 * np.linalg.norm(tips_of(angles, ("F2",)) - wanted, axis=-1)[0, 0]
    assert block.off_path_mm == {"F2": pytest.approx(off, abs=1e-6)}
    ((status, detail),) = block.cautions(Context("reference"))
    assert status == "path_unreachable"
    assert f"F2 is up to {off:.2f} mm" in detail


def test_a_place_that_another_posture_reaches_needs_time():
    near = FingertipPoint(at_s=0.01, by_mm={"F2": (0.0, 40.0, 0.0)})
    with pytest.raises(InputError, match=r"points\[1\]: F2_\w+ turns by \d+ deg/s .*at most 2000 deg/s"):
        FingertipPath(points=(FingertipPoint(at_s=0.0), near))


def test_a_file_makes_the_same_object():
    table = {"kind": "fingertip_path", "rate": "40", "rows": ["F2_flexion"], "hand": {"side": "left"},
             "posture_deg": {"wrist_flexion": -20},
             "points": [{"at_s": 0.5}, {"at_s": 1, "by_mm": {"F2": [0, -10, 0]}}]}
    experiment = from_document({"experiment": {"name": "told", "duration_s": 2.0},
                                "blocks": {"reference": table}})
    path = (FingertipPoint(at_s=0.5), FingertipPoint(at_s=1.0, by_mm={"F2": (0.0, -10.0, 0.0)}))
    assert experiment.nodes[0].part == FingertipPath(
        points=path, rows=("F2_flexion",), hand=HandSize(side="left"), posture_deg={"wrist_flexion": -20.0})
    assert from_document(experiment.document()) == experiment


@pytest.mark.parametrize(("changed", "named"), [
    ({"points": ()}, "points: at_s"),
    ({"points": (FingertipPoint(at_s=1.0), FingertipPoint(at_s=1.0))}, "each later"),
    ({"points": (FingertipPoint(at_s=1.0),)}, "points: no finger is named"),
    ({"posture_deg": {"wrist": 10.0}}, "posture_deg: 'wrist' is no freedom"),
    ({"posture_deg": {"wrist_flexion": 80.0}}, "posture_deg.wrist_flexion: 80 deg is outside the range"),
    ({"moving": ("F2_pip",)}, "moving: 'F2_pip'.*did you mean 'F2_pip_flexion'"),
    ({"rows": ("claw",)}, "rows: 'claw'"), ({"tolerance_mm": -1.0}, "tolerance_mm"),
    ({"preview": -1}, "preview"), ({"contact": "nail"}, "nail"),
])
def test_names_what_cannot_be(changed, named):
    with pytest.raises(InputError, match=named):
        FingertipPath(**{"points": BENT} | changed)


@pytest.mark.parametrize(("changed", "named"), [
    ({"at_s": -1.0}, "at_s"), ({"at_s": 601.0}, "at_s"),
    ({"mm": {"F6": (0.0, 0.0, 0.0)}}, "mm.F6: is no finger"),
    ({"mm": {"F2": (0.0, float("nan"), 0.0)}}, "mm.F2"), ({"by_mm": {"F2": (0.0, 1.0)}}, "by_mm.F2"),
    ({"mm": {"F2": (0.0, 0.0, 0.0)}, "by_mm": {"F2": (0.0, 0.0, 0.0)}}, "by_mm.F2: is given together"),
])
def test_names_what_a_point_cannot_be(changed, named):
    with pytest.raises(InputError, match=named):
        FingertipPoint(**{"at_s": 1.0} | changed)

"""The shipped experiment of grip force, cut short: with control the force stays, set once it fades.

About 40 s: the whole chain, twice.
"""

import numpy as np
import pytest

import fesloop
from fesloop import Recording

SHORT = ["experiment.duration_s=22", "score.grasp.until_s=22"]


@pytest.fixture(scope="module")
def controlled(tmp_path_factory):
    return fesloop.load("hold_grip_force", SHORT).run(tmp_path_factory.mktemp("controlled"))


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    return fesloop.load("hold_grip_force", [*SHORT, "set_within_s=2"]).run(tmp_path_factory.mktemp("once"))


def last_grip_n(result):
    """Force between both sides of the hand over the last second, N."""
    with Recording(result.recording) as recording:
        force = recording.signal("grip.grip")
        return force.values[force.times_ns > force.times_ns[-1] - 1_000_000_000].mean()


@pytest.mark.slow
def test_controlled_force_stays_and_force_set_once_fades(controlled, once):
    assert last_grip_n(controlled) > 1.1 * last_grip_n(once)
    controlled, once = controlled.metrics, once.metrics
    assert controlled["held"] == once["held"] == [True]
    grip_n = 0.5 * sum(values[0] for values in controlled["grip_force_n"].values())
    assert controlled["grip_force_rmse_n"][0] < 0.1 * grip_n
    assert once["grip_force_rmse_n"][0] > 1.3 * controlled["grip_force_rmse_n"][0]


def test_a_grip_that_settles_reports_no_slips_and_a_held_cylinder_does_not_creep(controlled):
    with Recording(controlled.recording) as recording:
        assert not [event for event in recording.events if event.status == "slip"]
        target = recording.signal("grip.target").values
        place = recording.signal("hand.object_position")
    assert target[-1] == 3.5
    late = place.values[place.times_ns > 16_000_000_000]
    assert np.linalg.norm(late[-1] - late[0]) < 0.5e-3 * 6.0


def test_posture_is_controlled_through_the_tracker_until_contact(controlled):
    with Recording(controlled.recording) as recording:
        events = [(event.where, event.status, event.time_ns) for event in recording.events]
        scale = recording.signal("grip.scale")
        given = recording.signal("grip.stimulation").values[..., 1]
        asked = recording.signal("posture.stimulation").values[..., 1]
    (contact_ns,) = [time_ns for where, status, time_ns in events if (where, status) == ("grip", "contact")]
    before = scale.times_ns < contact_ns
    assert contact_ns > 3.5e9
    np.testing.assert_array_equal(given[before], asked[before])
    assert scale.values[-1] > 1.3
    assert controlled.metrics["tracker_rmse_deg"][0] < 2.0


def test_a_clinician_reads_all_of_it(controlled):
    metrics = controlled.metrics
    for name in ("held", "held_s", "time_to_grasp_s", "grip_margin", "wrist_extension_deg",
                 "unwanted_motion_deg", "charge_uc", "grasps_until_fatigue"):
        assert len(metrics[name]) == 1
        assert metrics[name][0] is not None
    assert {"opening", "contact", "hold"} == set(metrics["aperture_mm"])

"""The `kortier` tracker on recordings, against published figures and in a field that misleads it."""

import numpy as np
import pytest
from tracker_parts import run_tracker

from estimators.kortier import KortierTracker
from fesloop import Recording, load
from fesloop.apps.bench.tracker import tick_times_us
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.hand import quaternion
from fesloop.hand.segments import Segment
from fesloop.streams.files import open_recording

SOFT = {"nonrigid": {"constraint_sd_deg": 5.0}}
"""Sensors on foam rotate by several degrees as they are shaken; the default is for tissue that does not."""
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def scored(recording, sensed, segments):
    """Scores of the pairs of a recording, some of its sensors left out; the others' orientations are NaN."""
    block = KortierTracker(sensors=len(sensed), segments=segments, magnetometers=False,
                           **SOFT.get(recording.sensor_set, {}))
    samples = (recording.gyr[:, sensed], recording.acc[:, sensed])
    outputs, _, _ = run_tracker(block, *samples, rate=recording.rate)
    orientation = np.full((len(recording.gyr), len(recording.sensors), 4), np.nan)
    orientation[:, sensed] = outputs[0]
    return score_recording(recording, recording.stamps_ns, orientation, "relative")


def rmse(score, pair):
    return score["orientation_rmse_deg"][pair]["total"]


# The batch method published with the recording: hinges 5.30 and 8.22, saddles 6.6 and 9.95 deg.
PUBLISHED = [("rigid", 5.30, 6.6), ("nonrigid", 8.22, 9.95)]


@pytest.mark.slow
@pytest.mark.parametrize(("sensor_set", "hinges", "saddles"), PUBLISHED)
def test_chain5_is_followed_better_than_by_the_published_batch(recordings, sensor_set, hinges, saddles):
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    score = scored(recording, range(5), ())
    found = [rmse(score, f"seg{i}-seg{i + 1}") for i in (2, 3, 4)]
    across = [rmse(score, pair) for pair in ("seg2-seg4", "seg3-seg5")]
    print(f"{sensor_set}: hinges {np.round(found, 2)}, saddles {np.round(across, 2)}")
    assert np.mean(found) < hinges
    assert np.mean(across) < saddles


@pytest.mark.slow
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_sds_of_real_hinges_are_at_most_twice_their_errors(sensor_set, recordings):
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    block = KortierTracker(sensors=5, magnetometers=False, **SOFT.get(sensor_set, {}))
    outputs = run_tracker(block, recording.gyr, recording.acc, rate=recording.rate)[0]
    ports = dict(zip((port.name for port in block.outputs), outputs, strict=True))
    reference, found = recording.reference, []
    for k, axis in zip((1, 2, 3), np.eye(3), strict=True):
        between = quaternion.relative(reference.orientation[:, k], reference.orientation[:, k + 1])
        true = 2.0 * np.arctan2(between[:, 1:] @ axis, between[:, 0])
        angle, sd, random_sd = (
            np.interp(reference.stamps_ns, recording.stamps_ns, np.unwrap(ports[name][:, 2 + k]))
            for name in ("angles", "angle_sd", "angle_random_sd"))
        error = np.angle(np.exp(1j * (angle - true)))
        known = np.isfinite(error) & reference.scored
        found.append([each[known] for each in (error, sd, error - np.mean(error[known]), random_sd)])
    error, sd, changing, random_sd = (np.concatenate(each) for each in zip(*found, strict=True))
    rms, random_rms = (float(np.sqrt(np.mean(each ** 2))) for each in (error, changing))
    share, random_share = np.mean(np.abs(error) <= 2.0 * sd), np.mean(np.abs(changing) <= 2.0 * random_sd)
    print(f"{sensor_set}: {100 * share:.1f} % within 2 sd, sd and rms "
          f"{np.degrees([np.median(sd), rms]).round(2)}; without the mean {100 * random_share:.1f} %, "
          f"{np.degrees([np.median(random_sd), random_rms]).round(2)}")
    assert share >= 0.9
    assert np.median(sd) <= 2.0 * rms
    assert 0.9 <= random_share <= 0.99


@pytest.mark.parametrize(("sensor_set", "published"), [("rigid", 6.6), ("nonrigid", 9.95)])
def test_chain5_with_the_middle_sensor_of_a_saddle_left_out(recordings, sensor_set, published):
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    found = []
    for sensed, axes in (((1, 3), (X, Y)), ((2, 4), (Y, Z))):
        names = [recording.sensors[i] for i in sensed]
        tree = (Segment(name=names[0]), Segment(name=names[1], parent=names[0], joint="saddle", axes=axes))
        found.append(rmse(scored(recording, sensed, tree), "-".join(names)))
    print(f"{sensor_set}: saddles {np.round(found, 2)}")
    assert np.mean(found) < published


def test_wrist_angle(recordings):
    """Two sensors on a robot's wrist, taken for a saddle joint as that of the hand is."""
    recording = open_recording(str(recordings / "wrist" / "circle-250.npz"), None)
    tree = (Segment(name="radius"), Segment(name="carpus", parent="radius", joint="saddle"))
    score = scored(recording, range(2), tree)
    print(f"wrist: {score['relative_angle_rmse_deg']}")
    assert score["relative_angle_rmse_deg"]["radius-carpus"] < 1.7


@pytest.mark.realtime
def test_sixteen_streams_keep_up_with_100_hz(recordings):
    path = recordings / "body16" / "qmt_full_body_example_data.mat"
    recording = open_recording(str(path), None)
    samples = (recording.gyr[:2000], recording.acc[:2000])
    times = tick_times_us(KortierTracker(sensors=16, magnetometers=False), samples, 100)
    late = np.percentile(times[100:], 99)
    print(f"body16: {np.median(times[100:]):.1f} us a tick (median), {late:.1f} us (p99)")
    assert late < 10_000.0


@pytest.mark.parametrize(("sensor_set", "hinges"), [("rigid", 5.0), ("nonrigid", 11.0)])
def test_a_field_that_misleads_is_read_no_more(sensor_set, hinges, recordings):
    """Indoors, beside iron: hinges were 6 and 22 deg off, a ball joint over 100 and called certain."""
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    block = KortierTracker(sensors=5)
    kinds = recording.gyr, recording.acc, recording.mag
    outputs, reports, _ = run_tracker(block, *kinds, rate=recording.rate)
    (detail,) = [detail for status, detail in reports if status == "field_misleads"]
    assert "set magnetometers = false" in detail
    score = score_recording(recording, recording.stamps_ns, outputs[0], "absolute")
    assert np.mean([rmse(score, f"seg{i}-seg{i + 1}") for i in (2, 3, 4)]) < hinges
    ball_sd = np.degrees(np.median(outputs[2][:, :3], axis=0))
    assert rmse(score, "seg1-seg2") < 3.5 * ball_sd.max()
    begun = [kind[:400].copy() for kind in kinds]
    again = run_tracker(block, *begun, rate=recording.rate)[0]
    begun[2][200:] = np.nan
    np.testing.assert_array_equal(run_tracker(block, *begun, rate=recording.rate)[0][0], again[0])


@pytest.mark.parametrize(("magnet", "told"), [(0, False), (2, True)])
def test_a_magnet_beside_the_hand_is_found_and_no_other(magnet, told, tmp_path):
    """Without one nothing is reported; with it the controlled joints are followed better."""
    settings = ["tracker=kortier", f"magnet_a_m2={magnet}"]
    done = load("grasp_mpc", settings).run(tmp_path)
    with Recording(done.recording) as recording:
        found = [event.status for event in recording.events if event.where == "tracker"]
    assert ("field_misleads" in found) == told
    if told:
        assert done.metrics["tracker_rmse_deg"][0] < 3.0

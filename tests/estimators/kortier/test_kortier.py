"""The `kortier` tracker: a finger and a hand with known motion, samples late, lost, clipped and missing."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import RATE, planar_finger, run_tracker

from estimators.gaps import turn_after
from estimators.kortier import KortierTracker
from estimators.kortier.samples import Trust, no_moment, take
from estimators.kortier.tick import track
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.kinematics import relative_orientations
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

START_DEG = (20.0, 30.0, 10.0)
FINGER = (Segment(name="palm"),
          *(Segment(name=name, parent=parent, joint=kind, joint_name=joint, offset=(0.0, -length, 0.0))
            for name, parent, kind, joint, length in (("proximal", "palm", "saddle", "mcp", 0.045),
                                                      ("middle", "proximal", "hinge", "pip", 0.026),
                                                      ("distal", "middle", "hinge", "dip", 0.017))))
START = dict(zip(("mcp_flexion", "pip_flexion", "dip_flexion"), START_DEG, strict=True))
FLEXION = [0, 2, 3]
FIELD = np.array([0.0, 20e-6, -44e-6])
TIMES = np.arange(6 * RATE) / RATE
PALM_DOWN = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.pi / 2)
TILTED = quaternion.from_axis_angle([1.0, 1.0, 0.0], 1.2)


def finger(base=TILTED, depth_deg=(50.0, 60.0, 30.0), seed=0, times=TIMES):
    """gyr, acc, mag (ticks, 4, 3) with noise and bias; flexion (ticks, 3), attitudes (ticks, 4, 4)."""
    gyr, acc, true = planar_finger(times, np.radians(START_DEG), np.radians(depth_deg), base)
    whole = np.cumsum(np.hstack([np.zeros((len(times), 1)), true]), axis=1)
    attitude = quaternion.multiply(base, quaternion.about_z(whole))
    rng = np.random.default_rng(seed)
    gyr = gyr + 5e-4 * rng.normal(size=gyr.shape) + 0.005 * rng.normal(size=(4, 3))
    mag = quaternion.rotate(quaternion.conjugate(attitude), FIELD) + 3e-7 * rng.normal(size=gyr.shape)
    return gyr, acc + 4e-2 * rng.normal(size=acc.shape), mag, true, attitude

EXACT = {"mounting_sd_deg": 1e-3, "axis_sd_deg": 1e-3, "heading_sd_deg": 1e-3,
         "fusion_sd_deg": 1e-3}
"""Priors of a body whose sensors and joints are exactly where they are assumed."""


def tracker(**changed):
    return KortierTracker(**{"sensors": 4, "segments": FINGER, "initial_angles_deg": START, **changed})


@pytest.mark.parametrize("base", [TILTED, PALM_DOWN])
def test_joint_angles_of_a_swinging_finger(base):
    gyr, acc, mag, true, _ = finger(base)
    (_, angles, sd, *_), reports, _ = run_tracker(tracker(), gyr, acc, mag)
    error = angles[:, FLEXION] - true
    assert reports == []
    assert np.degrees(np.sqrt(np.mean(error ** 2, axis=0))).max() < 3.0
    assert np.degrees(np.sqrt(np.mean(angles[:, 1] ** 2))) < 1.5
    assert np.sqrt(np.mean((error / sd[:, FLEXION]) ** 2)) < 2.0


def test_where_flexion_is_about_the_vertical_the_uncertainty_says_so():
    """Neither gravity nor a constraint shows such flexion, and one magnetometer pair not its share."""
    gyr, acc, mag, true, _ = finger(np.array([1.0, 0.0, 0.0, 0.0]))
    (_, angles, sd, *_), _, _ = run_tracker(tracker(), gyr, acc, mag)
    assert np.degrees(sd[-1, FLEXION]).min() > 3.0
    assert np.sqrt(np.mean(((angles[:, FLEXION] - true) / sd[:, FLEXION]) ** 2)) < 2.0


def test_a_wrong_start_is_corrected_and_its_uncertainty_covers_it():
    gyr, acc, mag, true, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    straight = tracker(**EXACT, initial_angles_deg={}, angle_sd_deg=20.0)
    (_, angles, *_), _, _ = run_tracker(straight, gyr, acc, mag)
    assert np.degrees(np.abs(angles[0, FLEXION] - true[0])).max() > 0.05
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 1.5


def test_orientations_are_to_the_earth_and_north():
    gyr, acc, mag, _, attitude = finger()
    (orientation, *_), _, _ = run_tracker(tracker(), gyr, acc, mag)
    off = quaternion.rotation_angle(quaternion.multiply(orientation, quaternion.conjugate(attitude)))
    assert np.degrees(np.sqrt(np.mean(off[100:] ** 2))) < 3.0


def test_a_still_hand_stays_where_it_is():
    gyr, acc, mag, _, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    (*_, position, velocity, _, _), _, _ = run_tracker(tracker(), gyr, acc, mag)
    assert np.abs(position).max() < 0.02
    assert np.abs(velocity[-1]).max() < 0.01


def test_position_follows_a_short_move():
    """10 cm along x in half a second, minimum jerk, from rest to rest."""
    times = np.arange(300) / RATE
    s = np.clip((times - 1.0) / 0.5, 0.0, 1.0)
    along = 0.1 / 0.25 * (60 * s - 180 * s**2 + 120 * s**3)
    acc = np.tile([0.0, 0.0, 9.81], (300, 4, 1))
    acc[..., 0] = along[:, None]
    gyr, mag = np.zeros((300, 4, 3)), np.tile(FIELD, (300, 4, 1))
    (*_, position, velocity, _, _), _, _ = run_tracker(tracker(), gyr, acc, mag)
    np.testing.assert_allclose(position[-1], [0.1, 0.0, 0.0], atol=0.01)
    np.testing.assert_allclose(velocity[-1], 0.0, atol=0.01)


def run_at_200_hz(block, gyr, acc, mag, held):
    """Gyroscopes at 200 Hz; accelerometers and magnetometers held for every second tick, or as fast."""
    clock = RateClock.from_rate(200)
    state, tick, outputs = block.init(Context("tracker", clock=clock)), Tick(), []
    for k in range(len(gyr)):
        tick.index, tick.time_ns = k, clock.tick(k)
        last = k - k % 2 if held else k
        captured = clock.tick(last)
        slow = [Sample(kind[last], captured, captured, captured) for kind in (acc, mag)]
        outputs.append(block.step(state, [Sample(gyr[k], *[tick.time_ns] * 3), *slow], tick))
    return [np.array(port) for port in zip(*outputs, strict=True)], tick.reports


def test_slower_accelerometers_are_taken_once_a_sample():
    still = [kind[:40] for kind in finger(PALM_DOWN, (0.0, 0.0, 0.0))[:3]]
    block = tracker(**EXACT, angle_sd_deg=20.0, lever_m=0.0, error_time_s=0.0)
    (_, _, once, *_), reports = run_at_200_hz(block, *still, held=True)
    (_, _, twice, *_), _ = run_at_200_hz(block, *still, held=False)
    assert reports == []
    # Of twice the samples the sd would be smaller by the root of two, before the biases come to matter.
    np.testing.assert_allclose((once / twice)[3:16:2, 2:], np.sqrt(2.0), rtol=0.12)


def test_joint_angles_with_slower_accelerometers():
    gyr, acc, mag, true, _ = finger()
    # The same motion in half the time, under the accelerations of the slow one.
    (_, angles, *_), _ = run_at_200_hz(tracker(), 2.0 * gyr, acc, mag, held=True)
    assert np.degrees(np.sqrt(np.mean((angles[:, FLEXION] - true) ** 2, axis=0))).max() < 4.0


@pytest.mark.slow
def test_without_a_magnetometer_wired():
    gyr, acc, _, true, _ = finger()
    nothing = Sample(np.zeros((4, 3)), NEVER, NEVER, NEVER)
    clock, block = RateClock.from_rate(RATE), tracker()
    state, tick, angles = block.init(Context("tracker", clock=clock)), Tick(), []
    for k in range(len(gyr)):
        tick.index, tick.time_ns = k, clock.tick(k)
        now = [Sample(kind[k], *[tick.time_ns] * 3) for kind in (gyr, acc)]
        angles.append(block.step(state, [*now, nothing], tick)[1][FLEXION])
    assert tick.reports == []
    assert np.degrees(np.sqrt(np.mean((np.array(angles) - true) ** 2))) < 4.0
    without = tracker(magnetometers=False)
    assert [port.name for port in without.inputs] == ["gyr", "acc"]
    (_, others, *_), _, _ = run_tracker(without, gyr, acc)
    np.testing.assert_array_equal(others[:, FLEXION], angles)


def test_short_losses_and_clipping_are_flagged_and_widen_the_uncertainty():
    gyr, acc, mag, true, _ = finger()
    clean = run_tracker(tracker(**EXACT), gyr, acc, mag)[0]
    spoilt, full = gyr.copy(), gyr.copy()
    spoilt[300:304, 2] = np.nan
    full[300:304, 2, 2] = np.radians(2000.0)
    for wrong, status in ((spoilt, "lost_sample"), (full, "clipped_sample")):
        (_, angles, sd, *_), reports, _ = run_tracker(tracker(**EXACT), wrong, acc, mag)
        assert reports == [(status, "gyr of sensor middle"),
                           ("samples_valid", "every sensor gives sound samples again")]
        assert (sd[303, 2:] > 1.2 * clean[2][303, 2:]).all()
        assert np.isfinite(angles).all()
    (_, angles, *_), _, _ = run_tracker(tracker(**EXACT), spoilt, acc, mag)
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 6.0


@pytest.mark.slow
@given(st.floats(0.1, 40.0), st.floats(0.002, 0.02), st.floats(0.1, 5.0))
@settings(deadline=None, max_examples=50)
def test_a_step_with_a_gap_is_believed_as_far_as_a_rate_can_have_changed_in_the_gap(periods, period, lost_sd):
    trust = Trust(gyr_sd=0.01, acc_sd=0.1, mag_sd=1.0, lost_sd=lost_sd, clipped_sd=10.0, lever_m=0.0,
                  error_time_s=0.0)
    moment, sample, sound = no_moment(1), np.full((1, 3), 0.5), np.zeros((3, 1), np.uint8)
    for dt in (period, periods * period):
        take(np.stack([sample] * 3), sound, np.array([dt, dt, dt]), period, trust, moment)
    share, variance = turn_after(dt, lost_sd) if dt >= 1.5 * period else (0.5 * dt, 0.0)
    assert (moment.gyr_variance[0] - trust.gyr_sd**2) * dt**2 == pytest.approx(variance, abs=1e-12)
    np.testing.assert_allclose(dt * moment.rates[0], share)


@pytest.mark.parametrize(("rate", "status"), [(1000.0, "clipped_sample"), (1e200, "lost_sample")])
def test_rates_that_no_hand_has_leave_nothing_but_numbers(rate, status):
    """A garbled stream, for as long as a filter can overflow: what it left was NaN for good."""
    gyr, acc, mag, _, _ = finger()
    gyr[300:500, 2:] = rate
    outputs, reports, state = run_tracker(tracker(), gyr, acc, mag)
    assert reports[0] == (status, "gyr of sensor middle, distal")
    assert all(np.isfinite(port).all() for port in outputs)
    assert np.abs(state.moment.steady).max() < 20.0
    gyr[300:500, 2:] = np.nan
    lost = run_tracker(tracker(), gyr, acc, mag)[0]
    same = [np.array_equal(*ports) for ports in zip(outputs, lost, strict=True)]
    assert all(same) == (status == "lost_sample")


def test_a_strip_left_off_is_unseen_and_comes_back():
    gyr, acc, mag, true, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    for kind in (gyr, acc, mag):
        kind[:300, 2:] = 0.0
    (_, angles, sd, *_), reports, _ = run_tracker(tracker(), gyr, acc, mag)
    assert ("untracked", "joint pip, dip") in reports
    assert reports[-1] == ("tracked", "joint pip, dip")
    assert (sd[:300, 2:] == np.pi).all()
    assert (angles[:300, 2:] == 0.0).all()
    assert np.degrees(np.abs(angles[250, 0] - true[250, 0])) < 1.5
    assert np.degrees(sd[-1]).max() < 10.0
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 2.0


def test_sensors_that_fall_silent_in_a_fast_movement_are_believed_no_more_than_they_know_afterwards():
    gyr, acc, mag, true, _ = finger(times=np.arange(30 * RATE) / RATE)
    silent = slice(350, 2350)
    assert np.abs(gyr[silent.start - 1, 2:, 2]).min() > 4.0
    for kind in (gyr, acc, mag):
        kind[silent, 2:] = np.nan
    (_, angles, sd, *_), _, _ = run_tracker(tracker(), gyr, acc, mag)
    back = slice(silent.stop + 2 * RATE, silent.stop + 5 * RATE)
    error = (angles[:, FLEXION] - true)[back]
    assert np.degrees(np.abs(error)).max() < 5.0
    assert (np.abs(error) < 3.0 * sd[back][:, FLEXION]).all()


def test_a_lost_joint_keeps_its_last_angle():
    gyr, acc, mag, _, _ = finger()
    gyr[300:400, 3] = np.nan
    (_, angles, sd, _, tip_sd, *_), reports, _ = run_tracker(tracker(), gyr, acc, mag)
    assert ("untracked", "joint dip") in reports
    lost = slice(311, 400)
    assert (sd[lost, 3] == np.pi).all()
    np.testing.assert_allclose(angles[lost, 3], angles[310, 3], atol=1e-12)
    assert tip_sd[399, 0].max() > 0.017
    assert tip_sd[250, 0].max() < 0.01


def test_a_chain_of_hinges_about_other_axes():
    """Nothing but gravity and what tilted hinges allow: motion about their axes is found."""
    tilt = quaternion.to_matrix(quaternion.from_axis_angle([1.0, 2.0, -1.0], 0.9))
    axes = [tuple(row) for row in tilt[:2]]
    tree = SegmentTree((Segment(name="a"), Segment(name="b", parent="a", joint="hinge", axes=(axes[0],)),
                        Segment(name="c", parent="b", joint="hinge", axes=(axes[1],))))
    true = np.stack([0.8 * np.sin(2.0 * TIMES), 0.5 * np.sin(3.0 * TIMES)], axis=1)
    relative = relative_orientations(tree, true)
    attitude = [np.broadcast_to(TILTED, (len(TIMES), 4))]
    for k in (1, 2):
        attitude.append(quaternion.multiply(attitude[-1], relative[:, k]))
    attitude = np.stack(attitude, axis=1)
    turn = quaternion.relative(attitude[:-1], attitude[1:])
    gyr = np.concatenate([np.zeros((1, 3, 3)), 2.0 * RATE * turn[..., 1:]])
    rng = np.random.default_rng(0)
    acc = quaternion.rotate(quaternion.conjugate(attitude), [0.0, 0.0, 9.81])
    acc += 4e-2 * rng.normal(size=gyr.shape)
    gyr = gyr + 0.01 * rng.normal(size=(3, 3)) + 5e-4 * rng.normal(size=gyr.shape)
    block = KortierTracker(sensors=3, segments=tree.segments)
    (_, angles, sd, *_), _, _ = run_tracker(block, gyr, acc, np.zeros_like(gyr))
    error = (angles - true)[100:]
    assert np.degrees(np.sqrt(np.mean(error ** 2))) < 2.0
    assert np.sqrt(np.mean((error / sd[100:]) ** 2)) < 2.0


def test_a_whole_hand_and_its_snapshot():
    rng = np.random.default_rng(3)
    gyr, acc, mag = rng.normal(size=(3, 80, 16, 3))
    acc += np.array([0.0, 0.0, 9.81])
    mag = 1e-6 * mag + FIELD
    block = KortierTracker().resolve({"gyr": (16, 3), "acc": (16, 3), "mag": (16, 3)})
    whole, _, _ = run_tracker(block, gyr, acc, mag)
    assert [part.shape[1:] for part in whole] == [
        (16, 4), (23,), (23,), (5, 3), (5, 3), (3,), (3,), (1,), (23,)]
    _, _, state = run_tracker(block, gyr, acc, mag, last=37)
    compiled = len(track.signatures)
    rest, _, _ = run_tracker(block, gyr, acc, mag, state=pickle.loads(pickle.dumps(state)), first=37)
    assert len(track.signatures) == compiled, "nothing is compiled anew for a restored state"
    for all_of_it, part in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(all_of_it[37:], part)
    np.testing.assert_allclose(np.linalg.norm(whole[0], axis=2), 1.0, atol=1e-12)


def test_five_sensors_alone_are_those_of_chain5_whose_lengths_nobody_knows():
    block = KortierTracker(magnetometers=False).resolve({"gyr": (5, 3), "acc": (5, 3)})
    assert [(port.name, port.shape) for port in block.outputs] == [
        ("orientation", (5, 4)), ("angles", (6,)), ("angle_sd", (6,)), ("position", (3,)), ("velocity", (3,)),
        ("aligned", (1,)), ("angle_random_sd", (6,))]
    worn = KortierTracker(sensors=5, sensed=("hand", "F2p", "F2m", "F2d", "forearm"))
    assert [port.name for port in worn.outputs[3:5]] == ["fingertips", "fingertip_sd"]


@pytest.mark.parametrize(("wrong", "key"), [
    ({"gyr_sd": 0.0}, "gyr_sd"), ({"lever_m": -1.0}, "lever_m"), ({"still_window": 1}, "still_window"),
    ({"sensors": -1}, "sensors"), ({"sensors": 15}, "sensed"), ({"sensors": 4, "base": "wrist"}, "base"),
    ({"sensors": 2, "sensed": ("hand", "F2p"), "base": "F3p"}, "base"),
    ({"sensors": 16, "initial_angles_deg": {"F2_pip": 10.0}}, "F2_pip_flexion"),
    ({"sensors": 16, "initial_angles_deg": {"F2_pip_flexion": 190.0}}, "-180 to 180")])
def test_impossible_parameters_are_refused(wrong, key):
    given = {"segments": FINGER, **wrong} if wrong.get("sensors") == 4 else wrong
    with pytest.raises(InputError, match=key):
        KortierTracker(**given)

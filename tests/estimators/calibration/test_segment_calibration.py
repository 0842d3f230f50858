"""The block before a tracker: samples of sensors mounted anyhow come out as if they sat on their segments."""

import pickle
from dataclasses import dataclass

import numpy as np
import pytest
from mounted_hand import BENT, NAMES, RATE, flat_then_bent, mounted
from scipy.spatial.transform import Rotation

from estimators.calibration.block import SegmentCalibration, turn_samples
from estimators.calibration.poses import PoseLimits
from estimators.fusion import VqfTracker
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

FLAT_S, BENT_S = 3.0, 4.0
POSES = {"method": "poses", "flat_s": (0.0, FLAT_S), "flexion_s": (FLAT_S, FLAT_S + BENT_S), "sensed": NAMES}
CONTEXT = Context("calibration", clock=RateClock.from_rate(RATE))


def worn(side="right", seed=0):
    """True samples (m, 2, 16, 3) of two poses and back again, the same as mounted sensors feel them."""
    flat, bent = flat_then_bent(side, flat_s=FLAT_S, bent_s=BENT_S)
    gyr = np.concatenate([flat.gyr, bent.gyr, -bent.gyr[::-1]])
    acc = np.concatenate([flat.acc, bent.acc, bent.acc[::-1]])
    turns = Rotation.random(len(NAMES), rng=np.random.default_rng(seed)).as_quat(scalar_first=True)
    felt = mounted(type(flat)(gyr, acc), turns)
    return np.stack([gyr, acc], axis=1), np.stack(felt, axis=1)


def stepped(block, felt, slow=1, state=None, first=0):
    """(outputs (m, 3, n, 3), [(tick, status, detail)], state); accelerometers sample every `slow` ticks."""
    state = block.init(CONTEXT) if state is None else state
    nothing = Sample(np.zeros((block.sensors, 3)), -1, -1, -1)
    tick, seen, told = Tick(), [], []
    for k in range(first, len(felt)):
        now, held = round(k * NS_PER_S / RATE), k - k % slow
        at = round(held * NS_PER_S / RATE)
        tick.index, tick.time_ns = k, now
        samples = [Sample(felt[k, 0], now, now, now), Sample(felt[held, 1], at, at, at), nothing]
        seen.append(np.stack(block.step(state, samples, tick)))
        told += [(k, *report) for report in tick.reports]
        tick.reports.clear()
    return np.array(seen), told, state


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("slow", [1, 2])
def test_after_the_poses_samples_are_those_of_the_segments(side, slow):
    true, felt = worn(side)
    seen, told, _ = stepped(SegmentCalibration(sensors=16, side=side, **POSES), felt, slow)
    end = round((FLAT_S + BENT_S) * RATE)
    assert np.isnan(seen[:end]).all()
    np.testing.assert_allclose(seen[end:, 0], true[end:, 0], atol=1e-6)
    np.testing.assert_allclose(seen[end::slow, 1], true[end::slow, 1], atol=1e-5)
    assert [(k, status) for k, status, _ in told] == [(0, "calibrating"), (end, "calibrated")]
    assert told[1][2].startswith("16 of 16 sensors by poses: axes within 0.0 deg")


def test_held_samples_are_counted_once():
    # Samples that come at half the rate of the block's ticks must give half the count, and the same turn.
    _, felt = worn()
    block = SegmentCalibration(sensors=16, **POSES)
    _, _, state = stepped(block, felt, slow=2)
    assert state.flat.offered == [FLAT_S * RATE, FLAT_S * RATE / 2]
    assert state.flexion.offered == BENT_S * RATE
    np.testing.assert_allclose(state.flexion.reach_deg()[0], np.degrees(1.2), atol=0.5)


def test_a_tracker_behind_it_waits_and_then_reads_the_fingers():
    _, felt = worn("right", seed=4)
    seen, _, _ = stepped(SegmentCalibration(sensors=16, side="right", **POSES), felt)
    tracker = VqfTracker(sensors=3, initial_angles_deg=(np.degrees(BENT),) * 2)
    state, tick = tracker.init(CONTEXT), Tick()
    index = [NAMES.index(name) for name in ("F2p", "F2m", "F2d")]
    statuses, angles, end = [], [], round((FLAT_S + BENT_S) * RATE)
    for k, rows in enumerate(seen):
        tick.index, tick.time_ns = k, round(k * NS_PER_S / RATE)
        samples = [Sample(rows[kind, index].copy(), tick.time_ns, tick.time_ns, tick.time_ns)
                   for kind in range(2)]
        angles.append(tracker.step(state, samples, tick)[1])
        statuses += [(k, status) for status, _ in tick.reports]
        tick.reports.clear()
    assert statuses == [(0, "lost_sample"), (0, "aligning"), (end, "samples_valid")]
    np.testing.assert_allclose(angles[end], BENT, atol=1e-3)
    np.testing.assert_allclose(angles[-1], 0.0, atol=np.radians(2.0))


def test_a_sensor_that_fails_is_named_and_stays_silent_while_the_others_go_on():
    true, felt = worn()
    felt = felt.copy()
    felt[100:120, 0, 4] += 1.0
    felt[:, 1, 9] = np.nan
    seen, told, state = stepped(SegmentCalibration(sensors=16, **POSES), felt)
    failed = [detail for _, status, detail in told if status == "calibration_failed"]
    assert [line.split(":")[0] for line in failed] == [NAMES[4], NAMES[9]]
    assert "moved in the flat pose" in failed[0]
    assert "hold it still" in failed[0]
    assert "lost in the flat pose: 0 sound accelerometer samples of 300" in failed[1]
    end = round((FLAT_S + BENT_S) * RATE)
    assert np.isnan(seen[:, :, [4, 9]]).all()
    others = [i for i in range(16) if i not in (4, 9)]
    np.testing.assert_allclose(seen[end:, 0, others], true[end:, 0, others], atol=1e-6)
    again = SegmentCalibration(sensors=16, **POSES)
    assert again.next_trial(state, CONTEXT) is state


def test_no_sample_in_time_is_a_failure_that_says_so():
    block = SegmentCalibration(sensors=16, **POSES)
    state, tick = block.init(CONTEXT), Tick()
    nothing = Sample(np.zeros((16, 3)), -1, -1, -1)
    tick.time_ns = 8 * NS_PER_S
    block.step(state, [nothing] * 3, tick)
    assert [status for status, _ in tick.reports] == ["calibrating"] + 16 * ["calibration_failed"]
    assert "too short: 0 gyroscope samples" in tick.reports[1][1]


def test_assumed_rotations_turn_at_once_the_magnetometer_too():
    rng = np.random.default_rng(1)
    turns = Rotation.random(3, rng=rng).as_quat(scalar_first=True)
    block = SegmentCalibration(sensors=3, rotations=tuple(map(tuple, turns)))
    kinds, tick = rng.normal(size=(3, 3, 3)), Tick()
    found = block.step(block.init(CONTEXT), [Sample(kind, 0, 0, 0) for kind in kinds], tick)
    for rows, kind in zip(found, kinds, strict=True):
        np.testing.assert_allclose(rows, Rotation.from_quat(turns, scalar_first=True).apply(kind), atol=1e-12)
    assert tick.reports == []
    plain = getattr(turn_samples, "py_func", turn_samples)(turns, np.array([True, False, True]), *kinds)
    np.testing.assert_allclose(plain[2][2], found[2][2], atol=1e-12)
    assert np.isnan(plain[0][1]).all()


def test_a_forearm_keeps_its_stated_rotation_whatever_it_does():
    true, felt = worn()
    felt = felt.copy()
    felt[:, 0, 0] = 0.0
    half_turn = (0.0, 1.0, 0.0, 0.0)
    block = SegmentCalibration(sensors=16, assumed=(0,), rotations=(half_turn,),
                               limits=PoseLimits(placement_deg=181.0), **POSES)
    seen, told, _ = stepped(block, felt)
    assert [status for _, status, _ in told] == ["calibrating", "calibrated"]
    np.testing.assert_allclose(seen[-1, 1, 0], quaternion.rotate(half_turn, felt[-1, 1, 0]))
    np.testing.assert_allclose(seen[-1, 0, 1:], true[-1, 0, 1:], atol=1e-6)


@dataclass(frozen=True, kw_only=True, eq=False)
class Glove:
    """A block that puts out one kind of samples (m, n, 3), one a tick."""

    samples: np.ndarray
    name: str
    unit: str

    inputs = ()

    @property
    def outputs(self):
        return (Port(self.name, self.samples.shape[1:], self.unit),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (self.samples[tick.index],)


@pytest.mark.slow
def test_in_a_loop_with_slower_accelerometers_that_arrive_late():
    true, felt = worn()
    nodes = [Node("gyroscopes", Glove(samples=felt[:, 0], name="gyr", unit="rad/s"), rate=RATE),
             Node("accelerometers", Glove(samples=felt[::2, 1].copy(), name="acc", unit="m/s^2"), rate=50),
             Node("calibration", SegmentCalibration(sensors=16, **POSES), rate=RATE)]
    wires = [Wire(source="gyroscopes.gyr", target="calibration.gyr", latency_ms=10),
             Wire(source="accelerometers.acc", target="calibration.acc", latency_ms=30)]
    recorder = Recorder()
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(8 * NS_PER_S)
    told = [(at, status) for at, name, status, _ in recorder.events]
    assert told == [(0, "calibrating"), (7 * NS_PER_S, "calibrated")]
    last = recorder.blocks["calibration"][-1]
    np.testing.assert_allclose(last[5][0], true[799, 0], atol=1e-6)
    np.testing.assert_allclose(last[5][1], true[796, 1], atol=1e-5)
    assert not np.any(last[5][2])


@pytest.mark.parametrize("at", [50, 299, 300, 500, 700, 720])
def test_stop_save_restore_continue_equals_uninterrupted(at):
    _, felt = worn()
    block = SegmentCalibration(sensors=16, **POSES)
    whole, told, _ = stepped(block, felt)
    first, told_first, state = stepped(block, felt[:at])
    rest, told_rest, _ = stepped(block, felt, state=pickle.loads(pickle.dumps(state)), first=at)
    np.testing.assert_array_equal(np.concatenate([first, rest]), whole)
    assert told_first + told_rest == told


@pytest.mark.parametrize(("parameters", "found"), [
    ({"sensors": -1}, "sensors: -1"), ({"method": "posse"}, "did you mean 'poses'"),
    ({"side": "middle"}, "side: 'middle'"), ({"flat_s": (3.0, 1.0)}, r"flat_s: \(3\.0, 1\.0\)"),
    ({"method": "poses", "flat_s": (0.0, 5.0)}, "flexion_s: begins at 4 s, before flat_s ends"),
    ({"sensors": 2, "assumed": (2,)}, "assumed: 2; allowed: 0 to 1"),
    ({"sensors": 2, "sensed": ("hand",)}, "sensed: names 1 segments, 2 sensors"),
    ({"sensors": 2, "rotations": ((1.0, 0.0, 0.0, 0.0),) * 3}, "rotations: shape"),
    ({"sensors": 2, "verticals": ((0.0, 0.0, 0.0),)}, "verticals"),
])
def test_misuse_is_named(parameters, found):
    with pytest.raises(InputError, match=found):
        SegmentCalibration(**parameters)


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_flat_pose_alone_leaves_nothing_but_a_turn_about_its_vertical(side):
    true, _ = worn(side)
    rng = np.random.default_rng(4)
    turns = Rotation.from_rotvec(np.radians(10.0) * rng.standard_normal((len(NAMES), 3)))
    felt = quaternion.rotate(turns.as_quat(scalar_first=True)[None, None], true)
    block = SegmentCalibration(sensors=16, side=side, method="flat", flat_s=(0.0, FLAT_S), sensed=NAMES)
    seen, told, state = stepped(block, felt)
    end = round(FLAT_S * RATE)
    assert np.isnan(seen[:end]).all()
    assert [(k, status) for k, status, _ in told] == [(0, "calibrating"), (end, "calibrated")]
    up = np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])
    np.testing.assert_allclose(seen[end, 1] / np.linalg.norm(seen[end, 1], axis=1, keepdims=True),
                               np.broadcast_to(up, (16, 3)), atol=0.02)
    # Whatever a sensor's turn is, what is left of it is about the vertical, and no larger.
    left = Rotation.from_quat(state.rotations, scalar_first=True) * turns
    assert np.abs(np.cross(left.as_rotvec(), up)).max() < 1e-4
    assert (left.magnitude() <= turns.magnitude() + 1e-6).all()


def test_a_hand_that_moved_in_the_flat_pose_is_named():
    _, felt = worn()
    felt[100:120, 0, 3] += 1.0
    block = SegmentCalibration(sensors=16, method="flat", flat_s=(0.0, FLAT_S), sensed=NAMES)
    seen, told, _ = stepped(block, felt)
    failed = [detail for _, status, detail in told if status == "calibration_failed"]
    assert len(failed) == 1
    assert NAMES[3] in failed[0]
    assert np.isnan(seen[-1, :, 3]).all()
    assert np.isfinite(np.delete(seen[-1, :2], 3, axis=1)).all()

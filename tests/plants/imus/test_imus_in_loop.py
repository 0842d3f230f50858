"""Hand-worn sensors against MuJoCo's, and in a loop: rates of their own, a drifting clock, gaps, trackers."""

from dataclasses import dataclass, field

import mujoco
import numpy as np
import pytest
from imu_parts import run
from mujoco_trees import mujoco_model

from fesloop.hand import kinematics, motion, quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.hand.skeleton import dorsal_points, hand_tree
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.join import Join
from plants.imus import Imus
from plants.imus.disturbances import MagneticField


@dataclass(frozen=True)
class Waving:
    """A hand whose every joint swings, and whose forearm turns: what its 17 sites feel, by our kinematics."""

    size: HandSize = field(default_factory=HandSize)
    phase: np.ndarray = field(default_factory=lambda: np.random.default_rng(3).uniform(0.0, 6.0, 23))
    grid = None
    feedthrough = False
    inputs = ()
    outputs = (Port("site_orientation", (17, 4)), Port("site_position", (17, 3), "m"),
               Port("site_rate", (17, 3), "rad/s"), Port("site_force", (17, 3), "m/s^2"))

    def joints(self, time):
        middle, half = (ranges @ self.tree.ranges.T for ranges in ([0.5, 0.5], [-0.35, 0.35]))
        angle = 5.0 * time + self.phase
        return middle + half * np.sin(angle), 5.0 * half * np.cos(angle), -25.0 * half * np.sin(angle)

    def forearm(self, time):
        """Orientation, rate, angular acceleration in its own frame, position, velocity, acceleration."""
        axis, swing = np.array([0.6, 0.0, 0.8]), 0.8 * np.sin(3.0 * time)
        place = 0.1 * np.array([np.sin(4.0 * time), np.cos(2.0 * time), 0.0])
        speed = 0.1 * np.array([4.0 * np.cos(4.0 * time), -2.0 * np.sin(2.0 * time), 0.0])
        force = 0.1 * np.array([-16.0 * np.sin(4.0 * time), -4.0 * np.cos(2.0 * time), 0.0])
        return (quaternion.from_axis_angle(axis, swing), 2.4 * np.cos(3.0 * time) * axis,
                -7.2 * np.sin(3.0 * time) * axis, place, speed, force)

    @property
    def tree(self):
        return hand_tree(self.size)

    def sites(self, time):
        tree, points = self.tree, dorsal_points(self.size)
        orientation, rate, change, place, _, acceleration = self.forearm(time)
        poses = kinematics.segment_poses(tree, self.joints(time)[0], Poses(orientation, place))
        samples = motion.sensed(tree, motion.sensor_points(tree, tree.names, points), *self.joints(time),
                                motion.root_motion(orientation, rate, change, acceleration))
        position = poses.position + quaternion.rotate(poses.orientation, points)
        return poses.orientation, position, samples.gyr, samples.acc

    def init(self, context):
        return [0]

    def advance(self, state, inputs, start_ns, stop_ns):
        state[0] = stop_ns

    def read(self, state, inputs):
        return self.sites(state[0] / NS_PER_S)


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
def test_samples_equal_mujocos_sensors_on_a_moving_hand(side):
    hand = Waving(HandSize(side=side))
    tree = hand.tree
    model = mujoco_model(tree, motion.sensor_points(tree, tree.names, dorsal_points(hand.size)))
    record = mujoco.MjData(model)
    samples, _ = run(Imus(preset="ideal", sites=tree.names), lambda _, time: hand.sites(time), 60)
    for k in range(60):
        angles, rates, accelerations = hand.joints(0.01 * k)
        orientation, turning, turning_up, place, speed, linear = hand.forearm(0.01 * k)
        record.qpos[:] = np.concatenate([place, orientation, angles])
        record.qvel[:] = np.concatenate([speed, turning, rates])
        record.qacc[:] = np.concatenate([linear, turning_up, accelerations])
        mujoco.mj_inverse(model, record)
        expected = record.sensordata.reshape(-1, 2, 3)
        np.testing.assert_allclose(samples["gyr"][k], expected[:, 0], rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(samples["acc"][k], expected[:, 1], rtol=0.0, atol=1e-8)
        frames = np.array([record.site(f"imu{i}").xmat.reshape(3, 3) for i in range(17)])
        field_there = np.einsum("nij,i->nj", frames, MagneticField().earth)
        np.testing.assert_allclose(samples["mag"][k], field_there, rtol=0.0, atol=1e-14)


def wired(nodes, wires, sensors, duration_ms=400, seed=1):
    """Recorder of a loop in which every block of `sensors` is fed by the waving hand."""
    ports = [port.name for port in Waving.outputs]
    fed = [Wire(f"hand.{port}", f"{name}.{port}") for name in sensors for port in ports]
    recorder = Recorder(plant_rate=None)
    loop = Loop(Wiring([Node("hand", Waving()), *nodes], [*fed, *wires], seed=seed), recorder=recorder)
    loop.run_until(duration_ms * NS_PER_MS)
    return recorder


def column(recorder, name, port):
    return np.array([row[5][port] for row in recorder.blocks[name]])


@pytest.mark.slow
def test_gyroscopes_at_200_and_the_rest_at_100_hz_of_one_device():
    mounted = {"device": "glove", "preset": "ideal", "mounting_sd_deg": 5.0}
    nodes = [Node("gyr", Imus(measures=("gyr",), **mounted), rate="200"),
             Node("rest", Imus(measures=("acc", "mag"), **mounted), rate="100"),
             Node("all", Imus(**mounted), rate="100")]
    recorder = wired(nodes, [], ["gyr", "rest", "all"])
    assert [len(recorder.blocks[name]) for name in ("gyr", "rest", "all")] == [81, 41, 41]
    np.testing.assert_array_equal(column(recorder, "gyr", 0)[::2], column(recorder, "all", 0))
    np.testing.assert_array_equal(column(recorder, "rest", 0), column(recorder, "all", 1))


@pytest.mark.slow
def test_a_clock_that_is_late_and_drifts_is_the_nodes_offset_and_rate():
    """2000 ppm fast, 3 ms late: each sample is of the instant that its stamp says."""
    imus = Imus(preset="ideal", measures=("gyr",), sites=("hand",))
    recorder = wired([Node("imus", imus, rate="100.2", offset_ms=3.0)], [], ["imus"])
    clock, hand = RateClock.from_rate("100.2", 3 * NS_PER_MS), Waving()
    for index, time, _, oldest, newest, (gyr,) in recorder.blocks["imus"]:
        assert time == oldest == newest == clock.tick(index)
        np.testing.assert_array_equal(gyr[0], hand.sites(time / NS_PER_S)[2][1])


@pytest.mark.slow
def test_the_forearm_joins_the_strips_over_its_own_wire():
    rates = {"preset": "ideal", "measures": ("gyr",)}
    nodes = [Node("strips", Imus(**rates, sites=hand_tree(HandSize()).names[1:]), rate="100"),
             Node("forearm", Imus(**rates, sites=("forearm",)), rate="100"),
             Node("join", Join(unit="rad/s"), rate="100")]
    wires = [Wire("strips.gyr", "join.first"),
             Wire("forearm.gyr", "join.second", latency_ms=10.0, loss=0.1)]
    recorder, hand = wired(nodes, wires, ["strips", "forearm"]), Waving()
    ages = []
    for _, _, _, oldest, newest, (gyr,) in recorder.blocks["join"][2:]:
        np.testing.assert_array_equal(gyr[:16], hand.sites(newest / NS_PER_S)[2][1:])
        np.testing.assert_array_equal(gyr[16], hand.sites(oldest / NS_PER_S)[2][0])
        ages.append((newest - oldest) / NS_PER_MS)
    assert min(ages) == 10.0
    assert set(ages) <= {10.0, 20.0, 30.0, 40.0}
    assert 1 <= ages.count(20.0) <= 10


def test_a_lost_sample_is_one_sensors_and_trackers_are_told_of_that_one():
    from estimators.fusion import VqfTracker

    imus = Imus(preset="ideal", measures=("gyr", "acc"), sites=("hand", "F2p", "F2m", "F2d"), loss=0.05)
    nodes = [Node("imus", imus, rate="100"), Node("tracker", VqfTracker(), rate="100")]
    wires = [Wire(f"imus.{kind}", f"tracker.{kind}") for kind in ("gyr", "acc")]
    recorder = wired(nodes, wires, ["imus"])
    lost = np.isnan(column(recorder, "imus", 0)[:, :, 0])
    assert 0 < lost.sum() < 20
    told = {time: detail for time, name, status, detail in recorder.events if status == "lost_sample"}
    begun = [k for k in range(41) if lost[k].any() and (k == 0 or (lost[k] != lost[k - 1]).any())]
    names = {k: ", ".join(imus.sites[i] for i in np.flatnonzero(lost[k])) for k in begun}
    assert {time: detail.replace("sensor ", "") for time, detail in told.items()} == {
        10 * k * NS_PER_MS: f"gyr of {names[k]}; acc of {names[k]}" for k in begun}
    assert not [event for event in recorder.events if event[2] == "non_finite"]


def test_the_kortier_tracker_reads_the_magnetometers_that_its_hardware_has_and_no_other():
    from estimators.kortier import KortierTracker

    quiet = {"mounting_sd_deg": 0.0, "device": "glove"}
    outputs = []
    for every in (None, tuple(hand_tree(HandSize()).names)):
        imus = Imus(preset="kortier2014", mag_sites=every, **quiet)
        nodes = [Node("imus", imus, rate="100"), Node("tracker", KortierTracker(), rate="100")]
        wires = [Wire(f"imus.{kind}", f"tracker.{kind}") for kind in ("gyr", "acc", "mag")]
        recorder = wired(nodes, wires, ["imus"], duration_ms=200)
        outputs.append(column(recorder, "tracker", 1))
        missing = np.isnan(column(recorder, "imus", 2)).all(axis=(0, 2))
        assert missing.sum() == (10 if every is None else 0)
        assert not [event for event in recorder.events if event[2] in ("lost_sample", "non_finite")]
    np.testing.assert_array_equal(*outputs)
    assert np.abs(outputs[0]).max() > 0.1

"""One contract for every tracker of a hand: whatever becomes of its samples is flagged and in the sd.

A hand of 17 sensors rests, then moves for some seconds; from FAULT on something is wrong.
"""

import functools
import math
import pickle
from importlib.metadata import entry_points
from typing import NamedTuple

import numpy as np
import pytest
from hand_parts import moving_hand

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

RATE, FAULT, COUNT = 100, 250, 450
"""Hz; tick of the fault; ticks."""
TREE = hand_tree(HandSize())
SENSOR = TREE.names.index("F2m")
TOUCHED = [TREE.freedoms.index(f"F2_{joint}_flexion") for joint in ("pip", "dip")]
SPARED = [k for k, name in enumerate(TREE.freedoms) if not name.startswith("F2_")]
POSE = {"initial_pose_s": 1.0}
KINDS = {"constrained": {}, "kortier": {}, "salchow_b": {}, "salchow_m1": POSE, "salchow_m2": POSE}


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


def made(kind, **parameters):
    (entry,) = (e for e in entry_points(group="fesloop.blocks") if e.name == kind)
    return entry.load()(**{**KINDS[kind], **parameters})


@functools.cache
def motion(names=TREE.names, tree=TREE):
    """(gyr, acc, mag) of a hand with noise and biases, so that no two samples are equal."""
    hand = moving_hand(tree, RATE, COUNT / RATE, 3, still_s=1.2, names=names,
                       base=quaternion.from_axis_angle([0.0, 1.0, 0.0], 1.2))
    rng = np.random.default_rng(1)
    sds = (0.005, 0.04, 2e-7)
    return tuple(part + sd * rng.standard_normal(part.shape) for part, sd in
                 zip((hand.gyr, hand.acc, hand.mag), sds, strict=True))


class Run(NamedTuple):
    """Outputs by port, a row a tick; (tick, status, detail) of all reports."""

    outputs: dict
    reports: list

    def told(self, status, since=FAULT):
        """All details of a status from a tick on."""
        return "; ".join(detail for k, name, detail in self.reports if name == status and k >= since)

    @property
    def sd(self):
        return self.outputs["angle_sd"]


def run(block, kinds, stamps=None, save_at=None):
    """Step a tracker over samples; `stamps` (kinds, ticks): the ticks at which they were captured."""
    clock, ports, reports = RateClock.from_rate(RATE), [], []
    state = block.init(Context("tracker", clock=clock))
    kinds = kinds[:len(block.inputs)]
    for k in range(len(kinds[0])):
        tick = Tick()
        tick.index, tick.time_ns = k, clock.tick(k)
        if k == save_at:
            state = pickle.loads(pickle.dumps(state))
        captured = [clock.tick(int(row[k])) if stamps is not None else tick.time_ns
                    for row in (stamps if stamps is not None else kinds)]
        samples = [Sample(rows[k], at, at, at) for rows, at in zip(kinds, captured, strict=False)]
        values = block.step(state, samples, tick)
        assert all(np.isfinite(value).all() for value in values)
        ports.append(values)
        reports.extend((k, *report) for report in tick.reports)
    named = zip((port.name for port in block.outputs), zip(*ports, strict=True), strict=True)
    return Run({name: np.array(rows) for name, rows in named}, reports)


@functools.cache
def sound_run(kind):
    return run(made(kind, sensors=17), motion())


def spoilt(change, kinds=(0, 1, 2), sensor=SENSOR, since=FAULT, until=COUNT):
    """The motion's samples with `change(rows, kind)` in place of a sensor's rows in a span."""
    parts = [part.copy() for part in motion()]
    for kind in kinds:
        rows = parts[kind][since:until, sensor]
        parts[kind][since:until, sensor] = change(rows, kind)
    return parts


def lost(rows, kind):
    return np.full_like(rows, np.nan)


def freedoms_of(*starts):
    return [k for k, name in enumerate(TREE.freedoms) if name.startswith(starts)]


@pytest.mark.slow
def test_sound_samples_are_not_flagged(kind):
    done = sound_run(kind)
    assert {port.name: port.shape for port in made(kind, sensors=17).outputs} == {
        name: rows.shape[1:] for name, rows in done.outputs.items()}
    assert {name: rows.shape[1:] for name, rows in done.outputs.items()}.items() >= {
        "orientation": (17, 4), "angles": (23,), "angle_sd": (23,), "fingertips": (5, 3),
        "fingertip_sd": (5, 3)}.items()
    assert {status for _, status, _ in done.reports} <= {"aligning", "aligned", "uncertain", "certain"}
    assert (done.sd[-1] < 0.5 * math.pi).all()
    assert (done.sd > 0.0).all()


def test_without_the_forearm_the_wrist_is_unseen(kind):
    done = run(made(kind, sensors=16), motion(TREE.names[1:]))
    assert "wrist" in done.told("untracked", 0)
    wrist = freedoms_of("wrist")
    assert (done.sd[:, wrist] == math.pi).all()
    assert not done.outputs["angles"][:, wrist].any()
    assert (np.delete(done.sd[-1], wrist) < 0.5 * math.pi).all()


def test_a_strip_left_off_is_unseen(kind):
    names = tuple(name for name in TREE.names if not name.startswith("F3"))
    done = run(made(kind, sensors=14, sensed=names), motion(names))
    off = freedoms_of("F3")
    assert all(joint in done.told("untracked", 0) for joint in ("F3_mcp", "F3_pip", "F3_dip"))
    assert (done.sd[:, off] == math.pi).all()
    assert not done.outputs["angles"][:, off].any()
    assert (np.delete(done.sd[-1], off) < 0.5 * math.pi).all()
    assert (done.outputs["fingertip_sd"][-1, 2] > 3.0 * done.outputs["fingertip_sd"][-1, 1]).any()


def test_another_tree(kind):
    arm = (Segment(name="upper"),
           Segment(name="lower", parent="upper", joint="saddle", joint_name="elbow", offset=(0.0, -0.3, 0.0),
                   ranges=((-0.2, 2.5), (-0.5, 0.5))),
           Segment(name="palm", parent="lower", joint="hinge", offset=(0.0, -0.1, 0.0),
                   ranges=((-1.0, 1.0),)))
    done = run(made(kind, sensors=3, segments=arm),
               motion(("upper", "lower", "palm"), SegmentTree(arm)))
    assert done.outputs["angles"].shape == (COUNT, 3)
    assert done.outputs["fingertips"].shape == (COUNT, 1, 3)
    assert {status for _, status, _ in done.reports} <= {"aligning", "aligned", "uncertain", "certain"}


@pytest.mark.parametrize("kinds", [(0,), (0, 1, 2)])
def test_samples_lost_for_a_second(kind, kinds):
    until = FAULT + RATE
    done, sound = run(made(kind, sensors=17), spoilt(lost, kinds, until=until)), sound_run(kind)
    assert f"sensor {TREE.names[SENSOR]}" in done.told("lost_sample")
    assert "F2_pip" in done.told("untracked") or (done.sd[until - 1, TOUCHED] > 1.0).all()
    assert (done.sd[until - 1, TOUCHED] > 2.0 * sound.sd[until - 1, TOUCHED]).all()
    assert (done.sd[until - 1, SPARED] < 1.3 * sound.sd[until - 1, SPARED]).all()
    assert done.told("samples_valid", until)
    assert (done.sd[-1, TOUCHED] >= sound.sd[-1, TOUCHED]).all()


def test_samples_lost_for_ever(kind):
    done = run(made(kind, sensors=17), spoilt(lost))
    assert all(joint in done.told("untracked") for joint in ("F2_pip", "F2_dip"))
    assert (done.sd[-1, TOUCHED] == math.pi).all()
    assert not done.outputs["angles"][-1, TOUCHED].any()
    assert (done.outputs["fingertip_sd"][-1, 1] > 3.0 * sound_run(kind).outputs["fingertip_sd"][-1, 1]).any()
    straight = segment_poses(TREE, done.outputs["angles"][-1]).position[TREE.names.index("F2d")]
    np.testing.assert_allclose(done.outputs["fingertips"][-1, 1], straight, atol=0.015)
    assert not done.told("samples_valid")
    assert (done.sd[-1, SPARED] < 0.5 * math.pi).all()


def test_a_sensor_that_never_gives_a_sample(kind):
    done = run(made(kind, sensors=17), spoilt(lost, since=0))
    assert f"sensor {TREE.names[SENSOR]}" in done.told("lost_sample", 0)
    assert all(joint in done.told("untracked", 0) for joint in ("F2_pip", "F2_dip"))
    assert (done.sd[200:, TOUCHED] == math.pi).all()
    assert not done.outputs["angles"][200:, TOUCHED].any()


@pytest.mark.parametrize("part", [1, 2])
def test_an_accelerometer_or_magnetometer_lost_for_ever(kind, part):
    block = made(kind, sensors=17)
    tip = TREE.names.index("F2d")  # kortier reads the magnetometers of bases and tips only
    if part >= len(block.inputs):
        pytest.skip("no magnetometers")
    done, sound = run(block, spoilt(lost, (part,), sensor=tip)), sound_run(kind)
    assert "sensor F2d" in done.told("lost_sample")
    assert (done.sd[-1, TOUCHED[1]] > sound.sd[-1, TOUCHED[1]]).all()


@pytest.mark.parametrize("how", ["nan", "held"])
def test_all_samples_lost_for_half_a_second(kind, how):
    until, sound = FAULT + RATE // 2, sound_run(kind)
    block = made(kind, sensors=17)
    if how == "nan":
        parts = [part.copy() for part in motion()]
        for part in parts:
            part[FAULT:until] = np.nan
        done = run(block, parts)
        assert f"sensor {TREE.names[0]}" in done.told("lost_sample")
    else:
        at = np.arange(COUNT)
        at[FAULT:until] = FAULT - 1
        done = run(block, [part[at] for part in motion()], np.tile(at, (3, 1)))
        assert done.told("repeated_sample")
    assert (done.sd[until - 1] > 1.25 * sound.sd[until - 1]).all()
    assert done.told("samples_valid", until)


def test_clipped_gyroscopes(kind):
    until, sound = FAULT + 20, sound_run(kind)
    done = run(made(kind, sensors=17),
               spoilt(lambda rows, kind: np.radians([0.0, 0.0, 2000.0]), (0,), until=until))
    assert f"sensor {TREE.names[SENSOR]}" in done.told("clipped_sample")
    assert (done.sd[until - 1, TOUCHED] > 1.2 * sound.sd[until - 1, TOUCHED]).all()
    assert done.told("samples_valid", until)


def test_accelerometers_at_the_end_of_their_range(kind):
    done = run(made(kind, sensors=17),
               spoilt(lambda rows, kind: [0.0, -16.0 * STANDARD_GRAVITY, 0.0], (1,), until=FAULT + 5))
    assert f"sensor {TREE.names[SENSOR]}" in done.told("clipped_sample")


@pytest.mark.parametrize("stamped", ["when taken", "with the gyroscopes"])
def test_accelerometers_and_magnetometers_at_half_the_rate(kind, stamped):
    every = {"acc_every": 2} if kind.startswith("salchow") else {}
    if kind in ("salchow_b", "salchow_m1"):
        every["mag_every"] = 2
    at = np.arange(COUNT)
    slow = at - at % 2
    gyr, acc, mag = motion()
    stamps = np.array([at, slow, slow]) if stamped == "when taken" else None
    done, sound = run(made(kind, sensors=17, **every), (gyr, acc[slow], mag[slow]), stamps), sound_run(kind)
    assert {status for _, status, _ in done.reports} <= {"aligning", "aligned", "uncertain", "certain"}
    off = done.outputs["angles"][-1] - sound.outputs["angles"][-1]
    assert np.sqrt(np.mean(off ** 2)) < math.radians(3.0)


def test_a_frozen_sensor(kind):
    last = [part[FAULT - 1, SENSOR] for part in motion()]
    done, sound = run(made(kind, sensors=17), spoilt(lambda rows, kind: last[kind])), sound_run(kind)
    assert f"sensor {TREE.names[SENSOR]}" in done.told("frozen_sample")
    assert (done.sd[-1, TOUCHED] > 2.0 * sound.sd[-1, TOUCHED]).all()
    assert (done.sd[-1, SPARED] < 1.3 * sound.sd[-1, SPARED]).all()


def test_a_sensor_that_freezes_at_rest_is_told_of(kind):
    first = [part[150, SENSOR] * (0.0, 1.0, 1.0)[k] + (0.01, 0.0, 0.0)[k] for k, part in enumerate(motion())]
    done = run(made(kind, sensors=17), spoilt(lambda rows, kind: first[kind], since=150, until=200))
    assert f"sensor {TREE.names[SENSOR]}" in done.told("frozen_sample", 150)
    assert not done.told("lost_sample", 150)
    assert done.told("samples_valid", 200)


def test_a_snapshot_in_mid_fault_continues_to_the_last_bit(kind):
    parts = spoilt(lost, until=FAULT + 30)
    whole, saved = (run(made(kind, sensors=17), parts, save_at=at) for at in (None, FAULT + 10))
    assert whole.reports == saved.reports
    for name, rows in whole.outputs.items():
        np.testing.assert_array_equal(rows, saved.outputs[name])


class Source:
    """Sends so many rows."""

    inputs = ()

    def __init__(self, rows, unit):
        self.outputs = (Port("y", (rows, 3), unit),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.ones(self.outputs[0].shape),)


def wired(kind, rows):
    block = made(kind)
    sources = [Node(port.name, Source(count, port.unit), rate=RATE)
               for port, count in zip(block.inputs, rows, strict=False)]
    wires = [Wire(f"{node.name}.y", f"tracker.{node.name}") for node in sources]
    return Wiring([*sources, Node("tracker", block, rate=RATE)], wires)


def test_streams_of_unequal_length_and_of_no_body_are_refused(kind):
    with pytest.raises(InputError, match=r"acc.*16, 3.*17, 3"):
        wired(kind, (17, 16, 17))
    with pytest.raises(InputError, match=r"sensed.*9 sensors are wired"):
        wired(kind, (9, 9, 9))
    Loop(wired(kind, (17, 17, 17))).run_until(0)


@pytest.mark.parametrize(("wrong", "words"), [
    ({"sensed": ("hand", "F2q")}, "F2q"),
    ({"sensed": ("hand", "hand")}, "'hand' given twice"),
    ({"sensed": ("hand", "F2p", "F2m")}, "names 3 segments, 2 sensors"),
    ({"sensors": -1}, "sensors: -1"),
])
def test_unknown_segments_are_refused(kind, wrong, words):
    with pytest.raises(InputError, match=words):
        made(kind, **{"sensors": 2, **wrong})


@pytest.mark.parametrize(("wrong", "words"), [
    ({"hand_mm": -190.0}, "hand_mm"), ({"hand_mm": math.nan}, "hand_mm"),
    ({"segments_mm": ((45.0, 30.0, 20.0),) * 4 + ((30.0, -20.0, 15.0),)}, "segments_mm"),
    ({"fingers_mm": (90.0, 90.0, 1000.0, 90.0, 80.0)}, "fingers_mm"),
])
def test_lengths_that_no_hand_has_are_refused(kind, wrong, words):
    with pytest.raises(InputError, match=words):
        made(kind, sensors=17, hand=HandSize(**wrong))

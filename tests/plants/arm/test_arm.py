"""Tests of the arm in a device against an ODE solver, sampled play, and statics."""

import itertools
import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fesloop.analysis.people.identify import save
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS
from fesloop.models.arm_people import ArmPeople
from fesloop.models.dry_friction import play
from fesloop.models.evoked_torque import Postures, features
from plants.arm import Arm

TWO = {"electrodes": ("biceps", "flexor carpi radialis"), "delay_ms": 40.0, "activation_rad_s": 20.0,
       "threshold_ma": (10.0, 5.0), "spread": (0.2, 0.15), "chronaxie_us": (100.0, 150.0),
       "highest": (0.7, 0.7), "hidden_nm": (0.0,) * 4}
REFERENCE = np.deg2rad([45.0, 0.0, 0.0, 0.0])


def pulses(*rows):
    """Pulses (electrodes, 3) of currents, mA, and widths, us, at 40 Hz."""
    return np.array([[1e-3 * current, 1e-6 * width, 40.0] for current, width in rows])


def course(arm, trains, end_ms, every_ms, reference=REFERENCE):
    """Outputs every so often; `trains` are (first ms, last ms, electrode, current, width), 40 Hz."""
    changes = {}
    for first, last, electrode, current, width in trains:
        for at in np.arange(first, last, 25.0):
            changes.setdefault(round(at * NS_PER_MS), []).append((electrode, current, width))
    state, now = arm.init(Context("arm")), 0
    silent = np.zeros((len(arm.electrodes), 3))
    inputs, seen = [silent, reference], []
    reads = [round(k * every_ms * NS_PER_MS) for k in range(1, round(end_ms / every_ms) + 1)]
    for instant in sorted({*changes, *(at + NS_PER_MS for at in changes), *reads}):
        if instant > now:
            arm.advance(state, inputs, now, instant)
            now = instant
        if instant in reads:
            seen.append(arm.read(state, inputs))
        if instant in changes:
            given_now = silent.copy()
            for electrode, current, width in changes[instant]:
                given_now[electrode] = 1e-3 * current, 1e-6 * width, 40.0
            inputs = [given_now, reference]
        elif instant - NS_PER_MS in changes:
            inputs = [silent, reference]
    return [np.array(column) for column in zip(*seen, strict=True)]


def test_activation_and_torque_are_those_of_an_ode_solver_and_a_sampled_play():
    arm = Arm(**TWO, friction_nm=(0.2, 0.02, 0.02, 0.01))
    trains = [(100.0, 600.0, 0, 60.0, 25.0), (300.0, 800.0, 1, 40.0, 22.0), (900.0, 1000.0, 0, 60.0, 30.0)]
    evoked, device, angles, activation = course(arm, trains, 2000.0, 1.0)
    times = np.arange(1, 2001) * 1e-3

    def drive(t):
        return [sum(float(arm.recruited(*pulses(*[(current, width)] * 2)[:, :2].T)[electrode])
                    for first, last, electrode, current, width in trains
                    if e == electrode and first <= 1e3 * t - 40.0 < last) for e in range(2)]

    found, expected = np.zeros(4), []
    edges = sorted({0.0, 2.0, *((1e-3 * (40.0 + edge)) for each in trains for edge in each[:2])})
    for start, end in itertools.pairwise(edges):
        level = np.array(drive(0.5 * (start + end)))
        inside = times[(times > start + 1e-9) & (times <= end + 1e-9)]
        solved = solve_ivp(lambda t, y, level=level: np.concatenate(
            [20.0 * (level - y[:2]), 20.0 * (y[:2] - y[2:])]), (start, end), found, dense_output=True,
            rtol=1e-10, atol=1e-12)
        expected.append(solved.sol(inside)[2:].T)
        found = solved.y[:, -1]
    np.testing.assert_allclose(activation, np.concatenate(expected), atol=1e-8)
    np.testing.assert_allclose(evoked, activation @ arm.torque_nm(REFERENCE), atol=1e-12)
    # A play sampled every ms misses at most what a torque turns within 1 ms.
    sampled = play(evoked, np.array(arm.friction_nm), np.zeros(4))
    np.testing.assert_allclose(-device, sampled, atol=1e-4)
    assert np.abs(sampled).max() > 0.4
    stiffness = np.array(arm.stiffness_nm_rad)
    np.testing.assert_allclose(stiffness * angles + device, np.tile(stiffness * REFERENCE, (2000, 1)),
                               atol=1e-12)


def test_play_turns_at_extrema_between_observations():
    """A pulse of torque that is over before anyone looks leaves its mark on a joint with friction."""
    arm = Arm(**TWO, friction_nm=(0.05, 0.01, 0.003, 0.01))
    trains = [(0.0, 25.0, 0, 65.0, 60.0), (0.0, 25.0, 1, 45.0, 60.0)]
    peak = np.abs(course(arm, trains, 1000.0, 0.1)[0]).max(axis=0)
    assert (peak > 2.5 * np.array(arm.friction_nm))[[0, 2]].all()
    left = -course(arm, trains, 1000.0, 1000.0)[1][0]
    # It rose to peak - friction, and what is left of it is friction's.
    np.testing.assert_allclose(np.abs(left)[[0, 2]], np.array(arm.friction_nm)[[0, 2]], atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(0.1, 700.0), min_size=1, max_size=6))
def test_outputs_do_not_depend_on_who_looks(looks):
    arm = Arm(**TWO)
    inputs = [pulses((60.0, 30.0), (40.0, 25.0)), REFERENCE]
    plain, looked = arm.init(Context("arm")), arm.init(Context("arm"))
    stop, now = 701 * NS_PER_MS, 0
    arm.advance(plain, inputs, 0, stop)
    for look in sorted(looks):
        arm.advance(looked, inputs, now, round(look * NS_PER_MS))
        now = round(look * NS_PER_MS)
        arm.read(looked, inputs)
    arm.advance(looked, inputs, now, stop)
    for one, other in zip(arm.read(plain, inputs), arm.read(looked, inputs), strict=True):
        assert np.array_equal(one, other)
    assert pickle.loads(pickle.dumps(plain)).passed.tolist() == plain.passed.tolist()


def test_a_pulse_acts_for_one_period():
    arm = Arm(**TWO)
    *_, activation = course(arm, [(0.0, 1000.0, 0, 60.0, 25.0)], 1500.0, 500.0)
    recruited = arm.recruited(np.array([0.06, 0.04]), np.array([25e-6, 0.0]))
    assert activation[1, 0] == pytest.approx(recruited[0], rel=1e-6)
    assert activation[2, 0] < 2e-3  # 460 ms after the last pulse's period
    assert recruited[1] == 0.0


def test_recruitment_is_half_at_the_threshold_by_strength_and_duration():
    arm = Arm(**TWO)
    widths = np.array([30e-6, 300e-6])
    currents = 1e-3 * np.array([10.0, 5.0]) * (1.0 + np.array([100e-6, 150e-6]) / widths)
    np.testing.assert_allclose(arm.recruited(currents, widths), 0.5)
    np.testing.assert_allclose(arm.recruited(currents * np.exp([0.2, 0.15]), widths), 0.8413447, rtol=1e-6)
    assert (arm.recruited(-currents, widths) == 0.0).all()


def test_torque_at_the_highest_width_is_the_persons():
    person = ArmPeople.shipped().stranger()
    arm = Arm(electrodes=("extensor carpi radialis longus",), hidden_nm=(0.0,) * 4)
    angles = np.deg2rad([60.0, 40.0, 10.0, -10.0])
    rows = features(Postures.of(arm.electrodes[0], angles[np.newaxis]), person.scale_nm, person.spreads)[0]
    torque = rows @ person.weights[arm.electrodes[0]].mean
    np.testing.assert_allclose(arm.response.highest[0] * arm.torque_nm(angles)[0], torque)
    # Friction of the device that read this hid itself of a large torque, and half of a small one.
    hidden = Arm(electrodes=arm.electrodes, hidden_nm=(1e-9, 1e-9, 1e-9, 1e3)).torque_nm(angles)[0]
    np.testing.assert_allclose(arm.response.highest[0] * hidden[:3], torque[:3] + 1e-9 * np.sign(torque[:3]),
                               rtol=1e-12)
    assert arm.response.highest[0] * hidden[3] == pytest.approx(2.0 * torque[3], rel=1e-6)


def test_a_device_that_moves_a_passive_arm_reads_its_friction():
    arm = Arm(**TWO)
    state = arm.init(Context("arm"))
    silent, away = np.zeros((2, 3)), REFERENCE + np.deg2rad([20.0, -10.0, 5.0, -5.0])
    arm.advance(state, [silent, REFERENCE], 0, NS_PER_MS)
    arm.advance(state, [silent, away], NS_PER_MS, 2 * NS_PER_MS)
    _, device, angles, _ = arm.read(state, [silent, away])
    np.testing.assert_allclose(device, np.array(arm.friction_nm) * [1, -1, 1, -1], rtol=1e-9)
    np.testing.assert_allclose(angles, away - device / np.array(arm.stiffness_nm_rad))


def test_a_jump_of_the_reference_counts_although_the_torque_falls_after_it():
    arm = Arm(**TWO, friction_nm=(0.8, 0.1, 0.1, 0.1))
    state, silent = arm.init(Context("arm")), np.zeros((2, 3))
    away, stop = REFERENCE + np.deg2rad([10.0, 0.0, 0.0, 0.0]), 560 * NS_PER_MS
    pulse = pulses((60.0, 25.0), (0.0, 0.0))
    for at in range(0, 500, 25):
        arm.advance(state, [pulse, REFERENCE], at * NS_PER_MS, (at + 1) * NS_PER_MS)
        arm.advance(state, [silent, REFERENCE], (at + 1) * NS_PER_MS, (at + 25) * NS_PER_MS)
    arm.advance(state, [silent, REFERENCE], 500 * NS_PER_MS, stop)  # the last pulse has ended at 540 ms
    arm.advance(state, [silent, away], stop, stop)
    evoked, device, _, _ = arm.read(state, [silent, away])
    arm.advance(state, [silent, away], stop, 2 * stop)
    later, held, _, _ = arm.read(state, [silent, away])
    assert 0.1 < evoked[0] - later[0] < 1.6
    # The joint followed to the edge of friction at the jump, and the falling torque leaves it there.
    assert device[0] == pytest.approx(0.8 - evoked[0], abs=1e-9)
    assert held[0] == pytest.approx(device[0], abs=1e-9)


def test_members_are_other_people_each_always_the_same():
    assert np.array_equal(Arm(member=3).torque_nm(REFERENCE), Arm(member=3).torque_nm(REFERENCE))
    assert not np.allclose(Arm(member=3).torque_nm(REFERENCE), Arm(member=4).torque_nm(REFERENCE))
    assert Arm(member=3).response.delay_s != Arm(member=4).response.delay_s
    assert len({Arm(member=k).response.frequency_rad_s for k in range(20)}) == 20


def test_a_persons_file_is_that_person(tmp_path):
    person = ArmPeople.shipped().stranger(np.random.default_rng(5))
    save(person, tmp_path / "p.json")
    path = tmp_path / "p.json"
    experiment = load("arm_bench", [f'person={{file = "{path}"}}', "blocks.arm.hidden_nm=[0,0,0,0]"])
    (arm,) = (node.part for node in experiment.wiring.nodes if node.name == "arm")
    mean = person.torque("biceps", REFERENCE[np.newaxis])[0][0]
    np.testing.assert_allclose(arm.torque_nm(REFERENCE)[0] * arm.response.highest[0], mean, rtol=1e-4)


@pytest.mark.parametrize(("change", "said"), [
    ({"format": "fesloop person 0"}, "is not a person's file"),
    ({"scale_nm": [1.0]}, "has weights without spreads or scale_nm"),
    ({"weights": {"biceps": {"mean": [1.0], "lower": [1.0]}}}, r"person.weights.biceps .*: 1 numbers"),
    ({"weights": {"bicep": {"mean": [1.0], "lower": [1.0]}}}, "'bicep'"),
    ({"weights": {"biceps": {"mean": [1.0], "lower": []}}}, r"lower .*: 0 numbers"),
])
def test_refuses_a_spoilt_persons_file(tmp_path, change, said):
    path = tmp_path / "p.json"
    save(ArmPeople.shipped().stranger(), path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(InputError, match=said):
        load("arm_bench", [f'person={{file = "{path}"}}'])


@pytest.mark.parametrize(("given_parameters", "said"), [
    ({"electrodes": ("bicep",)}, "arm.electrodes: 'bicep'"),
    ({"electrodes": ()}, "arm.electrodes: none"),
    ({"electrodes": ("biceps", "biceps")}, "each once"),
    ({"friction_nm": (-0.1, 0, 0, 0)}, "arm.friction_nm"),
    ({"stiffness_nm_rad": (0.0, 1, 1, 1)}, "arm.stiffness_nm_rad"),
    ({"posture_deg": (0.0, 1.0)}, "arm.posture_deg: shape"),
    ({"threshold_ma": (1.0,)}, "arm.threshold_ma: shape"),
    ({"highest": (1.5,) * 8}, "arm.highest"),
    ({"delay_ms": -1.0}, "arm.delay_ms"),
    ({"activation_rad_s": float("nan")}, "arm.activation_rad_s"),
    ({"member": -1}, "arm.member: -1"),
])
def test_refuses_with_the_parameters_name(given_parameters, said):
    with pytest.raises(InputError, match=said.replace("(", r"\(")):
        Arm(**given_parameters)


def test_trials_of_all_electrodes_read_what_the_person_does():
    """Friction hides a part of each trial; what is added for it brings the readings back, by joint."""
    rng, reads, tells = np.random.default_rng(0), [], []
    postures = [np.deg2rad([90.0 + a, b, c, d]) for a in (-60, -5) for b in (-40, 40)
                for c in (-10, 10) for d in (-10, 10)]
    for member in range(10):
        arm = Arm(member=member)
        plain = replace(arm, hidden_nm=(0.0,) * 4)
        friction = np.array(arm.friction_nm)
        for posture in postures:
            whole, told = (each.torque_nm(posture) * each.response.highest[:, np.newaxis]
                           for each in (arm, plain))
            trials = []
            for _ in range(3):
                order = rng.permutation(len(whole))
                path = np.vstack([np.zeros((1, 4)), whole[order]])
                passed = play(path, friction, rng.uniform(-friction, friction))
                passed -= np.median(passed, axis=0)
                trials.append(passed[1:][np.argsort(order)])
            reads.append(np.mean(trials, axis=0))
            tells.append(told)
    reads, tells = np.concatenate(reads), np.concatenate(tells)
    share = (reads * tells).sum(axis=0) / (tells**2).sum(axis=0)
    assert ((share > 0.85) & (share < 1.02)).all()

"""Soft tissue against the analytic oscillator, scipy's simulation, and what a gyroscope adds up to."""

import math

import numpy as np
import pytest
from imu_parts import ideal, run, sites
from scipy.signal import lsim
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from plants.imus.disturbances import SoftTissue, own_rate, turn_back, wobble

W, Z = 2.0 * math.pi * 6.0, 0.25


def analytic_step(time):
    """Unit step response of th'' + 2 z w th' + w^2 th = w^2 u from rest."""
    damped = W * math.sqrt(1.0 - Z * Z)
    ring = np.cos(damped * time) + Z * W / damped * np.sin(damped * time)
    return 1.0 - np.exp(-Z * W * time) * ring


def analytic_rate(time):
    damped = W * math.sqrt(1.0 - Z * Z)
    return W * W / damped * np.exp(-Z * W * time) * np.sin(damped * time)


@pytest.mark.parametrize("rate", ["100", "1000"])
def test_a_step_of_angular_acceleration_at_any_rate_of_samples(rate):
    """alpha = 20 rad/s^2 from t = 0 on, so the gyroscope reads alpha t and what the sensor adds."""
    tissue = SoftTissue(natural_hz=6.0, damping=Z, share=0.7, sag_deg=0.0)
    alpha, ticks = 20.0, int(0.6 * int(rate))

    def given(k, time):
        return sites(1, rate=(0.0, 0.0, alpha * time))

    samples, _ = run(ideal(1, soft_tissue=tissue), given, ticks, rate=rate)
    time = np.arange(ticks) / int(rate)
    expected = alpha * time - 0.7 * alpha / W**2 * analytic_rate(time)
    np.testing.assert_allclose(samples["gyr"][:, 0, 2], expected, rtol=0.0, atol=1e-10)
    # The magnetometer shows the angle: a field that stands still in the bone's frame.
    field = samples["mag"][:, 0]
    turned = np.unwrap(np.arctan2(field[:, 1], field[:, 0]))
    np.testing.assert_allclose(turned - turned[0], 0.7 * alpha / W**2 * analytic_step(time), atol=1e-10)


@pytest.mark.parametrize("rate", ["40", "100", "1000"])
def test_specific_force_pulls_the_sensor_over_as_scipy_says(rate):
    """A force that is linear from sample to sample, against scipy's exact simulation of it."""
    tissue = SoftTissue(natural_hz=6.0, damping=Z, share=0.0, sag_deg=3.0, outwards=(-1.0, 0.0, 0.0))
    ticks, rng = int(rate), np.random.default_rng(2)
    push = rng.normal(scale=5.0, size=ticks)

    def given(k, _):
        return sites(1, force=(9.80665, push[k], 0.0))

    samples, _ = run(ideal(1, soft_tissue=tissue), given, ticks, rate=rate)
    balance = math.radians(3.0) * push / 9.80665
    time = np.arange(ticks) / int(rate)
    system = (np.array([[0.0, 1.0], [-W * W, -2.0 * Z * W]]), [[0.0], [W * W]], np.eye(2), np.zeros((2, 1)))
    _, response, _ = lsim(system, balance, time, X0=[balance[0], 0.0])
    np.testing.assert_allclose(samples["gyr"][:, 0, 2], response[:, 1], rtol=0.0, atol=1e-9)


def test_at_rest_a_gravity_of_1_g_along_the_skin_is_the_sag():
    tissue = SoftTissue(sag_deg=4.0, outwards=(1.0, 0.0, 0.0))
    acc = run(ideal(1, soft_tissue=tissue), sites(1, force=(0.0, 9.80665, 0.0)), 3)[0]["acc"][:, 0]
    np.testing.assert_allclose(np.degrees(np.arctan2(acc[:, 0], acc[:, 1])), -4.0, atol=1e-9)
    straight = run(ideal(1, soft_tissue=tissue), sites(1, force=(9.80665, 0.0, 0.0)), 1)[0]["acc"][0, 0]
    np.testing.assert_array_equal(straight, [9.80665, 0.0, 0.0])


def test_weight_pulls_the_outer_side_down():
    """Standing out towards x with y up: the sensor's top leans down, towards -y, by a turn about -z."""
    motion = np.zeros((4, 3))
    wobble(SoftTissue(sag_deg=4.0, outwards=(1.0, 0.0, 0.0)).coefficients(), np.zeros(3),
           np.array([0.0, 9.80665, 0.0]), 0.0, motion)
    np.testing.assert_allclose(np.degrees(motion[0]), [0.0, 0.0, -4.0], atol=1e-12)


def test_the_gyroscope_adds_up_to_how_the_sensor_has_turned():
    """Bone turning fast in space: integrated samples end where bone and tissue together have turned."""
    tissue = SoftTissue(natural_hz=6.0, damping=Z, share=1.0, sag_deg=8.0)
    hertz, ticks = 4000, 2000

    def bone_rate(time):
        return np.array([4.0 * math.sin(9.0 * time), 3.0 * math.cos(7.0 * time) - 3.0,
                         5.0 * math.sin(5.0 * time)])

    def given(k, time):
        return sites(1, rate=bone_rate(time), force=(4.0 * math.sin(8.0 * time), 6.0, 7.0 * math.cos(time)))

    imus = ideal(1, soft_tissue=tissue, measures=("gyr", "acc"))
    samples, _ = run(imus, given, ticks + 1, rate=str(hertz))
    read = samples["gyr"][:, 0]
    still = Rotation.identity()
    bone = Rotation.identity()
    for k in range(ticks):
        still = still * Rotation.from_rotvec(0.5 * (read[k] + read[k + 1]) / hertz)
        bone = bone * Rotation.from_rotvec(bone_rate((k + 0.5) / hertz) / hertz)
    start, end = (given(k, k / hertz)[3][0] for k in (0, ticks))
    # What the accelerometer reads of a known force tells how the sensor stands against the bone.
    acc = samples["acc"][:, 0]
    np.testing.assert_allclose(still.apply(acc[-1]), turn_of(acc[0], start).apply(bone.apply(end)), atol=2e-4)
    assert np.linalg.norm(acc[-1] - end) > 0.1


def turn_of(read, true):
    """Rotation into the sensor's first frame: it starts balanced, so turned at right angles to the force."""
    axis = np.cross(true, read)
    size = np.linalg.norm(axis)
    return Rotation.from_rotvec(axis / size * math.asin(size / np.linalg.norm(read) / np.linalg.norm(true)))


@pytest.mark.parametrize("size", [0.0, 1e-8, 1e-3, 0.3, 2.0])
def test_turning_back_and_own_rate_are_those_of_the_rotation_vector(size):
    rng = np.random.default_rng(6)
    direction = rng.normal(size=3)
    rotation = size * direction / np.linalg.norm(direction)
    speed, vector = rng.normal(size=(2, 3))
    turned = vector.copy()
    turn_back(rotation, turned)
    np.testing.assert_allclose(turned, Rotation.from_rotvec(rotation).inv().apply(vector), atol=1e-12)
    h = 1e-5
    between = Rotation.from_rotvec(rotation - h * speed).inv() * Rotation.from_rotvec(rotation + h * speed)
    added = np.zeros(3)
    own_rate(rotation, speed, added)
    np.testing.assert_allclose(added, between.as_rotvec() / (2.0 * h), atol=1e-8)


def test_it_is_stable_where_the_period_is_longer_than_the_oscillation():
    rng = np.random.default_rng(1)
    tissue = SoftTissue(natural_hz=200.0, damping=0.05)
    imus = ideal(1, soft_tissue=tissue)
    samples, _ = run(imus, lambda k, _: sites(1, rate=rng.normal(size=3)), 500, rate="10")
    assert np.abs(samples["gyr"]).max() < 10.0


@pytest.mark.parametrize(("wrong", "name"), [
    ({"natural_hz": 0.0}, "natural_hz"), ({"damping": 1.0}, "damping"), ({"damping": 0.0}, "damping"),
    ({"share": -0.1}, "share"), ({"sag_deg": math.inf}, "sag_deg"),
    ({"outwards": (1.0, 1.0, 0.0)}, "outwards"), ({"outwards": (1.0, 0.0)}, "outwards")])
def test_parameters_that_cannot_be_are_named(wrong, name):
    with pytest.raises(InputError, match=name):
        SoftTissue(**wrong)

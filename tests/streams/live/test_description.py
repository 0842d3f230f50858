"""Which channels of a stream are put out, and in which unit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.streams.labels import factor
from fesloop.streams.live.description import Channel, Declared, pick_angles, pick_inertial

UNITS = {"gyr": "deg/s", "acc": "g", "mag": "uT"}
SI = {"gyr": math.pi / 180.0, "acc": 9.80665, "mag": 1e-6}


def described(sensors, kinds=("acc", "gyr", "mag"), form="{sensor}_{kind}_{axis}"):
    return [Channel(form.format(sensor=s, kind=k, axis=a), UNITS[k], k.upper())
            for s in sensors for k in kinds for a in "xyz"]


@given(st.permutations(["hand", "F2p", "F2m"]), st.sampled_from(
    ["{sensor}_{kind}_{axis}", "{kind}_{sensor}_{axis}", "{sensor}.{axis}.{kind}", "{sensor} {kind}{axis}"]),
    st.randoms(use_true_random=False))
def test_channels_are_found_wherever_they_stand(wanted, form, random):
    channels = described(["hand", "F2p", "F2m", "F2d"], form=form)
    random.shuffle(channels)
    picked = pick_inertial(channels, len(channels), ("gyr", "acc", "mag"), 3, wanted, Declared(), "stream")
    for kind, (numbers, factors) in picked.items():
        for row, sensor in enumerate(wanted):
            labels = [channels[n].label for n in numbers[row]]
            assert labels == [form.format(sensor=sensor, kind=kind, axis=a) for a in "xyz"]
        assert factors == pytest.approx(np.full((3, 3), SI[kind]))


def test_channels_that_are_not_understood_are_told_where_one_is_missing():
    channels = [Channel(each.label.replace("acc_z", "acc_up"), each.unit, "") for each in described(["hand"])]
    with pytest.raises(InputError, match=r"no channel 'hand acc z'.*not understood: 'hand_acc_up'"):
        pick_inertial(channels, 9, ("gyr", "acc"), 1, (), Declared(), "stream")


def test_numbers_become_si():
    picked = pick_inertial(described(["hand"]), 9, ("gyr", "acc", "mag"), 1, (), Declared(), "stream")
    sample = np.array([0.0, 0.0, 1.0, 180.0, 0.0, -90.0, 20.0, 0.0, -40.0], dtype=np.float32)
    assert picked["acc"].of(sample)[0] == pytest.approx([0.0, 0.0, 9.80665])
    assert picked["gyr"].of(sample)[0] == pytest.approx([math.pi, 0.0, -math.pi / 2])
    assert picked["mag"].of(sample)[0] == pytest.approx([2e-5, 0.0, -4e-5])


@pytest.mark.parametrize(("order", "numbers"), [
    ("by_sensor", [[0, 1, 2], [6, 7, 8]]), ("by_kind", [[0, 1, 2], [3, 4, 5]])])
def test_a_declared_layout_serves_where_none_is_described(order, numbers):
    layout = Declared(kinds=("acc", "gyr"), order=order, gyr_unit="dps", acc_unit="m/s^2")
    picked = pick_inertial((), 12, ("gyr", "acc"), 2, (), layout, "stream")
    assert picked["acc"].channels.tolist() == numbers
    assert picked["gyr"].factors == pytest.approx(np.full((2, 3), math.pi / 180))


def test_angles_are_found_by_name_and_become_radians():
    channels = [Channel("pip", "deg", ""), Channel("mcp", "rad", ""), Channel("dip", "degrees", "")]
    picked = pick_angles(channels, 3, ("mcp", "pip"), Declared(), "stream")
    assert picked.of(np.array([90.0, 0.5, 1.0])) == pytest.approx([0.5, math.pi / 2])
    declared = pick_angles((), 2, ("mcp", "pip"), Declared(angle_unit="deg"), "stream")
    assert declared.of(np.array([180.0, 90.0])) == pytest.approx([math.pi, math.pi / 2])


@pytest.mark.parametrize(("change", "parts"), [
    ({"names": ("thumb",)}, ("stream", "no sensor 'thumb'", "hand, F2p")),
    ({"sensors": 3}, ("has 2 sensors (hand, F2p)", "sensors = 3", "sensor_names")),
    ({"wanted": ("mag",)}, ("no channel 'hand mag x'",)),
    ({"count": 20}, ("describes 12 channels and has 20",)),
    ({"channels": ()}, ("does not describe its 12 channels", "layout")),
    ({"channels": (), "declared": Declared(kinds=("acc",))}, ("12 channels", "6: 2 sensors of acc")),
    ({"channels": (), "declared": Declared(kinds=("acc", "gyr"))}, ("layout.gyr_unit", "states no unit")),
])
def test_what_does_not_fit_is_refused_with_what_would(change, parts):
    given_ = {"channels": described(["hand", "F2p"], ("acc", "gyr")), "count": 12, "wanted": ("gyr", "acc"),
              "sensors": 2 if "names" not in change else 1, "names": (), "declared": Declared(), **change}
    with pytest.raises(InputError) as refused:
        pick_inertial(given_["channels"], given_["count"], given_["wanted"], given_["sensors"],
                      given_["names"], given_["declared"], "stream")
    for part in parts:
        assert part in str(refused.value)


@pytest.mark.parametrize(("first", "second"), [
    ("F2p_gyr_x", "F2p_gyr_x"), ("F2p_gyr_x", "F2p GyrX")])
def test_two_channels_that_are_the_same_are_refused_where_they_are_wanted(first, second):
    """Of a sensor or a kind that is left out it does not matter which is which."""
    channels = [*described(["hand", "F2p"]), Channel(second, "deg/s", "GYR")]
    numbers = [k + 1 for k, channel in enumerate(channels) if channel.label in (first, second)]
    assert len(numbers) == 2

    def pick(*names, kinds=("gyr", "acc"), sensors=2):
        return pick_inertial(channels, len(channels), kinds, sensors, names, Declared(), "stream name 'imus'")

    for sensors in (2, 3):
        with pytest.raises(InputError) as refused:
            pick(sensors=sensors)
        assert str(refused.value) == (
            f"stream name 'imus': has 2 channels of F2p gyr x: {first!r} (number {numbers[0]}) and "
            f"{second!r} (number {numbers[1]}); allowed: one; give each a label of its own at the sender")
    assert pick("hand", sensors=1)["gyr"].channels.tolist() == [[3, 4, 5]]
    assert set(pick(kinds=("acc", "mag"))) == {"acc", "mag"}


def test_an_angle_that_is_there_twice_is_refused_where_it_is_wanted():
    channels = [Channel(label, "rad", "") for label in ("mcp", "pip", "dip", "pip", "pip")]
    with pytest.raises(InputError) as refused:
        pick_angles(channels, 5, ("mcp", "pip"), Declared(), "stream name 'posture'")
    assert str(refused.value) == (
        "stream name 'posture': has 3 channels of pip: 'pip' (number 2) and 'pip' (number 4) and others; "
        "allowed: one; give each a label of its own at the sender")
    assert pick_angles(channels, 5, ("dip", "mcp"), Declared(), "stream").channels.tolist() == [2, 0]


def test_units_belong_to_quantities():
    assert factor("acc", "mg", "") == pytest.approx(9.80665e-3)
    assert factor("mag", "mG", "") == pytest.approx(1e-7)
    assert factor("mag", " µT ", "") == pytest.approx(1e-6)
    with pytest.raises(InputError, match="'kg' is no unit of acc"):
        factor("acc", "kg", "stream: channel 'x'")

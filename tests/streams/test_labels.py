"""Labels of channels: what laboratories and makers write, and what only looks alike."""

import pytest

from fesloop.streams.labels import not_understood, read_label


@pytest.mark.parametrize(("label", "read"), [
    ("hand_gyr_x", ("hand", "gyr", "x")), ("F2p_gyr_x", ("F2p", "gyr", "x")), ("AccX", ("", "acc", "x")),
    ("ACC_Z", ("", "acc", "z")), ("Accelerometer F2p Y", ("F2p", "acc", "y")), ("GYROX", ("", "gyr", "x")),
    ("F2p.mag.z", ("F2p", "mag", "z")), ("handAccX", ("hand", "acc", "x")), ("acc_x2", ("2", "acc", "x")),
    ("imu1 Gyroscope Z", ("imu1", "gyr", "z")), ("gyr.wrist.x", ("wrist", "gyr", "x")),
    ("Angular_velocity_y", ("", "gyr", "y")), ("left-hand magn-x", ("left-hand", "mag", "x")),
    ("acc.x.3", ("3", "acc", "x")), ("acc.z.3", ("3", "acc", "z")), ("hand AccX", ("hand", "acc", "x")),
    ("hand_x_gyr", ("hand", "gyr", "x")), ("gyr_x_hand", ("hand", "gyr", "x")), ("omega_x", ("", "gyr", "x")),
    ("angvel_z", ("", "gyr", "z")), ("angular rate X", ("", "gyr", "x")), ("IMU1_AccX", ("IMU1", "acc", "x")),
    ("imu1 GyroscopeY", ("imu1", "gyr", "y")), ("Accelerometer_Z", ("", "acc", "z")),
    ("upper_arm_left_acc_y", ("upper_arm_left", "acc", "y")), ("MagnetometerX", ("", "mag", "x")),
    ("magnetic field x", ("", "mag", "x")), ("hand acc (Y)", ("hand", "acc", "y")),
    ("F2p-acc_x_2", ("F2p_2", "acc", "x")), ("x_hand_acc_y", ("x_hand", "acc", "y"))])
def test_labels_that_say_what_they_are(label, read):
    assert read_label(label) == read
    assert read_label(f" {label} ", "MAG") == read


@pytest.mark.parametrize(("label", "channel_type", "read"), [
    ("F2p_x", "ACC", ("F2p", "acc", "x")), ("F2p X", "Gyroscope", ("F2p", "gyr", "x")),
    ("F2p.y", "AngularVelocityY", ("F2p", "gyr", "y")), ("z", "Magnetometer", ("", "mag", "z")),
    ("battery_x", "Misc", None), ("acc_norm", "ACC", None), ("F2p_x", "gyr and acc", None)])
def test_types_beside_labels(label, channel_type, read):
    assert read_label(label, channel_type) == read


@pytest.mark.parametrize("label", [
    "vacc_x", "Accuracy_x", "ACCURACY_X", "magnitude_x", "MAGNITUDE_X", "EMG_x", "quat_x", "x", "gyr",
    "acc_norm", "", "imagery_x", "temperature", "gyr_acc_x"])
def test_labels_that_are_something_else(label):
    assert read_label(label) is None


def test_channels_left_out_are_told_up_to_a_number():
    assert not not_understood(())
    assert not_understood(["a", "b"]) == "not understood: 'a', 'b'"
    assert not_understood([str(k) for k in range(10)]).endswith("'7' and 2 more")

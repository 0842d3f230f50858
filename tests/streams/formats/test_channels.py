"""Labels of channels: what laboratories write, and what only looks alike."""

import pytest

from fesloop.streams.formats.channels import channel_of_label


@pytest.mark.parametrize(("label", "sensor", "quantity", "axis"), [
    ("hand_gyr_x", "hand", "gyr", 0), ("AccX", "imu", "acc", 0), ("ACC_Z", "imu", "acc", 2),
    ("Accelerometer F2p Y", "F2p", "acc", 1), ("F2p.mag.z", "F2p", "mag", 2), ("handAccX", "hand", "acc", 0),
    ("GYROX", "imu", "gyr", 0), ("imu1 Gyroscope Z", "imu1", "gyr", 2), ("gyr.wrist.x", "wrist", "gyr", 0),
    ("Angular_velocity_y", "imu", "gyr", 1), ("left-hand magn-x", "left-hand", "mag", 0)])
def test_labels_that_say_what_they_are(label, sensor, quantity, axis):
    channel = channel_of_label(label, "V")
    assert (channel.sensor, channel.quantity, channel.axis, channel.unit) == (sensor, quantity, axis, "V")


@pytest.mark.parametrize("label", ["vacc_x", "Accuracy_x", "ACCURACY_X", "magnitude_x", "EMG_x", "quat_x",
                                   "x", "gyr", "acc_norm", "", "imagery_x"])
def test_labels_that_are_something_else(label):
    assert channel_of_label(label, "V") is None

"""Labels of channels: what laboratories write, and what only looks alike."""

from pathlib import Path

import numpy as np
import pytest

from fesloop.streams.formats.channels import channel_of_label, recording_of


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


def test_samples_of_a_tables_columns_lie_together():
    """Filters in C refuse samples whose numbers lie apart, as columns of a table do."""
    table = np.tile([0.0, 0.1, 0.2, 0.0, 0.0, 9.8], (5, 1)).copy(order="F")
    sensors = {name: {"gyr": table[:, :3], "acc": table[:, 3:]} for name in ("hand", "F2p", "F2m")}
    recording = recording_of(Path("t.xdf"), "xdf", sensors, np.arange(5) * 10_000_000, None)
    assert recording.gyr[3].flags.c_contiguous
    assert recording.acc[3].flags.c_contiguous
    np.testing.assert_array_equal(recording.gyr[3], np.tile([0.0, 0.1, 0.2], (3, 1)))

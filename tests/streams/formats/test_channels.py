"""From channels to sensors: names, and how samples lie in memory."""

from pathlib import Path

import numpy as np

from fesloop.streams.formats.channels import Channel, channel_of_label, recording_of


def test_a_sensor_without_a_name_is_imu():
    assert channel_of_label("AccX", "g") == Channel("imu", "acc", 0, "g")
    assert channel_of_label("F2p.z", "rad/s", "AngularVelocityZ") == Channel("F2p", "gyr", 2, "rad/s")
    assert channel_of_label("temperature", "K") is None


def test_samples_of_a_tables_columns_lie_together():
    """Filters in C refuse samples whose numbers lie apart, as columns of a table do."""
    table = np.tile([0.0, 0.1, 0.2, 0.0, 0.0, 9.8], (5, 1)).copy(order="F")
    sensors = {name: {"gyr": table[:, :3], "acc": table[:, 3:]} for name in ("hand", "F2p", "F2m")}
    recording = recording_of(Path("t.xdf"), "xdf", sensors, np.arange(5) * 10_000_000, None)
    assert recording.gyr[3].flags.c_contiguous
    assert recording.acc[3].flags.c_contiguous
    np.testing.assert_array_equal(recording.gyr[3], np.tile([0.0, 0.1, 0.2], (3, 1)))

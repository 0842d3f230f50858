"""A small Motion-BIDS dataset, written by hand after the specification."""

from __future__ import annotations

import json

import numpy as np
from recording_files import SAMPLES, still

POINTS = ("forearm", "hand")
STEM = "sub-01_task-grasp_tracksys-{}"
_TYPES = {"gyr": "GYRO", "acc": "ACCEL", "mag": "MAGN"}


def cell(value):
    """A number of full precision, or n/a."""
    return "n/a" if np.isnan(value) else repr(float(value))


def samples():
    """{point: (gyr deg/s, acc m/s^2, mag uT)}; the hand lost a sample of its gyroscope."""
    found = {}
    for number, point in enumerate(POINTS):
        gyr, acc, mag = still(seed=number)
        found[point] = [np.rad2deg(gyr), acc, mag]
    found["hand"][0][4] = np.nan
    return found


def quaternions(count=SAMPLES):
    """{point: (count, 4)} w x y z; the forearm's was not seen at first."""
    angle = 0.01 * np.arange(count)
    turned = np.stack([np.cos(angle), 0 * angle, 0 * angle, np.sin(angle)], axis=1)
    return {"forearm": np.vstack([np.full((1, 4), np.nan), turned[1:]]), "hand": turned}


def write_system(folder, name, channels, columns, rate, times=None):
    """One tracking system: channels are (name, component, type, tracked_point, units)."""
    if times is not None:
        channels = [("latency", "n/a", "LATENCY", "n/a", "s"), *channels]
        columns = [np.asarray(times), *columns]
    stem = STEM.format(name)
    folder.mkdir(parents=True, exist_ok=True)
    rows = zip(*columns, strict=True)
    (folder / f"{stem}_motion.tsv").write_text(
        "".join("\t".join(cell(value) for value in row) + "\n" for row in rows))
    (folder / f"{stem}_channels.tsv").write_text(
        "\n".join("\t".join(row) for row in [("name", "component", "type", "tracked_point", "units"),
                                             *channels]) + "\n")
    kinds = [channel[2] for channel in channels]
    counts = {f"{kind}ChannelCount": kinds.count(kind) for kind in (
        "ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "POS", "VEL")}
    (folder / f"{stem}_motion.json").write_text(json.dumps({
        "TaskName": "grasp", "TaskDescription": "grasp", "SamplingFrequency": rate, "RecordingType":
        "continuous", "TrackingSystemName": name, "TrackedPointsCount": len(POINTS), "Manufacturer": "none",
        "MotionChannelCount": len(channels) - kinds.count("LATENCY"), "MissingValues": "n/a",
        "RecordingDuration": 1.0, "SoftwareVersions": "n/a", "SubjectArtefactDescription": "n/a",
        "SamplingFrequencyEffective": rate, "ManufacturersModelName": "n/a", **counts}))
    return folder / f"{stem}_motion.tsv"


def write_dataset(root, latency=False):
    """The dataset: system imu at 100 Hz, system optical at 50 Hz from 0.1 s on; gives the imu's table."""
    folder = root / "sub-01" / "motion"
    (root).mkdir(parents=True, exist_ok=True)
    (root / "dataset_description.json").write_text(json.dumps(
        {"Name": "made", "BIDSVersion": "1.9.0", "DatasetType": "raw"}))
    (root / "README").write_text("A recording that was made up to test a reader of such files.\n")
    channels, columns = [], []
    for point, quantities in samples().items():
        for (kind, code), values, unit in zip(_TYPES.items(), quantities, ("deg/s", "m/s^2", "uT"),
                                              strict=True):
            for axis in range(3):
                channels.append((f"{point}_{kind}_{'xyz'[axis]}", "xyz"[axis], code, point, unit))
                columns.append(values[:, axis])
    times = 0.25 + 0.01 * np.arange(SAMPLES) if latency else None
    path = write_system(folder, "imu", channels, columns, 100, times)
    channels, columns = [], []
    for point, values in quaternions().items():
        for number, part in enumerate("wxyz"):
            channels.append((f"{point}_q{part}", f"quat_{part}", "ORNT", point, "n/a"))
            columns.append(values[:, number])
    write_system(folder, "optical", channels, columns, 50, 0.1 + 0.02 * np.arange(SAMPLES))
    return path

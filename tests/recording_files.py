"""Small sound recordings in each format, made from nothing but their makers' layout."""

from __future__ import annotations

import numpy as np
from scipy.io import savemat

SAMPLES = 40


def still(samples=SAMPLES, seed=0):
    """(gyr, acc, mag) of a sensor at rest with noise: rad/s, m/s^2, uT."""
    rng = np.random.default_rng(seed)
    gyr = 0.01 * rng.normal(size=(samples, 3))
    acc = np.array([0.0, 0.0, 9.81]) + 0.05 * rng.normal(size=(samples, 3))
    mag = np.array([0.0, 20.0, -40.0]) + 0.1 * rng.normal(size=(samples, 3))
    return gyr, acc, mag


def broad_content():
    gyr, acc, mag = still()
    quat = np.tile([1.0, 0.0, 0.0, 0.0], (SAMPLES, 1))
    quat[5] = np.nan
    return {"imu_gyr": gyr, "imu_acc": acc, "imu_mag": mag, "opt_quat": quat, "sampling_rate": 2000 / 7,
            "movement": np.ones((SAMPLES, 1), dtype=np.uint8)}


def body16_content():
    sensors = {}
    for i, name in enumerate(("forearm_left", "hand_left")):
        gyr, acc, _ = still(seed=i)
        sensors[name] = {"acc": acc, "gyr": gyr, "quat": np.ones((SAMPLES, 4))}
    return {"t": 40.0 + 0.01 * np.arange(SAMPLES)[:, np.newaxis], **sensors}


def chain5_content():
    content = {}
    for i, name in enumerate(("rigid", "nonrigid")):
        gyr, acc, mag = still(seed=i)
        content[f"imu_{name}"] = np.hstack([np.hstack([acc, gyr, 0.01 * mag])] * 5).astype(np.float32)
        content[f"imu_{name}_cols"] = np.array(
            [f"seg{s}_{k}_{a}" for s in range(1, 6) for k in ("acc", "gyr", "mag") for a in "xyz"])
        content[f"imu_{name}_hz"] = 40.0
    quat = np.tile([1.0, 0.0, 0.0, 0.0], (30, 5)).astype(np.float32)
    quat[3, :4] = np.nan
    content["omc"] = quat
    content["omc_cols"] = np.array([f"seg{s}_quat_{p}" for s in range(1, 6) for p in "wxyz"])
    content["omc_hz"] = 30.0
    return content


def wrist_content():
    content = {"imu_cols": np.array(["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]), "hz": 125.0,
               "gt_cols": np.array(["TIME", *(f"QUATERNION_{i}" for i in range(4))])}
    for i, segment in enumerate(("carpus", "radius")):
        gyr, acc, _ = still(seed=i)
        content[f"imu_{segment}"] = np.hstack([acc, gyr]).astype(np.float32)
        times = 1.1e9 + 8000.0 * np.arange(SAMPLES)[:, np.newaxis]
        content[f"gt_{segment}"] = np.hstack([times, np.tile([1.0, 0.0, 0.0, 0.0], (SAMPLES, 1))])
    return content


CONTENTS = {"broad": broad_content, "body16": body16_content, "chain5": chain5_content,
            "wrist": wrist_content}


def write(folder, kind, content=None, name="trial"):
    """A file of the kind; its name says nothing of what is in it."""
    content = CONTENTS[kind]() if content is None else content
    path = folder / f"{name}.dat"
    with path.open("wb") as file:
        if kind in ("broad", "body16"):
            savemat(file, content, do_compression=True)
        else:
            np.savez(file, **content)
    return path

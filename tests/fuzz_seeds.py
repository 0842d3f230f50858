"""Small sound files of every format that fesloop reads, made on the spot."""

from __future__ import annotations

import io
import json
import random
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import fuzz_mutations as spoil
import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.export import xdf
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.streams.files import open_recording
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.stimulation import import_stimulation

Array = NDArray[np.float64]
Spoiler = Callable[[bytes, random.Random], bytes]
_SAMPLES, _RATE = 60, 100
_LABELS = [f"hand_{kind}_{axis}" for kind in ("gyr", "acc", "mag") for axis in "xyz"]
_UNITS = ["rad/s"] * 3 + ["m/s^2"] * 3 + ["T"] * 3
_LAYOUT = """rate = 100
[text]
separator = ","
[sensors.hand]
gyr = ["hand_gyr_x", "hand_gyr_y", "hand_gyr_z"]
acc = ["hand_acc_x", "hand_acc_y", "hand_acc_z"]
mag = [7, 8, 9]
"""
_MAT_LAYOUT = """rate = 100
[sensors.hand]
gyr = "imu.gyr"
acc = "imu.acc"
mag = "mag"
"""
_XDF_LAYOUT = """time = "imu"
[sensors.hand]
gyr = ["hand_gyr_x", "hand_gyr_y", "hand_gyr_z"]
acc = {variable = "imu", columns = [4, 5, 6]}
"""


@dataclass(frozen=True, slots=True)
class Seed:
    """A sound recording.

    Attributes
    ----------
    files: by name within a folder; the first is the one that is opened.
    reader: how it is opened: "recording", "layout" (with the file layout.toml), "stimulation", "run" or
        "fmu".
    spoilers: what may be done to each file, by the ending of its name.
    """

    files: dict[str, bytes]
    reader: str
    spoilers: dict[str, tuple[Spoiler, ...]]


def make_seeds(folder: Path) -> dict[str, Seed]:
    """A seed a format, by name."""
    binary, text = (spoil.spoil_bytes,), (spoil.spoil_text,)
    archive = (spoil.spoil_bytes, spoil.spoil_members, spoil.trick_archive)
    variables = {"imu": {"gyr": _gyr(), "acc": _acc()}, "mag": _mag(), "note": "x"}
    broad = {"imu_gyr": _gyr(), "imu_acc": _acc(), "imu_mag": 1e6 * _mag(), "sampling_rate": 100.0,
             "opt_quat": np.tile([1.0, 0.0, 0.0, 0.0], (_SAMPLES, 1)), "movement": np.ones(_SAMPLES, "u1")}
    made = {
        "xdf": Seed({"lab.xdf": _xdf()}, "recording", {"": (spoil.spoil_bytes, spoil.spoil_xdf)}),
        "xdf_layout": Seed({"lab.xdf": _xdf(), "layout.toml": _XDF_LAYOUT.encode()}, "layout",
                           {".xdf": (spoil.spoil_bytes, spoil.spoil_xdf), ".toml": text}),
        "bids": Seed(_bids(), "recording", {"": text}),
        "mat5": Seed({"lab.mat": _mat5(broad, False)}, "recording", {"": binary}),
        "mat5_compressed": Seed({"lab.mat": _mat5(broad, True)}, "recording",
                                {"": (spoil.spoil_bytes, spoil.spoil_mat5)}),
        "mat5_structures": Seed({"lab.mat": _mat5(variables, False), "layout.toml": _MAT_LAYOUT.encode()},
                                "layout", {".mat": binary, ".toml": text}),
        "mat73": Seed({"lab.mat": _mat73(folder, variables), "layout.toml": _MAT_LAYOUT.encode()}, "layout",
                      {".mat": binary, ".toml": text}),
        "npz": Seed({"lab.npz": _npz()}, "recording", {"": archive}),
        "csv": Seed({"lab.csv": _csv(), "layout.toml": _LAYOUT.encode()}, "layout", {"": text}),
        "motion": Seed({"motion.h5": _motion(folder, broad)}, "recording", {"": binary}),
        "stimulation_tables": Seed(_trials(), "stimulation", {"": text}),
        "stimulation_npz": Seed({"rat.npz": _rat()}, "stimulation", {"": archive}),
        "stimulation": Seed({"person.h5": _person(folder)}, "stimulation", {"": binary}),
        "run": Seed({"run.h5": _run(folder)}, "run", {"": binary}),
    }
    fmu = _fmu(folder)
    return made | ({"fmu": Seed({"plant.fmu": fmu}, "fmu", {"": archive})} if fmu else {})


def _wave(middle: tuple[float, float, float], height: float) -> Array:
    return np.asarray(middle + np.linspace(-height, height, 3 * _SAMPLES).reshape(_SAMPLES, 3))


def _gyr() -> Array:
    return _wave((0.0, 0.0, 0.0), 1.0)


def _acc() -> Array:
    return _wave((0.0, 0.0, 9.81), 0.1)


def _mag() -> Array:
    return 1e-6 * _wave((0.0, 20.0, -40.0), 1.0)


def _table() -> Array:
    return np.hstack([_gyr(), _acc(), _mag()])


def _xdf() -> bytes:
    channels: xdf.Xml = [("channel", [("label", label), ("unit", unit)])
                                for label, unit in zip(_LABELS, _UNITS, strict=True)]
    header: xdf.Xml = [
        ("name", "imu"), ("type", "IMU"), ("channel_count", "9"), ("nominal_srate", str(_RATE)),
        ("channel_format", "double64"), ("desc", [("channels", channels)])]
    times = 10.0 + np.arange(_SAMPLES) / _RATE
    parts = [xdf.MAGIC, xdf.file_header([("version", "1.0")]),
             xdf.stream_header(1, header)]
    for start in range(0, _SAMPLES, 20):
        rows = slice(start, start + 20)
        parts += [xdf.clock_offset(1, times[start], -0.5 + 1e-5 * start),
                  xdf.samples(1, times[rows], _table()[rows]), xdf.boundary()]
    return b"".join([*parts, xdf.stream_footer(1, [("sample_count", str(_SAMPLES))])])


def _rows(separator: str) -> str:
    return "".join(separator.join(repr(float(cell)) for cell in row) + "\n" for row in _table())


def _csv() -> bytes:
    return (",".join(_LABELS) + "\n" + _rows(",")).encode()


def _bids() -> dict[str, bytes]:
    stem = "sub-01_task-a_tracksys-imu_"
    kinds = ["GYRO"] * 3 + ["ACCEL"] * 3 + ["MAGN"] * 3
    rows = [f"{label}\t{label[-1]}\t{kind}\thand\t{unit}"
            for label, kind, unit in zip(_LABELS, kinds, _UNITS, strict=True)]
    channels = "\n".join(["name\tcomponent\ttype\ttracked_point\tunits", *rows]) + "\n"
    return {f"{stem}motion.tsv": _rows("\t").encode(), f"{stem}channels.tsv": channels.encode(),
            f"{stem}motion.json": json.dumps({"SamplingFrequency": _RATE, "TaskName": "a"}).encode()}


def _mat5(content: dict[str, object], compressed: bool) -> bytes:
    from scipy.io import savemat

    made: Any = io.BytesIO()
    savemat(made, content, do_compression=compressed)
    return bytes(made.getvalue())


def _mat73(folder: Path, content: dict[str, object]) -> bytes:
    """HDF5 as MATLAB writes it: text of 512 bytes before it, axes reversed, classes as attributes."""
    path = folder / "seed.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        def put(group: h5py.Group, name: str, value: object) -> None:
            if isinstance(value, dict):
                for key, item in value.items():
                    put(group.require_group(name), key, item)
                return
            letters = isinstance(value, str)
            numbers = np.frombuffer(value.encode("utf-16-le"), "<u2") if isinstance(value, str) else value
            matrix = np.atleast_2d(np.asarray(numbers))
            dataset = group.create_dataset(name, data=matrix.T, compression="gzip")
            dataset.attrs["MATLAB_class"] = np.bytes_("char" if letters else "double")

        for name, value in content.items():
            put(file, name, value)
        cells = file.create_dataset("cells", (1, 1), dtype=h5py.ref_dtype)
        cells[0, 0] = file["mag"].ref
    return b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + path.read_bytes()[128:]


def _npz() -> bytes:
    rotation = np.hstack([1e4 * np.arange(_SAMPLES)[:, np.newaxis], np.tile([1.0, 0, 0, 0], (_SAMPLES, 1))])
    table = np.hstack([_gyr(), _acc()])
    made = io.BytesIO()
    np.savez_compressed(
        made, hz=100.0, imu_cols=[f"{kind}_{axis}" for kind in ("gyr", "acc") for axis in "xyz"],
        gt_cols=["TIME", *(f"QUATERNION_{k}" for k in range(4))], imu_radius=table, imu_carpus=table,
        gt_radius=rotation, gt_carpus=rotation)
    return made.getvalue()


def _motion(folder: Path, broad: dict[str, object]) -> bytes:
    source, target = folder / "seed_broad.mat", folder / "seed_motion.h5"
    source.write_bytes(_mat5(broad, True))
    write_motion_file(open_recording(source), target)
    return target.read_bytes()


def _trials() -> dict[str, bytes]:
    """Isometric trials and a ramp as tables, and the file that describes them."""
    described = ('person = "P1"\nside = "left"\nfrequency_hz = 40\nmuscles = ["biceps"]\ntorque = "device"\n'
                 'baseline = "passive"\nsteady = "trials.csv"\ncourses = "ramps.csv"\n'
                 '[device]\nfriction_nm = {elbow_flexion = 0.3}\n')
    trials = ["muscle,visit,time_s,current_ma,pulse_width_us,elbow_flexion_reference_deg,elbow_flexion_deg,"
              "elbow_flexion_nm"]
    trials += [f"{'biceps' if row % 2 else 'passive'},{row // 2},{3 * row},{60 * (row % 2)},{30 * (row % 2)},"
               f"{10 * (row // 2 % 2)},{10 * (row // 2 % 2) + 0.3},{-0.7 - row % 2}" for row in range(8)]
    ramp = ["recording,muscle,time_s,current_ma,pulse_width_us,elbow_flexion_deg,elbow_flexion_nm"]
    ramp += [f"ramp,biceps,{k / 100},60,{k},0.1,{-0.02 * k}" for k in range(30)]
    return {"p1.toml": described.encode(), "trials.csv": "\n".join(trials).encode(),
            "ramps.csv": "\n".join(ramp).encode()}


def _rat() -> bytes:
    made = io.BytesIO()
    pulse = np.arange(_SAMPLES) % 20 < 10
    np.savez_compressed(
        made, rat="GMx", kind=["QR", "SR"], name=["QR1", "SR1"], first=[0, 30], count=[30, 30], step_s=5e-4,
        length_um=40_000 + np.arange(_SAMPLES), force_mn=np.arange(_SAMPLES), pulse=pulse.astype("u1"))
    return made.getvalue()


def _person(folder: Path) -> bytes:
    for name, content in _trials().items():
        (folder / name).write_bytes(content)
    import_stimulation(folder / "p1.toml", folder / "seed_person.h5")
    return (folder / "seed_person.h5").read_bytes()


def _run(folder: Path) -> bytes:
    done = run(load("finger_pid_latency", ["experiment.duration_s=0.7"]), folder / "seed_runs")
    return done.recording.read_bytes()


def _fmu(folder: Path) -> bytes:
    """The default finger as an FMU; nothing where no plant can be written as one."""
    exporters = {entry.name: entry for entry in entry_points(group="fesloop.exporters")}
    if "finger" not in exporters:
        return b""
    content: bytes = exporters["finger"].load()(folder / "seed.fmu").path.read_bytes()
    return content

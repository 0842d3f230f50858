"""What a recording says of its run before the first tick: the experiment, versions, machine and hour."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib import metadata

import h5py
import numpy as np

from fesloop.experiment.experiment import Experiment

FORMAT = "fesloop recording 1"
STATUS_TYPE = np.dtype("S16")
_PACKAGES = ("fesloop", "numpy", "scipy", "numba", "h5py", "vqf", "osqp", "daqp", "fmpy")


def describe(file: h5py.File, experiment: Experiment) -> None:
    """Write everything that is known before the first tick."""
    file.attrs["format"] = FORMAT
    file.attrs["name"] = experiment.name
    file.attrs["seed"] = experiment.seed
    file.attrs["fingerprint"] = experiment.fingerprint()
    file.attrs["versions"] = json.dumps(_versions())
    file.attrs["wires"] = json.dumps([wire.name for wire in experiment.wires])
    file.create_dataset("experiment", data=experiment.as_json())
    file.create_dataset("status", data=np.array(b"running", STATUS_TYPE))


def describe_wall(file: h5py.File, realtime: Mapping[str, str | float] | None) -> None:
    """Make the group of what depends on the machine and the hour, with what is known of it."""
    wall = file.create_group("wall")
    wall.attrs["started"] = datetime.now(UTC).isoformat(timespec="seconds")
    wall.attrs["machine"] = platform.platform()
    wall.attrs.update(realtime or {})
    for name in ("seconds", "worst_late_s", "worst_collection_ms", "worst_write_ms"):
        wall.create_dataset(name, data=0.0)
    for name in ("deadlines", "missed_deadlines", "collections"):
        wall.create_dataset(name, data=0)


@cache
def _versions() -> Mapping[str, str]:
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "absent"
    return found

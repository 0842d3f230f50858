"""`fesloop reproduce error_replay`: error processes of recorded trackers, and closed loops with these errors.

Every recording of the folders `wrist` and `chain5` under FESLOOP_RECORDINGS plays through a tracker
(`hil_replay`); the error of each angle is fitted as a process to the first half and compared with the second
(`fesloop.analysis.tracker_error.judging`). For relative orientations, the mean squares of the three
components are added. The table also shows what was measured in both halves, since a stationary process cannot
predict a change. Each joint of each sensor set counts as a recording: the shares of its angles that hold are
given as ranges over recordings. (`broad` has one sensor, thus no joint.)

Each process is then used on the simulated finger of `hil_error_replay`, and compared with an ideal tracker.

Takes some minutes, shared by the workers.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fesloop.analysis.tracker_error.fitting import fit_error
from fesloop.analysis.tracker_error.judging import WITHIN
from fesloop.apps.reproduce.cohort import Kept, Key, Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load

VARIABLE = "FESLOOP_RECORDINGS"
LOOP = "hil_error_replay"
SUBJECTS = 10
CONTROLS = ("mpc", "pid")
CRITERIA = ("RMSE within 15 %", "autocorrelation in the 95 % band", "increments within 15 %")
Shares = tuple[float, ...]
_LEAST_MS = 1.0
"""Least offset of the reference's clock that is fitted separately (chosen)."""


@dataclass(frozen=True, slots=True)
class Source:
    """A recording and its tracker.

    Attributes
    ----------
    path: of the recording. folder: of its set. tracker, sensor_set: as in `hil_replay`.
    put_right: whether the reference's stamps are first corrected by the delay that the fit finds.
    drifts: whether the tracker's heading drifts without bound, which no stationary process can predict.
    seeds: of the closed loops.
    """

    path: str
    folder: str
    tracker: str
    sensor_set: str = ""
    put_right: bool = False
    drifts: bool = False
    seeds: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Name in messages."""
        words = [f"{self.folder}/{Path(self.path).stem}", self.sensor_set, self.tracker]
        return " ".join(filter(None, words)) + (", reference put right" if self.put_right else "")

    @property
    def key(self) -> Key:
        """Key of the result."""
        return ("source", self.name)

    def kept(self) -> Kept:
        """Fit and judge the process, and run the closed loops."""
        sensor_set = (f"sensor_set={self.sensor_set}",) if self.sensor_set else ()
        settings = (f"tracker={self.tracker}", *sensor_set)
        found, late_ms = fit_error(self.path, settings=settings), 0.0
        if self.put_right and found.ahead_ms > _LEAST_MS:
            late_ms = found.ahead_ms
            found = fit_error(self.path, settings=settings, reference_late_ms=late_ms)
        with TemporaryDirectory(prefix="fesloop-") as folder:
            file = Path(folder) / "error.toml"
            found.process.save(file)
            loops = {control: [closed_loop(control, seed, Path(folder), file) for seed in self.seeds]
                     for control in CONTROLS}
        return {"report": found.report(), "late_ms": late_ms, "loops": loops}


def closed_loop(control: str, seed: int, folder: Path, file: Path | None) -> tuple[float, float]:
    """RMSE of the joints, and of the tracker, deg, with the process of a file, or with an ideal tracker."""
    tracker = f"error={file}" if file is not None else "tracker=ideal"
    metrics = load(LOOP, (f"control={control}", tracker), seed).run(folder).metrics
    return float(metrics["joint_rmse_deg"][0]), float(metrics["tracker_rmse_deg"][0])


def sources(seeds: tuple[int, ...]) -> list[Source]:
    """Recordings to fit. Raises InputError if there are none."""
    root = Path(os.environ.get(VARIABLE, ""))
    wrists, chains = (sorted((root / folder).glob("*.npz")) for folder in ("wrist", "chain5"))
    if not os.environ.get(VARIABLE) or not (wrists or chains):
        raise InputError(VARIABLE, f"no recordings in {root}",
                         "a folder that holds wrist/*.npz or chain5/*.npz", f"set {VARIABLE} to it")
    found = [Source(str(path), "wrist", "vqf", seeds=seeds) for path in wrists]
    for path in chains:
        for sensor_set in ("rigid", "nonrigid"):
            found += [Source(str(path), "chain5", "constrained", sensor_set, put_right, seeds=seeds)
                      for put_right in (False, True)]
        found.append(Source(str(path), "chain5", "vqf", "rigid", drifts=True, seeds=seeds))
    return found


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Fit every recording, and run `subjects` closed loops with each process."""
    seeds = tuple(range(1, subjects + 1))
    asked = sources(seeds)
    kept = run_jobs(asked, workers, progress)
    with TemporaryDirectory(prefix="fesloop-") as folder:
        ideal = {control: closed_loop(control, 1, Path(folder), None)[0] for control in CONTROLS}
    rows: list[Row] = []
    loops = []
    stationary: dict[str, Shares] = {}
    drifting: dict[str, Shares] = {}
    for source in asked:
        found = kept[source.key]
        angles = found["report"]["angles"]
        rows += rows_of(source.name, angles)
        if not source.put_right:
            (drifting if source.drifts else stationary).update(shares_of_recordings(source.name, angles))
        for control in CONTROLS:
            errors = np.array(found["loops"][control])
            loops.append((f"{source.name}, {control}",
                          (ideal[control], float(errors[:, 0].mean()), float(errors[:, 0].min()),
                           float(errors[:, 0].max()), float(np.sqrt(np.mean(errors[:, 1] ** 2))))))
    sweep = Sweep(title=f"{LOOP}: error of the finger's joints with an ideal tracker and with the process, "
                  f"{subjects} seeds", unit="deg",
                  columns=("ideal", "error replay", "least", "greatest", "tracker"), rows=tuple(loops))
    sweeps = {}
    for name, title, recordings in (("ranges", "trackers without drift", stationary),
                                    ("ranges_drifting", "a tracker whose headings drift", drifting)):
        if recordings:
            sweeps[name] = ranges(recordings, title)
    each = Sweep(title="share of the angles of each recording that holds", unit="%", columns=CRITERIA,
                 rows=tuple({**stationary, **drifting}.items()))
    sweeps |= {"recordings": each, "shares": shares(rows), "closed_loop": sweep}
    return Reproduction("error_replay", subjects, rows, sweeps=sweeps)


def rows_of(name: str, angles: list[dict[str, Any]]) -> list[Row]:
    """Rows of each angle's RMSE, autocorrelation and increments, and of each relative orientation's RMSE."""
    rows = []
    for angle in angles:
        label = angle["angle"] + ("" if angle["moved"] else " (not moved)")
        rows.append(_rmse_row(name, label, [angle]))
        rows.append(Row(f"{name}: autocorrelation", label, "in the 95 % band",
                        f"{100.0 * angle['lags_in_band_share']:.0f} % of the lags",
                        angle["autocorrelation_in_band"]))
        rows.append(_increments_row(name, label, angle["increments"]))
    pairs: dict[str, list[dict[str, Any]]] = {}
    for angle in angles:
        pairs.setdefault(angle["angle"].rpartition(".")[0], []).append(angle)
    rows += [_rmse_row(name, f"{pair} as a whole", parts) for pair, parts in pairs.items() if len(parts) == 3]
    return rows


def _rmse_row(name: str, label: str, parts: list[dict[str, Any]]) -> Row:
    """Row of the RMSE measured in both halves and that of the process over the second."""
    first, second, process = (math.sqrt(sum(part[f"rmse_{which}_deg"] ** 2 for part in parts))
                              for which in ("fitted", "measured", "process"))
    return Row(f"{name}: RMSE", label, f"{second:.2f} (first half {first:.2f})",
               f"{process:.2f}, {100.0 * (process / second - 1.0):+.0f} %",
               bool(abs(process / second - 1.0) <= WITHIN), "deg")


def _increments_row(name: str, label: str, found: dict[str, Any]) -> Row:
    """Row of the RMS changes of the error over short times."""
    measured, process = np.array(found["measured_deg"]), np.array(found["process_deg"])
    off = " ".join(f"{each:+.0f}" for each in 100.0 * (process / measured - 1.0))
    theirs = ", ".join(f"{each:.2f}" for each in measured)
    times = ", ".join(f"{time:.2g}" for time in found["times_s"])
    return Row(f"{name}: increments", label, f"{theirs} over {times} s", f"{off} %",
               bool(found["within_15_percent"]), "deg")


def shares_of_recordings(name: str, angles: list[dict[str, Any]]) -> dict[str, Shares]:
    """Shares of the angles of each pair of segments, %, that hold by each of `CRITERIA`."""
    pairs: dict[str, list[list[bool]]] = {}
    for angle in angles:
        held = [abs(angle["rmse_process_deg"] / angle["rmse_measured_deg"] - 1.0) <= WITHIN,
                angle["autocorrelation_in_band"], angle["increments"]["within_15_percent"]]
        pairs.setdefault(angle["angle"].rpartition(".")[0], []).append(held)
    return {f"{name} {pair}": tuple((100.0 * np.mean(held, axis=0)).tolist()) for pair, held in pairs.items()}


def ranges(recordings: dict[str, Shares], title: str) -> Sweep:
    """Least, median and greatest share over recordings."""
    rows = []
    for criterion, values in zip(CRITERIA, zip(*recordings.values(), strict=True), strict=True):
        rows.append((criterion, (float(min(values)), float(np.median(values)), float(max(values)),
                                 float(np.mean(values)))))
    return Sweep(title=f"{title}, {len(recordings)} recordings: share of the angles that holds", unit="%",
                 columns=("least", "median", "greatest", "mean"), rows=tuple(rows))


def shares(rows: list[Row]) -> Sweep:
    """Count the rows of each table that hold, of all and of the axes about which a joint moves."""
    tables = dict.fromkeys(row.table for row in rows)
    found = []
    for table in tables:
        mine = [row for row in rows if row.table == table and "as a whole" not in row.row]
        moved = [row for row in mine if "not moved" not in row.row]
        found.append((table, (100.0 * np.mean([row.holds for row in mine]),
                              100.0 * np.mean([row.holds for row in moved]) if moved else math.nan)))
    return Sweep(title="share that holds", unit="%", columns=("all angles", "moved angles"), rows=tuple(
        (table, (float(every), float(some))) for table, (every, some) in found))

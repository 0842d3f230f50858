"""`fesloop reproduce people`: the virtual patient against recordings of stimulated people and muscles.

Recordings are those of the folder FESLOOP_RECORDINGS; a part without its recordings is left out, with a row
that says so.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fesloop.apps.reproduce.cohort import Progress
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people import bench, evoked, muscle, trains, unfitted
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.errors import InputError

VARIABLE = "FESLOOP_RECORDINGS"
SUBJECTS = 1000


def fes_exo(folder: Path, random_people: int) -> Part:
    """Steady torque by posture, the virtual patient's, and dynamics and recruitment, of arms in a device."""
    every = [each(folder, random_people) for each in (evoked.rows_and_sweeps, unfitted.part, bench.part)]
    return Part([row for each in every for row in each.rows],
                {name: sweep for each in every for name, sweep in each.sweeps.items()},
                {name: curve for each in every for name, curve in each.curves.items()})


PARTS: dict[str, Callable[[Path, int], Part]] = {
    "fes_exo": fes_exo,
    "rat_gm": muscle.part,
    "biceps_force": trains.part,
}
"""Parts by the folder of their recordings."""


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Compare all recordings that there are with `subjects` random people. Raises InputError without any."""
    folder = Path(os.environ.get(VARIABLE, ""))
    present = {name: part for name, part in PARTS.items() if (folder / name).is_dir()}
    if not os.environ.get(VARIABLE) or not present:
        raise InputError(VARIABLE, f"no recordings in {folder}", f"a folder that holds {' or '.join(PARTS)}",
                         f"set {VARIABLE} to it")
    rows: list[Row] = []
    sweeps: dict[str, Sweep] = {}
    curves: dict[str, Any] = {}
    for done, (name, part) in enumerate(PARTS.items()):
        if name in present:
            found = part(folder / name, subjects)
            rows += found.rows
            sweeps |= found.sweeps
            curves |= found.curves
        else:
            rows.append(Row(name, "recordings", "present", f"absent from {folder}", holds=False))
        if progress is not None:
            progress((done + 1) / len(PARTS))
    return Reproduction("people", subjects, rows, sweeps=sweeps, curves=curves, unit="random person")

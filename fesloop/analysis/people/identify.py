"""A person from a recording of their own: file, report, and what the recording does not say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from fesloop.analysis.people.population import ArmPopulation, trials_of
from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_people import FORMAT, ArmPerson, StoredArm
from fesloop.models.evoked_torque import REFERENCE_RAD
from fesloop.streams.stimulation import open_stimulation

WITHIN = 0.9
"""Probability of the intervals in a report."""
FEW_POSTURES = 4
"""Fewer postures than these leave most of what changes with posture to the population (chosen)."""


def identify_person(recording: str | Path) -> tuple[ArmPerson, list[str]]:
    """A person from the steady trials of a recording, and what these do not say, in words.

    Raises InputError for a recording without steady trials, or of other joints and electrodes.
    """
    trials = trials_of(open_stimulation(recording))
    population = ArmPopulation.shipped()
    lacking = [f"{name} was not stimulated: the interval is the population's"
               for name in population.common if name not in trials.cells]
    missing = [name for j, name in enumerate(JOINTS) if j not in trials.joints]
    if missing:
        lacking.append(f"{', '.join(missing)} not recorded: torque there follows from the other joints")
    few = [f"{name} ({len(cells.trials)})" for name, cells in trials.cells.items()
           if len(cells.trials) < FEW_POSTURES]
    if few:
        lacking.append(f"few postures of {', '.join(few)}: how torque changes with posture is mostly the "
                       "population's")
    if not trials.free:
        lacking.append("no posture was repeated: the scatter of a repeat is the population's")
    return population.person(trials), lacking


def summary_of(person: ArmPerson) -> dict[str, Any]:
    """Torque of each electrode in the reference posture: mean and interval, N m, by joint."""
    times = float(norm.ppf(0.5 + 0.5 * WITHIN))
    rows = []
    for electrode in person.weights:
        mean, sd = (each[0] for each in person.torque(electrode, REFERENCE_RAD[np.newaxis]))
        rows.append({"electrode": electrode, "recorded": electrode in person.tried,
                     **{joint: {"nm": float(mean[j]), "low": float(mean[j] - times * sd[j]),
                                "high": float(mean[j] + times * sd[j])} for j, joint in enumerate(JOINTS)}})
    return {"person": person.name, "posture_deg": np.rad2deg(REFERENCE_RAD).tolist(), "within": WITHIN,
            "repeat_sd_nm": dict(zip(JOINTS, person.scale_nm.tolist(), strict=True)), "electrodes": rows}


def save(person: ArmPerson, path: Path) -> None:
    """Write a person's file, JSON."""
    path.write_text(json.dumps({"format": FORMAT, **person.as_document()}) + "\n", encoding="utf-8")


def load_person(path: str | Path) -> ArmPerson:
    """Read a person's file. Raises InputError for another file."""
    try:
        return ArmPerson.from_document(StoredArm.file_tables(Path(path)))
    except (ValueError, AttributeError, KeyError, TypeError):
        raise InputError(str(path), "is not a person's file", f"JSON of the format {FORMAT!r}",
                         "write one by `fesloop identify --stimulation`") from None

"""A person from a recording of their own: file, report, and what the recording does not say."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from fesloop.analysis.people.population import ArmPopulation, Trials, trials_of
from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_people import FORMAT, ArmPerson, StoredArm
from fesloop.models.evoked_torque import REFERENCE_RAD
from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.summary import doubts_about

Array = NDArray[np.float64]
WITHIN = 0.9
"""Probability of the intervals in a report."""
SURE, MISFIT = 2.0, 2.0
"""Standard deviations beyond which a sign is sure; standard errors of a cell beyond which a fit is poor
(chosen; of the five people's 24 postures it is 1.0 to 1.1)."""
FEW_POSTURES = 4
"""Fewer postures than these leave most of what changes with posture to the population (chosen)."""


class Identified(NamedTuple):
    """An identified person, doubts about the recording in words, and joints that it lacks."""

    person: ArmPerson
    doubts: list[str]
    missing: list[str]


def identify_person(recording: str | Path) -> Identified:
    """Fit a person to the steady trials of a recording.

    Raises InputError for a recording without steady trials, or of other joints and electrodes.
    """
    opened = open_stimulation(recording)
    trials = trials_of(opened)
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
    various = doubts_about(opened).get("various_pulses")
    if various:
        lacking.append(various)
    if not trials.free:
        lacking.append("no posture was repeated by the same pulses: the scatter of a repeat is the "
                       "population's")
    person = population.person(trials)
    return Identified(person, [*_contradictions(trials, population, person), *lacking], missing)


def _contradictions(trials: Trials, population: ArmPopulation, person: ArmPerson) -> Iterator[str]:
    """Yield what contradicts the population, or is not described by the model, in words."""
    off: list[Array] = []
    for electrode, cells in trials.cells.items():
        angles = cells.postures.angles
        mean, sd = ArmPerson("", person.spreads, person.scale_nm, {electrode: population.newcomer(electrode)},
                             ()).torque(electrode, angles)
        usual, spread = mean.mean(axis=0)[trials.joints], sd.mean(axis=0)[trials.joints]
        seen = cells.torque_nm.mean(axis=0)
        error = person.scale_nm[trials.joints] / np.sqrt(cells.trials.sum())
        for j in np.flatnonzero((np.abs(usual) > SURE * spread) & (seen * usual < 0.0)
                                & (np.abs(seen) > SURE * error)):
            joint = JOINTS[trials.joints[j]]
            yield (f"{electrode}: {joint} of {seen[j]:+.2g} N m, where all people have the other sign: check "
                   "the signs of torque, and whether it is the device's or the muscle's")
        expected = person.torque(electrode, angles)[0][:, trials.joints]
        off.append(((cells.torque_nm - expected) / (person.scale_nm[trials.joints]
                                                    / np.sqrt(cells.trials[:, np.newaxis]))).ravel())
    misfit = float(np.sqrt(np.mean(np.concatenate(off)**2)))
    if misfit > MISFIT:
        yield (f"the model misses the recorded torque by {misfit:.1f} standard errors: read the intervals "
               "with care, and check postures, signs and outliers of the recording")


def summary_of(person: ArmPerson, missing: Collection[str] = ()) -> dict[str, Any]:
    """Torque of each electrode in the reference posture: mean and interval, N m, by joint.

    `missing`: joints that the recording lacks.
    """
    times = float(norm.ppf(0.5 + 0.5 * WITHIN))
    rows = []
    for electrode in person.weights:
        mean, sd = (each[0] for each in person.torque(electrode, REFERENCE_RAD[np.newaxis]))
        rows.append({"electrode": electrode, "recorded": electrode in person.tried,
                     **{joint: {"nm": float(mean[j]), "low": float(mean[j] - times * sd[j]),
                                "high": float(mean[j] + times * sd[j])} for j, joint in enumerate(JOINTS)}})
    return {"person": person.name, "missing": list(missing), "within": WITHIN,
            "posture_deg": dict(zip(JOINTS, np.rad2deg(REFERENCE_RAD).tolist(), strict=True)),
            "repeat_sd_nm": dict(zip(JOINTS, person.scale_nm.tolist(), strict=True)), "electrodes": rows}


def save(person: ArmPerson, path: Path) -> None:
    """Write a person's file, JSON."""
    path.write_text(json.dumps({"format": FORMAT, **person.as_document()}) + "\n", encoding="utf-8")


def load_person(path: str | Path) -> ArmPerson:
    """Read a person's file. Raises InputError for another file."""
    document = StoredArm.file_tables(Path(path))
    try:
        return ArmPerson.from_document(document)
    except (ValueError, AttributeError, KeyError, TypeError):
        raise InputError(str(path), "is not a person's file", f"JSON of the format {FORMAT!r}",
                         "write one by `fesloop identify --stimulation`") from None

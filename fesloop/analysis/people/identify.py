"""A person from a recording of their own: file, report, and what the recording does not say."""

from __future__ import annotations

import json
from collections.abc import Iterator
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
from fesloop.streams.stimulation import SteadyTrials, StimulationRecording, open_stimulation
from fesloop.streams.stimulation.recording import SAME_PULSES
from fesloop.streams.stimulation.summary import doubts_about

Array = NDArray[np.float64]
WITHIN = 0.9
"""Probability of the intervals in a report."""
BASELINES = {"visit_median": "the median of each visit", "passive": "each visit's passive trials",
             "none": "nothing"}
"""Torque without the muscle, by the baseline of a recording, in words."""
SURE, MISFIT = 2.0, 2.0
"""Standard deviations beyond which a sign is sure; standard errors of a cell beyond which a fit is poor
(chosen; of the five people's 24 postures it is 1.0 to 1.1)."""
FEW_POSTURES = 4
"""Fewer postures than these leave most of what changes with posture to the population (chosen)."""


class Identified(NamedTuple):
    """An identified person.

    Attributes
    ----------
    person: who it is.
    doubts: about the recording, in words.
    missing: joints that it lacks.
    baseline: what its torques are over, in words.
    gain: of the person's torques over the scatter of their repeats, relative to the population's.
    pulses: by recorded electrode, lowest and highest current, mA, and pulse width, us, in words.
    """

    person: ArmPerson
    doubts: list[str]
    missing: list[str]
    baseline: str
    gain: float
    pulses: dict[str, str]


def identify_person(recording: str | Path) -> Identified:
    """Fit a person to the steady trials of a recording.

    Raises InputError for a recording without steady trials, or of other joints and electrodes.
    """
    opened = open_stimulation(recording)
    trials, steady = trials_of(opened), opened.steady
    assert steady is not None
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
    return Identified(person, [*_contradictions(trials, population, person),
                               *_passive_trials(opened, trials, person), *lacking], missing,
                      BASELINES[steady.baseline], person.spreads.muscles / population.spreads.muscles,
                      {name: _pulses(steady, opened.muscles.index(name)) for name in trials.cells})


def _pulses(steady: SteadyTrials, muscle: int) -> str:
    """Range of a muscle's currents and pulse widths, in words."""
    here = steady.muscle == muscle
    return ", ".join(
        f"{low:.3g} {unit}" if high <= (1.0 + SAME_PULSES) * low else f"{low:.3g} to {high:.3g} {unit}"
        for low, high, unit in ((values[here].min() * factor, values[here].max() * factor, unit)
                                for values, factor, unit in ((steady.current_a, 1e3, "mA"),
                                                             (steady.pulse_width_s, 1e6, "us"))))


def _passive_trials(recording: StimulationRecording, trials: Trials, person: ArmPerson) -> Iterator[str]:
    """Yield in words that passive trials differ from the medians of their visits, beyond their noise."""
    steady = recording.steady
    assert steady is not None
    passive = ~steady.stimulated
    if steady.baseline != "visit_median" or not passive.any():
        return
    mean = steady.evoked_nm[passive].mean(axis=0)
    error = person.scale_nm[trials.joints] / np.sqrt(passive.sum())
    off = [f"{joint} {mean[j]:+.2g} (sd {error[j]:.1g})" for j, joint in enumerate(recording.joints)
           if abs(mean[j]) > SURE * error[j]]
    if off:
        yield (f"passive trials are not at the median of their visits, but at {', '.join(off)} N m: a "
               "person's torques are over the median, a patient's over passive trials: they differ by that")


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


def summary_of(found: Identified) -> dict[str, Any]:
    """Torque of each electrode in the reference posture: mean and interval, N m, by joint."""
    person = found.person
    times = float(norm.ppf(0.5 + 0.5 * WITHIN))
    rows = []
    for electrode in person.weights:
        mean, sd = (each[0] for each in person.torque(electrode, REFERENCE_RAD[np.newaxis]))
        rows.append({"electrode": electrode, "recorded": electrode in person.tried,
                     "pulses": found.pulses.get(electrode, ""),
                     **{joint: {"nm": float(mean[j]), "low": float(mean[j] - times * sd[j]),
                                "high": float(mean[j] + times * sd[j])} for j, joint in enumerate(JOINTS)}})
    return {"person": person.name, "missing": found.missing, "within": WITHIN, "baseline": found.baseline,
            "gain": found.gain,
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

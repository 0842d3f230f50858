"""Model file of a patient from the recording of a sweep over the elements of the arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation
from controllers.identification.elements import (
    GRASP,
    LAGS_S,
    Choice,
    Posture,
    Responses,
    choose_elements,
    model_of,
)
from controllers.trajectories import response
from fesloop.errors import InputError
from fesloop.experiment.files.patients import describe, hand_plant, patient_fingerprint
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.models.electrode_arrays import arrays_in_words
from fesloop.models.patient_model import RECRUITMENT, PatientModel

Array = NDArray[np.float64]
CHANNELS = 8
GREATEST_MA = 34.0
"""Greatest current of a channel, mA (chosen: those of the shipped grasps)."""
_BEFORE_S, _LAST_S = 0.15, 0.08
"""Spans of time before a turn, and at the end of a current, over which the posture is averaged (chosen)."""
_SWEEP = "sweep"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Swept:
    """Samples of a sweep on its ticks.

    Attributes
    ----------
    times_s: (ticks,); element, stair: (ticks,), as of `element_sweep`.
    stimulation: (ticks, 2), pulse after safety, A and s.
    measured: (ticks, m), rad, at the instants of the ticks; NaN before the first capture.
    """

    times_s: Array
    element: NDArray[np.int64]
    stair: NDArray[np.int64]
    stimulation: Array
    measured: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SweepIdentified:
    """Model of a sweep's patient, and the choice of elements that is in it."""

    model: PatientModel
    choice: Choice
    responses: Responses
    lags_s: Array

    def doubts(self) -> list[str]:
        """Postures out of reach of any choice of elements, a warning for each output."""
        return [f"no elements bring {name} nearer than {left:.0f} deg to the {posture} hand: "
                "expect an error there, move the arrays, or stimulate with more current"
                for left, name, posture in self.model.misses()]

    def report(self) -> dict[str, Any]:
        """Report as plain tables: what is left in each posture, and the channels."""
        model, choice = self.model, self.choice
        assert model.model.recruitment is not None
        allocation = Allocation(recruitment=model.model.recruitment, current_ma=model.current_ma,
                                width_max_us=1e6)
        widths = allocation.stimulation(np.full(len(model.current_ma), 0.05))[:, 1]
        channels = [
            {"electrode": model.electrodes[c], "current_ma": model.current_ma[c],
             "threshold_us": 1e6 * float(widths[c]), "half_ma": curve.threshold_ma, "spread": curve.spread,
             "fit_percent": curve.fit_percent, "at_bound": curve.at_bound, "grips": c in choice.closing,
             "moved_deg": dict(zip(model.outputs, np.degrees(curve.gain).tolist(), strict=True))}
            for c, curve in enumerate(choice.curves)]
        return {"patient": model.patient, "outputs": list(model.outputs), "rate": model.rate,
                "order": int(model.model.a.shape[0]), "delay_ms": model.model.delay_ns / 1e6,
                "fit_percent": {"sweep": dict(model.fit["sweep"])}, "channels": channels,
                "missed_deg": {posture: dict(row) for posture, row in model.missed_deg.items()},
                "doubts": self.doubts(), "lags_s": self.lags_s.tolist(),
                "usable": model.usable, "weaknesses": model.weaknesses()}


def identify_sweep(
    recording: Recording, sweep: str, source: str, measured: str, outputs: tuple[str, ...], *,
    channels: int = CHANNELS, greatest_ma: float = GREATEST_MA, task: Sequence[Posture] = GRASP,
) -> SweepIdentified:
    """Choose elements and make the model of a sweep's patient.

    Parameters
    ----------
    sweep, source: names of the block `element_sweep`, and of the one whose `stimulation` was applied.
    measured: signal of the outputs, rad; outputs: their names.
    channels, greatest_ma, task: as in `choose_elements`.

    Raises InputError for outputs that lack some of the task, for a recording without a stimulated element,
    and where too few elements move the hand.
    """
    lacking = sorted({name for posture in task for name in posture.deg} - set(outputs))
    if lacking:
        raise InputError(f"{recording.path}: {measured}", f"has no {', '.join(lacking)}",
                         "every angle of the task's postures", "sweep with sweep_grasp")
    table = recording.experiment["blocks"][sweep]
    swept = read_sweep(recording, sweep, source, measured)
    seen = responses_of(swept, np.array(table["current_ma"], dtype=np.float64), float(table["width_us"]),
                        int(table.get("count", 59)), outputs)
    choice = choose_elements(seen, channels, greatest_ma, task)
    lags_s, fit = lags_of(swept, choice, seen.rest)
    patient = recording.experiment.get("patient")
    model = PatientModel(
        patient=describe(patient) if patient else "",
        patient_fingerprint=patient_fingerprint(patient) if patient else "",
        source=f"{recording.name} {recording.fingerprint[:12]} {measured}", outputs=outputs,
        arrays=arrays_in_words(next((block for block in recording.experiment["blocks"].values()
                                     if block["kind"] == "electrodes"), None)),
        electrodes=tuple(str(element) for element in choice.elements), current_ma=choice.currents_ma,
        rate=table["rate"], model=model_of(choice, seen.rest, lags_s),
        operating_drive=np.zeros(channels), operating_outputs=seen.rest,
        fit={_SWEEP: dict(zip(outputs, fit, strict=True)),
             RECRUITMENT: {f"channel {c}": curve.fit_percent for c, curve in enumerate(choice.curves)}},
        closing=choice.closing, grasping=choice.grasping, plant=hand_plant(recording.experiment["blocks"]),
        missed_deg={posture.name: dict(zip(outputs, row.tolist(), strict=True))
                    for posture, row in zip(task, choice.missed_deg, strict=True)})
    return SweepIdentified(model=model, choice=choice, responses=seen, lags_s=lags_s)


def read_sweep(recording: Recording, sweep: str, source: str, measured: str) -> Swept:
    """Read trial 0 on the ticks of the sweep, with measurements interpolated between their captures."""
    element, stair = recording.signal(f"{sweep}.element"), recording.signal(f"{sweep}.stair")
    pulses, seen = recording.signal(f"{source}.stimulation"), recording.signal(measured)
    if not np.array_equal(pulses.times_ns, element.times_ns):
        raise InputError(f"{recording.path}: {source}", f"does not tick with {sweep}", "the same rate")
    captured, newest = np.unique(seen.newest_ns, return_index=True)
    known = captured >= 0
    if known.sum() < 2:
        raise InputError(f"{recording.path}: {measured}", "has no captured samples",
                         "samples of the whole run")
    times_s = element.times_ns / NS_PER_S
    columns = [np.interp(times_s, captured[known] / NS_PER_S, column, left=np.nan)
               for column in seen.values[newest[known]].T]
    return Swept(times_s=times_s, element=element.values.astype(np.int64),
                 stair=stair.values.astype(np.int64), stimulation=pulses.values[:, 0],
                 measured=np.stack(columns, axis=1))


def responses_of(
    swept: Swept, currents_ma: Array, width_us: float, count: int, outputs: tuple[str, ...]
) -> Responses:
    """Changes of the posture at the end of each current of each element, and the posture before."""
    moved, rests = np.full((count, len(currents_ma), len(outputs)), np.nan), []
    for element in np.unique(swept.element[swept.element >= 0]):
        turn = swept.element == element
        stimulated = np.flatnonzero(turn & (swept.stair >= 0))
        if not stimulated.size:
            continue
        begun_s = swept.times_s[stimulated[0]]
        before = _mean(swept, begun_s - _BEFORE_S, begun_s)
        rests.append(before)
        for stair in range(len(currents_ma)):
            given = np.flatnonzero(turn & (swept.stair == stair))
            # Current that safety did not pass is no current of this stair.
            if given.size and swept.stimulation[given, 1].all():
                ends_s = 2.0 * swept.times_s[given[-1]] - swept.times_s[given[-1] - 1]
                moved[element, stair] = _mean(swept, ends_s - _LAST_S, ends_s) - before
    if not rests:
        raise InputError("element_sweep", "stimulated no element in this recording", "one turn or more",
                         "run it for longer")
    if not np.isfinite(moved).any():
        raise InputError("element_sweep", "no pulse passed safety in this recording", "stimulation",
                         "read its events: `pose_contradicted`, for example, withholds it")
    return Responses(currents_ma=currents_ma, width_us=width_us, moved=moved,
                     rest=np.nanmedian(np.array(rests), axis=0), outputs=outputs)


def _mean(swept: Swept, from_s: float, until_s: float) -> Array:
    within = (swept.times_s > from_s - 1e-9) & (swept.times_s < until_s + 1e-9)
    mean: Array = swept.measured[within].mean(axis=0)
    return mean


def lags_of(swept: Swept, choice: Choice, rest: Array) -> tuple[Array, list[float]]:
    """Lag of each output, s, with which the model follows the chosen elements' turns best; its fit, %."""
    period_ns = round(NS_PER_S * float(np.median(np.diff(swept.times_s))))
    left = np.zeros((len(LAGS_S), len(rest)))
    total = np.zeros(len(rest))
    for c, element in enumerate(choice.elements):
        turn = np.flatnonzero(swept.element == element)
        pulses = np.zeros((turn.size, len(choice.elements), 2))
        pulses[:, c] = swept.stimulation[turn]
        truth = swept.measured[turn] - swept.measured[turn[0]]
        heard = np.isfinite(truth)
        total += np.sum(np.where(heard, truth, 0.0) ** 2, axis=0)
        for i, lag in enumerate(LAGS_S):
            model = model_of(choice, rest, np.full(len(rest), lag))
            assert model.recruitment is not None
            drives = np.array([model.recruitment.fraction(row) for row in pulses])
            told = response(model.sampled(period_ns, 0), drives)
            left[i] += np.sum(np.where(heard, truth - told, 0.0) ** 2, axis=0)
    best = np.argmin(left, axis=0)
    fit = 100.0 * (1.0 - np.sqrt(left[best, np.arange(len(rest))] / np.maximum(total, 1e-12)))
    return np.array(LAGS_S)[best], fit.tolist()

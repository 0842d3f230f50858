"""Model file of a patient from the recording of an identification experiment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation
from controllers.identification.dynamics import Method
from controllers.identification.elements import grasp_task
from controllers.identification.patient_model import IdentificationRecord, Identified, identify
from controllers.identification.sweep import SweepIdentified, identify_sweep
from fesloop.errors import InputError
from fesloop.experiment.files.patients import describe, hand_plant, patient_fingerprint
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.models.electrode_arrays import arrays_in_words
from fesloop.models.patient_model import RECRUITMENT, PatientModel, electrodes_in_words

Array = NDArray[np.float64]
THRESHOLD_SHARE = 0.05
"""Recruited fraction that counts as the threshold of a curve (chosen: a visible twitch)."""
_REPORTED = {"threshold_ma": "half_ma"}
"""Names in the report, where "threshold" is that of `THRESHOLD_SHARE`."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordingIdentified:
    """Model of a recording's patient, with the results of the identification."""

    model: PatientModel
    identified: Identified

    def report(self) -> dict[str, Any]:
        """Report as plain tables: fit on held-out samples, thresholds and curves."""
        model, identified = self.model, self.identified
        curves = model.model.recruitment
        assert curves is not None
        allocation = Allocation(recruitment=curves, current_ma=model.current_ma, width_max_us=1e6)
        widths = allocation.stimulation(np.full(len(model.current_ma), THRESHOLD_SHARE))[:, 1]
        names = model.electrodes or ("",) * len(model.current_ma)
        channels = [
            {"electrode": names[c], "current_ma": model.current_ma[c], "threshold_us": 1e6 * float(widths[c]),
             "half_ma": curve.threshold_ma, "spread": curve.spread, "fit_percent": curve.fit_percent,
             "at_bound": {_REPORTED.get(name, name): end for name, end in curve.at_bound.items()},
             "moved_deg": dict(zip(model.outputs, np.degrees(curve.moved).tolist(), strict=True))}
            for c, curve in enumerate(identified.curves)]
        return {"patient": model.patient, "outputs": list(model.outputs), "rate": model.rate,
                "order": int(model.model.a.shape[0]), "delay_ms": model.model.delay_ns / 1e6,
                "held_out_s": identified.held_out_s, "fit_percent": identified.fit, "channels": channels,
                "usable": model.usable, "weaknesses": model.weaknesses()}


def identify_recording(
    path: str, *, measured: str = "", method: Method = "subspace", opened_deg: float | None = None
) -> RecordingIdentified | SweepIdentified:
    """Identify the model of a recording's patient.

    Parameters
    ----------
    path: recording with a block of kind `excitation`, or `element_sweep`, from which elements are chosen, too
        (`controllers.identification.elements`); the output of a `safety` block, if there is one, counts as
        the stimulation.
    measured: signal to be predicted; empty: that of the first `synergies` block by name.
    method: method of `controllers.identification.dynamics`.
    opened_deg: flexion of the fingers of the opened hand that elements are chosen for, after a sweep; None:
        that of the shipped grasps.

    Raises InputError for another recording, and the errors of `identify` and `grasp_task`.
    """
    with Recording(path) as recording:
        blocks = recording.experiment["blocks"]
        sweep = _first(blocks, "element_sweep")
        if sweep and not _first(blocks, "excitation"):
            signal = measured or f"{_known(path, blocks, 'synergies', 'give --measured')}.synergies"
            task = grasp_task() if opened_deg is None else grasp_task(opened_deg)
            return identify_sweep(recording, sweep, _first(blocks, "safety") or sweep, signal,
                                  _names(blocks, signal), task=task)
        if opened_deg is not None:
            raise InputError("opened_deg", f"{opened_deg:g}, but {path} is no sweep over elements",
                             "a recording of sweep_grasp", "leave it out")
        excitation = _known(path, blocks, "excitation", "run identify_grasp, identify_patient or sweep_grasp")
        source = _first(blocks, "safety") or excitation
        signal = measured or f"{_known(path, blocks, 'synergies', 'give --measured')}.synergies"
        record = read_record(recording, excitation, source, signal, _names(blocks, signal))
        found = identify(record, method=method)
        stimulator, electrodes = _first(blocks, "stimulator"), _first(blocks, "electrodes")
        choice = recording.experiment.get("patient")
        model = PatientModel(
            patient=describe(choice) if choice else "",
            patient_fingerprint=patient_fingerprint(choice) if choice else "",
            source=f"{recording.name} {recording.fingerprint[:12]} {signal}", outputs=record.outputs,
            electrodes=electrodes_in_words(blocks[stimulator] if stimulator else None, record.channels),
            arrays=arrays_in_words(blocks[electrodes] if electrodes else None),
            current_ma=tuple(round(value, 9) for value in found.current_ma), rate=blocks[excitation]["rate"],
            plant=hand_plant(blocks), model=found.model, operating_drive=found.operating_drive,
            operating_outputs=found.operating_outputs,
            fit={**found.fit, RECRUITMENT: {f"channel {number}": curve.fit_percent
                                            for number, curve in enumerate(found.curves)}})
    return RecordingIdentified(model=model, identified=found)


def read_record(recording: Recording, excitation: str, source: str, measured: str,
                outputs: tuple[str, ...]) -> IdentificationRecord:
    """Read trial 0 on the ticks of the excitation, with measurements interpolated between their captures."""
    period_s = RateClock.from_rate(recording.experiment["blocks"][excitation]["rate"]).period_s
    phase = recording.signal(f"{excitation}.phase")
    pulses = recording.signal(f"{source}.stimulation")
    if not np.array_equal(pulses.times_ns, phase.times_ns):
        raise InputError(f"{recording.path}: {source}", f"does not tick with {excitation}", "the same rate")
    seen = recording.signal(measured)
    if seen.values.ndim != 2:
        raise InputError(f"{recording.path}: {measured}", f"has shape {seen.values.shape[1:]}", "a vector")
    captured, newest = np.unique(seen.newest_ns, return_index=True)
    known = captured >= 0
    if known.sum() < 2:
        raise InputError(f"{recording.path}: {measured}", "has no captured samples",
                         "samples of the whole run")
    times = captured[known] / NS_PER_S
    columns = seen.values[newest[known]].T
    values = np.stack([np.interp(pulses.times_ns / NS_PER_S, times, column) for column in columns], axis=1)
    names = outputs or tuple(f"{measured}[{i}]" for i in range(values.shape[1]))
    return IdentificationRecord(period_s=period_s, stimulation=pulses.values, measured=values,
                                phase=phase.values, outputs=names)


def _known(path: str, blocks: Mapping[str, Any], kind: str, remedy: str) -> str:
    """Name of the first block of a kind; raises InputError if there is none."""
    found = _first(blocks, kind)
    if not found:
        raise InputError(path, f"has no block of kind {kind!r}", ", ".join(sorted(blocks)), remedy)
    return found


def _first(blocks: Mapping[str, Any], kind: str) -> str:
    return next((name for name in sorted(blocks) if blocks[name]["kind"] == kind), "")


def _names(blocks: Mapping[str, Any], signal: str) -> tuple[str, ...]:
    """Names of a vector's elements, if its block has them."""
    table = blocks.get(signal.partition(".")[0], {})
    return tuple(table["rows"]) if table.get("kind") == "synergies" else ()

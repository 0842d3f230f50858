"""Summary of a recording of stimulated muscle, and doubts about it."""

from __future__ import annotations

from typing import Any

import numpy as np

from fesloop.models.evoked_torque import UNDER_ELECTRODES
from fesloop.streams.stimulation.recording import SAME_PULSES, SteadyTrials, StimulationRecording

_STUCK_SHARE = 0.3
"""Share of trials that read what the trial before read, above which friction hides torque (chosen)."""
_FAR = 15.0
"""Robust standard deviations beyond which a trial is an outlier (chosen: 3,112 trials of five people are
within 11)."""
_LIKE_RADIANS_DEG = 2.5
"""Greatest angle of several postures below which angles look like radians called degrees (chosen: postures
differ by 10 deg at the least)."""


def summary_of(recording: StimulationRecording) -> dict[str, Any]:
    """Content of a recording in plain values.

    Of isometric trials: number of trials, postures, visits, repeats of a muscle in a posture by the same
    pulses (fewest, most), passive trials, minutes; by joint `sd_nm` of a repeat, `rms_nm` of the evoked
    torque and their ratio `snr` (`SteadyTrials.repeatability`; None where nothing was repeated).
    """
    found: dict[str, Any] = {
        "person": recording.person, "side": recording.side, "source": recording.source,
        "source_format": recording.source_format, "muscles": list(recording.muscles),
        "joints": list(recording.joints), "frequency_hz": recording.frequency_hz,
        "courses": len(recording.courses), "movements": len(recording.movements),
        "forces": len(recording.forces)}
    trials = recording.steady
    if trials is not None:
        counts = [len(rows) for rows in trials.repeats()]
        scatter = trials.repeatability()
        found["steady"] = {
            "trials": len(trials), "passive": int((~trials.stimulated).sum()),
            "postures": int(np.unique(trials.posture).size), "visits": int(np.unique(trials.visit).size),
            "muscles": [recording.muscles[m] for m in np.unique(trials.muscle[trials.stimulated])],
            "repeats": [min(counts, default=0), max(counts, default=0)], "baseline": trials.baseline,
            "minutes": _plain(np.ptp(trials.time_s) / 60.0),
            **{name: dict(zip(recording.joints, map(_plain, values), strict=True))
               for name, values in (("sd_nm", scatter.sd_nm), ("rms_nm", scatter.rms_nm),
                                    ("snr", scatter.snr))}}
    return found


def _plain(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def doubts_about(recording: StimulationRecording) -> dict[str, str]:
    """Sentences on what a recording cannot show, or may have wrong, by a short name."""
    found: dict[str, str] = {}
    trials = recording.steady
    if trials is None:
        return found
    unknown = [name for name in recording.muscles if name not in UNDER_ELECTRODES]
    if unknown:
        found["unknown_muscles"] = (
            f"names muscles that `fesloop identify` refuses: {', '.join(unknown)}; it knows "
            f"{', '.join(UNDER_ELECTRODES)}: rename them, if they are among these")
    postures, counts = np.unique(trials.posture).size, [len(rows) for rows in trials.repeats()]
    if postures == 1:
        found["one_posture"] = "has one posture: it cannot show how torque changes with posture"
    elif np.abs(trials.reference_rad).max(initial=0.0) < np.radians(_LIKE_RADIANS_DEG):
        found["small_angles"] = (
            f"has {postures} postures within {np.degrees(np.abs(trials.reference_rad).max()):.2g} deg of 0: "
            "angles look like radians that are called degrees")
    if max(counts, default=0) < 2:
        found["no_repeats"] = ("repeats no muscle in any posture by the same pulses: the scatter of a "
                               "repeat is not known")
    if trials.baseline == "visit_median":
        visits, sizes = np.unique(trials.visit, return_counts=True)
        short = visits[sizes < 5]
        if short.size:
            found["short_visits"] = (
                f"has {short.size} visits of fewer than 5 trials: their median holds much of what muscles "
                "do; where each has a passive trial, baseline = \"passive\" is better")
    stuck = _stuck_share(recording)
    held = [f"{joint} {share:.2f}" for joint, share in zip(recording.joints, stuck, strict=True)
            if share > _STUCK_SHARE]
    if held:
        found["stuck"] = ("reads in many trials what the trial before read (share: " + ", ".join(held)
                          + "): dry friction of the device hides torque")
    rms = trials.repeatability().rms_nm
    hidden = [f"{joint} {size:.2g} of {friction:.2g} N m" for joint, size, friction
              in zip(recording.joints, rms, recording.friction_nm, strict=True) if size < friction]
    if hidden:
        found["within_friction"] = ("evokes less torque than the device's dry friction ("
                                    + ", ".join(hidden) + "): much of it does not show")
    found |= _outliers(recording, trials) | _other_pulses(recording, trials)
    return found


def _outliers(recording: StimulationRecording, trials: SteadyTrials) -> dict[str, str]:
    """Torques that are far from those of their repeats."""
    evoked, away = trials.evoked_nm, np.zeros_like(trials.device_torque_nm)
    for rows in trials.repeats():
        away[rows] = evoked[rows] - np.median(evoked[rows], axis=0)
    # Not the median, which is near 0 where friction holds many trials.
    spread = np.quantile(np.abs(away[trials.stimulated]), 0.9, axis=0) / 1.645
    far = np.abs(away) > _FAR * np.where(spread > 0.0, spread, np.inf)
    if not far.any():
        return {}
    row, j = np.unravel_index(int(np.argmax(np.where(far, np.abs(away), 0.0))), far.shape)
    return {"outliers": (
        f"has {int(far.any(axis=1).sum())} trials whose torque is far from that of their repeats, such as "
        f"{evoked[row, j]:+.3g} N m of {recording.joints[j]} for {recording.muscles[trials.muscle[row]]} in "
        f"posture {trials.posture[row]}, visit {trials.visit[row]}: leave them out if they are faults")}


def _other_pulses(recording: StimulationRecording, trials: SteadyTrials) -> dict[str, str]:
    """Muscles whose pulses differ between trials, or are not those that are stated as usable."""
    various, beyond = [], []
    for number, name in enumerate(recording.muscles):
        here = trials.muscle == number
        if not here.any():
            continue
        if np.unique(trials.stimulus[here]).size > 1:
            various.append(name)
        low, high = recording.lowest_width_s[number], recording.highest_width_s[number]
        widths = trials.pulse_width_s[here]
        if widths.max() > (1.0 + SAME_PULSES) * high or widths.min() < (1.0 - SAME_PULSES) * low:
            beyond.append(f"{name} ({1e6 * widths.min():.0f} to {1e6 * widths.max():.0f} us)")
    found = {}
    if various:
        found["various_pulses"] = (
            f"stimulates {', '.join(various)} by pulses that differ between trials: those of the same pulses "
            "alone are repeats, and the torque of a posture is the mean of all")
    if beyond:
        found["other_widths"] = ("has pulse widths outside those stated as usable: "
                                 + ", ".join(beyond) + ": check the unit")
    return found


def _stuck_share(recording: StimulationRecording) -> list[float]:
    """Share of trials by joint whose torque changes by less than 2 % of the sd of changes in a visit."""
    trials = recording.steady
    assert trials is not None
    rows = np.lexsort((trials.order, trials.visit))
    change = np.abs(np.diff(trials.device_torque_nm[rows], axis=0))[np.diff(trials.visit[rows]) == 0]
    if not len(change):
        return [0.0] * len(recording.joints)
    return [float((each < 0.02 * each.std()).mean()) if each.std() > 0.0 else 0.0 for each in change.T]

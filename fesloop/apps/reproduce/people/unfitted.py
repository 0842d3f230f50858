"""Unfitted members of the virtual patient in the experiment of the recorded people: torque at a held wrist.

Members of the preset `able_bodied` have single surface pads over muscles of the wrist, with the current and
pulse width of a recorded person. Their wrist is held in that person's postures; torque is the change of the
muscles' moments, at rest and at the steady activation of the pulses. The visits of the recording are played
in their order, through the dry friction of the device, and both recorded and simulated torques are taken
relative to the median of their visit (`SteadyTrials.as_evoked`). The elbow is not part of the hand's model:
its muscles evoke nothing, and its posture changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.people.pads import Forearm, HeldWrist, Pads
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.evoked import recordings
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Sweep
from fesloop.experiment.registry import patient_reader
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_responses import FRICTION_NM
from fesloop.models.dry_friction import play
from fesloop.streams.stimulation import StimulationRecording

Array = NDArray[np.float64]
PRESET, COHORT, MEMBERS, FEWER = "able_bodied", 1, 100, 20
AXES = ("wrist_flexion", "wrist_radial_deviation")
FACTOR, SPREAD_FACTOR, LEAST_CHANGE = 2.0, 1.5, 0.3
"""Bars: of mean flexion, of the spread between people, and of the change with posture over the mean."""
BARRED = ("FCR", "PL", "ECRL")
"""Muscles with bars: three people have FCU, and its torque is within the scatter of repeats."""


class Evoked(NamedTuple):
    """Evoked torque at the wrist of one person, (electrodes, 2), N m, flexion and radial deviation.

    NaN for electrodes without trials.

    Attributes
    ----------
    mean: over postures.
    change: standard deviation over postures, less what the scatter of repeats adds to it.
    by_posture: (electrodes, 8, 2), mean of the repeats, over the elbow's angles, by posture of `shown`.
    recruited: (electrodes, 29), recruitment of all muscles, mean of the trials; NaN in people.
    """

    mean: Array
    change: Array
    by_posture: Array
    recruited: Array


def postures_shown() -> list[tuple[int, int, int]]:
    """Signs of forearm pronation, wrist flexion and radial deviation of the held postures."""
    return [(f, w, r) for f in (-1, 1) for w in (-1, 1) for r in (-1, 1)]


def evoked_of(recording: StimulationRecording, evoked_nm: Array, electrodes: Sequence[str],
              recruited: Array | None = None) -> Evoked:
    """Reduce evoked torque (trials, 2) at the wrist to means and changes with posture, by electrode."""
    steady = recording.steady
    assert steady is not None
    cells = steady.cells()
    shape = (len(electrodes), len(AXES))
    mean, change = np.full(shape, np.nan), np.full(shape, np.nan)
    by_posture = np.full((len(electrodes), len(postures_shown()), len(AXES)), np.nan)
    joints = [recording.joints.index(name) for name in ("forearm_pronation", *AXES)]
    for number, electrode in enumerate(electrodes):
        rows = [each for (m, _), each in cells.items() if recording.muscles[m] == electrode]
        if not rows:
            continue
        each = np.array([evoked_nm[cell].mean(axis=0) for cell in rows])
        noise = np.mean([evoked_nm[cell].var(axis=0, ddof=1) / len(cell) for cell in rows if len(cell) > 1]
                        or [np.zeros(len(AXES))], axis=0)
        mean[number] = each.mean(axis=0)
        change[number] = np.sqrt(np.maximum(each.var(axis=0, ddof=1) - noise, 0.0))
        signs = [tuple(np.sign(steady.reference_rad[cell[0], joints]).astype(int)) for cell in rows]
        for place, shown in enumerate(postures_shown()):
            here = [row for row, sign in zip(each, signs, strict=True) if sign == shown]
            if here:
                by_posture[number, place] = np.mean(here, axis=0)
    missing = np.full((len(electrodes), len(MUSCLES)), np.nan)
    return Evoked(mean, change, by_posture, missing if recruited is None else recruited)


def simulated(recording: StimulationRecording, number: int, pads: Pads) -> Evoked:
    """Evoked torque of a member in the trials of a recorded person."""
    steady = recording.steady
    assert steady is not None
    patient = patient_reader().load(PRESET).member(cohort=COHORT, number=number)
    forearm = Forearm(patient, pads, np.random.default_rng([COHORT, number]))
    wrist, electrodes = HeldWrist(patient), list(pads.muscles)
    torque = np.zeros((len(steady), len(AXES)))
    recruited = np.full((len(electrodes), len(steady), len(MUSCLES)), np.nan)
    angles = steady.reference_rad[:, [recording.joints.index(n) for n in ("forearm_pronation", *AXES)]]
    known: dict[tuple[float, ...], tuple[Array, Array]] = {}
    at_wrist: dict[tuple[float, ...], Array] = {}
    for trial in np.flatnonzero(steady.stimulated).tolist():
        name = recording.muscles[steady.muscle[trial]]
        if name not in electrodes:
            continue
        pronation, flexion, radial = angles[trial].tolist()
        electrode = electrodes.index(name)
        given = (electrode, float(steady.current_a[trial]), float(steady.pulse_width_s[trial]), pronation)
        if given not in known:
            found, hertz = forearm.recruitment(*given[:3], recording.frequency_hz, pronation)
            known[given] = found, wrist.activation(found, hertz)
        recruited[electrode, trial], activation = known[given]
        if (*given, flexion, radial) not in at_wrist:
            at_wrist[*given, flexion, radial] = wrist.torque_nm(activation, flexion, radial)
        torque[trial] = at_wrist[*given, flexion, radial]
    shares = np.array([each[np.isfinite(each[:, 0])].mean(axis=0) if np.isfinite(each).any()
                       else np.full(len(MUSCLES), np.nan) for each in recruited])
    evoked = steady.as_evoked(passed(torque, steady.visit, steady.order))
    return evoked_of(recording, evoked, electrodes, shares)


def passed(torque_nm: Array, visit: NDArray[np.int64], order: NDArray[np.int64]) -> Array:
    """Torque (trials, 2) that passes the device's dry friction at the wrist.

    Trials of a visit follow each other; each begins with a ramp of pulse widths, in which the torque of the
    one before has gone (chosen: it falls faster than the ramp rises). A visit begins in the middle of the
    friction.
    """
    friction = np.array([FRICTION_NM[JOINTS.index(name)] for name in AXES])
    out = np.empty_like(torque_nm)
    for number in np.unique(visit):
        rows = np.flatnonzero(visit == number)
        rows = rows[np.argsort(order[rows])]
        course = np.zeros((2 * len(rows), torque_nm.shape[1]))
        course[1::2] = torque_nm[rows]
        out[rows] = play(course, friction, np.zeros(len(friction)))[1::2]
    return out


def members(people: Sequence[StimulationRecording], pads: Pads, count: int = MEMBERS) -> Iterator[Evoked]:
    """Members, each with the settings and in the postures of one of the people, in turn."""
    for number in range(count):
        yield simulated(people[number % len(people)], number, pads)


def part(folder: Path, random_people: int) -> Part:
    """Rows of members beside people, and torques for figures."""
    pads = Pads()
    people = recordings(folder)
    theirs = [evoked_of(each, _wrist(each), list(pads.muscles)) for each in people]
    found = compared(theirs, list(members(people, pads)), pads)
    return Part(found.rows, {**found.sweeps, "unfitted_pads": _other_pads(people, theirs)}, found.curves)


def _other_pads(people: Sequence[StimulationRecording], theirs: Sequence[Evoked]) -> Sweep:
    """Mean flexion over that of people with other pads than the chosen ones, of fewer members."""
    usual, names = Pads(), list(Pads().muscles.values())
    tried = {f"{FEWER} members": usual,
             **{f"pads of {mm:g} mm radius": replace(usual, radius_mm=mm)
                for mm in (usual.radius_mm - 2.0, usual.radius_mm + 2.0)},
             **{f"placed within {mm:g} mm": replace(usual, error_mm=mm)
                for mm in (0.5 * usual.error_mm, 1.5 * usual.error_mm)}}
    barred = [names.index(name) for name in BARRED]
    known = _over(np.mean, [each.mean for each in theirs])[barred, 0]
    rows = []
    for label, pads in tried.items():
        ours = _over(np.mean, [each.mean for each in members(people, pads, FEWER)])[barred, 0]
        rows.append((label, tuple((ours / known).tolist())))
    return Sweep(title="unfitted members with other pads: mean flexion over that of people", unit="1",
                 columns=BARRED, rows=tuple(rows))


def _wrist(recording: StimulationRecording) -> Array:
    assert recording.steady is not None
    return recording.steady.evoked_nm[:, [recording.joints.index(name) for name in AXES]]


def compared(theirs: Sequence[Evoked], ours: Sequence[Evoked], pads: Pads) -> Part:
    """Rows, recruitment and curves of two groups of people; muscles that nobody has get no rows."""
    names, scatter = list(pads.muscles.values()), partial(np.std, ddof=1)
    their_mean, our_mean = (_over(np.mean, [each.mean for each in group]) for group in (theirs, ours))
    their_sd, our_sd = (_over(scatter, [each.mean for each in group], 2) for group in (theirs, ours))
    their_change, our_change = (_over(np.mean, [each.change for each in group]) for group in (theirs, ours))
    shares = _over(np.mean, [each.recruited for each in ours])
    with np.errstate(divide="ignore", invalid="ignore"):  # members may evoke nothing at all
        ratio, spread = our_mean / their_mean, our_sd[:, 0] / their_sd[:, 0]
        change, their_share = (each[:, 0] / np.abs(mean[:, 0]) for each, mean in (
            (our_change, our_mean), (their_change, their_mean)))
        radial, their_radial = (np.abs(mean[:, 1] / mean[:, 0]) for mean in (our_mean, their_mean))
    table = f"{len(ours)} unfitted members of {PRESET}, wrist held, currents and widths of people"
    rows = []
    for m, name in enumerate(names):
        if not np.isfinite(their_mean[m]).all():
            continue
        barred = name in BARRED
        for j, axis in enumerate(("flexion", "radial deviation")):
            judged = barred and j == 0
            rows.append(Row(
                table, f"{name}: {axis}, mean (sd over people)",
                f"{their_mean[m, j]:+.3f} ({their_sd[m, j]:.3f}); "
                + (f"within a factor {FACTOR:g}" if judged else "no bar"),
                f"{our_mean[m, j]:+.3f} ({our_sd[m, j]:.3f}), ratio {ratio[m, j]:.2f}",
                bool(not judged or 1.0 / FACTOR <= ratio[m, j] <= FACTOR), "N m"))
        if not barred:
            continue
        rows.append(Row(table, f"{name}: flexion, sd over postures over mean",
                        f"{their_share[m]:.2f}; {LEAST_CHANGE:g} or more", f"{change[m]:.2f}",
                        bool(change[m] >= LEAST_CHANGE), "1"))
        if np.isfinite(their_sd[m, 0]):
            rows.append(Row(table, f"{name}: flexion, sd over people, ours over theirs",
                            f"1 within a factor {SPREAD_FACTOR:g}", f"{spread[m]:.2f}",
                            bool(1.0 / SPREAD_FACTOR <= spread[m] <= SPREAD_FACTOR), "1"))
        if name == "ECRL":
            rows.append(Row(table, f"{name}: radial deviation over flexion, sizes",
                            f"{their_radial[m]:.2f}; 1 or less", f"{radial[m]:.2f}",
                            bool(radial[m] <= 1.0), "1"))
    sweep = Sweep(title="recruitment of the muscle under the pad, and of the three others recruited most",
                  unit="1", columns=("under the pad", "first other", "second", "third"), rows=tuple(
                      _neighbours(name, shares[m]) for m, name in enumerate(names)))
    curves = {"muscles": names, "postures": postures_shown(), "axes": AXES,
              "theirs_nm": np.array([each.mean for each in theirs]),
              "ours_nm": np.array([each.mean for each in ours]),
              "theirs_by_posture_nm": np.array([each.by_posture for each in theirs]),
              "ours_by_posture_nm": np.array([each.by_posture for each in ours])}
    return Part(rows, {"unfitted_recruitment": sweep}, {"unfitted": curves})


def _over(of: Callable[..., Any], values: Sequence[Array], least: int = 1) -> Array:
    """Statistic by electrode over those people who have trials of it; NaN of fewer than `least`."""
    every = np.array(values)
    columns = (each[np.isfinite(each).all(axis=1)] for each in every.swapaxes(0, 1))
    return np.array([of(each, axis=0) if len(each) >= least else np.full(each.shape[1], np.nan)
                     for each in columns])


def _neighbours(name: str, shares: Array) -> tuple[str, tuple[float, ...]]:
    others = [k for k in np.argsort(-shares).tolist() if k != muscle(name)][:3]
    return (f"{name} ({', '.join(MUSCLES[k] for k in others)})",
            (float(shares[muscle(name)]), *(float(shares[k]) for k in others)))

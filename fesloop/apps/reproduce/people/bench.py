"""Courses of torque of held arms under steps and trains, and recruitment: random people in the same device.

Random people go through the experiment `arm_bench`: the protocol of the recordings, the chain of that
laboratory, its device's friction. The reading's noise is that of the recorded course at rest, in its first
second, over and over: it decides which responses are clear. Simulated courses are reduced by the function
that reduces the recorded ones. A recorded course is answered by people of the population without the person
whom it is of, each at their own usable pulse widths and the recorded current.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend
from scipy.stats import norm

from fesloop.analysis.people.courses import CourseFit, StepResponse, fits_of, step_responses, widths_of
from fesloop.analysis.people.identify import save
from fesloop.analysis.people.population import ArmPopulation
from fesloop.apps.reproduce.cohort import Job, Kept
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.evoked import people_of
from fesloop.apps.reproduce.people.part import Part
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.muscle_paths import JOINTS
from fesloop.loop.clock import NS_PER_S
from fesloop.models.arm_people import ArmPerson
from fesloop.models.arm_responses import (
    CHAIN_S,
    DELAY_UNIT_S,
    ArmResponse,
    ArmResponses,
    chronaxie_s,
    effective_a,
)
from fesloop.models.evoked_torque import UNDER_ELECTRODES, Weights
from fesloop.streams.stimulation import StimulationRecording, TorqueCourse, open_stimulation

Array = NDArray[np.float64]
PEOPLE_A_COURSE = 10
THREAD_S = 0.05
"""Period of the thread that sends pulse widths: a protocol begins at any place in it."""
REST_S = 0.95
"""Time before the first step, in which a recorded course is at rest."""
DELAY_S, ELBOW_RISE_S = (0.126, 0.153), (0.112, 0.140)
"""Quartiles of 99 and of all elbow responses of seven people."""
SPREAD, THRESHOLD_MA, LEAST_RECRUITED = (0.10, 0.31), (1.7, 7.0), 0.5
"""Published recruitment: quartiles of 18 fits; range over 38 muscles of the lowest usable effective current
at a chronaxie of 200 us; and what the highest usable width recruits at least."""
THRESHOLD_SD = {"people": 0.18, "muscles": 0.35}
"""Standard deviations of the logarithm of that current."""
FACTOR = 1.5
COVERED = (0.80, 0.97)
_USUAL_S = 200e-6
RAMP_S = 3.0
"""Stretches of stimulation longer than this are ramps up and down (4 s), others steps and trains."""
SHOWN = (0.4, 1.35)
"""Effective currents of curves, over the highest recorded one (chosen)."""


def part(folder: Path, random_people: int) -> Part:
    """Rows of dynamics and recruitment."""
    paths = [path for path in sorted(folder.glob("S*.npz")) if "_" not in path.stem]
    people = [each for each in map(open_stimulation, paths) if each.courses]
    theirs = [answer for each in people for course in each.courses for answer in step_responses(course)]
    ours = [answer for course in simulated(people, people_of(folder)[1]) for answer in step_responses(course)]
    return Part([*dynamic_rows(theirs, ours), *recruitment_rows(people, random_people)], {},
                {"recruitment": recruitment_curves(people, random_people)})


def simulated(people: Sequence[StimulationRecording], by_person: dict[str, ArmPopulation]
              ) -> Iterator[TorqueCourse]:
    """Courses of random people, `PEOPLE_A_COURSE` for each recorded one."""
    shipped, everyone = ArmPopulation.shipped(), ArmResponses.shipped()
    with TemporaryDirectory(prefix="fesloop-") as folder:
        for number, each in enumerate(people):
            population = by_person.get(each.person, shipped)
            others = everyone.without([each.person])
            rng = np.random.default_rng([number])
            for course in each.courses:
                electrode = each.muscles[course.muscle]
                for _ in range(PEOPLE_A_COURSE):
                    plain = _ran(electrode, course.current_a, population.stranger(rng),
                                 others.drawn((electrode,), rng), Path(folder), rng)
                    yield replace(plain, device_torque_nm=plain.device_torque_nm + noise(
                        course, len(plain.pulse_width_s), rng))


def noise(course: TorqueCourse, samples: int, rng: np.random.Generator) -> Array:
    """Noise (samples, joints) of a recorded reading at rest, without its trend, from a random place on."""
    rest = course.device_torque_nm[:round(REST_S / course.period_s)]
    left = detrend(rest[np.isfinite(rest).all(axis=1)], axis=0)
    return np.asarray(left[(rng.integers(len(left)) + np.arange(samples)) % len(left)])


def _ran(electrode: str, current_a: float, person: ArmPerson, response: ArmResponse, folder: Path,
         rng: np.random.Generator) -> TorqueCourse:
    """Course of one random person at the widths of their own."""
    weights = person.weights[electrode]
    drawn = Weights(weights.drawn(rng), weights.covariance)
    save(ArmPerson("random", person.spreads, person.scale_nm, {electrode: drawn}, ()), folder / "person.json")
    times, widths = protocol(response, current_a, rng)
    settings = (
        f"blocks.arm.electrodes={[electrode]}", f'person={{file = "{folder / "person.json"}"}}',
        f"blocks.arm.delay_ms={1e3 * response.delay_s}",
        f"blocks.arm.activation_rad_s={response.frequency_rad_s}",
        f"blocks.arm.threshold_ma={response.threshold_ma.tolist()}",
        f"blocks.arm.spread={response.spread.tolist()}", f"blocks.arm.highest={response.highest.tolist()}",
        f"current_ma=[[{1e3 * current_a:g}]]", f"blocks.protocol.times_s={times.tolist()}",
        f"blocks.protocol.width_us={(1e6 * widths[:, np.newaxis]).tolist()}")
    kept = Job(("bench",), "arm_bench", settings, 1, _device).kept()
    samples = np.arange(len(kept["torque"])) * kept["period_s"]
    return TorqueCourse(
        name=electrode, muscle=0, current_a=current_a, period_s=kept["period_s"],
        pulse_width_s=np.interp(samples, times, widths), reference_rad=np.zeros(len(JOINTS)),
        stiffness_nm_rad=np.full(len(JOINTS), np.nan), angle_rad=kept["angles"],
        device_torque_nm=kept["torque"])


def _device(recording: Recording) -> Kept:
    """Torque and angles as a device records them."""
    torque = recording.signal("arm.device")
    return {"torque": np.asarray(torque.values), "angles": np.asarray(recording.signal("arm.angles").values),
            "period_s": float(np.diff(torque.times_ns[:2])[0]) / NS_PER_S}


def protocol(response: ArmResponse, current_a: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Instants, s, and widths, s, of the shipped protocol at a person's widths, anywhere in the thread."""
    block: Any = next(node.part for node in load("arm_bench").wiring.nodes if node.name == "protocol")
    widths = np.array(block.width_us)[:, 0]
    share = (widths - widths.min()) / np.ptp(widths)
    low, high = (float(response.pulse_width_s(shares, current_a)[0])
                 for shares in (response.lowest, response.highest))
    times = np.array(block.times_s)
    times[1:] += rng.uniform(0.0, THREAD_S)
    return times, np.asarray(low + share * (high - low))


def _quartiles(answers: Sequence[StepResponse], field: str, shares: Mapping[int, float]) -> tuple[Array, int]:
    """Quartiles (3,) of a field, and how many there are; joints have `shares` of the weight."""
    known = [(each.joint, getattr(each, field)) for each in answers
             if each.joint in shares and np.isfinite(getattr(each, field))]
    if not known:
        return np.full(3, np.nan), 0
    known.sort(key=lambda each: each[1])
    joints, values = (np.array(column) for column in zip(*known, strict=True))
    weights = np.array([shares[joint] / np.count_nonzero(joints == joint) for joint in joints.tolist()])
    places = (np.cumsum(weights) - 0.5 * weights) / weights.sum()
    return np.asarray(np.interp([0.25, 0.5, 0.75], places, values)), len(known)


def dynamic_rows(theirs: Sequence[StepResponse], ours: Sequence[StepResponse]) -> list[Row]:
    """Times of responses: a median of ours holds within its bar, or without one within their quartiles.

    Joints count as often as in the recordings, where which of them answers most clearly depends on who they
    are of.
    """
    table = "steps and trains through the chain: median [quartiles], joints as often as theirs"

    def row(name: str, field: str, joint: int | None, bar: tuple[float, float] | None) -> Row:
        shares = Counter(each.joint for each in theirs
                         if joint in (None, each.joint) and np.isfinite(getattr(each, field)))
        (recorded, many), (found, number) = (_quartiles(side, field, shares) for side in (theirs, ours))
        low, high = (recorded[0], recorded[2]) if bar is None else bar
        unit, scale, digits = ("1", 1.0, 2) if field == "left" else ("ms", 1e3, 0)

        def text(quartiles: Array, count: int) -> str:
            first, middle, last = (f"{scale * each:.{digits}f}" for each in quartiles)
            return f"{middle} [{first}, {last}] of {count}" if count else "-"

        limits = "" if bar is None else f"{scale * low:.0f} to {scale * high:.0f}; "
        return Row(table, name, limits + text(recorded, many), text(found, number),
                   bool(low <= found[1] <= high), unit)

    rows = [row("5 % of torque after the command", "delay_s", None, DELAY_S),
            row("rise from 10 to 90 %, elbow", "rise_s", 0, ELBOW_RISE_S)]
    rows += [row(f"5 % of torque, {joint}", "delay_s", number, None) for number, joint in enumerate(JOINTS)]
    rows += [row(f"rise from 10 to 90 %, {JOINTS[joint]}", "rise_s", joint, None) for joint in (2, 3)]
    return [*rows, row("share left 1.5 s after a step", "left", None, None)]


def recruitment_rows(people: Sequence[StimulationRecording], random_people: int) -> list[Row]:
    """Recruitment of random people, and of each person by the population of the others."""
    responses, electrodes = ArmResponses.shipped(), tuple(UNDER_ELECTRODES)
    rng = np.random.default_rng(0)
    drawn = [responses.drawn(electrodes, rng) for _ in range(random_people)]
    spread, highest = (np.array([getattr(each, name) for each in drawn]) for name in ("spread", "highest"))
    current = 1e-3 * np.array([65.0, 65.0, 45.0, 45.0, 45.0, 45.0, 45.0, 45.0])
    widths = np.array([each.pulse_width_s(each.lowest, current) for each in drawn])
    threshold = 1e3 * effective_a(current, widths, _USUAL_S)
    logs = np.log(threshold)
    found = {"people": float(np.mean(logs.std(axis=0))), "muscles": float(logs.mean(axis=0).std(ddof=1))}
    low, middle, high = np.percentile(threshold, [5.0, 50.0, 95.0])
    quartiles = np.percentile(spread, [25.0, 50.0, 75.0])
    table = f"recruitment of {random_people} random people"
    return [
        Row(table, "spread of ln effective current", ".18, fits .10 to .31",
            f"{quartiles[1]:.2f} [{quartiles[0]:.2f}, {quartiles[2]:.2f}]",
            bool(SPREAD[0] <= quartiles[0] and quartiles[2] <= SPREAD[1]), "1"),
        Row(table, "effective current at the lowest width (5-95 %)",
            f"{THRESHOLD_MA[0]:g} to {THRESHOLD_MA[1]:g}, median 3.1", f"{middle:.1f} ({low:.1f}-{high:.1f})",
            bool(THRESHOLD_MA[0] <= low and high <= THRESHOLD_MA[1]), "mA"),
        *(Row(table, f"sd of its logarithm, {name}", f"{bar:.2f}, within a factor {FACTOR:g}",
              f"{found[name]:.2f}", bool(bar / FACTOR <= found[name] <= bar * FACTOR), "1")
          for name, bar in THRESHOLD_SD.items()),
        Row(table, "recruited at the highest width, median", f"{LEAST_RECRUITED:g} or more",
            f"{np.median(highest):.2f}", bool(np.median(highest) >= LEAST_RECRUITED), "1"),
        _covered(responses, people)]


def recruitment_curves(people: Sequence[StimulationRecording], random_people: int) -> dict[str, Any]:
    """Recruited share over effective current, by electrode with courses that the fit explains.

    Of each: currents `at_ma` (n,), percentiles 5, 50 and 95 of random people in `band` (3, n), and `fits`,
    with the name of the `person`, their `share` (n,), and what the device reads of their `ramps`.
    """
    electrodes, rng = tuple(UNDER_ELECTRODES), np.random.default_rng(0)
    drawn = [ArmResponses.shipped().drawn(electrodes, rng) for _ in range(random_people)]
    threshold, spread = (np.array([getattr(each, name) for each in drawn])
                         for name in ("threshold_ma", "spread"))
    fits = [(fit, course) for person in people for course in person.courses
            for fit in fits_of(replace(person, courses=(course,)))]
    curves = {}
    for number, electrode in enumerate(electrodes):
        mine = [each for each in fits if each[0].response.electrode == electrode]
        if mine:
            highest = max(_effective_ma(electrode, course).max() for _, course in mine)
            at = highest * np.geomspace(*SHOWN, 80)
            shares = _share(at, threshold[:, [number]], spread[:, [number]])
            curves[electrode] = {
                "at_ma": at, "band": np.percentile(shares, [5.0, 50.0, 95.0], axis=0),
                "fits": [{"person": fit.response.person, "ramps": ramps(fit, course),
                          "share": _share(at, fit.response.threshold_ma, fit.response.spread)}
                         for fit, course in mine]}
    return curves


def ramps(fit: CourseFit, course: TorqueCourse) -> dict[str, Array]:
    """Mean of the ramps of a course: effective current, mA, and what the device reads, N m, also fitted.

    Torque is positive in the muscle's direction, relative to that before a ramp, and later than the current
    by the fitted lag. NaN for a course without ramps.
    """
    response, period = fit.response, course.period_s
    lag = (CHAIN_S + response.delay_s + 2.0 / response.frequency_rad_s) / period
    at = _effective_ma(response.electrode, course)[np.maximum(fit.places - round(lag), 0)]
    lasts = np.ptp(np.where(np.isfinite(fit.seen_nm), fit.places, fit.places[:, :1]), axis=1)
    long = lasts * period > RAMP_S
    if not long.any():
        return {name: np.full(1, np.nan) for name in ("at_ma", "theirs_nm", "ours_nm")}
    whole = np.isfinite(fit.seen_nm[long]).all(axis=0)
    theirs, ours = (np.sign(fit.gain_nm) * (each[long] - each[long, :1])
                    for each in (fit.seen_nm, fit.fitted_nm))
    return {"at_ma": at[long][:, whole].mean(axis=0), "theirs_nm": theirs[:, whole].mean(axis=0),
            "ours_nm": ours[:, whole].mean(axis=0)}


def _effective_ma(electrode: str, course: TorqueCourse) -> Array:
    return 1e3 * effective_a(course.current_a, course.pulse_width_s, chronaxie_s(electrode))


def _share(at_ma: Array, threshold_ma: Array | float, spread: Array | float) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(norm.cdf(np.log(at_ma / threshold_ma) / spread))


def _covered(responses: ArmResponses, people: Sequence[StimulationRecording]) -> Row:
    """Row of each person's response by the population of the others: shares in 90 % intervals."""
    times = norm.ppf(0.95)
    inside = []
    for name, group in groupby(responses.estimates, lambda each: each.response.person):
        others = responses.without([name])
        pools = (others.delay, others.log_frequency, others.highest, others.log_spread)
        for each in group:
            values = (each.response.delay_s / DELAY_UNIT_S, np.log(each.response.frequency_rad_s),
                      each.response.highest, np.log(each.response.spread))
            errors = (each.sd[0] / DELAY_UNIT_S, *each.sd[1:])
            for value, pool, sd in zip(values, pools, errors, strict=True):
                mean, unknown = pool.of(each.response.electrode)
                total = np.sqrt(pool.between**2 + pool.within**2 + unknown**2 + sd**2)
                inside.append(abs(value - mean) <= times * total)
    for person in people:
        others = responses.without([person.person])
        pool = others.widths_pool
        inside += [abs(each.log_highest - others.log_highest[each.electrode])
                   <= times * np.hypot(pool.between, pool.within)
                   for each in widths_of(person) if each.electrode in others.log_highest]
    share = float(np.mean(inside))
    return Row("a person's response from the others", "numbers in the 90 % interval",
               f"{COVERED[0]:.2f} to {COVERED[1]:.2f}", f"{share:.2f} of {len(inside)}",
               COVERED[0] <= share <= COVERED[1], "1")

"""A virtual patient with the muscles of a recorded person: strength, thresholds, delay, speed, variation.

A person's evoked torque (`ArmPerson`) is that of an arm in a device. A patient is muscles, nerves and a hand.
Both meet where pads over FCR, PL, FCU and ECRL flex or extend a held wrist: there the torque of the preset's
random members (`pads`), as a device with dry friction reads it, is compared with the recorded one.

Of each muscle, u is the logarithm of its strength and v of its threshold, relative to the preset. Both are
the sum of what is common to all muscles and of the muscle's own, normal with the spreads of the preset's
[cohort]. The likelihood of a recorded mean torque y is averaged over members, who have places of pads and
motor points, axons, chronaxies and hands of their own:

    p(y | u, v) = mean over members of N(y; friction(exp(u) T(v)), (sd of y)^2 + (SESSION y)^2)

where a higher threshold acts as a lower current, and a share ODD of any torque is due to none of them. It is
summed on a grid, without further approximation. The
posterior's means and standard deviations are the patient's factors and spreads: one torque tells little about
strength and threshold apart, and the spreads say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from fesloop.analysis.people.courses import fits_of
from fesloop.analysis.people.identify import BASELINES
from fesloop.analysis.people.pads import Forearm, HeldWrist, Pads
from fesloop.analysis.people.population import trials_of
from fesloop.analysis.people.scatter import Scatter, repeats_of, scatter_of, simulated
from fesloop.errors import InputError
from fesloop.experiment.registry import Patient, patient_reader
from fesloop.forms.toml import toml_text
from fesloop.hand.movements import MUSCLES
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_people import ArmPerson
from fesloop.models.arm_responses import DELAY_UNIT_S, FRICTION_NM, ArmResponses, Pool
from fesloop.models.evoked_torque import Postures, features
from fesloop.streams.stimulation import StimulationRecording

Array = NDArray[np.float64]
PRESET = "able_bodied"
MEMBERS = 150
"""Random members over whom the likelihood is averaged (chosen: twice as many move means by a tenth of an
sd)."""
SESSION = 0.25
"""Standard deviation of a session's torque over its mean (chosen: in five people the third repeat of a
posture has .74 to 1.38 times the torque of the first)."""
ODD = 0.05
"""Probability that an electrode's torque is not that of a pad near its muscle (chosen): what no member has,
such as nothing at strong pulses, changes the patient little."""
VARIATION_LOG_SD, SIMULATED = 0.2, 12
"""Spread between people of the logarithm of variation between trials (five people: .25, less the errors of
single estimates), and simulations of a recording that state such an error."""
USUAL = 0.1
"""Recruitment at which torque over recruitment is taken: with tendons that yield it depends on it, by 3 %."""
SPAN, PLACES = 3.5, 29
"""Standard deviations to either side, and number of places, of each grid (chosen)."""
MOST, MOST_CONTRARY = 10.0, 1.0
"""Recorded over expected torque, of its sign and of the other one, beyond which something other than a person
is the cause (chosen). There is no least: some members evoke nothing, and so do some people."""
SURE = 2.0
"""Standard deviations beyond which a torque is sure."""
WITHIN = float(norm.ppf(0.95))
"""Standard deviations to either side of an interval of 90 %."""
_LEAST = 1e-6
_FLEXION = JOINTS.index("wrist_flexion")


class Factor(NamedTuple):
    """Mean and standard deviation of the logarithm of a factor on the preset."""

    mean: float
    sd: float


class MuscleFactors(NamedTuple):
    """One recorded muscle beside the preset's.

    Attributes
    ----------
    muscle, electrode: names.
    torque_nm, sd_nm: recorded wrist flexion, mean over postures.
    own_nm: that of the patient in the file, without members, at the same settings, pads over motor points.
    expected_nm: mean of the preset's members at the same settings. stranger_nm: their 90 % interval.
    strength, threshold: factors on the preset's, those common to all muscles included.
    """

    muscle: str
    electrode: str
    torque_nm: float
    sd_nm: float
    own_nm: float
    expected_nm: float
    stranger_nm: tuple[float, float]
    strength: Factor
    threshold: Factor


class OwnPatient(NamedTuple):
    """A person's patient.

    Attributes
    ----------
    tables: of the patient's file.
    muscles: the recorded ones.
    strength, threshold: factors common to all muscles.
    notes: what is the person's and what the preset's, in words.
    baseline: what the recorded torques of `muscles` are over, in words.
    """

    tables: dict[str, Any]
    muscles: list[MuscleFactors]
    strength: Factor
    threshold: Factor
    notes: list[str]
    baseline: str


class _Seen(NamedTuple):
    """A recorded electrode: mean flexion and its variance, and how it was stimulated.

    Attributes
    ----------
    muscle, electrode: names. number: of the pad.
    torque_nm, variance: of the mean over trials.
    settings: (n, 5), distinct current, A, width, s, pronation, flexion, radial deviation, rad.
    weights: (n,), share of the trials that have them.
    """

    muscle: str
    electrode: str
    number: int
    torque_nm: float
    variance: float
    settings: Array
    weights: Array


def own_patient(recording: StimulationRecording, person: ArmPerson) -> OwnPatient:
    """Make the patient of a person from the recording that the person was identified from.

    Raises InputError for a recording without wrist flexion or muscles of the wrist, and for torque that no
    patient of the preset's kind has.
    """
    preset, pads = patient_reader().load(PRESET), Pads()
    seen = _seen(recording, person, pads)
    tables = preset.table()
    spreads = tables["cohort"]
    logs = _grids(spreads)
    torques = _torques(seen, recording.frequency_hz, preset, pads, _friction_nm(recording), logs)
    prior = [np.exp(-0.5 * (each / sd)**2) for each, sd in zip(logs, _totals(spreads), strict=True)]
    weights = np.outer(prior[0], prior[1]) / (prior[0].sum() * prior[1].sum())
    expected = [float((weights * torque.mean(axis=0)).sum()) for torque in torques]
    for each, usual in zip(seen, expected, strict=True):
        _require_possible(recording.source, each, usual)
    common, single = posterior(
        [_likelihood(*each) for each in zip(seen, torques, expected, strict=True)], spreads, logs)
    notes = _write_factors(tables, common, dict(zip((each.muscle for each in seen), single, strict=True)))
    notes += [*_write_courses(tables, recording, pads), _write_variation(tables, recording)]
    notes.append(f"pads are assumed to have a radius of {pads.radius_mm:g} mm and to lie within "
                 f"{pads.error_mm:g} mm (sd) of motor points: the recording's [electrodes] are not used")
    own = _own_torques(tables, seen, recording.frequency_hz, _friction_nm(recording))
    factors = [MuscleFactors(each.muscle, each.electrode, each.torque_nm, float(np.sqrt(each.variance)),
                             torque, usual, _interval(members, weights), *pair)
               for each, torque, usual, members, pair
               in zip(seen, own, expected, torques, single, strict=True)]
    tables["name"] = recording.person
    tables["description"] = (f"{PRESET}, with {', '.join(each.muscle for each in factors)} of "
                             f"{recording.person}")
    if recording.side:
        tables["anthropometry"]["side"] = recording.side
    return OwnPatient(tables, factors, *common, notes, _baseline(recording))


def _seen(recording: StimulationRecording, person: ArmPerson, pads: Pads) -> list[_Seen]:
    """Recorded electrodes over muscles of the wrist."""
    trials, steady = trials_of(recording), recording.steady
    assert steady is not None
    if _FLEXION not in trials.joints:
        raise InputError(f"{recording.source}: joints", ", ".join(recording.joints),
                         "wrist_flexion among them", "a patient's muscles are those of the wrist and fingers")
    rest, rest_variance = _at_rest(recording, person)
    found = []
    for number, (electrode, muscle) in enumerate(pads.muscles.items()):
        if electrode not in trials.cells:
            continue
        cells = trials.cells[electrode]
        share = cells.trials / cells.trials.sum()
        rows = share @ features(Postures.of(electrode, cells.postures.angles), person.scale_nm,
                                person.spreads)[:, _FLEXION]
        mean, covariance = person.weights[electrode]
        mine = steady.muscle == recording.muscles.index(electrode)
        settings, counts = np.unique(np.column_stack([
            steady.current_a[mine], steady.pulse_width_s[mine], _angles(recording)[mine]]), axis=0,
            return_counts=True)
        found.append(_Seen(muscle, electrode, number, float(rows @ mean) - rest,
                           float(rows @ covariance @ rows) + rest_variance, settings, counts / counts.sum()))
    if not found:
        raise InputError(f"{recording.source}: muscles", ", ".join(trials.cells),
                         f"one or more of {', '.join(pads.muscles)}",
                         "a patient's muscles are those of the wrist and fingers")
    return found


def _angles(recording: StimulationRecording) -> Array:
    """Pronation, flexion and radial deviation (trials, 3), rad; 0 of joints that were not recorded."""
    steady = recording.steady
    assert steady is not None
    out = np.zeros((len(steady), 3))
    for column, name in enumerate(JOINTS[1:]):
        if name in recording.joints:
            joint = recording.joints.index(name)
            zero = recording.zero_rad[joint]
            out[:, column] = steady.reference_rad[:, joint] + (0.0 if np.isnan(zero) else zero)
    return np.round(out, 6)


def _at_rest(recording: StimulationRecording, person: ArmPerson) -> tuple[float, float]:
    """Mean flexion of passive trials and its variance: what the baseline of the visits holds of muscles."""
    steady = recording.steady
    assert steady is not None
    passive = ~steady.stimulated
    if not passive.any():
        return 0.0, 0.0
    evoked = steady.evoked_nm[passive, recording.joints.index(JOINTS[_FLEXION])]
    return float(evoked.mean()), float(person.scale_nm[_FLEXION]**2 / passive.sum() if evoked.any() else 0.0)


def _baseline(recording: StimulationRecording) -> str:
    """Torque, in words, over which the recorded flexion is: passive trials, where there are any."""
    steady = recording.steady
    assert steady is not None
    return BASELINES[steady.baseline] if steady.stimulated.all() else "all passive trials"


def _friction_nm(recording: StimulationRecording) -> float:
    """Dry friction of the device at the wrist; that of the published exoskeleton where it is unknown."""
    known = float(recording.friction_nm[recording.joints.index(JOINTS[_FLEXION])])
    return FRICTION_NM[_FLEXION] if np.isnan(known) else known


def _totals(spreads: Mapping[str, float]) -> tuple[float, float]:
    """Standard deviations of a muscle's strength and threshold, common and own."""
    return (float(np.hypot(spreads["strength"], spreads["muscle_strength"])),
            float(np.hypot(spreads["threshold"], spreads["muscle_threshold"])))


def _grids(spreads: Mapping[str, float]) -> tuple[Array, Array]:
    """Logarithms of strength and of threshold, (PLACES,) each."""
    strength, threshold = (SPAN * sd * np.linspace(-1.0, 1.0, PLACES) for sd in _totals(spreads))
    return strength, threshold


def _torques(seen: Sequence[_Seen], hertz: float, preset: Patient, pads: Pads, friction_nm: float,
             logs: tuple[Array, Array]) -> list[Array]:
    """Mean torque (members, strengths, thresholds), N m, that the device reads, by electrode."""
    arms = _arms(preset, seen, hertz)
    threshold = preset.parameters("electrodes", {})["threshold"]
    found = [np.zeros((MEMBERS, PLACES, PLACES)) for _ in seen]
    for number in range(MEMBERS):
        member = preset.member(cohort=0, number=number)
        forearm = Forearm(member, pads, np.random.default_rng([0, number]), {"threshold": threshold})
        sizes = (member.hand_size.hand_mm / preset.hand_size.hand_mm)**3 * np.exp(logs[0])
        for each, out in zip(seen, found, strict=True):
            for k, log in enumerate(logs[1]):
                out[number, :, k] = _shown(each, forearm, arms, hertz, friction_nm, sizes, log)
    return found


def _arms(patient: Patient, seen: Sequence[_Seen], hertz: float) -> dict[tuple[float, ...], Array]:
    """Flexion by unit of recruitment of each muscle (29,), N m, by flexion and radial deviation, rad."""
    wrist = HeldWrist(patient)
    whole = wrist.activation(np.ones(len(MUSCLES)), np.full(len(MUSCLES), hertz))
    return {place: np.array([wrist.torque_nm(row, *place)[0] / USUAL for row in USUAL * np.diag(whole)])
            for each in seen for place in map(tuple, each.settings[:, 3:].tolist())}


def _shown(seen: _Seen, forearm: Forearm, arms: Mapping[tuple[float, ...], Array], hertz: float,
           friction_nm: float, sizes: Array, log_threshold: float) -> Array:
    """Mean torque (n,), N m, that the device reads of muscles `sizes` (n,) times as strong."""
    total = np.zeros(len(sizes))
    known: dict[tuple[float, ...], Array] = {}
    for setting, weight in zip(map(tuple, seen.settings.tolist()), seen.weights, strict=True):
        current, width, pronation = setting[:3]
        if setting[:3] not in known:
            known[setting[:3]] = forearm.recruitment(
                seen.number, current * np.exp(-log_threshold), width, hertz, pronation)[0]
        torque = sizes * (known[setting[:3]] @ arms[setting[3:]])
        total += weight * (np.sign(torque) * np.maximum(np.abs(torque) - friction_nm, 0.0))
    return total


def _own_torques(tables: Mapping[str, Any], seen: Sequence[_Seen], hertz: float, friction_nm: float
                 ) -> list[float]:
    """Mean torque of each electrode, N m, that the device reads of the patient of these tables."""
    patient = patient_reader().from_table(tables, "patient")
    forearm = Forearm(patient, Pads(error_mm=0.0), np.random.default_rng(0))
    arms = _arms(patient, seen, hertz)
    return [float(_shown(each, forearm, arms, hertz, friction_nm, np.ones(1), 0.0)[0]) for each in seen]


def _interval(torque_nm: Array, weights: Array) -> tuple[float, float]:
    """Interval of 90 % of torque (members, strengths, thresholds) with weights (strengths, thresholds)."""
    low, high = np.quantile(torque_nm.ravel(), [0.05, 0.95], method="inverted_cdf",
                            weights=np.broadcast_to(weights, torque_nm.shape).ravel())
    return float(low), float(high)


def _likelihood(seen: _Seen, torque: Array, expected_nm: float) -> Array:
    """Likelihood (strengths, thresholds) of a recorded torque."""
    sd = np.sqrt(seen.variance + (SESSION * seen.torque_nm)**2)
    range_nm = 2.0 * max(abs(expected_nm), abs(seen.torque_nm), sd)
    usual = norm.pdf(seen.torque_nm, torque, sd).mean(axis=0)
    return np.asarray((1.0 - ODD) * usual + ODD / (2.0 * range_nm))


def posterior(likelihoods: Sequence[Array], spreads: Mapping[str, float], logs: tuple[Array, Array]
              ) -> tuple[tuple[Factor, Factor], list[tuple[Factor, Factor]]]:
    """Factors of strength and threshold: those common to all muscles, and the totals of each muscle.

    Parameters
    ----------
    likelihoods: of each muscle, (strengths, thresholds), on the grid of totals `logs`.
    spreads: standard deviations of logarithms: `strength`, `muscle_strength`, `threshold`,
        `muscle_threshold`.
    """
    common, given = [], []
    for grid, name in zip(logs, ("strength", "threshold"), strict=True):
        of_all = _mass(grid, 0.0, spreads[name])
        common.append(of_all)
        given.append(np.array([_mass(grid, centre, spreads[f"muscle_{name}"]) for centre in grid]))
    parts = [given[0] @ each @ given[1].T for each in likelihoods]
    joint = np.outer(*common)
    for part in parts:
        joint = joint * part / part.max()
    joint /= joint.sum()
    single = []
    for each, part in zip(likelihoods, parts, strict=True):
        ratio = np.divide(joint, part, out=np.zeros_like(joint), where=part > 0.0)
        total = each * (given[0].T @ ratio @ given[1])
        single.append((_factor(logs[0], total.sum(axis=1)), _factor(logs[1], total.sum(axis=0))))
    return (_factor(logs[0], joint.sum(axis=1)), _factor(logs[1], joint.sum(axis=0))), single


def _mass(grid: Array, centre: float, sd: float) -> Array:
    """Normal probability of each place of a grid, 1 in all."""
    if sd == 0.0:
        return np.asarray(np.arange(len(grid)) == np.abs(grid - centre).argmin(), float)
    mass = np.exp(-0.5 * ((grid - centre) / sd)**2)
    return np.asarray(mass / mass.sum())


def _factor(grid: Array, mass: Array) -> Factor:
    mass = mass / mass.sum()
    mean = float(grid @ mass)
    return Factor(mean, float(np.sqrt((grid - mean)**2 @ mass)))


def _require_possible(source: str, seen: _Seen, expected_nm: float) -> None:
    """Raise InputError for a torque that is surely of the other sign, or far beyond any patient's."""
    sd = float(np.sqrt(seen.variance))
    least = max(abs(seen.torque_nm) - SURE * sd, 0.0)
    contrary = seen.torque_nm * expected_nm < 0.0
    if least > (MOST_CONTRARY if contrary else MOST) * abs(expected_nm):
        current, width = np.average(seen.settings[:, :2], axis=0, weights=seen.weights)
        raise InputError(
            f"{source}: {seen.electrode}", f"evokes {seen.torque_nm:+.3g} N m of wrist flexion at "
            f"{1e3 * current:.3g} mA and {1e6 * width:.3g} us, where the virtual patient has "
            f"{expected_nm:+.2g}", f"at most {MOST:g} times as much, of its sign",
            "check signs, currents, pulse widths and units")


def _write_factors(tables: dict[str, Any], common: tuple[Factor, Factor],
                   muscles: Mapping[str, tuple[Factor, Factor]]) -> list[str]:
    """Write strengths and thresholds into a patient's tables; return what they are."""
    cohort = tables["cohort"]
    for number, (section, overall, single, key) in enumerate((
            ("strength", "overall", "muscles", "strength"),
            ("recruitment", "threshold", "thresholds", "threshold"))):
        table, of_all = tables[section], common[number]
        table[overall] = _short(table[overall] * np.exp(of_all.mean))
        cohort[key] = _short(of_all.sd)
        for muscle, factors in muscles.items():
            total = factors[number]
            table[single][muscle] = _short(table[single].get(muscle, 1.0) * np.exp(total.mean - of_all.mean))
            cohort[f"{key}s"][muscle] = _short(np.sqrt(max(total.sd**2 - of_all.sd**2, 0.0)))
    names = ", ".join(muscles)
    return [f"strength and thresholds of {names} are the preset's, moved as far as the recording tells them "
            "apart, with spreads of the posterior",
            f"other muscles are those of {PRESET}, but for the strength and threshold that all muscles have "
            "in common",
            "hand, motor points, axons, chronaxie and fatigue, and their spreads, are those of " + PRESET]


def patient_text(own: OwnPatient, recording: str) -> str:
    """Text of the patient's file, with what is the person's in comments."""
    notes = (f"Made of {recording} by `fesloop identify --stimulation --patient`:", *own.notes,
             "[cohort] holds the standard deviations of what is not known of the person: its members are",
             "possible patients. Wrist flexion at the recording's settings, N m: recorded, over",
             f"{own.baseline}; of this patient; of 90 % of the preset's members:",
             *(f"{each.muscle} {each.torque_nm:+.3g} (sd {each.sd_nm:.2g}), {each.own_nm:+.3g}, "
               f"{each.stranger_nm[0]:+.2g} to {each.stranger_nm[1]:+.2g}" for each in own.muscles))
    return "".join(f"# {note}\n" for note in notes) + toml_text(own.tables)


def as_report(own: OwnPatient) -> dict[str, Any]:
    """Factors with 90 % intervals, plain."""
    def row(factor: Factor) -> dict[str, float]:
        return {"factor": float(np.exp(factor.mean)), "low": float(np.exp(factor.mean - WITHIN * factor.sd)),
                "high": float(np.exp(factor.mean + WITHIN * factor.sd))}

    return {"strength": row(own.strength), "threshold": row(own.threshold), "notes": own.notes,
            "baseline": own.baseline,
            "muscles": [{"muscle": each.muscle, "electrode": each.electrode, "recorded_nm": each.torque_nm,
                         "recorded_sd_nm": each.sd_nm, "own_nm": each.own_nm,
                         "expected_nm": each.expected_nm,
                         "stranger_nm": dict(zip(("low", "high"), each.stranger_nm, strict=True)),
                         "strength": row(each.strength), "threshold": row(each.threshold)}
                        for each in own.muscles]}


def _write_courses(tables: dict[str, Any], recording: StimulationRecording, pads: Pads) -> list[str]:
    """Write delay and natural frequency of fitted courses into a patient's tables; return what they are.

    A muscle's value is the preset's plus what is common to the person's muscles plus its own, normal with the
    spreads of [cohort], and is seen with the error of its fit. Muscles of the elbow, which a patient does not
    have, tell about the person, relative to what they are in other people.
    """
    missing = f"delay and natural frequency, and their spreads, are those of {PRESET}: "
    if not recording.courses:
        return [missing + "there are no courses"]
    fits = fits_of(recording)
    if not fits:
        return [missing + "no course is explained well"]
    others = ArmResponses.shipped().without([recording.person])
    muscle, cohort = tables["muscle"], tables["cohort"]
    delay = courses_posterior(
        [(each.response.electrode, 1e3 * each.response.delay_s, 1e3 * float(each.sd[0])) for each in fits],
        muscle["delay_ms"], cohort["delay_ms"], cohort["muscle_delay_ms"], others.delay, 1e3 * DELAY_UNIT_S,
        pads)
    natural = courses_posterior(
        [(each.response.electrode, float(np.log(each.response.frequency_rad_s)), float(each.sd[1]))
         for each in fits], float(np.log(muscle["natural_rad_s"])), cohort["natural"],
        cohort["muscle_natural"], others.log_frequency, 1.0, pads)
    muscle["delay_ms"] = _short(muscle["delay_ms"] + delay[0].mean)
    muscle["natural_rad_s"] = _short(muscle["natural_rad_s"] * np.exp(natural[0].mean))
    cohort["delay_ms"], cohort["natural"] = _short(delay[0].sd), _short(natural[0].sd)
    for name, own in delay[1].items():
        muscle["delays_ms"][name], cohort["delays_ms"][name] = _short(own.mean), _short(own.sd)
    for name, own in natural[1].items():
        muscle["naturals"][name], cohort["naturals"][name] = _short(np.exp(own.mean)), _short(own.sd)
    return [f"delay and natural frequency are those of {len(fits)} courses ("
            + ", ".join(sorted({each.response.electrode for each in fits})) + ")"]


def courses_posterior(
    seen: Sequence[tuple[str, float, float]], preset: float, person_sd: float, muscle_sd: float, others: Pool,
    unit: float, pads: Pads
) -> tuple[Factor, dict[str, Factor]]:
    """Factors common to all muscles of a person, and those of single muscles of the wrist, on the preset.

    Parameters
    ----------
    seen: electrode, value and standard deviation of its error, of each course.
    preset, person_sd, muscle_sd: value of the preset, and spreads between people and among muscles.
    others: of other people, in `unit`, for muscles that a patient does not have.
    """
    own: dict[str, tuple[float, float, float]] = {}
    for electrode in dict.fromkeys(name for name, _, _ in seen):
        values, sds = np.array([each[1:] for each in seen if each[0] == electrode]).T
        weights = 1.0 / sds**2
        centre, spread = preset, muscle_sd
        if electrode not in pads.muscles:
            mean, unknown = others.of(electrode)
            centre, spread = unit * mean, unit * float(np.hypot(others.within, unknown))
        total = float(weights.sum())
        own[electrode] = float(weights @ values) / total - centre, spread**2, 1.0 / total
    precision = 1.0 / max(person_sd, _LEAST)**2 + sum(1.0 / (more + error) for _, more, error in own.values())
    common = Factor(sum(value / (spread + error) for value, spread, error in own.values()) / precision,
                    float(precision**-0.5))
    single = {}
    for electrode, (value, spread, error) in own.items():
        if electrode in pads.muscles:
            share = spread / (spread + error)
            single[pads.muscles[electrode]] = Factor(
                share * (value - common.mean), float(np.sqrt(share * error + (share * common.sd)**2)))
    return common, single


def _write_variation(tables: dict[str, Any], recording: StimulationRecording) -> str:
    """Write how much a person's muscles vary between trials, relative to the preset; return what it is.

    Friction of the device makes repeats differ more. The person's estimate is therefore compared with those
    of the same recording, simulated with the preset's variation, and pulled to the preset by their scatter.
    """
    variation = tables["variation"]
    usual, drift_s = Scatter(*(variation[name] for name in Scatter._fields)), variation["drift_s"]
    steady, rng = recording.steady, np.random.default_rng(0)
    if steady is None or np.isnan(steady.time_s).any():
        return f"variation between trials is that of {PRESET}: times of trials are not known"

    def log_of(each: StimulationRecording) -> float:
        return float(np.log(np.hypot.reduce(scatter_of([repeats_of(each)], drift_s))))

    try:
        own = log_of(recording)
        others = [log_of(simulated(recording, usual, drift_s, rng)) for _ in range(SIMULATED)]
    except InputError as fault:
        return f"variation between trials is that of {PRESET}: the recording {fault.found}"
    share = VARIATION_LOG_SD**2 / (VARIATION_LOG_SD**2 + float(np.var(others, ddof=1)))
    variation["scale"] = _short(np.exp(share * (own - float(np.mean(others)))))
    return f"variation between trials is {variation['scale']:.2g} times that of {PRESET}, by repeats"


def _short(value: float) -> float:
    return float(f"{value:.4g}")

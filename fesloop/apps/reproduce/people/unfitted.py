"""Unfitted members of the virtual patient in the experiment of the recorded people: torque at a held wrist.

Members of the preset `able_bodied` have single surface pads over muscles of the wrist, with the current and
pulse width of a recorded person. Their wrist is held in that person's postures; torque is the change of the
muscles' moments, at rest and at the steady activation of the pulses. The visits of the recording are played
in their order, through the dry friction of the device, and both recorded and simulated torques are taken
relative to the median of their visit (`SteadyTrials.as_evoked`). The elbow is not part of the hand's model:
its muscles evoke nothing, and its posture changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.evoked import recordings
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Sweep
from fesloop.experiment.registry import find, patient_reader
from fesloop.forms.schema import make
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.hand.muscle_paths import JOINTS
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.arm_responses import FRICTION_NM
from fesloop.models.dry_friction import play
from fesloop.streams.stimulation import StimulationRecording

Array = NDArray[np.float64]
PRESET, COHORT, MEMBERS = "able_bodied", 1, 20
AXES = ("wrist_flexion", "wrist_radial_deviation")
FACTOR, SPREAD_FACTOR, LEAST_CHANGE = 2.0, 1.5, 0.3
"""Bars: of mean flexion, of the spread between people, and of the change with posture over the mean."""
_STEADY_NS = 5 * NS_PER_S
"""Time of stimulation after which activation is steady (chosen: 20 time constants of the slowest muscle)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pads:
    """Surface pads, each over one muscle's motor point, as an experimenter places them.

    The recordings state neither size nor place. A pad is over the motor point of the average person, at the
    same share of the member's forearm, with an error: an experimenter moves a pad until the wanted movement
    is seen, but does not see the motor point.

    Attributes
    ----------
    radius_mm: of a pad (chosen: a common small round one has 25 mm).
    error_mm: standard deviation of a pad's place around the forearm and along it (chosen).
    muscles: muscle under each electrode.
    places: (deg, mm) around and along an adult's forearm, of electrodes that are elsewhere. That of ECRL is
        where it extends without much deviation, between ECRL and ECRB (chosen).
    """

    radius_mm: float = 12.0
    error_mm: float = 8.0
    muscles: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({
        "flexor carpi radialis": "FCR", "palmaris longus": "PL", "flexor carpi ulnaris": "FCU",
        "extensor carpi radialis longus": "ECRL"}))
    places: Mapping[str, tuple[float, float]] = field(default_factory=lambda: MappingProxyType({
        "extensor carpi radialis longus": (30.0, 86.0)}))


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


class Arm:
    """A member's forearm and hand with pads: steady torque at the held wrist.

    Parameters
    ----------
    number: of the member.
    pads: their size and error of place; the error is the member's own.
    """

    def __init__(self, number: int, pads: Pads) -> None:
        patient = patient_reader().load(PRESET).member(cohort=COHORT, number=number)
        self._block: Any = _with_pads(patient, pads, np.random.default_rng([COHORT, number]))
        self._pulses = self._block.init(Context("electrodes"))
        parameters = patient.parameters("muscles", {})
        self._muscles: Any = make(find("muscles"), {**parameters, "fatigue": None}, {}, "muscles")
        hand: Any = make(find("hand"), dict(patient.parameters("hand", {})), {}, "hand")
        self._model, self._data = hand.model, hand.init(Context("hand")).data
        self._tick = Tick()

    def recruitment(self, electrode: int, current_a: float, width_s: float, hertz: float,
                    pronation_rad: float) -> tuple[Array, Array]:
        """Recruitment (29,) and frequency (29,), Hz, by one pulse of one pad."""
        self._tick.time_ns += NS_PER_S  # the last pulse no longer counts
        now = self._tick.time_ns
        pulses = np.zeros((self._block.elements, 3))
        pulses[electrode] = current_a, width_s, hertz
        # Posture, skin and shift follow; the last two have had no message.
        inputs = (Sample(pulses, now, now, now), Sample(pronation_rad, now, now, now),
                  Sample(1.0, NEVER, NEVER, NEVER), Sample(np.zeros(2), NEVER, NEVER, NEVER))
        recruited, frequency = self._block.step(self._pulses, inputs, self._tick)
        return recruited, frequency

    def activation(self, recruited: Array, frequency: Array) -> Array:
        """Activation (29,) at which steady stimulation settles."""
        state, still = self._muscles.init(Context("muscles")), np.zeros(len(MUSCLES))
        inputs = (recruited, frequency, still, still)
        self._muscles.advance(state, inputs, 0, _STEADY_NS)
        return np.asarray(self._muscles.read(state, inputs)[0])

    def torque_nm(self, activation: Array, flexion_rad: float, radial_rad: float) -> Array:
        """Change (2,) of the muscles' moments of flexion and radial deviation at a held wrist."""
        model, data = self._model, self._data
        flexion, abduction = (model.joint(name) for name in ("wrist_flexion", "wrist_abduction"))
        data.qpos[flexion.qposadr[0]], data.qpos[abduction.qposadr[0]] = flexion_rad, -radial_rad
        data.qvel[:] = 0.0
        moments = []
        for level in (np.zeros(len(MUSCLES)), activation):
            data.ctrl[:len(MUSCLES)] = level
            mujoco.mj_forward(model, data)
            moments.append((data.qfrc_actuator[flexion.dofadr[0]], -data.qfrc_actuator[abduction.dofadr[0]]))
        return np.subtract(moments[1], moments[0])


def _with_pads(patient: Any, pads: Pads, rng: np.random.Generator) -> Any:
    """Block `electrodes` of a patient with one pad for each of the muscles."""
    usual: Any = find("electrodes")()
    points = {point.muscle: (point.around_deg, point.along_mm) for point in usual.motor_points}
    own = dict(patient.parameters("electrodes", {}))
    scale = own["length_mm"] / usual.length_mm
    errors = pads.error_mm * rng.normal(size=(len(pads.muscles), 2))
    positions = []
    for (electrode, name), (around, along) in zip(pads.muscles.items(), errors, strict=True):
        deg, mm = pads.places.get(electrode, points[name])
        positions.append([deg + np.degrees(around / own["radius_mm"]),
                          float(np.clip(scale * mm + along, 0.0, own["length_mm"]))])
    arrays = [{"positions": positions, "pad_mm": pads.radius_mm}]
    own = dict(patient.parameters("electrodes", {"arrays": arrays}))
    return make(find("electrodes"), {**own, "arrays": arrays, "shift_mm": 0.0, "shift_deg": 0.0}, {},
                "electrodes")


def simulated(recording: StimulationRecording, number: int, pads: Pads) -> Evoked:
    """Evoked torque of a member in the trials of a recorded person."""
    steady = recording.steady
    assert steady is not None
    arm, electrodes = Arm(number, pads), list(pads.muscles)
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
            found, hertz = arm.recruitment(*given[:3], recording.frequency_hz, pronation)
            known[given] = found, arm.activation(found, hertz)
        recruited[electrode, trial], activation = known[given]
        if (*given, flexion, radial) not in at_wrist:
            at_wrist[*given, flexion, radial] = arm.torque_nm(activation, flexion, radial)
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


def members(people: Sequence[StimulationRecording], pads: Pads) -> Iterator[Evoked]:
    """Members, each with the settings and in the postures of one of the people, in turn."""
    for number in range(MEMBERS):
        yield simulated(people[number % len(people)], number, pads)


def part(folder: Path, random_people: int) -> Part:
    """Rows of members beside people, and torques for figures."""
    pads = Pads()
    people = recordings(folder)
    theirs = [evoked_of(each, _wrist(each), list(pads.muscles)) for each in people]
    return compared(theirs, list(members(people, pads)), pads)


def _wrist(recording: StimulationRecording) -> Array:
    assert recording.steady is not None
    return recording.steady.evoked_nm[:, [recording.joints.index(name) for name in AXES]]


def compared(theirs: Sequence[Evoked], ours: Sequence[Evoked], pads: Pads) -> Part:
    """Rows, a table of all figures and curves of two groups of people."""
    names, scatter = list(pads.muscles.values()), partial(np.std, ddof=1)
    their_mean, our_mean = (_over(np.mean, [each.mean for each in group]) for group in (theirs, ours))
    their_sd, our_sd = (_over(scatter, [each.mean for each in group]) for group in (theirs, ours))
    their_change, our_change = (_over(np.mean, [each.change for each in group]) for group in (theirs, ours))
    shares = _over(np.mean, [each.recruited for each in ours])
    table = f"{len(ours)} unfitted members of {PRESET}, wrist held, currents and widths of people"
    rows = []
    for m, name in enumerate(names):
        barred = name != "FCU"
        for j, axis in enumerate(("flexion", "radial deviation")):
            mean, wanted = our_mean[m, j], their_mean[m, j]
            ratio = mean / wanted
            judged = barred and j == 0
            rows.append(Row(
                table, f"{name}: {axis}, mean (sd over people)",
                f"{wanted:+.3f} ({their_sd[m, j]:.3f})" + ("; within a factor 2" if judged else ", no bar"),
                f"{mean:+.3f} ({our_sd[m, j]:.3f}), ratio {ratio:.2f}",
                bool(not judged or 1.0 / FACTOR <= ratio <= FACTOR), "N m"))
        if not barred:
            continue
        share, known = our_change[m, 0] / abs(our_mean[m, 0]), their_change[m, 0] / abs(their_mean[m, 0])
        rows.append(Row(table, f"{name}: flexion, sd over postures over mean",
                        f"{known:.2f}; {LEAST_CHANGE:g} or more", f"{share:.2f}",
                        bool(share >= LEAST_CHANGE), "1"))
        spread = our_sd[m, 0] / their_sd[m, 0]
        rows.append(Row(table, f"{name}: flexion, sd over people, ours over theirs",
                        f"1 within a factor {SPREAD_FACTOR:g}", f"{spread:.2f}",
                        bool(1.0 / SPREAD_FACTOR <= spread <= SPREAD_FACTOR), "1"))
        if name == "ECRL":
            beside, theirs_beside = (abs(group[m, 1] / group[m, 0]) for group in (our_mean, their_mean))
            rows.append(Row(table, f"{name}: radial deviation over flexion, sizes",
                            f"{theirs_beside:.2f}; 1 or less", f"{beside:.2f}", bool(beside <= 1.0), "1"))
    sweep = Sweep(title="recruitment of the muscle under the pad, and of the three others recruited most",
                  unit="1", columns=("under the pad", "first other", "second", "third"), rows=tuple(
                      _neighbours(name, shares[m]) for m, name in enumerate(names)))
    curves = {"muscles": names, "postures": postures_shown(), "axes": AXES,
              "theirs_nm": np.array([each.mean for each in theirs]),
              "ours_nm": np.array([each.mean for each in ours]),
              "theirs_by_posture_nm": np.array([each.by_posture for each in theirs]),
              "ours_by_posture_nm": np.array([each.by_posture for each in ours])}
    return Part(rows, {"unfitted_recruitment": sweep}, {"unfitted": curves})


def _over(of: Callable[..., Any], values: Sequence[Array]) -> Array:
    """Statistic over those people who have trials of an electrode, by electrode."""
    every = np.array(values)
    columns = (each[np.isfinite(each).all(axis=1)] for each in every.swapaxes(0, 1))
    return np.array([of(each, axis=0) for each in columns])


def _neighbours(name: str, shares: Array) -> tuple[str, tuple[float, ...]]:
    others = [k for k in np.argsort(-shares).tolist() if k != muscle(name)][:3]
    return (f"{name} ({', '.join(MUSCLES[k] for k in others)})",
            (float(shares[muscle(name)]), *(float(shares[k]) for k in others)))

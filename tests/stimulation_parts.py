"""Recordings of stimulated muscle for tests, of any doubles that such a recording can hold."""

from dataclasses import fields, is_dataclass
from itertools import product

import numpy as np
from hypothesis import strategies as st

from fesloop.streams.stimulation.recording import (
    PASSIVE,
    ForceCourse,
    Movement,
    SteadyTrials,
    StimulationRecording,
    TorqueCourse,
)

JOINTS = ("elbow_flexion", "wrist_flexion", "wrist_radial_deviation")
MUSCLES = ("biceps", "flexor carpi radialis")
NAMES = st.text(st.characters(codec="utf-8", categories=("L", "N", "P")), min_size=1, max_size=12)


def any_numbers(rng, *shape, scale=1.0, lacking=0.0):
    """Doubles whose every bit counts; a share of them NaN."""
    values = rng.uniform(-scale, scale, shape)
    values[rng.random(shape) < lacking] = np.nan
    return values


def trials(rng, joints=2, muscles=2, visits=4, baseline="visit_median"):
    """Isometric trials: in each visit a passive one and each muscle, two postures visited in turn."""
    n = visits * (muscles + 1)
    visit = np.repeat(np.arange(visits), muscles + 1)
    muscle = np.tile(np.arange(PASSIVE, muscles), visits)
    on = muscle != PASSIVE
    reference = any_numbers(rng, n, joints)
    return SteadyTrials(
        muscle=muscle, posture=np.array(["10", "01"])[visit % 2], visit=visit, repeat=visit // 2,
        order=np.tile(np.arange(muscles + 1), visits), time_s=any_numbers(rng, n, scale=1e3, lacking=0.1),
        reference_rad=reference, angle_rad=reference + any_numbers(rng, n, joints, scale=0.1),
        pulse_width_s=on * rng.uniform(1e-5, 5e-4, muscles + 1)[muscle],
        current_a=on * rng.uniform(1e-3, 0.1, muscles + 1)[muscle],
        device_torque_nm=any_numbers(rng, n, joints, scale=10.0),
        device_torque_sd_nm=any_numbers(rng, n, joints, lacking=0.1),
        creep_nm=any_numbers(rng, n, joints, lacking=0.1),
        stiffness_nm_rad=any_numbers(rng, n, joints, scale=100.0, lacking=0.1), baseline=baseline,
        **({"trace_nm": any_numbers(rng, n, 5, joints, lacking=0.1), "trace_period_s": 0.01}
           if rng.random() < 0.5 else {}))


def recording(rng, **changed):
    """A recording with all four parts."""
    joints, muscles, m = JOINTS[:2], MUSCLES, rng.integers(1, 9)
    course = TorqueCourse(
        name="ramp", muscle=1, current_a=0.025, period_s=0.005, pulse_width_s=rng.uniform(1e-5, 3e-4, m),
        reference_rad=any_numbers(rng, 2), stiffness_nm_rad=any_numbers(rng, 2, lacking=0.5),
        angle_rad=any_numbers(rng, m, 2, lacking=0.1), device_torque_nm=any_numbers(rng, m, 2, lacking=0.1))
    movement = Movement(
        name="reach", period_s=0.01, reference_rad=any_numbers(rng, m, 2), angle_rad=any_numbers(rng, m, 2),
        device_torque_nm=any_numbers(rng, m, 2), planned_nm=any_numbers(rng, m, 2, lacking=1.0),
        pulse_width_s=rng.uniform(1e-5, 3e-4, (m, 2)), current_a=rng.uniform(0.0, 0.1, 2),
        settings={"kp": float(rng.normal())})
    force = ForceCourse(
        name="hop", kind="SSC", muscle=0, start_s=float(rng.random()), period_s=5e-4,
        force_n=np.append(1.0, any_numbers(rng, m - 1, scale=20.0, lacking=0.1)),
        length_m=any_numbers(rng, m, lacking=0.5),
        pulses_s=rng.random(rng.integers(0, 4)))
    given = {
        "person": "P1", "muscles": muscles, "joints": joints, "zero_rad": any_numbers(rng, 2, lacking=0.5),
        "friction_nm": any_numbers(rng, 2, lacking=0.5), "frequency_hz": float(rng.uniform(1.0, 100.0)),
        "lowest_width_s": any_numbers(rng, 2, lacking=0.5), "highest_width_s": any_numbers(rng, 2),
        "width_current_a": any_numbers(rng, 2), "source": "lab.toml", "source_format": "table",
        "side": "left", "electrodes": {"biceps": "5 cm"}, "notes": "a\nb \"c\"", "steady": trials(rng),
        "courses": (course,), "movements": (movement,), "forces": (force,)}
    return StimulationRecording(**{**given, **changed})


ARM_JOINTS = ("elbow_flexion", "forearm_pronation", "wrist_flexion", "wrist_radial_deviation")


def wrist_recording(torque_nm, repeats=2, current_a=0.03, width_s=2e-4, muscles=("flexor carpi radialis",),
                    **changed):
    """An arm's recording in eight postures of forearm and wrist; a device holds it.

    `torque_nm` takes signs of forearm, flexion and radial deviation (rows, 3), repeats and muscles (rows,) of
    the stimulated trials, and returns what stimulation evokes (rows, 4).
    """
    rows = [(posture, repeat, m) for repeat in range(repeats) for posture in product((-1, 1), repeat=3)
            for m in range(PASSIVE, len(muscles))]
    signs = np.array([posture for posture, _, _ in rows])
    on = np.array([m != PASSIVE for _, _, m in rows])
    reference = np.column_stack([np.zeros(len(rows)), np.deg2rad([40.0, 10.0, 10.0]) * signs])
    device, unknown = np.zeros((len(rows), 4)), np.full((len(rows), 4), np.nan)
    device[on] = -torque_nm(signs[on], *(np.array([row[k] for row in rows])[on] for k in (1, 2)))
    visits = {each: number for number, each in enumerate(dict.fromkeys(row[:2] for row in rows))}
    steady = SteadyTrials(
        muscle=np.array([m for _, _, m in rows]), visit=np.array([visits[row[:2]] for row in rows]),
        posture=np.array(["".join("01"[s > 0] for s in posture) for posture, _, _ in rows]),
        order=np.array([m + 1 for _, _, m in rows]), repeat=np.array([repeat for _, repeat, _ in rows]),
        time_s=np.arange(len(rows), dtype=float), reference_rad=reference, angle_rad=reference.copy(),
        pulse_width_s=on * width_s, current_a=on * current_a, device_torque_nm=device,
        device_torque_sd_nm=unknown.copy(), creep_nm=unknown.copy(), stiffness_nm_rad=unknown,
        baseline="passive")
    each = np.full(len(muscles), np.nan)
    given = {
        "person": "P1", "side": "right", "muscles": muscles, "joints": ARM_JOINTS, "zero_rad": np.zeros(4),
        "friction_nm": np.full(4, np.nan), "frequency_hz": 40.0, "lowest_width_s": each,
        "highest_width_s": each.copy(), "width_current_a": each.copy(), "source": "made up",
        "source_format": "table", "notes": "", "steady": steady}
    return StimulationRecording(**{**given, **changed})


@st.composite
def recordings_of_all_kinds(draw):
    """Recordings of any numbers and names, each part present or not."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    changed = {"person": draw(NAMES), "source": draw(NAMES),
               "notes": draw(st.text(st.characters(codec="utf-8"))),
               "side": draw(st.sampled_from(["left", "right", ""])),
               "muscles": tuple(draw(st.lists(NAMES, min_size=2, max_size=2, unique=True))),
               "electrodes": draw(st.dictionaries(NAMES, NAMES, max_size=2))}
    if draw(st.booleans()):
        changed["steady"] = None
    elif draw(st.booleans()):
        changed["steady"] = trials(rng, baseline=draw(st.sampled_from(["passive", "none"])))
    for part in ("courses", "movements", "forces"):
        if draw(st.booleans()):
            changed[part] = ()
    return recording(rng, **changed)


def require_same(one, other):
    """Everything in two parts of recordings is equal, arrays bit for bit."""
    assert type(one) is type(other)
    for name in (each.name for each in fields(one)):
        first, second = getattr(one, name), getattr(other, name)
        if isinstance(first, np.ndarray):
            assert (first.shape, first.dtype.kind) == (second.shape, second.dtype.kind), name
            assert first.tolist() == second.tolist() if first.dtype.kind == "U" else (
                first.dtype == second.dtype and first.tobytes() == second.tobytes()), name
        elif is_dataclass(first):
            require_same(first, second)
        elif isinstance(first, tuple) and first and is_dataclass(first[0]):
            assert len(first) == len(second), name
            for a, b in zip(first, second, strict=True):
                require_same(a, b)
        else:
            assert first == second, name

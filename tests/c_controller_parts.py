"""Controllers that are exported as C, and records of runs of them on plants that differ from their models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from c_code_parts import NEXT_TRIAL

import fesloop
from controllers.c_export import ilc as ilc_c
from controllers.c_export import mpc as mpc_c
from controllers.c_export import pid as pid_c
from controllers.c_export import tuned_pid as tuned_pid_c
from controllers.ilc.block import Ilc
from controllers.mpc.block import Mpc
from controllers.pid.block import Pid
from controllers.pid.tuned import TunedPid
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Sample
from fesloop.models.linear_model import Recruitment

RATE, PERIOD_NS, AGE_NS = "50", NS_PER_S // 50, 20_000_000
GRASP_RATE = "40"


def pid(**changes: object) -> Pid:
    return Pid(
        **{
            "kp": (1.2, 0.8),
            "ki": (2.0, 1.5),
            "kd": (0.05, 0.02),
            "mixing": ((0.7, 0.1), (-0.6, 0.3), (0.2, -0.9)),
            "bias": (0.1, 0.1, 0.0),
            "current_ma": (30.0, 25.0, 40.0),
            "recruitment": Recruitment(threshold_ma=(8.0, 9.0, 12.0), spread=(0.3, 0.25, 0.4)),
        }
        | changes
    )


def pid_program(block: Pid, rate: str = RATE):
    return pid_c.program(block, Context("control", clock=RateClock.from_rate(rate)))


def hour(kind: np.dtype, seconds: int, rng: np.random.Generator) -> np.ndarray:
    """Records of a slowly moving hand with noise, steps of the reference, and pauses of the sensor."""
    steps = seconds * 50
    t = np.arange(steps) / 50.0
    records = np.zeros(steps, kind)
    records["time_ns"] = np.arange(steps) * (NS_PER_S // 50)
    records["reference_newest_ns"] = records["time_ns"]
    records["reference"] = 0.5 + 0.3 * np.sign(np.sin(0.7 * t))[:, None]
    records["measured"] = 0.5 + 0.4 * np.sin(0.7 * t - 0.4)[:, None] + rng.normal(0.0, 0.02, (steps, 2))
    records["measured_newest_ns"] = np.where(np.arange(steps) < 20, -1, records["time_ns"] - 20_000_000)
    records["measured"][rng.integers(0, steps, steps // 500)] = np.nan
    return records


def tuned_pid(**changes: object) -> TunedPid:
    """The finger's controller, as shipped."""
    return replace(fesloop.load("finger_control", {"control": "tuned_pid"}).wiring.node("controller").part,
                   **changes)


def tuned_pid_program(block: TunedPid, *wired: str):
    return tuned_pid_c.program(block, Context("control", clock=RateClock.from_rate(RATE)), frozenset(wired))


def mpc(**changes: object) -> Mpc:
    """The finger's controller, as shipped."""
    return replace(fesloop.load("finger_control").wiring.node("controller").part, **changes)


def mpc_program(block: Mpc, *wired: str):
    return mpc_c.program(block, Context("control", clock=RateClock.from_rate(RATE)), frozenset(wired))


def grasping(**changes: object) -> Mpc:
    """The controller of a grasp with a glove of force sensors, as shipped."""
    return replace(fesloop.load("grasp_mpc").wiring.node("controller").part, **changes)


def grasping_program(block: Mpc, ticks: int = 0):
    context = Context("control", clock=RateClock.from_rate(GRASP_RATE))
    return mpc_c.program(block, context, frozenset(("reference_preview", "force")), ticks)


def pressed(sensors: int, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Forces (steps, sensors), N, of a hand that touches something for seconds, and bounces."""
    forces = np.zeros((steps, sensors))
    k = 60
    while k < steps:
        lasts = int(rng.integers(1, 160))
        touched = rng.random(sensors) < 0.3
        forces[k:k + lasts, touched] = rng.uniform(0.1, 3.0)
        k += lasts + int(rng.integers(1, 120))
    forces += rng.normal(0.0, 0.03, forces.shape)
    forces[rng.random(steps) < 0.002, 0] = np.nan
    return forces


def closed_loop(
    block: Mpc | TunedPid, kind: np.dtype, steps: int, seed: int, rate: str = RATE
) -> np.ndarray:
    """Records of a run of the block on a plant that is 40 % stronger than its model, with a noisy sensor.

    The reference asks for more than a finger can do; the sensor has pauses and values that are not finite.
    Where forces are felt, an object blocks the last two outputs.
    """
    context = Context("block", clock=RateClock.from_rate(rate))
    return one_trial(block, block.init(context), kind, steps, np.random.default_rng(seed), context.clock)[0]


def remembering(
    block: Mpc, kind: np.dtype, steps: int, seed: int, trials: int, strength: float
) -> tuple[np.ndarray, bool]:
    """Records of trials of different lengths, as of `closed_loop`, and whether the learning stopped."""
    rng, context = np.random.default_rng(seed), Context("block", clock=RateClock.from_rate(GRASP_RATE))
    state, rows, between = block.init(context), [], np.zeros(1, kind)
    between["time_ns"] = NEXT_TRIAL
    for trial in range(trials):
        if trial:
            state = block.next_trial(state, context)
            rows.append(between)
        length = steps - int(rng.integers(0, 3))
        rows.append(one_trial(block, state, kind, length, rng, context.clock, strength)[0])
    return np.concatenate(rows), state.course.progress.stopped


def one_trial(
    block: Mpc | TunedPid, state: object, kind: np.dtype, steps: int, rng: np.random.Generator,
    clock: RateClock, strength: float = 1.4,
) -> tuple[np.ndarray, np.ndarray]:
    """Records of a trial, and the block's pulses."""
    plant, period = block.model.sampled(clock.tick(1), 5_000_000), clock.tick(1)
    records = np.zeros(steps + 1, kind)
    t = np.arange(steps + 40) * period / NS_PER_S
    course = np.radians([30.0, 35.0, 20.0]) + np.radians([22.0, 28.0, 15.0]) * (
        0.6 * np.sign(np.sin(0.9 * t)) + 0.4 * np.sin(2.3 * t))[:, None]
    tick, x, y = Tick(), np.zeros(len(plant.a)), plant.offset
    captured, paused, issued = -1, 0, []
    if "force" in kind.names:
        felt = np.arange(steps) >= 40
        records["force"][:steps] = pressed(kind["force"].shape[0], steps, rng)
        late = rng.integers(10, 20, steps) * 1_000_000 + 600_000_000 * (rng.random(steps) < 0.01)
        records["force_newest_ns"][:steps] = np.where(felt, np.arange(steps) * period - late, -1)
    for k in range(steps):
        now = k * period
        record = records[k]
        if "reference_preview" in kind.names:
            coming = kind["reference_preview"].shape[0]
            record["reference_preview"] = course[k + 1:k + 1 + coming]
            record["reference_preview_newest_ns"] = now
        if "reference" in kind.names:
            record["reference"], record["reference_newest_ns"] = course[k], now
        record["time_ns"] = now
        tick.index, tick.time_ns = k, now
        samples = [
            Sample(port.initial_value() if port.resolved else None, -1, -1, -1)
            if port.name not in kind.names
            else Sample(
                np.array(record[port.name]),
                int(record[f"{port.name}_newest_ns"]),
                int(record[f"{port.name}_newest_ns"]),
                now,
            )
            for port in block.inputs
        ]
        paused = rng.integers(10, 60) if paused == 0 and rng.random() < 0.002 else max(paused - 1, 0)
        if k > 3 and not paused:
            captured = now - AGE_NS - int(rng.integers(0, 9_000_000))
            measured = y + rng.normal(0.0, np.radians(0.2), y.size)
            if rng.random() < 0.001:
                measured[0] = np.nan
        if captured >= 0:
            record["measured"] = measured
        record["measured_newest_ns"] = captured
        measured_at = [port.name for port in block.inputs].index("measured")
        samples[measured_at] = Sample(np.array(record["measured"]), captured, captured,
                                      now if captured >= 0 else -1)
        (pulses,) = block.step(state, samples, tick)
        issued.append(np.ravel(pulses))
        drive = block.model.recruitment.fraction(pulses)
        x = plant.a @ x + plant.b @ (strength * drive)
        free = plant.c @ x + plant.offset
        if "force" in kind.names and state.touch.holding:
            free[1:] = y[1:]
        y = free
    return records[:steps], np.array(issued)


def ilc(**changes: object) -> Ilc:
    """The finger's controller, as shipped, with another law."""
    return replace(fesloop.load("finger_ilc").wiring.node("controller").part, **{"law": "noilc"} | changes)


def ilc_program(block: Ilc, *wired: str):
    return ilc_c.program(block, Context("control", clock=RateClock.from_rate(RATE)), frozenset(wired))


def trials(block: Ilc, kind: np.dtype, count: int, seed: int) -> np.ndarray:
    """Trials of a finger that is 30 % stronger than its model; samples are late, noisy, lost or bad."""
    rng = np.random.default_rng(seed)
    plant = block.model.sampled(PERIOD_NS, 5_000_000)
    context = Context("block", clock=RateClock.from_rate(RATE))
    state, tick, rows = block.init(context), Tick(), []
    steps = round(block.duration_s * 50) + 3
    for trial in range(count):
        if trial:
            state = block.next_trial(state, context)
            rows.append(np.zeros(1, kind))
            rows[-1]["time_ns"] = NEXT_TRIAL
        x, captured, records = np.zeros(len(plant.a)), -1, np.zeros(steps, kind)
        bad = 0.4 if trial % 7 == 3 else 0.01
        for k in range(steps):
            now, record, y = k * PERIOD_NS, records[k], plant.c @ x + plant.offset
            record["time_ns"] = now
            record["reference"] = plant.offset + np.radians([8.0, 12.0, 6.0]) * (1.0 - np.cos(0.05 * k)) * (
                k < 250
            )
            record["reference_newest_ns"] = now
            if k > 2 and rng.random() > 0.05:
                captured = now - 20_000_000 - int(rng.integers(0, 9_000_000))
                measured = y + rng.normal(0.0, np.radians(0.3), 3)
                if rng.random() < bad:
                    measured[rng.integers(0, 3)] = np.nan
            if captured >= 0:
                record["measured"] = measured
            record["measured_newest_ns"] = captured
            tick.index, tick.time_ns = k, now
            samples = [
                Sample(port.initial_value() if port.resolved else None, -1, -1, -1) for port in block.inputs
            ]
            samples[0] = Sample(np.array(record["reference"]), now, now, now)
            samples[1] = Sample(
                np.array(record["measured"]), captured, captured, now if captured >= 0 else -1
            )
            if "measured_sd" in kind.names:
                record["measured_sd"], record["trusted"] = rng.uniform(0.0, 0.28, 3), rng.random() > 0.02
                samples[2] = Sample(np.array(record["measured_sd"]), now, now, now)
                samples[3] = Sample(float(record["trusted"]), now, now, now)
            (pulses,) = block.step(state, samples, tick)
            x = plant.a @ x + plant.b @ (1.3 * block.model.recruitment.fraction(pulses))
        rows.append(records)
    return np.concatenate(rows)

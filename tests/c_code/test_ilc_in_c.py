"""Iterative learning control in C equals the block, over trials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from c_code_parts import NEXT_TRIAL, QUICK, STRICT, build, needs_gcc, record_type, run, stepped

import fesloop
from controllers.c_export.ilc import LAWS, program
from controllers.ilc.block import Ilc
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Sample

RATE, PERIOD_NS = "50", NS_PER_S // 50


def ilc(**changes: object) -> Ilc:
    """The finger's controller, as shipped, with another law."""
    return replace(fesloop.load("finger_ilc").wiring.node("controller").part, **{"law": "noilc"} | changes)


def made(block: Ilc, *wired: str):
    return program(block, Context("control", clock=RateClock.from_rate(RATE)), frozenset(wired))


def trials(block: Ilc, kind: np.dtype, count: int, seed: int) -> np.ndarray:
    """Records of trials on a finger that is 30 % stronger than its model, with late, noisy, lost and bad samples."""
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
            record["reference"] = plant.offset + np.radians([8.0, 12.0, 6.0]) * (1.0 - np.cos(0.05 * k)) * (k < 250)
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
            samples = [Sample(port.initial_value() if port.resolved else None, -1, -1, -1) for port in block.inputs]
            samples[0] = Sample(np.array(record["reference"]), now, now, now)
            samples[1] = Sample(np.array(record["measured"]), captured, captured, now if captured >= 0 else -1)
            if "measured_sd" in kind.names:
                record["measured_sd"], record["trusted"] = rng.uniform(0.0, 0.28, 3), rng.random() > 0.02
                samples[2] = Sample(np.array(record["measured_sd"]), now, now, now)
                samples[3] = Sample(float(record["trusted"]), now, now, now)
            (pulses,) = block.step(state, samples, tick)
            x = plant.a @ x + plant.b @ (1.3 * block.model.recruitment.fraction(pulses))
        rows.append(records)
    return np.concatenate(rows)


def farthest(exported, block: Ilc, records: np.ndarray, binary) -> float:
    """Greatest difference of currents in A and of pulses as shares of the longest."""
    ours, theirs = run(binary, exported, records), stepped(block, exported, RATE, records)
    assert np.ptp(theirs) > 1e-4
    far = np.abs(ours[:, 1:] - theirs)
    far[:, 1::2] /= 1e-6 * block.width_max_us
    return float(far.max())


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_an_hour_of_trials_is_the_blocks_to_the_last_digits(tmp_path, law):
    block = ilc(law=law, stop_after=0)
    exported = made(block)
    records = trials(block, record_type(exported), 596, 1)  # of 6.04 s
    far = farthest(exported, block, records, build(exported, tmp_path, QUICK))
    print(f"{law}: greatest difference {far:.2g}")
    assert far < 1e-9


@needs_gcc
@pytest.mark.parametrize(("law", "changes"), [
    ("noilc", {"begin_s": 0.5, "first_drive": (0.1, 0.0, 0.2, 0.05), "forgetting": 0.1}),
    ("gradient", {"align_captures": False, "max_gap_ms": 41.0}), ("phase_lead", {"gain": 2.5, "cutoff_hz": 5.0}),
    ("phase_lead", {"gain": 1.0, "cutoff_hz": 0.0, "lead_ms": 60.0})])
def test_some_trials_under_sanitizers_are_the_blocks(tmp_path, law, changes):
    block = ilc(law=law, duration_s=4.0, **changes)
    exported = made(block, "measured_sd", "trusted")
    records = trials(block, record_type(exported), 9, 2)
    assert farthest(exported, block, records, build(exported, tmp_path, STRICT)) < 1e-9


@pytest.mark.parametrize(("changes", "wired", "where"), [
    ({"law": "noilc_constrained"}, (), "control.law"), ({"law": "newton"}, (), "control.law"),
    ({"trial_charge_max_uc": 500.0}, (), "control.trial_charge_max_uc"), ({}, ("force",), "control.force")])
def test_what_c_lacks_is_refused(changes, wired, where):
    with pytest.raises(fesloop.InputError, match=f"{where}.*not available in C"):
        made(ilc(**changes), *wired)

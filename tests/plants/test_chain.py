"""The whole chain in a loop: programme, safety, stimulator, electrodes, muscles, hand; about 10 s."""

from pathlib import Path

import numpy as np
import pytest

from fesloop.experiment.files.parse import from_document, read
from fesloop.hand.anthropometry import PARTS
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop

CHAIN = Path(__file__).with_name("chain.toml")
WALL = {"shape": "block", "size_mm": [12, 30, 65], "mass_kg": 100, "friction": 2.0,
        "position_m": [0.0, 0.107, -0.0875]}


def looped(blocks=None, plant_rate="100", seed=1):
    """A loop of the chain, its blocks changed, and its recorder."""
    _, document = read(CHAIN)
    document["experiment"]["seed"] = seed
    document["blocks"].update(blocks or {})
    recorder = Recorder(plant_rate)
    return Loop(from_document(document).wiring, recorder=recorder), recorder


def column(recorder, node, port):
    """All values of a plant's output."""
    return np.concatenate([row[2][port] for row in recorder.plants[node]])


def pressing_n(width_us, frequency_hz):
    """Force, N, with which the middle finger presses against a wall after a second of 20 mA at FDS3."""
    loop, recorder = looped({
        "programme": {"kind": "programme", "rate": "40", "times_s": [0.0], "current_ma": [[20.0]],
                      "width_us": [[width_us]]},
        "safety": {"kind": "safety", "rate": "40", "charge_rise_uc": 100.0},
        "stimulator": {"kind": "stimulator", "electrodes": [{"elements": [43, 44]}],
                       "frequency_hz": frequency_hz},
        "electrodes": {"kind": "electrodes", "clock": "stimulator"},
        "muscles": {"kind": "muscles"},
        "hand": {"kind": "hand", "splint_deg": {"wrist_flexion": 0.0, "wrist_abduction": 0.0},
                 "table": {"height_m": -0.12}, "object": WALL}})
    loop.run_until(1200 * NS_PER_MS)
    forces = column(recorder, "hand", 8)[-20:].mean(axis=0)
    middle = np.array([part.startswith("F3") for part in PARTS])
    assert not forces[~middle].any()
    return float(forces[middle].sum())


@pytest.mark.parametrize(("varied", "values"), [
    ("width_us", (20, 50, 100, 150, 200, 300, 400, 500)),
    ("frequency_hz", ("20", "25", "30", "40", "50"))])
def test_force_rises_with_pulse_width_and_frequency_and_saturates(varied, values):
    usual = {"width_us": 300.0, "frequency_hz": "40"}
    forces = np.array([pressing_n(**{**usual, varied: value}) for value in values])
    rise = np.diff(forces) / np.diff(np.array(values, dtype=float))
    # Neighbours that are recruited last bend other joints, and the finger presses less by a ten-thousandth.
    assert (rise >= -1e-3 * rise.max()).all()
    assert forces[-1] > (1.0 - 5e-4) * forces.max()
    assert forces[-1] > 0.3
    if varied == "width_us":
        assert forces[0] < 0.05
    # Axons at the motor point fire first, between 20 and 50 us: of two steps the second one saturates.
    first = 1 if varied == "width_us" else 0
    steepest = first + int(np.argmax(rise[first:]))
    assert (np.diff(rise[steepest:]) < 0.0).all()
    assert rise[-1] < 0.5 * rise[steepest]


def test_the_same_seed_gives_the_same_bits_whoever_looks_and_from_a_snapshot():
    """With tremor and reflex, an object, and the fibres' velocities fed back."""
    ends = []
    for plant_rate in ("100", "1000"):
        loop, recorder = looped(plant_rate=plant_rate)
        loop.run_until(300 * NS_PER_MS)
        snapshot = loop.snapshot()
        loop.run_until(600 * NS_PER_MS)
        ends.append((column(recorder, "hand", 0)[-1], column(recorder, "muscles", 0)[-1]))
    again, recorder = looped()
    again.restore(snapshot)
    again.run_until(600 * NS_PER_MS)
    ends.append((column(recorder, "hand", 0)[-1], column(recorder, "muscles", 0)[-1]))
    other, recorder = looped(seed=2)
    other.run_until(600 * NS_PER_MS)
    for angles, activation in ends[1:]:
        np.testing.assert_array_equal(angles, ends[0][0])
        np.testing.assert_array_equal(activation, ends[0][1])
    assert ends[0][1].max() > 0.1
    assert np.abs(column(recorder, "hand", 0)[-1] - ends[0][0]).max() > 1e-3

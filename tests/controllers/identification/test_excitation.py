import numpy as np
import pytest

from controllers.identification import Excitation
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick

SHORT = {"current_ma": (8.0, 12.0), "width_us": ((60.0, 300.0), (0.0, 240.0)), "lead_s": 0.5, "stairs": 3,
         "stair_s": 0.2, "rest_s": 0.4, "prbs_s": 40.0, "bit_s": 0.2}


def played(block, rate_hz=50, seed=0):
    """Pulses (ticks, channels, 2) and phases (ticks,) of the whole schedule and a second after it."""
    state, tick, seen = block.init(Context("excitation", seed)), Tick(), []
    for k in range(int((block.duration_s + 1.0) * rate_hz)):
        tick.index, tick.time_ns = k, k * 10**9 // rate_hz
        seen.append(block.step(state, (), tick))
    return np.array([pulses for pulses, _ in seen]), np.array([phase for _, phase in seen])


def test_staircase_of_each_channel_alone_then_rest():
    pulses, phase = played(Excitation(**SHORT))
    assert not pulses[:25].any()
    np.testing.assert_allclose(1e6 * pulses[25:55:10, 0, 1], [140.0, 220.0, 300.0])
    np.testing.assert_allclose(1e6 * pulses[75:105:10, 1, 1], [80.0, 160.0, 240.0])
    assert not pulses[55:75].any()
    assert not pulses[25:55, 1].any()
    assert (phase[25:75] == 0).all()
    assert (phase[75:125] == 1).all()


def test_ramp_rises_to_the_highest_width_and_falls():
    pulses, _ = played(Excitation(**SHORT | {"recruitment": "ramp"}))
    width = 1e6 * pulses[25:55, 0, 1]
    climbed = 1.0 - np.abs(2.0 * np.arange(30) / 30 - 1.0)
    np.testing.assert_allclose(width, 60.0 + 240.0 * climbed, atol=1e-9)


def test_binary_part_is_within_its_bounds_balanced_white_and_of_independent_channels():
    block = Excitation(**SHORT | {"prbs_us": ((100.0, 200.0), (0.0, 150.0))})
    pulses, phase = played(block)
    binary = 1e6 * pulses[phase == 2, :, 1]
    assert len(binary) == 2000
    np.testing.assert_allclose(sorted(set(binary[:, 0].round(6))), [100.0, 200.0])
    np.testing.assert_allclose(sorted(set(binary[:, 1].round(6))), [0.0, 150.0])
    assert (pulses[phase == 2, 1, 0] == np.where(binary[:, 1] > 0.0, 0.012, 0.0)).all()
    bits = np.where(binary > [150.0, 75.0], 1.0, -1.0)[::10]
    sd = 1.0 / np.sqrt(len(bits))
    assert np.abs(bits.mean(axis=0)).max() < 3.5 * sd
    for lag in range(1, 6):
        assert np.abs(bits[lag:].T @ bits[:-lag] / len(bits)).max() < 4.0 * sd
    assert abs(bits[:, 0] @ bits[:, 1]) / len(bits) < 3.5 * sd
    assert (played(block, seed=1)[0] != pulses).any()
    assert not pulses[-50:].any()


@pytest.mark.parametrize(("key", "value"), [
    ("current_ma", (8.0, 0.0)), ("width_us", ((60.0, 300.0),)), ("width_us", ((60.0, 30.0), (0.0, 240.0))),
    ("prbs_us", ((0.0, 300.0),)), ("stairs", 1), ("bit_s", 0.0), ("rest_s", -1.0)])
def test_names_the_faulty_key(key, value):
    with pytest.raises(InputError, match=key):
        Excitation(**SHORT | {key: value})

"""A reference that does not rotate as the gyroscope does is refused, with what would mend it."""

from pathlib import Path

import numpy as np
import pytest
from agreement_parts import motion
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fesloop.analysis.tracker_error.reference_agreement import require_agreement
from fesloop.errors import InputError
from fesloop.streams.recording import MotionRecording, Reference

SEEDS = st.integers(0, 10_000)
WRONG = {"scalar last": lambda q: q[:, [1, 2, 3, 0]], "`reference.direction`": lambda q: q * [1, -1, -1, -1]}


def recorded(seed, convention=lambda q: q, earth=(0.0, 0.0, 0.0), late=0, turning=1.0, noise_deg=0.3):
    """A sensor that turns at random with its orientations, w x y z, as a convention gives them."""
    times, gyr, acc = motion(seed, turning=turning)
    # The rates hold from one sample to the next.
    turns, reach = Rotation.from_rotvec(np.vstack([np.zeros(3), gyr[:-1] / 100.0])), 1
    while reach < times.size:
        turns = Rotation.concatenate([turns[:reach], turns[:-reach] * turns[reach:]])
        reach *= 2
    noise = np.random.default_rng(seed).standard_normal(gyr.shape) * np.radians(noise_deg)
    q = (Rotation.from_rotvec(earth) * turns * Rotation.from_rotvec(noise)).as_quat()[:, [3, 0, 1, 2]]
    stamps = np.arange(times.size, dtype=np.int64) * 10_000_000
    reference = Reference(
        stamps_ns=stamps + late * 10_000_000, orientation=convention(q)[:, np.newaxis],
        scored=np.ones(times.size, dtype=bool), sensor_frames=True, north=False)
    return MotionRecording(
        path=Path("lab.csv"), source_format="table", sensor_set=None, sensors=("hand",), rate=None,
        stamps_ns=stamps, gyr=gyr[:, np.newaxis], acc=acc[:, np.newaxis], mag=None, reference=reference,
        pairs=())


@given(seed=SEEDS, earth=st.tuples(*[st.floats(-1.8, 1.8)] * 3), late=st.integers(0, 6),
       turning=st.sampled_from([0.0, 0.3, 1.0]))
@settings(max_examples=8, deadline=None)
def test_a_right_reference_passes_in_any_earth_frame_and_late(seed, earth, late, turning):
    require_agreement(recorded(seed, earth=earth, late=late, turning=turning))


@pytest.mark.parametrize("wrong", WRONG)
@given(seed=SEEDS, earth=st.tuples(*[st.floats(-1.8, 1.8)] * 3))
@settings(max_examples=5, deadline=None)
def test_another_convention_is_refused_with_its_name(wrong, seed, earth):
    with pytest.raises(InputError) as refused:
        require_agreement(recorded(seed, WRONG[wrong], earth))
    assert wrong in str(refused.value)


def test_a_reference_of_another_motion_is_refused():
    other = recorded(2).reference.orientation[:, 0]
    with pytest.raises(InputError, match="does not rotate as the gyroscope does"):
        require_agreement(recorded(1, lambda q: other))

"""Errors since a beginning: of a stub that knows the truth and forgets a known error, and of a tracker."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from estimators.constrained import ConstrainedTracker
from fesloop.errors import InputError
from fesloop.experiment.metrics.convergence import convergence
from fesloop.hand import quaternion
from fesloop.loop.signals import Port
from fesloop.streams.files import open_recording

STARTS = (0.0, 10.0, 20.0, 31.3)


@dataclass(frozen=True, kw_only=True)
class Forgetting:
    """The reference's orientations, the third segment turned by 1 rad exp(-t / 1 s) since the beginning."""

    path: str
    known: dict[bytes, Any] = field(init=False, default_factory=dict)

    def __post_init__(self):
        recording = open_recording(self.path)
        true = quaternion.interpolate(
            recording.reference.stamps_ns, recording.reference.orientation, recording.stamps_ns)
        self.known.update((row.tobytes(), q) for row, q in zip(recording.gyr, true, strict=True))

    @property
    def inputs(self):
        return (Port("gyr", (5, 3), "rad/s"),)

    @property
    def outputs(self):
        return Port("count"), Port("orientation", (5, 4), "1", gaps=True)

    def init(self, context):
        return []

    def step(self, state, inputs, tick):
        state.append(1)
        q = self.known[np.ascontiguousarray(inputs[0].value).tobytes()].copy()
        angle = np.exp(-(len(state) - 1) / 40)
        q[2] = quaternion.multiply(q[2], quaternion.from_axis_angle([0.0, 1.0, 0.0], angle))
        return float(len(state)), q


def test_a_known_error_comes_out_at_its_times(recordings):
    path = str(recordings / "chain5" / "trial1.npz")
    found = convergence(path, Forgetting(path=path), STARTS, duration_s=4.0, step_s=0.5)
    assert found.times_s.tolist() == [0.25 + 0.5 * i for i in range(8)]
    expected = np.degrees(np.exp(-found.times_s) * np.sinh(0.25) / 0.25)
    for pair, errors in found.error_deg.items():
        wrong = expected if "seg3" in pair else 0.0 * expected
        assert errors.shape == (len(STARTS), 8)
        seen = np.isfinite(errors)
        assert seen.mean() > 0.5
        # Interpolated twice, from 30 to 40 Hz and back, the truth itself is off by some tenths of a degree;
        # where markers were hidden for part of an interval, the mean is that of the rest, within exp(1/4).
        wrong = np.broadcast_to(wrong, errors.shape)
        np.testing.assert_allclose(errors[seen], wrong[seen], rtol=0.29, atol=0.6)
    row = found.table()[0]
    assert row["pair"] == "seg1-seg2"
    assert len(row["times_s"]) == len(row["median_deg"]) == len(row["worst_deg"])


@pytest.mark.slow
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_hinges_of_the_chain_are_found_within_seconds(recordings, sensor_set):
    path = str(recordings / "chain5" / "trial1.npz")
    found = convergence(path, ConstrainedTracker(sensors=5), np.arange(0.0, 50.0, 2.5), 5.0, 0.5, sensor_set)
    for row in found.table():
        print(sensor_set, row["pair"], *(np.round(row[key], 1) for key in ("median_deg", "worst_deg")))
        if row["pair"] in ("seg2-seg3", "seg3-seg4", "seg4-seg5"):
            assert row["median_deg"][2] < 10.0
            assert row["worst_deg"][-1] < 15.0


def test_a_recording_without_reference_is_refused(recordings):
    path = str(recordings / "body16" / "qmt_full_body_example_data.mat")
    with pytest.raises(InputError, match="no orientations of jointed segments"):
        convergence(path, ConstrainedTracker(sensors=16), (0.0,))

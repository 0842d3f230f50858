"""The tracker bench: one row a case, and a hand that rests long enough for an initial pose."""

import numpy as np
import pytest

from fesloop.apps.bench import tracker
from fesloop.experiment import registry
from fesloop.loop.clock import RateClock


@pytest.mark.slow
def test_one_row_a_case_in_the_shape_of_every_bench(monkeypatch):
    monkeypatch.setattr(tracker, "TICKS", 405)
    monkeypatch.setattr(tracker, "CASES", (("vqf", {}), ("salchow_m2", {"front_end": "seel_ruppin"})))
    shares = []
    result = tracker.run(shares.append)
    assert list(result) == ["bench", "rows"]
    cases = [row["case"] for row in result["rows"]]
    assert cases == ["vqf, 16 sensors", "salchow_m2, seel_ruppin, 16 sensors"]
    for row in result["rows"]:
        assert list(row) == ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                             "ratio"]
        assert row["ratio"] == pytest.approx(row["us_median"] / row["reference_us_median"])
    assert shares == [0.0, 0.5]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "parameters"), tracker.CASES)
def test_trackers_are_at_work_when_counting_begins(kind, parameters):
    block = registry.find(kind)(sensors=tracker.SENSORS, **parameters)
    samples = tracker.moving_samples(tracker.WARM_UP + 5, tracker.SENSORS, tracker.STILL)
    step = tracker._Stepper(block, [samples[p.name] for p in block.inputs], RateClock.from_rate(tracker.RATE))
    for k in range(tracker.WARM_UP + 5):
        step(k)
    told = [status for status, _ in step.tick.reports]
    assert "initial_pose_failed" not in told
    assert told.count("aligning") == told.count("aligned")


def test_samples_rest_first():
    samples = tracker.moving_samples(10, 2, still=4)
    assert (samples["gyr"][:4] == 0.0).all()
    np.testing.assert_array_equal(samples["gyr"][4:], tracker.moving_samples(10, 2)["gyr"][4:])

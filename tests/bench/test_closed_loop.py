"""The bench of the whole hand's closed loop: its rows, and what it times beside what; about 12 s."""

import numpy as np
import pytest

from fesloop.apps.bench import closed_loop
from fesloop.apps.bench import closed_loop as _closed_loop_parts
from fesloop.experiment import registry


@pytest.mark.slow
def test_the_table_has_the_shape_of_every_bench_and_tells_the_parts(monkeypatch):
    monkeypatch.setattr(closed_loop, "CASES", {"grasp": closed_loop.CASES["grasp"]})
    shares = []
    result = closed_loop.run(repeats=1, processes=1, duration_s=0.3, progress=shares.append)
    assert list(result) == ["bench", "rows", "max_abs_error", "realtime_factor"]
    row, = result["rows"]
    assert list(row) == ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                         "ratio", "searched_us_median", "searched_ratio", "realtime_factor", "parts"]
    assert row["realtime_factor"] == pytest.approx(1e3 / row["us_median"])
    assert result["realtime_factor"] == {"grasp": row["realtime_factor"]}
    assert set(row["parts"]) == {"reference", "controller", "safety", "stimulator", "electrodes", "muscles",
                                 "hand", "imus", "tracker", "synergies", "loop", "recording"}
    assert list(row["parts"].values()) == sorted(row["parts"].values(), reverse=True)
    assert result["max_abs_error"] == 0.0
    assert shares == [1.0]


def test_rows_are_free_motion_and_a_grasp_of_one_loop_with_each_tracker():
    assert list(closed_loop.CASES)[:2] == ["free", "grasp"]
    for case, (tracker, _) in closed_loop.CASES.items():
        parts = {node.name: node.part for node in closed_loop.experiment(case, 1.0).wiring.nodes}
        assert (parts["hand"].object is not None) == (parts["hand"].table is not None) == ("grasp" in case)
        assert parts["tracker"].sensors == 17
        assert registry.find(tracker) is type(parts["tracker"])
        assert parts["controller"].model.inputs == parts["stimulator"].channels == 6


@pytest.mark.slow
@pytest.mark.parametrize("case", ["grasp, salchow_m2"])
def test_what_is_timed_is_a_grasp_that_holds(case):
    loop, seen, _ = _closed_loop_parts.recorded_loop(closed_loop.experiment(case, 6.0))
    hand = loop.states()["hand"]
    height = hand.data.qpos[-5]
    # The table is 15 cm below by now: 0.1 m/s from 3.5 s on, at most 0.2 m.
    assert abs(height) < 0.03
    assert hand.data.ncon > 4
    activations = np.array([row[4] for row in seen.inputs["hand"] if row[1] == 0])
    assert activations.max() > 0.02

"""Joint metrics: against closed forms, and the split of the error adds up."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.experiment.metrics import joints as metrics

MS = 1_000_000


def trace(period_ms, count, values):
    times = np.arange(count, dtype=np.int64) * period_ms * MS
    return times, np.asarray(values(times / 1e9), dtype=float)


def ramp(times):
    return np.stack([times, 2 * times], axis=1)


def test_held_values_stand_until_the_next_and_not_before_the_first():
    held = metrics.held((np.array([10, 20]), np.array([[1.0], [2.0]])), np.array([9, 10, 19, 20, 99]))
    np.testing.assert_array_equal(held[:, 0], [np.nan, 1.0, 1.0, 2.0, 2.0])


def test_rmse_of_a_delayed_ramp_is_its_delay():
    truth = trace(1, 1000, ramp)
    late = truth[0], ramp(truth[0] / 1e9 - 0.05)
    np.testing.assert_allclose(metrics.rmse_deg(truth, late), np.degrees([0.05, 0.1]))
    assert metrics.joint_rmse_deg([(truth, late)]) == [pytest.approx(np.degrees(np.sqrt(0.00625)))]


def test_one_joint_may_have_no_axis_of_joints():
    truth = trace(1, 1000, lambda t: ramp(t)[:, 0])
    late = truth[0], truth[1] - 0.05
    assert metrics.joint_rmse_deg([(truth, late)]) == [pytest.approx(np.degrees(0.05))]
    assert metrics.tracker_rmse_deg([(late, truth)]) == [pytest.approx(np.degrees(0.05))]
    assert metrics.range_deg(truth) == pytest.approx(np.degrees(np.ptp(truth[1])))


def test_an_estimate_is_judged_by_the_truth_at_its_capture():
    truth = trace(1, 1000, ramp)
    estimate = trace(10, 90, ramp)
    assert metrics.tracker_rmse_deg([(estimate, truth)]) == [pytest.approx(0.0, abs=1e-12)]


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 7, 10]), st.sampled_from([3, 10, 20]))
def test_the_parts_add_up_to_the_whole(seed, estimate_ms, reference_ms):
    rng = np.random.default_rng(seed)
    truth = trace(1, 300, lambda t: rng.normal(size=(len(t), 3)))
    estimate = trace(estimate_ms, 30, lambda t: rng.normal(size=(len(t), 3)))
    reference = trace(reference_ms, 30, lambda t: rng.normal(size=(len(t), 3)))
    split = metrics.split_error(truth, estimate, reference)
    np.testing.assert_allclose(split.total, metrics.rmse_deg(truth, reference))
    np.testing.assert_allclose(split.total**2, split.tracker**2 + split.controller**2
                               + 2 * split.correlation * split.tracker * split.controller)


def test_the_split_tells_a_blind_controller_from_a_lazy_one():
    truth = trace(1, 500, lambda t: np.full((len(t), 1), 0.3))
    wanted = trace(20, 25, lambda t: np.full((len(t), 1), 0.2))
    perfect_view = metrics.split_error(truth, truth, wanted)
    fooled = metrics.split_error(truth, wanted, wanted)
    for split, tracker, controller in ((perfect_view, 0.0, 0.1), (fooled, 0.1, 0.0)):
        assert split.total[0] == pytest.approx(np.degrees(0.1))
        assert split.tracker[0] == pytest.approx(np.degrees(tracker), abs=1e-12)
        assert split.controller[0] == pytest.approx(np.degrees(controller), abs=1e-12)


@pytest.mark.parametrize("rows", [1, 7, 299, 300])
def test_a_trace_in_pieces_has_the_error_of_the_whole(monkeypatch, rows):
    rng = np.random.default_rng(3)
    truth, estimate, reference = (trace(ms, 300 // ms, lambda t: rng.normal(size=(len(t), 2)))
                                  for ms in (1, 3, 20))
    whole = metrics.split_error(truth, estimate, reference), metrics.rmse_deg(estimate, truth)
    monkeypatch.setattr(metrics, "_ROWS_AT_ONCE", rows)
    split = metrics.split_error(truth, estimate, reference)
    for part in ("total", "tracker", "controller", "correlation"):
        np.testing.assert_allclose(getattr(split, part), getattr(whole[0], part), rtol=1e-12)
    np.testing.assert_allclose(metrics.rmse_deg(estimate, truth), whole[1], rtol=1e-12)


def test_what_is_no_number_shows_except_in_a_reference():
    truth, wanted = trace(1, 10, ramp), trace(1, 10, ramp)
    wanted[1][3] = np.nan
    assert metrics.rmse_deg(truth, wanted) == pytest.approx([0.0, 0.0])
    truth[1][5] = np.nan
    assert np.isnan(metrics.rmse_deg(truth, wanted)).all()
    assert np.isnan(metrics.split_error(truth, wanted, wanted).total).all()


def test_nothing_in_common_is_not_a_number():
    late = np.array([10**12], dtype=np.int64), np.zeros((1, 2))
    assert np.isnan(metrics.rmse_deg(trace(1, 10, ramp), late)).all()
    assert np.isnan(metrics.split_error(trace(1, 10, ramp), late, late).total).all()


def test_values_stand_under_the_names_of_the_joints():
    assert metrics.by_joint(np.array([1.0, 2.0]), ("MCP", "PIP")) == {"MCP": 1.0, "PIP": 2.0}

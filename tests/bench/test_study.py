"""The bench of studies: its arithmetic on made-up times, and that it times the same runs; about 15 s."""

import os
from concurrent.futures import Future

import pytest

from fesloop.apps.bench import _study_runs, study
from fesloop.apps.bench._study_runs import Timed


class AtOnce:
    """In place of a pool: what is submitted is done there and then."""

    def __init__(self, *given, **named):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        pass

    def submit(self, function, *given):
        future = Future()
        future.set_result(function(*given))
        return future


@pytest.fixture
def made_up(monkeypatch):
    """Bare runs of .3 s, then .5 s, in turns; studies a tenth slower than .4 s, and off by .25."""
    bares, order = iter([0.3, 0.5] * 10), []

    def bare(tables):
        order.append("bare")
        took = next(bares)
        return Timed(took * 4, took, 0.3, {"a": 1.0, "b": 2.0, "c": 3.0, "d": 4.0}, {})

    def studied(tables):
        order.append("study")
        return Timed(2.0, 0.44, 0.33, {"a": 1.0, "b": 2.25, "c": 3.0, "d": 4.0},
                     {"coordinator": [200.0], "workers": [210.0, 220.0]}, task_s=0.418)

    for name, function in (("bare", bare), ("studied", studied), ("duration_for", lambda run_s: 60.0),
                           ("alternating", lambda tables: ([0.303, 0.306, 0.309], [0.3, 0.3, 0.3])),
                           ("ProcessPoolExecutor", AtOnce)):
        monkeypatch.setattr(study, name, function)
    return order


def test_a_row_says_what_made_up_times_come_to(made_up):
    shares = []
    result = study.run(rounds=2, long_runs=4, short_runs=4, short_bare=4, progress=shares.append)
    assert list(result) == ["bench", "rows", "max_abs_error"]
    assert result["max_abs_error"] == 0.25
    row, alone, short, _, task = result["rows"]
    assert row["share_in_tasks"] == pytest.approx(0.95)
    assert row["outside_tasks_ms"] == pytest.approx(22.0)
    assert (task["us_median"], task["reference_us_median"]) == pytest.approx((0.306e6, 0.3e6))
    assert task["ratio"] == pytest.approx(1.02)
    assert list(row)[:7] == ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                             "ratio"]
    assert row["us_median"] == pytest.approx(0.44e6)
    # Of the pair, the slower counts: .5 s.
    assert row["efficiency_of_pair"] == pytest.approx(0.5 / 0.44)
    assert row["efficiency_cpu"] == short["efficiency_cpu"] == pytest.approx(0.3 / 0.33)
    assert row["overhead_cpu_ms"] == pytest.approx(30.0)
    # Two workers and 2 s for 4 runs: 1 s a run with the start, of which .44 s without it.
    assert row["start_s"] == pytest.approx(2.0 - 0.44 * 4 / 2)
    assert row["efficiency"] == pytest.approx(1.0 / row["ratio"])
    assert row["efficiency_with_start"] == pytest.approx(row["efficiency"] * 0.44)
    assert row["peaks_mb"] == {"coordinator": 200.0, "workers": 220.0}
    assert list(alone) == list(row)[:7]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_the_bare_runs_before_and_after_a_study_are_its_reference(made_up):
    row, *_ = study.run(rounds=1, long_runs=4, short_runs=4, short_bare=4)["rows"]
    assert made_up[:3] == ["bare", "study", "bare"]
    assert row["reference_us_median"] == pytest.approx(0.4e6)
    assert row["ratio"] == pytest.approx(1.1)
    assert row["overhead_ms"] == pytest.approx(40.0)


def test_libraries_keep_to_one_thread_while_it_runs_and_go_back(made_up, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    seen = []
    monkeypatch.setattr(study, "duration_for",
                        lambda run_s: seen.append([os.environ[name] for name in study._THREADS]) or 60.0)
    study.run(rounds=1)
    assert seen == [["1", "1", "1"]]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "OPENBLAS_NUM_THREADS" not in os.environ


@pytest.mark.slow
def test_a_study_and_bare_runs_do_the_same():
    tables = _study_runs.document(24, 1.0)
    bare, studied = _study_runs.bare(tables), _study_runs.studied(tables)
    assert len(bare.found) == 24
    assert studied.found == bare.found
    assert bare.wall_s == pytest.approx(24 * bare.run_s)
    assert 0.0 < bare.cpu_s < 4.0 * bare.run_s
    assert 0.0 < studied.run_s < 2.0 * studied.wall_s
    assert studied.cpu_s > 0.5 * bare.cpu_s
    # numpy, scipy and numba alone take 100 MB; the machine that judges this has a few GB.
    assert len(studied.peaks_mb["workers"]) == _study_runs.WORKERS
    assert all(100.0 < peak < 2000.0 for peaks in studied.peaks_mb.values() for peak in peaks)

"""The controller's bench: the peers' problems, solved right, beside a bare solver; nothing without them."""

import sys

import numpy as np
import pytest

from fesloop.apps.bench import mpc
from fesloop.apps.bench.mpc import Stepper, problems

KEYS = ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median", "ratio"]


@pytest.fixture
def scripts(peers, monkeypatch):
    monkeypatch.setenv("FESLOOP_PEERS", str(peers))
    yield peers
    for name in ("mpc_problem", "qp_bench"):
        sys.modules.pop(name, None)


@pytest.mark.slow
def test_one_row_a_size_in_the_shape_of_every_bench(scripts, monkeypatch, capsys):
    monkeypatch.setattr(mpc, "find_spec", lambda name: None)
    shares = []
    result = mpc.run(count=12, passes=1, processes=1, progress=shares.append)
    assert [row["case"] for row in result["rows"]] == ["S", "M", "L"]
    for row in result["rows"]:
        assert list(row) == KEYS
        assert row["ratio"] == pytest.approx(row["us_median"] / row["reference_us_median"])
        assert row["us_median"] <= row["us_p99"] <= row["us_worst"]
    assert result["max_abs_error"] < 1e-6
    assert shares == pytest.approx([1 / 6, 1 / 3, 1 / 2])
    assert "do-mpc is not installed" in capsys.readouterr().err


@pytest.mark.slow
def test_what_both_solve_is_the_optimum_of_the_peers_programme(scripts):
    made = problems("S", 150)
    told = sys.modules["mpc_problem"]
    stepper, muscles = Stepper(made, told.DU, told.TS), made.mpc.nu
    for k, problem in enumerate(made.sequence):
        q, lower, upper = made.mpc.cond_vec(*problem)
        best = made.optima[k]
        gradient, change = made.mpc.H @ best + q, made.mpc.D @ best
        # Stationary with multipliers of the right sign: no feasible direction descends.
        free_box = (best > 1e-7) & (best < 1.0 - 1e-7)
        free_slew = (change > lower + 1e-7) & (change < upper - 1e-7)
        active = np.vstack([np.eye(best.size)[~free_box], made.mpc.D[~free_slew]])
        at_upper = np.concatenate([best[~free_box] > 0.5, (change > 0.5 * (lower + upper))[~free_slew]])
        multipliers = np.linalg.lstsq(active.T, -gradient, rcond=None)[0] if active.size else np.empty(0)
        assert np.abs(gradient + active.T @ multipliers).max() < 1e-6
        assert (np.where(at_upper, multipliers, -multipliers) > -1e-6).all()
        stepper.step(stepper.place(k))
        assert np.abs(stepper.drive - best[:muscles]).max() < 1e-9


def test_without_the_scripts_there_are_no_rows_and_a_reason(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("FESLOOP_PEERS", str(tmp_path))
    assert mpc.run() == {"bench": "mpc", "rows": []}
    assert "FESLOOP_PEERS" in capsys.readouterr().err

"""The yardstick of `fesloop bench loop` is the peers' loop, and both give the same trajectory."""

import importlib.util
import sys

import numpy as np
import pytest

from fesloop.apps.bench import loop as yardstick
from fesloop.apps.bench.loop import run


def peers_module(peers):
    spec = importlib.util.spec_from_file_location("peers_loop_common_for_bench", peers / "loop" / "common.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_yardstick_is_the_peers_loop(peers):
    theirs = peers_module(peers)
    a, b = yardstick.matrices()
    assert np.abs(a - theirs.AD).max() < 1e-15
    assert np.abs(b - theirs.BD[:, 0]).max() < 1e-15
    assert (yardstick.KP, yardstick.KI, yardstick.REFERENCE, yardstick.CONTROL_S, yardstick.CALLS) == (
        theirs.KP, theirs.KI, theirs.R, theirs.TS, theirs.CALLS)
    expected, _ = theirs.reference()
    assert np.abs(yardstick.exact_trajectory() - expected).max() < 1e-12
    assert np.abs(yardstick.run_bare() - expected).max() < 1e-12


@pytest.mark.slow
def test_the_bench_has_its_shape_and_no_error():
    result = run(repeats=1, processes=1)
    assert result["bench"] == "loop"
    assert result["max_abs_error"] < 1e-12
    for row in result["rows"]:
        assert set(row) == {"case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                            "ratio"}

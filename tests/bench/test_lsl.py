"""The shape of `fesloop bench lsl`, on a run too short to judge by (some 15 s)."""

import numpy as np
import pytest

from fesloop.apps.bench.lsl import _answered, run

pytestmark = pytest.mark.realtime

pytest.importorskip("pylsl", reason="pylsl is not installed")


def test_commands_find_the_sample_that_they_answer():
    stamps = np.array([1.00, 1.01, 1.02, 1.03])
    commands = np.array([[1.0101, 1.012], [1.0101, 1.017], [1.0299, 1.033], [1.036, 1.04]])
    np.testing.assert_allclose(_answered(commands, stamps), [[1.01, 1.012], [1.03, 1.033]])


@pytest.mark.slow
def test_end_to_end_takes_longer_than_the_bare_way():
    result = run(seconds=4.0)
    bare, whole = result["rows"]
    assert list(result) == ["bench", "rows", "samples"]
    assert result["samples"] > 100
    assert 0.0 < bare["us_median"] < whole["us_median"]
    for row in (bare, whole):
        assert row["us_median"] <= row["us_p99"] <= row["us_worst"]
    assert whole["excess_p99_us"] == pytest.approx(whole["us_p99"] - bare["us_p99"])
    assert whole["reference_us_median"] == bare["us_median"]

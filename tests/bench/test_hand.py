"""The hand bench: one row a case, plant and bare MuJoCo at the same place to the last bit."""

import pytest

from fesloop.bench import hand


def test_one_row_a_case_in_the_shape_of_every_bench():
    shares = []
    result = hand.run(turns=60, progress=shares.append)
    assert list(result) == ["bench", "rows", "max_abs_error"]
    assert [row["case"] for row in result["rows"]] == ["free", "grasp"]
    for row in result["rows"]:
        assert list(row) == ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                             "ratio"]
        assert row["ratio"] == pytest.approx(row["us_median"] / row["reference_us_median"])
    assert result["max_abs_error"] == 0.0
    assert shares == [0.0, 0.5]

"""The hand bench: one row a case, plant and bare MuJoCo at the same place to the last bit; fields made."""

import pytest

from fesloop.apps.bench import hand


def test_one_row_a_case_in_the_shape_of_every_bench():
    shares = []
    result = hand.run(turns=60, progress=shares.append)
    assert list(result) == ["bench", "rows", "max_abs_error"]
    rows = {row["case"]: row for row in result["rows"]}
    assert list(rows) == ["free", "grasp", "electrodes", "electrodes, field made anew"]
    for case, row in rows.items():
        assert list(row) == ["case", "us_median", "us_p99", "us_worst", "reference", "reference_us_median",
                             "ratio"]
        if case in hand.CASES:
            assert row["ratio"] == pytest.approx(row["us_median"] / row["reference_us_median"])
        else:
            assert row["reference"] is row["reference_us_median"] is row["ratio"] is None
    assert result["max_abs_error"] == 0.0
    assert shares == pytest.approx([0.0, 1.0 / 3.0, 2.0 / 3.0])


def test_a_field_made_anew_is_what_the_second_row_of_the_electrodes_times(monkeypatch):
    made = []
    monkeypatch.setattr("plants.electrodes.recruitment.fill_rows",
                        lambda active, known, *rest: (made.append(int((active & ~known).sum())),
                                                      known.__ior__(active)))
    hand._pulse_times(turning=False)
    assert made == [59] + [0] * (hand.PULSES - 1)
    made.clear()
    hand._pulse_times(turning=True)
    assert made == [59] * hand.PULSES

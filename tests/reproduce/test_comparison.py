import json

import numpy as np

from fesloop.apps.reproduce.comparison import Band, Row, band, compared, share_that_holds
from fesloop.apps.reproduce.result import Reproduction, Sweep


def test_a_band_is_from_the_5th_to_the_95th_percentile():
    found = band(np.arange(101.0))
    assert (found.low, found.median, found.high) == (5.0, 50.0, 95.0)
    assert found.holds(5.0)
    assert found.holds(95.0)
    assert not found.holds(4.99)
    assert not found.holds(95.01)
    assert not found.holds(float("nan"))


def test_a_rows_table_has_the_agreed_keys():
    row = compared("Table 6", "A-F1, B", 6.1, Band(5.0, 4.0, 7.0), "cm")
    assert row.as_table() == {
        "table": "Table 6", "row": "A-F1, B", "theirs": 6.1,
        "ours": {"median": 5.0, "low": 4.0, "high": 7.0}, "holds": True, "unit": "cm"}
    assert not compared("Table 6", "A-F1, B", 7.1, Band(5.0, 4.0, 7.0), "cm").holds
    said = Row("Table 7", "M2 best", "6 of 6", "5 of 6", holds=False)
    assert said.as_table()["ours"] == "5 of 6"


def test_a_reproduction_is_one_json_object():
    rows = [Row("1", "a", 1.0, Band(1.0, 0.0, 2.0), holds=True), Row("1", "b", "yes", "no", holds=False)]
    sweep = Sweep(title="t", unit="cm", columns=("x", "y"), rows=(("one", (1.0, 2.0)),))
    told = json.loads(json.dumps(Reproduction("paper", 3, rows, {"s": sweep}).as_table()))
    assert list(told) == ["paper", "subjects", "rows", "holding", "sweeps"]
    assert told["holding"] == 0.5
    assert told["sweeps"]["s"] == {"title": "t", "unit": "cm", "rows": [{"row": "one", "x": 1.0, "y": 2.0}]}
    assert share_that_holds([]) == 0.0

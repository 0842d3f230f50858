"""Each fault of a session once, in whole runs, and the arithmetic of the times. About 35 s."""

import json

import hil_faults
import pytest
from hil_faults import zero_after_ms

from fesloop.apps.bench.stream_faults import Given, given
from fesloop.errors import RunError

pytestmark = pytest.mark.realtime

MS = 1_000_000


def test_the_log_is_read_to_its_last_whole_line(tmp_path):
    (tmp_path / "log").write_text("1\topen\t\n2\tgive\t0/0 20/300\n3\tgive\t0/300 0/0\n4\tstop\t\n5\tgi")
    assert given(tmp_path / "log") == [(1, False), (2, True), (3, False), (4, False)]
    assert given(tmp_path / "nothing") == []


def test_the_time_to_zero_is_that_to_the_end_of_the_last_current():
    rows = [Given(0, False), Given(10 * MS, True), Given(20 * MS, False), Given(25 * MS, True),
            Given(40 * MS, False), Given(50 * MS, False)]
    assert zero_after_ms(rows, 15 * MS) == 25.0
    assert zero_after_ms(rows, 30 * MS) == 10.0
    assert zero_after_ms(rows[:4], 15 * MS) is None


def test_a_fault_without_current_shows_nothing():
    with pytest.raises(RunError, match="was not stimulated"):
        zero_after_ms([Given(0, False), Given(10, True)], 5)


@pytest.mark.slow
@pytest.mark.parametrize("fault", hil_faults.FAULTS, ids=lambda fault: fault.name)
def test_a_fault_ends_current_in_time_and_keeps_the_recording(fault):
    pytest.importorskip("pysciencemode")
    result = hil_faults.run(moments=1, faults=[fault])
    if fault.own_disk and result["not_tried"]:
        pytest.skip(result["not_tried"][0]["why"])
    json.dumps(result)
    (row,) = result["rows"]
    assert row["ratio"] <= 1.0
    assert row["stated_held"] == row["recording_readable"] == row["cause_named"] == "1 of 1"
    assert row["lost_s"] <= 1.0

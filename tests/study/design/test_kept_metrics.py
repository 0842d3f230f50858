import math
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.analysis.study.design.study import KeptMetric
from fesloop.errors import InputError

finite = st.lists(st.floats(-1e9, 1e9), min_size=1)


def kept(path, metrics):
    return KeptMetric.parse("m", path).of(metrics)


@given(finite)
def test_a_list_has_a_number_a_trial(values):
    metrics = {"joints": {"MCP": {"rmse": values}}}
    assert kept("joints.MCP.rmse", metrics) == kept("joints.MCP.rmse:last", metrics) == values[-1]
    assert kept("joints.MCP.rmse:first", metrics) == values[0]
    assert kept("joints.MCP.rmse:min", metrics) == min(values)
    assert kept("joints.MCP.rmse:max", metrics) == max(values)
    assert kept("joints.MCP.rmse:median", metrics) == statistics.median(values)
    assert kept("joints.MCP.rmse:mean", metrics) == pytest.approx(math.fsum(values) / len(values))


@pytest.mark.parametrize(("value", "number"), [
    (3, 3.0), (True, 1.0), (None, None), (math.nan, None), (math.inf, None), ([], None), ([None], None)])
def test_what_is_no_finite_number_is_none(value, number):
    assert kept("e", {"e": value}) == number


def test_of_a_list_with_gaps_only_an_end_can_be_told():
    metrics = {"e": [1.0, None, 3.0]}
    assert [kept(f"e:{how}", metrics) for how in ("first", "last", "mean", "max")] == [1.0, 3.0, None, None]


@pytest.mark.parametrize(("path", "fault"), [
    ("eror", r"study\.metrics\.m: a run has no metric 'eror'; allowed: error, joints; did you mean 'error'"),
    ("joints.MPC.e", r"no metric 'joints\.MPC'; allowed: MCP; did you mean 'MCP'"),
    ("error.x", r"no metric 'error\.x'"), ("joints.MCP", "is not a number; .*name one below it"),
    ("joints.MCP.text", "is not a number")])
def test_a_path_that_leads_to_no_number_is_named(path, fault):
    with pytest.raises(InputError, match=fault):
        kept(path, {"error": [1.0], "joints": {"MCP": {"e": 1.0, "text": "x"}}})

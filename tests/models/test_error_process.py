"""Error processes as files, and what they refuse."""

import tomllib

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.forms.schema import make
from fesloop.loop.duration import Duration
from fesloop.models.error_process import ErrorProcess, ErrorSeries
from fesloop.models.error_steps import QUICK_RATE, RISE

HINGES = tuple(ErrorSeries(name=name, moved=moved, bias_deg=1.23456789, fast_deg=0.5, fast_s=0.2)
               for name, moved in (("a-b.x", True), ("a-b.y", False), ("b-c.y", True), ("c-d.x", True),
                                   ("c-d.y", True)))


def again(process, path):
    process.save(path)
    return make(ErrorProcess, ErrorProcess.file_tables(path), {}, "process")


def test_a_file_gives_the_process_back_to_six_digits(tmp_path):
    process = ErrorProcess(series=HINGES[:2], correlation=((1.0, 0.25), (0.25, 1.0)), age_ms=12.5, loss=0.1,
                           burst_messages=3.0, jitter=Duration(kind="exponential", mean_ms=2.0, high_ms=9.0),
                           source="a recording")
    back = again(process, tmp_path / "error.toml")
    assert (back.age_ms, back.loss, back.burst_messages, back.source) == (12.5, 0.1, 3.0, "a recording")
    assert back.jitter == process.jitter
    assert back.correlation == process.correlation
    np.testing.assert_allclose(back.series[0].row(), process.series[0].row(), rtol=1e-5)
    assert back.names == ("a-b.x", "a-b.y")


def test_files_without_an_oscillation_and_a_second_time_constant_are_read_as_before(tmp_path):
    path = tmp_path / "error.toml"
    path.write_text('format = "fesloop error process 1"\n[series."a.x"]\nslow_deg = 1.0\nslow_s = 2.0\n'
                    "smooth = true\nfast_deg = 0.5\nfast_s = 0.1\nquick_deg = 0.1\n")
    series, = make(ErrorProcess, ErrorProcess.file_tables(path), {}, "process").series
    assert series.row()[RISE] == 2.0
    assert (series.quick_hz, series.row()[QUICK_RATE]) == (0.0, 0.0)


def test_a_rounded_correlation_of_many_stays_one(tmp_path):
    common = np.random.default_rng(0).standard_normal((12, 2))
    matrix = np.corrcoef(common @ np.random.default_rng(1).standard_normal((2, 500)))
    series = tuple(ErrorSeries(name=f"s{i}", fast_deg=1.0, fast_s=0.1) for i in range(12))
    process = ErrorProcess(series=series, correlation=tuple(map(tuple, matrix.tolist())))
    back = again(process, tmp_path / "error.toml")
    np.testing.assert_allclose(back.matrix(), matrix, atol=1e-3)


def test_hinges_come_first():
    process = ErrorProcess(series=HINGES)
    assert process.usual() == ("a-b.x", "b-c.y")
    assert ErrorProcess(series=HINGES[3:]).usual() == ("c-d.x", "c-d.y")
    assert ErrorProcess(series=HINGES[1:2]).usual() == ("a-b.y",)


@pytest.mark.parametrize(("change", "told"), [
    ({"fast_deg": -1.0}, "fast_deg: -1.0"), ({"slow_deg": 1.0}, "slow_s: 0.0 with a slow_deg"),
    ({"smooth": True}, "slow_s: 0.0 of a smooth part"), ({"bias_deg": float("nan")}, "bias_deg: nan"),
    ({"quick_hz": 9.0}, "quick_s: 0.0 with a quick_hz"), ({"rise_s": -1.0}, "rise_s: -1"),
    ({"angle_deg": (5.0, 10.0)}, "angle_deg")])
def test_series_refuse_what_is_none(change, told):
    with pytest.raises(InputError, match=told):
        ErrorSeries(name="a", **change)


@pytest.mark.parametrize(("change", "told"), [
    ({"series": ()}, "series: none"), ({"series": HINGES[:1] * 2}, "each name once"),
    ({"correlation": ((1.0, 2.0), (2.0, 1.0))}, "no correlation of 2"),
    ({"correlation": ((1.0,),)}, "correlation"), ({"correlation": ((1.0, 0.0), (0.0,))}, "correlation"),
    ({"loss": 1.0}, "loss: 1.0"), ({"age_ms": -1.0}, "age_ms"),
    ({"loss": 0.5, "burst_messages": 0.5}, "burst"), ({"jitter": Duration(kind="measured")}, "jitter.kind"),
    ({"age_ms": 2.0, "jitter": Duration(kind="fixed", ms=-3.0)}, "jitter: -3 ms at least")])
def test_processes_refuse_what_is_none(change, told):
    with pytest.raises(InputError, match=told):
        ErrorProcess(**{"series": HINGES[:2], **change})


@pytest.mark.parametrize(("text", "told"), [
    (None, "cannot be read"), ("a = [", "is not TOML"), ('format = "other"', "format"),
    ('format = "fesloop error process 1"', "series")])
def test_other_files_are_refused(text, told, tmp_path):
    path = tmp_path / "error.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=told):
        ErrorProcess.file_tables(path)


def test_where_it_cannot_be_written_it_says_so(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        ErrorProcess(series=HINGES[:1]).save(tmp_path)


def test_a_file_holds_parameters_and_nothing_else(tmp_path):
    ErrorProcess(series=HINGES).save(tmp_path / "error.toml")
    table = tomllib.loads((tmp_path / "error.toml").read_text())
    assert set(table) == {"format", "series", "correlation", "age_ms", "jitter", "loss", "burst_messages",
                          "source"}

import pytest
from pydantic import TypeAdapter, ValidationError

from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.errors import InputError
from fesloop.forms.schema import make, table

MAP = {"name": "error", "kind": "heat_map", "metric": "error_deg", "x": "latency_ms", "y": "jitter_ms",
       "panels": "controller"}
CURVES = {"name": "error", "kind": "curves", "metric": "error_deg", "x": "latency_ms", "by": "controller"}


@pytest.mark.parametrize("given", [
    MAP, CURVES, {**CURVES, "at": {"jitter_ms": 0, "law": "p", "drift": True}, "low": 0}])
def test_a_table_of_a_study_file_makes_a_figure(given):
    assert TypeAdapter(table(Figure, {})).validate_python(given) == given
    figure = make(Figure, given, {}, "figures[0]")
    assert (figure.x, figure.panels, figure.at) == (given["x"], given.get("panels"), given.get("at", {}))


@pytest.mark.parametrize("given", [{**MAP, "kind": "pie"}, {**MAP, "z": "law"},
                                   {**CURVES, "confidence": "95"}, {**CURVES, "at": {"law": [1]}}])
def test_what_no_figure_has_is_refused_by_the_schema(given):
    with pytest.raises(ValidationError):
        TypeAdapter(table(Figure, {})).validate_python(given)


@pytest.mark.parametrize(("change", "fault"), [
    ({"name": "../error"}, "name:"), ({"y": None}, "a heat map has x and y"), ({"by": "law"}, "no by"),
    ({"y": "latency_ms"}, "'latency_ms' is named more than once"),
    ({"at": {"controller": "pid"}}, "'controller' is named more than once"),
    ({"confidence": 1.0}, "confidence: 1"), ({"low": 2.0, "high": 1.0}, "low: 2"),
    ({"kind": "curves"}, "curves have x and by")])
def test_a_figure_that_cannot_be_drawn_is_refused(change, fault):
    with pytest.raises(InputError, match=fault):
        Figure(**{**MAP, **change})


def test_axes_and_metrics_that_are_not_there_are_named():
    axes, metrics = ["latency_ms", "controllers"], ["error", "held"]
    faults = [str(fault) for fault in Figure(**MAP).faults(axes, metrics)]
    assert len(faults) == 3
    assert faults[0].startswith("y: there is no axis 'jitter_ms'; allowed: latency_ms, controllers")
    assert "did you mean 'controllers'?" in faults[1]
    assert faults[2].startswith("metric: the study keeps no metric 'error_deg'; allowed: error, held")
    assert Figure(**MAP).faults(["latency_ms", "jitter_ms", "controller"], ["error_deg"]) == []

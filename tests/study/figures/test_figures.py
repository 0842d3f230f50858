import sys
from itertools import combinations

import pytest
from matplotlib.image import imread
from study_stores import write_store

from fesloop.analysis.study import Figure, load
from fesloop.analysis.study.results.quantities import called, with_unit
from fesloop.errors import InputError
from fesloop.show.figures import Overlay, draw
from fesloop.show.figures.content import Content
from fesloop.show.figures.curves import curves
from fesloop.show.figures.heat_maps import heat_map
from fesloop.show.figures.layout import columns_of

AXES = {"latency_ms": {"levels": [0, 20, 40], "label": "latency of the tracker", "unit": "ms"},
        "jitter_ms": [0, 5], "law": ["p", "pd", "pid", "mpc", "ilc"],
        "member": {"levels": [0, 1, 2], "cohort": {"patient": "sci_c6", "members": 3}}}
MAP = {"name": "map", "kind": "heat_map", "metric": "joint_rmse_deg", "x": "latency_ms", "y": "jitter_ms"}
CURVES = {"name": "curves", "kind": "curves", "metric": "joint_rmse_deg", "x": "latency_ms"}
LONG = ("Error of the finger's joints over latency and jitter of the tracker, for every law of control that "
        "there is, in patients of whom each is a little different")


def outcome(levels, replicate):
    if levels["latency_ms"] == 40 and levels["law"] == "p":
        return "not finite"
    return {"joint_rmse_deg": 1.0 + levels["member"] + 0.1 * levels["latency_ms"]}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "latency_map.sqlite"
    return load(write_store(path, AXES, 1, outcome, ("joint_rmse_deg",)))


@pytest.mark.parametrize(("kind", "spec", "overlays"), [
    (heat_map, {**MAP, "panels": "law", "title": LONG}, [Overlay(label="critical latency", x=[30.0])]),
    (heat_map, {**MAP, "y": "law", "at": {"jitter_ms": 0}}, []),
    (curves, {**CURVES, "by": "law", "panels": "jitter_ms"}, [Overlay(label="critical latency", x=[30.0])]),
    (curves, {**CURVES, "by": "jitter_ms", "panels": "law", "title": LONG}, []), (curves, CURVES, [])])
def test_nothing_in_a_figure_hides_anything_else(results, kind, spec, overlays):
    drawing = kind(Content.of(results, Figure(**spec), overlays))
    drawing.draw_without_rendering()
    parts = [*(axes for axes in drawing.axes if axes.get_visible()), *drawing.legends, *drawing.texts]
    boxes = [part.get_tightbbox() for part in parts]
    for box in boxes:
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= drawing.bbox.x1
        assert box.y1 <= drawing.bbox.y1
    for one, other in combinations(boxes, 2):
        across = min(one.x1, other.x1) - max(one.x0, other.x0)
        assert min(across, min(one.y1, other.y1) - max(one.y0, other.y0)) <= 1.0


def test_a_figure_says_what_it_is_of(results):
    content = Content.of(results, Figure(**CURVES, at={"jitter_ms": 5}), [])
    assert content.title == "latency_map: joint RMSE"
    assert content.caption(intervals=True) == (
        "mean of 3 patients; 95 % interval (Student's t); averaged over law; jitter 5 ms; "
        "3 of 45 runs failed")
    axes = curves(content).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("latency of the tracker, ms", "joint RMSE, deg")


def test_an_axis_of_one_level_is_not_averaged_over(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": [0, 20], "law": ["p"]}, 1,
                               lambda levels, replicate: {"joint_rmse_deg": 1.0}))
    assert Content.of(results, Figure(**CURVES), []).caption(intervals=False) == "mean of 1 replicate"


def test_axes_without_cells_of_their_own_are_averaged_over(results):
    content = Content.of(results, Figure(**CURVES), [])
    assert [cell.value for cell in content.cells] == pytest.approx([2.0, 4.0, 6.0])
    assert [cell.units for cell in content.cells] == [3, 3, 3]


@pytest.mark.parametrize(("name", "expected"), [
    ("latency_ms", ("latency", "ms")), ("held", ("held", "")), ("joint_rmse_deg", ("joint RMSE", "deg")),
    ("queries", ("queries", "")), ("field_ut", ("field", "µT")), ("ms", ("ms", ""))])
def test_a_name_tells_its_unit(name, expected):
    assert called(name) == expected


def test_what_a_file_calls_a_quantity_comes_first():
    assert called("latency_ms", "delay", "s") == ("delay", "s")


@pytest.mark.parametrize(("panels", "columns"), [(1, 1), (4, 4), (5, 3), (8, 4), (9, 3)])
def test_rows_of_panels_are_even(panels, columns):
    assert columns_of(panels) == columns


@pytest.mark.parametrize("spec", [MAP, CURVES])
def test_a_figure_is_a_picture_of_its_name(results, tmp_path, spec):
    path = draw(results, Figure(**spec), tmp_path / "figures")
    assert path == tmp_path / "figures" / f"{spec['name']}.png"
    assert imread(path).shape[0] > 300
    again = draw(results, Figure(**spec), tmp_path / "again")
    assert again.read_bytes() == path.read_bytes()


def test_a_study_of_which_nothing_is_over_can_be_drawn(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 1, lambda levels, replicate: None,
                               ("joint_rmse_deg",)))
    for spec in (MAP, CURVES):
        assert draw(results, Figure(**spec), tmp_path).is_file()


def test_a_study_whose_every_run_failed_can_be_drawn(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", AXES, 1, lambda levels, replicate: "no",
                               ("joint_rmse_deg",)))
    for spec in (MAP, CURVES):
        assert draw(results, Figure(**spec), tmp_path).is_file()


@pytest.mark.parametrize(("change", "overlay", "fault"), [
    ({"metric": "error"}, {}, "figure map: metric: the study keeps no metric 'error'"),
    ({"x": "lag_ms"}, {}, "figure map: x: there is no axis 'lag_ms'"),
    ({"at": {"law": "lqr"}}, {}, "law = lqr: is not a level"),
    ({"x": "law"}, {"x": [1.0]}, "overlay 'theory': law is no axis of numbers"),
    ({"y": "law"}, {"x": [1.0], "y": [1.0]}, "overlay 'theory': law is no axis of numbers"),
    ({}, {"x": [1.0], "panel": "pid"}, "overlay 'theory': panel: pid, but the figure has none"),
    ({"panels": "law"}, {"x": [1.0], "panel": "lqr"}, "law = lqr: is not a level")])
def test_what_cannot_be_drawn_is_named(results, tmp_path, change, overlay, fault):
    overlays = [Overlay(label="theory", **overlay)] if overlay else []
    with pytest.raises(InputError, match=fault):
        draw(results, Figure(**{**MAP, **change}), tmp_path, overlays)


@pytest.mark.parametrize("given", [{"x": []}, {"x": [1.0, 2.0], "y": [1.0]}])
def test_an_overlay_has_as_many_y_as_x(given):
    with pytest.raises(InputError, match="as many y as x"):
        Overlay(label="theory", **given)


def test_a_figure_that_cannot_be_written_is_refused(results, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        draw(results, Figure(**CURVES), tmp_path / "taken")


def test_without_matplotlib_there_are_no_figures(results, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.backends.backend_agg", None)
    with pytest.raises(InputError, match="matplotlib is not installed"):
        draw(results, Figure(**CURVES), tmp_path)


def test_powers_in_units_are_raised():
    assert with_unit("magnet", "A m^2") == "magnet, A m²"
    assert with_unit("held", "") == "held"

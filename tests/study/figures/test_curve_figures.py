from itertools import pairwise

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_rgba
from study_stores import write_cells, write_store

from fesloop.analysis.study import Figure, load
from fesloop.show.figures import Overlay
from fesloop.show.figures.content import Content
from fesloop.show.figures.curves import curves
from fesloop.show.picture.palette import BLUE, GREEN, VERMILION

LATENCIES = [0, 10, 20, 40, 80]
AXES = {"latency_ms": LATENCIES, "controller": ["pid", "mpc", "ilc"]}
SPEC = {"name": "error", "kind": "curves", "metric": "error_deg", "x": "latency_ms", "by": "controller"}


def outcome(levels, replicate):
    if levels["controller"] == "pid" and levels["latency_ms"] == 80:
        return "not finite"
    if levels["controller"] == "mpc" and levels["latency_ms"] == 80 and replicate == 1:
        return "not finite"
    noise = np.random.default_rng([replicate, levels["latency_ms"]]).normal()
    return {"error_deg": 5.0 + 0.05 * levels["latency_ms"] + noise, "held": replicate < 3}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "study.sqlite"
    return load(write_store(path, AXES, 5, outcome, ("error_deg", "held")))


@pytest.fixture(scope="module")
def axes(results):
    return curves(Content.of(results, Figure(**SPEC), [])).axes[0]


def joined(axes):
    """The lines themselves, without markers."""
    return [line for line in axes.lines if line.get_linestyle() == "-" and len(line.get_xdata()) == 5]


def test_a_line_goes_through_its_cells(results, axes):
    for line, controller in zip(joined(axes), AXES["controller"], strict=True):
        cells = results.cells("error_deg", ["latency_ms"], at={"controller": controller})
        assert line.get_xdata().tolist() == LATENCIES
        assert np.array_equal(line.get_ydata(), [cell.value for cell in cells], equal_nan=True)


def test_a_band_is_the_interval_of_each_cell(results, axes):
    for band, controller in zip(axes.collections, AXES["controller"], strict=True):
        cells = [cell for cell in results.cells("error_deg", ["latency_ms"], at={"controller": controller})
                 if np.isfinite(cell.high)]
        corners = {tuple(np.round(corner, 9)) for path in band.get_paths() for corner in path.vertices}
        assert corners == {(float(cell.levels["latency_ms"]), round(end, 9))
                           for cell in cells for end in (cell.low, cell.high)}


def test_a_marker_is_hollow_where_some_runs_failed(axes):
    hollow = [tuple(line.get_xdata()) for line in axes.lines if line.get_markerfacecolor() == "white"]
    assert sorted(hollow) == [(), (80.0,), (80.0,)]


def test_a_cross_below_the_axis_stands_where_all_runs_failed(axes):
    (cross,) = [line for line in axes.lines if line.get_gid() == "all failed"]
    assert cross.get_xdata().tolist() == [80.0]
    assert axes.get_ylim()[0] < cross.get_ydata()[0] < 0.0
    assert cross.get_color() == BLUE
    assert min(axes.get_yticks()) == 0.0


def test_the_key_names_lines_and_marks(results):
    drawing = curves(Content.of(results, Figure(**SPEC), []))
    (key,) = drawing.legends
    assert key.get_title().get_text() == "controller"
    assert [text.get_text() for text in key.get_texts()] == ["pid", "mpc", "ilc", "some runs failed",
                                                            "all runs failed"]
    colours = [line.get_color() for line in key.get_lines()][:3]
    assert colours == [BLUE, VERMILION, GREEN]


def test_shares_go_from_0_to_100_percent(results):
    axes = curves(Content.of(results, Figure(**{**SPEC, "metric": "held"}), [])).axes[0]
    assert axes.get_ylabel() == "held, %"
    assert joined(axes)[2].get_ydata() == pytest.approx(np.full(5, 60.0))
    assert axes.get_ylim()[1] == pytest.approx(102.0)
    assert axes.get_yticks().tolist() == [0, 20, 40, 60, 80, 100]


def test_theory_takes_the_colour_of_its_line(results):
    overlays = [Overlay(label="critical latency", x=[30.0, 33.0], line="mpc"),
                Overlay(label="exact cost", x=[0.0, 20.0], y=[1.0, 5e6])]
    drawing = curves(Content.of(results, Figure(**SPEC), overlays))
    lines = [line for line in drawing.axes[0].lines if line.get_gid() == "overlay"]
    assert [(line.get_xdata()[0], line.get_color(), line.get_linestyle()) for line in lines] == [
        (30.0, VERMILION, "--"), (33.0, VERMILION, "--"), (0.0, "0.15", ":")]
    assert list(lines[2].get_ydata()) == [1.0, 5e6]
    assert drawing.axes[0].get_ylim()[1] < 30.0
    assert {"critical latency", "exact cost"} <= {text.get_text() for text in drawing.legends[0].get_texts()}


def test_wide_intervals_do_not_set_the_scale(tmp_path):
    """Of two replicates an interval of 95 % is nine times as wide as they are apart."""
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": LATENCIES}, 2,
                               lambda levels, replicate: {"error_deg": 10.0 + 10.0 * replicate}))
    assert results.cells("error_deg")[0].high > 70.0
    axes = curves(Content.of(results, Figure(**{**SPEC, "by": None}), [])).axes[0]
    assert axes.get_ylim() == pytest.approx((0.0, 30.0 + 0.06 * 15.0))


def test_negative_values_are_shown(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": LATENCIES}, 1,
                               lambda levels, replicate: {"error_deg": levels["latency_ms"] - 40.0}))
    low, high = curves(Content.of(results, Figure(**{**SPEC, "by": None}), [])).axes[0].get_ylim()
    assert low < -40.0
    assert high > 40.0


def test_over_text_lines_stand_beside_each_other_and_are_not_joined(results):
    axes = curves(Content.of(results, Figure(**{**SPEC, "x": "controller", "by": "latency_ms"}), [])).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["pid", "mpc", "ilc"]
    assert not [line for line in axes.lines if line.get_linestyle() == "-" and line.get_gid() is None
                and len(line.get_xdata()) == 3 and line.get_marker() == "None"]
    markers = [line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 3]
    assert {round(float(x), 6) for each in markers for x in each % 1.0} == {0.76, 0.88, 0.0, 0.12}
    places = {round(float(x % 1.0), 6): to_rgba(line.get_color())
              for line in axes.lines if line.get_marker() != "None" for x in line.get_xdata()}
    colours = [colormaps["viridis"](0.22 * number) for number in range(len(LATENCIES))]
    assert [places[place] for place in (0.76, 0.88, 0.0, 0.12, 0.24)] == colours


def test_where_many_bands_overlap_each_interval_has_a_bar_of_its_own(tmp_path):
    laws = ["p", "pd", "pid", "mpc"]
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": LATENCIES, "law": laws}, 3,
                               lambda levels, replicate: {"error_deg": 5.0 + replicate}))
    axes = curves(Content.of(results, Figure(**{**SPEC, "by": "law"}), [])).axes[0]
    bars = [each for each in axes.collections if each.get_gid() == "bars"]
    ends = np.array([bar.get_segments()[0] for bar in bars])
    cell = results.cells("error_deg")[0]
    assert ends[:, :, 1] == pytest.approx(np.tile([cell.low, cell.high], (4, 1)))
    shown = sorted(bar.get_transform().transform(bar.get_segments()[0])[0, 0] for bar in bars)
    assert np.diff(shown) == pytest.approx(2.2 / 72.0 * axes.figure.dpi)


def test_points_that_were_drawn_are_not_joined(tmp_path):
    cells = [{"latency_ms": x} for x in (3.1, 0.2, 7.9)]
    document = {"study": {"design": "random", "metrics": {"error_deg": "x"}}, "axes": {}}
    results = load(write_cells(tmp_path / "a.sqlite", document, cells, 1,
                               lambda levels, replicate: {"error_deg": levels["latency_ms"]}))
    axes = curves(Content.of(results, Figure(**{**SPEC, "by": None}), [])).axes[0]
    assert {line.get_linestyle() for line in axes.lines} == {"None"}
    assert axes.lines[0].get_xdata().tolist() == [0.2, 3.1, 7.9]


def test_many_levels_are_not_all_labelled(tmp_path):
    axes = {"latency_ms": [*range(0, 1700, 100), 1, 2, 3]}
    results = load(write_store(tmp_path / "a.sqlite", axes, 1, lambda levels, replicate: {"error_deg": 1.0}))
    drawn = curves(Content.of(results, Figure(**{**SPEC, "by": None}), [])).axes[0]
    drawn.figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in drawn.get_xticklabels()]
    assert len(boxes) > 5
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))

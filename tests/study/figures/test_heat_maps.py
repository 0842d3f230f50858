"""Figures are laid out as they are drawn, then looked at."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from study_stores import write_cells, write_store

from fesloop.analysis.study import Figure, load
from fesloop.show.figures import Overlay
from fesloop.show.figures.content import Content
from fesloop.show.figures.heat_maps import _colours, decimals_of, heat_map, interval_text

LATENCIES, JITTERS = [0, 10, 20, 40, 80], [0, 5, 20]
AXES = {"latency_ms": LATENCIES, "jitter_ms": JITTERS, "controller": ["pid", "mpc"]}
REPLICATES = 4
SPEC = {"name": "error", "kind": "heat_map", "metric": "error_deg", "x": "latency_ms", "y": "jitter_ms",
        "panels": "controller"}


def true_error(levels):
    return 1.0 + 0.05 * levels["latency_ms"] + 0.1 * levels["jitter_ms"] + (levels["controller"] == "pid")


def outcome(levels, replicate):
    if levels["latency_ms"] == 80 and levels["controller"] == "pid":
        return "not finite"
    if levels["latency_ms"] == 40 and levels["jitter_ms"] == 20 and replicate == 0:
        return "not finite"
    if levels["latency_ms"] == 0 and levels["jitter_ms"] == 5:
        return None
    shift = 0.1 * (replicate - 0.5 * (REPLICATES - 1)) if levels["latency_ms"] < 40 else 0.0
    return {"error_deg": true_error(levels) + shift, "held": replicate < 3}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "study.sqlite"
    return load(write_store(path, AXES, REPLICATES, outcome, ("error_deg", "held")))


@pytest.fixture(scope="module")
def drawing(results):
    drawn = heat_map(Content.of(results, Figure(**SPEC), []))
    drawn.draw_without_rendering()
    return drawn


def texts(axes, gid):
    return [text for text in axes.texts if text.get_gid() == gid]


def marked(axes, gid):
    return [patch for patch in axes.patches if patch.get_gid() == gid]


def panels_of(drawing):
    return [axes for axes in drawing.axes if axes.get_title(loc="left")]


def test_squares_have_the_values_of_their_cells_in_one_scale_of_colours(drawing):
    meshes = [axes.collections[0] for axes in panels_of(drawing)]
    assert meshes[0].get_clim() == meshes[1].get_clim() == pytest.approx((1.0, 7.0))
    for mesh, controller in zip(meshes, ("pid", "mpc"), strict=True):
        expected = [[true_error({"latency_ms": x, "jitter_ms": y, "controller": controller})
                     for x in LATENCIES] for y in JITTERS]
        found = mesh.get_array()
        known = ~np.ma.getmaskarray(found)
        assert np.ma.allclose(found, expected)
        assert known.sum() == (11 if controller == "pid" else 14)


def test_values_stand_inside_their_squares(drawing):
    ends = np.array([-5.0, 5.0, 15.0, 30.0, 60.0, 100.0]), np.array([-2.5, 2.5, 12.5, 27.5])
    seen = 0
    for axes, controller in zip(panels_of(drawing), ("pid", "mpc"), strict=True):
        for text in texts(axes, "value"):
            x, y = text.xy
            column, row = np.searchsorted(ends[0], x) - 1, np.searchsorted(ends[1], y) - 1
            levels = {"latency_ms": LATENCIES[column], "jitter_ms": JITTERS[row], "controller": controller}
            assert float(text.get_text()) == pytest.approx(true_error(levels), abs=0.005 + 1e-9)
            box = text.get_window_extent()
            (left, low), (right, high) = axes.transData.transform(
                [(ends[0][column], ends[1][row]), (ends[0][column + 1], ends[1][row + 1])])
            assert left - 1 <= box.x0 < box.x1 <= right + 1
            assert low - 1 <= box.y0 < box.y1 <= high + 1
            seen += 1
    assert seen >= 20


def test_all_values_have_one_size(drawing):
    assert len({text.get_fontsize() for axes in panels_of(drawing) for text in texts(axes, "value")}) == 1


def test_hatching_tells_which_share_of_runs_failed(drawing):
    pid, mpc = (marked(axes, "failed") for axes in panels_of(drawing))
    whole = [patch for patch in pid if patch.get_x() == 60.0]
    assert [(patch.get_width(), patch.get_height()) for patch in whole] == [(40.0, 5.0), (40.0, 10.0),
                                                                          (40.0, 15.0)]
    for patch in (next(patch for patch in pid if patch.get_x() == 30.0), mpc[0]):
        assert patch.get_width() == pytest.approx(30.0 / REPLICATES)
        assert (patch.get_y(), patch.get_height() < 3.0) == (12.5, True)
    assert len(mpc) == 1
    assert "share of runs that failed" in [text.get_text() for text in drawing.legends[0].get_texts()]


def test_what_is_not_over_is_marked_as_such(drawing):
    for axes in panels_of(drawing):
        (dash,) = texts(axes, "nothing")
        assert dash.xy == pytest.approx((0.0, 7.5))
    assert caption_of(drawing) == ("mean of 3 to 4 replicates; 14 of 120 runs failed; 8 of 120 runs not over "
                                   "yet")


def caption_of(drawing):
    (caption,) = [text for text in drawing.texts if text.get_gid() == "caption"]
    return caption.get_text().replace("\n", " ")


def test_intervals_stand_below_values_where_all_have_room(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": [0, 20], "law": ["p", "pd"]}, 4,
                               lambda levels, replicate: {"error_deg": 2.0 + 0.1 * replicate}))
    figure = Figure(**{**SPEC, "y": "law", "panels": None})
    drawing = heat_map(Content.of(results, figure, []))
    cells = results.cells("error_deg")
    found = [text.get_text() for text in texts(drawing.axes[0], "interval")]
    assert found == [interval_text(cell, decimals_of(cells)) for cell in cells]
    assert found[0] == "1.94–2.36"
    assert caption_of(drawing) == "mean of 4 replicates; 95 % interval (Student's t)"


def test_the_first_of_named_levels_is_at_the_top(tmp_path):
    results = load(write_store(tmp_path / "a.sqlite", {"latency_ms": [0, 20], "law": ["p", "pd"]}, 1,
                               lambda levels, replicate: {"error_deg": 1.0}))
    axes = heat_map(Content.of(results, Figure(**{**SPEC, "y": "law", "panels": None}), [])).axes[0]
    heights = {label.get_text(): axes.transData.transform((0.0, place))[1]
               for place, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)}
    assert heights["p"] > heights["pd"]


def test_shares_are_in_percent_from_0_to_100(results):
    drawing = heat_map(Content.of(results, Figure(**{**SPEC, "metric": "held"}), []))
    mesh = panels_of(drawing)[1].collections[0]
    assert mesh.get_clim() == (0.0, 100.0)
    assert sorted(set(np.round(mesh.get_array().compressed(), 6))) == [66.666667, 75.0]
    assert {text.get_text() for text in texts(panels_of(drawing)[1], "value")} == {"67", "75"}


def test_a_logarithmic_axis_is_split_in_the_geometric_middle(tmp_path):
    axes = {"size": {"levels": [0.1, 1.0, 10.0], "scale": "log"}, "law": ["p", "pd"]}
    results = load(write_store(tmp_path / "a.sqlite", axes, 1, lambda levels, replicate: {"error_deg": 1.0}))
    content = Content.of(results, Figure(**{**SPEC, "x": "size", "y": "law", "panels": None}), [])
    assert content.x.edges == pytest.approx(10.0 ** np.array([-1.5, -0.5, 0.5, 1.5]))
    drawn = heat_map(content).axes[0]
    assert drawn.get_xscale() == "log"


def test_theory_is_drawn_where_it_belongs(results):
    overlays = [Overlay(label="critical latency", x=[30.0, 60.0], y=[0.0, 20.0], panel="mpc"),
                Overlay(label="limit", x=[15.0])]
    pid, mpc = panels_of(heat_map(Content.of(results, Figure(**SPEC), overlays)))
    lines = {axes: [line for line in axes.lines if line.get_gid() == "overlay"] for axes in (pid, mpc)}
    assert len(lines[pid]) == 1
    assert lines[pid][0].get_xdata() == [15.0, 15.0]
    assert lines[mpc][0].get_xdata().tolist() == [30.0, 60.0]
    assert lines[mpc][0].get_ydata().tolist() == [0.0, 20.0]
    even = panels_of(heat_map(Content.of(results, Figure(**SPEC, spacing="even"), overlays)))[1]
    line = next(line for line in even.lines if line.get_gid() == "overlay")
    assert line.get_xdata().tolist() == [2.5, 3.5]
    assert line.get_ydata().tolist() == [0.0, 2.0]


def test_ends_of_the_scale_may_be_given_and_what_is_beyond_has_an_arrow(results):
    drawing = heat_map(Content.of(results, Figure(**SPEC, low=2.0, high=4.0), []))
    assert panels_of(drawing)[0].collections[0].get_clim() == (2.0, 4.0)
    (bar,) = [axes for axes in drawing.axes if axes.get_ylabel() == "error, deg"]
    assert bar._colorbar.extend == "both"


def test_points_that_were_drawn_are_dots(tmp_path):
    points = np.random.default_rng(0).random((12, 2))
    cells = [{"latency_ms": x, "jitter_ms": y} for x, y in points.tolist()]
    document = {"study": {"design": "sobol", "metrics": {"error_deg": "x"}}, "axes": {}}
    results = load(write_cells(tmp_path / "a.sqlite", document, cells, 1, lambda levels, replicate: (
        "lost" if levels["latency_ms"] > 0.8 else {"error_deg": levels["jitter_ms"]})))
    axes = heat_map(Content.of(results, Figure(**{**SPEC, "panels": None}), [])).axes[0]
    dots, crosses = axes.collections
    lost = points[:, 0] > 0.8
    assert 0 < lost.sum() < 12
    assert sorted(map(tuple, dots.get_offsets().tolist())) == sorted(map(tuple, points[~lost].tolist()))
    assert dots.get_array().tolist() == dots.get_offsets()[:, 1].tolist()
    assert sorted(map(tuple, crosses.get_offsets().tolist())) == sorted(map(tuple, points[lost].tolist()))


def luminance(colour):
    """Relative, as WCAG 2.1 defines it."""
    channels = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def test_colours_grow_darker_all_the_way():
    """So that they are told apart in print and by the colour-blind."""
    assert (np.diff([luminance(colour[:3]) for colour in _colours()(np.linspace(0.0, 1.0, 40))]) < 0.0).all()


def test_text_can_be_read_on_its_square(drawing):
    """A contrast of 3 is WCAG's least for large text and graphics."""
    for axes in panels_of(drawing):
        mesh = axes.collections[0]
        for text in texts(axes, "value"):
            under = luminance(mesh.cmap(mesh.norm(float(text.get_text())))[:3])
            over = luminance(text.get_color())
            assert (max(under, over) + 0.05) / (min(under, over) + 0.05) > 3.0

"""What a study's page tells is what its runs gave, known here beforehand."""

import time
import tomllib

import numpy as np
import pytest
from study_stores import write_cells, write_store

from fesloop.analysis.study import load
from fesloop.show.figures.content import Overlay
from fesloop.show.figures.theory_overlays import keep_overlays
from fesloop.show.report.page import page_html
from fesloop.show.report.parts import Bars, Chart, Code, Fold, HeatMap, Notice, Paragraph, Table
from fesloop.show.report.study.page import study_page

CREATED = "2026-01-01T00:00:00+00:00"
CURVES = {"name": "curves", "kind": "curves", "metric": "error_deg", "x": "latency_ms", "by": "law"}


def parts_of(page, kind):
    """Parts of a kind anywhere on the page."""
    def within(parts):
        for part in parts:
            if isinstance(part, kind):
                yield part
            if isinstance(part, Fold):
                yield from within(part.parts)
    return [part for section in page.sections for part in within(section.parts)]


def section(page, key):
    (found,) = [each for each in page.sections if each.key == key]
    return found


def test_the_sentence_names_question_and_answer(make):
    sentence = study_page(make()).sentence
    assert "latency (3 levels), jitter (2 levels) and law (2 levels)" in sentence
    assert "Error is best at latency 0 ms, jitter 0 ms, law mpc: 1.25 deg" in sentence
    assert "worst at latency 40 ms, jitter 5 ms, law pid: 6.55 deg" in sentence


def test_more_is_better_of_a_quality(make):
    study = {"study": {"name": "s", "design": "grid", "metrics": {"quality": "found_true_quality"}}}
    path = make(lambda levels, replicate: {"quality": 0.1 * levels["jitter_ms"]}, figures=(), study=study)
    assert "Quality is best at latency 0 ms, jitter 5 ms" in study_page(path).sentence


def test_neither_end_is_called_good_of_what_is_not_known(make):
    study = {"study": {"name": "s", "design": "grid", "metrics": {"angle_deg": "grasp_angle"}}}
    path = make(lambda levels, replicate: {"angle_deg": levels["jitter_ms"] + 1.0}, figures=(), study=study)
    assert "Angle is lowest at" in study_page(path).sentence


def test_a_heat_map_has_each_value_in_its_place(make):
    maps = parts_of(study_page(make()), HeatMap)
    pid, mpc, laws = maps
    assert [each.title for each in (pid, mpc)] == ["pid", "mpc"]
    assert mpc.x_levels == ["0", "20", "40"]
    assert mpc.y_levels == ["0", "5"]
    np.testing.assert_allclose(mpc.values, [[1.25, 3.25, 5.25], [1.30, 3.30, 5.30]])
    assert mpc.cells[1][2] == "5.30"
    assert pid.cells[0][2].endswith("*"), "some runs failed there"
    assert "1 of 2 runs failed" in pid.told[0][2]
    assert (pid.low, pid.high) == (mpc.low, mpc.high) == (pytest.approx(1.25), pytest.approx(6.55))
    # Text reads from above; rows are counted from below.
    assert laws.y_levels == ["mpc", "pid"]
    np.testing.assert_allclose(laws.values[0], [1.275, 3.275, 5.275])


def test_theory_lies_between_the_levels_where_it_belongs(with_theory):
    page = study_page(with_theory)
    pid, mpc, _ = parts_of(page, HeatMap)
    (contour,) = pid.contours
    np.testing.assert_allclose(contour.x, [1.5, 0.5])
    np.testing.assert_allclose(contour.y, [0.0, 1.0])
    assert not mpc.contours
    (curves,) = [chart for chart in parts_of(page, Chart) if chart.key.startswith("figure-curves")]
    (upright,) = [line for line in curves.lines if line.style == "dashed"]
    np.testing.assert_array_equal(upright.x[:2], [25.0, 25.0])
    np.testing.assert_array_equal(upright.y[:2], curves.limits)
    (mpc_line,) = [line for line in curves.lines if line.name == "mpc"]
    assert upright.role == mpc_line.role


def test_theory_of_another_store_is_not_drawn(with_theory):
    keep_overlays(with_theory.parent, "another day", {"map": [Overlay(label="theory", x=[30.0])]})
    assert not any(each.contours for each in parts_of(study_page(with_theory), HeatMap))


def test_damaged_theory_takes_no_figure_with_it(with_theory):
    (with_theory.parent / "theory.json").write_text("{")
    page = study_page(with_theory)
    assert len(parts_of(page, HeatMap)) == 3
    assert any("Theory is not drawn" in notice.text for notice in parts_of(page, Notice))


def test_curves_are_estimates_with_their_intervals(make):
    path = make()
    charts = parts_of(study_page(path), Chart)
    chart = next(chart for chart in charts if chart.key.startswith("figure-curves"))
    for law, line in zip(("pid", "mpc"), chart.lines, strict=True):
        cells = [cell for cell in load(path).cells("error_deg", ["latency_ms", "law"])
                 if cell.levels["law"] == law]
        np.testing.assert_array_equal(line.x, [cell.levels["latency_ms"] for cell in cells])
        np.testing.assert_allclose(line.y, [cell.value for cell in cells])
        np.testing.assert_allclose(line.low, [cell.low for cell in cells])
        np.testing.assert_allclose(line.high, [cell.high for cell in cells])


def test_curves_over_text_are_points_beside_each_other(make):
    chart = next(chart for chart in parts_of(study_page(make()), Chart)
                 if chart.key.startswith("figure-over_laws"))
    assert chart.x_levels == ["pid", "mpc"]
    assert {line.style for line in chart.lines} == {"points"}
    xs = np.stack([line.x for line in chart.lines])
    np.testing.assert_array_equal(xs.round(), [[0.0, 1.0], [0.0, 1.0]])
    assert (xs[0] != xs[1]).all()


def test_pairs_tell_what_a_level_costs(make):
    parts = section(study_page(make()), "comparisons").parts
    tables = {table.title.partition(":")[0]: table for table in parts if isinstance(table, Table)}
    latency = tables["latency, ms"]
    assert [row[:3] for row in latency.rows] == [["20", "0", "2.00"], ["40", "20", "2.00"]]
    (law,) = tables["law"].rows
    assert law[:3] == ["pid", "mpc", "1.00"]
    assert law[-1] == "2 first failed"


def test_failures_are_told_by_cause_and_place(make):
    parts = section(study_page(make()), "failures").parts
    (table,) = [part for part in parts if isinstance(part, Table)]
    assert table.rows == [["2", "the QP is infeasible", "latency 40 ms; law pid"]]
    (bars,) = [part for part in parts if isinstance(part, Bars)]
    assert list(bars.values["failed"]) == [0.0, 0.0, 25.0]


def test_nothing_is_said_of_failures_where_there_were_none(make):
    page = study_page(make(lambda levels, replicate: {"error_deg": error_of(levels)}))
    assert not [each for each in page.sections if each.key == "failures"]


def error_of(levels):
    return 1.0 + levels["latency_ms"]


def test_simulation_is_told_beside_theory(make):
    cost = {**CURVES, "theory": "stationary_cost"}
    path = make(figures=[cost])
    # The mean of both laws' replicates over jitter under mpc is 1.275 + 0.1 latency.
    keep_overlays(path.parent, CREATED, {"curves": [
        Overlay(label="exact", x=[0.0, 20.0], y=[1.0, 4.0], line="mpc")]})
    told = [part.text for part in parts_of(study_page(path), Paragraph)]
    assert "Simulation lies -18.1 to +27.5 % off theory at 2 cells; theory lies within 2 of 2 intervals." \
        in told


def test_one_value_each_has_no_interval(make):
    page = study_page(make(lambda levels, replicate: {"error_deg": error_of(levels)}, replicates=1))
    tables = [part for part in section(page, "comparisons").parts if isinstance(part, Table)]
    assert all("95 % interval" not in table.columns for table in tables)
    assert not [part.text for part in parts_of(page, Paragraph) if "interval" in part.text]


def test_what_was_run_is_there_to_be_run_again(make):
    codes = parts_of(study_page(make()), Code)
    document = tomllib.loads(codes[0].text)
    assert [figure["name"] for figure in document["figures"]] == ["map", "laws", "curves", "over_laws"]
    assert any("from fesloop.analysis.study import load" in code.text for code in codes)


def test_titles_are_by_their_axes_and_read_as_no_ratio(make):
    named = {"label": "motion at rest, RMS", "unit": "deg"}
    page = study_page(make(figures=[CURVES | named, CURVES | {"name": "b"}]))
    assert [each.title for each in page.sections[:2]] == ["Motion at rest, RMS, by latency",
                                                          "Error by latency"]
    texts = [chart.text for chart in parts_of(page, Chart)]
    assert texts[0].startswith("Motion at rest, RMS, deg, by latency, ms: pid ")
    assert not [text for text in [*texts, *(each.title for each in page.sections)] if " over " in text]


def test_titles_of_maps_are_by_both_axes(make):
    page = study_page(make())
    assert [each.title for each in page.sections[:2]] == ["Error by latency and jitter",
                                                          "Error by latency and law"]
    assert not [each.text for each in parts_of(page, HeatMap) if " over " in each.text]


def test_a_study_without_figures_gets_some(make):
    charts = parts_of(study_page(make(figures=())), Chart)
    assert {chart.y_label for chart in charts} == {"error, deg", "held, %"}
    assert all(chart.x_label == "latency, ms" for chart in charts)


def test_points_that_were_drawn_are_shown_over_each_axis(tmp_path):
    figure = {"name": "map", "kind": "heat_map", "metric": "error_deg", "x": "gain", "y": "latency_ms"}
    document = {"study": {"name": "s", "design": "sobol", "metrics": {"error_deg": "x"}},
                "axes": {"gain": {}, "latency_ms": {}}, "figures": [figure]}
    cells = [{"gain": gain, "latency_ms": latency} for gain, latency in ((0.1, 5.0), (0.2, 1.0), (0.4, 3.0))]
    path = write_cells(tmp_path / "study.sqlite", document, cells, 1,
                       lambda levels, replicate: {"error_deg": levels["gain"]})
    gain, latency = parts_of(study_page(path), Chart)
    assert (gain.title, latency.title) == ("Error by gain", "Error by latency")
    np.testing.assert_allclose(gain.lines[0].x, gain.lines[0].y)
    assert sorted(latency.lines[0].x) == [1.0, 3.0, 5.0]


def test_every_part_fits_a_page(with_theory):
    html = page_html(study_page(with_theory))
    assert "the QP is infeasible" in html


def test_what_a_store_says_is_text(make):
    cause = "<script>alert(1)</script>"
    html = page_html(study_page(make(lambda levels, replicate: cause)))
    assert cause not in html
    assert "&lt;script&gt;" in html


def test_five_thousand_runs_take_seconds_and_a_small_page(tmp_path):
    axes = {"latency_ms": list(range(0, 250, 25)), "jitter_ms": [0, 25, 50, 75, 100], "law": list("abcde"),
            "member": {"levels": [0, 1], "cohort": {"patient": "sci_c6", "members": 2}}}
    figures = [{"name": "map", "kind": "heat_map", "metric": "error_deg", "x": "latency_ms", "y": "jitter_ms",
                "panels": "law"}]
    path = write_store(tmp_path / "study.sqlite", axes, 10,
                       lambda levels, replicate: {"error_deg": levels["latency_ms"] + replicate},
                       study={"figures": figures})
    begun = time.process_time()
    page = study_page(path)
    html = page_html(page)
    assert time.process_time() - begun < 30.0
    assert len(html) < 2e6
    assert load(path).planned == 5000
    assert len(parts_of(page, HeatMap)) == 5
    assert parts_of(page, Paragraph)

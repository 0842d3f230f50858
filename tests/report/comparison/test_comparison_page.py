"""Runs side by side: what differs is told, what is common is drawn together, what is neither is said."""

from contextlib import ExitStack

import numpy as np
import pytest

import fesloop
from fesloop import Recording
from fesloop.errors import InputError
from fesloop.show.report.comparison.differences import differing
from fesloop.show.report.comparison.page import comparison_page
from fesloop.show.report.page import page_html
from fesloop.show.report.parts import Bars, Chart, Fold, Notice, Table

SHORT = ("experiment.duration_s=2", "score.after_s=0.5")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs an experiment with settings; its recording's path."""
    def made(name, *settings):
        return fesloop.load(name, settings).run(tmp_path_factory.mktemp("runs")).recording
    return made


@pytest.fixture(scope="module")
def pid(run):
    return run("finger_control", "control=pid", "latency_ms=0", *SHORT)


@pytest.fixture(scope="module")
def late(run):
    return run("finger_control", "control=pid", "latency_ms=100", *SHORT)


@pytest.fixture(scope="module")
def mpc(run):
    return run("finger_control", "control=mpc", *SHORT)


@pytest.fixture(scope="module")
def loop(run):
    return run("linear_loop", "experiment.duration_s=6")


def page_of(*paths):
    with ExitStack() as stack:
        return comparison_page([stack.enter_context(Recording(path)) for path in paths])


def of(page, key, kind):
    (section,) = [section for section in page.sections if section.key == key]
    return [part for part in section.parts if isinstance(part, kind)]


def test_runs_whose_trials_ended_at_different_instants_are_scored_over_different_spans(run):
    until = ("control=pid", "score.after_s=0.5", "score.until_s=1.5")
    whole, short = (run("finger_control", f"experiment.duration_s={end}", *until) for end in (1.6, 1))
    also = run("finger_control", "experiment.duration_s=2", "latency_ms=5", *until)
    told = [part.text for part in of(page_of(whole, short), "metrics", Notice)]
    assert any("different parts of a trial" in text and "0.5 s to 1 s" in text for text in told)
    assert not [part for part in of(page_of(whole, also), "metrics", Notice) if "different" in part.text]


def error_deg(path):
    from fesloop.experiment.metrics.scoring import metrics_of

    with Recording(path) as recording:
        return metrics_of(recording)["joint_rmse_deg"][-1]


def test_the_sentence_names_the_least_and_the_greatest_error(pid, late):
    page = page_of(pid, late)
    names = [name for name, _ in page.facts]
    assert len(set(names)) == 2, "files of the same name are told apart by their folders"
    (least, best), (greatest, worst) = sorted((error_deg(path), name)
                                              for path, name in zip((pid, late), names, strict=True))
    assert f"is least in {best}, {least:.2f} deg RMS" in page.sentence
    assert f"greatest in {worst}, {greatest:.2f} deg" in page.sentence


def test_the_sentence_says_which_trials_it_compares(pid, run):
    two = run("finger_ilc", "trials=2", *SHORT)
    other = run("finger_ilc", "trials=2", "law=phase_lead", *SHORT)
    assert "in the last of 2 trials" in page_of(two, other).sentence
    page = page_of(pid, two)
    (one, _), (later, _) = page.facts[:2]
    assert f"in the last trial of each (0 of {one} and 1 of {later})" in page.sentence


def test_one_key_that_differs_is_one_row(pid, late):
    (table,) = of(page_of(pid, late), "differences", Table)
    assert [row[1:] for row in table.rows] == [["0.0", "100.0"]]
    assert "latency_ms" in table.rows[0][0]


def test_parameters_of_another_kind_of_block_are_apart(pid, mpc):
    page = page_of(pid, mpc)
    (table,) = of(page, "differences", Table)
    assert ["blocks.controller.kind", "pid", "mpc"] in table.rows
    assert not [row for row in table.rows if row[0] == "blocks.controller.kp"]
    folded = [row for fold in of(page, "differences", Fold) for part in fold.parts for row in part.rows]
    assert [row for row in folded if row[0] == "blocks.controller.kp"]


def test_runs_of_the_same_experiment_differ_in_nothing(pid):
    page = page_of(pid, pid)
    assert not of(page, "differences", Table)
    assert "is" in page.sentence
    assert "in all of them" in page.sentence


def test_joints_of_the_same_name_are_drawn_over_each_other_with_one_reference(pid, late):
    charts = of(page_of(pid, late), "joints", Chart)
    assert [chart.title for chart in charts] == ["MCP", "PIP", "DIP"]
    with Recording(late) as recording:
        truth = np.degrees(recording.signal("patient.angles", 0).values[:, 0])
    for chart in charts:
        assert chart.lines[0].name == "reference"
        assert len(chart.lines) == 3
    drawn = charts[0].lines[2]
    low = drawn.y if drawn.low is None else drawn.low
    high = drawn.y if drawn.high is None else drawn.high
    assert np.nanmin(low) == pytest.approx(truth.min(), abs=1e-6)
    assert np.nanmax(high) == pytest.approx(truth.max(), abs=1e-6)


def test_metrics_stand_side_by_side(pid, late):
    (table,) = of(page_of(pid, late), "metrics", Table)
    row = next(row for row in table.rows if row[0] == "joint RMSE, deg")
    assert [float(cell) for cell in row[1:]] == pytest.approx([error_deg(pid), error_deg(late)], rel=5e-3)


def test_one_trial_each_is_bars_and_more_are_lines(pid, late, run):
    assert of(page_of(pid, late), "trials", Bars)
    learning = run("finger_ilc", "trials=2")
    (chart, *_) = of(page_of(pid, learning), "trials", Chart)
    assert [len(line.x) for line in chart.lines] == [1, 2]


def test_different_experiments_are_allowed_and_said(pid, loop):
    page = page_of(pid, loop)
    told = " ".join(notice.text for section in page.sections for notice in section.parts
                    if isinstance(notice, Notice))
    assert "different experiments, finger_control and linear_loop" in told
    assert page_html(page)


def test_one_run_is_nothing_to_compare(pid):
    with pytest.raises(InputError, match="two or more"):
        page_of(pid)


def test_what_only_one_has_is_told_as_missing():
    one = {"blocks": {"a": {"kind": "x", "gain": 1.0}, "b": {"kind": "y"}},
           "wires": [{"from": "a.u", "to": "b.v", "loss": 0.1}]}
    other = {"blocks": {"a": {"kind": "x", "gain": 2.0}}, "wires": [], "seed": 3}
    rows, of_others = differing([one, other])
    assert dict(rows) == {"blocks.b.kind": ["y", None], "wire a.u → b.v": ["there", None],
                          "blocks.a.gain": [1.0, 2.0], "seed": [None, 3]}
    assert of_others == []


def test_wires_are_compared_by_their_ends():
    wires = [{"from": "a.u", "to": "b.v", "loss": 0.1}, {"from": "a.u", "to": "c.v", "loss": 0.0}]
    changed = [wires[1], {**wires[0], "loss": 0.3}]
    assert differing([{"wires": wires}, {"wires": changed}]) == ([("wire a.u → b.v: loss", [0.1, 0.3])], [])

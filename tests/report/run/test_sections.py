"""Numbers in a page's sections against the recording and the metrics, computed another way."""

import math
import re
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fesloop
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Event, Recording
from fesloop.loop.latency import StageSummary
from fesloop.show.report.parts import Bars, Line, Paragraph, Table
from fesloop.show.report.run import (
    events,
    fatigue,
    latency,
    lateness,
    result,
    tracker,
    tracking,
)
from fesloop.show.report.run import (
    result as trials,
)
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.result import split_section
from fesloop.show.report.run.thinning import Course


@pytest.fixture(scope="module")
def known(learning):
    with Recording(learning) as recording:
        yield known_of(recording)


def test_the_shares_of_each_trial_are_its_own(known):
    bars = {part.trial: part for part in split_section(known).parts if isinstance(part, Bars)}
    split, joints = known.metrics["split_rmse_deg"], known.metrics["joints"].values()
    for trial in range(3):
        for part, shown in zip(("total", "tracker", "controller"), bars[trial].values.values(), strict=True):
            assert shown == [split[part][trial], *(each[f"split_{part}_deg"][trial] for each in joints)]


def test_a_tracker_is_held_against_the_truth_of_its_capture(known):
    chart = next(part for part in tracker.tracker_section(known).parts
                 if getattr(part, "key", "") == "tracker-course-1")
    truth = known.recording.signal(known.score["truth"], 1)
    estimate = known.recording.signal(known.score["estimate"], 1)
    seconds, errors = [], []
    for capture, values in zip(estimate.newest_ns, estimate.values, strict=True):
        if capture >= truth.times_ns[0]:
            then = truth.values[truth.times_ns <= capture][-1]
            seconds.append(capture / 1e9)
            errors.append(math.degrees(math.sqrt(np.mean((values - then) ** 2))))
    line = chart.lines[0]
    assert line.high is None  # 600 rows in 600 points
    there = np.isfinite(line.y)
    assert line.x[there] == pytest.approx(seconds)
    assert line.y[there] == pytest.approx(errors)


def test_limits_hold_all_of_the_truth_and_not_what_an_estimate_does_now_and_then():
    x, wave = np.arange(600.0), np.sin(np.arange(600.0))
    truth, estimate = 20.0 * wave, 20.0 * wave
    truth[7], estimate[9] = 60.0, 9000.0
    lines = [Line(name=role, role=role, x=x, y=y) for role, y in (("truth", truth), ("estimate", estimate))]
    low, high = tracking._limits(lines)
    assert -40.0 < low < -20.0
    assert 60.0 < high < 80.0


@pytest.mark.parametrize(("estimate", "told"), [
    (0.0, ""), (9000.0, " (estimate up to 9000 deg, cut off)"),
    (-300.0, " (estimate down to -300 deg, cut off)")])
def test_what_is_cut_off_of_an_estimate_is_said(known, estimate, told):
    wave = 20.0 * np.sin(np.arange(600.0))[:, np.newaxis]
    astray = wave.copy()
    astray[9] = estimate
    found = {role: Course(np.arange(600.0), np.radians(values), None, None)
             for role, values in (("truth", wave), ("estimate", astray))}
    angles = tracking._Angles("", "patient.angles", "tracker.angles", "hand")
    chart = tracking._chart(known, angles, 1, found, 0, "F2_mcp_flexion")
    assert chart.title == f"F2 MCP flexion{told}"
    inside = astray[(astray >= chart.limits[0]) & (astray <= chart.limits[1])]
    assert len(inside) == 600 - bool(told)


def test_events_are_counted_with_the_first_and_the_last_of_their_kind():
    told = [Event(0, 1_000_000_000, "imu", "lost", ""), Event(0, 2_000_000_000, "imu", "lost", "again"),
            Event(1, 500_000_000, "wire", "late", ""), Event(3, 250_000_000, "imu", "lost", "")]
    table = next(part for part in events._events(told) if isinstance(part, Table))
    assert [[cell.replace("\N{NO-BREAK SPACE}", " ") for cell in row] for row in table.rows] == [
        ["imu `lost`", "3", "0: 1.000 s", "3: 0.250 s"], ["wire `late`", "1", "1: 0.500 s", "1: 0.500 s"]]


def test_of_many_events_of_one_kind_the_first_are_told_and_all_are_counted():
    told = [Event(0, number, "imu", "lost", "") for number in range(1000)]
    table, fold = events._events(told)
    assert [row[1] for row in table.rows] == ["1000"]
    assert fold.title == "The first 400 of 1000 events"
    assert Counter(len(part.rows) for part in fold.parts) == {400: 1}


def test_the_weakest_muscle_is_that_of_the_last_trial(known, monkeypatch):
    ends = np.ones((2, 3))
    ends[0, 0], ends[1, 2] = 0.2, 0.4
    monkeypatch.setattr(fatigue, "_end", lambda known, name, trial: ends[trial])
    monkeypatch.setattr(fatigue, "course", lambda *_: None)
    parts = list(fatigue._parts(replace(known, begun=2), "patient.fitness"))
    assert "the least is 0.400 (muscle 2)" in next(part.text for part in parts if isinstance(part, Paragraph))
    chart = next(part for part in parts if getattr(part, "key", "") == "fatigue-trials")
    assert {line.name: line.y.tolist() for line in chart.lines} == {
        "muscle 0": [0.2, 1.0], "muscle 2": [1.0, 0.4]}


def test_a_trial_of_whose_end_nothing_is_known_is_left_out(known, monkeypatch):
    ends = np.array([[0.9, 1.0], [np.nan, np.nan], [0.8, 1.0], [np.nan, 1.0]])
    monkeypatch.setattr(fatigue, "_end", lambda known, name, trial: ends[trial])
    monkeypatch.setattr(fatigue, "course", lambda *_: None)
    parts = list(fatigue._parts(replace(known, begun=4), "patient.fitness"))
    assert "At the end of trial 2 the least is 0.800" in parts[0].text
    (line,) = parts[1].lines
    assert (line.x.tolist(), line.y.tolist()) == ([0.0, 2.0], [0.9, 0.8])


def test_a_stage_begins_where_the_means_of_those_before_it_end():
    stages = (StageSummary("one", 0, 4e6, 9_000_000), StageSummary("two", 0, 6e6, 7_000_000),
              StageSummary("total", 0, 10e6, 16_000_000))
    shown = latency._time_line(stages)
    found = re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', shown)
    bars = [tuple(map(float, each)) for each in found]
    left, scale = latency._LEFT, bars[2][1] / 10.0
    assert [x for x, _ in bars] == pytest.approx([left, left + 4.0 * scale, left], abs=0.1)
    assert [wide for _, wide in bars] == pytest.approx([4.0 * scale, 6.0 * scale, 10.0 * scale], abs=0.1)


def test_the_way_that_is_shown_first_is_the_slowest_through_the_estimate(known):
    def way(name, mean_ns):
        return name, (StageSummary("total", 0, mean_ns, 1),)

    ways = [way("patient → imus → tracker → controller", 5e6),
            way("patient → slow → tracker → controller", 9e6),
            way("patient → camera → controller", 50e6)]
    assert latency._foremost(known, ways) == ways[1]


def test_the_error_of_an_only_trial_is_that_of_each_instant(recorded):
    with Recording(recorded("finger_control", "experiment.duration_s=2", "score.after_s=0")) as recording:
        section = result.result_section(known_of(recording))
        score = recording.experiment["score"]
        truth, wanted = (recording.signal(score[key]) for key in ("truth", "reference"))
    line = next(part for part in section.parts if getattr(part, "key", "") == "result").lines[0]
    errors = [math.degrees(math.sqrt(np.mean((values - wanted.values[wanted.times_ns <= now][-1]) ** 2)))
              if wanted.times_ns[0] <= now else math.nan
              for now, values in zip(truth.times_ns, truth.values, strict=True)]
    assert (line.low is None) == (len(errors) <= 600)
    per_point = -(-len(errors) // 600)
    groups = [errors[first:first + per_point] for first in range(0, len(errors), per_point)]
    assert line.y == pytest.approx([np.mean(group) for group in groups])
    assert line.high == pytest.approx([max(group) for group in groups])


def test_lateness_is_in_milliseconds_by_trial():
    rows = np.array([(0, 0, 0, 0), (1, 10**9, 2_500_000, 1_000_000), (1, 2 * 10**9, 0, 500_000)],
                    dtype=[(name, "i8") for name in ("trial", "time_ns", "late_ns", "took_ns")])
    (chart,) = lateness._courses(SimpleNamespace(recording=SimpleNamespace(instants=rows), trials=(1,)))
    late, took = chart.lines
    assert (late.x.tolist(), late.y.tolist(), took.y.tolist()) == ([1.0, 2.0], [2.5, 0.0], [1.0, 0.5])


def test_of_many_trials_the_first_and_the_last_stand_in_the_table():
    metrics = {"joint_rmse_deg": [float(trial) for trial in range(200)]}
    (table,) = trials._tables(SimpleNamespace(metrics=metrics, begun=200))
    assert [int(row[0]) for row in table.rows] == [*range(30), *range(170, 200)]
    assert [float(row[1]) for row in table.rows] == [*range(30), *range(170, 200)]
    assert "140 trials" in table.title


@given(st.integers(2, 14), st.integers(1, 30))
def test_a_table_has_a_column_a_trial_where_it_has_more_metrics(begun, count):
    """26 columns of metrics were cut off."""
    metrics = {f"metric_{number}": [float(100 * number + trial) for trial in range(begun)]
               for number in range(count)}
    (table,) = trials._tables(SimpleNamespace(metrics=metrics, begun=begun))
    across = len(table.rows) == count and table.columns[1:] == [str(trial) for trial in range(begun)]
    assert across or len(table.rows) == begun
    assert len(table.columns) <= max(11, begun + 1) or begun > 10
    cells = table.rows if across else list(zip(*table.rows, strict=True))[1:]
    names = [row[0] for row in table.rows] if across else table.columns[1:]
    assert len(set(names)) == count
    for row, values in zip(cells, metrics.values(), strict=True):
        assert [float(cell) for cell in (row[1:] if across else row)] == pytest.approx(values, abs=0.5)


def test_elements_that_a_search_found_are_in_its_table():
    metrics = {"queries": [3], "found_elements": [[9, 16]], "element_quality": [[None, 0.5]]}
    (table,) = trials._tables(SimpleNamespace(metrics=metrics, begun=1))
    assert [row[1] for row in table.rows] == ["3", "9, 16"]
    (table,) = trials._tables(SimpleNamespace(metrics={"found_elements": [[]]}, begun=1))
    assert [row[1] for row in table.rows] == ["none"]


ONE = """
[experiment]
name = "one"
duration_s = 1
[blocks.reference]
kind = "minimum_jerk"
rate = "50"
times_s = [0.2, 0.8]
angles_deg = [[20], [30]]
[blocks.tracker]
kind = "ideal"
rate = "100"
[blocks.controller]
kind = "pid"
rate = "50"
kp = [2.0]
ki = [1.0]
kd = [0.0]
mixing = [[1.0]]
current_ma = [20]
recruitment_curve = "linear"
[blocks.plant]
kind = "state_space"
a = [[-2.0]]
b = [[2.0]]
c = [[1.0]]
recruitment = { threshold_ma = [10], spread = [0.5] }
output_unit = "rad"
[score]
truth = "plant.y"
reference = "reference.angles"
estimate = "tracker.angles"
[[wires]]
from = "reference.angles"
to = "controller.reference"
[[wires]]
from = "plant.y"
to = "tracker.angles"
[[wires]]
from = "tracker.angles"
to = "controller.measured"
latency_ms = 10
[[wires]]
from = "controller.stimulation"
to = "plant.stimulation"
latency_ms = 1
"""


def test_a_plant_of_one_output_is_drawn_with_its_own_errors(tmp_path):
    (tmp_path / "one.toml").write_text(ONE)
    done = load(str(tmp_path / "one.toml")).run(tmp_path)
    with Recording(done.recording) as recording:
        known = known_of(recording)
        course = result.result_section(known).parts[0]
        charts = tracking.tracking_section(known).parts[1:]
        own = tracker.tracker_section(known).parts
    drawn = np.sqrt(np.mean(course.lines[0].y[np.isfinite(course.lines[0].y)] ** 2))
    assert drawn == pytest.approx(done.metrics["joint_rmse_deg"][0], rel=1e-4)
    assert {line.name for line in charts[0].lines} == {"reference", "truth", "estimate"}
    (line,) = next(part for part in own if getattr(part, "key", "") == "tracker-course-0").lines
    assert line.y[np.isfinite(line.y)] == pytest.approx(0.0, abs=1e-9)


def test_a_metric_has_its_definition_where_a_pointer_rests_on_it(tmp_path):
    recording = fesloop.load("finger_ilc", ["experiment.trials=2"]).run(tmp_path).recording
    fesloop.report(recording, out=tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert 'title="Error of the movement: true joint angles less the reference' in page
    assert "controller: that estimate less the reference" in page

"""What is not known of a run is drawn as nothing, and hides nothing of what is."""

import math
import shutil
from functools import partial

import h5py
import numpy as np

from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.comparison.page import comparison_page
from fesloop.show.report.parts import Bars
from fesloop.show.report.run import tracker
from fesloop.show.report.run.known import Known, known_of
from fesloop.show.report.run.page import run_page
from fesloop.show.report.run.result import split_section


def known_with(metrics):
    """A run of one trial of which only metrics are known."""
    return Known(None, 1, (0,), None, metrics, {}, (), frozenset())


def test_an_error_that_is_not_known_is_no_bar_of_length_nought():
    shares = ("total", "tracker", "controller")
    joints = {"MCP": {f"split_{share}_deg": [1.0] for share in shares},
              "PIP": {f"split_{share}_deg": [math.nan] for share in shares}}
    every = {share: [1.0] for share in shares}
    section = split_section(known_with({"split_rmse_deg": every, "joints": joints}))
    (bars,) = (part for part in section.parts if isinstance(part, Bars))
    for values in bars.values.values():
        assert values[:2] == [1.0, 1.0]
        assert math.isnan(values[2])


def test_fingertips_of_which_nothing_is_known_have_no_bars():
    tips = {"one": {"F1": [math.nan], "F2": [math.nan]}}
    section = tracker.tracker_section(known_with({"fingertip_rmse_mm": tips}))
    assert section is None or not any(isinstance(part, Bars) for part in section.parts)


def test_rows_without_a_capture_take_no_peak_of_their_neighbours_with_them(learning, tmp_path, monkeypatch):
    monkeypatch.setattr(tracker, "thinned", partial(tracker.thinned, points=50))
    path = tmp_path / "late.h5"
    shutil.copy(learning, path)
    with Recording(learning) as recording:
        name = recording.experiment["score"]["estimate"]
    node, _, port = name.partition(".")
    with h5py.File(path, "r+") as file:
        rows = file[f"blocks/{node}"]
        mine = rows[:]
        first = np.flatnonzero(mine["trial"] == 0)[:2]
        mine["newest_ns"][first[0]] = -1
        mine["newest_ns"][first[1]] = mine["time_ns"][first[1]]
        mine[port][first[1]] = 50.0
        rows[:] = mine
    with Recording(path) as recording:
        section = tracker.tracker_section(known_of(recording))
    chart = next(part for part in section.parts if getattr(part, "key", "") == "tracker-course-0")
    line = chart.lines[0]
    assert np.nanmax(line.high) > math.degrees(40.0)


def test_stimulation_beyond_floats_is_reported_without_a_warning(recorded, tmp_path):
    path = tmp_path / "damaged.h5"
    shutil.copy(recorded("finger_pid_latency", "experiment.duration_s=0.6"), path)
    with h5py.File(path, "r+") as file:
        rows = file["blocks/safety"]
        mine = rows[:]
        mine["stimulation"] = 1e308
        rows[:] = mine
    with Recording(path) as recording:
        assert "stimulation" in {section.key for section in run_page(recording).sections}
        assert comparison_page([recording, recording]).sections

"""A run's page shows what is in the recording, in its order; what fails takes nothing with it."""

import html
import os
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.page import write_page
from fesloop.show.report.parts import Chart, Drawing, Fold, Notice, Paragraph, Strips, Table
from fesloop.show.report.run import page as module
from fesloop.show.report.run.page import run_page


def every(parts):
    for part in parts:
        yield part
        if isinstance(part, Fold):
            yield from every(part.parts)


def parts_of(page, kind):
    return [part for section in page.sections for part in every(section.parts) if isinstance(part, kind)]


@pytest.fixture(scope="module")
def page(learning):
    with Recording(learning) as recording:
        return run_page(recording)


def test_sections_come_in_their_order(page):
    assert [section.key for section in page.sections] == [
        "result", "hand", "trials", "tracking", "split", "stimulation", "latency", "tracker", "events",
        "experiment"]
    assert (page.trials, page.shown) == ((0, 1, 2), 2)
    assert not parts_of(page, Notice)


def test_its_numbers_are_the_run_s(page, learning):
    with Recording(learning) as recording:
        metrics = metrics_of(recording)
        truth = np.degrees(recording.signal("patient.angles", 2).values)
    curve = next(part for part in parts_of(page, Chart) if part.key == "result")
    assert curve.lines[0].y.tolist() == metrics["joint_rmse_deg"]
    table = next(part for part in parts_of(page, Table) if part.title == "By trial")
    across = [list(row) for row in zip(table.columns, *table.rows, strict=True)]
    shown = next(row[1:] for row in [*across, *table.rows] if row[0] == "joint RMSE, deg")
    assert [float(each) for each in shown] == pytest.approx(metrics["joint_rmse_deg"], rel=5e-3)
    pip = next(part for part in parts_of(page, Chart) if part.key == "tracking-scored-1-2")
    line = next(line for line in pip.lines if line.role == "truth")
    assert (line.low.min(), line.high.max()) == pytest.approx((truth[:, 1].min(), truth[:, 1].max()))
    assert [line.role for line in pip.lines] == ["reference", "truth", "estimate"]


def test_every_trial_has_its_own_charts(page):
    for trial in range(3):
        mine = [part for part in parts_of(page, (Chart, Strips)) if part.trial == trial]
        stimulated = {"Current", "Pulse width"} if trial else set()
        assert {part.title for part in mine} >= {"MCP", "PIP", "DIP"} | stimulated
    keys = [part.key for part in parts_of(page, (Chart, Strips, Drawing))]
    assert len(keys) == len(set(keys))
    assert "No channel delivered a pulse in trial 0." in [part.text for part in parts_of(page, Paragraph)]


def test_no_line_has_more_points_than_a_chart_has_pixels(page):
    lengths = [len(line.x) for part in parts_of(page, (Chart, Strips)) for line in part.lines]
    assert 300 < max(lengths) <= 600  # the patient has 6000 rows a trial


def test_it_can_be_written(page, tmp_path):
    write_page(page, tmp_path / "run.html")
    written = html.unescape((tmp_path / "run.html").read_text())
    assert page.sentence in written
    assert "A point stands for up to 10 samples: a line is their mean, the band their extremes." in written


def test_a_section_that_fails_says_so_in_its_place(learning, monkeypatch):
    def broken(known):
        raise ZeroDivisionError("nobody expects it")

    sections = [(key, title, broken if key == "split" else build) for key, title, build in module._SECTIONS]
    monkeypatch.setattr(module, "_SECTIONS", sections)
    with Recording(learning) as recording:
        page = run_page(recording)
    split = next(section for section in page.sections if section.key == "split")
    assert split.parts[0].text == "This cannot be shown: ZeroDivisionError: nobody expects it"
    assert page.sections[-1].key == "experiment"


def test_a_block_that_is_not_installed_leaves_what_the_recording_tells(learning, tmp_path):
    path = tmp_path / "foreign_block.h5"
    shutil.copy(learning, path)
    with h5py.File(path, "r+") as file:
        told = file["experiment"][()].replace(b'"kind":"vqf"', b'"kind":"nobody_has_it"')
        del file["experiment"]
        file["experiment"] = told
    with Recording(path) as recording:
        page = run_page(recording)
    shown = {section.key for section in page.sections}
    assert {"result", "trials", "tracking", "stimulation", "experiment"} <= shown
    wiring = next(part for part in parts_of(page, Drawing) if part.key == "wiring")
    assert "nobody_has_it" in wiring.svg
    assert any("nobody_has_it" in part.text for part in parts_of(page, Notice))


def test_an_empty_run_is_reported(learning, tmp_path):
    path = tmp_path / "empty.h5"
    shutil.copy(learning, path)
    with h5py.File(path, "r+") as file:
        file["status"][()] = b"running"
        file.visititems(lambda name, item: item.resize(0, axis=0) if getattr(item, "chunks", None) else None)
    with Recording(path) as recording:
        page = run_page(recording)
    assert page.sentence == (
        "The run is still under way or was killed; recorded so far: nothing.")
    assert page.trials == ()
    write_page(page, tmp_path / "empty.html")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_a_killed_run_is_reported(tmp_path):
    command = [sys.executable, "-m", "fesloop", "run", "finger_control", "--realtime", "--out",
               str(tmp_path)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline and not any(_rows(path) for path in tmp_path.glob("finger*.h5")):
            time.sleep(0.2)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    with Recording(next(tmp_path.glob("finger*.h5"))) as recording:
        page = run_page(recording)
    assert page.sentence.startswith("The run is still under way or was killed")
    assert "tracking" in [section.key for section in page.sections]


def _rows(path):
    with Recording(path) as recording:
        return recording.trials

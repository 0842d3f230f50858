"""The budget on the page is that of the wiring; ages are those of the recording."""

import json
from dataclasses import replace

import numpy as np
import pytest

import fesloop
from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.latency import LatencyReport
from fesloop.show.report.parts import Drawing, Notice, Table
from fesloop.show.report.run import latency
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.latency import latency_section


@pytest.fixture(scope="module")
def section(learning):
    with Recording(learning) as recording:
        yield latency_section(known_of(recording))


def test_the_foremost_way_is_through_the_tracker_and_adds_up(section):
    first = next(part for part in section.parts if isinstance(part, Drawing))
    assert first.title == ("patient → imus → tracker → controller → safety → patient; "
                           "controller acts on it in the next trial")
    # The file gives 20 ms to the controller and 5 ms to the patient; all blocks tick together.
    assert "tracker.angles → controller.measured: 20 ms" in first.svg
    assert "total: 25 ms" in first.svg
    assert first.text.endswith("total 25 to 25 ms, mean 25")


def test_ages_are_as_recorded(section, learning):
    table = next(part for part in section.parts if isinstance(part, Table))
    row = next(row for row in table.rows if row[0] == "safety.stimulation")
    with Recording(learning) as recording:
        ages = np.concatenate([(signal.left_ns - signal.oldest_ns)[signal.oldest_ns >= 0]
                               for signal in (recording.signal(row[0], trial) for trial in range(3))])
    assert row[1] == str(len(ages))
    assert float(row[3]) == pytest.approx(np.median(ages) / 1e6, rel=1e-2)


def test_where_it_cannot_be_computed_it_says_why(learning):
    with Recording(learning) as recording:
        section = latency_section(replace(known_of(recording), experiment=None, not_resolved="no such kind"))
    assert any(isinstance(part, Notice) and "cannot be computed" in part.text for part in section.parts)


@pytest.mark.slow
def test_page_check_and_budget_say_the_same_of_each_channel(capsys):
    """Between capture and pulse lie 10 ms of radio, 0 or 5 for a tick, 1 in the device, and the slots."""
    assert main(["check", "grasp_mpc", "--json"]) == 0
    checked = next(way for way in json.loads(capsys.readouterr().out)["latency"]
                   if "-> synergies -> controller -> grip ->" in way["path"])
    by_channel = {lane["stage"]: (lane["min_ms"], lane["max_ms"]) for lane in checked["lanes"]}
    slots_ms = [3.125 * slot for slot in (8, 1, 2, 3, 4, 5, 6, 7)]
    assert by_channel == {f"channel {c}": (10.0 + slots_ms[c], 15.0 + slots_ms[c]) for c in range(8)}
    total = checked["stages"][-1]
    assert (total["min_ms"], total["max_ms"]) == (13.125, 40.0)
    report = LatencyReport(fesloop.load("grasp_mpc").wiring, horizon_ns=NS_PER_S)
    way = next(way for way in latency._ways(report.paths) if "synergies → controller → grip" in way.name)
    assert latency._in_words(way.stages).endswith("total 13.1 to 40 ms, mean 26.6")
    (table,) = latency._lane_table(way)
    assert table.rows[0] == ["channel 0", "35", "37.5", "40"]
    assert len(table.rows) == 8


@pytest.mark.parametrize(("time_ns", "text"), [
    (250_000, "0.25"), (25e6, "25"), (999e6, "999"), (12_346e6, "12346")])
def test_times_are_told_without_exponents(time_ns, text):
    assert latency._ms(time_ns) == text

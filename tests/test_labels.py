"""Labels say what stands beside them: classes, intervals, workers, trials, and whose fault a fault is."""

import contextlib
import io
import json
import math
import os
import re
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from study_stores import write_store

from fesloop.analysis.study import load as load_study
from fesloop.analysis.study.engine.worker import ResultSpec, run_one
from fesloop.apps.cli import main
from fesloop.apps.cli.run_command import _pacing_rows
from fesloop.apps.cli.study_command import _show
from fesloop.apps.reproduce.comparison import band
from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import from_document, load, read
from fesloop.experiment.files.source import shipped
from fesloop.experiment.metrics.lateness import EDGES_MS, histogram

NUMBER = r"([\d.e+-]+)"


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 1e4), min_size=1, max_size=50))
def test_a_class_of_lateness_counts_what_its_label_says(late):
    """Read by its words alone: no instant is in two rows, and every one in the row that names it."""
    counts = histogram(np.array(late)).tolist()
    told = {"missed": 0, "deadlines": len(late), "period_ms": 1.0, "policy": "skip", "late_ms": {},
            "took_ms": {}, "histogram": {"from_ms": list(EDGES_MS), "instants": counts}, "done": {},
            "collections": 0.0, "worst_collection_ms": 0.0, "worst_write_ms": 0.0, "memory": "",
            "scheduling": ""}
    seen = 0
    for label, count in _pacing_rows(told):
        if found := re.fullmatch(rf"late by {NUMBER} to {NUMBER} ms", label):
            low, high = map(float, found.groups())
        elif found := re.fullmatch(rf"late by {NUMBER} ms or more", label):
            low, high = float(found[1]), math.inf
        else:
            continue
        assert int(count) == sum(low <= each < high for each in late)
        seen += int(count)
    assert seen == len(late)


@pytest.mark.parametrize("name", [name for name in shipped() if "patient" in read(name)[1]])
def test_a_patient_who_does_not_exist_is_named_before_all_else(name):
    """Whatever else does not fit them: a model that was made for somebody cannot be theirs."""
    with pytest.raises(InputError) as fault:
        load(name, ["patient=nobody"])
    assert "nobody: there is no shipped patient of this name" in str(fault.value)
    assert "the model is of" not in "".join(map(str, getattr(fault.value, "faults", ())))


def test_other_faults_of_a_model_stand_beside_those_of_the_patient():
    _, document = read("grasp_mpc")
    document["patient"] = {"file": "nobody"}
    document["blocks"]["controller"]["model"]["file"] = "no_such_model"
    with pytest.raises(InputErrors) as fault:
        from_document(document)
    texts = [str(each) for each in fault.value.faults]
    assert [("no shipped patient" in text, "cannot be read" in text) for text in texts] == [
        (True, False), (False, True)]


@pytest.mark.slow
@settings(deadline=None, max_examples=30)
@given(values=st.lists(st.lists(st.floats(0.1, 9.0) | st.none(), min_size=1, max_size=3), min_size=1,
                       max_size=3),
       width=st.integers(1, 3))
def test_a_study_speaks_of_intervals_where_it_shows_some(tmp_path_factory, values, width):
    path = tmp_path_factory.mktemp("study") / "study.sqlite"

    def outcome(levels, replicate):
        each = values[levels["x"]]
        return {"error_deg": each[replicate] if replicate < len(each) else None}

    results = load_study(write_store(path, {"x": list(range(len(values)))}, width, outcome))
    screen = io.StringIO()
    with contextlib.redirect_stderr(screen):
        _show(results)
    told = screen.getvalue()
    cells = results.cells("error_deg")
    assert ("interval" in told) == bool(re.search(rf"\({NUMBER} to {NUMBER}\)", told))
    assert "nan" not in told
    shown = re.compile(rf"{NUMBER} \({NUMBER} to {NUMBER}\)")
    assert [found[0] for found in shown.finditer(told)] == [str(cell) for cell in cells if cell.has_interval]
    for cell in cells:
        assert "nan" not in str(cell)
        assert ("no interval" in str(cell)) == (math.isfinite(cell.value) and not cell.has_interval)
        assert cell.has_interval == (math.isfinite(cell.low) and cell.sd > 1e-9 * abs(cell.value))


def test_a_study_shows_no_interval_of_replicates_that_do_not_differ(tmp_path):
    store = write_store(tmp_path / "study.sqlite", {"x": [0]}, 2, lambda *about: {"error_deg": 1.0})
    screen = io.StringIO()
    with contextlib.redirect_stderr(screen):
        _show(load_study(store))
    assert "interval" not in screen.getvalue()
    assert "1 to 1" not in screen.getvalue()


@given(st.lists(st.floats(-1e3, 1e3) | st.just(math.nan) | st.just(math.inf), min_size=1, max_size=5))
def test_a_band_of_nothing_known_is_no_pair_of_nan(values):
    with np.errstate(all="ignore"):
        text = str(band(np.array(values)))
    assert "nan" not in text
    assert "inf" not in text


def test_every_process_that_ran_something_is_a_worker_of_its_own(tmp_path):
    document = load("finger_pid_latency", ["experiment.duration_s=0.2", "score.after_s=0.1"]).document()
    spec = ResultSpec((), "none", str(tmp_path))
    outcome = run_one("a", zlib.compress(json.dumps(document).encode()), 1, spec)
    assert str(os.getpid()) in outcome.worker.split()


def test_takes_is_said_to_be_without_compilation(capsys):
    assert main(["list"]) == 0
    told = capsys.readouterr().out
    assert "first run" in told
    assert "compile" in told

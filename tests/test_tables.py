"""How objects are shown in notebooks and when printed."""

import re
from html.parser import HTMLParser

import pytest
from study_stores import write_store

import fesloop
from fesloop.analysis.study import load as load_study
from fesloop.apps import progress
from fesloop.loop.latency import LatencyReport
from fesloop.tables import Table, as_html, as_text


class Texts(HTMLParser):
    """Texts of a page; fails where tags are not closed in order."""

    def __init__(self, page):
        super().__init__()
        self.open, self.texts = [], []
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        assert tag != "script"
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def experiment():
    return fesloop.load("finger_control", {"experiment.duration_s": 1.0})


@pytest.fixture(scope="module")
def result(experiment, tmp_path_factory):
    return experiment.run(tmp_path_factory.mktemp("runs"))


def test_numbers_are_aligned_and_texts_are_not():
    assert as_text([Table("t", ("name", "n"), [("a", "1.5"), ("bcdef", "22")])]) == (
        "t\nname     n\na      1.5\nbcdef   22")


def test_every_text_is_escaped():
    page = as_html([Table("<b>", ("<i>", "&"), [("<script>alert(1)</script>", "'\"")], folded=True)])
    assert "<script" not in page
    assert Texts(page).texts == ["<b>", "<i>", "&", "<script>alert(1)</script>", "'\""]


def test_an_experiment_shows_wiring_and_settings(experiment):
    assert repr(experiment) == "Experiment('finger_control': 5 nodes, 6 wires, 1 x 1 s, seed 1)"
    shown = Texts(experiment._repr_html_()).texts
    for text in ("controller", "mpc", "50 Hz", "Wires", "patient.angles", "20 ms", "blocks.patient.strength"):
        assert text in shown
        assert text in str(experiment)


def test_a_latency_report_shows_the_slowest_path_open(experiment):
    report = experiment.latency_report()
    assert isinstance(report, LatencyReport)
    page = report._repr_html_()
    assert page.count("<details") == 1
    assert Texts(page).texts[0] == "Latency, 2 paths. Every sample in the 1 s of a trial counts."
    assert re.search(r"total +25\.000 +25\.000 +25\.000", str(report))


def test_a_recording_shows_signals_also_after_it_is_closed(result):
    with fesloop.Recording(result.recording) as recording:
        shown = Texts(recording._repr_html_()).texts
        row = shown.index("patient.angles")
        assert shown[row:row + 6] == ["patient.angles", "rad", "3", "1000", "1000", "0.999"]
        assert "Recording(" in repr(recording)
    assert "closed" in str(recording)
    assert "closed" in recording._repr_html_()
    assert repr(recording).endswith("(closed)")


def test_a_result_shows_its_metrics(result):
    assert "joint_rmse_deg" in str(result)
    assert "joints.MCP.joint_rmse_deg" in Texts(result._repr_html_()).texts


def test_a_result_begins_with_what_went_wrong(tmp_path):
    """As the command does, with the events beside it; a result outlives its file."""
    settings = {"blocks.safety.width_max_us": 1.0, "experiment.duration_s": 1}
    result = fesloop.run("finger_control", settings, out=tmp_path)
    assert result.troubles
    assert str(result).startswith(result.troubles[0])
    assert Texts(result._repr_html_()).texts[0] == result.troubles[0]
    found = {event.status for event in result.events}
    assert found
    assert found <= set(str(result).split())
    result.recording.unlink()
    assert (result.troubles, result.events) == ((), ())
    assert "joint_rmse_deg" in str(result)


def test_a_study_shows_its_table_and_failures(tmp_path):
    store = write_store(tmp_path / "study.sqlite", {"x<y": [0, 1]}, 2, lambda *about: {"error_deg": 1.0})
    results = load_study(store)
    assert Texts(results._repr_html_()).texts[1] == "x<y"
    assert "4 of 4 runs" in repr(results)
    assert str(results).splitlines()[1].split() == ["x<y", "runs", "failed", "error_deg"]


class Display:
    """A notebook's display, which keeps what it shows."""

    def __init__(self):
        self.shown = []

    def __call__(self, data, **options):
        self.shown.append(data["text/plain"])
        return self

    def update(self, data, raw):
        self.shown.append(data["text/plain"])


def test_progress_in_a_notebook_is_one_line_that_is_removed(monkeypatch, tmp_path, experiment):
    display = Display()
    monkeypatch.setattr(progress, "in_notebook", lambda: True)
    monkeypatch.setattr(progress, "_QUIET_S", 0.0)
    monkeypatch.setattr(progress, "_REFRESH_S", 0.0)
    monkeypatch.setattr(progress, "import_module", lambda name: type("IPython", (), {"display": display}))
    with progress.run_progress("one") as shown:
        shown(0.25)
    with progress.study_progress("two") as watch:
        watch.stage("check", 0.5)
        watch.runs(3, {"cause": 1}, 8)
    assert display.shown == ["one: 25 %", "", "two: check 50 %", "two: 4 of 8 runs, 1 failed", ""]


def test_elsewhere_nothing_is_shown(capsys):
    assert not progress.in_notebook()
    with progress.run_progress("one") as shown, progress.study_progress("two") as watch:
        shown(0.5)
        watch.stage("check")
        watch.runs(1, {}, 2)
    assert capsys.readouterr() == ("", "")


def test_a_notebook_shows_an_error_as_one_line():
    assert fesloop.InputError("a", "b")._render_traceback_() == ["InputError: a: b"]

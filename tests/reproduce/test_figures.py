import numpy as np
import pytest
from made_up_scores import run_jobs

from fesloop.apps.reproduce import error_model, kortier2014, salchow2019
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.result import Reproduction

pytest.importorskip("matplotlib")
from fesloop.apps.reproduce.figures import draw


def check(files, names):
    assert {file.stem for file in files} == names
    for file in files:
        assert file.read_bytes().startswith(b"\x89PNG")
        assert file.stat().st_size > 5000


@pytest.mark.slow
@pytest.mark.parametrize(("paper", "names"), [
    (kortier2014, {"figure_5", "figure_6", "constraints", "bands"}),
    (salchow2019, {"figure_12", "figure_13", "figure_14", "figure_15", "bands"}),
])
def test_every_figure_of_a_paper_is_drawn(paper, names, monkeypatch, tmp_path):
    monkeypatch.setattr(error_model, "run_jobs", run_jobs)
    check(draw(paper.run(2, 1), tmp_path), names)


def test_the_hour_is_drawn_without_bands(tmp_path):
    kept = {name: np.ones((60, 5)) for name in ("constrained", "salchow_m2", "m2_calibrated", "sd")}
    kept["still"] = np.array([2100.0, 2700.0])
    rows = [Row("subject 1", "drift", "1.5", "1.2", holds=True)]
    check(draw(Reproduction("hour", 1, rows, {}, {"minutes": [kept]}), tmp_path), {"hour"})

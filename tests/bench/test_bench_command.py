"""`fesloop bench`: options go to benches that know of them, and one that cannot run here stops no other."""

import json
from types import SimpleNamespace

import pytest

from fesloop.apps.cli import bench_command, main
from fesloop.errors import InputError

ROW = {"case": "a", "us_median": 2.0, "us_p99": 3.0, "us_worst": 4.0, "reference": None,
       "reference_us_median": None, "ratio": None}


@pytest.fixture
def benches(monkeypatch):
    """Two benches that note how they were run, and one without what it needs."""
    asked = []

    def plain(progress=None):
        asked.append({})
        return {"bench": "plain", "rows": [ROW]}

    def paced(short=False, priority=0, progress=None):
        asked.append({"short": short, "priority": priority})
        return {"bench": "paced", "rows": [ROW]}

    def without(progress=None):
        raise InputError("FESLOOP_RECORDINGS", "there is no recording")

    found = {"fesloop.apps.bench.paced": paced, "fesloop.apps.bench.plain": plain,
             "fesloop.apps.bench.without": without}
    monkeypatch.setattr(bench_command, "names", lambda: [name.rpartition(".")[2] for name in found])
    monkeypatch.setattr(bench_command, "import_module", lambda name: SimpleNamespace(run=found[name]))
    return asked


def test_options_go_where_they_are_known(benches, capsys):
    assert main(["bench", "paced", "--short", "--priority", "5"]) == 0
    assert main(["bench", "plain", "--short"]) == 0
    assert benches == [{"short": True, "priority": 5}, {}]
    assert "bench paced" in capsys.readouterr().err


def test_what_cannot_run_here_is_told_and_left_out_of_all(benches, capsys):
    assert main(["bench", "--json"]) == 0
    out, err = capsys.readouterr()
    told = {bench["bench"]: bench for bench in json.loads(out)["benches"]}
    assert list(told) == ["paced", "plain", "without"]
    assert told["without"]["rows"] == []
    assert "FESLOOP_RECORDINGS: there is no recording" in told["without"]["left_out"]
    assert "bench without: left out" in err


def test_asked_for_by_name_it_is_bad_input(benches, capsys):
    assert main(["bench", "without"]) == 2
    assert "FESLOOP_RECORDINGS" in capsys.readouterr().err


@pytest.mark.parametrize("priority", ["500", "-1", "99"])
@pytest.mark.parametrize("name", [[], ["paced"], ["plain"]])
def test_a_priority_that_is_none_is_refused_before_any_bench_runs(benches, capsys, name, priority):
    assert main(["bench", *name, "--priority", priority]) == 2
    assert capsys.readouterr().err.startswith(f"fesloop: --priority: {priority}; allowed: 1 to 98")
    assert benches == []

import json

import pytest
from made_up_scores import run_jobs

from fesloop.apps.cli import main
from fesloop.apps.reproduce import error_model, kortier2014


@pytest.fixture
def made_up(monkeypatch):
    """The cohort of kortier2014 answers at once, by a model without error."""
    monkeypatch.setattr(error_model, "run_jobs", run_jobs)
    monkeypatch.setattr(kortier2014, "with_model_error", lambda paper, figures: figures)


def refused(capsys, *arguments):
    """The one line that a refusal prints."""
    code = main(["reproduce", *arguments])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    return line


@pytest.mark.parametrize(("arguments", "told"), [
    (("kortier2013",), "did you mean 'kortier2014'?"),
    (("salchow2019", "--subjects", "0"), "1 to 10000"),
    (("kortier2014", "--subjects", "-3"), "1 to 10000"),
    (("kortier2014", "--workers", "0"), "1 to 1024"),
])
def test_bad_input_is_one_line_and_leaves_nothing(arguments, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert told in refused(capsys, *arguments)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_told_before_anything_runs(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(error_model, "run_jobs", lambda *given: pytest.fail("it ran"))
    file = tmp_path / "file"
    file.write_text("")
    assert "cannot be written" in refused(capsys, "kortier2014", "--out", str(file))


@pytest.mark.slow
def test_json_is_one_object_of_the_agreed_shape(made_up, capsys, tmp_path):
    assert main(["reproduce", "kortier2014", "--subjects", "6", "--workers", "1", "--json",
                 "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["paper"], told["subjects"], told["holding"]) == ("kortier2014", 6, 1.0)
    assert len(told["rows"]) == 20
    for row in told["rows"]:
        assert list(row) == ["table", "row", "theirs", "ours", "holds", "unit", "scores"]
        assert row["holds"] is True
    assert "100 % of 20 rows hold" in err
    for title in ("published and fitted", "published and predicted", "patterns"):
        assert err.count(f"kortier2014: {title}") == 1
    assert {half: told["summary"][half]["rows"] for half in told["summary"]} == {
        "fitted": 6, "predicted": 9, "patterns": 5}
    assert told["summary"]["predicted"]["log_score"] > told["summary"]["predicted"]["baseline_log_score"]
    assert told["baseline"] in err
    written = tmp_path / "kortier2014"
    assert json.loads((written / "table.json").read_text()) == told
    assert (written / "bands.png").stat().st_size > 5000


@pytest.mark.slow
def test_without_json_the_folder_alone_is_printed(made_up, capsys, tmp_path):
    assert main(["reproduce", "kortier2014", "--subjects", "1", "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert out.strip() == str(tmp_path / "kortier2014")
    assert "published and predicted" in err
    assert "mean log score undefined" in err


@pytest.mark.slow
def test_a_row_that_does_not_hold_says_so(made_up, capsys, tmp_path, monkeypatch):
    def slow(attempts, *given):
        kept = run_jobs(attempts, *given)
        for each in attempts:
            if each.job.key[0] == "rapid":
                kept[each.key]["kept"]["range_deg"] = 79.0
        return kept

    monkeypatch.setattr(error_model, "run_jobs", slow)
    main(["reproduce", "kortier2014", "--subjects", "6", "--json", "--out", str(tmp_path)])
    out, err = capsys.readouterr()
    (broken,) = [row for row in json.loads(out)["rows"] if not row["holds"]]
    assert broken["row"].startswith("range of the PIP joint")
    assert "NO" in err

"""Tables of committed results: what is in the JSON is on the page, and nothing else."""

import json
import math
from pathlib import Path

import pytest
from result_tables import RESULTS, benches, result

from fesloop.apps.cli.output import as_json
from fesloop.apps.cli.parser import make_parser
from fesloop.apps.reproduce.comparison import Band, FigureScores, PatternScores, Row
from fesloop.apps.reproduce.result import Reproduction, Sweep

KEPT = sorted(RESULTS.glob("*.json"))


def written(tmp_path, found):
    kept = {"command": "fesloop reproduce it", "version": "0.1.0", "commit": "abc", "day": "2026-01-01",
            "found": found}
    (tmp_path / "it.json").write_text(json.dumps(kept))
    return "\n".join(result("it", tmp_path))


def test_rows_stand_in_the_tables_of_the_paper_with_their_bands(tmp_path):
    rows = [Row("Table 2", "x | y", 2.2, Band(2.0, 1.0, 3.0), True, "mm"),
            Row("Figure 6", "range", "80", "90", False, "deg"),
            Row("Table 2", "z", 3.25, Band(4.004, 3.5, 5.0), False, "mm")]
    sweep = Sweep(title="By noise", unit="mm", columns=("a", "b"), rows=(("low", (1.0, 2.125)),))
    text = written(tmp_path, Reproduction("it", 3, rows, {"noise": sweep}).as_table())
    assert "**1 of 3 rows hold.**" in text
    assert "| x \\| y | 2.2 | 2.00 (1.00 to 3.00) | mm | yes |" in text
    assert "| z | 3.25 | 4.00 (3.50 to 5.00) | mm | **no** |" in text
    assert text.index("| z |") < text.index("| range | 80 | 90 | deg | **no** |")
    assert "| low | 1.00 | 2.12 |" in text
    assert "`fesloop reproduce it`, fesloop 0.1.0 (`abc`), 2026-01-01." in text


def test_fitted_and_predicted_rows_are_in_tables_of_their_own(tmp_path):
    def scores(half, width):
        return FigureScores(half=half, pit=0.25, log_score=-0.5, baseline_log_score=-1.25,
                            baseline_holds=False, band_over_sd=width)

    rows = [Row("Table 2", "x", 2.2, Band(2.0, 1.0, 3.0), True, "mm", scores("fitted", 1.5)),
            Row("Table 2", "y", 3.2, Band(2.0, 1.0, 3.0), False, "mm", scores("predicted", math.nan)),
            Row("Table 2", "z worst", "2 of 2", "in 75 %", True, "",
                PatternScores(share=0.75, baseline_share=0.25, baseline_holds=False))]
    text = written(tmp_path, json.loads(as_json(Reproduction("it", 3, rows, baseline="abc").as_table())))
    fitted, predicted, pattern = (text.index(f"**{half}, Table 2: {holding} of 1 hold**")
                                  for half, holding in (("Fitted", 1), ("Predicted", 0), ("Pattern", 1)))
    assert fitted < text.index("| x | 2.2 | 2.00 (1.00 to 3.00) | mm | 0.25 | -0.50 | -1.25 | 1.50 | yes |")
    assert predicted < text.index("| y | 3.2 | 2.00 (1.00 to 3.00) | mm | 0.25 | -0.50 | -1.25 |  | **no** |")
    assert pattern < text.index("| z worst | 2 of 2 | in 75 % | in 25 % | yes |")
    assert fitted < predicted < pattern
    assert ("- predicted: 0 of 1 rows in the band, 0 in the baseline's; mean log score -0.5, baseline "
            "-1.25, better in 1 rows; bands undefined published standard deviations, median") in text


def test_a_bench_has_a_line_a_case(tmp_path):
    found = {"bench": "loop", "rows": [{"case": "a", "us_median": 1.23456, "reference": None},
                                       {"case": "b", "us_median": 2.0, "ratio": 3.0}]}
    text = written(tmp_path, found)
    assert "| a | 1.235 |  |  |" in text
    assert "| b | 2 |  | 3 |" in text


def test_what_is_not_kept_is_said(tmp_path):
    assert "No result is kept here" in "\n".join(result("it", tmp_path))
    assert "No result of a bench is kept" in "\n".join(benches(tmp_path))


def test_benches_are_told_of_and_papers_are_not_among_them(tmp_path):
    written(tmp_path, {"bench": "it", "rows": [{"case": "a"}]})
    (tmp_path / "paper.json").write_text(json.dumps({"found": {"paper": "paper", "rows": []}}))
    assert [line for line in benches(tmp_path) if line.startswith("###")] == ["### it"]


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_a_kept_result_is_whole(path):
    kept = json.loads(path.read_text())
    words = kept["command"].split()
    make_parser().parse_args(words[1:])
    assert path.stem == kept["found"].get("paper", kept["found"].get("bench")) == words[2]
    text = "\n".join(result(path.stem))
    judged = [line for line in text.splitlines() if line.endswith(("| yes |", "| **no** |"))]
    if "paper" in kept["found"]:
        assert len(judged) == len(kept["found"]["rows"])
        assert sum(line.endswith("| yes |") for line in judged) == sum(
            row["holds"] for row in kept["found"]["rows"])


def test_there_are_kept_results():
    assert [Path(path).stem for path in KEPT]

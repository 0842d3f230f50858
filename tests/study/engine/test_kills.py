"""One random moment for each victim; `fesloop bench study_kills` takes five."""

import pytest

from fesloop.apps.bench import study_kills
from fesloop.apps.bench.study_kills import VICTIMS


@pytest.mark.slow
def test_whatever_is_killed_the_results_are_those_of_an_undisturbed_study():
    """Quick it is not: a dozen studies, each in processes of its own."""
    told = study_kills.run(moments=1, replicates=2)
    assert told["same_on_both_clusters"]
    assert [row["case"] for row in told["rows"]] == list(VICTIMS)
    for row in told["rows"]:
        assert row["identical"] == "1 of 1", row
        assert row["killed"] == [2 if row["case"] == "both" else 1]
        assert row["exit_codes"][0][-1] == 0
        assert (row["exit_codes"][0][0] == -9) == (row["case"] in ("coordinator", "both"))

"""One random moment for each victim; `python tests/study_kills.py` takes five."""

import random

import pytest
from study_kills import VICTIMS, disturbed, undisturbed

pytestmark = pytest.mark.slow
REPLICATES = 2


@pytest.fixture(scope="module")
def digest(tmp_path_factory):
    return undisturbed(tmp_path_factory.mktemp("kills") / "whole", REPLICATES, by_hand=False)


def test_a_cluster_that_is_started_by_hand_gives_the_same_results(digest, tmp_path):
    assert undisturbed(tmp_path / "whole", REPLICATES, by_hand=True) == digest


@pytest.mark.parametrize("victim", VICTIMS)
def test_whatever_is_killed_the_results_are_those_of_an_undisturbed_study(digest, tmp_path, victim):
    killing = disturbed(tmp_path / victim, REPLICATES, victim, random.Random())
    assert killing.digest == digest
    assert killing.processes == (2 if victim == "both" else 1)
    assert killing.exit_codes[-1] == 0
    assert (killing.exit_codes[0] == -9) == (victim in ("coordinator", "both"))

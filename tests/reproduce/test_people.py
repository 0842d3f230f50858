"""Tests of `fesloop reproduce people`: who predicts whom, and that scores are those of plain formulas."""

import numpy as np
import pytest

from fesloop.analysis.people.population import ArmPopulation
from fesloop.apps.reproduce import people
from fesloop.apps.reproduce.people import evoked
from fesloop.errors import InputError


def test_needs_recordings(monkeypatch, tmp_path):
    monkeypatch.delenv("FESLOOP_RECORDINGS", raising=False)
    with pytest.raises(InputError, match="FESLOOP_RECORDINGS: no recordings"):
        people.run()
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path))
    with pytest.raises(InputError, match="a folder that holds fes_exo"):
        people.run()


def test_other_peoples_density_is_students():
    others = [np.array([1.0, 0.0]), np.array([2.0, 0.0]), np.array([3.0, 3.0])]
    found = evoked._others_log_density(np.array([2.0, 1.0]), others)
    # Density of t with 2 degrees of freedom at 0: 1 / (2 sqrt 2), over the scale sqrt(4 / 3).
    assert found[0] == pytest.approx(np.log(1.0 / (2.0 * np.sqrt(2.0)) / np.sqrt(4.0 / 3.0)))
    assert np.isnan(evoked._others_log_density(np.zeros(2), others[:2])).all()


@pytest.mark.slow
def test_nobody_predicts_themselves(recordings, monkeypatch):
    found = evoked.recordings(recordings / "fes_exo")
    shipped = ArmPopulation.shipped()
    assert {each.person for each in found} == set(shipped.people)
    asked = []
    monkeypatch.setattr(ArmPopulation, "of", lambda trials: asked.append([each.person for each in trials]))
    evoked.populations(found)
    assert [set(shipped.people) - set(others) for others in asked] == [{each.person} for each in found]


@pytest.mark.slow
def test_people_are_predicted_better_than_by_lines_and_by_other_peoples_mean(recordings):
    rows, sweeps, _ = evoked.rows_and_sweeps(recordings / "fes_exo", 400)
    by_name = {(row.table, row.row): row for row in rows}
    assert all(row.holds for key, row in by_name.items() if "stretch" not in key[1])
    assert len(sweeps["postures"].rows) == 5

import numpy as np
import pytest

from fesloop.apps.reproduce import hour
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load

NAMES = ("F2-F5, last ten minutes", "95 % intervals", "ten still minutes")


def kept():
    """All that is claimed holds: M2 begins at 1 cm, ours is 1.4 cm off throughout, still from 2100 s on."""
    minutes, still = 60, slice(35, 44)
    sd = np.full((minutes, 5), 1.0)
    sd[still] += 0.1 * np.arange(9)[:, np.newaxis]
    return {"constrained": np.full((minutes, 5), 1.4), "salchow_m2": np.linspace(1.0, 3.0, minutes)[:, None]
            * np.ones(5), "m2_calibrated": np.full((minutes, 5), 0.9),
            "inside": np.full((minutes, 5), 0.95), "sd": sd, "uncertain": np.array([]),
            "still": np.array([2100.0, 2700.0])}


def found(monkeypatch, change=lambda hours: None):
    hours = kept()
    change(hours)
    monkeypatch.setattr(hour, "run_jobs", lambda jobs, *given: {job.key: hours for job in jobs})
    rows = hour.run(1, 1).rows
    return {name: next(row for row in rows if row.row.startswith(name)).holds for name in NAMES}


def test_the_run_can_be_loaded():
    experiment = load(hour.EXPERIMENT, (), 1)
    assert {hour.OURS, hour.THEIRS, hour.CALIBRATED} <= {node.name for node in experiment.nodes}
    with pytest.raises(InputError):
        load(hour.EXPERIMENT, ("nothing=1",), 1)


def test_all_rows_hold_in_an_hour_that_is_as_claimed(monkeypatch):
    assert found(monkeypatch) == dict.fromkeys(NAMES, True)


@pytest.mark.parametrize(("name", "change"), [
    (NAMES[0], lambda hours: hours["constrained"][-10:, 1:].__imul__(1.2)),
    (NAMES[1], lambda hours: hours["inside"].fill(0.89)),
    (NAMES[1], lambda hours: hours["inside"].fill(1.0)),
    (NAMES[2], lambda hours: hours["sd"].fill(1.0)),
])
def test_a_claim_that_is_not_met_does_not_hold(name, change, monkeypatch):
    assert found(monkeypatch, change) == dict.fromkeys(NAMES, True) | {name: False}


def test_the_bar_is_m2s_first_minute_where_that_is_worse(monkeypatch):
    def change(hours):
        hours["constrained"].fill(2.3)
        hours["salchow_m2"][0] = 2.0

    assert found(monkeypatch, change)[NAMES[0]]


def test_a_flag_tells_of_still_minutes_too(monkeypatch):
    def change(hours):
        hours["sd"].fill(1.0)
        hours["uncertain"] = np.array([2400.0])

    assert found(monkeypatch, change)[NAMES[2]]


def test_the_thumb_counts_in_no_claim(monkeypatch):
    assert all(found(monkeypatch, lambda hours: hours["constrained"][:, 0].fill(9.0)).values())

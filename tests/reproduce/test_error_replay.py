"""Rows of the error processes' table, and what it says without recordings."""

import pytest

from fesloop.apps.reproduce import error_replay
from fesloop.apps.reproduce.error_replay import (
    CONTROLS,
    CRITERIA,
    Source,
    closed_loop,
    ranges,
    rows_of,
    shares,
    shares_of_recordings,
    sources,
)
from fesloop.errors import InputError


def angle(name, second, process, held, moved=True):
    return {"angle": name, "moved": moved, "rmse_fitted_deg": 1.0, "rmse_measured_deg": second,
            "rmse_process_deg": process, "autocorrelation_in_band": held, "lags_in_band_share": 0.9,
            "increments": {"times_s": [0.067, 0.1], "measured_deg": [0.5, 1.0],
                           "process_deg": [0.5, 1.1 if held else 1.2], "within_15_percent": held}}


ANGLES = [angle("a-b.x", 3.0, 3.3, True), angle("a-b.y", 4.0, 4.0, False, moved=False),
          angle("a-b.z", 1.0, 2.0, True)]


def test_rows_hold_where_the_process_is_within_15_percent():
    rows = {(row.table, row.row): row for row in rows_of("chain", ANGLES)}
    assert rows["chain: RMSE", "a-b.x"].holds
    assert not rows["chain: RMSE", "a-b.z"].holds
    assert not rows["chain: autocorrelation", "a-b.y (not moved)"].holds
    changes = rows["chain: increments", "a-b.y (not moved)"]
    assert (changes.theirs, changes.ours) == ("0.50, 1.00 over 0.067, 0.1 s", "+0 +20 %")
    assert not changes.holds
    whole = rows["chain: RMSE", "a-b as a whole"]
    # Roots of 26 and of 30.89.
    assert whole.theirs == "5.10 (first half 1.73)"
    assert whole.ours == "5.56, +9 %"
    assert whole.holds


def test_shares_are_of_angles_and_not_of_wholes():
    told = dict(shares(rows_of("chain", ANGLES)).rows)
    assert told["chain: RMSE"] == pytest.approx((200 / 3, 50.0))
    assert told["chain: autocorrelation"] == pytest.approx((200 / 3, 100.0))


def test_ranges_are_over_the_joints_of_a_recording():
    other = [angle("b-c.x", 1.0, 1.0, True), angle("b-c.y", 1.0, 0.8, False)]
    found = shares_of_recordings("chain", [*ANGLES, *other])
    assert found == {"chain a-b": pytest.approx((200 / 3, 200 / 3, 200 / 3)),
                     "chain b-c": pytest.approx((50.0, 50.0, 50.0))}
    told = dict(ranges(found, "trackers").rows)
    assert tuple(told) == CRITERIA
    assert told[CRITERIA[0]] == pytest.approx((50.0, 175 / 3, 200 / 3, 175 / 3))


def test_without_recordings_it_says_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.delenv("FESLOOP_RECORDINGS", raising=False)
    with pytest.raises(InputError, match="FESLOOP_RECORDINGS: no recordings in"):
        sources((1,))
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path))
    with pytest.raises(InputError, match="wrist"):
        error_replay.run(1)


@pytest.mark.slow
def test_the_wrist_from_recording_to_closed_loop(recordings, monkeypatch):
    path = str(recordings / "wrist" / "circle-250.npz")
    monkeypatch.setattr(error_replay, "sources", lambda seeds: [Source(path, "wrist", "vqf", seeds=seeds)])
    found = error_replay.run(2)
    assert [row.holds for row in found.rows][:2] == [True, True]
    assert dict(found.sweeps["ranges"].rows)[CRITERIA[0]] == (100.0, 100.0, 100.0, 100.0)
    assert "ranges_drifting" not in found.sweeps
    loops = dict(found.sweeps["closed_loop"].rows)
    for control in CONTROLS:
        ideal, mean, least, greatest, tracker = loops[f"wrist/circle-250 vqf, {control}"]
        assert 0.0 < ideal < mean
        assert least <= mean <= greatest
        assert tracker > 0.3


def test_seeds_close_other_loops(tmp_path):
    assert closed_loop("mpc", 1, tmp_path, None)[1] == 0.0

"""The sentence says what was measured, and no more."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fesloop.experiment.recording.reading import Event
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.sentence import sentence_of


def run_of(metrics, score=(), status="done", trials=1, blocks=()):
    recording = SimpleNamespace(status=status, trials=trials, events=(), signals=(),
                                experiment={"blocks": dict(blocks)})
    return Known(recording, trials, tuple(range(trials)), None, metrics, dict(score), (), frozenset())


@pytest.mark.parametrize(("errors", "words"), [
    ([4.0], "The tracking error was 4.00 deg RMS."),
    ([9.0, 3.0, 2.0],
     "The tracking error fell from 9.00 deg RMS in the first of 3 trials to 2.00 deg in the last."),
    ([2.0, 9.0],
     "The tracking error rose from 2.00 deg RMS in the first of 2 trials to 9.00 deg in the last."),
    ([2.0011, 2.0012], "The tracking error was 2.00 deg RMS in the first of 2 trials and in the last."),
    ([9.0, 1.0, 2.0], "The tracking error fell from 9.00 deg RMS in the first of 3 trials to 2.00 deg in the "
                      "last (the least, 1.00 deg, in trial 1)."),
    ([9.0, math.nan], "The tracking error was 9.00 deg RMS in 1 of 2 trials (unknown in the other)."),
    ([math.nan, 9.0, 4.0, math.nan], "The tracking error was 4.00 to 9.00 deg RMS in 2 of 4 trials (unknown "
                                     "in the others)."),
    ([math.nan], "The tracking error is unknown: there is nothing to score in 1 trial."),
])
def test_how_the_error_went(errors, words):
    assert sentence_of(run_of({"joint_rmse_deg": errors}, trials=len(errors))) == words


@pytest.mark.parametrize("status", ["posture_jumped", "emergency_stop"])
@pytest.mark.parametrize("errors", [[9.0, 3.0, 2.0], [2.0, 3.0, 9.0], [2.0, math.nan, 9.0]])
def test_no_change_over_trials_is_claimed_where_stimulation_was_withheld_in_one(status, errors):
    known = run_of({"joint_rmse_deg": errors}, trials=3, blocks={"safety": {"kind": "safety"}})
    known.recording.events = (Event(1, 500_000_000, "safety", status, "ramp to zero"),)
    told = sentence_of(known)
    assert told.startswith("Stimulation ")
    assert "fell" not in told
    assert "rose" not in told
    assert "9.00 deg RMS" in told
    assert "no trend is reported" in told


def test_the_while_that_is_scored_is_said():
    told = sentence_of(run_of({"joint_rmse_deg": [4.0]}, {"after_s": 2.0, "until_s": 4.4}))
    assert told == "The tracking error from 2 to 4.4 s was 4.00 deg RMS."


@pytest.mark.parametrize(("rows", "duration_s"), [(3000, 3.0), (3000, 9.0)])
def test_of_a_trial_that_ended_before_the_while_did_what_there_is_of_it_is_said(rows, duration_s):
    """Of a trial that was set to end, and of one that broke off."""
    known = run_of({"joint_rmse_deg": [4.0]}, {"after_s": 2.0, "until_s": 4.4, "truth": "hand.angles"})
    known.recording.experiment["experiment"] = {"duration_s": duration_s}
    times_ns = np.arange(rows) * 1_000_000
    known.recording.signal = lambda name, trial: SimpleNamespace(times_ns=times_ns)
    known = replace(known, signals=frozenset({"hand.angles"}))
    assert sentence_of(known) == (
        "The tracking error from 2 to 3 s (the trial ended before 4.4 s) was 4.00 deg RMS.")
    assert [(mark.at, mark.until) for mark in known.scored_while()] == [(2.0, 3.0)]


@pytest.mark.parametrize(("held", "words"), [
    ([True], "The object was held."),
    ([False], "The object was not held."),
    ([None], "Whether the object was held is unknown: no trial lasted long enough."),
    ([True, True], "The object was held in 2 of 2 trials."),
    ([False, True, True], "The object was held in 2 of 3 trials, the last one among them."),
    ([True, False], "The object was held in 1 of 2 trials, not in the last."),
    ([False, False], "The object was held in none of 2 trials."),
    ([None, False], "The object was held in none of 2 trials (unknown for 1)."),
    ([False, None], "The object was held in 0 of 2 trials (unknown for 1)."),
])
def test_whether_the_object_was_held(held, words):
    assert sentence_of(run_of({"held": held}, trials=len(held))) == words


def test_of_a_recording_that_was_played_no_tracking_error_is_claimed():
    told = sentence_of(run_of({}, blocks={"recording": {"kind": "replay", "recording": "a.mat"}}))
    assert "there is no tracking error" in told
    assert "deg" not in told


@pytest.mark.parametrize(("status", "beginning"), [
    ("running", "The run is still under way or was killed"), ("failed", "The run failed"),
    ("interrupted", "The run was interrupted"), ("damaged", "The file is damaged")])
def test_a_run_that_broke_off_claims_no_whole_last_trial(status, beginning):
    told = sentence_of(run_of({"joint_rmse_deg": [9.0, 2.0]}, status=status, trials=2))
    assert told.startswith(beginning)
    assert told.endswith("to 2.00 deg in what there is of the last.")


def test_the_tracker_s_error_is_of_the_trial_that_it_is_known_of():
    told = sentence_of(run_of({"tracker_rmse_deg": [0.5, 0.25, math.nan]}, trials=3))
    assert told == "The tracker's own error in the scored angles in trial 1 was 0.250 deg RMS."


def test_what_was_not_scored_is_said():
    assert sentence_of(run_of({}, trials=3)) == "3 trials recorded; nothing was scored."
    assert sentence_of(run_of({}, trials=0)) == "Nothing was recorded."


@pytest.mark.parametrize(("declines", "words"), [
    ([12.5], "fell by 12.5 % from the first cycle to the last."),
    ([-3.0], "rose by 3.00 % from the first cycle to the last."),
    ([5.0, 8.0], "fell by 8.00 % from the first cycle to the last in the last trial."),
    ([5.0, math.nan], "fell by 5.00 % from the first cycle to the last in trial 0.")])
def test_a_peak_fell_or_rose_in_the_trial_that_is_named(declines, words):
    score = {"cycles": {"signal": "hand.force"}}
    told = sentence_of(run_of({"decline_pct": declines}, score, trials=len(declines)))
    assert told == f"The peak of `hand.force` {words}"


@pytest.mark.parametrize(("trials", "which"), [(1, ""), (2, " in the last trial")])
def test_fingertips_are_those_of_the_last_trial(trials, which):
    errors = {"tracker": {"F1": [9.0, 2.0][-trials:], "F2": [9.0, 4.0][-trials:]}}
    told = sentence_of(run_of({"fingertip_rmse_mm": errors}, trials=trials))
    assert told == f"Fingertips were off{which} (RMS, by finger): tracker by 2.00 to 4.00 mm."

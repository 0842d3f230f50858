"""What `fesloop reproduce three_trials` makes of patients' sessions, and one session."""

import math

import pytest

from fesloop.apps.reproduce import three_trials
from fesloop.apps.reproduce.patient_session import Session
from fesloop.errors import RunError

HELD = {"failed": "", "min": 3.5, "held": [False, True, False], "error": [6.0, 4.0, 2.0], "floor": 1.5}
LOST = {"failed": "nothing moved", "min": math.nan, "held": [False] * 3, "error": [math.inf] * 3,
        "floor": math.nan}


def test_patients_who_fail_count_as_ones_who_did_not_hold():
    found = three_trials.compare([{"failed": "", "ways": {"sweep": HELD, "identify": LOST}},
                                  {"failed": "", "ways": {"sweep": HELD, "identify": HELD}}])
    rows = {(row.table, row.row.partition(",")[0]): row for row in found.rows}
    swept, identified = three_trials.WAYS.values()
    assert rows[swept, "held in one of three trials"].ours == "2 of 2"
    assert rows[swept, "held in the third trial"].ours == "0 of 2"
    assert rows[identified, "held in one of three trials"].ours == "1 of 2"
    assert not rows[identified, "held in one of three trials"].holds
    assert rows[identified, "error before contact"].ours.high == math.inf
    assert rows[f"{identified}: not to its end", "member 0"].ours == "nothing moved"
    assert found.sweeps["sweep"].rows[0] == ("member 0", (3.5, 0.0, 1.0, 0.0, 6.0, 4.0, 2.0, 1.5))


def test_every_tenth_person_has_another_hand(monkeypatch):
    seen = []

    def run_jobs(sessions, workers, progress):
        seen.extend(sessions)
        return {session.key: {"ways": {"sweep": HELD, "identify": HELD}} for session in sessions}

    monkeypatch.setattr(three_trials, "run_jobs", run_jobs)
    assert three_trials.run(30).subjects == 30
    assert [k for k, session in enumerate(seen) if "plant=myohand" in session.patient] == [9, 19, 29]
    assert len({(session.patient, session.seed) for session in seen}) == 30


def test_a_failure_is_told_without_the_folder_of_its_session(monkeypatch, tmp_path):
    def ran(self, experiment, folder):
        raise RunError(f"{folder}/sweep_grasp-1.h5: the disk is full")

    monkeypatch.setattr(Session, "ran", ran)
    session = Session((0,), ("patient=sci_c6",), 1, three_trials.grasp)
    ways = three_trials.grasp(session, tmp_path)["ways"]
    assert {way["failed"] for way in ways.values()} == {"sweep_grasp-1.h5: the disk is full"}
    assert not any(any(way["held"]) for way in ways.values())


def test_the_floor_is_the_root_mean_square_of_what_is_left():
    left = {"opened": {"wrist_extension": -3.0, "F2_flexion": 4.0}, "closed": {"wrist_extension": 90.0}}
    assert three_trials._floor_deg({"missed_deg": left}) == pytest.approx(math.sqrt(12.5))
    assert math.isnan(three_trials._floor_deg({}))


@pytest.mark.slow
def test_a_person_with_myohand_opens_wider_both_ways(monkeypatch, tmp_path):
    """Its floor is that of the wider opening."""
    pytest.importorskip("myo_sim", reason="the extra `myohand` is not installed")
    loaded = []
    load = Session.load

    def seen(self, experiment, settings=()):
        loaded.append(load(self, experiment, settings))
        return loaded[-1]

    monkeypatch.setattr(Session, "load", seen)
    patient = ("patient=sci_c6", "cohort=3", "member=9", *three_trials._hand(9))
    ways = three_trials.grasp(Session((9,), patient, 709, three_trials.grasp), tmp_path)["ways"]
    assert [way["failed"] for way in ways.values()] == ["", ""]
    documents = [each.document() for each in loaded]
    opened = [each["blocks"]["reference"]["phases"][1]["deg"] for each in documents
              if "reference" in each["blocks"]]
    assert opened == [{"wrist_extension": 25, **{f"F{i}_flexion": 8.0 for i in range(2, 6)}},
                      {"wrist_extension": 25, "finger_flexion": 8.0}]
    assert 4.0 < ways["sweep"]["floor"] < 7.0


@pytest.mark.slow
def test_a_person_is_swept_and_grasps(tmp_path):
    session = Session((0,), ("patient=sci_c6", "cohort=3", "member=1"), 700, three_trials.grasp)
    ways = three_trials.grasp(session, tmp_path)["ways"]
    assert [way["failed"] for way in ways.values()] == ["", ""]
    assert 3.0 < ways["sweep"]["min"] < 3.7
    assert any(ways["sweep"]["held"])
    assert 0.0 < ways["sweep"]["floor"] < 10.0
    assert math.isnan(ways["identify"]["floor"])


@pytest.mark.parametrize(("floor", "within"), [(1.5, "1 of 1"), (0.5, "0 of 1")])
def test_only_a_trial_that_holds_counts_within_the_floor(floor, within):
    """The second trial holds at 4 deg; the third, nearer to the floor, does not hold."""
    ways = {"sweep": {**HELD, "floor": floor}, "identify": LOST}
    found = three_trials.compare([{"failed": "", "ways": ways}])
    (row,) = [row for row in found.rows if "floor" in row.row]
    assert (row.table, row.ours) == (three_trials.WAYS["sweep"], within)

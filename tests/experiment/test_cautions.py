"""Runs that show nothing say so: way-points beyond the trial, loops that are not closed."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop.apps.cli import main
from fesloop.errors import FesloopError
from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.files.parse import read
from fesloop.experiment.files.source import shipped
from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.sentence import sentence_of

BASE = ["experiment.duration_s=3", "score.after_s=1"]
CUT = [*BASE, "blocks.reference.times_s=[1000, 2500]",
       "blocks.reference.angles_deg=[[20, 25, 15], [34, 45, 22]]"]
OPEN = ['wires."finger.angles->tracker.angles".from=reference.angles']
EXPERIMENT = "finger_pid_latency"


def test_the_scored_reference_of_a_shipped_experiment_needs_no_caution():
    assert experiment_cautions(fesloop.load(EXPERIMENT)) == []


@settings(deadline=None, max_examples=30)
@given(st.lists(st.floats(0.0, 6.0), min_size=2, max_size=4, unique=True).map(sorted))
def test_way_points_beyond_the_trial_and_a_reference_that_stays_are_named(times):
    """Truth: a way-point moves the reference between it and the one before, each is 10 deg from the last."""
    times = [round(time, 2) for time in times]
    if len(set(times)) < len(times):
        return
    angles = [[10.0 + 10.0 * (i % 2)] * 3 for i in range(len(times))]
    told = experiment_cautions(fesloop.load(EXPERIMENT, [
        *BASE, f"blocks.reference.times_s={times}", f"blocks.reference.angles_deg={angles}"]))
    beyond, still = any(time > 3.0 for time in times), times[0] >= 3.0 or times[-1] <= 1.0
    assert bool(told) == (beyond or still)
    for node, status, detail in told:
        assert (node, status) == ("reference", "reference_still" if still else "reference_cut_off")
        assert ("lie beyond the trial of 3 s" in detail) == beyond


@pytest.mark.parametrize(("change", "said"), [
    (CUT, "does not move from 1 to 3 s"),
    ([*BASE, "score.until_s=7"], "score.until_s is 7 s, and a trial ends at 3 s"),
    ([*BASE, *OPEN], "no way leads from the patient to the input `measured` of `controller`")])
def test_check_run_and_report_say_it(change, said, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = [word for each in change for word in ("--set", each)]
    assert main(["check", EXPERIMENT, *given]) == 0
    checked = " ".join(capsys.readouterr().out.split())
    assert said in checked
    assert ("No latency budget: no path leads" in checked) == (change[-1] in OPEN)
    assert main(["run", EXPERIMENT, *given]) == 0
    out = capsys.readouterr()
    assert re.search(f"fesloop: caution: .*{re.escape(said)}", out.err)
    with Recording(out.out.strip().splitlines()[-1]) as recording:
        assert said in sentence_of(known_of(recording))


@settings(deadline=None, max_examples=20)
@given(st.sampled_from([("finger_control", key, 6000.0) for key in (
    "latency_ms", "silence_ms", "blocks.tracker.offset_ms")]
    + [("grasp_emg", "blocks.reference.hold_ms", 14000.0), ("finger_pid_latency", "latency_ms", 12000.0)]),
    st.one_of(st.floats(1e-3, 2.0), st.floats(2.0, 1e5)))
def test_durations_longer_than_a_trial_are_named(case, share):
    name, key, trial_ms = case
    value = round(share * trial_ms, 2)
    given = [f"{key}={value}", *(["control=pid"] if name == "finger_control" else [])]
    found = [detail for _, status, detail in experiment_cautions(fesloop.load(name, given))
             if status == "longer_than_trial"]
    assert len(found) == (value > trial_ms)
    assert all(f"{key.rpartition('.')[2]}" in each and f"longer than a trial ({trial_ms:g} ms)" in each
               for each in found)


@settings(deadline=None, max_examples=20)
@given(st.floats(1.5, 20.0), st.floats(1.5, 20.0))
def test_a_score_beyond_the_trial_is_named_in_one_caution(duration_s, until_s):
    """Scored until `until_s`; the grasp's own spans begin at 4 and 6.2 s and end at 8.5 s."""
    duration_s, until_s = round(duration_s, 2) + 1.0, round(until_s, 2) + 1.0
    given = ["scene=cylinder", f"experiment.duration_s={duration_s}", f"score.until_s={until_s}"]
    found = [detail for node, _, detail in experiment_cautions(fesloop.load("grasp_mpc", given))
             if node == "score"]
    spans = {"score.until_s": until_s, "score.grasp.from_s": 6.2, "score.grasp.until_s": 8.5,
             "score.grasp.starts_s": 4.0}
    late = [f"{key} is {value:g} s" for key, value in spans.items() if value > duration_s + 1e-9]
    told = [detail.partition(", and a trial ends")[0] for detail in found]
    assert told == ([", ".join(late)] if late else [])


@settings(deadline=None, max_examples=15)
@given(st.sampled_from(["cylinder", "ball", "block"]), st.floats(20.0, 200.0))
def test_an_object_that_is_put_above_or_into_its_table_is_named_with_what_puts_it_right(shape, tall):
    """The table of the grasp is 60.1 mm below the object's centre."""
    tall = round(tall, 1)
    size = {"cylinder": [50.0, tall], "ball": [tall], "block": [50.0, 40.0, tall]}[shape]
    given = [f"blocks.hand.object.shape={shape}", f"blocks.hand.object.size_mm={size}"]
    found = [detail for _, status, detail in experiment_cautions(fesloop.load("grasp_mpc", given))
             if status == "object_off_table"]
    assert len(found) == (abs(tall - 120.2) > 10.0)
    for detail in found:
        assert ("falls onto it" if tall < 120.0 else "has no room") in detail
        for key in ("object.position_m[2]", "table.height_m"):
            (value,) = re.findall(re.escape(key) + r" = (\S+)", detail)
            right = {"table.height_m": f"blocks.hand.table.height_m={value}",
                     "object.position_m[2]": f"blocks.hand.object.position_m=[-0.006, 0.112, {value}]"}[key]
            mended = experiment_cautions(fesloop.load("grasp_mpc", [*given, right]))
            assert "object_off_table" not in [status for _, status, _ in mended]


@pytest.mark.slow
def test_no_shipped_experiment_has_a_duration_longer_than_its_trial_or_an_object_off_its_table():
    """With every option of every variant: muscles fatigue over minutes, and sensors drift over hours."""
    for name in shipped():
        _, document = read(name)
        variants = document.get("variants", {}).items()
        for picked in ([], *([f"{variant}={option}"] for variant, table in variants
                             for option in table if option != "default")):
            try:
                experiment = fesloop.load(name, picked)
            except FesloopError:  # needs more settings
                continue
            statuses = [status for _, status, _ in experiment_cautions(experiment)]
            assert not {"longer_than_trial", "object_off_table"}.intersection(statuses), (name, picked)

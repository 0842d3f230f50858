"""The most important thing that went wrong comes first, whatever else did; on screen and in reports."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_files import write

from fesloop.apps.cli import main
from fesloop.apps.cli.run_command import _events as events_in_summary
from fesloop.experiment.metrics.grasp_outcome import OUTCOMES
from fesloop.experiment.recording.reading import Event
from fesloop.experiment.trouble import KINDS, troubles
from fesloop.show.report.comparison.page import sentence_of as sentence_of_several
from fesloop.show.report.run.events import events_section
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.sentence import sentence_of

S = 1_000_000_000
NOTE = "controller.model explains little: the free run of finger_flexion has a fit of 10.5 %, 20 %"


def event(second, where, status, trial=0):
    return Event(trial, round(second * S), where, status, "what happened")


@st.composite
def runs(draw):
    """A run with some kinds of trouble, and what is no trouble mixed in."""
    kinds = draw(st.sets(st.sampled_from(KINDS)))
    outcome = draw(st.sampled_from([word for word in OUTCOMES if word not in ("held", "incomplete")]))
    trials = draw(st.integers(2, 4)) if "rose" in kinds else draw(st.integers(1, 4))
    last = trials - 1
    events = [event(0.0, "tracker", "aligning"), event(0.0, "controller", "no_input"),
              event(draw(st.floats(0.0, 0.9)), "safety", "posture_frozen"), event(1.0, "tracker", "aligned"),
              *(event(draw(st.floats(0.0, 9.0)), "controller", "saturated", last) for _ in range(3))]
    if "recording" in kinds:
        events.append(event(*draw(st.sampled_from([(0.0, "recording", "rates_disagree"),
                                                   (5.0, "tracker", "implausible_angle")]))))
    if "pose" in kinds:
        status = draw(st.sampled_from(["pose_contradicted", "rates_beyond_range"]))
        events.append(event(draw(st.floats(0.0, 9.0)), "tracker", status))
    if "safety" in kinds:
        status = draw(st.sampled_from(["posture_silent", "posture_jumped", "posture_frozen", "emergency_stop",
                                       "charge_exhausted"]))
        events.append(event(draw(st.floats(1.1, 9.0)), "safety", status))
    if "failed" in kinds:
        status = draw(st.sampled_from(["initial_pose_failed", "device_failed", "non_finite"]))
        events.append(event(draw(st.floats(0.0, 9.0)), draw(st.sampled_from(["tracker", "other"])), status))
    errors = [3.0 + 2.0 * trial * ("rose" in kinds) for trial in range(trials)]
    metrics = {"joint_rmse_deg": errors, "held": ["not_held" not in kinds] * trials,
               "unmoved_rmse_deg": [errors[-1] * (0.9 if "no_better" in kinds else 1.5)] * trials,
               "object_outcome": [outcome if "not_held" in kinds else "held"] * trials}
    broken = draw(st.sampled_from(["failed", "interrupted", "running"]))
    recording = SimpleNamespace(
        status=broken if "broken_off" in kinds else "done", trials=trials, name="grasp", signals=(),
        events=tuple(sorted(events, key=lambda each: (each.trial, each.time_ns))),
        experiment={"blocks": {"safety": {"kind": "safety"}, "tracker": {"kind": "salchow_m2"}},
                    "experiment": {"notes": [NOTE]} if "noted" in kinds else {}})
    return kinds, Known(recording, trials, tuple(range(trials)), None, metrics, {}, (), frozenset())


@given(runs())
def test_troubles_are_all_told_in_the_order_of_their_weight(run):
    kinds, known = run
    found = troubles(known.recording, known.metrics)
    # Trials that were not alike are not compared.
    told = kinds - {"rose"} if kinds & {"recording", "pose", "safety", "failed"} else kinds
    assert list(dict.fromkeys(each.kind for each in found)) == [kind for kind in KINDS if kind in told]
    assert all(each.sentence.endswith(".") and not math.isnan(len(each.text)) for each in found)


@given(runs())
def test_a_report_begins_with_the_most_important(run):
    kinds, known = run
    told = sentence_of(known)
    found = [each for each in troubles(known.recording, known.metrics)
             if each.kind not in ("broken_off", "rose")]
    if "broken_off" in kinds:
        assert told.startswith(("The run failed", "The run was interrupted", "The run is still under way"))
    elif found:
        assert told.startswith(found[0].sentence)
        assert all(each.text[1:] in told for each in found)
    else:
        assert told.startswith("The tracking error")
    assert told.count("The object was not held:") + told.count("the object was not held:") <= 1


@given(runs(), runs())
def test_runs_side_by_side_begin_with_what_went_worst(one, other):
    both = [SimpleNamespace(known=known, name=name, recording=known.recording,
                            last_error=lambda metric, known=known: known.metrics.get(metric, [math.nan])[-1])
            for name, (_, known) in zip("AB", (one, other), strict=True)]
    told = sentence_of_several(both)
    ranks = [min((KINDS.index(kind) for kind in kinds), default=len(KINDS)) for kinds, _ in (one, other)]
    if min(ranks) < len(KINDS):
        assert told.startswith("In A, " if ranks[0] <= ranks[1] else "In B, ")
    else:
        assert told.startswith("2 runs of `grasp`")


@pytest.mark.slow
@pytest.mark.parametrize(("settings", "first"), [
    (["blocks.hand.table.lowered_at_s=-1", "blocks.hand.object.given_at_s=9.9"],
     "fesloop: the object was not held: it was never given"),
    (["blocks.tracker.pose_limits.gravity=0.001"],
     "fesloop: no channel gave a pulse: safety: not_aligned at 0 s: a tracker's initial pose has not been"),
    (["blocks.tracker.initial_pose_s=1.0", "blocks.hand.assist.until_s=0.5"],
     "fesloop: the angles of `tracker` are not to be trusted")])
def test_the_summary_begins_with_the_most_important(settings, first, tmp_path, capsys):
    arguments = [part for setting in settings for part in ("--set", setting)]
    if "given" in first:
        arguments += ["--set", "tracker=ideal"]
    assert main(["run", "grasp_mpc", *arguments, "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err.startswith(first)


FATES = st.sampled_from(["held", "dropped", "not_given", "not_touched", "incomplete"])


@given(st.lists(FATES, min_size=1, max_size=5))
def test_failure_is_counted_over_all_trials_with_the_reason_of_each(fates):
    known = {"held": True, "incomplete": None}
    metrics = {"held": [known.get(fate, False) for fate in fates], "object_outcome": fates}
    texts = [each.text for each in troubles(Told([(1.0, 1.0, 1.0)] * len(fates)), metrics)
             if each.kind == "not_held"]
    lost = {fate for fate in fates if fate not in known}
    assert len(texts) == (fates[-1] in lost)
    for text in texts:
        count = fates.count("held")
        assert (f"held in {count or 'none'} of {len(fates)} trials" in text) == (len(fates) > 1)
        assert {fate for fate in OUTCOMES if OUTCOMES[fate] in text} == lost
        for fate in lost if len(lost) > 1 else ():
            which = text.split(f"{OUTCOMES[fate]} (trial")[1].split(")")[0]
            assert [int(each) for each in re.findall("[0-9]+", which)] == [
                trial for trial, each in enumerate(fates) if each == fate]


def test_an_object_that_was_never_held_is_said_so_once():
    fates = ["not_given", "dropped", "not_given"]
    metrics = {"held": [False] * 3, "object_outcome": fates}
    assert [each.text for each in troubles(Told([(1.0, 1.0, 1.0)] * 3), metrics)] == [
        "the object was held in none of 3 trials: it was never given: the hand left no room for it "
        "(trials 0 and 2); it was in the hand and fell (trial 1)"]


class Told:
    """A recording of a safety block between a controller and a stimulator, one row each 100 ms."""

    def __init__(self, trials, events=(), learns=False):
        self.charges, self.trials, self.status, self.name = trials, len(trials), "done", "grasp"
        self.events = tuple(events)
        self.signals = ["controller.stimulation", "safety.stimulation", "stimulator.charge"]
        self.experiment = {
            "blocks": {"controller": {"kind": "ilc" if learns else "mpc"}, "safety": {"kind": "safety"}},
            "wires": [{"from": "controller.stimulation", "to": "safety.stimulation"},
                      {"from": "safety.stimulation", "to": "stimulator.stimulation"}]}

    def tables(self, names, trial=0):
        uc = np.full((100, 2), 1e-6 * self.charges[trial][self.signals.index(names[0])])
        pulses = np.stack([np.full(uc.shape, 1e-2), 100.0 * uc], axis=2)
        values = uc if names[0].endswith("charge") else pulses
        piece = SimpleNamespace(times_ns=np.arange(100) * S // 10, values=(values,))
        return [SimpleNamespace(pieces=lambda: iter([piece]))]


CHARGES = st.sampled_from([0.0, 1.0, 3.0])
"""Asked, passed and given, uC."""
FLOW = st.tuples(CHARGES, CHARGES, CHARGES).map(lambda each: tuple(sorted(each, reverse=True)))


@given(st.lists(FLOW, min_size=1, max_size=4), st.sampled_from([0.0, 9.0]), st.booleans())
def test_the_first_sentence_is_that_no_channel_gave_a_pulse_where_one_was_due(flows, still, learns):
    metrics = {"joint_rmse_deg": [1.0] * len(flows), "unmoved_rmse_deg": [still] * len(flows)}
    texts = [each.text for each in troubles(Told(flows, learns=learns), metrics)]
    without = [trial for trial, (asked, _, given_) in enumerate(flows) if given_ == 0.0 and (
        asked > 0.0 or (still > 0.0 and not (learns and trial == 0)))]
    assert any("no channel gave a pulse" in text for text in texts) == bool(without)
    if without:
        assert texts[0].startswith("no channel gave a pulse")
        assert len(flows) == 1 or f"{len(without)} of {len(flows)} trials" in texts[0]
    cut = [trial for trial, (asked, passed, _) in enumerate(flows)
           if trial not in without and passed < 0.5 * asked]
    assert any("of the charge that was commanded" in text for text in texts) == bool(cut)


@pytest.mark.parametrize(("status", "second", "told"), [
    ("stale_input", 3.0, True), ("no_posture", 3.0, True), ("posture_silent", 0.5, True),
    ("stale_input", 0.5, False), ("not_aligned", 0.0, False), ("no_input", 0.0, False)])
def test_stimulation_is_taken_away_by_whatever_keeps_it_off_beyond_alignment(status, second, told):
    events = [event(0.0, "tracker", "aligning"), event(second, "safety", status),
              event(1.0, "tracker", "aligned")]
    texts = [each.text for each in troubles(Told([(3.0, 2.0, 2.0)], events), {})]
    assert bool(texts and texts[0].startswith(f"stimulation was taken away at {second:.3g} s")) == told


def test_the_summary_says_first_that_no_pulse_was_given_and_why(tmp_path, capsys):
    assert main(["run", "finger_control", "--set", "loss=0.9999", "--out", str(tmp_path)]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("fesloop: caution:")]
    assert said[0].startswith("fesloop: no channel gave a pulse: none was commanded: controller.stimulation")
    assert "(controller: no_input" in said[0]


@given(st.floats(0.0, 20.0), st.floats(1.0, 20.0))
def test_a_controller_that_begins_after_the_trial_is_why_there_is_no_pulse(begin_s, duration_s):
    told = Told([(0.0, 0.0, 0.0)], [event(0.0, "controller", "no_input")])
    told.experiment["experiment"] = {"duration_s": duration_s}
    told.experiment["blocks"]["controller"]["begin_s"] = begin_s
    text = troubles(told, {"joint_rmse_deg": [9.0], "unmoved_rmse_deg": [9.0]})[0].text
    never = f"(controller: begin_s is {begin_s:g} s, and a trial ends at {duration_s:g} s)"
    assert text.endswith(never) == (begin_s >= duration_s)
    assert ("no_input" in text) == (begin_s < duration_s)


@given(st.integers(0, 30), st.sampled_from(["stale_input", "posture_silent", "no_posture",
                                                 "charge_exhausted"]))
def test_no_list_of_events_cuts_off_what_is_grave(others, status):
    events = [event(0.1 * i, "other", f"saturated_{i}") for i in range(others) for _ in range(2)]
    events += [event(9.0, "safety", status), event(9.5, "tracker", "initial_pose_failed")]
    assert [kind for (_, kind), _ in events_in_summary(events, "")][:2] == ["initial_pose_failed", status]
    rows = events_section(Known(SimpleNamespace(events=events, messages=()), 1, (0,), None, {}, {}, (),
                                frozenset())).parts[0].rows
    assert "initial_pose_failed" in rows[0][0]
    assert status in rows[1][0]


def test_of_events_as_grave_those_of_the_tracker_that_is_scored_come_first():
    events = [event(0.1 * i, "controller", "saturated") for i in range(9)]
    events += [event(0.5, "tracker", "uncertain"), event(0.6, "safety", "stale_input"),
               event(0.7, "tracker", "misfit")]
    assert [kind for (_, kind), _ in events_in_summary(events, "tracker")] == [
        "misfit", "stale_input", "uncertain", "saturated"]


def test_a_replay_says_first_what_its_tracker_says_of_itself(tmp_path, capsys):
    path = write(tmp_path, "wrist")
    assert main(["run", "replay", "--set", f"recording={path}", "--out", str(tmp_path),
                 "--set", "blocks.safety.max_age_ms=0.01"]) == 0
    told = re.findall(r"events +\d+ x (\w+) \((\w+)\)", capsys.readouterr().err)
    nodes = [node for _, node in told]
    assert {"tracker", "safety"} <= set(nodes)
    assert nodes == sorted(nodes, key=lambda node: node != "tracker")


def test_a_silent_controller_is_named_where_safety_only_said_how_a_trial_begins():
    """`no_posture` at 0 s is how every trial begins, and no reason."""
    told = Told([(0.0, 0.0, 0.0)], [event(0.0, "safety", "no_posture")])
    first = troubles(told, {"joint_rmse_deg": [9.0], "unmoved_rmse_deg": [9.0]})[0].text
    assert first == "no channel gave a pulse: none was commanded: controller.stimulation has none"
    events = [event(0.0, "safety", "no_posture"), event(0.0, "controller", "no_input")]
    heard = Told([(0.0, 0.0, 0.0)], events)
    assert "(controller: no_input" in troubles(heard, {"unmoved_rmse_deg": [9.0]})[0].text
    kept = Told([(3.0, 0.0, 0.0)], [event(0.0, "safety", "no_posture")])
    assert "safety: no_posture" in troubles(kept, {})[0].text


def test_an_angle_about_an_axis_that_its_joint_hardly_turns_about_is_named():
    shares = {"a-b": 0.03, "b-c": 0.97}
    texts = [each.text for each in troubles(Told([(3.0, 2.0, 2.0)], []), {"flexion_axis_share": shares})]
    (told,) = [text for text in texts if "are about z" in text]
    assert "a-b (3 %)" in told
    assert "b-c" not in told


@given(still=st.floats(1.01, 50.0), ratio=st.floats(0.9, 1.2))
def test_errors_that_are_shown_alike_are_not_called_worse(still, ratio):
    metrics = {"joint_rmse_deg": [ratio * still], "unmoved_rmse_deg": [still]}
    texts = [each.text for each in troubles(Told([(1.0, 1.0, 1.0)], learns=False), metrics)]
    (followed,) = [text for text in texts if "than if they had not moved" in text] or [""]
    assert ("worse" in followed) == (ratio * still > 1.01 * still)
    assert bool(followed) == (ratio * still > still)


@pytest.mark.parametrize(("errors", "told"), [
    ([9.9, 2.3, 7.9, 8.3],
     "the tracking error is 8.3 deg RMS in the last of 4 trials, and was 2.3 deg in trial 1"),
    ([9.8, 4.2, 2.9, 1.6, 2.2, 1.5, 2.6, 2.2], ""), ([9.9, math.nan, 2.0, 4.1], "was 2 deg in trial 2"),
    ([9.9, 2.0, 4.0], ""), ([0.5, 0.2, 0.5], ""), ([3.0, 1.0, 3.2], "was 1 deg in trial 1"),
    ([3.0, 1.0, 3.4], "rose from 3 deg RMS in the first of 3 trials to 3.4 deg in the last"),
    ([9.9, 2.0, math.nan], ""), ([math.nan, math.nan], ""), ([5.0], "")])
@pytest.mark.parametrize("learns", [True, False])
def test_a_last_trial_that_is_worse_than_the_best_is_named_with_a_remedy(errors, told, learns):
    recording = Told([(1.0, 1.0, 1.0)] * len(errors), learns=learns)
    found = [each for each in troubles(recording, {"joint_rmse_deg": errors}) if each.kind == "rose"]
    assert len(found) == bool(told)
    for each in found:
        assert told in each.text
        assert f"trial {errors.index(np.nanmin(errors))}" in each.text
        assert each.text.endswith("(block `mpc`, as in grasp_mpc)") == learns


@given(st.lists(st.floats(1.0, 30.0), min_size=2, max_size=5), st.data())
def test_learning_that_makes_it_worse_is_told_where_the_tracker_is_as_wrong_in_each_trial(errors, data):
    lost = data.draw(st.sets(st.integers(0, len(errors) - 1), min_size=1))
    recording = Told([(1.0, 1.0, 1.0)] * len(errors),
                     [event(1.3, "tracker", "rates_beyond_range", trial) for trial in sorted(lost)])
    recording.experiment["blocks"]["controller"]["memory"] = {"share": 0.5}
    texts = [each.text for each in troubles(recording, {"joint_rmse_deg": errors}) if each.kind == "rose"]
    alike = len(lost) == len(errors)
    if errors[-1] > max(1.25 * errors[0], errors[0] + 1.0):
        assert len(texts) == alike
    for text in texts:
        assert f"trial {int(np.argmin(errors))}" in text
        assert "learn less from each trial (`memory.share`)" in text


def test_a_negative_current_is_why_there_is_no_pulse():
    events = [event(0.0, "safety", "no_posture"), event(0.02, "safety", "negative")]
    told = Told([(-3.0, 0.0, 0.0)], events)
    assert "safety: negative" in troubles(told, {"joint_rmse_deg": [9.0], "unmoved_rmse_deg": [9.0]})[0].text

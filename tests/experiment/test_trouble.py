"""The most important thing that went wrong comes first, whatever else did; on screen and in reports."""

import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.cli import main
from fesloop.experiment.metrics.grasp_outcome import OUTCOMES
from fesloop.experiment.recording.recorded import Event
from fesloop.experiment.trouble import KINDS, troubles
from fesloop.report.comparison.scored import sentence_of as sentence_of_several
from fesloop.report.run.known import Known
from fesloop.report.run.sentence import sentence_of

S = 1_000_000_000
NOTE = "controller.model explains little: the free run of finger_flexion has a fit of 10.5 %, 20 %"


def event(second, where, status, trial=0):
    return Event(trial, round(second * S), where, status, "what happened")


@st.composite
def runs(draw):
    """A run with some kinds of trouble, and what is no trouble mixed in."""
    kinds = draw(st.sets(st.sampled_from(KINDS)))
    outcome = draw(st.sampled_from([word for word in OUTCOMES if word not in ("held", "not_known")]))
    trials = draw(st.integers(2, 4)) if "rose" in kinds else draw(st.integers(1, 4))
    last = trials - 1
    events = [event(0.0, "tracker", "aligning"), event(0.0, "controller", "no_input"),
              event(draw(st.floats(0.0, 0.9)), "safety", "posture_frozen"), event(1.0, "tracker", "aligned"),
              *(event(draw(st.floats(0.0, 9.0)), "controller", "saturated", last) for _ in range(3))]
    if "safety" in kinds:
        status = draw(st.sampled_from(["posture_silent", "posture_jumped", "posture_frozen", "stopped",
                                       "budget_spent"]))
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
        status=broken if "broken_off" in kinds else "done", trials=trials, name="grasp",
        events=tuple(sorted(events, key=lambda each: (each.trial, each.time_ns))),
        experiment={"blocks": {"safety": {"kind": "safety"}, "tracker": {"kind": "salchow_m2"}},
                    "experiment": {"notes": [NOTE]} if "noted" in kinds else {}})
    return kinds, Known(recording, trials, tuple(range(trials)), None, metrics, {}, (), frozenset())


@given(runs())
def test_troubles_are_all_told_in_the_order_of_their_weight(run):
    kinds, known = run
    found = troubles(known.recording, known.metrics)
    assert list(dict.fromkeys(each.kind for each in found)) == [kind for kind in KINDS if kind in kinds]
    assert all(each.sentence.endswith(".") and not math.isnan(len(each.text)) for each in found)


@given(runs())
def test_a_report_begins_with_the_most_important(run):
    kinds, known = run
    told = sentence_of(known)
    found = [each for each in troubles(known.recording, known.metrics)
             if each.kind not in ("broken_off", "rose")]
    if "broken_off" in kinds:
        assert told.startswith(("The run failed", "The run was interrupted", "The run is not over"))
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


@pytest.mark.parametrize(("settings", "first"), [
    (["blocks.hand.table.lowered_at_s=-1", "blocks.hand.object.given_at_s=9.9"],
     "fesloop: the object was not held: it was never given"),
    (["blocks.tracker.initial_pose_s=1.0", "blocks.hand.settle_s=0"],
     "fesloop: tracker: initial_pose_failed")])
def test_the_summary_begins_with_the_most_important(settings, first, tmp_path, capsys):
    arguments = [part for setting in settings for part in ("--set", setting)]
    if "given" in first:
        arguments += ["--set", "tracker=ideal"]
    assert main(["run", "grasp_mpc", *arguments, "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err.startswith(first)

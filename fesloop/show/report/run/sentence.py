"""The result of a run in one sentence: what was measured, and no more than that."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.trouble import comparable, troubles
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.words import counted, listed, told

_SAID = ("broken_off", "rose")
"""Kinds of trouble that the sentence says otherwise: by how it begins, and by the course of the error."""
_BROKEN_OFF = {"running": "The run is not over, or was killed; of what it had recorded: ",
               "damaged": "The file is damaged; of what is left of it: ",
               "failed": "The run failed; of what it had recorded: ",
               "interrupted": "The run was interrupted; of what it had recorded: "}


def sentence_of(known: Known) -> str:
    """What came of the run, exactly: first what went wrong, then what was measured, and what is not."""
    status = known.recording.status
    before = _BROKEN_OFF.get(status, "" if status == "done" else f"The run ended as {status!r}: ")
    if not known.begun:
        return f"{before}nothing was recorded." if before else "Nothing was recorded."
    found = troubles(known.recording, known.metrics)
    wrong = [each for each in found if each.kind not in _SAID]
    repeated = len(known.metrics.get("held") or ()) == 1 and any(each.kind == "not_held" for each in wrong)
    findings = list(_findings(known, grasp=not repeated, compared=comparable(found)))
    if not findings and not repeated:
        findings = [f"{counted(known.begun, 'trial')} recorded, of which nothing was scored"]
    if before:
        return f"{before}{'; '.join([*(each.text for each in wrong), *findings])}."
    text = "; ".join(findings)
    told = [each.sentence for each in wrong[:1]]
    if wrong[1:]:
        told.append(f"Also: {'; '.join(each.text for each in wrong[1:])}.")
    if known.experiment is not None:
        told += [f"Caution: `{node}`: {detail}." for node, _, detail in experiment_cautions(known.experiment)]
    if text:
        told.append(f"{text[:1].upper()}{text[1:]}.")
    return " ".join(told)


def _findings(known: Known, *, grasp: bool, compared: bool) -> Iterator[str]:
    """What was found, the most important first.

    Parameters
    ----------
    grasp: whether the object was held, too.
    compared: whether trials can be: else no change from one to another is claimed.
    """
    yield from _tracking(known, compared)
    if grasp:
        yield from _grasp(known)
    yield from _grip(known)
    yield from _search(known.metrics)
    yield from _played(known)
    yield from _tracker(known)
    yield from _fingertips(known)
    yield from _decline(known)


def _tracking(known: Known, compared: bool) -> Iterator[str]:
    errors = known.per_trial("joint_rmse_deg")
    finite = [error for error in errors if math.isfinite(error)]
    if not errors:
        return
    over = _over(known)
    if not finite:
        yield f"no tracking error is known: there is nothing to score in {counted(len(errors), 'trial')}"
    elif len(errors) == 1:
        yield f"the tracking error{over} was {told(finite[0])} deg RMS"
    elif compared:
        yield _course(errors, over, _in_last(known))
    else:
        among = "" if len(finite) == len(errors) else f"{len(finite)} of "
        yield (f"the tracking error{over} was {_range(finite)} deg RMS in {among}"
               f"{counted(len(errors), 'trial')}, which were not alike: no change over them is claimed")


def _in_last(known: Known) -> str:
    """The last trial, which a run that broke off has a part of."""
    return "in the last" if known.recording.status == "done" else "in what there is of the last"


def _course(errors: list[float], over: str, in_last: str) -> str:
    """From the first to the last trial, and the least between where that is less."""
    first, last = errors[0], errors[-1]
    if not (math.isfinite(first) and math.isfinite(last)):
        known = [error for error in errors if math.isfinite(error)]
        others = "other" if len(errors) - len(known) == 1 else "others"
        return (f"the tracking error{over} was {_range(known)} deg RMS in {len(known)} of "
                f"{counted(len(errors), 'trial')} (in the {others} it is not known)")
    least = min(error for error in errors if math.isfinite(error))
    if told(first) == told(last):
        text = (f"the tracking error{over} was {told(first)} deg RMS in the first of {len(errors)} trials "
                f"and {in_last}")
    else:
        way = "fell" if last < first else "rose"
        text = (f"the tracking error{over} {way} from {told(first)} deg RMS in the first of {len(errors)} "
                f"trials to {told(last)} deg {in_last}")
    if told(least) != told(min(first, last)):
        text += f" (the least, {told(least)} deg, in trial {errors.index(least)})"
    return text


def _over(known: Known) -> str:
    """The while that is scored, where that is a part of the trial."""
    (after, end), until = known.scored_span_s(), known.score.get("until_s")
    if until is not None:
        short = f" (the trial ended before {until:g} s)" if end != until else ""
        return f" from {after:g} to {end:g} s{short}"
    return f" after the first {after:g} s" if after else ""


def _grasp(known: Known) -> Iterator[str]:
    held = known.metrics.get("held")
    if not isinstance(held, list) or not held:
        return
    told_of = [each for each in held if each is not None]
    if not told_of:
        yield "whether the object was held is not known: no trial lasted long enough"
    elif len(held) == 1:
        yield "the object was held"
    else:
        among = f", the last one {'' if held[-1] else 'not '}among them"
        last = among if held[-1] is not None and any(told_of) and not all(told_of) else ""
        unknown = len(held) - len(told_of)
        rest = f" (of {unknown} it is not known)" if unknown else ""
        yield f"the object was held in {sum(told_of)} of {len(held)} trials{rest}{last}"


def _newest(known: Known, name: str) -> tuple[float, str]:
    """A metric of the last trial that it is known of, and which that is, where there are several."""
    values = known.per_trial(name)
    finite = [trial for trial, value in enumerate(values) if math.isfinite(value)]
    if not finite:
        return math.nan, ""
    if len(values) == 1:
        return values[0], ""
    last = finite[-1] == len(values) - 1
    return values[finite[-1]], f" {_in_last(known)} trial" if last else f" in trial {finite[-1]}"


def _grip(known: Known) -> Iterator[str]:
    error, which = _newest(known, "grip_force_rmse_n")
    if math.isfinite(error):
        yield f"grip force was {told(error)} N RMS from what was wanted{which}"


def _search(metrics: Mapping[str, Any]) -> Iterator[str]:
    queries = metrics.get("queries")
    if not isinstance(queries, list) or not queries:
        return
    minutes = metrics.get("minutes", [math.nan])[0]
    over = f"in {told(minutes)} minutes" if math.isfinite(minutes) else "and had not ended"
    text = f"the search asked {queries[0]} times {over}"
    found = metrics.get("found_elements")
    if found and found[0]:
        share = metrics.get("optimum_share", [math.nan])[0]
        of_best = f", {100.0 * share:.0f} % of the best that there is" if math.isfinite(share) else ""
        elements = f"element{'s' if len(found[0]) != 1 else ''} {listed(list(map(str, found[0])))}"
        text += (f", and recommends {elements} at {told(metrics['found_ma'][0])} mA "
                 f"(quality {told(metrics['found_quality'][0])}{of_best})")
    yield text


def played_by(known: Known) -> list[str]:
    """Blocks that play a recording in a run whose patient answers to nothing."""
    blocks = known.recording.experiment.get("blocks", {})
    if known.scored("truth") or (known.cast is not None and known.cast.hand is not None):
        return []
    return [name for name, table in blocks.items() if "recording" in table]


def _played(known: Known) -> Iterator[str]:
    players = played_by(known)
    errors = known.metrics.get("orientation_rmse_deg")
    if isinstance(errors, dict) and errors:
        totals = [each["total"] for each in errors.values()
                  if isinstance(each, dict) and math.isfinite(each.get("total", math.nan))]
        if totals:
            yield f"the tracker's orientations were {_range(totals)} deg RMS from the recording's reference"
    if players:
        yield "a recording was played, which cannot answer to stimulation: no tracking error is claimed"


def _range(values: list[float]) -> str:
    """From the least to the greatest; one where they look the same."""
    least, greatest = told(min(values)), told(max(values))
    return least if least == greatest else f"{least} to {greatest}"


def _tracker(known: Known) -> Iterator[str]:
    error, which = _newest(known, "tracker_rmse_deg")
    if math.isfinite(error):
        split = known.metrics.get("split_rmse_deg", {}).get("total")
        heard = not isinstance(split, list) or not split or any(math.isfinite(each) for each in split)
        unheard = "" if heard else ", of which nothing reached the controller"
        yield f"the tracker's own error{which} was {told(error)} deg RMS{unheard}"


def _fingertips(known: Known) -> Iterator[str]:
    errors = known.metrics.get("fingertip_rmse_mm")
    if isinstance(errors, dict) and errors:
        parts = []
        for tracker, tips in errors.items():
            last = [values[-1] for values in tips.values() if values and math.isfinite(values[-1])]
            if last:
                parts.append(f"{tracker} by {_range(last)} mm")
        if parts:
            which = f" {_in_last(known)} trial" if known.begun > 1 else ""
            yield f"fingertips were off{which} (RMS, by finger): {listed(parts)}"


def _decline(known: Known) -> Iterator[str]:
    decline, which = _newest(known, "decline_pct")
    if math.isfinite(decline):
        cycles = known.score.get("cycles") or {}
        of_one = f" ({cycles['muscle']})" if cycles.get("muscle") else ""
        way = "fell" if decline >= 0.0 else "rose"
        yield (f"the peak of `{cycles.get('signal', 'the signal')}`{of_one} {way} by {told(abs(decline))} % "
               f"from the first cycle to the last{which}")

"""Summary of a run in one or a few sentences: what was measured, and no more."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.metrics.sweep import RESPONDS_DEG
from fesloop.experiment.trouble import comparable, reached, troubles
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.words import counted, listed, rounded

_SAID = ("broken_off", "rose")
"""Kinds of trouble that the summary expresses by its beginning and by the change of the error."""
_MOST_ANGLES = 8
"""Angles of a sweep that the summary names (chosen: the six of a hand's fingers, wrist and thumb)."""
_BROKEN_OFF = {"running": ("The run is still under way or was killed", "recorded so far"),
               "damaged": ("The file is damaged", "in its readable part"),
               "failed": ("The run failed", "recorded until then"),
               "interrupted": ("The run was interrupted", "recorded until then")}


def sentence_of(known: Known) -> str:
    """Summary of a run: first what went wrong, then what was measured."""
    status = known.recording.status
    what, part = _BROKEN_OFF.get(status, (f"The run ended as {status!r}", "recorded"))
    before = "" if status == "done" else f"{what}{reached(known.recording)}; {part}: "
    if not known.begun:
        return f"{before}nothing." if before else "Nothing was recorded."
    found = troubles(known.recording, known.metrics)
    wrong = [each for each in found if each.kind not in _SAID]
    repeated = (known.metrics.get("held") or [None])[-1] is False  # a trouble, which says how often it was
    findings = list(_findings(known, grasp=not repeated, compared=comparable(found)))
    if not findings and not repeated:
        findings = [f"{counted(known.begun, 'trial')} recorded; nothing was scored"]
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
    """Findings, the most important first.

    Parameters
    ----------
    grasp: whether to say if the object was held.
    compared: whether trials are comparable; otherwise no change over trials is claimed.
    """
    yield from _tracking(known, compared)
    if grasp:
        yield from _grasp(known)
    yield from _grip(known)
    yield from _swept(known)
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
        yield f"the tracking error is unknown: there is nothing to score in {counted(len(errors), 'trial')}"
    elif len(errors) == 1:
        yield f"the tracking error{over} was {rounded(finite[0])} deg RMS"
    elif compared:
        yield _course(errors, over, _in_last(known))
    else:
        among = "" if len(finite) == len(errors) else f"{len(finite)} of "
        yield (f"the tracking error{over} was {_range(finite)} deg RMS in {among}"
               f"{counted(len(errors), 'trial')}, which differ, so that no trend is reported")


def _in_last(known: Known) -> str:
    """Words for the last trial, which may be incomplete."""
    return "in the last" if known.recording.status == "done" else "in what there is of the last"


def _course(errors: list[float], over: str, in_last: str) -> str:
    """Change of the error from the first to the last trial, with the least error if another trial has it."""
    first, last = errors[0], errors[-1]
    if not (math.isfinite(first) and math.isfinite(last)):
        known = [error for error in errors if math.isfinite(error)]
        others = "other" if len(errors) - len(known) == 1 else "others"
        return (f"the tracking error{over} was {_range(known)} deg RMS in {len(known)} of "
                f"{counted(len(errors), 'trial')} (unknown in the {others})")
    least = min(error for error in errors if math.isfinite(error))
    if rounded(first) == rounded(last):
        text = (f"the tracking error{over} was {rounded(first)} deg RMS in the first of {len(errors)} trials "
                f"and {in_last}")
    else:
        way = "fell" if last < first else "rose"
        text = (f"the tracking error{over} {way} from {rounded(first)} deg RMS in the first of {len(errors)} "
                f"trials to {rounded(last)} deg {in_last}")
    if rounded(least) != rounded(min(first, last)):
        text += f" (the least, {rounded(least)} deg, in trial {errors.index(least)})"
    return text


def _over(known: Known) -> str:
    """Words for the scored interval if it is a part of the trial."""
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
        yield "whether the object was held is unknown: no trial lasted long enough"
    elif len(held) == 1:
        yield "the object was held"
    else:
        among = f", the last one {'' if held[-1] else 'not '}among them"
        last = among if held[-1] is not None and any(told_of) and not all(told_of) else ""
        unknown = len(held) - len(told_of)
        rest = f" (unknown for {unknown})" if unknown else ""
        yield f"the object was held in {sum(told_of)} of {len(held)} trials{rest}{last}"


def _newest(known: Known, name: str) -> tuple[float, str]:
    """Value of a metric in the last trial in which it is known, with words for that trial."""
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
        yield f"grip force was {rounded(error)} N RMS from the target{which}"


def _search(metrics: Mapping[str, Any]) -> Iterator[str]:
    queries = metrics.get("queries")
    if not isinstance(queries, list) or not queries:
        return
    minutes = metrics.get("minutes", [math.nan])[0]
    over = f"in {rounded(minutes)} minutes" if math.isfinite(minutes) else "and had not ended"
    text = f"the search made {queries[0]} queries {over}"
    found = metrics.get("found_elements")
    if found and found[0]:
        share = metrics.get("optimum_share", [math.nan])[0]
        of_best = f", {100.0 * share:.0f} % of the optimum" if math.isfinite(share) else ""
        elements = f"element{'s' if len(found[0]) != 1 else ''} {listed(list(map(str, found[0])))}"
        text += (f", and recommends {elements} at {rounded(metrics['found_ma'][0])} mA "
                 f"(quality {rounded(metrics['found_measured_quality'][0])} by the tracker, "
                 f"{rounded(metrics['found_true_quality'][0])} in truth{of_best})")
    yield text


def _swept(known: Known) -> Iterator[str]:
    """Elements of a sweep that move the hand, and the strongest for the angles that moved most."""
    moved = known.metrics.get("responding_elements")
    if not moved:
        return
    trial = len(moved) - 1
    which = f" in the last of {len(moved)} trials" if trial else ""
    swept = known.metrics["swept_elements"][trial]
    yield f"{moved[trial]} of {swept} elements moved an angle by {RESPONDS_DEG:g} deg or more{which}"
    strongest = []
    for name, values in known.metrics.get("joints", {}).items():
        ways = [(values[f"{word}_deg"][trial], sign, values[f"{word}_by"][trial])
                for word, sign in (("raised", "+"), ("lowered", "-"))]
        ways = [way for way in ways if math.isfinite(way[0]) and way[0] >= RESPONDS_DEG]
        if ways:
            text = " and ".join(f"{sign}{way:.0f} ({by})" for way, sign, by in ways)
            strongest.append((max(ways)[0], f"{name} {text}"))
    shown = sorted(strongest, reverse=True)[:_MOST_ANGLES]
    if shown:
        others = len(strongest) - len(shown)
        more = f" ({others} more angles moved less)" if others else ""
        yield f"the strongest, deg (element): {', '.join(text for _, text in shown)}{more}"


def played_by(known: Known) -> list[str]:
    """Blocks that replay a recording in a run without a patient model."""
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
            since = known.metrics.get("orientation_from_s")
            yield (f"the tracker's orientations were {_range(totals)} deg RMS from the recording's reference"
                   + (f", from {rounded(since)} s on, when it was aligned" if since else ""))
    if players:
        yield "a recording was replayed, which does not respond to stimulation: there is no tracking error"


def _range(values: list[float]) -> str:
    """Range of values in words; one value if the ends look the same."""
    least, greatest = rounded(min(values)), rounded(max(values))
    return least if least == greatest else f"{least} to {greatest}"


def _tracker(known: Known) -> Iterator[str]:
    error, which = _newest(known, "tracker_rmse_deg")
    if math.isfinite(error):
        split = known.metrics.get("split_rmse_deg", {}).get("total")
        heard = not isinstance(split, list) or not split or any(math.isfinite(each) for each in split)
        unheard = "" if heard else ", and no estimate reached the controller"
        yield f"the tracker's own error in the scored angles{which} was {rounded(error)} deg RMS{unheard}"


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
        yield (f"the peak of `{cycles.get('signal', 'the signal')}`{of_one} {way} by "
               f"{rounded(abs(decline))} % from the first cycle to the last{which}")

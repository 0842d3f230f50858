"""Whose the error was: what the controller could not see, and what it saw and did not put right."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fesloop.experiment.metrics.scoring import alignments
from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.parts import Bars, Chart, Line, Paragraph, Part, Section
from fesloop.show.report.run.axes import from_zero
from fesloop.show.report.run.known import Known, seconds
from fesloop.show.report.run.words import joint_label, listed, told

_WORDS = {"total": ("what the patient sees", "truth"), "tracker": ("not seen by the controller", "tracker"),
          "controller": ("seen, not put right", "controller")}
_ABOUT = ("Truth minus reference is truth minus estimate (the tracker's share, latency included) plus "
          "estimate minus reference (the controller's share), at every instant. Root mean squares of the two "
          "do not add up to that of the sum: their squares do where the two are not correlated, and where "
          "they cancel each may be greater than the sum.")


def split_section(known: Known) -> Section | None:
    """None where the score does not name truth, estimate and reference."""
    split = known.metrics.get("split_rmse_deg")
    if not isinstance(split, dict):
        return None
    return Section(key="split", title="Error: the tracker's share and the controller's",
                   parts=[Paragraph(text=_ABOUT), *_span(known), *_parts(known, split)])


def _span(known: Known) -> Iterator[Part]:
    """From when on the parts count, what set that, and that the tracking error's span is another."""
    since = {trial: each for trial, each in enumerate(known.per_trial("split_from_s")) if np.isfinite(each)}
    if not since:
        return
    waited = [trial for trial, each in since.items() if each > _scored_from_s(known, trial)]
    least, greatest = (f"{each:.3g}" for each in (min(since.values()), max(since.values())))
    begin = f"{least} s" if least == greatest else f"{least} to {greatest} s, by trial,"
    tracker = "an aligned tracker" if alignments(known.recording, known.score["estimate"]) else "the tracker"
    arrival = f"an estimate of {tracker} had reached the controller"
    scored = "where scoring begins (`score.after_s`)" if known.score.get("after_s") \
        else "where the trial begins"
    if not waited:
        yield Paragraph(text=f"All three count from {begin} on, {scored}: {arrival} by then. The tracking "
                        "error of the result counts from there, too.")
        return
    rest = "" if len(waited) == len(since) else f" in trial {listed([*map(str, waited)])}, else {scored}"
    yield Paragraph(text=f"All three count from {begin} on, when {arrival} and the reference was "
                    f"known{rest}. The tracking error of the result counts what was before, too, and need "
                    "not be the same number.")


def _scored_from_s(known: Known, trial: int) -> float:
    """The first instant of a trial that is scored."""
    after_ns = round((known.score.get("after_s") or 0.0) * NS_PER_S)
    times, _ = known.recording.column(known.score["truth"], trial, after_ns)
    return seconds(int(times[0]))


def _parts(known: Known, split: dict[str, list[float]]) -> Iterator[Part]:
    if known.begun > 1:
        number = np.arange(float(known.begun))
        lines = [Line(name=words, role=role, x=number, y=np.array(split[part]))
                 for part, (words, role) in _WORDS.items()]
        yield Chart(key="split", title="Error by trial, RMS over all scored joints", x_label="trial",
                    y_label="error, deg", lines=lines, limits=from_zero(lines),
                    text="; ".join(f"{words}: {told(split[part][-1])} deg in the last trial"
                                   for part, (words, _) in _WORDS.items()))
    joints: dict[str, Any] = known.metrics.get("joints") or {}
    for trial in known.trials:
        if not np.isfinite(split["total"][trial]):
            continue
        yield Bars(key=f"split-joints-{trial}", title="Error by joint, RMS", x_label="error, deg",
                   names=["all", *map(joint_label, joints)],
                   values={words: [split[part][trial], *(each[f"split_{part}_deg"][trial]
                                                         for each in joints.values())]
                           for part, (words, _) in _WORDS.items()},
                   roles=dict(_WORDS.values()), stacked=False, trial=trial,
                   text=f"Error of each joint in trial {trial}, and its two shares.")

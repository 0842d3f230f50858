"""Sections of a report on the result: main figure, errors by trial, parts of the error, metrics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.quantities import with_unit
from fesloop.experiment.metrics.joints import columns, held
from fesloop.experiment.metrics.missing import MISSING, reasons_of
from fesloop.experiment.metrics.scoring import alignments
from fesloop.experiment.metrics.words import definition_text
from fesloop.hand.movements import muscle
from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.parts import Bars, Chart, Fold, Line, Mark, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known, seconds
from fesloop.show.report.run.thinning import from_zero, thinned
from fesloop.show.report.run.tracker import tip_course
from fesloop.show.report.run.words import joint_label, listed, metric_label, rounded

_MOST_ROWS, _MOST_JOINTS = 60, 8
"""Most rows of a table, and lines of a chart (chosen: what a reader takes in)."""
_MOST_BESIDE = 10
"""Most trials beside each other in a table (chosen: they fit on a page)."""


def trials_section(known: Known) -> Section | None:
    """Section on errors per trial; None if no metric has a value per trial."""
    parts = [*_curves(known), *_tables(known)]
    title = "Error per trial" if known.begun > 1 else "Metrics"
    return Section(key="trials", title=title, parts=parts) if parts else None


def learning_curve(known: Known, key: str) -> Chart | None:
    """Chart of the tracking error by trial; None for fewer than two trials, or without an error."""
    errors = known.per_trial("joint_rmse_deg")
    if len(errors) < 2:
        return None
    number = np.arange(float(len(errors)))
    lines = [Line(name="truth against reference", role="truth", x=number, y=np.array(errors))]
    seen = known.per_trial("tracker_rmse_deg")
    if len(seen) == len(errors):
        lines.append(Line(name="tracker against truth", role="tracker", x=number, y=np.array(seen)))
    return Chart(key=key, title="Error by trial, RMS over all scored joints", x_label="trial",
                 y_label="error, deg", lines=lines, limits=from_zero(lines),
                 text=f"Tracking error by trial, deg: {', '.join(map(rounded, errors))}.")


def _curves(known: Known) -> Iterator[Part]:
    joints: dict[str, Any] = known.metrics.get("joints") or {}
    errors = {name: table["joint_rmse_deg"] for name, table in joints.items() if "joint_rmse_deg" in table}
    if not errors:
        return
    if known.begun < 2:
        yield Bars(key="trials-joints", title="Error by joint, RMS", x_label="error, deg",
                   names=[joint_label(name) for name in errors],
                   values={"truth against reference": [values[0] for values in errors.values()]},
                   roles={"truth against reference": "truth"}, stacked=False,
                   text="Error of each joint against its reference.")
        return
    worst = sorted(errors, key=lambda name: -np.nan_to_num(errors[name]).max())[:_MOST_JOINTS]
    lines = [Line(name=joint_label(name), role=f"series-{number}", x=np.arange(float(len(errors[name]))),
                  y=np.array(errors[name], dtype=np.float64))
             for number, name in enumerate(name for name in errors if name in worst)]
    more = f" ({len(lines)} of {len(errors)}, those with the greatest)" if len(lines) < len(errors) else ""
    yield Chart(key="trials-joints", title=f"Error by trial and joint, RMS{more}", x_label="trial",
                y_label="error, deg", lines=lines, limits=from_zero(lines),
                text="Error of each joint against its reference, by trial.")


def _tables(known: Known) -> Iterator[Part]:
    """Table of the metrics that have a value per trial."""
    columns, about = {}, {}
    for name, metric in known.metrics.items():
        if name not in ("joints", MISSING):
            own = dict(_by_trial(name, metric, known.begun))
            columns.update(own)
            about.update(dict.fromkeys(own, definition_text(name)))
    if not columns:
        return
    shown = list(range(known.begun))
    if len(shown) > _MOST_ROWS:
        shown = [*shown[:_MOST_ROWS // 2], *shown[-_MOST_ROWS // 2:]]
    left_out = known.begun - len(shown)
    title = "By trial" + (f" (without {left_out} trials in the middle)" if left_out else "")
    if known.begun > 1 and len(columns) > len(shown) <= _MOST_BESIDE:  # a trial a column, or it is too wide
        rows = [[label, *(rounded(values[trial]) for trial in shown)] for label, values in columns.items()]
        yield Table(title=title, columns=["trial", *map(str, shown)], rows=rows, about=about)
    elif known.begun > 1:
        rows = [[str(trial), *(rounded(values[trial]) for values in columns.values())] for trial in shown]
        yield Table(title=title, columns=["trial", *columns], rows=rows, about=about)
    else:
        values = [[label, rounded(metric[0])] for label, metric in columns.items()]
        yield Table(columns=["metric", "value"], rows=values, about=about)


def _by_trial(name: str, metric: Any, trials: int) -> Iterator[tuple[str, list[Any]]]:
    """Columns of a metric that has one plain value per trial."""
    if isinstance(metric, dict):
        for part, inner in metric.items():
            for label, values in _by_trial(name, inner, trials):
                stem, comma, unit = label.partition(", ")
                yield f"{stem} {part}{comma}{unit}", values
    elif name == "found_elements":
        yield metric_label(name), [elements or "none" for elements in metric]
    elif isinstance(metric, list) and len(metric) == trials \
            and not any(isinstance(value, (list, dict)) for value in metric):
        yield metric_label(name), metric


Array = NDArray[np.float64]


def result_section(known: Known) -> Section | None:
    """Section with the main figure; None if nothing was scored."""
    parts = [part for part in (_figure(known), *_remarks(known)) if part is not None]
    return Section(key="result", title="Result", parts=parts) if parts else None


def _figure(known: Known) -> Part | None:
    """Figure of the main finding."""
    return (learning_curve(known, "result") or _error_course(known) or _orientations(known)
            or _fingertips(known) or _cycles(known))


def _remarks(known: Known) -> Iterator[Part]:
    """Paragraphs that define the numbers."""
    if "joint_rmse_deg" in known.metrics:
        yield Paragraph(text="Tracking error: true joint angles against the reference, root mean square over "
                        "time and over all scored joints.")
    if "held" in known.metrics:
        grasp = known.score["grasp"]
        yield Paragraph(text=f"Held: from {grasp['from_s']:g} to {grasp['until_s']:g} s the object stayed in "
                        f"the hand, within {grasp['within_mm']:g} mm of where it was in it at the start, and "
                        "did not rest on its table.")
    reasons = [f"{name}: {reason}" for name, reason in reasons_of(known.metrics)]
    if reasons:
        yield Fold(title="Reasons for missing values", parts=[
            Paragraph(text=f"{reason}.") for reason in reasons])


def _error_course(known: Known) -> Part | None:
    """Chart of the error over a single trial, RMS over the joints."""
    truth, reference = known.scored("truth"), known.scored("reference")
    if not (truth and reference and known.begun == 1):
        return None
    (table,) = known.recording.tables([truth], 0)
    wanted = known.recording.column(reference, 0)
    apart = ((piece.times_ns, columns(piece.values[0]) - columns(held(wanted, piece.times_ns)))
             for piece in table.pieces())
    pieces = ((times_ns, np.degrees(np.sqrt(np.mean(np.square(error), axis=1)))) for times_ns, error in apart)
    found = thinned(pieces, table.count)
    if found is None:
        return None
    lines = [found.line("truth against reference", "truth")]
    return Chart(key="result", title="Error over time, RMS over all scored joints", x_label="time, s",
                 y_label="error, deg", lines=lines, limits=from_zero(lines),
                 marks=known.scored_while(), trial=0, timed=True,
                 text="Distance of the true joint angles from the reference over the trial.")


def _orientations(known: Known) -> Part | None:
    """Errors of a tracker on a recording that was played, by segment."""
    errors = known.metrics.get("orientation_rmse_deg")
    if not isinstance(errors, dict) or not errors:
        return None
    parts = [part for part in ("heading", "inclination", "total")
             if all(isinstance(each, dict) and part in each for each in errors.values())]
    values = {part: [each[part] for each in errors.values()] for part in parts}
    roles = {part: f"series-{number}" for number, part in enumerate(parts)}
    return Bars(key="result", title="Error of the tracker's orientations, RMS", x_label="error, deg",
                names=list(errors), values=values, roles=roles, stacked=False,
                text="Error of each orientation against the recording's reference.")


def _fingertips(known: Known) -> Part | None:
    """Chart of the trackers' fingertip errors over the last trial."""
    trackers = (known.score.get("trackers") or ()) if known.begun else ()
    courses = [(tracker, tip_course(known, tracker, known.last)) for tracker in trackers]
    lines = [found.line(tracker, f"series-{number % 8}") for number, (tracker, found) in enumerate(courses)
             if found is not None]
    if not lines:
        return None
    which = " in the last trial" if known.begun > 1 else ""
    return Chart(key="result", title=f"Error of the fingertips over time{which}, RMS over them",
                 x_label="time, s", y_label="error, mm", lines=lines, limits=from_zero(lines),
                 text="Distance of each tracker's fingertips from the true ones.")


def _cycles(known: Known) -> Part | None:
    """The signal whose peaks fade, over the trial that the page opens with."""
    cycles = known.score.get("cycles")
    name = str((cycles or {}).get("signal", ""))
    if not cycles or name not in known.signals or not known.begun:
        return None
    one = muscle(cycles["muscle"]) if cycles.get("muscle") else None
    (table,) = known.recording.tables([name], known.best)

    def counted(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        return np.asarray(flat.sum(axis=1) if one is None else flat[:, one])

    found = thinned(((piece.times_ns, counted(piece.values[0])) for piece in table.pieces()), table.count)
    if found is None:
        return None
    what = f"of {cycles['muscle']}" if one is not None else "in all"
    marks = [Mark(text=f"cycle {number}", at=number * cycles["cycle_s"], until=number * cycles["cycle_s"])
             for number in (0, cycles["count"] - 1)]
    y_label = with_unit(name.partition(".")[2].replace("_", " "), table.signals[0].unit)
    return Chart(key="result", title=f"{name} {what}", x_label="time, s", y_label=y_label,
                 lines=[found.line(name, "truth")], marks=marks, trial=known.best, timed=True,
                 text=f"{name} {what}, whose peaks are compared cycle by cycle.")


_WORDS = {"total": ("true error", "truth"), "tracker": ("tracker's share", "tracker"),
          "controller": ("controller's share", "controller")}
_ABOUT = ("Truth minus reference is truth minus estimate (the tracker's share, latency included) plus "
          "estimate minus reference (the controller's share), at every instant. Root mean squares of the two "
          "do not add up to that of the sum: their squares do where the two are not correlated, and where "
          "they cancel each may be greater than the sum.")


def split_section(known: Known) -> Section | None:
    """Section on the parts of the error; None unless the score names truth, estimate and reference."""
    split = known.metrics.get("split_rmse_deg")
    if not isinstance(split, dict):
        return None
    return Section(key="split", title="Error: the tracker's share and the controller's",
                   parts=[Paragraph(text=_ABOUT), *_span(known), *_parts(known, split)])


def _span(known: Known) -> Iterator[Part]:
    """Sentence on the start of the interval over which the parts are computed, and its reason."""
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
                    text="; ".join(f"{words}: {rounded(split[part][-1])} deg in the last trial"
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

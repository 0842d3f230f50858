"""The result in one figure."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.quantities import with_unit
from fesloop.experiment.metrics.joints import columns, held
from fesloop.experiment.metrics.not_known import reasons_of
from fesloop.hand.muscles import muscle
from fesloop.show.report.parts import Bars, Chart, Fold, Mark, Paragraph, Part, Section
from fesloop.show.report.run.axes import from_zero
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import thinned
from fesloop.show.report.run.tracker import tip_course
from fesloop.show.report.run.trials import learning_curve

Array = NDArray[np.float64]


def result_section(known: Known) -> Section | None:
    """None where nothing was scored."""
    parts = [part for part in (_figure(known), *_remarks(known)) if part is not None]
    return Section(key="result", title="Result", parts=parts) if parts else None


def _figure(known: Known) -> Part | None:
    """Of what the sentence says first."""
    return (learning_curve(known, "result") or _error_course(known) or _orientations(known)
            or _fingertips(known) or _cycles(known))


def _remarks(known: Known) -> Iterator[Part]:
    """What the numbers are."""
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
        yield Fold(title="Why some numbers are missing", parts=[
            Paragraph(text=f"{reason}.") for reason in reasons])


def _error_course(known: Known) -> Part | None:
    """Error over the only trial, RMS over the joints."""
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
    """How far trackers' fingertips are off, over the last trial."""
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
    """The signal whose peaks fade, over the last trial."""
    cycles = known.score.get("cycles")
    name = str((cycles or {}).get("signal", ""))
    if not cycles or name not in known.signals or not known.begun:
        return None
    one = muscle(cycles["muscle"]) if cycles.get("muscle") else None
    (table,) = known.recording.tables([name], known.last)

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
                 lines=[found.line(name, "truth")], marks=marks, trial=known.last, timed=True,
                 text=f"{name} {what}, whose peaks are compared cycle by cycle.")

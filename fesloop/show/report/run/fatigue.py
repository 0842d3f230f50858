"""Section of a report on fatigue: fitness of muscles within a trial and from trial to trial."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import FOREVER
from fesloop.show.report.parts import Chart, Line, Notice, Paragraph, Part, Section
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import course
from fesloop.show.report.run.words import listed, rounded

_MOST_MUSCLES = 8
_TIRED = 0.005
"""Least loss of strength for a muscle to be shown (chosen)."""
_PORT = "fitness"


def fatigue_section(known: Known) -> Section | None:
    """Section on fatigue; None if no muscle of the patient fatigues."""
    name = next((name for name in sorted(known.signals) if name.endswith(f".{_PORT}")), "")
    left_out = known.recording.experiment.get("record", {}).get("leave_out", [])
    if not name:
        missing = next((each for each in left_out if each.endswith(f".{_PORT}")), "")
        return None if not missing else Section(key="fatigue", title="Fatigue", parts=[
            Notice(text=f"Not shown: {missing} was left out of the recording.")])
    return Section(key="fatigue", title="Fatigue", parts=list(_parts(known, name)))


def _parts(known: Known, name: str) -> Iterator[Part]:
    by_trial = {trial: end for trial in range(known.begun)
                if (end := _end(known, name, trial)) is not None and np.isfinite(end).all()}
    if not by_trial:
        yield Notice(text=f"Not shown: nothing of {name} is there.")
        return
    ends = np.array(list(by_trial.values()))
    least = ends.min(axis=0)
    tired = [int(number) for number in np.argsort(least)[:_MOST_MUSCLES] if least[number] < 1.0 - _TIRED]
    if not tired:
        yield Paragraph(text=f"No muscle lost more than {100.0 * _TIRED:g} % of its strength by the end "
                             "of a trial.")
        return
    last = max(by_trial)
    which = "the last trial" if last == known.last else f"trial {last}"
    names = MUSCLES if len(MUSCLES) == len(least) else tuple(f"muscle {i}" for i in range(len(least)))
    yield Paragraph(text=f"Fitness is the remaining share of a rested muscle's strength. At the end of "
                         f"{which} the least is {rounded(float(ends[-1].min()))} "
                         f"({names[int(ends[-1].argmin())]}). The most "
                         f"fatigued muscles are shown: {listed([names[each] for each in tired])}.")
    if len(ends) > 1:
        number = np.array(list(by_trial), dtype=np.float64)
        lines = [Line(name=names[each], role=f"series-{k}", x=number, y=ends[:, each])
                 for k, each in enumerate(tired)]
        yield Chart(key="fatigue-trials", title="Fitness at the end of each trial", lines=lines,
                    x_label="trial", y_label="fitness",
                    text="Fitness of the most fatigued muscles, by trial.")
    for trial in known.trials:
        found = course(known.recording, name, trial)
        if found is not None:
            lines = [found.line(names[each], f"series-{k}", each) for k, each in enumerate(tired)]
            yield Chart(key=f"fatigue-{trial}", title="Fitness", x_label="time, s",
                        y_label="fitness", lines=lines, trial=trial, timed=True,
                        text=f"Fitness of the most fatigued muscles in trial {trial}.")


def _end(known: Known, name: str, trial: int) -> np.ndarray | None:
    """Fitness (muscles,) in the last row of a trial."""
    times, column = known.recording.column(name, trial, 0, FOREVER)
    return np.asarray(column[len(times) - 1:len(times)][0]) if len(times) else None

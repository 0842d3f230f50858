"""Section of a report on a person's intention: EMG, the effort estimated from it, and what it triggered."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.parts import Chart, Line, Mark, Paragraph, Part, Section
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import course, from_zero


def intention_section(known: Known) -> Section | None:
    """Section on intention; None for a run without attempts that are scored."""
    score = known.score.get("intention")
    if not score or score["attempt"] not in known.signals:
        return None
    parts = list(_parts(known, score["attempt"], score["phase"]))
    return Section(key="intention", title="Intention", parts=parts)


def _parts(known: Known, attempt: str, phase: str) -> Iterator[Part]:
    person = attempt.partition(".")[0]
    detections = sorted(name for name in known.signals if name.endswith(".detection"))
    estimate = f"{detections[0].partition('.')[0]}.effort" if detections else ""
    yield Paragraph(text="Effort is a fraction of the greatest that the person can make with the muscle. "
                         "Numbered intervals are attempts; the phase changes where the person triggers it.")
    for trial in known.trials:
        marks = _attempts(known, attempt, trial)
        if f"{person}.emg" in known.signals and (emg := course(known.recording, f"{person}.emg", trial)):
            for row, name in enumerate(known.recording.tables([f"{person}.emg"], trial)[0].signals[0].rows):
                yield Chart(key=f"emg-{row}-{trial}", title=f"EMG of {name}", x_label="time, s",
                            y_label="EMG, mV", lines=[emg.line(name, "series-0", row, 1e3)], marks=marks,
                            trial=trial, timed=True, text=f"Surface EMG of {name} in trial {trial}.")
        lines = list(_efforts(known, person, estimate, trial))
        if lines:
            yield Chart(key=f"effort-{trial}", title="Effort", x_label="time, s", y_label="effort",
                        lines=lines, marks=marks, trial=trial, timed=True, limits=from_zero(lines),
                        text=f"Effort and its estimate in trial {trial}.")
        changes = course(known.recording, phase, trial) if phase in known.signals else None
        if changes is not None:
            yield Chart(key=f"phase-{trial}", title="Phase of the reference", x_label="time, s",
                        y_label="phase", marks=marks, trial=trial, timed=True,
                        lines=[changes.line("phase", "reference", style="steps")],
                        text=f"Number of the reference's phase in trial {trial}.")


def _efforts(known: Known, person: str, estimate: str, trial: int) -> Iterator[Line]:
    """Lines of the true and the estimated effort."""
    if f"{person}.effort" in known.signals and (true := course(known.recording, f"{person}.effort", trial)):
        yield true.line("effort", "truth", 0)
    if estimate in known.signals and (found := course(known.recording, estimate, trial)):
        yield found.line("estimate", "estimate")


def _attempts(known: Known, name: str, trial: int) -> list[Mark]:
    """Intervals of the attempts of a trial."""
    signal = known.recording.signal(name, trial)
    numbers, times_s = signal.values.reshape(-1), signal.times_ns / NS_PER_S
    edges = np.flatnonzero(np.diff(numbers, prepend=0.0, append=0.0))
    marks = []
    for first, after in pairwise(edges.tolist()):
        if numbers[first] > 0.0:
            marks.append(Mark(text=f"{int(numbers[first])}", at=float(times_s[first]),
                              until=float(times_s[min(after, times_s.size - 1)])))
    return marks

"""Section of a report on lateness in real time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fesloop.experiment.metrics.lateness import class_names, realtime_summary
from fesloop.loop.clock import NS_PER_MS
from fesloop.show.report.parts import Bars, Chart, Part, Section, Table
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import thinned
from fesloop.show.report.run.words import rounded

_QUANTILES = {"p50": "median", "p99": "99 % within", "worst": "at most"}


def lateness_section(known: Known) -> Section | None:
    """Section on lateness; None for a run that was not in real time."""
    summary = realtime_summary(known.recording)
    if not summary:
        return None
    return Section(key="lateness", title="Real time",
                   parts=[_table(summary), _histogram(summary), *_courses(known)])


def _table(summary: dict[str, Any]) -> Table:
    rows = [["missed deadlines", f"{summary['missed']} of {summary['deadlines']}, later than "
             f"{summary['period_ms']:g} ms ({summary['policy']})"]]
    for key, words in (("late_ms", "start of work, late by"), ("took_ms", "duration of work")):
        rows.append([words, ", ".join(f"{_QUANTILES[name]} {rounded(value)} ms"
                                      for name, value in summary[key].items())])
    rows += [[f"instants {action}", str(count)] for action, count in summary["done"].items()]
    rows += [["garbage collections", f"{summary['collections']:g}, the longest "
              f"{rounded(summary['worst_collection_ms'])} ms"],
             *([["longest write of the recording", f"{rounded(summary['worst_write_ms'])} ms"]]
               if "worst_write_ms" in summary else []),
             ["memory", summary["memory"]], ["scheduling", summary["scheduling"]]]
    return Table(columns=["", ""], rows=rows)


def _histogram(summary: dict[str, Any]) -> Bars:
    starts, counts = summary["histogram"].values()
    return Bars(key="lateness-histogram", title="How late work began", x_label="instants",
                names=class_names(starts), values={"instants": counts},
                roles={"instants": "plain"}, stacked=False,
                text="Number of instants by how late their work began.")


def _courses(known: Known) -> Iterator[Part]:
    """Charts of lateness over the shown trials."""
    rows = known.recording.instants
    for trial in known.trials:
        mine = rows[rows["trial"] == trial]
        late = thinned([(mine["time_ns"], mine["late_ns"] / NS_PER_MS)], len(mine))
        took = thinned([(mine["time_ns"], mine["took_ns"] / NS_PER_MS)], len(mine))
        if late is not None and took is not None:
            yield Chart(key=f"lateness-{trial}", title="Lateness over time", x_label="time, s",
                        y_label="duration, ms",
                        lines=[late.line("began late", "series-0"), took.line("took", "series-1")],
                        trial=trial, timed=True,
                        text=f"How late work began and how long it took in trial {trial}.")

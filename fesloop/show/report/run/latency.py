"""Section of a report on latency: the budget as time lines, and the age of commands in the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.latency import MEANING, LatencyReport, PathLatency, StageSummary
from fesloop.show.report import svg
from fesloop.show.report.parts import Drawing, Fold, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.stimulation import final_stimulation
from fesloop.show.report.run.words import rounded

_WIDE, _LEFT, _ROW, _BAR = 440.0, 8.0, 34.0, 10.0
_MOST_STAGES = 24
Stages = tuple[StageSummary, ...]


class Way(NamedTuple):
    """Path from the patient through blocks back to the patient.

    Attributes
    ----------
    name: whom it leads through.
    stages: those that take any time, the total last.
    lanes: total of each channel, where there are several.
    """

    name: str
    stages: Stages
    lanes: Stages = ()



def latency_section(known: Known) -> Section:
    """Section with the latency of all paths by stage, from the wiring, and the recorded ages."""
    parts: list[Part] = []
    if known.experiment is None:
        parts.append(Notice(text=f"The latency budget cannot be computed: {known.not_resolved}"))
    else:
        report = LatencyReport(known.experiment.wiring, horizon_ns=known.experiment.duration_ns)
        parts += _budget(known, _ways(report.paths), report.coverage(known.experiment.trials))
    return Section(key="latency", title="Latency budget", parts=[*parts, *_ages(known)])


def _ways(paths: Sequence[PathLatency]) -> list[Way]:
    """Paths on which a sample takes effect; paths of equal latency are merged."""
    found: dict[tuple[tuple[str, ...], str, Stages, Stages], list[str]] = {}
    for path in paths:
        through = tuple(connection.target.name for connection in path.connections)
        stages = tuple(stage for stage in path.summary() if stage.most_ns or stage.name == "total")
        if len(through) > 1 and stages:
            sources = found.setdefault((through, path.later, stages, path.by_lane()), [])
            sources += [] if (name := path.connections[0].source.name) in sources else [name]
    return [Way(" → ".join([", ".join(sources), *through]) + (f"; {later}" if later else ""), stages, lanes)
            for (through, later, stages, lanes), sources in found.items()]


def _budget(known: Known, ways: Sequence[Way], coverage: str) -> Iterator[Part]:
    if not ways:
        yield Paragraph(text="No path leads from the patient through blocks back to the patient.")
        return
    yield Paragraph(text=f"{MEANING} {coverage} Computed from the wiring. A bar is the mean, the thin line "
                         "the range.")
    first = _foremost(known, ways)
    drawings = [[Drawing(key=f"latency-{number}", title=way.name, svg=_time_line(way.stages),
                         text=_in_words(way.stages)), *_lane_table(way)]
                for number, way in enumerate([first, *(way for way in ways if way is not first)])]
    yield from drawings[0]
    if drawings[1:]:
        yield Fold(title=f"{len(drawings) - 1} more paths",
                   parts=[part for way in drawings[1:] for part in way])


def _lane_table(way: Way) -> Iterator[Part]:
    """Table of the total latency of each channel."""
    if way.lanes:
        yield Table(title="Total by channel, ms", columns=["channel", "least", "mean", "greatest"],
                    rows=[[lane.name, _ms(lane.least_ns), _ms(lane.mean_ns), _ms(lane.most_ns)]
                          for lane in way.lanes])


def _foremost(known: Known, ways: Sequence[Way]) -> Way:
    """Slowest path through the scored estimate, or the slowest of all if none passes it."""
    estimate = str(known.score.get("estimate") or "").partition(".")[0]
    through = [way for way in ways if estimate and f" {estimate} " in way[0]]
    return max(through or ways, key=lambda way: (way[1][-1].mean_ns, way[0].count("→")))


def _time_line(stages: Sequence[StageSummary]) -> str:
    """SVG of the stages below each other; each begins where the one before it ends."""
    shown = stages[:-1][:_MOST_STAGES]
    longest = max(stages[-1].most_ns, sum(stage.mean_ns for stage in shown) + _overhang(shown), 1)
    scale = (_WIDE - 2.0 * _LEFT) / longest
    pieces: list[str] = []
    begin = 0.0
    for number, stage in enumerate([*shown, stages[-1]]):
        total = number == len(shown)
        start = 0.0 if total else begin
        pieces += _stage(stage, start * scale + _LEFT, scale, _ROW * number, total)
        begin += stage.mean_ns
    height = _ROW * (len(shown) + 1)
    return svg.drawing(_WIDE, height + 30.0, [*_grid(longest, scale, height), *pieces])


def _overhang(stages: Sequence[StageSummary]) -> float:
    """Excess of the greatest durations over the sum of the means, ns."""
    ends = np.cumsum([0.0, *(stage.mean_ns for stage in stages)])
    beyond = [begin + stage.most_ns - ends[-1] for begin, stage in zip(ends, stages, strict=False)]
    return max(0.0, *beyond) if beyond else 0.0


def _stage(stage: StageSummary, x: float, scale: float, y: float, total: bool) -> Iterator[str]:
    least, mean, most = stage.least_ns, stage.mean_ns, stage.most_ns
    role = "plain" if total else "series-0" if stage.name.startswith("wire") else "series-2"
    spread = "" if least == most else f" ({_ms(least)} to {_ms(most)})"
    words = f"{stage.name.removeprefix('wire ').replace('->', ' → ')}: {_ms(mean)}{spread} ms"
    yield svg.text(_LEFT, y + 14.0, words, size=11.5, bold=total)
    middle = y + 19.0 + 0.5 * _BAR
    yield svg.rect(x, y + 19.0, max(mean * scale, 1.0), _BAR, f"fill-{role}", radius=1.5, tooltip=words)
    if least < most:
        yield svg.line((x + least * scale, middle), (x + most * scale, middle), "stroke-plain", width=1.5)
        for end in (least, most):
            yield svg.line((x + end * scale, middle - 4.0), (x + end * scale, middle + 4.0), "stroke-plain")


def _grid(longest_ns: float, scale: float, height: float) -> Iterator[str]:
    """Vertical lines at round milliseconds, and the axis below."""
    longest = longest_ns / NS_PER_MS
    step = next((size * 10.0**power for power in range(-4, 7) for size in (1, 2, 5)
                 if longest / (size * 10.0**power) <= 6.0), longest)
    for number in range(int(longest / step) + 1):
        x = _LEFT + number * step * NS_PER_MS * scale
        yield svg.line((x, 0.0), (x, height + 4.0), "stroke-plain faint", width=0.4)
        yield svg.text(x, height + 16.0, f"{number * step:g}", kind="faint", size=11.0,
                       anchor="start" if number == 0 else "middle")
    yield svg.text(_WIDE - _LEFT, height + 28.0, "ms after the capture", kind="faint", size=11.0,
                   anchor="end")


def _in_words(stages: Sequence[StageSummary]) -> str:
    return "; ".join(f"{stage.name} {_ms(stage.least_ns)} to {_ms(stage.most_ns)} ms, "
                     f"mean {_ms(stage.mean_ns)}" for stage in stages)


def _ms(time_ns: float) -> str:
    time_ms = time_ns / NS_PER_MS
    return f"{time_ms:.3g}" if time_ms < 1000.0 else f"{time_ms:.0f}"


def _ages(known: Known) -> Iterator[Part]:
    """Table of recorded ages: time from the oldest capture behind a value until it left its block."""
    rows = []
    for name in dict.fromkeys([known.scored("estimate"), final_stimulation(known)]):
        ages = _age_ms(known, name) if name else np.empty(0)
        if ages.size:
            rows.append([name, str(ages.size), *(rounded(float(value)) for value in
                                                 (ages.min(), *np.percentile(ages, (50, 99)), ages.max()))])
    if rows:
        yield Table(title="Recorded age of the oldest capture behind each value as it left its block, ms",
                    rows=rows, columns=["signal", "values", "least", "median", "99 %", "greatest"])


def _age_ms(known: Known, name: str) -> np.ndarray:
    """Ages (n,), ms, over all trials, of values that derive from a capture."""
    found = []
    for trial in range(known.begun):
        for table in known.recording.tables([name], trial):
            found += [(piece.left_ns - piece.oldest_ns)[piece.oldest_ns >= 0] for piece in table.pieces()]
    return np.concatenate(found) / NS_PER_MS if found else np.empty(0)

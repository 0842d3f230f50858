"""A point search in a run: what it asked of which elements, what it found, and how soon."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import FesloopError
from fesloop.experiment.metrics.search import Asked, SearchScore, asked_of, search_metrics
from fesloop.experiment.recording.reading import Recording
from fesloop.forms.schema import make
from fesloop.show.picture.cast import cast_of
from fesloop.show.report.parts import Chart, Drawing, Fold, Line, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.searched_arrays import MOST_STEPS, path_svg, qualities_of, quality_svg
from fesloop.show.report.run.words import counted, told

Array = NDArray[np.float64]
_KIND = "point_search"
_MOST_LISTED = 300
"""Queries that are listed one by one: of more, the best (chosen)."""


def search_sections(recording: Recording) -> list[Section]:
    """What a recording tells of a point search; none where there was none.

    What it lacks is said in its place. Raises InputError for a score that is none, or signals that are lost.
    """
    blocks = recording.experiment.get("blocks", {})
    searches = [name for name, table in blocks.items() if table.get("kind") == _KIND]
    scored = (recording.experiment.get("score") or {}).get("search")
    if scored is None:
        return [_section([Notice(text=f"`{name}` searches, but what it found is not judged: no table "
                                 "`score.search` says which angles of the hand are true.")
                          for name in searches])] if searches else []
    score: SearchScore = make(SearchScore, scored, {}, "score.search")
    return [_section([part for trial in range(recording.trials)
                      for part in _of_trial(recording, score, trial)])]


def _section(parts: Sequence[Part]) -> Section:
    return Section(key="search", title="The search", parts=parts)


def _of_trial(recording: Recording, score: SearchScore, trial: int) -> Iterator[Part]:
    """A sentence, the arrays, the course, the queries."""
    asked = asked_of(recording, score, trial)
    several = recording.trials > 1
    shown = trial if several else None
    if not asked:
        yield Notice(text=f"Trial {trial}: no query was answered in what is recorded.")
        return
    lead = f"Trial {trial}: " if several else ""
    yield Paragraph(text=f"{lead}{_sentence(recording, score, asked, trial)}")
    yield from _arrays(recording, asked, trial, shown)
    yield from _courses(score, asked, trial, shown)
    yield _queries(asked, trial if several else None)


def _sentence(recording: Recording, score: SearchScore, asked: Sequence[Asked], trial: int) -> str:
    metrics = {name: values[trial] for name, values in search_metrics(recording, score).items()
               if trial < len(values)}
    elements, current_ma = asked[-1].best
    minutes = metrics["minutes"]
    ended = f"in {minutes:.1f} min" if np.isfinite(minutes) else \
        "in what is recorded, which ends before the search does"
    told_first = f"{_counted_queries(asked)} for {score.movement.replace('_', ' ')} {ended}."
    if not elements:
        return f"{told_first} It recommends nothing."
    quality = metrics.get("found_quality", np.nan)
    truly = f", truly of quality {quality:.2f}" if np.isfinite(quality) else \
        ", which was not asked itself, so that its true quality is not known"
    text = f"{told_first} It recommends {_electrode(elements)} at {current_ma:g} mA{truly}"
    if score.optimum is not None and np.isfinite(quality):
        share = 100.0 * quality / score.optimum
        text += f": {share:.0f} % of the best there is, {score.optimum:.2f}, by an exhaustive search"
    return f"{text}. Quality 1 is the whole movement and nothing else, 0 is rest."


def _counted_queries(asked: Sequence[Asked]) -> str:
    return "1 query" if len(asked) == 1 else f"{len(asked)} queries"


def _arrays(recording: Recording, asked: Sequence[Asked], trial: int, shown: int | None) -> Iterator[Part]:
    """Both drawings, or why there are none."""
    try:
        player = cast_of(recording).electrodes
    except FesloopError as fault:
        yield Notice(text=f"The arrays are not drawn: {' '.join(str(fault).split())}")
        return
    if player is None or not _fits(player.part, asked):
        yield Notice(text="The arrays are not drawn: no block says where their elements are.")
        return
    qualities = qualities_of(asked)
    found = asked[-1].best[0]
    best = max(qualities, key=qualities.__getitem__)
    yield Drawing(
        key=f"search-quality-{trial}", trial=shown, svg=quality_svg(player.part, qualities, found),
        title="What each element, and each joined pair, was good for at best; ringed: what was found; "
              "empty: not asked",
        text=f"{counted(len(qualities), 'electrode')} asked. The best was {_electrode(best)}, of quality "
             f"{qualities[best]:.2f}; the search found {_electrode(found) if found else 'none'}.")
    if len(qualities) > MOST_STEPS:
        yield Paragraph(text=f"It asked {len(qualities)} electrodes, too many for its path to be drawn.")
        return
    order = [_electrode(electrode) for electrode in qualities]
    yield Drawing(key=f"search-path-{trial}", trial=shown, svg=path_svg(player.part, asked),
                  title="The path of the search: electrodes in the order in which they were first asked",
                  text=f"From {order[0]} to {order[-1]}.")


def _fits(electrodes: Any, asked: Sequence[Asked]) -> bool:
    """Whether every element that was asked is one of the block's."""
    return max(element for one in asked for element in one.elements) < len(electrodes.places)


def _courses(
    score: SearchScore, asked: Sequence[Asked], trial: int, shown: int | None
) -> Iterator[Chart]:
    """Quality by query, and by the patient's time."""
    number = np.arange(1.0, len(asked) + 1.0)
    minutes = np.array([one.told_s / 60.0 for one in asked])
    for name, x, label in (("queries", number, "query"), ("minutes", minutes, "patient's time, min")):
        yield Chart(
            key=f"search-{name}-{trial}", trial=shown, title=f"Quality by {label.partition(',')[0]}",
            x_label=label, y_label="quality", lines=list(_lines(score, asked, x)),
            text=f"Best true quality so far after {counted(len(asked), 'answer')}: "
                 f"{max(one.verdict.quality for one in asked):.2f}.")


def _lines(score: SearchScore, asked: Sequence[Asked], x: Array) -> Iterator[Line]:
    """What each query brought, what was recommended after it, and the best there is."""
    true = np.array([one.verdict.quality for one in asked])
    yield Line(name="of a query, as it truly was", role="truth", style="points", x=x, y=true)
    yield Line(name="of a query, as the search saw it", role="estimate", style="points", x=x,
               y=np.array([one.quality for one in asked]))
    yield Line(name="of what is recommended, as it truly was", role="controller", style="steps", x=x,
               y=_recommended(asked))
    if score.optimum is not None:
        yield Line(name="best there is", role="reference", style="dashed", x=x[[0, -1]],
                   y=np.full(2, score.optimum))


def _recommended(asked: Sequence[Asked]) -> Array:
    """True quality of what was recommended after each query, when it was last asked; NaN where it was not."""
    known: dict[tuple[tuple[int, ...], float], float] = {}
    found = []
    for one in asked:
        known[one.elements, round(one.current_ma, 6)] = one.verdict.quality
        elements, current_ma = one.best
        found.append(known.get((elements, round(current_ma, 6)), np.nan))
    return np.array(found)


def _queries(asked: Sequence[Asked], trial: int | None) -> Fold:
    """Every query, or the best of many."""
    chosen = list(enumerate(asked, start=1))
    title = f"The {_counted_queries(asked)}"
    if len(chosen) > _MOST_LISTED:
        chosen = sorted(chosen, key=lambda item: -item[1].verdict.quality)[:_MOST_LISTED]
        title = f"The best {_MOST_LISTED} of {len(asked)} queries"
    rows = [[str(number), " + ".join(map(str, one.elements)), told(one.current_ma), told(one.quality),
             told(one.verdict.quality), told(one.verdict.wanted), told(one.verdict.unwanted),
             f"{one.told_s / 60.0:.2f}"] for number, one in chosen]
    return Fold(title=title, parts=[Table(columns=[
        "query", "elements", "current, mA", "quality, as seen", "quality, true", "wanted", "unwanted",
        "after, min"], rows=rows, trial=trial)])


def _electrode(elements: tuple[int, ...]) -> str:
    """An electrode in a sentence."""
    what = "element" if len(elements) == 1 else "elements"
    return f"{what} {' and '.join(map(str, elements))}"

"""Section of a report on a point search: quality of elements, path of the search, queries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import FesloopError
from fesloop.experiment.metrics.search import Asked, SearchScore, asked_of, search_metrics
from fesloop.experiment.recording.reading import Recording
from fesloop.forms.schema import make
from fesloop.hand.movements import movement_label
from fesloop.show.picture.arrays import CUT_DEG, unrolled
from fesloop.show.picture.cast import cast_of
from fesloop.show.report import svg
from fesloop.show.report.parts import Chart, Drawing, Fold, Line, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.words import counted, rounded

Array = NDArray[np.float64]
Electrode = tuple[int, ...]
_SCALE = 2.6
"""Pixels a mm, where the page is as wide as the drawing."""
_AROUND_MM = 17.0
_PALEST, _DEEPEST = 0.12, 0.7
"""Opacities of quality 0 and of the best quality (chosen: numbers stay readable)."""
_STOP = 10.0
"""Radius of a stop on the path, pixels."""
_GOOD, _POOR = "series-0", "series-1"
"""Roles of qualities above and below 0."""
MOST_STEPS = 150
"""Most steps of a path that are drawn (chosen: more are illegible)."""


def qualities_of(asked: Sequence[Asked]) -> dict[Electrode, float]:
    """Best true quality of each queried virtual electrode, in the order of first queries."""
    best: dict[Electrode, float] = {}
    for one in asked:
        best[one.elements] = max(one.verdict.quality, best.get(one.elements, -np.inf))
    return best


def quality_svg(electrodes: Any, qualities: Mapping[Electrode, float], found: Electrode | None) -> str:
    """SVG of elements and joined elements coloured by quality; a ring marks the recommended ones.

    `electrodes`: the block; its `places` (elements, 3): around, along, radius, mm; its `radius_mm`.
    """
    skin = _Skin(electrodes)
    scale = max((abs(quality) for quality in qualities.values()), default=0.0)
    pieces = [*skin.boxes(), *_rings(skin, found or ()), *skin.pads()]
    # Joined elements lie below single ones, and good ones above poor ones.
    for electrode, quality in sorted(qualities.items(), key=lambda item: (-len(item[0]), item[1])):
        pieces += _electrode_mark(skin, electrode, quality, scale)
    pieces += [*skin.numbers(), *_key(skin, min(qualities.values(), default=0.0), scale)]
    return svg.drawing(skin.wide, skin.high + 52.0, pieces)


def path_svg(electrodes: Any, asked: Sequence[Asked]) -> str:
    """SVG of the path from electrode to electrode, numbered in the order of first queries."""
    skin = _Skin(electrodes)
    way = [one.elements for one in asked]
    stops = [way[0], *(other for one, other in pairwise(way) if other != one)] if way else []
    points = [skin.middle(electrode) for electrode in stops]
    pieces = [*skin.boxes(), *skin.pads()]
    if len(points) <= MOST_STEPS:
        pieces += [svg.line(start, end, "stroke-plain", width=0.4 + 0.8 * number / len(points))
                   for number, (start, end) in enumerate(pairwise(points))]
    for number, electrode in reversed(list(enumerate(dict.fromkeys(stops)))):
        x, y = skin.middle(electrode)
        late = number / max(1, len(set(stops)) - 1)
        pieces.append(svg.circle(x, y, _STOP, "paper stroke-plain", width=1.0))
        pieces.append(svg.circle(x, y, _STOP, f"fill-{_GOOD}", opacity=0.06 + 0.6 * late,
                                 tooltip=f"{number + 1}: {_electrode(electrode)}"))
        pieces.append(svg.text(x, y + 3.7, str(number + 1), size=10.5, anchor="middle", bold=number == 0))
    return svg.drawing(skin.wide, skin.high + 20.0, pieces)


class _Skin:
    """Unrolled skin of the forearm, in pixels."""

    def __init__(self, electrodes: Any) -> None:
        places = unrolled(electrodes.places, electrodes.radius_mm)
        first = np.deg2rad(CUT_DEG) * electrodes.radius_mm
        corner = np.array([first, places[:, 1].min() - _AROUND_MM])
        self.wide = _SCALE * 2.0 * np.pi * electrodes.radius_mm
        self.high = _SCALE * float(np.ptp(places[:, 1]) + 2.0 * _AROUND_MM)
        self.places: Array = np.column_stack((_SCALE * (places[:, :2] - corner), _SCALE * places[:, 2]))

    def middle(self, electrode: Electrode) -> tuple[float, float]:
        """Centre of an electrode's elements."""
        x, y = self.places[list(electrode), :2].mean(axis=0).tolist()
        return x, y

    def boxes(self) -> Iterator[str]:
        """Dorsal and volar halves with their labels."""
        for x, name in ((0.0, "back"), (0.5 * self.wide, "front")):
            yield svg.rect(x + 0.5, 0.5, 0.5 * self.wide - 1.0, self.high - 1.0, "paper stroke-plain",
                           radius=4.0)
            yield svg.text(x + 8.0, 16.0, f"{name} of the forearm", kind="faint", size=12.0)
        yield svg.text(self.wide - 8.0, 16.0, "elbow ↑", kind="faint", size=12.0, anchor="end")
        yield svg.text(self.wide - 8.0, self.high - 6.0, "wrist ↓", kind="faint", size=12.0, anchor="end")
        for share, name, anchor in ((0.0, "ulnar", "start"), (0.5, "radial", "middle"),
                                    (1.0, "ulnar", "end")):
            yield svg.text(share * self.wide, self.high + 15.0, name, kind="faint", size=12.0, anchor=anchor)

    def pads(self) -> Iterator[str]:
        """Empty circles of all elements."""
        for x, y, radius in self.places.tolist():
            yield svg.circle(x, y, radius, "paper stroke-plain", width=0.8)

    def numbers(self) -> Iterator[str]:
        """Numbers of the elements."""
        for element, (x, y, radius) in enumerate(self.places.tolist()):
            yield svg.text(x, y + 0.4 * radius, str(element), size=9.5, anchor="middle")


def _rings(skin: _Skin, found: Electrode) -> Iterator[str]:
    """Rings around the recommended elements; circles of elements cover their insides."""
    for element in found:
        x, y, radius = skin.places[element].tolist()
        yield svg.circle(x, y, radius + 4.0, "fill-theory", tooltip=f"found: {_electrode(found)}")


def _key(skin: _Skin, lowest: float, scale: float) -> Iterator[str]:
    """Key of the colours."""
    yield svg.text(0.0, skin.high + 42.0, "quality", kind="faint", size=12.0)
    for number, share in enumerate((-1.0, -0.5, 0.0, 0.5, 1.0) if lowest < 0.0 else (0.0, 0.5, 1.0)):
        x, y = 64.0 + 82.0 * number, skin.high + 38.0
        role = _GOOD if share >= 0.0 else _POOR
        yield svg.circle(x, y, 9.0, "paper stroke-plain", width=0.8)
        yield svg.circle(x, y, 9.0, f"fill-{role}", opacity=_opacity(share))
        yield svg.text(x + 14.0, y + 4.0, f"{share * scale:.2f}", size=12.0)


def _opacity(share: float) -> float:
    """Opacity of a quality, given as a share of the best."""
    return _PALEST + (_DEEPEST - _PALEST) * abs(share)


def _electrode_mark(skin: _Skin, electrode: Electrode, quality: float, scale: float) -> Iterator[str]:
    """Disc on an element; for joined elements a disc in their middle with lines to them."""
    share = quality / scale if scale else 0.0
    role = f"fill-{_GOOD if quality >= 0.0 else _POOR}"
    told = f"{_electrode(electrode)}: quality {quality:.2f}"
    opacity = _opacity(share)
    if len(electrode) == 1:
        x, y, radius = skin.places[electrode[0]].tolist()
        yield svg.circle(x, y, radius, role, opacity=opacity, tooltip=told)
        return
    x, y = skin.middle(electrode)
    for element in electrode:
        yield svg.line((x, y), skin.middle((element,)), "stroke-plain", width=1.0)
    size = 0.55 * float(skin.places[list(electrode), 2].mean())
    yield svg.circle(x, y, size, "paper stroke-plain", width=0.6)
    yield svg.circle(x, y, size, role, opacity=opacity, tooltip=told)


_KIND = "point_search"
_MOST_LISTED = 300
"""Most queries in the table; of more, the best are listed (chosen)."""


def search_sections(recording: Recording) -> list[Section]:
    """Sections on a point search; none for a run without one.

    Raises InputError for a score that is none, or signals that are lost.
    """
    blocks = recording.experiment.get("blocks", {})
    searches = [name for name, table in blocks.items() if table.get("kind") == _KIND]
    scored = (recording.experiment.get("score") or {}).get("search")
    if scored is None:
        return [_section([Notice(text=f"`{name}` searches, but its result is not scored: a table "
                                 "`score.search` with the true angles of the hand is missing.")
                          for name in searches])] if searches else []
    score: SearchScore = make(SearchScore, scored, {}, "score.search")
    return [_section([part for trial in range(recording.trials)
                      for part in _of_trial(recording, score, trial)])]


def _section(parts: Sequence[Part]) -> Section:
    return Section(key="search", title="The search", parts=parts)


def _of_trial(recording: Recording, score: SearchScore, trial: int) -> Iterator[Part]:
    """Sentence, arrays, charts and queries of one trial."""
    asked = asked_of(recording, score, trial)
    several = recording.trials > 1
    shown = trial if several else None
    if not asked:
        yield Notice(text=f"Trial {trial}: no query was answered in the recording.")
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
        "until the recording ends, before the search does"
    told_first = f"{_counted_queries(asked)} for {movement_label(score.movement)} {ended}."
    if not elements:
        return f"{told_first} It recommends nothing."
    quality = metrics.get("found_true_quality", np.nan)
    measured = metrics.get("found_measured_quality", np.nan)
    truly = f", of quality {measured:.2f} by the tracker and truly {quality:.2f}" \
        if np.isfinite(quality) else ", whose true quality is unknown because it was not queried itself"
    text = f"{told_first} It recommends {_electrode(elements)} at {current_ma:g} mA{truly}"
    if score.optimum is not None and np.isfinite(quality):
        share = 100.0 * quality / score.optimum
        text += f": {share:.0f} % of the best there is, {score.optimum:.2f}, by an exhaustive search"
    return f"{text}. Quality 1 is the complete movement without any other, 0 is rest."


def _counted_queries(asked: Sequence[Asked]) -> str:
    return "1 query" if len(asked) == 1 else f"{len(asked)} queries"


def _arrays(recording: Recording, asked: Sequence[Asked], trial: int, shown: int | None) -> Iterator[Part]:
    """Drawings of quality and path, or a notice on why there are none."""
    try:
        player = cast_of(recording).electrodes
    except FesloopError as fault:
        yield Notice(text=f"The arrays are not drawn: {' '.join(str(fault).split())}")
        return
    if player is None or not _fits(player.part, asked):
        yield Notice(text="The arrays are not drawn: no block has positions of their elements.")
        return
    qualities = qualities_of(asked)
    found = asked[-1].best[0]
    best = max(qualities, key=qualities.__getitem__)
    yield Drawing(
        key=f"search-quality-{trial}", trial=shown, svg=quality_svg(player.part, qualities, found),
        title="Best quality of each element and each joined pair; ring: recommended; "
              "empty: not queried",
        text=f"{counted(len(qualities), 'electrode')} queried. The best was {_electrode(best)}, of quality "
             f"{qualities[best]:.2f}; the search found {_electrode(found) if found else 'none'}.")
    if len(qualities) > MOST_STEPS:
        yield Paragraph(text=f"It queried {len(qualities)} electrodes, too many for a drawing of its path.")
        return
    order = [_electrode(electrode) for electrode in qualities]
    yield Drawing(key=f"search-path-{trial}", trial=shown, svg=path_svg(player.part, asked),
                  title="Path of the search: electrodes in the order of their first queries",
                  text=f"From {order[0]} to {order[-1]}.")


def _fits(electrodes: Any, asked: Sequence[Asked]) -> bool:
    """Return whether all queried elements exist."""
    return max(element for one in asked for element in one.elements) < len(electrodes.places)


def _courses(
    score: SearchScore, asked: Sequence[Asked], trial: int, shown: int | None
) -> Iterator[Chart]:
    """Charts of quality by query and by time of the patient."""
    number = np.arange(1.0, len(asked) + 1.0)
    minutes = np.array([one.told_s / 60.0 for one in asked])
    for name, x, label in (("queries", number, "query"), ("minutes", minutes, "patient's time, min")):
        yield Chart(
            key=f"search-{name}-{trial}", trial=shown, title=f"Quality by {label.partition(',')[0]}",
            x_label=label, y_label="quality", lines=list(_lines(score, asked, x)),
            text=f"Best true quality so far after {counted(len(asked), 'answer')}: "
                 f"{max(one.verdict.quality for one in asked):.2f}.")


def _lines(score: SearchScore, asked: Sequence[Asked], x: Array) -> Iterator[Line]:
    """Lines of the quality of each query, of the recommendation after it, and of the best there is."""
    true = np.array([one.verdict.quality for one in asked])
    yield Line(name="query, true", role="truth", style="points", x=x, y=true)
    yield Line(name="query, as measured", role="estimate", style="points", x=x,
               y=np.array([one.quality for one in asked]))
    yield Line(name="recommendation, true", role="controller", style="steps", x=x,
               y=_recommended(asked))
    if score.optimum is not None:
        yield Line(name="best there is", role="reference", style="dashed", x=x[[0, -1]],
                   y=np.full(2, score.optimum))


def _recommended(asked: Sequence[Asked]) -> Array:
    """True quality of the recommendation after each query; NaN if it was never queried itself."""
    known: dict[tuple[tuple[int, ...], float], float] = {}
    found = []
    for one in asked:
        known[one.elements, round(one.current_ma, 6)] = one.verdict.quality
        elements, current_ma = one.best
        found.append(known.get((elements, round(current_ma, 6)), np.nan))
    return np.array(found)


def _queries(asked: Sequence[Asked], trial: int | None) -> Fold:
    """Table of all queries, or of the best of many."""
    chosen = list(enumerate(asked, start=1))
    title = f"The {_counted_queries(asked)}"
    if len(chosen) > _MOST_LISTED:
        chosen = sorted(chosen, key=lambda item: -item[1].verdict.quality)[:_MOST_LISTED]
        title = f"The best {_MOST_LISTED} of {len(asked)} queries"
    rows = [[str(number), " + ".join(map(str, one.elements)), rounded(one.current_ma), rounded(one.quality),
             rounded(one.verdict.quality), rounded(one.verdict.wanted), rounded(one.verdict.unwanted),
             f"{one.told_s / 60.0:.2f}"] for number, one in chosen]
    return Fold(title=title, parts=[Table(columns=[
        "query", "elements", "current, mA", "quality, measured", "quality, true", "intended", "unintended",
        "after, min"], rows=rows, trial=trial)])


def _electrode(elements: tuple[int, ...]) -> str:
    """Name of an electrode in a sentence."""
    what = "element" if len(elements) == 1 else "elements"
    return f"{what} {' and '.join(map(str, elements))}"

"""Which parts of a page stand beside each other, and which are shown with a trial only."""

from __future__ import annotations

from collections.abc import Sequence

from fesloop.show.report.parts import Chart, HeatMap, Line, Part, Strips


def trial_of(part: Part) -> int | None:
    """The trial that a part is shown with; None where it is of all."""
    return getattr(part, "trial", None)


def alike(one: Part, other: Part) -> bool:
    """Whether two parts are charts, or maps, of the same kind of thing, to be seen beside each other."""
    if isinstance(one, HeatMap) and isinstance(other, HeatMap):
        return ((one.x_label, one.y_label, one.value_label, one.low, one.high)
                == (other.x_label, other.y_label, other.value_label, other.low, other.high))
    return (isinstance(one, Chart) and isinstance(other, Chart)
            and (one.trial, one.timed, one.y_label, _names(one.lines))
            == (other.trial, other.timed, other.y_label, _names(other.lines)))


def _names(lines: Sequence[Line]) -> list[str]:
    return [line.name for line in lines]


def rows(parts: Sequence[Part]) -> list[list[Part]]:
    """Parts in their order, those that are alike together."""
    found: list[list[Part]] = []
    for part in parts:
        if found and alike(found[-1][-1], part):
            found[-1].append(part)
        else:
            found.append([part])
    return found


def thinned_in_words(part: Part) -> str:
    """How samples became points, for the reader of a chart; empty where each sample is a point."""
    lines = part.lines if isinstance(part, (Chart, Strips)) else ()
    thinned = [line for line in lines if line.thinned > 1]
    if not thinned:
        return ""
    first = "a line is the first of them" if all(line.style == "steps" for line in thinned) \
        else "a line is their mean"
    band = ", the band their extremes" if any(line.low is not None for line in thinned) else ""
    return f"A point stands for up to {max(line.thinned for line in thinned)} samples: {first}{band}."

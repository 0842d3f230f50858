"""How pictures of a study are called: a metric by what it was found for, which reads as no ratio."""

from __future__ import annotations

from collections.abc import Sequence

from fesloop.analysis.study.results.quantities import called
from fesloop.show.figures.content import Content
from fesloop.show.report.run.words import listed


def by_axes(content: Content, axes: Sequence[str]) -> str:
    """A metric by its axes, without units: "Motion at rest, RMS, by latency and law"."""
    figure = content.figure
    metric, _ = called(figure.metric, figure.label)
    return by(metric, [content.axis_name(axis) for axis in axes])


def by(quantity: str, axes: Sequence[str]) -> str:
    """A quantity by its axes; set off by a comma where it has one itself."""
    text = f"{quantity}{',' if ',' in quantity else ''} by {listed(axes)}"
    return text[:1].upper() + text[1:]

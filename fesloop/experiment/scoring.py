"""Metrics of a run, from its recording alone."""

from __future__ import annotations

from typing import Any

from fesloop.experiment.reading import Recording


def metrics_of(recording: Recording) -> dict[str, Any]:
    """What the experiment's [score] asks for, by the names of the metrics' vocabulary."""
    return {}

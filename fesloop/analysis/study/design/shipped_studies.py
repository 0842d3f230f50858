"""Shipped studies: their names, and what `fesloop list` says of each."""

from __future__ import annotations

from fesloop.experiment.files.overlay import merged
from fesloop.experiment.files.source import Shelf, read_tables

STUDIES = Shelf("study", "fesloop.analysis.study", merged)


def shipped_studies() -> list[str]:
    """Names of the studies that come with fesloop."""
    return STUDIES.names()


def described_studies() -> dict[str, dict[str, str]]:
    """Shipped studies: the description of each under "", and the cost of each other form under its name."""
    found = {}
    for name in shipped_studies():
        document = read_tables(name, STUDIES)[1]
        forms = {form: str(patch.get("cost", "")) for form, patch in document.get("forms", {}).items()}
        found[name] = {"": str(document["study"].get("description", "")), **forms}
    return found


def kept_metrics() -> dict[str, dict[str, str]]:
    """Numbers that shipped studies keep, by name: study to path in a run's metrics."""
    found: dict[str, dict[str, str]] = {}
    for study in shipped_studies():
        for name, path in read_tables(study, STUDIES)[1]["study"].get("metrics", {}).items():
            found.setdefault(name, {})[study] = path
    return found

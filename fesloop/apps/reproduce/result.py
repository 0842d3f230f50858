"""Result of a reproduction: rows of the comparison, sweeps, and curves for figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from fesloop.apps.reproduce.comparison import Row, share_that_holds


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A table without published counterpart, such as a sweep of an unpublished parameter or of error sources.

    Attributes
    ----------
    title, unit: of it.
    columns: names of the columns. rows: name of each row, and its values.
    """

    title: str
    unit: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[float, ...]], ...]

    def as_table(self) -> dict[str, Any]:
        """Table for `fesloop reproduce --json`."""
        return {"title": self.title, "unit": self.unit,
                "rows": [{"row": name, **dict(zip(self.columns, values, strict=True))}
                         for name, values in self.rows]}


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A paper's experiments on virtual subjects.

    Attributes
    ----------
    paper: name. subjects: number of virtual subjects.
    rows: of the comparison.
    sweeps: by name.
    curves: arrays for figures.
    """

    paper: str
    subjects: int
    rows: Sequence[Row]
    sweeps: dict[str, Sweep] = field(default_factory=dict)
    curves: dict[str, Any] = field(default_factory=dict)

    @property
    def cohort(self) -> str:
        """Number of subjects as text."""
        return f"{self.subjects} virtual subject" + "s" * (self.subjects != 1)

    def as_table(self) -> dict[str, Any]:
        """Table for `fesloop reproduce --json`."""
        return {"paper": self.paper, "subjects": self.subjects, "rows": [row.as_table() for row in self.rows],
                "holding": share_that_holds(self.rows),
                "sweeps": {name: sweep.as_table() for name, sweep in self.sweeps.items()}}

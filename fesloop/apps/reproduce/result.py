"""What a reproduction ends in: rows, sweeps beside them, and what figures are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from fesloop.apps.reproduce.comparison import Row, share_that_holds


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A table of ours alone: what no source states is swept, and error sources are taken one by one.

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
        """As `fesloop reproduce --json` prints it."""
        return {"title": self.title, "unit": self.unit,
                "rows": [{"row": name, **dict(zip(self.columns, values, strict=True))}
                         for name, values in self.rows]}


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A paper's experiments on virtual subjects.

    Attributes
    ----------
    paper: its name here. subjects: how many.
    rows: theirs beside ours.
    sweeps: of ours alone, by name.
    curves: arrays for figures.
    """

    paper: str
    subjects: int
    rows: Sequence[Row]
    sweeps: dict[str, Sweep] = field(default_factory=dict)
    curves: dict[str, Any] = field(default_factory=dict)

    @property
    def cohort(self) -> str:
        """How many subjects, in words."""
        return f"{self.subjects} virtual subject" + "s" * (self.subjects != 1)

    def as_table(self) -> dict[str, Any]:
        """As `fesloop reproduce --json` prints it."""
        return {"paper": self.paper, "subjects": self.subjects, "rows": [row.as_table() for row in self.rows],
                "holding": share_that_holds(self.rows),
                "sweeps": {name: sweep.as_table() for name, sweep in self.sweeps.items()}}

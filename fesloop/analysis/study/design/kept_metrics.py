"""Which numbers of a run's metrics a study keeps.

    joint_rmse_deg                a number, or of a list, which has one a trial, the last
    joint_rmse_deg:mean           of a list: first, last, mean, median, min, max
    joints.MCP.joint_rmse_deg     a metric below others
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.errors import InputError, did_you_mean

_REDUCTIONS: dict[str, Callable[[Sequence[float]], float]] = {
    "first": lambda values: values[0], "last": lambda values: values[-1], "mean": statistics.fmean,
    "median": statistics.median, "min": min, "max": max}


@dataclass(frozen=True, slots=True)
class KeptMetric:
    """A number that is kept.

    Attributes
    ----------
    name: under which it is kept.
    path: where it stands in a run's metrics.
    reduction: what is taken of a list.
    """

    name: str
    path: tuple[str, ...]
    reduction: str = "last"

    @classmethod
    def parse(cls, name: str, text: str) -> KeptMetric:
        """From a study file's text. Raises InputError for a reduction that is not there."""
        path, _, reduction = text.partition(":")
        if reduction and reduction not in _REDUCTIONS:
            raise InputError(f"metrics.{name}", f"{text!r} asks for {reduction!r} of a list",
                             ", ".join(_REDUCTIONS), did_you_mean(reduction, _REDUCTIONS))
        if not all(path.split(".")):
            raise InputError(f"metrics.{name}", f"{text!r}", "a path such as joints.MCP.joint_rmse_deg")
        return cls(name, tuple(path.split(".")), reduction or "last")

    def of(self, metrics: Mapping[str, Any]) -> float | None:
        """The number; None where the run has it not, or not a finite one.

        Raises InputError where the path leads to no number in what the run has.
        """
        value: Any = metrics
        for depth, part in enumerate(self.path):
            if not isinstance(value, Mapping) or part not in value:
                known = list(value) if isinstance(value, Mapping) else []
                raise InputError(f"study.metrics.{self.name}",
                                 f"a run has no metric {'.'.join(self.path[:depth + 1])!r}",
                                 ", ".join(map(str, known)), did_you_mean(part, map(str, known)))
            value = value[part]
        if isinstance(value, (list, tuple)):
            numbers = [self._number(item) for item in value]
            finite = [number for number in numbers if number is not None]
            if len(finite) < len(numbers) or not finite:
                return self._end(numbers)
            return float(_REDUCTIONS[self.reduction](finite))
        return self._number(value)

    def _end(self, numbers: Sequence[float | None]) -> float | None:
        """Of a list that is not all numbers: its first or last, if that is asked for."""
        ends = {"first": 0, "last": -1}
        return numbers[ends[self.reduction]] if numbers and self.reduction in ends else None

    def _number(self, value: Any) -> float | None:
        if value is None:
            return None
        if not isinstance(value, (bool, int, float)):
            raise InputError(f"study.metrics.{self.name}", f"{'.'.join(self.path)!r} is no number",
                             "a number, or a list of numbers, one a trial",
                             "go on to one below it" if isinstance(value, Mapping) else "")
        return float(value) if math.isfinite(value) else None

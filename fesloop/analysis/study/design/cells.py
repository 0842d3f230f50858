"""Cells of a study: combinations of levels at which the base experiment is run."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fesloop.analysis.study.design.axes import Level, LevelValue
from fesloop.analysis.study.design.study import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A combination of levels.

    Attributes
    ----------
    number: counted from 0.
    levels: by axis.
    experiment: name or path of the experiment to run.
    common: settings of every cell, as for `fesloop run --set`.
    by_axis: settings of each axis in this cell.
    """

    number: int
    levels: dict[str, LevelValue]
    experiment: str
    common: tuple[str, ...]
    by_axis: dict[str, tuple[str, ...]]

    @property
    def settings(self) -> tuple[str, ...]:
        """All settings but those of prepared models."""
        return (*self.common, *(setting for settings in self.by_axis.values() for setting in settings))

    @property
    def place(self) -> str:
        """The levels in words, for messages."""
        return ", ".join(f"{axis} {level}" for axis, level in self.levels.items()) or "no axis"


def cells_of(study: Study) -> Iterator[Cell]:
    """All cells; the last axis changes fastest."""
    places = _grid(study) if study.about.design == "grid" else _points(study)
    for number, levels in enumerate(places):
        yield _cell(study, number, dict(zip(study.axes, levels, strict=True)))


def covering(study: Study) -> Iterator[Cell]:
    """Cells in which every level of every axis occurs, by taking each that has one which none before had.

    Whatever file or setting has changed since a plan was stored, a level names it: comparing these is enough.
    """
    seen: set[tuple[str, LevelValue]] = set()
    for cell in cells_of(study):
        levels = set(cell.levels.items())
        if not cell.number or not levels <= seen:
            seen |= levels
            yield cell


def base_cells(study: Study) -> list[Cell]:
    """A cell without axes for each base experiment of the study."""
    replaced = any(all(option.experiment for option in axis.options.values())
                   for axis in study.axes.values() if axis.options)
    names = {} if replaced else {study.about.experiment: None}
    for axis in study.axes.values():
        names |= dict.fromkeys(option.experiment for option in axis.options.values() if option.experiment)
    return [Cell(number=number, levels={}, experiment=study.experiment(name), common=study.about.settings,
                 by_axis={}) for number, name in enumerate(names)]


def _grid(study: Study) -> Iterator[tuple[Level, ...]]:
    return itertools.product(*(
        [axis.level(name, number) for number in range(axis.count_of_levels(name))]
        for name, axis in study.axes.items()))


def _points(study: Study) -> Iterator[tuple[Level, ...]]:
    """Points of a random or Sobol design, from the study's seed; more samples extend the same sequence."""
    axes, count = study.axes.items(), study.about.samples
    if study.about.design == "random":
        shares = np.random.default_rng(study.about.seed).random((count, len(study.axes)))
    else:
        from scipy.stats.qmc import Sobol

        sequence = Sobol(max(1, len(study.axes)), rng=np.random.default_rng(study.about.seed))
        shares = sequence.random_base2((count - 1).bit_length())[:count]
    for row in shares:
        yield tuple(axis.sampled(name, float(share)) for (name, axis), share in zip(axes, row, strict=False))


def _cell(study: Study, number: int, levels: dict[str, Level]) -> Cell:
    experiments = [level.experiment for level in levels.values() if level.experiment]
    return Cell(number=number, levels={name: level.value for name, level in levels.items()},
                experiment=study.experiment(experiments[-1] if experiments else study.about.experiment),
                common=study.about.settings,
                by_axis={name: level.settings for name, level in levels.items()})

"""Cells of a study: the places on its axes at which the base experiment is run."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fesloop.analysis.study.design.axes import Level, LevelValue
from fesloop.analysis.study.design.study import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One place.

    Attributes
    ----------
    number: counted from 0.
    levels: by axis.
    experiment: name or path of the experiment that is run there.
    common: settings of every cell, as of `fesloop run --set`.
    by_axis: what each axis sets here.
    """

    number: int
    levels: dict[str, LevelValue]
    experiment: str
    common: tuple[str, ...]
    by_axis: dict[str, tuple[str, ...]]

    @property
    def settings(self) -> tuple[str, ...]:
        """All of them, without what is prepared."""
        return (*self.common, *(setting for settings in self.by_axis.values() for setting in settings))

    @property
    def place(self) -> str:
        """By which a user is told of it."""
        return ", ".join(f"{axis} {level}" for axis, level in self.levels.items()) or "no axis"


def cells_of(study: Study) -> Iterator[Cell]:
    """Every cell, in the order in which the last axis changes fastest."""
    places = _grid(study) if study.about.design == "grid" else _points(study)
    for number, levels in enumerate(places):
        yield _cell(study, number, dict(zip(study.axes, levels, strict=True)))


def base_cells(study: Study) -> list[Cell]:
    """The experiments that the study varies, as they stand without its axes: a cell for each of them."""
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
    """Drawn by the study's seed; a longer sequence begins with the shorter one."""
    axes, count = study.axes.items(), study.about.samples
    if study.about.design == "random":
        shares = np.random.default_rng(study.about.seed).random((count, len(study.axes)))
    else:
        from scipy.stats.qmc import Sobol

        sequence = Sobol(max(1, len(study.axes)), rng=np.random.default_rng(study.about.seed))
        shares = sequence.random_base2((count - 1).bit_length())[:count]
    for row in shares:
        yield tuple(axis.drawn(name, float(share)) for (name, axis), share in zip(axes, row, strict=False))


def _cell(study: Study, number: int, levels: dict[str, Level]) -> Cell:
    experiments = [level.experiment for level in levels.values() if level.experiment]
    return Cell(number=number, levels={name: level.value for name, level in levels.items()},
                experiment=study.experiment(experiments[-1] if experiments else study.about.experiment),
                common=study.about.settings,
                by_axis={name: level.settings for name, level in levels.items()})

"""Scores of published figures and patterns under the predictive distribution of a simulated paper.

A replicate is a whole simulated paper: its room, its subjects and their trials, reduced as the paper does.
So the sampling error of a published mean of n subjects is part of each replicate, and none is added here.
Published values are taken as printed, with one decimal.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm

from fesloop.apps.reproduce.comparison import FigureScores, PatternScores, Row, band
from fesloop.apps.reproduce.published import Published
from fesloop.errors import InputError

Array = NDArray[np.float64]
Replicates = Mapping[str, Array]
"""Values of each figure by `Published.key`, (replicates,): one index is one simulated paper."""
MOST = 0.5
"""Least share of replicates in which a pattern occurs that holds."""
_REPLICATES = 4000


def pit(theirs: float, replicates: Array) -> float:
    """Probability integral transform: mean rank of a value among replicates, 0 to 1 (Dawid 1984).

    It is uniform if the value and the replicates have the same distribution; ties count by half.
    """
    below = np.sum(replicates < theirs) + 0.5 * np.sum(replicates == theirs)
    return float((below + 0.5) / (replicates.size + 1))


def log_score(theirs: float, replicates: Array) -> float:
    """Log density at a value's logarithm of the normal distribution with the replicates' moments.

    The normal distribution is that of the replicates' logarithms, so the score has no unit and is finite
    everywhere; more is better. It is proper: its mean is largest for the true moments (Dawid and Sebastiani's
    score; Gneiting and Raftery 2007, doi 10.1198/016214506000001437). NaN if all replicates are equal.
    """
    logs = np.log(replicates)
    sd = float(logs.std(ddof=1)) if logs.size > 1 else 0.0
    return float(norm.logpdf(math.log(theirs), logs.mean(), sd)) if sd > 1e-12 else math.nan


def papers_of_subjects(
    values: Replicates, figures: Mapping[str, Published], seed: int = 0
) -> dict[str, Array]:
    """Make replicates of a paper from independent subjects, drawn with replacement.

    `values` are each subject's, (subjects,). A figure that is a mean of n is that of a replicate's first n
    subjects; so the one subject of a table is among those of the others.
    """
    count = len(next(iter(values.values())))
    most = max(figure.subjects for figure in figures.values())
    drawn = np.random.default_rng(seed).integers(count, size=(_REPLICATES, most))
    return {key: np.asarray(values[key], dtype=np.float64)[drawn[:, :figure.subjects]].mean(axis=1)
            for key, figure in figures.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Baseline:
    """Subjects of an earlier model, for comparison.

    Attributes
    ----------
    commit: of the project that simulated them.
    values: of each figure by key, (subjects,).
    """

    commit: str
    values: dict[str, Array]


def baseline(paper: str) -> Baseline:
    """Baseline of a paper, read from published/PAPER_baseline.json."""
    kept = json.loads(files(__package__).joinpath("published", f"{paper}_baseline.json").read_text())
    return Baseline(commit=kept["commit"],
                    values={key: np.array(values) for key, values in kept["values"].items()})


def figure_rows(
    figures: Mapping[str, Published], replicates: Replicates, of_baseline: Replicates
) -> list[Row]:
    """Rows of published figures, with scores; a row holds if the figure lies in the 5-95 % band.

    Raises InputError if replicates of a figure are missing, or are not positive numbers.
    """
    for each in (replicates, of_baseline):
        _check(figures, each)
    rows = []
    for key, figure in figures.items():
        ours, theirs = band(replicates[key]), figure.value
        rows.append(Row(figure.table, figure.row, theirs, ours, ours.holds(theirs), figure.unit, FigureScores(
            half=figure.half, pit=pit(theirs, replicates[key]), log_score=log_score(theirs, replicates[key]),
            baseline_log_score=log_score(theirs, of_baseline[key]),
            baseline_holds=band(of_baseline[key]).holds(theirs),
            band_over_sd=(ours.high - ours.low) / figure.spread)))
    return rows


def _check(figures: Mapping[str, Published], replicates: Replicates) -> None:
    if set(replicates) != set(figures):
        odd = ", ".join(sorted(set(replicates) ^ set(figures)))
        raise InputError("replicates", f"missing or unknown: {odd}", "one array for each published figure")
    if len({values.shape for values in replicates.values()}) != 1:
        raise InputError("replicates", "figures differ in the number of replicates", "the same papers in all")
    for key, values in replicates.items():
        if not (values.size and np.isfinite(values).all() and (values > 0.0).all()):
            raise InputError(f"replicates, {key}", "none, or not all are positive numbers", "numbers above 0")


def all_of(conditions: ArrayLike) -> NDArray[np.bool_]:
    """Whether every condition, (conditions, replicates), is met in each replicate."""
    return np.asarray(np.all(conditions, axis=0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """A published statement that compares figures of one paper.

    Attributes
    ----------
    table, statement: where it is, and its text.
    theirs: how often it holds in the paper's own figures.
    occurs: function of replicates; whether it occurs in each, (replicates,).
    """

    table: str
    statement: str
    theirs: str
    occurs: Callable[[Replicates], NDArray[np.bool_]]


def pattern_rows(patterns: Sequence[Pattern], replicates: Replicates, of_baseline: Replicates) -> list[Row]:
    """Rows of patterns; each holds if it occurs in at least half of the replicates."""
    rows = []
    for pattern in patterns:
        share, before = (float(np.mean(pattern.occurs(each))) for each in (replicates, of_baseline))
        ours = f"in {100.0 * share:.0f} %"
        rows.append(Row(pattern.table, pattern.statement, pattern.theirs, ours, share >= MOST, "",
                        PatternScores(share=share, baseline_share=before, baseline_holds=before >= MOST)))
    return rows

"""Figures of point searches: how fast each finds, and maps over the arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.result import Reproduction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
# Told apart by the colour-blind (Okabe and Ito).
_COLOURS = {"gp": "#0072b2", "magnets": "#d55e00", "two_phase": "#009e73"}
_WORDS = {"gp": "Gaussian process", "magnets": "the same, salchow_b near magnets", "two_phase": "two phases"}


def progress(found: Reproduction) -> Figure:
    """What is recommended, as a share of the optimum, over minutes of each patient's time."""
    figure = _figure(9.0, 4.0)
    axes = figure.subplots()
    for number, patient in enumerate(found.curves["patients"]):
        optimum = max(patient["gp"]["everything"].values())
        for name, colour in _COLOURS.items():
            kept = patient[name]
            axes.step(kept["told_min"], 100.0 * kept["worth"] / optimum, where="post", color=colour,
                      alpha=0.6, linewidth=1.0, label=_WORDS[name] if number == 0 else None)
    axes.axhline(90.0, color="0.6", linewidth=0.8, linestyle="--")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("minutes")
    axes.set_ylabel("quality of what is recommended, % of optimum")
    axes.legend(frameon=False, fontsize="small")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def maps(found: Reproduction) -> Figure:
    """The first patient's arrays: what each element is good for at best, and how often it was asked."""
    patient = found.curves["patients"][0]
    layouts = patient["gp"]["layouts"]
    best = _best_of_elements(patient["gp"]["everything"], sum(rows * columns for rows, columns in layouts))
    figure = _figure(9.0, 3.6)
    grid = figure.subplots(1, len(layouts), squeeze=False)[0]
    first, most = 0, float(np.nanmax(np.abs(best)))
    for number, (axes, (rows, columns)) in enumerate(zip(grid, layouts, strict=True)):
        count = rows * columns
        image = axes.imshow(best[first:first + count].reshape(rows, columns), cmap="RdBu", vmin=-most,
                            vmax=most)
        _mark(axes, patient["gp"]["asked"], first, rows, columns)
        axes.set_title(("dorsal array", "volar array")[number] if len(layouts) == 2 else f"array {number}",
                       loc="left", fontsize="medium")
        axes.set_xlabel("column, elbow to wrist")
        axes.set_ylabel("row, towards radial")
        first += count
    figure.colorbar(image, ax=list(grid), label="best quality with the element")
    return figure


def _best_of_elements(everything: dict[Any, float], count: int) -> Array:
    """Of each element the best quality of all queries that it has part in, (count,)."""
    best = np.full(count, np.nan)
    for (elements, _), quality in everything.items():
        for element in elements:
            best[element] = np.fmax(best[element], quality)
    return best


def _mark(
    axes: Axes, asked: list[tuple[tuple[int, ...], float]], first: int, rows: int, columns: int
) -> None:
    """A dot a query, in the middle of its elements, larger where more were."""
    places: dict[tuple[float, float], int] = {}
    for elements, _ in asked:
        inside = [element - first for element in elements if 0 <= element - first < rows * columns]
        if inside:
            row, column = np.divmod(inside, columns)
            place = float(np.mean(column)), float(np.mean(row))
            places[place] = places.get(place, 0) + 1
    for (x, y), count in places.items():
        axes.plot(x, y, "o", color="black", markersize=2.0 + 1.5 * count, alpha=0.7)


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")

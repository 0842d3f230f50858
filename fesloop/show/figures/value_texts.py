"""Values of cells as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fesloop.analysis.study.results.estimates import Estimate


def decimals_of(cells: Sequence[Estimate]) -> int:
    """So many that the largest value has three digits; none of a share, which is in percent."""
    if cells[0].statistic == "share":
        return 0
    largest = max((abs(cell.value) for cell in cells if np.isfinite(cell.value)), default=0.0)
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, 6)) if largest > 0.0 else 0


def value_text(cell: Estimate, decimals: int) -> str:
    """As it is written into a cell."""
    return f"{100.0 * cell.value:.0f}" if cell.statistic == "share" else f"{cell.value:.{decimals}f}"


def interval_text(cell: Estimate, decimals: int) -> str:
    """Its ends; empty where it has none."""
    if not np.isfinite(cell.high - cell.low):
        return ""
    factor = 100.0 if cell.statistic == "share" else 1.0
    return f"{factor * cell.low:.{decimals}f}–{factor * cell.high:.{decimals}f}"

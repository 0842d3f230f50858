"""Figures of grasps: what a tracker's latency costs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fesloop.apps.reproduce.result import Reproduction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BLUE, _GREY = "#0072b2", "0.75"


def latency(found: Reproduction) -> Figure:
    """Errors before contact and patients who hold, over latency: each patient grey, the median blue."""
    from matplotlib.figure import Figure

    at, errors = found.curves["latencies_ms"], found.curves["errors"]
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    panels = figure.subplots(1, len(errors) + 1)
    for axes, (name, values) in zip(panels, errors.items(), strict=False):
        for row in np.where(np.isfinite(values), values, np.nan):
            axes.plot(at, row, color=_GREY, linewidth=1.0)
        middle = np.median(values, axis=0)
        axes.plot(at, np.where(np.isfinite(middle), middle, np.nan), "o-", color=_BLUE)
        axes.set_title(f"{name}, deg RMSE before contact", loc="left", fontsize="medium")
        axes.set_ylim(bottom=0.0)
    panels[-1].step(at, found.curves["held"].sum(axis=0), "o-", where="mid", color=_BLUE)
    panels[-1].set_title(f"held, of {found.subjects}", loc="left", fontsize="medium")
    panels[-1].set_ylim(0.0, found.subjects + 0.5)
    for axes in panels:
        axes.set_xlabel("tracker latency, ms")
        axes.spines[["top", "right"]].set_visible(False)
    return figure

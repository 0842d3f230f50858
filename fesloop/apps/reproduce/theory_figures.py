"""Figure of the running loop beside the theory of linear loops."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from fesloop.apps.reproduce.result import Reproduction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BLUE, _ORANGE = "#0072b2", "#d55e00"


def beside_theory(found: Reproduction) -> Figure:
    """Mean squares over exact ones with their intervals, and crossings less critical latencies."""
    from matplotlib.figure import Figure

    cost, crossing = found.curves["cost"], found.curves["crossing"]
    figure = Figure(figsize=(12.0, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2, 3))
    places = np.arange(len(cost["names"]))
    left.errorbar(100.0 * cost["mean"] / cost["exact"], places, xerr=100.0 * cost["half"] / cost["exact"],
                  fmt="o", color=_BLUE, markersize=4, capsize=2)
    left.axvline(100.0, color="black", linewidth=1.0)
    left.set_yticks(places, [fill(name, 48) for name in cost["names"]], fontsize="small")
    left.invert_yaxis()
    left.set_xlabel("simulated mean square, % of the exact")
    left.set_title("cost at rest, 99 % intervals of all points together", loc="left", fontsize="medium")
    for wire, colour in zip(dict.fromkeys(crossing["wires"]), (_BLUE, _ORANGE), strict=False):
        mine = np.array([each == wire for each in crossing["wires"]])
        right.plot(crossing["theory_ms"][mine], (crossing["simulated_ms"] - crossing["theory_ms"])[mine], "o",
                   color=colour, markersize=4, label=wire)
    right.axhline(0.0, color="black", linewidth=1.0)
    right.set_ylim(-0.12, 0.12)
    right.set_xlabel("critical latency, ms")
    right.set_title("critical latency, simulated less exact, ms", loc="left", fontsize="medium")
    right.legend(frameon=False, fontsize="small")
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    return figure

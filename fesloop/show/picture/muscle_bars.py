"""Bars of all muscles at one instant: recruited share, activation, fitness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.muscles import EXTRINSIC, MUSCLES
from fesloop.show.picture.palette import BLUE, FAINT, INK, SKY, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


def draw_muscles(axes: Axes, muscles: dict[str, Array | None]) -> None:
    """One row a muscle; `recruitment`, `activation`, `fitness` (29,) each or None."""
    rows = np.arange(len(MUSCLES))
    recruitment, activation, fitness = (muscles[key] for key in ("recruitment", "activation", "fitness"))
    if recruitment is not None:
        axes.barh(rows, recruitment, 0.8, color=SKY, alpha=0.55, label="recruited share")
    if activation is not None:
        axes.barh(rows, activation, 0.38, color=BLUE, label="activation")
    if fitness is not None and (fitness < 0.995).any():
        axes.plot(fitness, rows, "|", color=INK, markersize=7, label="fitness")
    axes.set_yticks(rows, MUSCLES)
    axes.set_ylim(len(MUSCLES) - 0.4, -0.6)
    axes.axhline(len(EXTRINSIC) - 0.5, color=FAINT, linewidth=0.6)
    axes.set_xlim(0.0, 1.0)
    axes.grid(axis="x", color="0.9", linewidth=0.7)
    axes.set_axisbelow(True)
    tidy(axes, "share of the muscle")
    axes.tick_params(axis="y", labelsize=7.5, length=0)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3,
                    borderaxespad=0.2, handlelength=1.2, columnspacing=1.2)
    else:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color=FAINT)

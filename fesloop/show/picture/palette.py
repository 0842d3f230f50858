"""Colours and style of all pictures, distinguishable with colour blindness (Okabe and Ito)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE = (
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7")
CHANNELS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, YELLOW)
"""Colours of a stimulator's channels, in turn."""
FINGER_COLOURS = (BLACK, BLUE, GREEN, ORANGE, PURPLE)
"""Colours of F1 to F5."""
INK, FAINT = "0.15", "0.6"


def channel_colour(channel: int) -> str:
    """Colour of a channel; colours repeat after eight."""
    return CHANNELS[channel % len(CHANNELS)]


def tidy(axes: Axes, x: str = "", y: str = "", title: str = "") -> None:
    """Label axes, and remove the top and right spines."""
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.set_title(title, loc="left", fontsize=10, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)

"""Title, time, legend and stimulation over time, beside the hand of a film's frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.show.film.stage import GHOST, PAPER, SKIN, Picture
from fesloop.show.picture.palette import CHANNELS, FAINT, INK

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
_COLOURS = (*CHANNELS[:6], "#404040", "#8a7a00")
"""Colours of channels: those of all figures, black lightened and yellow darkened."""
MOST_CHANNELS = 8
_DPI, _HEIGHT_PX = 100, 720
"""Letters have their size in points in a picture of this height, and grow with it."""
_WIDE = 1.2
"""Ratio of width to height from which on the hand stands beside the channels, and not above them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Channel:
    """A channel of the stimulator in a trial.

    Attributes
    ----------
    number: counted from 0.
    times_s: (n,). current_ma, width_us: (n,), each held until the next instant.
    """

    number: int
    times_s: Array
    current_ma: Array
    width_us: Array

    @property
    def charge_uc(self) -> Array:
        """Charge of one phase of a pulse, uC."""
        return self.current_ma * self.width_us * 1e-3

    def at(self, time_s: float) -> tuple[float, float]:
        """Current, mA, and pulse width, us, at an instant."""
        row = int(np.searchsorted(self.times_s, time_s + 1e-9, side="right")) - 1
        return (0.0, 0.0) if row < 0 else (float(self.current_ma[row]), float(self.width_us[row]))


class Place(NamedTuple):
    """Part of a picture, pixels from its upper left corner."""

    left: int
    top: int
    width: int
    height: int


class Panel:
    """Draws title, time and stimulation around a place for the hand.

    Parameters
    ----------
    width, height: of the picture, pixels.
    title: of the run. trial: words for the trial.
    keys: colour and words for each hand in the picture.
    channels: stimulated ones; none: the hand takes the whole width.
    span_s: instants of the axes' ends. note: words below the channels.
    """

    def __init__(self, width: int, height: int, title: str, trial: str, keys: Sequence[tuple[str, str]],
                 channels: Sequence[Channel], span_s: tuple[float, float], note: str = "") -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        dpi = _DPI * min(height / _HEIGHT_PX, width / (_WIDE * _HEIGHT_PX))
        self._figure = Figure(figsize=(width / dpi, height / dpi), dpi=dpi, facecolor=PAPER)
        # matplotlib leaves the canvas's methods without types
        canvas: Any = FigureCanvasAgg(self._figure)
        self._canvas = canvas
        self._unit_px, self._span_s = dpi / _DPI, span_s
        self._channels = channels
        wide = width >= _WIDE * height
        head, foot, edge = (round(each * self._unit_px) for each in (92, 46, 28))
        if not channels:
            self.hand = Place(0, head, width, height - head - foot)
        elif wide:
            self.hand = Place(0, head, round(0.60 * width), height - head - foot)
        else:
            self.hand = Place(0, head, width, round(0.55 * (height - head - foot)))
        self._text(edge, 26, title, size=19, color=INK, weight="bold")
        self._text(edge, 60, trial, size=13, color="0.35")
        self._clock = self._text(width - edge, 24, "", size=24, color=INK, weight="bold", ha="right")
        self._moving: list[Artist] = [self._clock]
        self._rows: list[tuple[Axes, Artist, Artist, Artist]] = []
        self._keys(edge, self.hand.top + self.hand.height, keys)
        if channels:
            top = head if wide else self.hand.top + self.hand.height + foot
            left = self.hand.width if wide else edge
            self._stack(Place(left, top, width - left - edge, height - top - edge), note)
        canvas.draw()
        self._background = canvas.copy_from_bbox(self._figure.bbox)

    def around(self, hand: Picture, time_s: float) -> Picture:
        """Picture (height, width, 3) of an instant, with a picture of the hand in its place."""
        self._canvas.restore_region(self._background)
        self._clock.set_text(f"{time_s:.2f} s")  # type: ignore[attr-defined]
        for (axes, past, head, now), channel in zip(self._rows, self._channels, strict=True):
            self._move(axes, past, head, now, channel, time_s)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        picture = np.asarray(self._canvas.buffer_rgba())[..., :3].copy()
        left, top, width, height = self.hand
        picture[top:top + height, left:left + width] = hand
        return picture

    def _move(self, axes: Axes, past: Artist, head: Artist, now: Artist, channel: Channel,
              time_s: float) -> None:
        from matplotlib.transforms import Bbox

        ends = axes.transData.transform([(self._span_s[0], 0.0), (time_s, 0.0)])
        past.set_clip_box(Bbox([[ends[0, 0], 0.0], [ends[1, 0], self._figure.bbox.height]]))
        head.set_xdata([time_s, time_s])  # type: ignore[attr-defined]
        current, width = channel.at(time_s)
        on = current > 0.0 and width > 0.0
        now.set_text(f"{current:.1f} mA · {width:.0f} µs" if on else "off")  # type: ignore[attr-defined]
        now.set_color(INK if on else FAINT)  # type: ignore[attr-defined]

    def _text(self, x: float, y: float, text: str, *, size: float, color: str, ha: str = "left",
              weight: str = "normal") -> Artist:
        """Text at pixels from the upper left corner, y in pixels of a picture of 720."""
        width, height = self._figure.bbox.width, self._figure.bbox.height
        return self._figure.text(x / width, 1.0 - y * self._unit_px / height, text, fontsize=size * 0.72,
                                 color=color, ha=ha, va="top", weight=weight)

    def _keys(self, left: float, top: float, keys: Sequence[tuple[str, str]]) -> None:
        """Row of coloured squares and words below the hand."""
        x = left
        renderer = self._canvas.get_renderer()
        for colour, words in keys:
            for text, ink in (("■ ", colour), (words, "0.25")):
                drawn = self._text(x, top / self._unit_px + 10, text, size=14, color=ink)
                x += drawn.get_window_extent(renderer).width
            x += 26 * self._unit_px

    def _stack(self, place: Place, note: str) -> None:
        """Charge of each channel's pulses over time, one strip below another."""
        width, height = self._figure.bbox.width, self._figure.bbox.height
        unit = self._unit_px
        self._text(place.left, place.top / unit, "Stimulation: charge of each pulse, µC", size=14.5,
                   color=INK, weight="bold")
        if note:
            self._text(place.left, place.top / unit + 20, note, size=12, color="0.4")
        top, foot = place.top + (48 if note else 34) * unit, 40 * unit
        each = min((place.top + place.height - foot - top) / len(self._channels), 120 * unit)
        most = max(float(np.nanmax(channel.charge_uc, initial=0.0)) for channel in self._channels) or 1.0
        margin = 34 * unit
        for number, channel in enumerate(self._channels):
            base = top + (number + 1) * each
            strip = min(each - 24 * unit, 90 * unit)
            axes = self._figure.add_axes(((place.left + margin) / width, 1.0 - base / height,
                                          (place.width - margin) / width, strip / height))
            self._strip(axes, channel, most, last=number == len(self._channels) - 1)

    def _strip(self, axes: Axes, channel: Channel, most: float, *, last: bool) -> None:
        colour = _colour(channel)
        times = np.append(channel.times_s, max(self._span_s[1], channel.times_s[-1]))
        charge = np.append(channel.charge_uc, channel.charge_uc[-1])
        axes.set_facecolor("none")
        axes.fill_between(times, charge, step="post", color=colour, alpha=0.18, linewidth=0.0)
        past = axes.fill_between(times, charge, step="post", color=colour, alpha=0.85, linewidth=0.0,
                                 animated=True)
        head = axes.axvline(self._span_s[0], color=INK, linewidth=1.2, animated=True)
        above: dict[str, Any] = {"transform": axes.transAxes, "fontsize": 12 * 0.72, "va": "bottom"}
        axes.text(0.0, 1.03, f"channel {channel.number}", ha="left", color=INK, weight="bold", **above)
        now = axes.text(1.0, 1.03, "", ha="right", animated=True, **above)
        axes.set_xlim(*self._span_s)
        axes.set_ylim(0.0, 1.05 * most)
        axes.set_yticks([0.0, _rounded(most)])
        axes.tick_params(labelsize=11 * 0.72, length=3, color="0.7", labelcolor="0.35")
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color("0.75")
        if last:
            axes.set_xlabel("time in the trial, s", fontsize=12 * 0.72, color="0.35", labelpad=2)
        else:
            axes.tick_params(labelbottom=False)
        self._rows.append((axes, past, head, now))
        self._moving += [past, head, now]


def _colour(channel: Channel) -> str:
    return _COLOURS[channel.number % len(_COLOURS)]


def _rounded(most: float) -> float:
    """The number of one digit that is next below."""
    step = 10.0 ** np.floor(np.log10(most))
    return float(np.floor(most / step) * step)


def key_of(colour: tuple[float, float, float], words: str) -> tuple[str, str]:
    """Entry of the row of keys."""
    return "#" + "".join(f"{round(255 * each):02x}" for each in colour), words


TRUE_KEY = key_of(SKIN, "true hand")
"""Entry of the true hand; that of an estimate names its tracker (`estimate_key`)."""


def estimate_key(tracker: str) -> tuple[str, str]:
    """Entry of a tracker's estimate."""
    return key_of(GHOST, f"estimate of {tracker}")

"""Picture of a stimulated arm in a device: pulses, activation, torque of the muscles and as it is read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.hand.muscle_paths import JOINTS
from fesloop.loop.clock import NS_PER_S
from fesloop.show.picture.cast import source_of
from fesloop.show.picture.palette import BLACK, BLUE, INK, channel_colour, tidy
from fesloop.show.picture.signals import curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_LEAST_NM = 5e-3
"""Torque below which a joint is not drawn (chosen: a tenth of what stimulation evokes at a wrist)."""
_LEAST_ACTIVATION = 0.01
"""Least range of an axis of activation (chosen)."""
_MOST_ROWS = 8000
"""Most points of a loop (chosen: 40 s at 200 Hz)."""


def arm_of(recording: Recording) -> str:
    """Name of the block that is an arm in a device, by its outputs; empty without one."""
    names = dict.fromkeys(name.partition(".")[0] for name in recording.signals)
    return next((name for name in names if all(
        f"{name}.{port}" in recording.signals for port in ("evoked", "device", "activation"))), "")


def arm_figure(
    recording: Recording, arm: str, trial: int, at_ns: Instants, until_ns: int, title: str
) -> Figure:
    """Figure of an arm in a device.

    Left, over time: pulse widths, activation by electrode, and for each joint the torque of the muscles and
    what the device reads of it, minus its own torque. Right: activation over pulse width, and the reading
    over the torque of the muscles, of which dry friction makes a loop beside the line.

    The instants `at_ns` are marked.
    """
    from matplotlib.figure import Figure

    stimulator = source_of(recording, f"{arm}.elements").partition(".")[0]
    stimulation = source_of(recording, f"{stimulator}.stimulation")
    electrodes = [str(name) for name in recording.experiment["blocks"][arm].get("electrodes", ())]
    seconds, evoked = curve(recording, f"{arm}.evoked", trial, until_ns)
    _, device = curve(recording, f"{arm}.device", trial, until_ns)
    when, activation = curve(recording, f"{arm}.activation", trial, until_ns)
    pulses = curve(recording, stimulation, trial, until_ns) if stimulation in recording.signals else None
    sizes = [max(float(np.nanmax(np.abs(values[:, j]), initial=0.0)) for values in (evoked, device))
             for j in range(len(JOINTS))]
    shown = [j for j, size in enumerate(sizes) if size >= _LEAST_NM] or [int(np.argmax(sizes))]
    rows = (pulses is not None) + 1 + len(shown)
    figure = Figure(figsize=(13.33, 1.6 + 1.9 * rows), dpi=150, layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, color=INK)
    grid = figure.subplots(rows, 2, width_ratios=(4, 1), squeeze=False)
    for axes in grid[:, 0]:
        axes.set_xlim(0.0, until_ns / NS_PER_S)
        for now in at_ns:
            axes.axvline(now / NS_PER_S, color="0.75", linewidth=0.8, zorder=0)
    row = 0
    if pulses is not None:
        _widths(grid[0, 0], *pulses)
        row = 1
    _activation(grid[row, 0], when, activation, electrodes)
    if pulses is None:
        grid[row, 1].set_visible(False)
    else:
        _recruitment(grid[row, 1], *_some(recording, f"{arm}.activation", trial, until_ns),
                     *recording.column(stimulation, trial))
        grid[0, 1].set_visible(False)
    _, forces = _some(recording, f"{arm}.evoked", trial, until_ns)
    _, reading = _some(recording, f"{arm}.device", trial, until_ns)
    for j, (left, right) in zip(shown, grid[row + 1:], strict=True):
        _torque(left, JOINTS[j].replace("_", " "), seconds, evoked[:, j], -device[:, j])
        _loop(right, forces[:, j], -reading[:, j])
    for axes in grid[:-1, 0]:
        axes.tick_params(labelbottom=False)
    grid[row + 1, 0].legend(frameon=False, fontsize=8, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 0.97),
                            borderaxespad=0.0)
    grid[-1, 0].set_xlabel("s", fontsize=9)
    grid[-1, 1].set_xlabel("of the muscles, N m", fontsize=9)
    hidden = [JOINTS[j].replace("_", " ") for j in range(len(JOINTS)) if j not in shown]
    if hidden:
        figure.text(0.99, 0.995, f"below {_LEAST_NM:g} N m: {', '.join(hidden)}", ha="right", va="top",
                    fontsize=8, color=INK)
    return figure


def _widths(axes: Axes, seconds: Array, values: Array) -> None:
    """Pulse width of every channel, nothing where there is no current, and the current in words."""
    on = values[..., 0] > 0.0
    for channel in range(values.shape[1]):
        width = np.where(on[:, channel], 1e6 * values[:, channel, 1], 0.0)
        axes.plot(seconds, width, color=channel_colour(channel), linewidth=1.2, drawstyle="steps-post")
    currents = [np.unique(values[on[:, c], c, 0].round(6)) for c in range(values.shape[1])]
    words = [f"{1e3 * each[0]:g} mA" if len(each) == 1 else
             f"{1e3 * each[0]:g} to {1e3 * each[-1]:g} mA" for each in currents if each.size]
    tidy(axes, y="µs", title="pulse width" + (f" at {', '.join(words)}" if words else ""))
    axes.set_ylim(bottom=0.0)


def _activation(axes: Axes, seconds: Array, values: Array, electrodes: list[str]) -> None:
    for e in range(values.shape[1]):
        axes.plot(seconds, values[:, e], color=channel_colour(e), linewidth=1.3,
                  label=electrodes[e] if e < len(electrodes) else str(e))
    tidy(axes, y="1", title="activation")
    axes.set_ylim(0.0, max(_LEAST_ACTIVATION, axes.get_ylim()[1]))
    axes.legend(frameon=False, fontsize=8, ncols=4, loc="lower right", bbox_to_anchor=(1.0, 0.97),
                borderaxespad=0.0)


def _some(recording: Recording, name: str, trial: int, until_ns: int) -> tuple[Instants, Array]:
    """Instants (n,), ns, and values (n, *shape) of a signal, every so many rows of the recording."""
    times, column = recording.column(name, trial)
    stop = int(np.searchsorted(times, until_ns, side="right"))
    every = max(1, stop // _MOST_ROWS)
    return times[:stop:every], column[:stop:every]


def _recruitment(axes: Axes, times_ns: Instants, values: Array, when_ns: Instants, pulses: Any) -> None:
    """Activation over the pulse width of the electrode's channel at that time; delay opens a loop."""
    last = np.clip(np.searchsorted(when_ns, times_ns, side="right") - 1, 0, None)
    pulses = pulses[:]
    for e in range(min(values.shape[1], pulses.shape[1])):
        on = pulses[:, e, 0] > 0.0
        width = np.where(on, 1e6 * pulses[:, e, 1], np.nan)[last]
        axes.plot(width, values[:, e], ".", color=channel_colour(e), markersize=1.5)
    tidy(axes, x="µs", title="activation over pulse width")
    axes.set_ylim(0.0, max(_LEAST_ACTIVATION, axes.get_ylim()[1]))


def _torque(axes: Axes, joint: str, seconds: Array, evoked: Array, read: Array) -> None:
    """Torque of the muscles and reading over time."""
    axes.axhline(0.0, color="0.8", linewidth=0.6)
    axes.plot(seconds, evoked, color=BLUE, linewidth=1.2, label="of the muscles")
    axes.plot(seconds, read, color=BLACK, linewidth=1.2, label="as the device reads it")
    tidy(axes, y="N m", title=joint)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -_LEAST_NM / 10.0), max(high, _LEAST_NM / 10.0))


def _loop(axes: Axes, evoked: Array, read: Array) -> None:
    """Reading over the torque of the muscles; without friction on the grey line."""
    ends = float(min(evoked.min(), read.min())), float(max(evoked.max(), read.max()))
    axes.plot(ends, ends, color="0.8", linewidth=0.8)
    axes.plot(evoked, read, color=BLACK, linewidth=0.8)
    axes.locator_params(axis="x", nbins=4)
    tidy(axes, y="read, N m", title="read over that of the muscles")

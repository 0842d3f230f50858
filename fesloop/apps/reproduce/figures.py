"""Figures of a reproduction: those of the papers, and published values with the bands of virtual subjects."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.comparison import Band, FigureScores, Row
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BLUE, _GREY = "#0072b2", "0.75"


def latency(found: Reproduction) -> Figure:
    """Draw errors before contact and patients who hold over latency: each patient grey, the median blue."""
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


Array = NDArray[np.float64]
# Told apart by the colour-blind (Okabe and Ito).
_COLOURS = {"gp": "#0072b2", "magnets": "#d55e00", "two_phase": "#009e73"}
_WORDS = {"gp": "Gaussian process", "magnets": "the same, salchow_b near magnets", "two_phase": "two phases"}


def progress(found: Reproduction) -> Figure:
    """Draw quality of the recommendation, as a share of the optimum, over minutes of each patient's time."""
    figure = _search_figure(9.0, 4.0)
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
    """Draw the first patient's arrays: best quality of each element, and how often it was queried."""
    patient = found.curves["patients"][0]
    layouts = patient["gp"]["layouts"]
    best = _best_of_elements(patient["gp"]["everything"], sum(rows * columns for rows, columns in layouts))
    figure = _search_figure(9.0, 3.6)
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
    """Best quality of all queries that contain an element, (count,)."""
    best = np.full(count, np.nan)
    for (elements, _), quality in everything.items():
        for element in elements:
            best[element] = np.fmax(best[element], quality)
    return best


def _mark(
    axes: Axes, asked: list[tuple[tuple[int, ...], float]], first: int, rows: int, columns: int
) -> None:
    """Draw a dot for each query at the centre of its elements, larger for more queries."""
    places: dict[tuple[float, float], int] = {}
    for elements, _ in asked:
        inside = [element - first for element in elements if 0 <= element - first < rows * columns]
        if inside:
            row, column = np.divmod(inside, columns)
            place = float(np.mean(column)), float(np.mean(row))
            places[place] = places.get(place, 0) + 1
    for (x, y), count in places.items():
        axes.plot(x, y, "o", color="black", markersize=2.0 + 1.5 * count, alpha=0.7)


def _search_figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


_THEORY_BLUE, _ORANGE = "#0072b2", "#d55e00"


def beside_theory(found: Reproduction) -> Figure:
    """Draw mean squares relative to exact ones with intervals, and crossings minus critical latencies."""
    from matplotlib.figure import Figure

    cost, crossing = found.curves["cost"], found.curves["crossing"]
    figure = Figure(figsize=(12.0, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2, 3))
    places = np.arange(len(cost["names"]))
    left.errorbar(100.0 * cost["mean"] / cost["exact"], places, xerr=100.0 * cost["half"] / cost["exact"],
                  fmt="o", color=_THEORY_BLUE, markersize=4, capsize=2)
    left.axvline(100.0, color="black", linewidth=1.0)
    left.set_yticks(places, [fill(name, 48) for name in cost["names"]], fontsize="small")
    left.invert_yaxis()
    left.set_xlabel("simulated mean square, % of the exact")
    left.set_title("cost at rest, 99 % intervals of all points together", loc="left", fontsize="medium")
    for wire, colour in zip(dict.fromkeys(crossing["wires"]), (_THEORY_BLUE, _ORANGE), strict=False):
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


BLUE, ORANGE, GREY, GREEN = "#0072b2", "#d55e00", "#666666", "#009e73"
"""Colours that the colour-blind can distinguish (Okabe and Ito)."""
SKY = "#56b4e9"
_OF_PEOPLE = ("black", ORANGE, GREEN, "#cc79a7", "#e69f00", SKY)
COLOURS = {"B": ORANGE, "M1": BLUE, "M2": GREEN}


def draw(found: Reproduction, folder: Path) -> list[Path]:
    """Write every figure that has curves as PNG and return the paths.

    Raises InputError if matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: F401
    except ImportError:
        raise InputError("figures", "matplotlib is not installed", "matplotlib 3.8 or later",
                         "pip install matplotlib") from None
    written = []
    every: dict[str, Callable[[Reproduction], Figure | None]] = dict(_OF_PAPER.get(found.paper, {}))
    if any(isinstance(row.ours, Band) for row in found.rows):
        every["bands"] = bands
    for name, make in every.items():
        figure = make(found)
        if figure is not None:
            figure.savefig(folder / f"{name}.png", dpi=110)
            written.append(folder / f"{name}.png")
    return written


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _tidy(axes: Axes, x: str = "", y: str = "", title: str = "") -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, loc="left", fontsize="medium")
    axes.spines[["top", "right"]].set_visible(False)


def bands(found: Reproduction) -> Figure:
    """Draw published values as points and the bands of virtual subjects, a line for each row."""
    rows = [row for row in found.rows if isinstance(row.ours, Band)]
    figure = _figure(9.0, 1.2 + 0.24 * len(rows))
    axes = figure.subplots()
    for y, row in enumerate(rows):
        ours = row.ours
        assert isinstance(ours, Band)
        axes.plot([ours.low, ours.high], [y, y], color=BLUE, linewidth=4, alpha=0.45, solid_capstyle="butt",
                  label="ours, 5-95 %" if y == 0 else None)
        axes.plot(ours.median, y, "|", color=BLUE, markersize=9, label="ours, median" if y == 0 else None)
        theirs = float(row.theirs)
        axes.plot(theirs, y, "o" if row.holds else "X", color="black" if row.holds else ORANGE, markersize=5)
    axes.plot([], [], "o", color="black", markersize=5, label="theirs, in the band")
    axes.plot([], [], "X", color=ORANGE, markersize=5, label="theirs, outside")
    axes.set_yticks(range(len(rows)), [_label(row) for row in rows], fontsize="small")
    axes.invert_yaxis()
    axes.set_xlim(left=0.0)
    axes.legend(frameon=False, fontsize="small", loc="lower right")
    units = ", ".join(dict.fromkeys(row.unit for row in rows))
    _tidy(axes, units, title=f"{found.paper}, {found.cohort}")
    return figure


def _label(row: Row) -> str:
    half = f" ({row.scores.half})" if isinstance(row.scores, FigureScores) else ""
    return f"{row.table}: {row.row}{half}"


def kortier_5(found: Reproduction) -> Figure:
    """Draw figure 5 of K14: index tip in the hand's frame in flexion and circles, and its error."""
    figure = _figure(10.0, 7.0)
    grid = figure.subplots(4, 2, sharex="col")
    for column, motion in zip(grid.T, ("flexion", "circles"), strict=True):
        traces = found.curves["traces"][motion]
        times = traces["times_s"] - traces["times_s"][0]
        for i, name in enumerate("xyz"):
            column[i].plot(times, traces["true_tip_mm"][:, i], color="black", label="truth")
            column[i].plot(times, traces["tip_mm"][:, i], "--", color=ORANGE, label="tracker")
            _tidy(column[i], y=f"{name}, mm", title=motion if i == 0 else "")
        error = np.linalg.norm(traces["tip_mm"] - traces["true_tip_mm"], axis=1)
        column[3].plot(times, error, color=BLUE)
        _tidy(column[3], "s", "error, mm")
    grid[0, 0].legend(frameon=False, fontsize="small", ncols=2)
    return figure


def kortier_6(found: Reproduction) -> Figure:
    """Draw figure 6 of K14: PIP angle and its rate in 30 rapid movements."""
    traces = found.curves["traces"]["rapid"]
    figure = _figure(10.0, 5.0)
    angle, rate = figure.subplots(2, sharex=True)
    start = traces["times_s"][0]
    angle.plot(traces["times_s"] - start, traces["true_pip_deg"], color="black", label="truth")
    angle.plot(traces["times_s"] - start, traces["pip_deg"], "--", color=ORANGE, label="tracker")
    angle.legend(frameon=False, fontsize="small", ncols=2)
    rate.plot(traces["rate_times_s"] - start, traces["rate_deg_s"], color=BLUE)
    _tidy(angle, y="PIP angle, deg", title="116 beats a minute")
    _tidy(rate, "s", "PIP rate, deg/s")
    return figure


def salchow_12(found: Reproduction) -> Figure:
    """Draw figure 12 of S19: quartiles and maximum over time of the median subject's fingertip error."""
    motions = [name for name in found.curves["main"] if "-" in name]
    figure = _figure(10.0, 4.0)
    axes = figure.subplots()
    for number, motion in enumerate(motions):
        scores = found.curves["main"][motion]
        for shift, methods, colour in ((-0.18, ("B",), ORANGE), (0.18, ("M1", "M2"), BLUE)):
            low, middle, high, worst = (
                float(np.median([max(each[method][key] for method in methods) for each in scores]))
                for key in ("low", "median", "high", "worst"))
            axes.bxp([{"q1": low, "med": middle, "q3": high, "whislo": low, "whishi": worst, "fliers": []}],
                     positions=[number + shift], widths=0.3, patch_artist=True, manage_ticks=False,
                     boxprops={"facecolor": colour, "alpha": 0.6}, medianprops={"color": "black"})
    axes.set_xticks(range(len(motions)), motions)
    axes.set_ylim(bottom=0.0)
    for colour, label in ((ORANGE, "B"), (BLUE, "M1, M2: the higher value")):
        axes.plot([], [], color=colour, linewidth=6, alpha=0.6, label=label)
    axes.legend(frameon=False)
    _tidy(axes, y="error, cm", title="without magnetic disturbance; quartiles, whisker to the maximum")
    return figure


def salchow_13(found: Reproduction) -> Figure:
    """Draw figure 13 of S19: index tip by M1 in AF-F2, and its error in three movements."""
    traces = found.curves["traces"]
    figure = _figure(10.0, 6.0)
    place, error = figure.subplots(2, sharex=True)
    for motion, colour in (("A-F2", BLUE), ("F-F2", GREEN), ("AF-F2", ORANGE)):
        one = traces[motion]
        times = one["times_s"] - one["times_s"][0]
        shown = times <= 25.0
        if motion == "AF-F2":
            for i, (name, line) in enumerate(zip("xyz", (BLUE, GREEN, ORANGE), strict=True)):
                place.plot(times[shown], one["estimate_cm"][shown, i], color=line, label=f"{name}, M1")
                place.plot(times[shown], one["truth_cm"][shown, i], "--", color="black", linewidth=0.8)
        apart = np.linalg.norm(one["estimate_cm"] - one["truth_cm"], axis=1)
        error.plot(times[shown], apart[shown], color=colour, label=motion)
    for axes in (place, error):
        axes.legend(frameon=False, fontsize="small", ncols=3)
    error.set_ylim(bottom=0.0)
    _tidy(place, y="index tip, cm", title="AF-F2; truth dashed")
    _tidy(error, "s", "error, cm")
    return figure


def salchow_14(found: Reproduction) -> Figure:
    """Draw figure 14 of S19: RMSE of the distances, mean and standard deviation over subjects."""
    main = found.curves["main"]
    keys = [(motion, pair) for motion in main if "-" not in motion for pair in main[motion][0]["B"]]
    figure = _figure(10.0, 4.0)
    axes = figure.subplots()
    for shift, method in zip((-0.27, 0.0, 0.27), COLOURS, strict=True):
        values = np.array([[each[method][pair]["rmse"] for each in main[motion]] for motion, pair in keys])
        axes.bar(np.arange(len(keys)) + shift, values.mean(axis=1), 0.25, yerr=values.std(axis=1), capsize=3,
                 color=COLOURS[method], alpha=0.75, label=method)
    axes.set_xticks(range(len(keys)), [f"{motion} {pair}" for motion, pair in keys])
    axes.legend(frameon=False)
    axes.set_ylim(bottom=0.0)
    _tidy(axes, y="RMSE, cm", title="with magnetic disturbance")
    return figure


def salchow_15(found: Reproduction) -> Figure:
    """Draw figure 15 of S19: distance of the pinching tips by M2; grey where they are released."""
    traces = found.curves["traces"]["P3"]
    figure = _figure(10.0, 3.2)
    axes = figure.subplots()
    times = traces["times_s"]
    axes.plot(times, traces["distance_cm"], color=GREEN, label="M2")
    axes.axhline(0.0, color=GREEN, linestyle="--", label="truth while they touch")
    edges = [times[0], *traces["spans"].ravel(), times[-1]]
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        axes.axvspan(start, stop, color="0.85")
    axes.legend(frameon=False)
    _tidy(axes, "s", "distance of the tips, cm", "pinch (P3), released in grey")
    return figure


def sweep(name: str) -> Callable[[Reproduction], Figure]:
    """Draw a sweep as grouped bars."""
    def make(found: Reproduction) -> Figure:
        table: Sweep = found.sweeps[name]
        figure = _figure(10.0, 1.5 + 0.45 * len(table.rows))
        axes = figure.subplots()
        height = 0.8 / len(table.columns)
        for number, column in enumerate(table.columns):
            colour = COLOURS.get(column.rpartition(" ")[2], GREY)
            places = np.arange(len(table.rows)) + (number - 0.5 * (len(table.columns) - 1)) * height
            lengths = [values[number] for _, values in table.rows]
            axes.barh(places, lengths, height, color=colour, label=column, alpha=0.9 if number < 3 else 0.5)
        axes.set_yticks(range(len(table.rows)), [row for row, _ in table.rows])
        axes.invert_yaxis()
        axes.legend(frameon=False, fontsize="small")
        _tidy(axes, f"RMSE, {table.unit}", title=table.title)
        return figure

    return make


_OF_HOUR = (("salchow_m2", ORANGE, "M2"), ("m2_calibrated", GREEN, "M2, calibrated"),
            ("constrained", BLUE, "constrained"))


def hour(found: Reproduction) -> Figure:
    """Draw the RMSE of the fingertips minute by minute, with the standard deviation stated by the tracker."""
    figure = _figure(10.0, 4.5)
    axes = figure.subplots()
    for number, kept in enumerate(found.curves["minutes"]):
        for tracker, colour, label in _OF_HOUR:
            rmse = np.sqrt(np.mean(kept[tracker][:, 1:] ** 2, axis=1))
            axes.plot(np.arange(len(rmse)) + 0.5, rmse, color=colour, alpha=0.8,
                      label=f"{label}, RMSE" if number == 0 else None)
        sd = np.sqrt(np.mean(kept["sd"][:, 1:] ** 2, axis=1))
        axes.plot(np.arange(len(sd)) + 0.5, sd, ":", color=BLUE, alpha=0.6,
                  label="constrained, its own sd" if number == 0 else None)
        if number == 0:
            axes.axvspan(*(kept["still"] / 60.0), color="0.9", label="still")
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False)
    _tidy(axes, "min", "fingertips F2-F5, cm", f"an hour, {found.cohort}")
    return figure


def rats(found: Reproduction) -> Figure | None:
    """Draw force of each rat's muscle, measured black and simulated blue: contractions, a ramp, a cycle."""
    animals = found.curves.get("rats")
    if not animals:
        return None
    figure = _figure(12.0, 3.2 * len(animals))
    grid = figure.subplots(len(animals), 3, squeeze=False)
    for row, (name, kept) in zip(grid, animals.items(), strict=True):
        for key in ("long", "short"):
            _both(row[0], kept[key]["times_s"], kept[key])
        _tidy(row[0], "s", "force, N",
              f"{name}: isometric, {kept['long']['name']} and {kept['short']['name']}")
        _both(row[1], kept["ramp"]["times_s"], kept["ramp"])
        _tidy(row[1], "s", "force, N", f"{kept['ramp']['name']}: step and ramp of shortening")
        _both(row[2], kept["cycles"]["length_mm"], kept["cycles"])
        _tidy(row[2], "length of muscle and tendon, mm", "force, N",
              f"{kept['cycles']['name']}: not fitted, of median error")
        for axes in row[:2]:
            axes.set_xlim(0.45, 1.05)
    figure.axes[0].legend(*_first_two(figure.axes[0]), frameon=False, fontsize="small")
    return figure


def _both(axes: Axes, x: NDArray[np.float64], kept: dict[str, Any]) -> None:
    axes.plot(x, kept["theirs_n"], color="black", linewidth=1.0, label="theirs")
    axes.plot(x, kept["ours_n"], color=BLUE, linewidth=1.0, label="ours")


def _first_two(axes: Axes) -> tuple[list[Any], list[str]]:
    handles, labels = axes.get_legend_handles_labels()
    return handles[:2], labels[:2]


def biceps(found: Reproduction) -> Figure | None:
    """Draw the trains of a biceps, measured black and simulated blue: those fitted, and those predicted."""
    trains = found.curves.get("trains")
    if not trains:
        return None
    figure = _figure(11.0, 3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    for train in trains:
        _both(left if train["fitted"] else right, train["times_s"], train)
    _tidy(left, "s", "force, N", "biceps: trains fitted")
    _tidy(right, "s", "", "course of trains not fitted, each at its own scale")
    left.legend(*_first_two(left), frameon=False, fontsize="small")
    return figure


def postures(found: Reproduction) -> Figure | None:
    """Draw torque over posture of the person of median error: measured black, predicted blue with 90 %."""
    kept = found.curves.get("postures")
    if not kept:
        return None
    rows, joints = kept["by_electrode"], kept["joints"]
    figure = _figure(3.2 * len(joints), 1.0 + 1.25 * len(rows))
    panels = figure.subplots(len(rows), len(joints), sharex=True, sharey="col", squeeze=False)
    for number, (electrode, each) in enumerate(rows.items()):
        at = np.arange(len(each["codes"]))
        seen = at % 3 == 0
        for j, axes in enumerate(panels[number]):
            ours, half = each["ours_nm"][:, j], 1.645 * each["sd_nm"][:, j]
            axes.fill_between(at, ours - half, ours + half, color=BLUE, alpha=0.2, linewidth=0.0)
            axes.plot(at, ours, color=BLUE, linewidth=1.0)
            axes.plot(at[seen], each["theirs_nm"][seen, j], "o", color="black", markersize=3.5)
            axes.plot(at[~seen], each["theirs_nm"][~seen, j], "o", color="black", markersize=3.5,
                      markerfacecolor="white")
            axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
            _tidy(axes, y=fill(electrode, 15) if j == 0 else "",
                  title=joints[j].replace("_", " ") if number == 0 else "")
            axes.set_xticks(at, each["codes"], rotation=90, fontsize=5)
    figure.suptitle(f"{kept['person']}: evoked torque, N m, over posture. Full: seen, open: predicted; line, "
                    "band: prediction, 90 %", fontsize="medium", x=0.01, ha="left")
    return figure


def recruitment(found: Reproduction) -> Figure | None:
    """Draw torque that a device reads in ramps, recorded and fitted, and recruited shares, by electrode.

    Shares beyond the recorded currents are dashed; the band is of random people.
    """
    kept = found.curves.get("recruitment")
    if not kept:
        return None
    people = sorted({fit["person"] for each in kept.values() for fit in each["fits"]})
    colours = dict(zip(people, cycle(_OF_PEOPLE), strict=False))
    figure = _figure(1.0 + 2.2 * len(kept), 5.6)
    panels = figure.subplots(2, len(kept), sharex="col", squeeze=False)
    for number, (above, axes, (electrode, each)) in enumerate(zip(*panels, kept.items(), strict=True)):
        low, middle, high = each["band"]
        axes.fill_between(each["at_ma"], low, high, color=BLUE, alpha=0.2, linewidth=0.0,
                          label="random people, 5-95 %")
        axes.plot(each["at_ma"], middle, color=BLUE, linewidth=1.0, label="random people, median")
        for fit in each["fits"]:
            colour, ramps = colours[fit["person"]], fit["ramps"]
            inside = (each["at_ma"] >= ramps["at_ma"].min()) & (each["at_ma"] <= ramps["at_ma"].max())
            axes.plot(each["at_ma"], fit["share"], "--", color=colour, linewidth=0.7)
            axes.plot(each["at_ma"][inside], fit["share"][inside], color=colour, linewidth=2.0)
            above.plot(ramps["at_ma"], ramps["ours_nm"], color=colour, linewidth=1.0)
            above.plot(ramps["at_ma"][::8], ramps["theirs_nm"][::8], ".", color=colour, markersize=4)
        above.set_xlim(each["at_ma"][0], each["at_ma"][-1])
        _tidy(above, y="" if number else "torque in ramps, N m", title=fill(electrode, 20))
        _tidy(axes, "effective current, mA", "" if number else "recruited share")
    last = panels[1, 0]
    last.plot([], [], ".", color=GREY, label="recorded, up and down")
    last.plot([], [], "--", color=GREY, linewidth=0.7, label="beyond the recording")
    for person, colour in colours.items():
        last.plot([], [], color=colour, linewidth=1.2, label=f"{person}, fitted")
    figure.legend(*last.get_legend_handles_labels(), frameon=False, fontsize="small", ncols=5,
                  loc="outside lower center")
    return figure


def learned(found: Reproduction) -> Figure | None:
    """Draw a person's torque by electrode and joint: measured, and intervals by how much is known of them."""
    kept = found.curves.get("learned")
    if not kept:
        return None
    names, intervals = kept["electrodes"], kept["intervals_nm"]
    figure = _figure(12.0, 1.4 + 0.45 * len(names))
    panels = figure.subplots(1, len(kept["joints"]), sharey=True)
    at = np.arange(len(names))
    for j, axes in enumerate(panels):
        for (count, (low, _, high)), colour, shift in zip(
                intervals.items(), ("0.7", SKY, BLUE), (-0.25, 0.0, 0.25), strict=True):
            axes.hlines(at + shift, low[:, j], high[:, j], color=colour, linewidth=4, label=(
                f"posterior, {count} postures" if count else "prior (population)") + ", 90 %")
        axes.vlines(kept["theirs_nm"][:, j], at - 0.38, at + 0.38, color="black", linewidth=1.2,
                    label=f"measured, {max(intervals)} postures")
        axes.axvline(0.0, color="0.7", linewidth=0.6, zorder=0)
        _tidy(axes, "torque, N m", title=kept["joints"][j].replace("_", " "))
    panels[0].set_yticks(at, [fill(name, 15) for name in names])
    panels[0].invert_yaxis()
    figure.suptitle(f"{kept['person']}: evoked torque, mean over postures", fontsize="medium", x=0.01,
                    ha="left")
    figure.legend(*panels[0].get_legend_handles_labels(), frameon=False, fontsize="small", ncols=4,
                  loc="outside lower center")
    return figure


def unfitted(found: Reproduction) -> Figure | None:
    """Draw torque at the held wrist by muscle: people black, members of the virtual patient blue.

    Above, means over postures, a dot a person, and the mean of the group; below, flexion by posture, mean and
    standard deviation of the group.
    """
    kept = found.curves.get("unfitted")
    if not kept:
        return None
    names = kept["muscles"]
    figure = _figure(11.0, 7.0)
    grid = figure.add_gridspec(2, 1)
    above, below = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    groups = (("theirs", "people", "black", -0.16), ("ours", "members", BLUE, 0.16))
    for j, axes in enumerate(above.subplots(1, 2)):
        for key, who, colour, shift in groups:
            values = kept[f"{key}_nm"][:, :, j]
            beside = shift + 0.1 * np.linspace(-1.0, 1.0, len(values))[:, np.newaxis]
            axes.plot((np.arange(len(names)) + beside).ravel(), values.ravel(), "o", color=colour, alpha=0.6,
                      markersize=4, markeredgewidth=0.0, label=f"{key}, {len(values)} {who}")
            middle = np.ma.masked_invalid(values).mean(axis=0).filled(np.nan)
            axes.hlines(middle, np.arange(len(names)) + shift - 0.14,
                        np.arange(len(names)) + shift + 0.14, color=colour, linewidth=2)
        axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
        axes.set_xticks(range(len(names)), names)
        _tidy(axes, y="N m", title=("evoked flexion, mean over postures",
                                    "evoked radial deviation, mean over postures")[j])
    above.axes[0].legend(frameon=False, fontsize="small")
    labels = ["".join(sign[k > 0] for sign, k in zip(("sp", "ef", "ur"), each, strict=True))
              for each in kept["postures"]]
    for m, axes in enumerate(below.subplots(1, len(names))):
        for key, _, colour, shift in groups:
            values = kept[f"{key}_by_posture_nm"][:, m, :, 0]
            values = values[np.isfinite(values).all(axis=1)]
            if len(values):
                axes.errorbar(np.arange(len(labels)) + 0.5 * shift, values.mean(axis=0),
                              yerr=values.std(axis=0), fmt="o-", color=colour, markersize=3, linewidth=1.0,
                              elinewidth=0.6)
        axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
        axes.set_xticks(range(len(labels)), labels, rotation=90, fontsize="small")
        _tidy(axes, y="flexion, N m" if m == 0 else "", title=names[m])
    below.supxlabel("posture: forearm supinated or pronated, wrist extended or flexed, ulnar or radial",
                    fontsize="small")
    return figure


_OF_PAPER: dict[str, dict[str, Any]] = {
    "array_search": {"maps": maps, "progress": progress},
    "grasp_mpc": {"latency": latency},
    "hour": {"hour": hour},
    "people": {"postures": postures, "learned": learned, "unfitted": unfitted, "recruitment": recruitment,
               "rats": rats, "biceps": biceps},
    "linear_theory": {"beside_theory": beside_theory},
    "kortier2014": {"figure_5": kortier_5, "figure_6": kortier_6, "constraints": sweep("constraints")},
    "salchow2019": {"figure_12": salchow_12, "figure_13": salchow_13, "figure_14": salchow_14,
                    "figure_15": salchow_15}}

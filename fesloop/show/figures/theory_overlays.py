"""Lines of theory in the figures of a study, for cells that are linear loops."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.analysis.study.design.cells import Cell, cells_of
from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.design.plan import Resolver
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.results.axis_levels import AxisLevel, level_text
from fesloop.analysis.study.store.file import THEORY
from fesloop.analysis.theory.critical_latency import critical_latency_ms, growth
from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.loop import LinearLoop
from fesloop.analysis.theory.stationary_cost import StationaryCost, stationary_cost
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.cautions import is_source, put_out
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.machine import one_blas_thread
from fesloop.show.figures.content import Overlay

_WITHIN_NS = NS_PER_MS // 4
"""Tolerance of critical latencies in figures (chosen: less than the width of a line)."""
_AT_REST, _CRITICAL = "exact cost", "critical latency"

Levels = dict[str, AxisLevel]


def theory_overlays(study: Study, figure: Figure) -> list[Overlay]:
    """Lines of theory over a figure, panel by panel; none where nothing is linear, or theory is "none".

    Axes that the figure does not name are taken at their first levels. Raises InputError for critical
    latencies along an axis that is not the latency of one wire.
    """
    if figure.theory == "none":
        return []
    rows = _Rows(study, figure)
    overlays_of = _critical if figure.theory == "critical_latency" else _at_rest
    with one_blas_thread():
        return [overlay for panel in rows.levels(figure.panels) for line in rows.levels(figure.by)
                for overlay in overlays_of(rows, panel, line)]


class _Rows:
    """Cells of a study along the x of a figure; `theory` says at which levels others are taken."""

    def __init__(self, study: Study, figure: Figure) -> None:
        self.figure, self._study, self._resolver = figure, study, Resolver(study)
        self.metric = next(each for each in study.metrics if each.name == figure.metric)
        self._cells: list[Cell] = list(cells_of(study))
        first = self._cells[0].levels
        named = {axis for key, axis in figure.named_axes() if key != "at"}
        held = {name: level for name, level in first.items() if name not in named} | dict(figure.at)
        self._cells = [cell for cell in self._cells if all(cell.levels[a] == held[a] for a in held)]
        chosen = [f"{name} {level_text(level)}" for name, level in held.items() if name not in figure.at]
        self.theory = ", ".join(["theory", *chosen])

    def levels(self, axis: str | None) -> list[AxisLevel | None]:
        """Levels of an axis, in the order of the study; one None of no axis."""
        if axis is None:
            return [None]
        return list(dict.fromkeys(cell.levels[axis] for cell in self._cells))

    def along_x(self, at: Mapping[str | None, AxisLevel | None]) -> list[Cell]:
        """Cells at levels of axes, by x."""
        chosen = [cell for cell in self._cells
                  if all(axis is None or cell.levels[axis] == level for axis, level in at.items())]
        return sorted(chosen, key=lambda cell: cell.levels[self.figure.x])

    def experiment(self, cell: Cell) -> Experiment:
        """Experiment of a cell, without its preparations."""
        settings = [*cell.settings, *(each for preparation in self._study.prepare.values()
                                      for each in preparation.meanwhile)]
        return self._resolver.experiment(cell.experiment, settings, self._study.about.seed)

    def loops(self, cells: list[Cell]) -> list[LinearLoop]:
        """Linear loops of cells; none unless all are."""
        try:
            return [linear_loop(self.experiment(cell)) for cell in cells]
        except InputError:
            return []


def _at_rest(rows: _Rows, panel: AxisLevel | None, line: AxisLevel | None) -> Iterator[Overlay]:
    """The exact cost along x; no point where the loop is not stable."""
    figure = rows.figure
    cells = rows.along_x({figure.panels: panel, figure.by: line})
    loops = rows.loops(cells)
    for cell in cells if loops else ():
        _require_at_rest(figure, rows.experiment(cell))
    costs = [(cell.levels[figure.x], stationary_cost(loop))
             for cell, loop in zip(cells, loops, strict=False)]
    places: list[tuple[Any, float]] = [(x, _of_metric(figure, rows.metric.path, cost))
                                       for x, cost in costs if cost.stable]
    if places:
        yield Overlay(label=f"{_AT_REST} ({rows.theory})", x=[x for x, _ in places],
                      y=[y for _, y in places], panel=panel, line=line)


def _of_metric(figure: Figure, path: tuple[str, ...], cost: StationaryCost) -> float:
    """Value of a metric at rest, deg. Raises InputError for a metric that theory does not cover."""
    if path == ("joint_rmse_deg",):
        return cost.joint_rms_deg
    if len(path) == 3 and (path[0], path[2]) == ("joints", "joint_rmse_deg") and path[1] in cost.names:
        return float(cost.rms_deg[cost.names.index(path[1])])
    raise InputError(f"figure {figure.name}: theory", f"'stationary_cost' says nothing of {'.'.join(path)}",
                     "joint_rmse_deg, or joints.NAME.joint_rmse_deg", 'take theory = "none"')


def _require_at_rest(figure: Figure, experiment: Experiment) -> None:
    """Raise InputError for a loop that is not at its reference on average: error is more than its spread."""
    why = ""
    for node in experiment.wiring.nodes:
        if any(np.any(getattr(node.part, key, 0.0)) for key in ("bias_deg", "drift_deg_s")):
            why = f"{node.name} has a bias or drifts"
    name, _, port = (experiment.score.reference or "").partition(".")
    for node in experiment.wiring.nodes:
        if node.name == name and is_source(node) and node.clock is not None:
            ports = [each.name for each in node.part.outputs]
            values = put_out(experiment.wiring, node, ports.index(port), experiment.duration_ns)
            first = sum(node.clock.tick(k) < experiment.score.after_s * NS_PER_S for k in range(len(values)))
            why = f"{name} moves" if np.ptp(values[first:], axis=0).any() else why
    if why:
        raise InputError(f"figure {figure.name}: theory",
                         f"'stationary_cost' is the spread about rest, and {why}",
                         "a constant reference from score.after_s on, and no bias", 'take theory = "none"')


def _critical(rows: _Rows, panel: AxisLevel | None, line: AxisLevel | None) -> Iterator[Overlay]:
    """Critical latencies: along y in a heat map, else upright."""
    figure = rows.figure
    found = []
    for y in rows.levels(figure.y):
        cells = rows.along_x({figure.panels: panel, figure.by: line, figure.y: y})
        loops = rows.loops(cells)
        if loops:
            critical_ms = _critical_ms(rows, cells, loops)
            found += [(critical_ms, y)] if critical_ms is not None else []
    if found and figure.y is not None:
        yield Overlay(label=f"{_CRITICAL} ({rows.theory})", x=[x for x, _ in found], panel=panel, line=line,
                      y=[float(y) for _, y in found if y is not None])
    elif found:
        yield Overlay(label=f"{_CRITICAL} ({rows.theory})", x=[found[0][0]], panel=panel, line=line)


def _critical_ms(rows: _Rows, cells: list[Cell], loops: list[LinearLoop]) -> float | None:
    """The least latency at which the loop is unstable; None where it is stable up to the last x.

    Under jitter or loss, where growth takes long to compute, it is searched level by level.
    """
    wire = _wire_along_x(rows.figure, cells, loops)
    places = [loop.wire(wire).wire.latency_ns for loop in loops]
    if not loops[0].random and places[-1]:
        return critical_latency_ms(loops[0], wire, places[-1] / NS_PER_MS)
    unstable = next((i for i, loop in enumerate(loops) if growth(loop) >= 1.0), None)
    if unstable is None:
        return None
    high = places[unstable]
    low = places[unstable - 1] if unstable else 0
    while high - low > _WITHIN_NS:
        middle = (low + high) // 2
        if growth(loops[0].with_latency(wire, middle)) >= 1.0:
            high = middle
        else:
            low = middle
    return high / NS_PER_MS


def _wire_along_x(figure: Figure, cells: list[Cell], loops: list[LinearLoop]) -> str:
    """The one wire on the loop whose latency is x. Raises InputError where there is not one."""
    names = [[c.wire.name for c in loop.connections
              if c.wire.latency_ns == round(float(cell.levels[figure.x]) * NS_PER_MS)]
             for cell, loop in zip(cells, loops, strict=True)]
    common = set(names[0]).intersection(*names[1:])
    if len(cells) < 2 or len(common) != 1:
        raise InputError(f"figure {figure.name}: theory", f"{figure.x} is the latency of {len(common)} wires",
                         "of one wire of the loop, at two levels or more", 'take theory = "none"')
    return common.pop()


def keep_overlays(folder: Path, created: str, overlays: Mapping[str, Sequence[Overlay]]) -> None:
    """Write the overlays of a study's figures, by figure, into the folder of its store.

    `created`: when the store was, which distinguishes it from a later one in its place. Raises
    InputError where the file cannot be written.
    """
    path = folder / THEORY
    tables = {name: [asdict(overlay) for overlay in each] for name, each in overlays.items()}
    try:
        path.write_text(json.dumps({"created": created, "figures": tables}), encoding="utf-8")
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror}",
                         "a folder that can be written") from None


def kept_overlays(folder: Path, created: str) -> dict[str, list[Overlay]]:
    """The overlays by figure; none where none were kept, or those of another store.

    Raises InputError for a file that cannot be read or is damaged.
    """
    path = folder / THEORY
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["created"] != created:
            return {}
        return {str(name): [Overlay(**table) for table in tables]
                for name, tables in found["figures"].items()}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as fault:
        raise InputError(str(path), f"cannot be read: {fault}", "lines that `fesloop study` kept",
                         "remove it, and start the study again: no run is run twice") from None

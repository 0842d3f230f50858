"""Figures of a study, written as PNG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.results.study_results import StudyResults
from fesloop.errors import FesloopError, InputError, InputErrors
from fesloop.show.figures.content import Content, Overlay
from fesloop.show.figures.curves import curves
from fesloop.show.figures.heat_maps import heat_map


def draw(results: StudyResults, figure: Figure, folder: str | Path, overlays: Sequence[Overlay] = ()) -> Path:
    """Draw a figure of a study's results into `folder`; return the path of the file, NAME.png.

    `overlays` are lines over it, such as theory's. Raises InputError for a figure of axes or metrics that the
    study lacks, or without any planned run, for an overlay that does not fit, where matplotlib is not
    installed, and where the file cannot be written.
    """
    faults = figure.faults(tuple(results.axes), results.metrics)
    if faults:
        raise InputErrors([InputError(f"figure {figure.name}: {fault.where}", fault.found, fault.allowed,
                                      fault.remedy) for fault in faults])
    content = Content.of(results, figure, overlays)
    _require_matplotlib()
    drawing = heat_map(content) if figure.kind == "heat_map" else curves(content)
    path = Path(folder) / f"{figure.name}.png"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        drawing.savefig(path)
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror}",
                         "a folder that can be written") from None
    return path


def _require_matplotlib() -> None:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: F401
    except ImportError:
        raise InputError("figures", "matplotlib is not installed", "matplotlib 3.8 or later",
                         "pip install matplotlib") from None


def draw_all(results: StudyResults, study: Study, folder: Path) -> tuple[list[Path], dict[str, FesloopError]]:
    """Draw a study's figures and keep their theoretical curves for reports.

    Returns the files, and why others, by name of the figure, cannot be drawn.
    """
    from fesloop.show.figures.theory_overlays import keep_overlays, theory_overlays

    drawn: list[Path] = []
    theory: dict[str, list[Overlay]] = {}
    faults: dict[str, FesloopError] = {}
    for figure in study.figures:
        try:
            theory[figure.name] = list(theory_overlays(study, figure))
            drawn.append(draw(results, figure, folder, theory[figure.name]))
        except FesloopError as fault:
            faults[figure.name] = fault
    if any(theory.values()):
        keep_overlays(folder, results.about.get("created", ""), theory)
    return drawn, faults

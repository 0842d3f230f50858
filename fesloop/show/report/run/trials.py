"""Error per trial: the learning curve, by joint, and every metric in a table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fesloop.experiment.metrics.not_known import NOT_KNOWN
from fesloop.show.report.parts import Bars, Chart, Line, Part, Section, Table
from fesloop.show.report.run.axes import from_zero
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.words import joint_label, metric_label, told

_MOST_ROWS, _MOST_JOINTS = 60, 8
"""Of a table, and lines of a chart (chosen: what a reader takes in)."""


def trials_section(known: Known) -> Section | None:
    """None where nothing has a number a trial."""
    parts = [*_curves(known), *_tables(known)]
    title = "Error per trial" if known.begun > 1 else "Metrics"
    return Section(key="trials", title=title, parts=parts) if parts else None


def learning_curve(known: Known, key: str) -> Chart | None:
    """Tracking error over all joints by trial; None for less than two trials, or no error."""
    errors = known.per_trial("joint_rmse_deg")
    if len(errors) < 2:
        return None
    number = np.arange(float(len(errors)))
    lines = [Line(name="truth against reference", role="truth", x=number, y=np.array(errors))]
    seen = known.per_trial("tracker_rmse_deg")
    if len(seen) == len(errors):
        lines.append(Line(name="tracker against truth", role="tracker", x=number, y=np.array(seen)))
    return Chart(key=key, title="Error by trial, RMS over all scored joints", x_label="trial",
                 y_label="error, deg", lines=lines, limits=from_zero(lines),
                 text=f"Tracking error by trial, deg: {', '.join(map(told, errors))}.")


def _curves(known: Known) -> Iterator[Part]:
    joints: dict[str, Any] = known.metrics.get("joints") or {}
    errors = {name: table["joint_rmse_deg"] for name, table in joints.items() if "joint_rmse_deg" in table}
    if not errors:
        return
    if known.begun < 2:
        yield Bars(key="trials-joints", title="Error by joint, RMS", x_label="error, deg",
                   names=[joint_label(name) for name in errors],
                   values={"truth against reference": [values[0] for values in errors.values()]},
                   roles={"truth against reference": "truth"}, stacked=False,
                   text="Error of each joint against its reference.")
        return
    worst = sorted(errors, key=lambda name: -np.nan_to_num(errors[name]).max())[:_MOST_JOINTS]
    lines = [Line(name=joint_label(name), role=f"series-{number}", x=np.arange(float(len(errors[name]))),
                  y=np.array(errors[name], dtype=np.float64))
             for number, name in enumerate(name for name in errors if name in worst)]
    more = f" ({len(lines)} of {len(errors)}, those with the greatest)" if len(lines) < len(errors) else ""
    yield Chart(key="trials-joints", title=f"Error by trial and joint, RMS{more}", x_label="trial",
                y_label="error, deg", lines=lines, limits=from_zero(lines),
                text="Error of each joint against its reference, by trial.")


def _tables(known: Known) -> Iterator[Part]:
    """Metrics that have a value a trial, side by side."""
    columns = {label: values for name, metric in known.metrics.items() if name not in ("joints", NOT_KNOWN)
               for label, values in _by_trial(name, metric, known.begun)}
    if not columns:
        return
    shown = list(range(known.begun))
    if len(shown) > _MOST_ROWS:
        shown = [*shown[:_MOST_ROWS // 2], *shown[-_MOST_ROWS // 2:]]
    rows = [[str(trial), *(told(values[trial]) for values in columns.values())] for trial in shown]
    left_out = known.begun - len(shown)
    title = "By trial" + (f" (without {left_out} trials in the middle)" if left_out else "")
    if known.begun > 1:
        yield Table(title=title, columns=["trial", *columns], rows=rows)
    else:
        values = [[label, told(metric[0])] for label, metric in columns.items()]
        yield Table(columns=["metric", "value"], rows=values)


def _by_trial(name: str, metric: Any, trials: int) -> Iterator[tuple[str, list[Any]]]:
    """Columns of a metric, those with a plain value a trial."""
    if isinstance(metric, dict):
        for part, inner in metric.items():
            for label, values in _by_trial(name, inner, trials):
                stem, comma, unit = label.partition(", ")
                yield f"{stem} {part}{comma}{unit}", values
    elif isinstance(metric, list) and len(metric) == trials \
            and not any(isinstance(value, (list, dict)) for value in metric):
        yield metric_label(name), metric

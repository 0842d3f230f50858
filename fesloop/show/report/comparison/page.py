"""Report page that compares several runs: summary, metrics and errors."""


from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from fesloop.analysis.study.results.quantities import called, with_unit
from fesloop.errors import FesloopError, InputError
from fesloop.experiment.metrics.missing import MISSING
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.trouble import KINDS, troubles
from fesloop.show.report.comparison.compared import Compared, compared, finite
from fesloop.show.report.comparison.differences import differences_section
from fesloop.show.report.comparison.joints import joints_section
from fesloop.show.report.parts import Bars, Chart, Fold, Line, Notice, Page, Paragraph, Part, Section, Table
from fesloop.show.report.run.words import counted, listed, metric_label, rounded

_ERRORS = (("joint_rmse_deg", "Error of the joints against the reference"),
           ("tracker_rmse_deg", "Error of the tracker against the truth"))
_BY_JOINT, _STEPS = "joints", "step_us"
Scored = dict[str, Any]


def metrics_section(runs: Sequence[Compared]) -> Section:
    """Section with the metrics of each run's last trial; metrics by joint are folded."""
    flat = [dict(_flat(run.known.metrics)) for run in runs]
    keys = list(dict.fromkeys(key for each in flat for key in each))
    shown = [key for key in keys if not key.startswith((f"{_BY_JOINT} ", f"{_STEPS} "))]
    folded = [key for key in keys if key not in shown]
    columns = ["metric", *(run.name for run in runs)]
    parts: list[Part] = [Paragraph(text="Values are of the last trial of each run.")] if any(
        run.known.begun > 1 for run in runs) else []
    if shown:
        parts.append(Table(columns=columns, rows=[_row(key, flat) for key in shown]))
    else:
        parts.append(Notice(text="No run is scored."))
    parts += _not_comparable(runs, flat)
    if folded:
        parts.append(Fold(title="By joint, and execution times", parts=[
            Table(columns=columns, rows=[_row(key, flat) for key in folded])]))
    return Section(key="metrics", title="Metrics side by side", parts=parts)


def _flat(metrics: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Metrics by their paths, of lists the last: one a trial."""
    for name, value in metrics.items():
        if name == MISSING:
            continue
        place = f"{path} {name}".strip()
        if isinstance(value, Mapping):
            yield from _flat(value, place)
        elif not isinstance(value, (list, tuple)):
            yield place, value
        elif value and not isinstance(value[-1], (list, tuple, Mapping)):
            yield place, value[-1]


def _row(key: str, flat: Sequence[Scored]) -> list[str]:
    return [_label(key), *(rounded(each.get(key)) for each in flat)]


def _label(key: str) -> str:
    """A metric's path in words, its unit last: "split RMSE total, deg"."""
    parts = [called(part) for part in key.removeprefix(f"{_BY_JOINT} ").split(" ")]
    unit = next((unit for _, unit in parts if unit), "")
    return with_unit(" ".join(text for text, _ in parts), unit)


def _not_comparable(runs: Sequence[Compared], flat: Sequence[Scored]) -> Iterator[Part]:
    """Runs that are scored otherwise than the others."""
    unscored = [run.name for run, each in zip(runs, flat, strict=True) if not each]
    if unscored:
        yield Notice(text=f"Not scored: {listed(unscored)}.")
    whiles = {run.name: run.known.scored_span_s() for run in runs if run.name not in unscored}
    if len(set(whiles.values())) > 1:
        each = "; ".join(f"{name} from {after:g} s{' on' if end is None else f' to {end:g} s'}"
                         for name, (after, end) in whiles.items())
        yield Notice(text=f"Runs are scored over different parts of a trial: {each}.")


def trials_section(runs: Sequence[Compared]) -> Section | None:
    """Errors per trial over each other; bars where there is one trial each; None where nothing has errors."""
    parts: list[Part] = []
    for metric, title in _ERRORS:
        errors = {run: run.known.per_trial(metric) for run in runs}
        having = {run: values for run, values in errors.items() if finite(values)}
        if not having:
            continue
        parts.append(_over_trials(metric, title, having) if max(map(len, having.values())) > 1
                     else _beside(metric, title, having))
        if len(having) < len(runs):
            lacking = listed([run.name for run in runs if run not in having])
            parts.append(Notice(text=f"Without {metric_label(metric)}: {lacking}."))
    return Section(key="trials", title="Error per trial", parts=parts) if parts else None


def _over_trials(metric: str, title: str, having: Mapping[Compared, Sequence[float]]) -> Chart:
    lines = [Line(name=run.name, role=run.role, x=np.arange(float(len(values))), y=np.array(values))
             for run, values in having.items()]
    ends = "; ".join(f"{run.name} {rounded(values[0])} to {rounded(values[-1])}"
                     for run, values in having.items())
    highest = max(float(np.nanmax(line.y)) for line in lines)
    return Chart(key=f"trials-{metric}", title=f"{title}, RMS", x_label="trial", y_label="error, deg",
                 lines=lines, limits=(0.0, 1.05 * highest or 1.0), text=f"First to last trial, deg: {ends}.")


def _beside(metric: str, title: str, having: Mapping[Compared, Sequence[float]]) -> Bars:
    values = [run_values[0] for run_values in having.values()]
    return Bars(key=f"trials-{metric}", title=f"{title}, RMS", x_label="error, deg",
                names=[run.name for run in having], values={"error": values}, roles={"error": "truth"},
                stacked=False, text=", ".join(f"{run.name} {rounded(value)} deg"
                                              for run, value in zip(having, values, strict=True)) + ".")


def sentence_of(runs: Sequence[Compared]) -> str:
    """Summary: what went wrong, and the runs with the least and the greatest error."""
    return " ".join([*_troubles(runs), _errors(runs)])


def _troubles(runs: Sequence[Compared]) -> list[str]:
    """The most important thing that went wrong in each run, the gravest of them first."""
    first = [(run, found[0]) for run in runs if (found := troubles(run.known.recording, run.known.metrics))]
    first.sort(key=lambda pair: KINDS.index(pair[1].kind))
    return [f"In {run.name}, {trouble.text}." for run, trouble in first]


def _errors(runs: Sequence[Compared]) -> str:
    """Sentence on the runs with the least and the greatest error."""
    names = sorted({run.recording.name for run in runs})
    begin = f"{counted(len(runs), 'run')} of {listed([f'`{name}`' for name in names])}."
    for metric, title in _ERRORS:
        errors = {run.name: run.last_error(metric) for run in runs}
        known = {name: error for name, error in errors.items() if np.isfinite(error)}
        if len(known) > 1:
            best, worst = min(known, key=known.__getitem__), max(known, key=known.__getitem__)
            last = _in_last_trial([run for run in runs if run.name in known])
            if known[best] == known[worst]:
                return f"{begin} {title} is {rounded(known[best])} deg RMS in all of them{last}."
            return (f"{begin} {title} is least in {best}, {rounded(known[best])} deg RMS{last}, and greatest "
                    f"in {worst}, {rounded(known[worst])} deg.")
    return f"{begin} The runs have no common error of joints."


def _in_last_trial(runs: Sequence[Compared]) -> str:
    """Words for the trial that is compared."""
    begun = [run.known.begun for run in runs]
    if max(begun) == 1:
        return ""
    if min(begun) == max(begun):
        return f" in the last of {counted(begun[0], 'trial')}"
    return f" in the last trial of each ({listed([f'{run.known.last} of {run.name}' for run in runs])})"


Build = Callable[[Sequence[Compared]], Section | None]
_SECTIONS: tuple[tuple[str, str, Build], ...] = (
    ("trials", "Error per trial", trials_section),
    ("differences", "Differences", differences_section),
    ("metrics", "Metrics side by side", metrics_section),
    ("joints", "Joints in the last trial", joints_section),
)


@np.errstate(all="ignore")  # a damaged file may hold any number
def comparison_page(recordings: Sequence[Recording]) -> Page:
    """The report of runs side by side, of one experiment or of several.

    What cannot be compared is said where it would stand. Raises InputError for fewer than two recordings.
    """
    if len(recordings) < 2:
        raise InputError("recordings", f"{len(recordings)} to be compared", "two or more")
    runs = compared(recordings)
    sections = [section for each in _SECTIONS for section in _built(runs, *each)]
    said = [Notice(text=f"{run.name}: {each}") for run in runs for each in run.known.lacks]
    if said:
        sections.insert(0, Section(key="lacking", title="Unreadable parts", parts=said))
    sections.append(_ran(runs))
    names = sorted({recording.name for recording in recordings})
    facts = [(run.name, f"{run.recording.status}, seed {run.recording.seed}") for run in runs]
    return Page(title=f"{' and '.join(names)}: {len(runs)} runs", sentence=sentence_of(runs),
                sections=sections, facts=facts)


def _built(runs: Sequence[Compared], key: str, title: str, build: Build) -> Iterator[Section]:
    """Build a section; if that fails, a notice takes its place and the other sections are unaffected."""
    try:
        section = build(runs)
        if section is not None:
            yield section
    except Exception as fault:  # noqa: BLE001 - whatever files hold: the rest of the page is worth having
        kind = "" if isinstance(fault, FesloopError) else f"{type(fault).__name__}: "
        yield Section(key=key, title=title, parts=[
            Notice(text=f"This cannot be shown: {kind}{' '.join(str(fault).split())}")])


def _ran(runs: Sequence[Compared]) -> Section:
    columns = ["run", "experiment", "seed", "trials", "status", "fingerprint", "fesloop", "file"]
    rows = [[run.name, run.recording.name, str(run.recording.seed), str(run.known.begun),
             run.recording.status, run.recording.fingerprint[:12],
             run.recording.versions.get("fesloop", "?"), str(run.recording.path)] for run in runs]
    return Section(key="ran", title="Experiment", parts=[Table(columns=columns, rows=rows)])

"""Several runs on one page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from fesloop.errors import FesloopError, InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.comparison.compared import Compared, compared
from fesloop.show.report.comparison.differences import differences_section
from fesloop.show.report.comparison.joints import joints_section
from fesloop.show.report.comparison.scored import metrics_section, sentence_of, trials_section
from fesloop.show.report.parts import Notice, Page, Section, Table

Build = Callable[[Sequence[Compared]], Section | None]
_SECTIONS: tuple[tuple[str, str, Build], ...] = (
    ("trials", "Error per trial", trials_section),
    ("differences", "What differs", differences_section),
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
        sections.insert(0, Section(key="lacking", title="What could not be read", parts=said))
    sections.append(_ran(runs))
    names = sorted({recording.name for recording in recordings})
    facts = [(run.name, f"{run.recording.status}, seed {run.recording.seed}") for run in runs]
    return Page(title=f"{' and '.join(names)}: {len(runs)} runs", sentence=sentence_of(runs),
                sections=sections, facts=facts)


def _built(runs: Sequence[Compared], key: str, title: str, build: Build) -> Iterator[Section]:
    """A section; one that fails says so in its place, and takes no other with it."""
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
    return Section(key="ran", title="What was run", parts=[Table(columns=columns, rows=rows)])

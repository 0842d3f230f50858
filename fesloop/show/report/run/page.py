"""Report page of one run, made from the recording alone."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from fesloop.errors import FesloopError
from fesloop.experiment.files.patients import describe
from fesloop.experiment.recording.reading import Recording
from fesloop.show.best_trial import telling_s
from fesloop.show.report.parts import Figure3d, Notice, Page, Section
from fesloop.show.report.recorded_hand import TRUTH
from fesloop.show.report.run.events import events_section
from fesloop.show.report.run.experiment import experiment_section
from fesloop.show.report.run.fatigue import fatigue_section
from fesloop.show.report.run.intention import intention_section
from fesloop.show.report.run.known import Known, known_of
from fesloop.show.report.run.latency import latency_section
from fesloop.show.report.run.lateness import lateness_section
from fesloop.show.report.run.result import result_section, split_section, trials_section
from fesloop.show.report.run.search import search_sections
from fesloop.show.report.run.sentence import sentence_of
from fesloop.show.report.run.stimulation import stimulation_section
from fesloop.show.report.run.tracker import tracker_section
from fesloop.show.report.run.tracking import tracking_section
from fesloop.show.report.run.words import counted


def hand_section(known: Known) -> Section | None:
    """Section with the moving hand; None if no posture of a hand is recorded."""
    from fesloop.show.report.motion import hand_motion

    figure = hand_motion(known.recording)
    return None if figure is None else Section(key="hand", title="The hand", parts=[figure])


Progress = Callable[[float], None]
Build = Callable[[Known], Section | None]


def _search_section(known: Known) -> Section | None:
    """Section on a point search; None for a run without one."""
    parts = [part for section in search_sections(known.recording) for part in section.parts]
    return Section(key="search", title="The search", parts=parts) if parts else None


_SECTIONS: tuple[tuple[str, str, Build], ...] = (
    ("result", "Result", result_section),
    ("hand", "The hand", hand_section),
    ("search", "The search", _search_section),
    ("trials", "Error per trial", trials_section),
    ("tracking", "Tracking by joint", tracking_section),
    ("intention", "Intention", intention_section),
    ("split", "Error: the tracker's share and the controller's", split_section),
    ("stimulation", "Stimulation", stimulation_section),
    ("latency", "Latency budget", latency_section),
    ("tracker", "Tracker quality", tracker_section),
    ("fatigue", "Fatigue", fatigue_section),
    ("events", "Statuses and events", events_section),
    ("lateness", "Real time", lateness_section),
    ("experiment", "Experiment", experiment_section),
)


@np.errstate(all="ignore")  # a damaged file may hold any number
def run_page(recording: Recording, notices: Sequence[str] = (),
             progress: Progress = lambda fraction: None) -> Page:
    """Report page of one run. A section that fails is replaced by a notice; nothing is raised.

    `notices`: parts known to be missing in the file. `progress` receives the fraction done.
    """
    sections = []
    known = known_of(recording)
    for number, (key, title, build) in enumerate(_SECTIONS):
        sections += list(_built(known, key, title, build))
        progress((number + 1) / len(_SECTIONS))
    said = [*notices, *known.lacks]
    if said:
        notes = [Notice(text=each) for each in said]
        sections.insert(0, Section(key="lacking", title="Unreadable parts", parts=notes))
    return Page(title=_title(recording), sentence=_headline(known), facts=list(_facts(known)),
                sections=sections, trials=known.trials if known.begun > 1 else (),
                shown=known.best if known.begun > 1 else 0, at_s=_telling_s(known, sections))


def _headline(known: Known) -> str:
    """Summary of the run, which names the trial that the page opens with if that is not the last."""
    sentence = sentence_of(known)
    named = known.begun < 2 or known.best == known.last or re.search(rf"\btrial {known.best}\b", sentence)
    return sentence if named else f"{sentence} Trial {known.best}, the best, is shown first."


def _telling_s(known: Known, sections: Sequence[Section]) -> float | None:
    """Instant at which the hand of the trial that the page opens with is shown; None without a hand."""
    parts = (part for section in sections for part in section.parts)
    figure = next((part for part in parts if isinstance(part, Figure3d)), None)
    frames = None if figure is None else figure.trials.get(known.best)
    if frames is None or not frames.hands:
        return None
    poses = frames.hands.get(TRUTH, next(iter(frames.hands.values())))
    times_s = frames.start_s + frames.step_s * np.arange(len(poses), dtype=np.float64)
    return telling_s(known.score, times_s, poses[..., 4:])


def _built(known: Known, key: str, title: str, build: Build) -> Iterator[Section]:
    """Build a section; if that fails, a notice takes its place and the other sections are unaffected."""
    try:
        section = build(known)
    except FesloopError as fault:
        text = f"This cannot be shown: {' '.join(str(fault).split())}"
    except Exception as fault:  # noqa: BLE001 - whatever a file holds, the rest is worth having
        text = f"This cannot be shown: {type(fault).__name__}: {' '.join(str(fault).split())}"
    else:
        if section is not None:
            yield section
        return
    yield Section(key=key, title=title, parts=[Notice(text=text)])


def _title(recording: Recording) -> str:
    return f"{recording.name} ({recording.path.name})"


def _facts(known: Known) -> Iterator[tuple[str, str]]:
    """Facts under the title."""
    recording = known.recording
    about = recording.experiment.get("experiment", {})
    lasts = f" of {known.duration_s:g} s" if known.duration_s is not None else ""
    planned = about.get("trials", known.begun)
    begun = "" if planned == known.begun else f", {known.begun} begun"
    numbered = ", numbered from 0" if planned > 1 else ""
    yield "experiment", f"{recording.name}: {counted(planned, 'trial')}{lasts}{numbered}{begun}"
    patient = recording.experiment.get("patient")
    if patient:
        yield "patient", describe({**patient, "file": Path(patient["file"]).stem})
    yield "seed", str(recording.seed)
    yield "status", recording.status
    wall = recording.wall
    started = str(wall.get("started", "?")).replace("T", " ").replace("+00:00", " UTC")
    yield "run", f"{started}, {wall.get('seconds', 0.0):.1f} s on {wall.get('machine', '?')}"
    versions = recording.versions
    yield "versions", ", ".join(f"{name} {versions[name]}" for name in ("fesloop", "python", "numpy")
                                if name in versions)
    yield "fingerprint", recording.fingerprint[:16]

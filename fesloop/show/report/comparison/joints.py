"""Joints of the same name over each other, at the last trial of each run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fesloop.errors import FesloopError
from fesloop.show.report.comparison.compared import Compared
from fesloop.show.report.parts import Chart, Fold, Line, Notice, Paragraph, Part, Section
from fesloop.show.report.run.thinning import Course, course
from fesloop.show.report.run.words import counted, joint_label, listed

_TO_DEG = float(np.degrees(1.0))
_FEW = 6
"""Joints that are shown at once, those that some run is to move; the others are folded (chosen)."""
_MOVES_RAD = 0.02
"""Least range of a reference that is meant to move its joint (chosen: a degree)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Courses:
    """Truth and reference of one run's last trial; its joints by name."""

    run: Compared
    truth: Course
    reference: Course | None
    joints: tuple[str, ...]

    def line(self, joint: str) -> Line:
        """The true angle of a joint."""
        return self.truth.line(self.run.name, self.run.role, self.joints.index(joint), _TO_DEG)

    def wanted(self, joint: str) -> Line | None:
        """Reference of the joint; None without one."""
        if self.reference is None:
            return None
        line = self.reference.line("reference", "reference", self.joints.index(joint), _TO_DEG, "dashed")
        return line if np.isfinite(line.y).any() else None


def joints_section(runs: Sequence[Compared]) -> Section | None:
    """Section on joints; None if no joint occurs in two runs."""
    found, lost = [], []
    for run in runs:
        try:
            courses = _courses_of(run)
        except FesloopError as fault:
            lost.append(f"{run.name}: {' '.join(str(fault).split())}")
            continue
        if courses is None:
            lost.append(f"{run.name}: no scored signal of joint angles is recorded")
        else:
            found.append(courses)
    parts: list[Part] = [Notice(text=f"Not drawn here: {'; '.join(lost)}.")] if lost else []
    every = list(dict.fromkeys(joint for each in found for joint in each.joints))
    common = [joint for joint in every if sum(joint in each.joints for each in found) > 1]
    if not common:
        return None if len(found) < 2 else Section(key="joints", title="Joints", parts=[
            *parts, Notice(text="No joint occurs in two runs.")])
    alone = [joint_label(joint) for joint in every if joint not in common]
    if alone:
        parts.append(Paragraph(text=f"Joints of a single run, which are not drawn: {listed(alone)}."))
    moved = [joint for joint in common if any(_moves(each, joint) for each in found)]
    first = (moved or common)[:_FEW]
    rest = [joint for joint in common if joint not in first]
    parts += [_chart(joint, found) for joint in first]
    if rest:
        parts.append(Fold(title=counted(len(rest), "more joint"),
                          parts=[_chart(joint, found) for joint in rest]))
    return Section(key="joints", title="Joints in the last trial", parts=parts)


def _courses_of(run: Compared) -> _Courses | None:
    truth, reference = run.known.scored("truth"), run.known.scored("reference")
    if not truth or not run.known.begun:
        return None
    true = course(run.recording, truth, run.known.last)
    if true is None or true.mean.ndim != 2:
        return None
    wanted = course(run.recording, reference, run.known.last) if reference else None
    if wanted is not None and wanted.mean.shape[1:] != true.mean.shape[1:]:
        wanted = None
    return _Courses(run, true, wanted, run.known.joints(true.mean.shape[1]))


def _moves(courses: _Courses, joint: str) -> bool:
    if courses.reference is None or joint not in courses.joints:
        return False
    asked = courses.reference.mean[:, courses.joints.index(joint)]
    known = asked[np.isfinite(asked)]
    return bool(known.size) and float(np.ptp(known)) > _MOVES_RAD


def _chart(joint: str, found: Sequence[_Courses]) -> Chart:
    """True angles of every run; the reference once if they share it, else of each."""
    having = [each for each in found if joint in each.joints]
    return Chart(key=f"joint-{joint}", title=joint_label(joint), x_label="time, s", y_label="angle, deg",
                 lines=[*_references(joint, having), *(each.line(joint) for each in having)],
                 text=f"Angle of {joint_label(joint)} in {listed([each.run.name for each in having])}.")


def _references(joint: str, having: Sequence[_Courses]) -> Iterator[Line]:
    wanted = [(each, line) for each in having if (line := each.wanted(joint)) is not None]
    shared = all(_alike(line, wanted[0][1]) for _, line in wanted)
    for each, line in wanted[:1] if shared else wanted:
        yield Line(name="reference" if shared else f"reference of {each.run.name}", x=line.x, y=line.y,
                   role="reference" if shared else each.run.role, style="dashed", thinned=line.thinned)


def _alike(one: Line, other: Line) -> bool:
    return one.x.shape == other.x.shape and np.allclose(one.x, other.x) and np.allclose(
        one.y, other.y, equal_nan=True)

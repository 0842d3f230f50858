"""Report of a recording of stimulated muscle."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fesloop.show.picture.stimulation import chosen_forces, joint_label, muscles_of
from fesloop.show.report.parts import Chart, Fold, Line, Notice, Page, Paragraph, Part, Section, Table
from fesloop.streams.stimulation.features import (
    CLEAR,
    baselines,
    by_repeat,
    principal_joint,
    recruitment_curve,
    shown_joint,
)
from fesloop.streams.stimulation.recording import Array, SteadyTrials, StimulationRecording
from fesloop.streams.stimulation.summary import doubts_about

_MOST_MOVEMENTS, _POINTS = 60, 1000


def stimulation_page(recording: StimulationRecording, path: Path) -> Page:
    """Page of a recording: scatter and torque over posture, recruitment, change over the session, force."""
    sections = [section for section in (
        _about(recording), _posture(recording), _recruitment(recording), _drift(recording),
        _movements(recording), _forces(recording)) if section is not None]
    facts = [("person", recording.person), ("side", recording.side or "not stated"),
             ("pulses", f"{recording.frequency_hz:.4g} Hz"), ("muscles", ", ".join(recording.muscles)),
             ("joints, named after +", ", ".join(map(joint_label, recording.joints)) or "none"),
             ("source", f"{recording.source} ({recording.source_format})")]
    return Page(title=path.name, sentence=_sentence(recording), facts=facts, sections=sections)


def _sentence(recording: StimulationRecording) -> str:
    """Summarise the recording in a sentence: evoked torque over a repeat's scatter, if there are trials."""
    trials = recording.steady
    if trials is not None and len(trials.cells()):
        snr = trials.repeatability().snr
        known = np.isfinite(snr)
        if known.any():
            stated = ", ".join(f"{joint_label(joint)} {value:.1f}" for joint, value, there in zip(
                recording.joints, snr, known, strict=True) if there)
            return f"{recording.person}: evoked torque over the scatter of a repeat is {stated}."
        return f"{recording.person}: {len(trials)} isometric trials, none repeated; their scatter is unknown."
    if recording.forces:
        peak = max(float(np.nanmax(course.force_n)) for course in recording.forces)
        return f"{recording.person}: {len(recording.forces)} recordings of force, up to {peak:.3g} N."
    return (f"{recording.person}: {len(recording.courses)} courses of torque and {len(recording.movements)} "
            "movements, no isometric trials.")


def _about(recording: StimulationRecording) -> Section | None:
    parts: list[Part] = [Notice(text=f"The recording {doubt}.") for doubt in doubts_about(recording).values()]
    if recording.notes:
        parts.append(Paragraph(text=recording.notes))
    rows = [[name, *(f"{factor * value:.4g}" if np.isfinite(value) else "-" for factor, value in (
        (1e3, recording.width_current_a[m]), (1e6, recording.lowest_width_s[m]),
        (1e6, recording.highest_width_s[m]))), recording.electrodes.get(name, "-")]
        for m, name in enumerate(recording.muscles)]
    if any(row[1:] != ["-"] * 4 for row in rows):
        parts.append(Table(title="Pulses and electrodes", rows=rows, columns=[
            "muscle", "current, mA", "lowest width, us", "highest width, us", "electrodes"]))
    return Section(key="about", title="What was recorded", parts=parts) if parts else None


def _posture(recording: StimulationRecording) -> Section | None:
    trials = recording.steady
    if trials is None or not trials.stimulated.any():
        return None
    scatter = trials.repeatability()
    rows = [[joint_label(joint), *(f"{value:.2g}" if np.isfinite(value) else "-" for value in values)]
            for joint, *values in zip(recording.joints, scatter.sd_nm, scatter.rms_nm, scatter.snr,
                                      strict=True)]
    evoked = trials.evoked_nm
    principal = {muscle: principal_joint(trials, muscle) for muscle in muscles_of(trials)}
    charts = {(muscle, j): _over_posture(recording, trials, evoked, muscle, j)
              for muscle in principal for j in range(len(recording.joints))}
    parts: list[Part] = [
        Table(title="Evoked torque, N m", rows=rows, columns=[
            "joint", "sd of a repeat", "rms over muscles and postures", "their ratio"]),
        Paragraph(text="Each muscle at the joint at which its torque stands out most from the scatter of a "
                  "repeat. Points are repeats, the line is their mean with the standard deviation of a "
                  "repeat. The code of a posture has the rank of each joint's angle."),
        *(chart for (muscle, j), chart in charts.items() if principal[muscle] == j)]
    if len(recording.joints) > 1:
        parts.append(Fold(title="At the other joints", parts=[
            chart for (muscle, j), chart in charts.items() if principal[muscle] != j]))
    return Section(key="posture", title="Torque over posture", parts=parts)


def _over_posture(recording: StimulationRecording, trials: SteadyTrials, evoked: Array, muscle: int,
                  joint: int) -> Chart:
    """Torque of a muscle at a joint in every posture."""
    codes, sd = np.unique(trials.posture).tolist(), trials.repeatability().sd_nm[joint]
    rows = {code: found for code in codes if (found := trials.cells().get((muscle, code))) is not None}
    mean = np.array([evoked[rows[code], joint].mean() if code in rows else np.nan for code in codes])
    x = [float(codes.index(code)) for code, found in rows.items() for _ in found]
    y = [float(value) for found in rows.values() for value in evoked[found, joint]]
    name, band = recording.muscles[muscle], np.full(len(codes), sd if np.isfinite(sd) else 0.0)
    return Chart(
        key=f"posture-{muscle}-{joint}", title=f"{name}: {joint_label(recording.joints[joint])}",
        x_label="posture", y_label="evoked torque, N m", x_levels=codes,
        text=f"Torque of {name} at {joint_label(recording.joints[joint])} in {len(rows)} postures.",
        lines=[Line(name="repeats", role="plain", x=np.array(x), y=np.array(y), style="points"),
               Line(name="mean", role="series-0", x=np.arange(len(codes), dtype=float), y=mean,
                    low=mean - band, high=mean + band)])


def _recruitment(recording: StimulationRecording) -> Section | None:
    """Torque over pulse width in the ramps of courses, and each course over time."""
    charts: list[Part] = []
    courses: list[Part] = []
    for number, course in enumerate(recording.courses):
        title = f"{recording.muscles[course.muscle]}, {1e3 * course.current_a:g} mA"
        curve = recruitment_curve(course)
        if curve is not None:
            j = shown_joint(recording, course, curve)
            charts.append(Chart(
                key=f"ramp-{number}", title=f"{title}: {joint_label(recording.joints[j])}",
                x_label="pulse width, us", y_label="torque, N m",
                text=f"Torque over pulse width, mean of {curve.ramps} ramps.",
                lines=[Line(name=name, role=role, x=1e6 * curve.width_s, y=values[:, j], style=style)
                       for name, role, style, values in (
                           ("rising width", "series-0", "line", curve.up_nm),
                           ("falling width", "series-1", "dashed", curve.down_nm))]))
        evoked = _first_known(course.device_torque_nm) - course.device_torque_nm
        courses.append(_timed(f"course-{number}", f"{title}: {course.name}", "torque, N m", course.time_s, [
            (joint_label(joint), f"series-{j % 8}", evoked[:, j])
            for j, joint in enumerate(recording.joints)]))
    if not courses:
        return None
    text = ("Torque at the instant of its pulse width as commanded: the delay of stimulator and muscle and "
            "the friction of the device part the curves of rising and falling width.")
    return Section(key="recruitment", title="Recruitment", parts=[
        *([Paragraph(text=text), *charts] if charts else []),
        Fold(title="Courses of torque over time", parts=courses)])


def _first_known(values: Array) -> Array:
    """First number of each column; 0 for a column without any."""
    known = np.isfinite(values)
    return np.where(known.any(axis=0), values[known.argmax(axis=0), np.arange(values.shape[1])], 0.0)


def _timed(key: str, title: str, y_label: str, time_s: Array,
           lines: Sequence[tuple[str, str, Array]]) -> Chart:
    """Chart over time of at most some thousand samples of each line."""
    step = -(-len(time_s) // _POINTS)
    return Chart(key=key, title=title, x_label="s", y_label=y_label, text=title, lines=[
        Line(name=name, role=role, x=time_s[::step], y=values[::step]) for name, role, values in lines])


def _drift(recording: StimulationRecording) -> Section | None:
    trials = recording.steady
    if trials is None or not trials.stimulated.any() or trials.repeat.max() < 1:
        return None
    lines, unclear = [], []
    for number, muscle in enumerate(muscles_of(trials)):
        found, name = by_repeat(trials, muscle), recording.muscles[muscle]
        if not found.clear:
            unclear.append(name)
            continue
        visits = np.arange(len(found.mean_nm), dtype=float)
        lines.append(Line(name=f"{name}: {joint_label(recording.joints[found.joint])}",
                          role=f"series-{number % 8}", x=visits, y=found.mean_nm / found.mean_nm.mean()))
    rest = baselines(trials)
    timed = bool(np.isfinite(rest.time_s).all())
    parts: list[Part] = []
    if lines:
        most = max(len(line.x) for line in lines)
        parts.append(Chart(
            key="drift", title="Mean torque of muscles", x_label="visit of the same postures", lines=lines,
            y_label="torque over its mean", x_levels=[str(k + 1) for k in range(most)],
            text="Mean torque of each muscle in each visit of the same postures, over its mean."))
    if unclear:
        parts.append(Paragraph(text=f"Within {CLEAR:g} standard errors of 0, and not shown: "
                               + ", ".join(unclear) + "."))
    parts.append(Chart(
        key="baseline", title="Device torque of visits", x_label="min" if timed else "visit",
        y_label="median less mean of the posture, N m",
        text="Median device torque of each visit, less the mean of its posture's visits.",
        lines=[Line(name=joint_label(joint), role=f"series-{j % 8}", style="points",
                    x=rest.time_s / 60.0 if timed else rest.visit, y=rest.change_nm[:, j])
               for j, joint in enumerate(recording.joints)]))
    return Section(key="drift", title="Change over the session", parts=parts)


def _movements(recording: StimulationRecording) -> Section | None:
    if not recording.movements:
        return None

    def rms(values: Array) -> str:
        return " ".join(f"{np.sqrt(np.mean(column[np.isfinite(column)]**2)):.2f}"
                        if np.isfinite(column).any() else "-" for column in values.T)

    rows = [[each.name, f"{len(each.time_s) * each.period_s:.1f}",
             "yes" if (each.pulse_width_s > 0.0).any() else "no",
             rms(np.degrees(each.angle_rad - each.reference_rad)), rms(each.device_torque_nm),
             rms(each.planned_nm), ", ".join(f"{key} {value:g}" for key, value in each.settings.items())]
            for each in recording.movements[:_MOST_MOVEMENTS]]
    parts: list[Part] = [Table(rows=rows, columns=[
        "name", "s", "pulses", "error, deg rms", "device, N m rms", "planned for muscles, N m rms",
        "settings"])]
    if len(recording.movements) > _MOST_MOVEMENTS:
        parts.append(Notice(text=f"{len(recording.movements) - _MOST_MOVEMENTS} movements are omitted."))
    joints = ", ".join(map(joint_label, recording.joints))
    return Section(key="movements", title="Movements", parts=[
        Paragraph(text=f"Numbers of a cell are of the joints in order: {joints}."), Fold(
            title=f"{len(recording.movements)} movements", parts=parts)])


def _forces(recording: StimulationRecording) -> Section | None:
    if not recording.forces:
        return None
    kinds = sorted({course.kind for course in recording.forces})
    rows = []
    for kind in kinds:
        courses = [course for course in recording.forces if course.kind == kind]
        peaks = [float(np.nanmax(course.force_n)) for course in courses]
        lengths = [1e3 * float(each) for course in courses if np.isfinite(course.length_m).any()
                   for each in (np.nanmin(course.length_m), np.nanmax(course.length_m))]
        rows.append([kind or "-", str(len(courses)), f"{min(peaks):.3g} to {max(peaks):.3g}",
                     f"{min(lengths):.4g} to {max(lengths):.4g}" if lengths else "-",
                     f"{min(len(c.pulses_s) for c in courses)} to {max(len(c.pulses_s) for c in courses)}"])
    charts = [_timed(f"force-{number}", course.name, "force, N", course.time_s,
                     [("force", "series-0", course.force_n)])
              for number, course in enumerate(chosen_forces(recording))]
    return Section(key="force", title="Force", parts=[
        Table(rows=rows, columns=["kind", "recordings", "peak, N", "length, mm", "pulses"]), *charts])

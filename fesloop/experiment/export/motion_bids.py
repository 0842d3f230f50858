"""Motion-BIDS, a dataset folder (bids-specification.readthedocs.io; doi 10.1038/s41597-024-03559-8).

A tracking system is a node with its own clock. Its table begins with the channel of latencies and with what
else stamps say; instants are s from the trial's start with nine decimals, so that every ns is kept. A trial
is a run, counted from 1.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fesloop.experiment.export.channels import Quantity, quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import instant, lines, numbers, seconds, side_by_side, unique
from fesloop.experiment.recording.reading import Piece, SignalTable, TableSignal
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.formats.motion_bids import PAIRS

BIDS_VERSION = "1.10.0"
_TYPES: dict[Quantity, str] = {"acceleration": "ACCEL", "rate": "GYRO", "field": "MAGN",
                               "orientation": "ORNT", "joint_angle": "JNTANG", "position": "POS",
                               "velocity": "VEL", "other": "MISC"}
_KINDS = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "POS", "VEL")
CHANNEL_COLUMNS = ["name", "component", "type", "tracked_point", "units", "reference_frame", "description"]
STAMPS = [
    ["latency", "n/a", "LATENCY", "n/a", "s", "n/a", "instant from the trial's start"],
    ["index", "n/a", "MISC", "n/a", "n/a", "n/a", "number of the tick"],
    ["left", "n/a", "MISC", "n/a", "s", "n/a", "instant at which the values left the node"],
    ["oldest", "n/a", "MISC", "n/a", "s", "n/a", "oldest capture that the values derive from"],
    ["newest", "n/a", "MISC", "n/a", "s", "n/a", "newest capture that the values derive from"]]
EVENT_COLUMNS = ["onset", "duration", "trial_type", "where", "detail"]
EVENTS = {
    "trial_type": {"Description": "Status that a node or wire reported when it began to hold"},
    "where": {"Description": "Node or wire that reported it"},
    "detail": {"Description": "What it said"}}
SCANS = {"trial": {"Description": "Number of the trial in fesloop's recording, from 0"}}
PARTICIPANTS = {"participant_id": {
    "Description": "Who wore the hand: a virtual patient, or whoever a recording or live stream was of"}}
CHANNELS = {"reference_frame": {
    "Description": "Frame in which a channel's component is to be read",
    "Levels": {
        "sensor": {"Description": "The sensor's or segment's own frame; acceleration is specific force, +g "
                   "upwards at rest", "RotationRule": "right-hand"},
        "earth": {"Description": "East, north, up; quaternions w, x, y, z turn the segment's frame into it",
                  "RotationRule": "right-hand"},
        "root": {"Description": "Frame of the root segment: the forearm, its origin at the wrist",
                 "RotationRule": "right-hand"},
        "joint": {"Description": "Angles about the axes of the joint, intrinsic: flexion about z, then "
                  "abduction about x, then pronation about y (doi 10.3390/s19010208, eq. 20-22)",
                  "RotationRule": "right-hand"}}}}


def dataset(selection: Selection) -> dict[str, Any]:
    """dataset_description.json."""
    recording = selection.recording
    return {"Name": f"fesloop run {recording.name}", "BIDSVersion": BIDS_VERSION, "DatasetType": "raw",
            "GeneratedBy": [{"Name": "fesloop", "Version": version("fesloop"),
                             "Description": f"fesloop export of a run made with version "
                                            f"{recording.versions.get('fesloop', 'n/a')}"}]}


def readme(selection: Selection) -> str:
    """README.md."""
    recording = selection.recording
    return (f"# {recording.name}\n\n{_description(selection)}\n\n"
            f"Exported by fesloop from a recording of the experiment `{recording.name}`, seed "
            f"{recording.seed}, fingerprint {recording.fingerprint}, which ended as {recording.status}.\n\n"
            "Each tracking system is a block or plant of the closed loop with a clock of its own. Its first "
            "column is the latency from the trial's start; all systems of a run share that start. "
            f"Signals: {', '.join(selection.signals)}.\n")


def motion(selection: Selection, table: SignalTable, task: str, system: str,
           described: list[list[str]]) -> dict[str, Any]:
    """*_motion.json."""
    times = table.times_ns()
    rate = rate_of_stamps(times)
    kinds = Counter(row[2] for row in described)
    points = {row[3] for row in described} - {"n/a"}
    pairs = dict.fromkeys(pair for signal in table.signals for pair in signal.named_pairs)
    return {
        "TaskName": task, "TaskDescription": _description(selection) or "n/a",
        "TrackingSystemName": system, "SamplingFrequency": rate.hertz,
        "SamplingFrequencyEffective": rate.hertz,
        "RecordingDuration": float(times[-1] - times[0]) / NS_PER_S, "RecordingType": "continuous",
        "MissingValues": "n/a", "Manufacturer": "fesloop",
        "ManufacturersModelName": selection.block(table.signals[0]).get("kind", "n/a"),
        "SoftwareVersions": selection.recording.versions.get("fesloop", "n/a"),
        "SubjectArtefactDescription": "n/a", "TrackedPointsCount": len(points),
        "MotionChannelCount": sum(count for kind, count in kinds.items() if kind not in ("MISC", "LATENCY")),
        **({PAIRS: [list(pair) for pair in pairs]} if pairs else {}),
        **{f"{kind}ChannelCount": kinds[kind] for kind in _KINDS}}


def _description(selection: Selection) -> str:
    return str(selection.recording.experiment.get("experiment", {}).get("description", ""))


def channel_rows(selection: Selection, table: SignalTable) -> list[list[str]]:
    """*_channels.tsv without its header: stamps, then every number of every signal."""
    rows = [list(row) for row in STAMPS]
    for signal in table.signals:
        kind = quantity(signal)
        for channel in selection.channels(signal):
            name = f"{signal.port}.{channel.label}" if channel.label else signal.port
            component = f"quat_{channel.component}" if kind == "orientation" else channel.component
            rows.append([
                name, component if kind not in ("joint_angle", "other") else "n/a", _TYPES[kind],
                channel.point or signal.port, "n/a" if channel.unit == "1" else channel.unit,
                _frame(signal, kind), f"{signal.name} {channel.label}".strip()])
    for row, name in zip(rows, unique([row[0] for row in rows]), strict=True):
        row[0] = name
    return rows


def _frame(signal: TableSignal, kind: Quantity) -> str:
    if kind in ("acceleration", "rate", "field"):
        return "sensor"
    if kind == "joint_angle":
        return "joint"
    if kind == "other":
        return "n/a"
    return "root" if signal.port.startswith("fingertip") else "earth"


NO_VALUE = "n/a"
_SUBJECT = "sub-01"


def is_motion(signal: TableSignal) -> bool:
    """Return whether a signal is inertial samples, orientations, joint angles, positions or velocities."""
    return quantity(signal) != "other"


def write(selection: Selection, folder: Path) -> list[str]:
    """Write the dataset and return notes.

    BIDS has no empty files: signals without a row in a trial are left out.
    """
    task = _alphanumeric(selection.recording.name)
    motion = folder / _SUBJECT / "motion"
    motion.mkdir(parents=True)
    _write_dataset(selection, folder)
    notes, scans = [], [["filename", "acq_time", "trial"]]
    for trial in selection.trials:
        run = "" if selection.among == 1 else f"_run-{trial + 1}"
        tables = selection.tables(trial)
        for table, system in zip(tables, _systems(selection, tables), strict=True):
            if not table.count:
                notes.append(f"{selection.name_of(table)}, trial {trial}: no row, so no file")
                continue
            stem = f"{_SUBJECT}_task-{task}_tracksys-{system}{run}"
            _write_system(selection, table, task, system, motion / stem)
            scans.append([f"motion/{stem}_motion.tsv", selection.onset(trial), str(trial)])
        _write_events(selection, trial, motion / f"{_SUBJECT}_task-{task}{run}")
    _write_table(folder / _SUBJECT / f"{_SUBJECT}_scans.tsv", scans)
    _write_json(folder / _SUBJECT / f"{_SUBJECT}_scans.json", SCANS)
    return notes


def _write_dataset(selection: Selection, folder: Path) -> None:
    """Write the files that a dataset has once."""
    _write_json(folder / "dataset_description.json", dataset(selection))
    (folder / "README.md").write_text(readme(selection), encoding="utf-8")
    _write_table(folder / "participants.tsv", [["participant_id"], [_SUBJECT]])
    _write_json(folder / "participants.json", PARTICIPANTS)


def _write_system(selection: Selection, table: SignalTable, task: str, system: str, stem: Path) -> None:
    """Motion, its description, and its channels."""
    described = channel_rows(selection, table)
    _write_table(stem.with_name(f"{stem.name}_channels.tsv"), [CHANNEL_COLUMNS, *described])
    _write_json(stem.with_name(f"{stem.name}_channels.json"), CHANNELS)
    _write_json(stem.with_name(f"{stem.name}_motion.json"),
                motion(selection, table, task, system, described))
    with stem.with_name(f"{stem.name}_motion.tsv").open("w", encoding="utf-8", newline="\n") as file:
        for piece in selection.pieces(table):
            file.write(lines(_stamps(piece), numbers(side_by_side(piece), NO_VALUE), "\t"))


def _stamps(piece: Piece) -> list[list[str]]:
    """The columns of `sidecars.STAMPS`."""
    instants = (piece.left_ns, piece.oldest_ns, piece.newest_ns)
    return [seconds(piece.times_ns, NO_VALUE), list(map(str, piece.indices.tolist())),
            *(seconds(times, NO_VALUE) for times in instants)]


def _write_events(selection: Selection, trial: int, stem: Path) -> None:
    """Statuses of nodes and wires in a trial, where there were any."""
    rows = [[instant(event.time_ns), NO_VALUE, event.status, event.where, event.detail]
            for event in selection.events(trial)]
    if rows:
        _write_table(stem.with_name(f"{stem.name}_events.tsv"), [EVENT_COLUMNS, *rows])
        _write_json(stem.with_name(f"{stem.name}_events.json"), EVENTS)


def _systems(selection: Selection, tables: list[SignalTable]) -> list[str]:
    """A label a table: letters and digits."""
    return unique([_alphanumeric(selection.name_of(table)) for table in tables], "")


def _alphanumeric(name: str) -> str:
    """A BIDS label: "grasp_ilc" is graspIlc."""
    parts = [part for part in re.split("[^A-Za-z0-9]+", name) if part]
    return "".join([*parts[:1], *(part[0].upper() + part[1:] for part in parts[1:])]) or "unnamed"


def _write_table(path: Path, rows: list[list[str]]) -> None:
    """A TSV file; white space within a cell is single blanks."""
    text = "".join("\t".join(" ".join(cell.split()) or NO_VALUE for cell in row) + "\n" for row in rows)
    path.write_text(text, encoding="utf-8")


def _write_json(path: Path, table: object) -> None:
    path.write_text(json.dumps(table, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")

"""What describes the tables of a Motion-BIDS dataset."""

from __future__ import annotations

from collections import Counter
from importlib.metadata import version
from typing import Any

from fesloop.experiment.export.channels import Quantity, quantity
from fesloop.experiment.export.names import unique
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.recording.signal_table import SignalTable, TableSignal
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.formats.bids_files import PAIRS

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

"""`fesloop import`."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.apps.cli.output import print_doubts, print_json, print_table, progress_bar
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.labels import not_understood

if TYPE_CHECKING:
    from fesloop.streams.inspection import Inspection, Stream


def execute(args: Namespace) -> int:
    """Read a recording of any known format and write it as a file of fesloop's own, or say what it holds."""
    if args.inspect:
        return _inspect(args)
    if (args.target is None) == (args.out is None):
        raise InputError("TARGET", "is missing" if args.target is None else "is given twice",
                         "the file to write, as TARGET or with --out")
    args.target = args.target or args.out
    if args.source.endswith(".ssp"):
        return _import_system(args)
    if args.rate is not None:
        raise InputError("--rate", "is of systems of FMUs, .ssp", "no such option with a recording")
    return _import_stimulation(args) if args.stimulation else _import_motion(args)


def _inspect(args: Namespace) -> int:
    """Print streams, rates, gaps and units of a recording, and write a layout to start from."""
    from fesloop.streams.inspection import inspect

    for option in ("stimulation", "layout", "sensor_set", "resample"):
        if getattr(args, option):
            raise InputError(f"--{option.replace('_', '-')}", "is given beside --inspect",
                             "--inspect with the file, and where to write its layout")
    if args.target is not None and args.out is not None:
        raise InputError("TARGET", "is given twice", "the layout to write, as TARGET or with --out")
    with progress_bar(f"inspect {args.source}"):
        found = inspect(args.source)
    target = Path(args.target or args.out or f"{Path(args.source).stem}.layout.toml")
    taken: dict[str, Any] = {}
    if found.layout:
        taken = _written(found, target)
    if args.json:
        print_json({"source": str(found.path), "source_format": found.source_format,
                    "readable": found.readable, "streams": [
                        {**each._asdict(), "gaps": [gap._asdict() for gap in each.gaps]}
                        for each in found.streams],
                    "kinds": [each._asdict() for each in found.kinds], "unread": list(found.unread),
                    "notes": list(found.notes), "layout": str(target) if found.layout else None, **taken})
        return 0
    print_table(f"{found.path}: {found.source_format}", (
        "stream", "type", "columns", "samples", "rate, Hz", "stated", "lasts, s", "gaps", "longest, s",
        "missing"), [_stream_row(each) for each in found.streams], sys.stdout)
    if found.kinds:
        print()
        rows = [(each.sensor, each.kind, each.unit or "unknown", f"{each.lost}", each.stream,
                 ", ".join(each.columns)) for each in found.kinds]
        print_table("Samples of inertial sensors", ("sensor", "kind", "unit", "lost", "stream", "columns"),
                    rows, sys.stdout)
    if found.unread:
        print()
        print(not_understood(found.unread))
    for note in found.notes:
        print(f"guessed: {note}")
    if found.readable:
        print(f"next:   fesloop import {found.path} motion.h5")
    if taken.get("fault"):
        print(f"{target}: to be completed: {taken['fault']}")
    elif found.layout:
        print(f"{target}: {taken['taken']}")
        print(f"next:   fesloop import {found.path} motion.h5 --layout {target}")
    elif not found.readable:
        print("no layout is written: no columns of a gyroscope and an accelerometer were found")
    return 0


def _written(found: Inspection, target: Path) -> dict[str, Any]:
    """Write the layout, and read the recording by it: what it gives, or why it is refused."""
    from fesloop.streams.doubts import doubts
    from fesloop.streams.files import open_recording

    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(found.layout_text())
    except FileExistsError:
        raise InputError(str(target), "exists", "the name of a new file", "give another one") from None
    except OSError as fault:
        raise InputError(str(target), f"cannot be written: {fault.strerror}", "a new file") from None
    try:
        recording = open_recording(found.path, layout=target)
    except InputError as fault:
        return {"taken": None, "fault": str(fault)}
    print_doubts(str(found.path), doubts(recording))
    several = "s" * (len(recording.sensors) > 1)
    return {"taken": f"{len(recording.sensors)} sensor{several}, {recording.samples} samples, "
            + (f"{float(recording.rate):.9g} Hz" if recording.rate is not None else "at uneven instants"),
            "fault": None}


def _stream_row(stream: Stream) -> tuple[str, ...]:
    """A stream as cells of a table; "-" for what the file does not give."""
    def number(value: float | None, form: str) -> str:
        return "-" if value is None else f"{value:{form}}"

    longest = max((gap.to_s - gap.from_s for gap in stream.gaps), default=None)
    return (stream.name, stream.type, f"{stream.columns}", f"{stream.samples}", number(stream.rate_hz, ".6g"),
            number(stream.stated_hz, ".6g"), number(stream.lasts_s, ".6g"),
            "-" if stream.rate_hz is None else f"{len(stream.gaps)}", number(longest, ".4g"),
            "-" if stream.rate_hz is None else f"{sum(gap.missing for gap in stream.gaps)}")


def _import_system(args: Namespace) -> int:
    """Import a system of FMUs as an experiment; print what it lacks."""
    from fesloop.experiment.registry import system_importer

    for option in ("layout", "sensor_set", "resample", "stimulation"):
        if getattr(args, option):
            raise InputError(
                f"--{option.replace('_', '-')}", "is of recordings", "no such option with an .ssp"
            )
    with progress_bar(f"import {args.source}"):
        imported = system_importer()(args.source, args.target, args.rate or "1000")
    for note in imported.notes:
        print(f"fesloop: {args.source}: {note}", file=sys.stderr)
    if args.json:
        print_json({"experiment": str(imported.experiment), "components": imported.components,
                    "connections": imported.connections, "notes": list(imported.notes)})
    else:
        print(imported.experiment)
    return 0


def _import_stimulation(args: Namespace) -> int:
    """Import a recording of stimulated muscle; print what it holds and how it scatters."""
    from fesloop.streams.stimulation.files import import_stimulation
    from fesloop.streams.stimulation.summary import doubts_about, summary_of

    for option in ("layout", "sensor_set", "resample"):
        if getattr(args, option) is not None:
            raise InputError(f"--{option.replace('_', '-')}", "is of recordings of inertial sensors",
                             "no such option with --stimulation")
    with progress_bar(f"import {args.source}"):
        recording = import_stimulation(args.source, args.target)
    doubts, summary = doubts_about(recording), summary_of(recording)
    for doubt in doubts.values():
        print(f"fesloop: {args.source}: {doubt}", file=sys.stderr)
    if args.json:
        print_json({"stimulation": args.target, **summary, "doubts": doubts})
        return 0
    held = [f"{count} {name if count > 1 else name.removesuffix('s')}" for name, count in (
        ("courses of torque", summary["courses"]), ("movements", summary["movements"]),
        ("courses of force", summary["forces"])) if count]
    steady = summary.get("steady")
    if steady is not None:
        fewest, most = steady["repeats"]
        held.insert(0, f"{steady['trials']} isometric trials ({steady['passive']} passive, "
                    f"{steady['postures']} postures, {len(steady['muscles'])} muscles, {fewest} "
                    + (f"to {most} " if most > fewest else "") + "repeats)")
    print(f"{args.target}: {recording.person}: {', '.join(held)}, from {recording.source} "
          f"({recording.source_format})")
    if steady is not None:
        rows = [[joint, *("-" if steady[key][joint] is None else f"{steady[key][joint]:{form}}"
                          for key, form in (("sd_nm", ".2g"), ("rms_nm", ".3g"), ("snr", ".2g")))]
                for joint in recording.joints]
        print_table("evoked torque, N m: sd of a repeat; rms over muscles and postures; their ratio",
                    ["joint", "sd", "rms", "SNR"], rows, sys.stdout)
    return 0


def _import_motion(args: Namespace) -> int:
    """Import a recording of inertial sensors; print what it holds and lacks."""
    from fesloop.streams.doubts import all_doubts, lacking_in, lost_samples
    from fesloop.streams.files import import_recording

    with progress_bar(f"import {args.source}"):
        recording = import_recording(args.source, args.target, args.layout, args.sensor_set, args.resample)
    doubts, lacking = dict(all_doubts(recording)), lacking_in(recording)
    print_doubts(args.source, doubts.items())
    summary: dict[str, Any] = {
        "motion": args.target, "source": recording.source, "source_format": recording.source_format,
        "sensors": list(recording.sensors), "samples": recording.samples,
        "rate": None if recording.rate is None else str(recording.rate),
        "duration_s": recording.duration_ns / NS_PER_S, "magnetometers": recording.mag is not None,
        "reference": recording.reference is not None, "source_units": dict(recording.source_units),
        "left_out": list(recording.left_out),
        **{status: doubts.get(status, "") for status in (
            "rates_disagree", "rates_not_checked", "mounting_disagrees", "range_too_small",
            "repeated_samples")},
        "origin_s": recording.origin_s, "resampled_hz": dict(recording.resampled_hz),
        "rate_between_gaps_hz": lacking.rate_hz,
        "gaps": [gap._asdict() for gap in lacking.gaps],
        "lost_samples": dict(zip(recording.sensors, lost_samples(recording).sum(axis=0).tolist(),
                                 strict=True))}
    if args.json:
        print_json(summary)
    else:
        rate = f"{float(recording.rate):.9g} Hz" if recording.rate is not None else (
            f"about {lacking.rate_hz:.6g} Hz " + ("with gaps" if lacking.gaps else "at uneven instants"))
        sensors = "1 sensor" if len(recording.sensors) == 1 else f"{len(recording.sensors)} sensors"
        print(f"{args.target}: {sensors}, {recording.samples} samples, {rate}, from "
              f"{recording.source} ({recording.source_format})")
        if recording.origin_s is not None:
            print(f"{args.target}: t = 0 is {recording.origin_s:.9f} s by the clock of {recording.source}")
        if recording.resampled_hz:
            own = ", ".join(f"{name} {hz:.6g} Hz" for name, hz in recording.resampled_hz.items())
            print(f"{args.target}: brought to common instants by straight lines between samples, from {own}")
    return 0

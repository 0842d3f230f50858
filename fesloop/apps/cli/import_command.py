"""`fesloop import`."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

from fesloop.apps.cli.output import print_doubts, print_json, print_table, progress_bar
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S


def execute(args: Namespace) -> int:
    """Read a recording of any known format and write it as a file of fesloop's own."""
    if (args.target is None) == (args.out is None):
        raise InputError("TARGET", "is missing" if args.target is None else "is given twice",
                         "the file to write, as TARGET or with --out")
    args.target = args.target or args.out
    if args.source.endswith(".ssp"):
        return _import_system(args)
    if args.rate is not None:
        raise InputError("--rate", "is of systems of FMUs, .ssp", "no such option with a recording")
    return _import_stimulation(args) if args.stimulation else _import_motion(args)


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

"""`fesloop identify`."""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.apps.cli.output import free_target, print_made, print_table, progress_bar
from fesloop.errors import InputError
from fesloop.experiment.registry import identifier
from fesloop.models.patient_model import require_usable

if TYPE_CHECKING:
    from fesloop.models.arm_people import ArmPerson

_WEAK = 50.0
"""Fit of a recruitment curve, %, below which it is marked (chosen: it explains 1 - .5^2 of the variance)."""


def execute(args: Namespace) -> int:
    """Write the file of a patient's model, or of a person."""
    if args.patient and not args.stimulation:
        raise InputError("--patient", "is for recordings of stimulation", "--stimulation beside it",
                         "add --stimulation, or remove it")
    if args.stimulation and args.opened_deg is not None:
        raise InputError("--opened-deg", "is for recordings of sweep_grasp", "it without --stimulation",
                         "remove one of the two")
    return _identify_person(args) if args.stimulation else _identify_model(args)


def _identify_person(args: Namespace) -> int:
    """Write a person's file; print torque and intervals, and what the recording does not say."""
    from fesloop.analysis.people import identify

    source = Path(args.recording)
    out = args.out or str(source.with_name(f"{source.stem}_person.json"))
    path = free_target(out, f"--out {out}")
    patient_path = free_target(args.patient, f"--patient {args.patient}") if args.patient else None
    found = identify.identify_person(args.recording)
    report: dict[str, Any] = {**identify.summary_of(found), "doubts": found.doubts}
    if patient_path is not None:
        report["patient"] = {"file": args.patient,
                             **_write_patient(args.recording, found.person, patient_path)}
    identify.save(found.person, path)
    for each in found.doubts:
        print(f"fesloop: {args.recording}: {each}", file=sys.stderr)
    print_made("person", path, report, _print_person, as_json=args.json)
    if patient_path is not None and not args.json:
        print(patient_path)
    return 0


def _write_patient(recording: str, person: ArmPerson, path: Path) -> dict[str, Any]:
    """Write a person's virtual patient; return its factors."""
    from fesloop.analysis.people.own_patient import as_report, own_patient, patient_text
    from fesloop.streams.stimulation import open_stimulation

    own = own_patient(open_stimulation(recording), person)
    path.write_text(patient_text(own, Path(recording).name), encoding="utf-8")
    return as_report(own)


def _print_person(summary: dict[str, Any]) -> None:
    joints = list(summary["repeat_sd_nm"])
    rows = [[row["electrode"] + ("" if row["recorded"] else " *"), row["pulses"] or "-",
             *(_with_interval(**row[joint]) for joint in joints)] for row in summary["electrodes"]]
    posture = ", ".join(f"{joint.replace('_', ' ')} {angle:g}"
                        for joint, angle in summary["posture_deg"].items())
    print_table(f"{summary['person']}: evoked torque, N m, over {summary['baseline']}, at {posture} deg "
                f"(elbow straight: 0), {100 * summary['within']:.0f} % interval",
                ["electrode", "pulses", *(joint + " *" * (joint in summary["missing"]) for joint in joints)],
                rows, sys.stderr)
    print("arm_bench takes these torques; recruitment, delay and speed of its muscles are the population's",
          file=sys.stderr)
    if summary["missing"] or not all(row["recorded"] for row in summary["electrodes"]):
        print("* not recorded: the population's, at the pulses of its people, in units of this recording's "
              "scatter and times the gain; joints of a recorded electrode follow its other ones, too",
              file=sys.stderr)
    print(f"gain {summary['gain']:.2g}: torque of the recorded electrodes over the scatter of their repeats, "
          "relative to the population's; it follows how strongly they were driven", file=sys.stderr)
    if "patient" in summary:
        _print_patient(summary["patient"], summary["within"])


def _with_interval(nm: float, low: float, high: float) -> str:
    """Text of a torque and its interval, to two digits of half the interval."""
    digits = max(0, 1 - math.floor(math.log10(0.5 * (high - low)))) if high > low else 3
    return f"{nm:+.{digits}f} ({low:+.{digits}f} to {high:+.{digits}f})"


def _print_patient(patient: dict[str, Any], within: float) -> None:
    def cells(row: dict[str, Any]) -> list[str]:
        return [f"{row[key]['factor']:.2f} ({row[key]['low']:.2f} to {row[key]['high']:.2f})"
                for key in ("strength", "threshold")]

    rows = [[row["muscle"], f"{row['recorded_nm']:+.3g} (sd {row['recorded_sd_nm']:.2g})",
             f"{row['own_nm']:+.3g}",
             f"{row['stranger_nm']['low']:+.2g} to {row['stranger_nm']['high']:+.2g}",
             *cells(row)] for row in patient["muscles"]]
    print_table(f"{patient['file']}: mean wrist flexion at the recording's settings, N m: recorded, over "
                f"{patient['baseline']}, of this patient, of {100 * within:.0f} % of the preset's members; "
                f"factors on the preset's muscles, {100 * within:.0f} % interval",
                ["muscle", "recorded", "this patient", "members", "strength", "threshold"],
                [*rows, ["all muscles", "", "", "", *cells(patient)]], sys.stderr)
    for note in patient["notes"]:
        print(f"{patient['file']}: {note}", file=sys.stderr)


def _identify_model(args: Namespace) -> int:
    """Write the model file of a recording's patient; print its fit to data that was held out.

    A model that explains too little is written for inspection and refused by controllers: exit code 1.
    """
    out = args.out or "model.toml"
    path = free_target(out, f"--out {out}")
    with progress_bar(f"identify {args.recording}"):
        found = identifier()(args.recording, measured=args.measured, method=args.method,
                             opened_deg=args.opened_deg)
    found.model.save(path)
    usable = True
    try:
        require_usable(str(path), found.model)
    except InputError as fault:
        usable = False
        print(f"fesloop: {fault}", file=sys.stderr)
    else:
        for weakness in found.model.weaknesses():
            print(f"fesloop: {path}: {weakness}: the model is weak there", file=sys.stderr)
    report = found.report()
    for doubt in report.get("doubts", ()):
        print(f"fesloop: {path}: {doubt}", file=sys.stderr)
    print_made("model", path, report, _print, as_json=args.json)
    return 0 if usable else 1


def _print(report: dict[str, Any]) -> None:
    missed = report.get("missed_deg", {})
    if missed:
        print_table("what the chosen elements leave of each posture, deg", ["output", *missed],
                    [[name, *(f"{left[name]:+.1f}" for left in missed.values())]
                     for name in report["outputs"]], sys.stderr)
    kinds = list(report["fit_percent"])
    rows = [[name, *(f"{report['fit_percent'][kind][name]:.1f}" for kind in kinds)]
            for name in report["outputs"]]
    on = "to the sweep" if missed else f"on the {report['held_out_s']:.3g} s held out"
    print_table(f"fit {on}, %: order {report['order']}, delay {report['delay_ms']:g} ms", ["output", *kinds],
                rows, sys.stderr)
    rows = [[str(c), row["electrode"], f"{row['current_ma']:g}", f"{row['threshold_us']:.0f}",
             *(f"{row[name]:.2f} {row['at_bound'].get(name, '')}".rstrip() for name in ("half_ma", "spread")),
             f"{row['fit_percent']:.0f}{' weak' if row['fit_percent'] < _WEAK else ''}",
             *(["yes" if row["grips"] else ""] if missed else [])]
            for c, row in enumerate(report["channels"])]
    print_table("recruitment: threshold at 5 %, half at an effective current", [
        "channel", "electrode", "mA", "threshold us", "half mA", "spread", "fit %",
        *(["grips"] if missed else [])], rows, sys.stderr)
    if any(row["at_bound"] for row in report["channels"]):
        print("'or more', 'or less': the fit is at the end of the range tried"
              f"{'' if missed else ' (half: the strongest pulse)'}; the patient's value may lie beyond",
              file=sys.stderr)
    if any(row["fit_percent"] < _WEAK for row in report["channels"]):
        print(f"'weak': a fit below {_WEAK:g} %, which explains less than three quarters of the variance "
              "of the responses: expect others than the model's", file=sys.stderr)

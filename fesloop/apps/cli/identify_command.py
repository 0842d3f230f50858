"""`fesloop identify`."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

from fesloop.apps.cli.output import free_target, print_made, print_table, progress_bar
from fesloop.errors import InputError
from fesloop.experiment.registry import identifier
from fesloop.models.patient_model import require_usable


def execute(args: Namespace) -> int:
    """Write the file of a patient's model, or of a person."""
    return _identify_person(args) if args.stimulation else _identify_model(args)


def _identify_person(args: Namespace) -> int:
    """Write a person's file; print torque and intervals, and what the recording does not say."""
    from fesloop.analysis.people import identify

    out = args.out or "person.json"
    path = free_target(out, f"--out {out}")
    person, doubts, missing = identify.identify_person(args.recording)
    identify.save(person, path)
    for each in doubts:
        print(f"fesloop: {args.recording}: {each}", file=sys.stderr)
    print_made("person", path, {**identify.summary_of(person, missing), "doubts": doubts}, _print_person,
               as_json=args.json)
    return 0


def _print_person(summary: dict[str, Any]) -> None:
    joints = list(summary["repeat_sd_nm"])
    rows = [[row["electrode"] + ("" if row["recorded"] else " *"),
             *(f"{row[joint]['nm']:+.3f} ({row[joint]['low']:+.3f} to {row[joint]['high']:+.3f})"
               for joint in joints)] for row in summary["electrodes"]]
    posture = ", ".join(f"{joint.replace('_', ' ')} {angle:g}"
                        for joint, angle in summary["posture_deg"].items())
    print_table(f"{summary['person']}: evoked torque, N m, at {posture} deg (elbow straight: 0), "
                f"{100 * summary['within']:.0f} % interval",
                ["electrode", *(joint + " *" * (joint in summary["missing"]) for joint in joints)], rows,
                sys.stderr)
    if summary["missing"] or not all(row["recorded"] for row in summary["electrodes"]):
        print("* not recorded: of the population, as far as the other joints do not say", file=sys.stderr)


def _identify_model(args: Namespace) -> int:
    """Write the model file of a recording's patient; print its fit to data that was held out.

    A model that explains too little is written for inspection and refused by controllers: exit code 1.
    """
    out = args.out or "model.toml"
    path = free_target(out, f"--out {out}")
    with progress_bar(f"identify {args.recording}"):
        found = identifier()(args.recording, measured=args.measured, method=args.method)
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
    print_made("model", path, found.report(), _print, as_json=args.json)
    return 0 if usable else 1


def _print(report: dict[str, Any]) -> None:
    kinds = list(report["fit_percent"])
    rows = [[name, *(f"{report['fit_percent'][kind][name]:.1f}" for kind in kinds)]
            for name in report["outputs"]]
    print_table(f"fit on the {report['held_out_s']:.3g} s held out, %: order {report['order']}, "
                f"delay {report['delay_ms']:g} ms", ["output", *kinds], rows, sys.stderr)
    rows = [[str(c), row["electrode"], f"{row['current_ma']:g}", f"{row['threshold_us']:.0f}",
             *(f"{row[name]:.2f} {row['at_bound'].get(name, '')}".rstrip() for name in ("half_ma", "spread")),
             f"{row['fit_percent']:.0f}"]
            for c, row in enumerate(report["channels"])]
    print_table("recruitment: threshold at 5 %, half at an effective current", [
        "channel", "electrode", "mA", "threshold us", "half mA", "spread", "fit %"], rows, sys.stderr)
    if any(row["at_bound"] for row in report["channels"]):
        print("'or more', 'or less': the fit is at the end of the range tried (half: the strongest pulse); "
              "the patient's value may lie beyond", file=sys.stderr)

"""`fesloop calibrate`."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

from fesloop.apps.cli.output import free_target, print_made, print_table, progress_bar
from fesloop.experiment.registry import calibrator
from fesloop.forms.schema import plain


def execute(args: Namespace) -> int:
    """Write the calibration that a recording shows; print what was found and what was not."""
    path = free_target(args.out, f"--out {args.out}")
    markers = args.markers_out and free_target(args.markers_out, f"--markers-out {args.markers_out}")
    with progress_bar(f"calibrate {args.recording}"):
        found = calibrator()(
            args.recording, sensor_set=args.sensor_set, layout=args.layout, joints=tuple(args.joints),
            flat_s=tuple(args.flat) if args.flat else None, side=args.side, low_pass_hz=args.low_pass,
            markers=args.markers, marker=args.marker, sensor=args.sensor,
            arcs_s=tuple(args.arcs) if args.arcs else None,
            rotation=tuple(args.rotation) if args.rotation else None, fixture=args.fixture)
    if markers:
        found.write_markers(markers)
    found.calibration.save(path)
    report = {**plain(found.calibration), "refused": list(found.refused)}
    for clock, row in zip(found.calibration.clocks, report["clocks"], strict=True):
        row["late_ms"] = clock.late_ms
    print_made("calibration", path, report, _print, as_json=args.json)
    return 0


def _print(report: dict[str, Any]) -> None:
    tables = (
        ("axes of hinges, in the sensors' frames", ["joint", "parent's axis", "child's axis", "sd deg",
                                                    "residual deg/s"],
         [[f"{hinge['parent']}-{hinge['child']}", _vector(hinge["parent_axis"]), _vector(hinge["child_axis"]),
           f"{max(hinge['parent_sd_deg'], hinge['child_sd_deg']):.2f}", f"{hinge['residual_deg_s']:.2g}"]
          for hinge in report["hinges"]]),
        ("rotations, sensor to segment", ["sensor", "w x y z", "misfit deg", "from"],
         [[each["name"], _vector(each["rotation"]), f"{each['off_deg']:.2f}", each["method"]]
          for each in report["sensors"]]),
        ("clocks", ["other", "late ms", "correlation", "second peak", "sensor"],
         [[each["other"], f"{each['late_ms']:.2f}", f"{each['peak']:.3f}", f"{each['second_peak']:.3f}",
           each["sensor"]] for each in report["clocks"]]),
        ("centres of rotation, in the markers' frame", ["marker", "centre m", "radius m", "deviation mm",
                                                        "sd mm"],
         [[each["marker"], _vector(each["centre_m"], 4), f"{each['radius_m']:.4f}",
           f"{1e3 * each['deviation_m']:.2f}", f"{1e3 * each['sd_m']:.2f}"] for each in report["centres"]]),
        ("from the markers' frame to the target frame", ["rotation w x y z", "origin m", "rms mm"],
         [[_vector(each["rotation"]), _vector(each["origin_m"], 4), f"{1e3 * each['rms_m']:.2f}"]
          for each in report["frames"]]))
    for title, columns, rows in tables:
        if rows:
            print_table(title, columns, rows, sys.stderr)
    for line in report["refused"]:
        print(f"fesloop: not found: {line}", file=sys.stderr)


def _vector(numbers: list[float], digits: int = 3) -> str:
    return " ".join(f"{number:.{digits}f}" for number in numbers)

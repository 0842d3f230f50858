"""`fesloop fit-error`."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

from fesloop.apps.cli.output import free_target, print_made, print_table, progress_bar

_AHEAD_MS = 1.0
"""Least shift that is reported (chosen)."""
_OF_MEANS = {"constrained", "kortier"}
"""Trackers that take the mean of a rate and the one before for the time between: they lead by nothing."""
_LEGEND = """\
moved: whether the joint turned about this axis
first half, second half: measured; process there: the process along the second half's motion{range_text}
within 15 %: whether that is near the measured error of the second half
autocorrelation in band: whether the measured one is, as a whole, among those of 95 % of the process's runs
lags %: share of lags at which it is among the middle 95 % of the runs, lag by lag
increments: RMS change of the process's error less the measured one, over {times} s, %; NO: not within 15 %"""


def execute(args: Namespace) -> int:
    """Fit a tracker's error process to first halves of recordings; print how it predicts the second ones."""
    from fesloop.analysis.tracker_error.fitting import fit_error

    path = free_target(args.target, args.target)
    settings = tuple(args.settings) + ((f"tracker={args.tracker}",) if args.tracker else ())
    with progress_bar(f"fit-error {' '.join(args.recordings)}") as bar:
        found = fit_error(*args.recordings, settings=settings, reference_late_ms=args.reference_late,
                          seed=args.seed or 0, progress=bar)
    found.process.save(path)
    print_made("process", path, found.report(), _print, as_json=args.json)
    return 0


def _print(report: dict[str, Any]) -> None:
    several = len(report["recordings"]) > 1
    rows = [[f"{angle['recording']}: {angle['angle']}" if several else angle["angle"],
             "yes" if angle["moved"] else "", f"{angle['rmse_fitted_deg']:.2f}",
             f"{angle['rmse_measured_deg']:.2f}", _process(angle, several),
             _yes(angle["rmse_within_15_percent"]), _yes(angle["autocorrelation_in_band"]),
             f"{100.0 * angle['lags_in_band_share']:.0f}", _increments(angle["increments"])]
            for angle in report["angles"]]
    for number, name in enumerate(report["recordings"], 1) if several else ():
        print(f"{number}: {name}", file=sys.stderr)
    fitted, judged = f"{report['fitted_s']:.3g} s", f"{report['judged_s']:.3g} s"
    title = (f"{len(report['recordings'])} recordings: RMS error, deg; fitted to their first halves, "
             f"{fitted} in all, compared with their second ones, {judged}" if several else
             f"{report['source']}: RMS error, deg; fitted to {fitted} from {report['from_s']:.3g} s on, "
             f"compared with the {judged} after")
    print_table(title, [
            "angle", "moved", "first half", "second half", "process there", "within 15 %",
            "autocorrelation in band", "lags %", "increments"], rows, sys.stderr)
    if several:
        _print_differences(report)
    times_s = report["angles"][0]["increments"]["times_s"]
    print(_LEGEND.format(range_text=" (and 95 % of its runs)" if several else "",
                         times=", ".join(f"{time:.2g}" for time in times_s)), file=sys.stderr)
    print(f"age {report['age_ms']:g} ms at least, {100.0 * report['loss']:.3g} % lost", file=sys.stderr)
    half_ms = 0.0 if set(report["trackers"]) <= _OF_MEANS else report["half_sample_ms"]
    if shift := delay_text(report["ahead_ms"], half_ms, report["recorded_reference"]):
        print(shift, file=sys.stderr)
    for key, text in (("too_slow_to_tell", "correlated for longer than half of this recording can show"),
                      ("left_out", "too few samples to fit")):
        if report[key]:
            print(f"{text}: {', '.join(report[key])}", file=sys.stderr)


def delay_text(ahead_ms: float, half_sample_ms: float, recorded: bool) -> str:
    """Describe by how much estimates are shifted in time, and possible causes; empty for a small shift.

    half_sample_ms: 0 for trackers that lead by nothing.
    recorded: whether the reference is a recorded one, whose stamps may be late, and not a plant's truth.
    """
    if abs(ahead_ms) <= _AHEAD_MS:
        return ""
    which = f"{abs(ahead_ms):.3g} ms {'ahead of' if ahead_ms > 0.0 else 'behind'}"
    if not recorded:
        return f"the estimates are {which} the truth"
    shift = f"the estimates are {which} the reference"
    if not half_sample_ms:
        cause = "its stamps are late" if ahead_ms > 0.0 else "the tracker lags, or its stamps are early"
        return f"{shift}: {cause}; --reference-late {ahead_ms:.3g} corrects stamps"
    late_ms = ahead_ms - half_sample_ms
    own = (f"a tracker that takes each rate for the whole period before it, such as vqf, is half a sample "
           f"ahead, {half_sample_ms:.3g} ms")
    takes = f"--reference-late {late_ms:.3g} corrects that (for such a tracker; {ahead_ms:.3g} for another)"
    if ahead_ms < 0.0:
        return f"{shift}: the tracker lags, or the reference's stamps are early, where {takes}; {own}"
    if late_ms <= _AHEAD_MS:
        return f"{shift}: {own}; with any other tracker the reference's stamps are late by that"
    return f"{shift}: {own}; the rest means that the reference's stamps are late; {takes}"


def _process(angle: dict[str, Any], several: bool) -> str:
    """RMSE of the process; with its 95 % range where recordings differ."""
    low, high = angle["rmse_process_95_deg"]
    return f"{angle['rmse_process_deg']:.2f}" + (f" ({low:.2f}-{high:.2f})" if several else "")


def _print_differences(report: dict[str, Any]) -> None:
    """Parts of each angle's error, recording by recording."""
    rows = [[each["angle"], *(" ".join(f"{value:.{digits}f}" for value in each[key]) for key, digits in (
        ("bias_deg", 2), ("lead_ms", 0), ("random_deg", 2)))] for each in report["differences"]]
    print_table("first halves, recording by recording: constant part, lead of the estimates on the "
                "reference, RMS of the random part", ["angle", "bias, deg", "lead, ms", "random, deg"],
                rows, sys.stderr)


def _increments(found: dict[str, Any]) -> str:
    """Relative differences of increments, and whether all hold."""
    pairs = zip(found["process_deg"], found["measured_deg"], strict=True)
    return " ".join(f"{100.0 * (process / measured - 1.0):+.0f}" for process, measured in pairs) + (
        "" if found["within_15_percent"] else " NO")


def _yes(holds: bool) -> str:
    return "yes" if holds else "NO"

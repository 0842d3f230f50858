"""Runs every shipped experiment with its variants, and checks that results are plausible; studies on request.

    plausible.py [--only NAME]... [--workers N] [--studies] [--json FILE]

A run is doubtful when an initial pose or a calibration fails, when a pulse leaves the safety block before
each tracker that needs stillness is aligned, when a metric is none without a reason in words, when one is
outside what a hand, a tracker or a stimulator can do or has no definition (`fesloop explain`), or when
docs/events.md does not explain an event. A
sweep or a study is doubtful when an error falls, beyond its 95 % interval, while latency or a tracker's error
grows.
EXPLAINED lists doubts that are right, with the reason. Exits with 1 if there is any other doubt.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
EVENTS = ROOT / "docs" / "events.md"
RECORDINGS = Path(os.environ.get("FESLOOP_RECORDINGS", ROOT.parent / "shared" / "data"))
BODY16 = RECORDINGS / "body16" / "qmt_full_body_example_data.mat"

SETTINGS = {"grasp_ilc": ["trials=2"], "open_close_ilc": ["trials=2"], "tracker_hour": ["duration_s=120"]}
"""Settings that shorten long experiments without leaving out any part of them."""
LEFT_OUT = {"array_search_exhaustive", "array_search_magnets", "array_search_two_phase", "hil_live",
            "hil_dry_stimulator", "hil_twin", "hil_error_replay", "hil_replay", "replay"}
"""Experiments left out: long searches, and those that need a stream, a clock or a file (tests run them)."""
SKIPPED = {("plant", "myohand"), ("tracker", "error_replay"), ("reference", "recorded"),
           ("channels", "model")}
"""Options that need an extra or a file."""
SWEEPS = {
    "grasp_mpc": ("tracker_latency_ms", (0, 100, 200), (1, 2, 3)),
    "finger_mpc": ("latency_ms", (0, 50, 150), (1, 2, 3, 4)),
    "finger_pid_latency": ("latency_ms", (0, 50, 100, 150), (1, 2, 3, 4)),
    "pinch_mpc": ("tracker_latency_ms", (0, 100), (1, 2, 3)),
}
"""Setting, latencies in ms and seeds by experiment."""

REPLICATES = 3
"""Least number of runs of each cell of a study."""
BOUNDS = (
    (r"(.*[_.])?(joint|tracker)_rmse_deg|(.*\.)?split.*", 0.0, 90.0),
    (r"(orientation|heading|inclination).*_deg", 0.0, 180.0),
    (r"fingertip_rmse_mm.*", 0.0, 200.0),
    (r"object_moved_mm", 0.0, 200.0),
    (r"aperture_mm\..*", 0.0, 250.0),
    (r"grip_force_n\..*", 0.0, 100.0),
    (r"grip_margin", 0.0, 50.0),
    (r"(held_s|time_to_grasp_s)", 0.0, 120.0),
    (r"wrist_extension_deg", -90.0, 90.0),
    (r"unwanted_motion_deg", 0.0, 90.0),
    (r"minutes", 0.0, 120.0),
    (r"queries", 1.0, 10_000.0),
    (r"charge_uc", 0.0, 1e7),
    (r"grasps_until_fatigue", 0.0, 1e4),
)
"""Possible range of a metric, by its path."""
ERRORS = re.compile(r"error|rmse|_deg$")
WORSE = re.compile(r"latency|jitter|loss|dropout|silence|misalignment|magnet|noise|bias|drift|delay|error")

EXPLAINED = {
    r"^tracker_map: \w+ of salchow_b over magnet_a_m2 falls from .* at 5 ":
        "at 5 A m2 the wrist is found again and fingers are opened as far as they go (docs/maps.md)",
    r"^finger_pid_latency: joint_rmse_deg over latency_ms falls":
        "PID set by hand is slow to follow; latency takes damping from it, which is faster up to 70 ms",
}
"""Doubts that are right: pattern, and reason."""


class Case(NamedTuple):
    """An experiment with settings."""

    name: str
    settings: tuple[str, ...] = ()
    seed: int | None = None

    def __str__(self) -> str:
        seed = () if self.seed is None else (f"seed={self.seed}",)
        return " ".join((self.name, *self.settings, *seed))


def cases(only: Sequence[str]) -> Iterator[Case]:
    """Each shipped experiment with its defaults, and with each option of each variant."""
    from fesloop.experiment.files.parse import read
    from fesloop.experiment.files.source import shipped

    for name in shipped():
        if name in LEFT_OUT or (only and name not in only):
            continue
        short = tuple(SETTINGS.get(name, ()))
        yield Case(name, short)
        for variant, table in read(name)[1].get("variants", {}).items():
            for option, content in table.items():
                if (isinstance(content, dict) and option != table.get("default")
                        and (variant, option) not in SKIPPED):
                    yield Case(name, (*short, f"{variant}={option}"))


def sweep_cases(only: Sequence[str]) -> Iterator[Case]:
    """Each latency with each seed."""
    for name, (key, values, seeds) in SWEEPS.items():
        if not only or name in only:
            yield from (Case(name, (f"{key}={value}",), seed) for value in values for seed in seeds)


def run(case: Case) -> tuple[Case, dict[str, Any], list[str]]:
    """Metrics of a run, and its doubts."""
    from fesloop import Recording, load

    experiment = load(case.name, list(case.settings), case.seed)
    with tempfile.TemporaryDirectory() as folder:
        done = experiment.run(out=folder)
        with Recording(done.recording) as recording:
            doubts = [*events_doubted(recording), *pulses_doubted(recording, experiment.nodes),
                      *metrics_doubted(done.metrics)]
    return case, done.metrics, doubts


def events_doubted(recording: Any) -> Iterator[str]:
    """Failed poses, and events that no page explains."""
    explained = set(re.findall(r"`(\w+)`", EVENTS.read_text())) if EVENTS.exists() else set()
    for status, where, detail in sorted({(e.status, e.where, e.detail) for e in recording.events}):
        if status in ("initial_pose_failed", "pose_contradicted", "calibration_failed"):
            yield f"{status} ({where}): {detail}"
    for status in sorted({event.status for event in recording.events} - explained):
        yield f"event {status} is not explained in docs/events.md"


def pulses_doubted(recording: Any, nodes: Sequence[Any]) -> Iterator[str]:
    """Pulses that leave a guard before every tracker that needs stillness is aligned."""
    guards = [node.name for node in nodes if getattr(node.part, "guards", False)]
    still = [f"{node.name}.{output}" for node in nodes
             if (output := getattr(node.part, "needs_stillness", ""))]
    missing = {*still, *(f"{guard}.stimulation" for guard in guards)} - {*recording.signals}
    if not still or missing:
        yield from (f"{name} is not recorded" for name in sorted(missing) if still)
        return
    for trial in range(recording.trials):
        for guard in guards:
            pulses = recording.signal(f"{guard}.stimulation", trial)
            given = pulses.times_ns[pulses.values.reshape(len(pulses.values), -1).any(axis=1)]
            for name in still:
                aligned = recording.signal(name, trial)
                since = aligned.times_ns[aligned.values[:, 0] > 0.5]
                if given.size and (not since.size or given[0] < since[0]):
                    yield f"trial {trial}: {guard} stimulates at {given[0] / 1e9:g} s, before {name}"


def flat(metrics: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, list[Any]]]:
    """Metrics by dotted path, one value per trial."""
    for name, value in metrics.items():
        at = f"{path}.{name}" if path else name
        if name == "missing":
            continue
        if isinstance(value, Mapping):
            yield from flat(value, at)
        elif isinstance(value, (list, int, float, type(None))):
            yield at, list(value) if isinstance(value, list) else [value]


def metrics_doubted(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Metrics that are none without a reason, outside the possible range, or without a definition."""
    from fesloop.experiment.metrics.words import groups

    defined = {each.name for group in groups() for each in group.definitions}
    yield from (f"{name} has no definition" for name in metrics if name not in {*defined, "missing"})
    reasons = metrics.get("missing", {})
    for name, values in flat(metrics):
        limits = next(((low, high) for pattern, low, high in BOUNDS if re.fullmatch(pattern, name)), None)
        for trial, value in enumerate(values):
            if value is None or (isinstance(value, float) and math.isnan(value)):
                given = reasons.get(name)
                if not (given[trial] if isinstance(given, list) else given):
                    yield f"{name} of trial {trial} is none, without a reason"
            elif isinstance(value, (int, float)) and limits and not limits[0] <= value <= limits[1]:
                yield f"{name} of trial {trial} is {value:g}, possible is {limits[0]:g} to {limits[1]:g}"


def falls(levels: Sequence[float], values: Sequence[Sequence[float]], name: str,
          comparisons: int = 1) -> Iterator[str]:
    """Levels at which the mean of an error falls from the one before by more than its 95 % interval.

    Values are (levels, seeds), the same seeds at each level: the interval is of the paired difference, and
    of all `comparisons` together (Bonferroni).
    """
    from scipy.stats import t

    for (low, before), (high, after) in pairwise(zip(levels, values, strict=True)):
        change = np.subtract(after, before)
        change = change[np.isfinite(change)]
        if change.size < 2 or not np.isfinite(before).any():
            continue
        half = t.ppf(1.0 - 0.025 / comparisons, change.size - 1) * change.std(ddof=1) / math.sqrt(change.size)
        if change.mean() + half < -0.01 * abs(np.nanmean(before)):
            yield (f"{name} falls from {np.nanmean(before):.3g} at {low:g} to {np.nanmean(after):.3g} at "
                   f"{high:g} (by {-change.mean():.2g} +- {half:.2g})")


def sweeps_doubted(found: Mapping[Case, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Errors that fall with latency."""
    for name, (key, levels, seeds) in SWEEPS.items():
        runs = [[found.get(Case(name, (f"{key}={value}",), seed)) for seed in seeds] for value in levels]
        if any(each is None for row in runs for each in row):
            continue
        for metric in ("joint_rmse_deg", "tracker_rmse_deg"):
            values = [[np.mean(each[metric]) if each and metric in each else math.nan for each in row]
                      for row in runs]
            yield from ((name, doubt) for doubt in falls(levels, values, f"{metric} over {key}"))


def courses_of(table: Any, axes: Sequence[str], metrics: Sequence[str]) -> Iterator[
        tuple[list[float], list[list[float]], str]]:
    """Errors over each axis that makes things worse: levels, values (levels, pairs), and a description.

    One course for each choice of options on the other axes; replicates and their numeric levels make pairs.
    """
    numeric = [axis for axis in axes if table[axis].dtype.kind in "if"]
    for axis in filter(WORSE.search, numeric):
        options = [each for each in axes if each not in numeric]
        pairs = ["replicate", *(each for each in numeric if each != axis)]
        for labels, group in table.groupby(options, dropna=False) if options else (((), table),):
            for metric in metrics:
                by_level = group.pivot_table(index=pairs, columns=axis, values=metric).dropna()
                if len(by_level) > 1 and by_level.shape[1] > 1:
                    yield (list(by_level), by_level.to_numpy().T.tolist(),
                           f"{metric} of {', '.join(map(str, labels)) or 'all'} over {axis}")


def study_doubted(name: str, workers: int) -> Iterator[str]:
    """Failed runs of a small study, and errors of its tables that fall; replicates give the interval."""
    from fesloop.analysis.study import load, read_study, run_study, study_of

    document = dict(read_study(name).document)
    document["study"] = {**document["study"], "replicates": max(REPLICATES, document["study"]["replicates"])}
    with tempfile.TemporaryDirectory() as folder:
        results = load(run_study(study_of(document), out=folder, workers=workers).store)
        table = results.frame()
    failed = table[table["status"] != "done"]
    for cause, count in failed["cause"].value_counts().items():
        yield f"{count} of {len(table)} runs failed: {cause}"
    courses = list(courses_of(table, list(results.axes), [*filter(ERRORS.search, results.metrics)]))
    steps = sum(len(levels) - 1 for levels, _, _ in courses)
    for levels, values, told in courses:
        yield from falls(levels, values, told, max(steps, 1))
    print(f"{name}: {len(table)} runs, {len(courses)} courses of errors, {steps} steps compared", flush=True)


def explained(doubt: str) -> str:
    """Reason why a doubt is right; "" where none is known."""
    return next((why for pattern, why in EXPLAINED.items() if re.search(pattern, doubt)), "")


def main(arguments: Sequence[str]) -> int:
    """Print all doubts; exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--studies", action="store_true")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args(arguments)
    asked = [*cases(given.only), *sweep_cases(given.only)]
    found: dict[Case, dict[str, Any]] = {}
    doubted: list[tuple[str, str]] = []
    with ProcessPoolExecutor(given.workers) as pool:
        for case, metrics, doubts in pool.map(run, asked):
            found[case] = metrics
            doubted += [(str(case), doubt) for doubt in doubts]
            print("\n    ".join((f"{case}: {len(doubts)} doubts", *doubts)), flush=True)
    doubted += sweeps_doubted(found)
    if given.studies:
        from fesloop.analysis.study.design.shipped_studies import shipped_studies

        for name in shipped_studies():
            if not given.only or name in given.only:
                doubted += [(name, doubt) for doubt in study_doubted(name, given.workers)]
    if given.json:
        metrics_of = {str(case): metrics for case, metrics in found.items()}
        given.json.write_text(json.dumps(metrics_of, default=str))
    left = 0
    for name, doubt in doubted:
        why = explained(f"{name}: {doubt}")
        left += not why
        print(f"{name}: {doubt}" + (f" [{why}]" if why else ""))
    print(f"{len(asked)} runs, {len(doubted)} doubts, {left} not explained")
    return int(left > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

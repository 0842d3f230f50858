"""`fesloop check`."""

from __future__ import annotations

import sys
from argparse import Namespace
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from fesloop.apps.cli.output import print_json, print_table, progress_bar
from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.files.parse import load_picked
from fesloop.experiment.files.patients import describe
from fesloop.experiment.running import Experiment, without_stand_in
from fesloop.experiment.shown import exact_ms, wiring_tables
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.latency import MEANING, LatencyReport, StageSummary
from fesloop.loop.realtime import is_live
from fesloop.models.electrode_arrays import FitsArrays

if TYPE_CHECKING:
    from fesloop.analysis.theory.first_answer import FirstAnswer


def execute(args: Namespace) -> int:
    """Validate an experiment; print its wiring, cautions, latency budget, theory, variants and aliases."""
    from fesloop.analysis.theory.first_answer import first_answer

    with progress_bar(f"check {args.experiment}"):
        experiment, picked = load_picked(args.experiment, args.settings, args.seed)
        report = experiment.latency_report()
        theory = first_answer(experiment)
    aliases = picked.document.get("aliases", {})
    if args.json:
        print_json(_table(experiment, report) | {
            "theory": theory.as_table(), "aliases": aliases, "variants": picked.variants})
        return 0
    for number, table in enumerate(wiring_tables(experiment, _patient(experiment))):
        print("\n" * bool(number), end="")
        print_table(table.title, table.columns, table.rows, sys.stdout)
    arrays = arrays_rows(experiment)
    if arrays:
        print()
        print_table("Electrode arrays", ("node", "", ""), arrays, sys.stdout)
    cautions = _cautions(experiment)
    if cautions:
        print()
        print_table("Cautions", ("node", "status", "detail"), cautions, sys.stdout)
    budgets = report.budgets()
    print()
    if not budgets:
        print("No latency budget: no path leads from a plant's output through blocks to a plant's input.")
    else:
        print(fill(f"{MEANING} {report.coverage(experiment.trials)}", 120))
    for title, stages in budgets:
        print()
        print_table(title, ("stage, ms", "min", "mean", "max"), stages, sys.stdout)
    _print_theory(theory)
    for variant, table in picked.variants.items():
        print()
        print_table(f"Options of --set {variant}=...", ("option", "description"),
                    _option_rows(table, picked.options[variant]), sys.stdout)
    if aliases:
        print()
        rows = [(name, key if isinstance(key, str) else ", ".join(key)) for name, key in aliases.items()]
        print_table("Aliases for --set", ("name", "key"), rows, sys.stdout)
    return 0


def _print_theory(theory: FirstAnswer) -> None:
    """Print exact results of the linear theory, and the reason for each that is missing."""
    cost = theory.cost
    stable = cost is not None and cost.stable
    rows = [(f"critical latency of {wire}", critical_text(critical, now, stable), f"{exact_ms(now)} now")
            for wire, (now, critical) in theory.critical_ms.items()]
    if cost is not None and not cost.stable:
        rows.append(("at rest", "never", f"squares grow {cost.growth_per_s:.3g}-fold a second"))
    elif cost is not None:
        in_degrees = cost.unit == "rad"
        values, unit = (cost.rms_deg, "deg") if in_degrees else (cost.rms, cost.unit)
        by_name = ", ".join(f"{name} {value:.4g}" for name, value in zip(cost.names, values, strict=True))
        rows.append((f"rms at rest, {unit}", f"{np.sqrt(np.mean(values**2)):.4g}", by_name))
    if rows:
        print()
        print_table("Theory of the linear loop, while nothing saturates", ("", "exactly", ""), rows,
                    sys.stdout)
    if theory.not_known:
        print()
    for reason in dict.fromkeys(theory.not_known.values()):
        missing = " and ".join(what for what, why in theory.not_known.items() if why == reason)
        print(f"Theory gives no {missing}: {reason}")


def critical_text(latency_ms: float | None, now_ms: float, stable: bool) -> str:
    """Describe the least latency at which the loop is unstable, and whether the present one is stable."""
    if latency_ms is None:
        return "none up to 500 ms"
    critical = exact_ms(latency_ms)
    if stable and latency_ms <= now_ms:
        return f"{critical}, but stable now"
    return critical if latency_ms else f"{critical}: unstable at 0, too"


def _option_rows(table: dict[str, Any], picked: str) -> list[tuple[str, str]]:
    """Options of a variant with their descriptions; the picked one is marked."""
    return [(f"{option} (picked)" if option == picked else option, about)
            for option, about in table["options"].items()]


def _cautions(experiment: Experiment) -> list[tuple[str, str, str]]:
    """Cautions as (node, status, detail): of parameters, latencies, neighbours and live nodes."""
    found = experiment_cautions(experiment)
    if any(is_live(node) for node in experiment.wiring.nodes):
        found += [(name, "not_rehearsed", "it has to be closed at the end and has no stand-in: the run "
                   "starts without a rehearsal, and code is compiled while devices and streams wait")
                  for name in without_stand_in(experiment.wiring)]
    return found


def arrays_rows(experiment: Experiment) -> list[tuple[str, str, str]]:
    """Parameters that the electrode arrays determine, as rows (node, name, value); none without arrays."""
    return [(node.name, *row) for node in experiment.wiring.nodes if isinstance(node.part, FitsArrays)
            for row in node.part.of_arrays()]


def _patient(experiment: Experiment) -> str:
    """The patient in words; empty where there is none."""
    return describe(experiment.patient) if experiment.patient is not None else ""


def _table(experiment: Experiment, report: LatencyReport) -> dict[str, Any]:
    return {
        "experiment": experiment.name,
        "seed": experiment.seed,
        "patient": _patient(experiment) or None,
        "fingerprint": experiment.fingerprint(),
        "document": experiment.document(),
        "cautions": [{"node": node, "status": status, "detail": detail}
                     for node, status, detail in _cautions(experiment)],
        "arrays": [{"node": node, "what": what, "value": value}
                   for node, what, value in arrays_rows(experiment)],
        "latency": [{"path": path.name, "later": path.later, "covers_s": path.covered_ns / NS_PER_S,
                     "stages": [_stage(stage) for stage in path.summary()],
                     "lanes": [_stage(lane) for lane in path.by_lane()]}
                    for path in report.paths],
        "latency_not_counted": report.not_counted,
    }


def _stage(stage: StageSummary) -> dict[str, Any]:
    return {"stage": stage.name, "min_ms": stage.least_ns / NS_PER_MS, "mean_ms": stage.mean_ns / NS_PER_MS,
            "max_ms": stage.most_ns / NS_PER_MS}

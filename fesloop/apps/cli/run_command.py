"""`fesloop run`."""

from __future__ import annotations

import math
import shlex
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from fesloop.apps.cli.output import print_json, print_next_commands, print_table, progress_bar
from fesloop.errors import FesloopError, InputError
from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.files.layout import guide_of
from fesloop.experiment.files.parse import load_picked
from fesloop.experiment.metrics.missing import MISSING, reasons_of
from fesloop.experiment.recording.reading import Event, Recording
from fesloop.experiment.running import Experiment, Result, run
from fesloop.experiment.trouble import graveness, troubles
from fesloop.loop.realtime import Pacing
from fesloop.models.linear_form import LinearPlant

_SHOWN = 10
_CLOSE = 1e-5
"""Excess over 1 of a spectral radius that makes no difference in a run (chosen)."""
_EXIT_CODES = {"done": 0, "failed": 1, "interrupted": 130}

_OPTIONS = {"seed": None, "out": "runs", "late": None, "priority": None}
"""Options of a run that a repetition needs too, with their defaults."""
_RELATIVE = "relative_angle_rmse_deg"
"""Metric of a tracker that shows that `fesloop fit-error` can fit its error."""


def execute(args: Namespace) -> int:
    """Run an experiment, print its summary, and return the exit code of its status."""
    pacing = _pacing(args)
    with progress_bar(args.experiment) as bar:
        experiment, picked = load_picked(args.experiment, args.settings, args.seed)
        cautions = experiment_cautions(experiment, blocks=False)
    for node, status, detail in cautions:
        print(f"fesloop: caution: {node}: {status}: {detail}", file=sys.stderr)
    with progress_bar(args.experiment) as bar:
        if not pacing:
            result = run(experiment, Path(args.out), progress=bar)
    if pacing:  # without a progress bar, which takes tens of ms to draw
        result = run(experiment, Path(args.out), realtime=pacing)
    with Recording(result.recording) as recording:
        wrong, events = troubles(recording, result.metrics, result.cause), recording.events
        scored = str(recording.experiment.get("score", {}).get("orientation") or "").partition(".")[0]
    if unstable := _unstable(experiment):
        print(f"fesloop: {unstable}", file=sys.stderr)
    if result.cause:
        print(f"fesloop: {result.cause}", file=sys.stderr)
    for trouble in wrong:
        if not (result.cause and trouble.kind == "broken_off"):
            print(f"fesloop: {trouble.text}", file=sys.stderr)
    _summarise(result, events, scored)
    print_next_commands(result.recording, _next_commands(args, result, picked.document))
    if args.json:
        print_json({**result.as_table(), **({"troubles": [each.text for each in wrong]} if wrong else {})})
    else:
        print(result.recording)
    return _EXIT_CODES[result.status]


def _next_commands(args: Namespace, result: Result, document: Mapping[str, Any]) -> Iterator[str]:
    """Commands to try next; those are left out that the settings of this run would have refused."""
    guide = guide_of(document) if result.status == "done" else None
    if guide is None:
        return
    options = ["--realtime"] * args.realtime + [
        word for name, default in _OPTIONS.items() if (value := getattr(args, name)) != default
        for word in (f"--{name}", str(value))]
    aliases, made = document.get("aliases", {}), list[str]()
    plain = all(str(aliases.get(key := setting.partition("=")[0].strip(), key)).startswith("experiment.")
                for setting in args.settings)
    for command in guide.next_commands(str(result.recording), args.settings, _RELATIVE in result.metrics,
                                       args.experiment, options):
        words = shlex.split(command)
        if plain or any(each in command for each in made) or _is_sound(words):
            yield command
        made += [words[k + 1] for k, word in enumerate(words) if word == "--out" and words[1] != "run"]


def _is_sound(words: Sequence[str]) -> bool:
    """Whether a command on an experiment loads it."""
    if words[1] not in ("run", "check"):
        return True
    settings = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
    try:
        load_picked(words[2], settings)
    except FesloopError:
        return False
    return True


def _unstable(experiment: Experiment) -> str:
    """A sentence that says that the loop is unstable by theory; empty where theory does not say so."""
    if not any(isinstance(node.part, LinearPlant) for node in experiment.wiring.nodes if node.is_plant):
        return ""
    from fesloop.analysis.theory.critical_latency import growth
    from fesloop.analysis.theory.linear_loop import linear_loop

    try:
        loop = linear_loop(experiment)
        radius = 0.0 if loop.random else math.sqrt(growth(loop))
    except FesloopError:
        return ""
    if radius <= 1.0 + _CLOSE:
        return ""
    return f"the loop is unstable: the spectral radius of its linear part is {radius:.6g}, above 1"


def _pacing(args: Namespace) -> Pacing | bool:
    """Pacing of the run by the wall clock; False without --realtime."""
    given = {"late": args.late, "priority": args.priority}
    options = {name: value for name, value in given.items() if value is not None}
    if options and not args.realtime:
        raise InputError(f"--{next(iter(options))}", "applies to runs in real time only", "with --realtime")
    return args.realtime and Pacing(**options)


def _summarise(result: Result, recorded: Sequence[Event], scored: str) -> None:
    """Print status, events and scalar metrics in one table, then a table for each metric by joint.

    `scored` is the tracker that a replay scores; "" where there is none.
    """
    rows = [["status", result.status], ["seed", str(result.seed)]]
    tables = {}
    for name, value in result.metrics.items():
        if name == MISSING:
            continue
        if isinstance(value, dict) and all(isinstance(item, dict) for item in value.values()):
            tables[name] = value
        elif isinstance(value, dict):
            rows += [[f"{name} {key}", _text(item)] for key, item in value.items()]
        else:
            rows.append([name, _text(value)])
    rows += [["wall time", f"{result.wall_s:.2f} s"], ["real-time factor", f"{result.realtime_factor:.1f}"]]
    rows += _pacing_rows(result.realtime)
    events = _events(recorded, scored)
    shown = sorted(events[:_SHOWN], key=lambda entry: entry[0][0] != scored)
    rows += [["events", f"{count} x {status} ({where})"] for (where, status), count in shown]
    if len(events) > _SHOWN:
        rows.append(["events", f"and {len(events) - _SHOWN} more kinds, in the recording"])
    if events:
        rows.append(["events", "what they mean: docs/events.md"])
    if result.metrics:
        rows.append(["numbers", "what they are: fesloop explain NAME"])
    elif result.status == "done":
        rows.append(["numbers", "none: nothing was scored; a table [score] names what to compare"])
    print_table(result.experiment, ("", ""), rows, sys.stderr)
    for name, reason in reasons_of(result.metrics):
        print(f"{name}: no number: {reason}", file=sys.stderr)
    for name, value in tables.items():
        columns = list(dict.fromkeys(key for item in value.values() for key in item))
        cells = [[key, *(_text(_last(row.get(column))) for column in columns)] for key, row in value.items()]
        print(file=sys.stderr)
        print_table(f"{name}{_of_which_trial(value)}", ("", *columns), cells, sys.stderr)


def _pacing_rows(realtime: dict[str, Any]) -> list[list[str]]:
    """Rows on how a run kept in step with the wall clock; none for a run that did not have to."""
    if not realtime:
        return []
    from fesloop.experiment.metrics.lateness import class_names  # other runs do without

    rows = [["missed deadlines", f"{realtime['missed']} of {realtime['deadlines']}, "
             f"later than {realtime['period_ms']:g} ms ({realtime['policy']})"]]
    rows += [[words, "  ".join(f"{name} {value:.3f}" for name, value in realtime[key].items())]
             for key, words in (("late_ms", "begun late, ms"), ("took_ms", "work took, ms"))]
    starts, counts = realtime["histogram"].values()
    rows += [[f"late by {name}", str(count)]
             for name, count in zip(class_names(starts), counts, strict=True) if count]
    rows += [["instants " + action, str(count)] for action, count in realtime["done"].items()]
    rows.append(["garbage collections", f"{realtime['collections']:g}, the longest "
                 f"{realtime['worst_collection_ms']:.3f} ms"])
    rows.append(["longest write of the recording", f"{realtime['worst_write_ms']:.3f} ms"])
    return [*rows, ["memory", realtime["memory"]], ["scheduling", realtime["scheduling"]]]


def _last(value: Any) -> Any:
    return value[-1] if isinstance(value, list) and value else value


def _of_which_trial(table: dict[str, Any]) -> str:
    """Note that a table shows the last trial, where there are several."""
    lists = [item for row in table.values() for item in row.values() if isinstance(item, list)]
    return f", last trial ({len(lists[0]) - 1}, counted from 0)" if lists and len(lists[0]) > 1 else ""


def _text(value: Any) -> str:
    """Format a value for a cell; a list (one value a trial) side by side."""
    if isinstance(value, list):
        return "  ".join(_text(item) for item in value)
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.3f}" if math.isfinite(value) else "-"
    return str(value)


def _events(events: Sequence[Event], scored: str) -> list[tuple[tuple[str, str], int]]:
    """Count events by node and status, the gravest first, then those of `scored`, then the most frequent."""
    counted = Counter((event.where, event.status) for event in events).most_common()
    return sorted(counted, key=lambda entry: (graveness(entry[0][1]), entry[0][0] != scored))

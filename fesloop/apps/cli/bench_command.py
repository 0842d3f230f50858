"""`fesloop bench`."""

from __future__ import annotations

import pkgutil
import sys
from argparse import Namespace
from importlib import import_module
from inspect import signature
from typing import Any

import fesloop.apps.bench
from fesloop.apps.cli.output import print_json, print_table, progress_bar
from fesloop.errors import InputError, did_you_mean
from fesloop.loop.realtime import Pacing
from fesloop.posix import require_linux

_OF_LINUX = ("realtime", "shipped", "study", "view")
"""Benches that ask the kernel about processes, or keep them on a core."""
_COLUMNS = ("us_median", "us_p99", "us_worst", "reference_us_median", "ratio")


def names() -> list[str]:
    """Names of benches: public modules of fesloop.apps.bench, each with a function `run(progress=...)`."""
    return sorted(module.name for module in pkgutil.iter_modules(fesloop.apps.bench.__path__)
                  if not module.name.startswith("_"))


def execute(args: Namespace) -> int:
    """Run one bench or all."""
    if args.name is not None and args.name not in names():
        raise InputError(f"bench {args.name}", "there is no such bench", ", ".join(names()),
                         did_you_mean(args.name, names()))
    Pacing(priority=args.priority)  # refuses a bad priority before a bench starts a process
    if args.name is not None:
        results = [_one(args.name, args)]
    else:
        results = [_one_of_all(name, args) for name in names()]
    if args.json:
        print_json(results[0] if args.name else {"benches": results})
    return 0


def _one_of_all(name: str, args: Namespace) -> dict[str, Any]:
    """Run a bench; where it cannot run here, print why, so that the others do."""
    try:
        return _one(name, args)
    except InputError as fault:
        print(f"bench {name}: left out: {fault}", file=sys.stderr)
        return {"bench": name, "rows": [], "left_out": str(fault)}


def _one(name: str, args: Namespace) -> dict[str, Any]:
    """Run a bench with the options that it has, and print its rows."""
    if name in _OF_LINUX:
        require_linux(f"bench {name}", "what it measures", "other benches run here")
    with progress_bar(f"bench {name}") as bar:
        bench = import_module(f"fesloop.apps.bench.{name}").run
        known = signature(bench).parameters
        options = {option: getattr(args, option) for option in ("short", "priority") if option in known}
        result: dict[str, Any] = bench(progress=bar, **options)
    rows = [[str(row["case"]), *(_cell(row.get(key)) for key in _COLUMNS)] for row in result["rows"]]
    print_table(f"bench {name}", ("case", *_COLUMNS), rows, sys.stderr)
    for key in ("max_abs_error", "realtime_factor", "missed", "memory_mb", "p99_ratio", "turns",
                "frames_per_s"):
        if result.get(key) is not None:
            print(f"{key}: {_cell(result[key])}", file=sys.stderr)
    return result


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_cell(item)}" for key, item in value.items())
    return "-" if value is None else str(value) if isinstance(value, int) else f"{value:.4g}"

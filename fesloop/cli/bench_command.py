"""`fesloop bench`."""

from __future__ import annotations

import pkgutil
import sys
from argparse import Namespace
from importlib import import_module
from typing import Any

import fesloop.bench
from fesloop.cli.output import print_json, print_table, progress_bar
from fesloop.errors import InputError, did_you_mean

_COLUMNS = ("us_median", "us_p99", "us_worst", "reference_us_median", "ratio")


def names() -> list[str]:
    """Every bench: the public modules of fesloop.bench, each with `run(progress=...)`."""
    return sorted(module.name for module in pkgutil.iter_modules(fesloop.bench.__path__)
                  if not module.name.startswith("_"))


def execute(args: Namespace) -> int:
    """Run one bench or all."""
    if args.name is not None and args.name not in names():
        raise InputError(f"bench {args.name}", "there is no such bench", ", ".join(names()),
                         did_you_mean(args.name, names()))
    results = [_one(name) for name in ([args.name] if args.name else names())]
    if args.json:
        print_json(results[0] if args.name else {"benches": results})
    return 0


def _one(name: str) -> dict[str, Any]:
    """Run a bench and print its rows."""
    with progress_bar(f"bench {name}") as bar:
        result: dict[str, Any] = import_module(f"fesloop.bench.{name}").run(progress=bar)
    rows = [[str(row["case"]), *(_cell(row.get(key)) for key in _COLUMNS)] for row in result["rows"]]
    print_table(f"bench {name}", ("case", *_COLUMNS), rows, sys.stderr)
    for key in ("max_abs_error", "realtime_factor"):
        if result.get(key) is not None:
            print(f"{key}: {_cell(result[key])}", file=sys.stderr)
    return result


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_cell(item)}" for key, item in value.items())
    return "-" if value is None else f"{value:.4g}"

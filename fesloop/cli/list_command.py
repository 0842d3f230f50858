"""`fesloop list`."""

from __future__ import annotations

import sys
from argparse import Namespace

from fesloop.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.parse import read, shipped


def execute(args: Namespace) -> int:
    """Print shipped experiments and block kinds."""
    experiments = {name: str(read(name)[1]["experiment"].get("description", "")) for name in shipped()}
    kinds = {kind: _summary(kind) for kind in registry.kinds()}
    if args.json:
        print_json({"experiments": experiments, "kinds": kinds})
    else:
        print_table("Shipped experiments", ("name", "what it is"), list(experiments.items()), sys.stdout)
        print()
        print_table("Block kinds", ("kind", "what it is"), list(kinds.items()), sys.stdout)
    return 0


def _summary(kind: str) -> str:
    """A line on a kind, also where its package does not import."""
    try:
        return registry.summary(kind)
    except InputError as fault:
        return fault.found

"""`fesloop list`."""

from __future__ import annotations

import sys
from argparse import Namespace

from fesloop.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.parse import read, shipped
from fesloop.experiment.patients import presets


def execute(args: Namespace) -> int:
    """Print shipped experiments, block kinds and patients."""
    experiments = {name: str(read(name)[1]["experiment"].get("description", "")) for name in shipped()}
    kinds = {kind: _summary(kind) for kind in registry.kinds()}
    patients = presets()
    if args.json:
        print_json({"experiments": experiments, "kinds": kinds, "patients": patients})
    else:
        print_table("Shipped experiments", ("name", "what it is"), list(experiments.items()), sys.stdout)
        print()
        print_table("Block kinds", ("kind", "what it is"), list(kinds.items()), sys.stdout)
        print()
        print_table("Patients", ("name", "who it is"), list(patients.items()), sys.stdout)
    return 0


def _summary(kind: str) -> str:
    """A line on a kind, also where its package does not import."""
    try:
        return registry.summary(kind)
    except InputError as fault:
        return fault.found

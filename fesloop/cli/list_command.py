"""`fesloop list`."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

from fesloop.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.files.parse import read, shipped
from fesloop.experiment.files.patients import presets
from fesloop.experiment.files.variants import listed
from fesloop.study.design.study_file import described_studies


def execute(args: Namespace) -> int:
    """Print shipped experiments and their variants, studies, block kinds and patients."""
    documents = {name: read(name)[1] for name in shipped()}
    experiments = {name: str(each["experiment"].get("description", "")) for name, each in documents.items()}
    variants = {name: listed(each) for name, each in documents.items() if "variants" in each}
    kinds = {kind: _summary(kind) for kind in registry.kinds()}
    patients, studies = presets(), described_studies()
    if args.json:
        print_json({"experiments": experiments, "variants": variants, "studies": studies, "kinds": kinds,
                    "patients": patients})
    else:
        print_table("Shipped experiments", ("name", "what it is"), list(experiments.items()), sys.stdout)
        if variants:
            print()
            print_table("Their variants", ("name", "--set", "options, the default first"), [
                (name, f"{variant}=...", _options(table)) for name, each in variants.items()
                for variant, table in each.items()], sys.stdout)
        print()
        print_table("Shipped studies", ("name", "--form", "what it is, and what the form costs"), [
            (name, form, text) for name, each in studies.items() for form, text in each.items()], sys.stdout)
        print()
        print_table("Block kinds", ("kind", "what it is"), list(kinds.items()), sys.stdout)
        print()
        print_table("Patients", ("name", "who it is"), list(patients.items()), sys.stdout)
    return 0


def _options(table: dict[str, Any]) -> str:
    """Options of a variant in a line."""
    return ", ".join(dict.fromkeys([table["default"], *table["options"]]))


def _summary(kind: str) -> str:
    """A line on a kind, also where its package does not import."""
    try:
        return registry.summary(kind)
    except InputError as fault:
        return fault.found

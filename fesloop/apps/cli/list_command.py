"""`fesloop list`."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from typing import Any

from fesloop.analysis.study.design.shipped_studies import described_studies
from fesloop.analysis.study.results.quantities import duration_text
from fesloop.apps.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.files.source import read_experiment, shipped
from fesloop.experiment.files.variants import listed

_JOBS = {"closed_loop": "A closed loop around a virtual patient",
         "array_search": "Electrodes searched for on arrays",
         "hardware": "Hardware in the loop, recorded and live streams",
         "trackers": "Hand trackers by themselves"}


_COMPILING = ("takes: run time once code is compiled, measured on one machine. The first run of a kind on a "
              "machine\nalso compiles: half a minute more, or longer.")
"""Measured: 25 s of processor for `finger_mpc` with an empty cache, 2 s with a full one."""


def execute(args: Namespace) -> int:
    """Print shipped experiments and their variants, studies, block kinds and patients."""
    documents = {name: read_experiment(name)[1] for name in shipped()}
    experiments = {name: _experiment(each) for name, each in documents.items()}
    variants = {name: listed(each) for name, each in documents.items() if "variants" in each}
    kinds = {kind: _summary(kind) for kind in registry.kinds()}
    patients, studies = registry.patient_presets(), described_studies()
    if args.json:
        print_json({"experiments": experiments, "variants": variants, "studies": studies, "kinds": kinds,
                    "patients": patients})
    else:
        _print_experiments(documents)
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


def _experiment(document: Mapping[str, Any]) -> dict[str, Any]:
    """Description and guide of a shipped experiment."""
    optional: dict[str, Any] = {"needs": [], "needs_with": {}, "try_next": [], "try_next_with": {}}
    guide = document.get("guide")
    return {"description": _description(document), **(optional | guide if guide else {})}


def _print_experiments(documents: Mapping[str, Mapping[str, Any]]) -> None:
    """Print a table of experiments for each job."""
    guides = {name: each["guide"] for name, each in documents.items() if "guide" in each}
    for job, title in _JOBS.items():
        rows = [(name, duration_text(guide["takes_s"]), ", ".join(guide.get("needs", ())),
                 _description(documents[name]))
                for name, guide in guides.items() if guide["job"] == job]
        print_table(title, ("name", "takes", "needs", "what it is"), rows, sys.stdout)
        print()
    print(_COMPILING)
    print()
    print_table("What settings need", ("--set", "needs", "in"), _needs_of_settings(guides), sys.stdout)
    print()


def _description(document: Mapping[str, Any]) -> str:
    return str(document["experiment"].get("description", ""))


def _needs_of_settings(guides: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str, str]]:
    """Settings that need something, what they need, and the experiments that have them."""
    found: dict[tuple[str, str], list[str]] = {}
    for name, guide in guides.items():
        for pair in guide.get("needs_with", {}).items():
            found.setdefault(pair, []).append(name)
    return [(setting, need, ", ".join(names)) for (setting, need), names in found.items()]


def _options(table: dict[str, Any]) -> str:
    """Options of a variant, the default first."""
    return ", ".join(dict.fromkeys([table["default"], *table["options"]]))


def _summary(kind: str) -> str:
    """Summary line of a kind; the reason if its package cannot be imported."""
    try:
        return registry.summary(kind)
    except InputError as fault:
        return fault.found

"""`fesloop patient`."""

from __future__ import annotations

from argparse import Namespace

from fesloop.apps.cli.output import print_json
from fesloop.experiment.files.patients import drawn_patient
from fesloop.forms.toml import toml_text


def execute(args: Namespace) -> int:
    """Print a patient as the text of a file that defines the same patient."""
    choice = {key: getattr(args, key) for key in ("file", "cohort", "member", "day")}
    tables = drawn_patient({key: value for key, value in choice.items() if value is not None}).table()
    if args.json:
        print_json(tables)
    else:
        print(toml_text(tables), end="")
    return 0

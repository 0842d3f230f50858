"""`fesloop schema`."""

from __future__ import annotations

from argparse import Namespace

from fesloop.apps.cli.output import print_json
from fesloop.experiment.files.layout import json_schema


def execute(args: Namespace) -> int:
    """Print the JSON Schema of experiment files, with the parameters of every block kind."""
    print_json(json_schema())
    return 0

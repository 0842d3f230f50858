"""What commands say at their end: where the report is, and what to try next."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from pathlib import Path


def tell_what_next(results: Path, commands: Iterable[str]) -> None:
    """On standard error: the command that makes the report of these results, and those to try next."""
    print(f"report: fesloop report {shlex.quote(str(results))}", file=sys.stderr)
    for command in commands:
        print(f"next:   {command}", file=sys.stderr)

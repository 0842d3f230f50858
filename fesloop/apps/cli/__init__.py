"""The command line: `fesloop COMMAND ...`. What a command needs is imported when it runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from fesloop.apps.cli.greeting import GREETING
from fesloop.apps.cli.parser import make_parser
from fesloop.errors import InputError, RunError, in_one_line, where_it_broke

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
_BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Matrices here are small: threads of BLAS wait for each other longer than they multiply (measured in
`fesloop.analysis.theory`: 12 times the CPU time), and sums in another order are other bits. A study's workers
have one thread each as well."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and give its exit code; a mistake of the user's ends in one line a fault.

    Without a command it greets.
    """
    given = sys.argv[1:] if argv is None else argv
    if not given:
        print(GREETING, end="")
        return DONE
    args = make_parser().parse_args(given)
    for name in _BLAS_THREADS:
        os.environ.setdefault(name, "1")
    try:
        return int(import_module(f"fesloop.apps.cli.{args.command.replace('-', '_')}_command").execute(args))
    except InputError as fault:
        return _refused(fault, getattr(args, "json", False))
    except RunError as fault:
        print(f"fesloop: {in_one_line(str(fault), 3000)}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print("fesloop: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return FAILED
    except Exception as fault:
        if args.traceback:
            raise
        print(f"fesloop: an error inside fesloop or a block, {in_one_line(where_it_broke(fault))}; "
              "--traceback before the command shows the way there", file=sys.stderr)
        return FAILED


def _refused(fault: InputError, as_json: bool) -> int:
    """Name every fault; with --json also as the one object on standard output."""
    lines = [" ".join(line.split()) for line in str(fault).splitlines()]
    for line in lines:
        print(f"fesloop: {line}", file=sys.stderr)
    if as_json:
        from fesloop.apps.cli.output import print_json

        print_json({"status": "refused", "faults": lines})
    return BAD_INPUT

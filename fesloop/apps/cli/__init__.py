"""The command line: `fesloop COMMAND ...`. A command imports what it needs when it runs."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from fesloop.apps.cli.parser import make_parser
from fesloop.errors import InputError, RunError, in_one_line, where_it_broke

GREETING = """\
fesloop: closed-loop co-simulation of functional electrical stimulation of the
hand, where the hand tracker is one block of an exactly timed loop.

A virtual patient's paralysed hand learns to grasp through a tracker:
    fesloop run grasp_ilc                           (about 35 s)
  the error of each trial, what of it is the tracker's, and what was held.

Electrodes that open the hand are searched for on arrays on the forearm:
    fesloop run array_search_two_phase              (about 70 s)
  what was found, how well it does, queries and minutes of the patient's time.

The same controllers beside hardware, in step with the wall clock:
    fesloop run hil_dry_stimulator --realtime       (about 9 s)
  how late each tick was; commands go to a device that only writes them down.

What latency, trackers and patients do to any of these is a study (extra
`study`):  fesloop study linear_map

fesloop list            every experiment, how long it takes and what it needs
fesloop check NAME      how an experiment is wired, and its latency budget
fesloop report RUN.h5   a run, several, or a study as one page to read and share
fesloop --help          all commands
Documentation: README.md and docs/ where fesloop's sources are.
"""
"""Printed by `fesloop` without a command."""

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
_BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Environment variables that are set to one thread, as for the workers of a study.

Matrices here are small: BLAS threads wait for each other longer than they multiply (12 times the CPU time,
measured in `fesloop.analysis.theory`), and another order of summation changes the last bits.
"""
_COLLECT_AFTER = 100_000
"""Objects after which garbage is collected: modules are none. Collections during imports, and the one at the
end of the process, which is left out, took 0.7 s of `fesloop run grasp_ilc`."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; prints one line for each fault in the user's input.

    Without a command, prints an introduction.
    """
    given = sys.argv[1:] if argv is None else argv
    if not given:
        print(GREETING, end="")
        return DONE
    args = make_parser().parse_args(given)
    for name in _BLAS_THREADS:
        os.environ.setdefault(name, "1")
    gc.set_threshold(_COLLECT_AFTER, *gc.get_threshold()[1:])
    atexit.register(gc.freeze)
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
        print(f"fesloop: internal error in fesloop or in a block, {in_one_line(where_it_broke(fault))}; "
              "put --traceback before the command to see the traceback", file=sys.stderr)
        return FAILED


def _refused(fault: InputError, as_json: bool) -> int:
    """Print every fault; with --json also as one object on standard output."""
    lines = [" ".join(line.split()) for line in str(fault).splitlines()]
    for line in lines:
        print(f"fesloop: {line}", file=sys.stderr)
    if as_json:
        from fesloop.apps.cli.output import print_json

        print_json({"status": "refused", "faults": lines})
    return BAD_INPUT

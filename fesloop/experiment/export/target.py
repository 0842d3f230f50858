"""Target of an export: a hidden draft beside it, renamed once it is complete."""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.experiment.recording.reading import Piece
from fesloop.given_files import exists
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import NEVER


@contextmanager
def published(target: Path, single: bool) -> Iterator[Path]:
    """Yield a draft folder, which becomes the target; with `single` its only file does.

    Raises InputError where the target exists or cannot be made, RunError where it cannot be written to the
    end, as on a full disk.
    """
    draft = _draft(target)
    try:
        yield draft
        _publish(draft, target, single)
    except OSError as fault:
        raise _failure(target, fault) from fault
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _draft(target: Path) -> Path:
    """A new hidden folder beside the target; folders above it are made."""
    where = f"--out {target}"
    if exists(target):
        raise InputError(where, "is there already", "a name that is free", "give another, or remove it")
    draft = target.parent / f".{target.name}-{secrets.token_hex(8)}"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.mkdir()
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise InputError(where, f"nothing can be made there: {reason}",
                         "in a folder that can be written to") from None
    return draft


def _publish(draft: Path, target: Path, single: bool) -> None:
    """Give what was written its name in one step, and overwrite nothing."""
    for path in draft.rglob("*"):
        if path.is_file():
            with path.open("rb") as file:
                os.fsync(file.fileno())
    if not single:
        draft.rename(target)
        return
    (written,) = draft.iterdir()
    try:
        target.hardlink_to(written)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if target.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        written.rename(target)


def _failure(target: Path, fault: OSError) -> RunError:
    """Error for a target that cannot be written."""
    if fault.errno in (errno.ENOSPC, errno.EDQUOT):
        return RunError(f"--out {target}: the disk is full; make room, or give another folder; "
                        "nothing was exported")
    return RunError(f"--out {target}: cannot be written: {fault.strerror or fault}; nothing was exported")


def file_name(name: str) -> str:
    """A name for any file system: only letters, digits, dots, dashes, and underscores for anything else."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name).lstrip(".") or "_"


def unique(names: Sequence[str], between: str = "_") -> list[str]:
    """The same names, with a number behind each that repeats an earlier one in any case of letters."""
    found: list[str] = []
    for name in names:
        number, tried = 1, name
        while tried.lower() in {other.lower() for other in found}:
            number += 1
            tried = f"{name}{between}{number}"
        found.append(tried)
    return found


def seconds(times_ns: NDArray[np.int64], never: str) -> list[str]:
    """Instants as s with nine decimals, exact; `never` in place of what was not captured at all."""
    return [never if time == NEVER else f"-{instant(-time)}" if time < 0 else instant(time)
            for time in times_ns.tolist()]


def instant(time_ns: int) -> str:
    """One instant, not below 0, as s with nine decimals."""
    whole, rest = divmod(time_ns, NS_PER_S)
    return f"{whole}.{rest:09d}"


def numbers(values: NDArray[np.float64], missing: str) -> Iterator[list[str]]:
    """Rows of values (n, ...) as text: `repr` is the shortest that reads back as the same float."""
    rows = values.reshape(len(values), -1)
    if np.isnan(rows).any():
        return ([missing if number != number else repr(number) for number in row] for row in rows.tolist())
    return (list(map(repr, row)) for row in rows.tolist())


def lines(columns: Iterable[Iterable[str]], rows: Iterator[list[str]], separator: str) -> str:
    """Lines of leading columns and of rows of numbers."""
    leading = zip(*columns, strict=True)
    return "".join(f"{separator.join((*first, *row))}\n" for first, row in zip(leading, rows, strict=True))


def side_by_side(piece: Piece) -> NDArray[np.float64]:
    """Values of all signals of a piece, (n, channels)."""
    return np.concatenate([values.reshape(len(values), -1) for values in piece.values], axis=1)

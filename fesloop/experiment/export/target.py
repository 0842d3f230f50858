"""Where an export goes: a hidden draft beside it, and its name once it is whole."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fesloop.errors import InputError, RunError
from fesloop.given_files import exists


@contextmanager
def published(target: Path, single: bool) -> Iterator[Path]:
    """A folder to write into, which then is the target; with `single` its one file is. Else nothing is left.

    Raises InputError where the target exists or cannot be made, RunError where it cannot be written to the
    end, as on a full disk.
    """
    draft = _draft(target)
    try:
        yield draft
        _publish(draft, target, single)
    except OSError as fault:
        raise _told(target, fault) from fault
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


def _told(target: Path, fault: OSError) -> RunError:
    """What went wrong; a recording that cannot be read says so itself."""
    if fault.errno in (errno.ENOSPC, errno.EDQUOT):
        return RunError(f"--out {target}: the disk is full; make room, or give another folder; "
                        "nothing was exported")
    return RunError(f"--out {target}: cannot be written: {fault.strerror or fault}; nothing was exported")

"""Where a command leaves the one file that it makes."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryFile

from fesloop.errors import InputError


def free_target(given: str, where: str) -> Path:
    """The path of a file that is to be made, looked at before the work and not after it; folders are made.

    Parameters
    ----------
    given: the path. where: what it was given as, for messages.

    Raises InputError where something of this name is there, or nothing can be made.
    """
    path = Path(given)
    try:
        there = path.exists() or path.is_symlink()
        path.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path.parent):
            pass
    except OSError as fault:
        raise InputError(where, f"nothing can be made there: {fault.strerror or fault}",
                         "in a folder that can be written to") from None
    if there:
        raise InputError(where, "is there already", "a name that is free", "give another, or remove it")
    return path

"""Files that a user names, looked up and read without any failure but an InputError."""

from __future__ import annotations

import os
from pathlib import Path

from fesloop.errors import InputError

_MOST_BYTES = 2**28
"""Greatest size of a file that is read whole (chosen: a hundred times the greatest model file)."""


def exists(path: Path) -> bool:
    """True if something has this name, a dangling link included; no name raises."""
    return os.path.lexists(path)


def is_file(path: Path) -> bool:
    """True for a regular file; False for names that no file can have, where `Path.is_file` raises."""
    return os.path.isfile(path)  # noqa: PTH113


def is_folder(path: Path) -> bool:
    """True for a folder; False for names that no folder can have, where `Path.is_dir` raises."""
    return os.path.isdir(path)  # noqa: PTH112


def read_whole(path: str | Path, allowed: str) -> bytes:
    """All bytes of a file.

    Raises InputError, with what is `allowed`, where it cannot be read, is a pipe or a device, whose end may
    never come, or is too large.
    """
    file = Path(path)
    try:
        if os.path.exists(file) and not is_file(file) and not is_folder(file):  # noqa: PTH110
            raise InputError(str(path), "is a pipe or a device", f"{allowed}, as a file",
                             "copy what it gives to a file")
        with file.open("rb") as opened:
            content = opened.read(_MOST_BYTES + 1)
    except OSError as fault:
        raise InputError(str(path), f"cannot be read: {fault.strerror}", allowed) from None
    except ValueError as fault:  # a name with a null character, or one that the file system cannot encode
        raise InputError(str(path), f"cannot be read: {fault}", allowed) from None
    if len(content) > _MOST_BYTES:
        raise InputError(str(path), f"is larger than {_MOST_BYTES / 1e6:.0f} MB", allowed)
    return content

"""Names of files, variables and columns: none that a system does not take, and none twice."""

from __future__ import annotations

import re
from collections.abc import Sequence


def file_name(name: str) -> str:
    """A name that any file system takes: what is no letter, digit, dot, dash or underscore is one."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name).lstrip(".") or "_"


def unique(names: Sequence[str], between: str = "_") -> list[str]:
    """The same names, those that stand there already, in small or capital letters, with a number behind."""
    found: list[str] = []
    for name in names:
        number, tried = 1, name
        while tried.lower() in {other.lower() for other in found}:
            number += 1
            tried = f"{name}{between}{number}"
        found.append(tried)
    return found

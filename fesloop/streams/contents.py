"""Files that an experiment plays, identified by what they say and not by their paths alone."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError


def content_hash(named: Any, arrays: Sequence[NDArray[Any] | None]) -> str:
    """SHA-256 of plain values and of arrays with their types and shapes, as hexadecimal text."""
    forms = [None if array is None else [array.dtype.str, array.shape] for array in arrays]
    total = hashlib.sha256(json.dumps([named, forms]).encode())
    for array in arrays:
        if array is not None:
            total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


def require_the_same(path: str, given: str, found: str) -> None:
    """Raise InputError for a file whose contents are not those of a fingerprint that is given."""
    if given not in ("", found):
        raise InputError("recording", f"{path} has changed, its fingerprint is {found[:12]}", f"{given[:12]}",
                         'bring the file back, or set fingerprint to "" to play this one')

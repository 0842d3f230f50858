"""Theory's lines kept beside a study's results: they take longer to find than to draw."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from fesloop.analysis.study.store.file import THEORY
from fesloop.errors import InputError
from fesloop.show.figures.overlays import Overlay


def keep_overlays(folder: Path, created: str, overlays: Mapping[str, Sequence[Overlay]]) -> None:
    """Write the overlays of a study's figures, by figure, into the folder of its store.

    `created`: when the store was, which tells it from another that stands in its place later. Raises
    InputError where the file cannot be written.
    """
    path = folder / THEORY
    tables = {name: [asdict(overlay) for overlay in each] for name, each in overlays.items()}
    try:
        path.write_text(json.dumps({"created": created, "figures": tables}), encoding="utf-8")
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror}",
                         "a folder that can be written") from None


def kept_overlays(folder: Path, created: str) -> dict[str, list[Overlay]]:
    """The overlays by figure; none where none were kept, or those of another store.

    Raises InputError for a file that cannot be read or is damaged.
    """
    path = folder / THEORY
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["created"] != created:
            return {}
        return {str(name): [Overlay(**table) for table in tables]
                for name, tables in found["figures"].items()}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as fault:
        raise InputError(str(path), f"cannot be read: {fault}", "lines that `fesloop study` kept",
                         "remove it, and start the study again: no run is run twice") from None

"""Paths in a file start from the folder of that file; those of `--set` from the current folder.

A value that names what is shipped stays as it is: a preset of a patient, a model, an FMU.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fesloop.models.patient_model import shipped_models

_KEYS = ("file", "path", "recording", "layout")
"""Parameters of blocks, and of tables in them, whose text is a path."""
_SHIPPED = "shipped:"


def placed(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables of an experiment file in a folder, the paths in them as seen from the current folder."""
    return {key: _placed((key,), value, folder) for key, value in document.items()}


def placed_value(path: Sequence[str], value: Any, folder: Path | None) -> Any:
    """What a file in a folder puts at a path of an experiment; None: a file that is shipped."""
    return value if folder is None else _placed(tuple(path), value, folder)


def _placed(path: tuple[str, ...], value: Any, folder: Path) -> Any:
    if path[0] == "variants" and len(path) > 3:
        path = path[3:]
    if isinstance(value, dict):
        return {key: _placed((*path, key), each, folder) for key, each in value.items()}
    if isinstance(value, list):
        return [_placed(path, each, folder) for each in value]
    return str(folder / value) if isinstance(value, str) and _is_path(path, value) else value


def _is_path(path: tuple[str, ...], text: str) -> bool:
    if path == ("patient", "file"):
        return text.endswith(".toml") or "/" in text
    if path[0] != "blocks" or len(path) < 3 or path[-1] not in _KEYS:
        return False
    return bool(text) and not text.startswith(_SHIPPED) and text not in shipped_models()

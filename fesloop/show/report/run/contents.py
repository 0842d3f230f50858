"""What is in an HDF5 file that is no recording, or one of a form that is not known here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py

from fesloop.errors import InputError
from fesloop.show.report.parts import Notice, Page, Part, Section, Table
from fesloop.show.report.run.words import counted

_MOST_ROWS, _LONGEST = 400, 120
"""Items and attributes listed, and letters of a value (chosen)."""


def contents_page(path: Path, fault: InputError) -> Page:
    """A page of the file's items and attributes, and why there is no more of it.

    Raises `fault` where it is no HDF5 file either.
    """
    try:
        with h5py.File(path, "r") as file:
            items, attributes = _listed(file)
    except (OSError, RuntimeError):
        raise fault from None
    parts: list[Part] = [
        Notice(text=f"This is no recording that can be read here: {fault}. What it holds is listed."),
        Table(title="Items", columns=["name", "what it is"], rows=items[:_MOST_ROWS]),
        Table(title="Attributes", columns=["of", "name", "value"], rows=attributes[:_MOST_ROWS])]
    left_out = max(len(items) - _MOST_ROWS, 0) + max(len(attributes) - _MOST_ROWS, 0)
    if left_out:
        parts.append(Notice(text=f"{counted(left_out, 'row')} are left out."))
    return Page(title=path.name, sentence="This file is no recording that can be read here; nothing is said "
                "of any run.", facts=[("file", str(path)), ("size", f"{path.stat().st_size:,} bytes")],
                sections=[Section(key="contents", title="What is in the file", parts=parts)])


def _listed(file: h5py.File) -> tuple[list[list[str]], list[list[str]]]:
    """Rows of items, and rows of attributes."""
    items: list[list[str]] = []
    attributes = [["/", key, _short(value)] for key, value in file.attrs.items()]

    def note(name: str, item: Any) -> None:
        items.append([name, _short(_extent(item) if isinstance(item, h5py.Dataset) else "group")])
        attributes.extend([name, key, _short(value)] for key, value in item.attrs.items())

    file.visititems(note)
    return items, attributes


def _extent(item: h5py.Dataset) -> str:
    """Type and size of a dataset."""
    if item.shape is None:
        return f"{item.dtype}, empty"
    return f"{item.dtype}, {' x '.join(map(str, item.shape)) or 'one value'}"


def _short(value: Any) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST - 1]}…"

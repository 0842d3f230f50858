"""Opening the file of a run for its report, also if it is damaged, of another version, or no recording."""


from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import h5py

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording, open_file
from fesloop.experiment.recording.rescue import rescued
from fesloop.experiment.recording.writing import FORMAT
from fesloop.given_files import is_file
from fesloop.show.report.parts import Notice, Page, Part, Section, Table
from fesloop.show.report.run.words import counted


@contextmanager
def readable(path: Path) -> Iterator[tuple[Recording, Sequence[str]]]:
    """Open a recording, and list what is known to be missing from its file, a sentence each.

    Of a damaged file, the rest is opened. Raises InputError if nothing readable is left.
    """
    with ExitStack() as stack:
        try:
            recording, notices = _sound(path, stack), []
        except InputError as fault:
            if not is_file(path):
                raise
            try:
                found = stack.enter_context(rescued(path))
                recording = _sound(found.path, stack)
            except InputError:
                raise fault from None
            notices = [f"The file is damaged ({fault.found}). Its readable part is shown.", *found.losses]
        form = _form(recording.path)
        if form != FORMAT:
            notices = [f"The format of the file is {form!r}; the parts of a {FORMAT!r} are shown, and "
                       "additions of another version are not.", *notices]
        yield recording, notices


def _sound(path: Path, stack: ExitStack) -> Recording:
    """Open a recording and check that its tables can be read."""
    recording = stack.enter_context(Recording(path))
    _ = recording.trials, recording.status, recording.wall, recording.events, recording.messages
    return recording


def _form(path: Path) -> str:
    with open_file(path) as file:
        return str(file.attrs["format"])


_MOST_ROWS, _LONGEST = 400, 120
"""Most items and attributes listed, and letters of a value (chosen)."""


def contents_page(path: Path, fault: InputError) -> Page:
    """Page that lists the items and attributes of a file, and why there is no more.

    Raises `fault` if the file is not HDF5 either.
    """
    try:
        with h5py.File(path, "r") as file:
            items, attributes = _listed(file)
    except (OSError, RuntimeError):
        raise fault from None
    parts: list[Part] = [
        Notice(text=f"This file is not a readable recording: {fault}. Its contents are listed below."),
        Table(title="Items", columns=["name", "what it is"], rows=items[:_MOST_ROWS]),
        Table(title="Attributes", columns=["of", "name", "value"], rows=attributes[:_MOST_ROWS])]
    left_out = max(len(items) - _MOST_ROWS, 0) + max(len(attributes) - _MOST_ROWS, 0)
    if left_out:
        parts.append(Notice(text=f"{counted(left_out, 'row')} are omitted."))
    return Page(title=path.name, sentence="This file is not a readable recording; there is no run to "
                "report.", facts=[("file", str(path)), ("size", f"{path.stat().st_size:,} bytes")],
                sections=[Section(key="contents", title="Contents of the file", parts=parts)])


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

"""Recordings of stimulated muscle: one way to open any of them, known by their content."""

from __future__ import annotations

from pathlib import Path

from fesloop.errors import InputError
from fesloop.given_files import is_file
from fesloop.streams.reading import ZIP, form_of, head_of, is_hdf5, read_file
from fesloop.streams.stimulation import stored
from fesloop.streams.stimulation.published import PUBLISHED, read_published
from fesloop.streams.stimulation.recording import StimulationRecording, utf8_name
from fesloop.streams.stimulation.stored import write_stimulation
from fesloop.streams.stimulation.table import read_tables

ALLOWED = ("a TOML file that describes tables of trials, a NumPy .npz archive of a known set "
           f"({', '.join(each.name for each in PUBLISHED)}), or {stored.ALLOWED}")


_TABLES = (".csv", ".tsv", ".txt")


def open_stimulation(path: str | Path) -> StimulationRecording:
    """The recording in a file.

    Parameters
    ----------
    path: of a file that `fesloop import --stimulation` wrote; a TOML file that describes tables
        (`fesloop.streams.stimulation.table`), or a table that has one of its name beside it; or a NumPy
        archive of a published set (`fesloop.streams.stimulation.published`).

    Raises InputError, naming file, table, row and column, for anything that is not a sound recording.
    """
    file = Path(path)
    head = head_of(file, ALLOWED)
    if file.suffix == ".toml":
        return read_tables(file)
    if file.suffix in _TABLES:
        layout = file.with_suffix(".toml")
        if not is_file(layout):
            raise InputError(str(file), "is a table that no file describes", f"{layout.name} beside it",
                             "describe it there: docs/howto/stimulation_recordings.md")
        return read_tables(layout)
    if is_hdf5(head):
        return stored.recording_in(read_file("hdf5", file), file)
    if head.startswith(ZIP):
        content = read_file("npz", file)
        found = read_published(content, str(file), utf8_name(file))
        if found is None:
            keys = ", ".join(list(content)[:8]) or "nothing"
            raise InputError(str(file), f"is no archive of a known set, it holds {keys}", ALLOWED)
        return found
    raise InputError(str(file), "is empty" if not head else "is no recording of a known format", ALLOWED)


def is_stimulation(path: Path) -> bool:
    """Return whether a file is one that `fesloop import --stimulation` wrote."""
    try:
        return form_of(path) == stored.FORMAT
    except InputError:
        return False


def import_stimulation(source: str | Path, target: str | Path) -> StimulationRecording:
    """Read a recording, write it as fesloop's own file (`fesloop.streams.stimulation.stored`), and give it.

    Raises InputError as `open_stimulation` does, and where `target` exists or cannot be written.
    """
    recording = open_stimulation(source)
    write_stimulation(recording, Path(target))
    return recording

"""The tables of a TOML file, laid over those of the file that it extends.

    extends = "hand_rig"

names a shipped file, or the path of one of the user's, from the folder of the file that says so. What a file
says is laid over what it extends; that may extend another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import read_whole
from fesloop.models.patient_model import shipped_models

Tables = dict[str, Any]
Overlay = Callable[[Tables, Mapping[str, Any]], Tables]
DEEPEST = 16
"""Files that extend each other (chosen)."""


class Shelf(NamedTuple):
    """Where shipped files of one kind are.

    Attributes
    ----------
    what: what a file is, for messages, such as "experiment".
    package: whose folder `shipped` holds them, and whose folder `shipped/parts` files that others extend.
    placed: of the tables of a user's file, and its folder: the same, with the paths in them starting there.
    """

    what: str
    package: str
    placed: Callable[[Tables, Path], Tables] = lambda tables, _: tables

    @property
    def a_file(self) -> str:
        """A file of this kind, for messages."""
        return f"{'an' if self.what[0] in 'aeiou' else 'a'} {self.what} file"

    def names(self, parts: bool = False) -> list[str]:
        """Names of shipped files; with `parts` also of those that are only there to be extended."""
        folder = resources.files(self.package) / "shipped"
        found = [*folder.iterdir()]
        if parts and (folder / "parts").is_dir():
            found += (folder / "parts").iterdir()
        return sorted(file.name.removesuffix(".toml") for file in found if file.name.endswith(".toml"))

    def content(self, name: str) -> bytes:
        """A shipped file."""
        folder = resources.files(self.package) / "shipped"
        file = folder / f"{name}.toml"
        return (file if file.is_file() else folder / "parts" / f"{name}.toml").read_bytes()


def read_tables(source: str | Path, shelf: Shelf, overlay: Overlay) -> tuple[str, Tables, Path | None]:
    """Name for messages, tables, and the folder of a file; None for a shipped one.

    `overlay(base, tables)` lays tables over what they extend. Raises InputError for a file that cannot be
    read or is not TOML, for what it extends and cannot, and whatever `overlay` raises, with the file's name.
    """
    return _read(source, shelf, overlay, None, ())


def _read(source: str | Path, shelf: Shelf, overlay: Overlay, folder: Path | None,
          below: tuple[str, ...]) -> tuple[str, Tables, Path | None]:
    """As `read_tables`; from the folder of the file that extends it, `below` those that do."""
    text = str(source)
    shipped = isinstance(source, str) and not text.endswith(".toml") and "/" not in text
    path = None if shipped else (folder or Path()) / Path(source)
    name = text if path is None or folder is None else str(path)
    content = _shipped(text, shelf, bool(below)) if path is None else read_whole(path, shelf.a_file)
    document = _tables(name, content)
    if path is not None:
        document = shelf.placed(document, path.parent)
    if "extends" not in document:
        return name, document, path and path.parent
    extended = document.pop("extends")
    if not isinstance(extended, str):
        raise InputError(f"{name}: extends", f"{extended!r} is no text", f"name or path of {shelf.a_file}")
    if name in below or len(below) == DEEPEST:
        raise InputError(f"{name}: extends",
                         "leads round in a circle" if name in below else "leads too deep",
                         f"a file that extends at most {DEEPEST} others, and not itself")
    base = _read(extended, shelf, overlay, path.parent if path else None, (*below, name))[1]
    try:
        return name, overlay(base, document), path and path.parent
    except InputError as fault:
        raise fault.within(name) from None


def _shipped(name: str, shelf: Shelf, parts: bool) -> bytes:
    known = shelf.names(parts)
    if name not in known:
        raise InputError(name, f"there is no shipped {shelf.what} of this name", ", ".join(known),
                         did_you_mean(name, known) or "or give the path of a .toml file")
    return shelf.content(name)


def _tables(name: str, content: bytes) -> Tables:
    try:
        return tables_of(content.decode("utf-8-sig"))
    except UnicodeDecodeError as fault:
        raise InputError(name, f"is not UTF-8 text (byte {fault.start})", "a TOML file") from None
    except TomlError as fault:
        raise InputError(name, f"is not TOML: {fault}", remedy="mend the line") from None


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

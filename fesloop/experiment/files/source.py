"""Experiment, study and patient files as tables, each merged over the file that it extends.

    extends = "hand_rig"

names a shipped file, or the path of a user's file relative to the folder of the extending file. An extended
file may itself extend another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.files.overlay import Tables, extended, of_its_own
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import is_file, read_whole

Overlay = Callable[[Tables, Mapping[str, Any]], Tables]
DEEPEST = 16
"""Most files that extend each other (chosen)."""


class Shelf(NamedTuple):
    """Shipped files of one kind, and how files of that kind are read.

    Attributes
    ----------
    what: kind of file for messages, such as "experiment".
    package, folder: package with the files in a folder, and those that others extend in its folder `parts`.
    overlay: merges tables over those that they extend.
    placed: makes the paths in a user's tables relative to the current folder, given those and their folder.
    """

    what: str
    package: str
    overlay: Overlay
    placed: Callable[[Tables, Path], Tables] = lambda tables, _: tables
    folder: str = "shipped"

    @property
    def a_file(self) -> str:
        """Noun phrase for messages: "an experiment file"."""
        return f"{'an' if self.what[0] in 'aeiou' else 'a'} {self.what} file"

    def names(self, parts: bool = False) -> list[str]:
        """Names of shipped files; with `parts` also of those that only serve to be extended."""
        folder = resources.files(self.package) / self.folder
        found = [*folder.iterdir()]
        if parts and (folder / "parts").is_dir():
            found += (folder / "parts").iterdir()
        return sorted(file.name.removesuffix(".toml") for file in found if file.name.endswith(".toml"))

    def content(self, name: str) -> bytes:
        """Bytes of a shipped file."""
        folder = resources.files(self.package) / self.folder
        file = folder / f"{name}.toml"
        return (file if file.is_file() else folder / "parts" / f"{name}.toml").read_bytes()


def read_tables(source: str | Path, shelf: Shelf, folder: Path | None = None,
                below: tuple[str, ...] = ()) -> tuple[str, Tables, Path | None]:
    """Read a file: its name for messages, its tables, and its folder (None for a shipped file).

    `folder` is that of the file that extends it, and `below` are all that do. Raises InputError for a file
    that cannot be read, is not TOML, or extends what it cannot; the name of the file leads every fault.
    """
    text = str(source)
    shipped = isinstance(source, str) and not text.endswith(".toml") and "/" not in text
    path = None if shipped else (folder or Path()) / Path(source)
    name = text if path is None or folder is None else str(path)
    try:
        content = _shipped(text, shelf, bool(below)) if path is None else read_whole(path, shelf.a_file)
    except InputError as fault:
        raise (fault.within(f"{below[-1]}: extends") if below else fault) from None
    document = _tables(name, content)
    _require(shelf, name, document)
    if path is not None:
        document = shelf.placed(document, path.parent)
    if "extends" not in document:
        return name, document, path and path.parent
    extended = document.pop("extends")
    if not isinstance(extended, str):
        raise InputError(f"{name}: extends", f"{extended!r} is no text", f"name or path of {shelf.a_file}")
    if name in below or len(below) == DEEPEST:
        raise InputError(f"{name}: extends",
                         "refers back to this file" if name in below else "is nested too deeply",
                         f"a file that extends at most {DEEPEST} others, and not itself")
    base = read_tables(extended, shelf, path.parent if path else None, (*below, name))[1]
    try:
        return name, shelf.overlay(base, document), path and path.parent
    except InputError as fault:
        raise fault.within(name) from None


def _require(shelf: Shelf, name: str, document: Tables) -> None:
    """Raise InputError for a study in place of an experiment, and an experiment in place of a study."""
    is_study, is_experiment = (isinstance(document.get(key), dict) for key in ("study", "blocks"))
    if shelf.what == "experiment" and is_study and not is_experiment:
        raise InputError(name, "is a study", "an experiment", f"run it with: fesloop study {name}")
    if shelf.what == "study" and is_experiment and not is_study:
        raise InputError(name, "is an experiment", "a study", f"run it with: fesloop run {name}")


def _shipped(name: str, shelf: Shelf, parts: bool) -> bytes:
    known = shelf.names(parts)
    if name not in known and is_file(Path(name)):
        raise InputError(name, f"is not {shelf.a_file}", "a file that ends in .toml")
    if name not in known:
        raise InputError(name or "''", f"there is no shipped {shelf.what} of this name", ", ".join(known),
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
"""Parameters of blocks, and of tables in blocks, whose text is a path."""
_SHIPPED = "shipped:"


def placed(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Make the paths in a file's tables, which start from its folder, relative to the current folder."""
    return {key: _placed((key,), value, folder) for key, value in document.items()}


def placed_value(path: Sequence[str], value: Any, folder: Path | None) -> Any:
    """The value of one key, as `placed` makes it; `folder` is None for a shipped file."""
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
    if path == ("electrodes", "array"):
        return True
    if path[-1] == "movement" and path[0] in ("blocks", "score") and len(path) == 3:
        return text.endswith(".toml")
    if path[0] != "blocks" or len(path) < 3 or path[-1] not in _KEYS:
        return False
    if not text or text.startswith(_SHIPPED):
        return False
    from fesloop.models.patient_model import shipped_models

    return text not in shipped_models()


EXPERIMENTS = Shelf("experiment", "fesloop.experiment", extended, placed)


def shipped() -> list[str]:
    """Names of the experiments that come with fesloop."""
    return EXPERIMENTS.names()


def read_experiment(experiment: str | Path) -> tuple[str, Tables]:
    """Read an experiment file: its name for messages, and its tables over those that it extends."""
    name, document, _ = read_tables(experiment, EXPERIMENTS)
    return name, of_its_own(document)

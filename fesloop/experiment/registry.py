"""Block kinds, patients, identification and calibration, found through entry points.

Any package adds a kind, a value of `kind = "..."` in experiment files, by an entry point of the group
"fesloop.blocks" whose value names the frozen dataclass of the block or plant. Of the other groups the first
entry by name counts: that of "fesloop.patients" names a module with the functions of `PatientReader`, those
of "fesloop.identifiers" and "fesloop.calibrators" name functions from the path of a recording to an object
whose `model` or `calibration` can be saved.

A class of a notebook or a script is a kind for this process only (`fesloop.experiment.own_blocks`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

from fesloop.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from fesloop.hand.anthropometry import HandSize

BLOCKS, PATIENTS = "fesloop.blocks", "fesloop.patients"
IDENTIFIERS, CALIBRATORS, SYSTEM_IMPORTERS = (
    "fesloop.identifiers", "fesloop.calibrators", "fesloop.system_importers")
"""Groups of entry points."""


class Patient(Protocol):
    """A patient as experiments use it."""

    @property
    def hand_size(self) -> HandSize:
        """Value of every plant's parameter `hand: HandSize`."""

    @property
    def measured_hand(self) -> HandSize:
        """Value of every other block's parameter `hand: HandSize`: the hand as a clinician measures it."""

    def member(self, *, cohort: int, number: int) -> Patient:
        """One of the patients of this kind."""

    def on_day(self, number: int) -> Patient:
        """The same patient on another day."""

    def with_error_scale(self, scale: float) -> Patient:
        """The same patient with errors of what a tracker knows and senses times `scale`."""

    def table(self) -> dict[str, Any]:
        """Plain tables of the patient, from which `from_table` makes the same one."""

    def parameters(self, kind: str, own: Mapping[str, Any]) -> dict[str, Any]:
        """Plain parameters for a block of a kind whose own table in the experiment is `own`."""


class PatientReader(Protocol):
    """Functions of the module that reads patients; all raise InputError for invalid patients."""

    def presets(self) -> dict[str, str]:
        """Names of the presets, with a description each."""

    def load(self, file: str) -> Patient:
        """A preset, or the patient of a file."""

    def from_table(self, tables: Mapping[str, Any], name: str) -> Patient:
        """The patient of plain tables; `name` leads every fault."""


@cache
def _entries() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=BLOCKS)}


@cache
def _first(group: str) -> EntryPoint | None:
    return next(iter(sorted(entry_points(group=group), key=lambda entry: entry.name)), None)


class OwnClass(NamedTuple):
    """A class that this process has registered, and its present source with all that it uses."""

    cls: type[Any]
    source: Callable[[], str]


_own: dict[str, OwnClass] = {}
"""Classes that this process has registered, by kind."""


def register(kind: str, cls: type[Any], source: Callable[[], str]) -> None:
    """Make a class a kind in this process; a former class of this name in the same place is replaced.

    Raises InputError for a kind that is taken, and for a class that breaks the contract.
    """
    if kind in _entries():
        raise InputError("kind", f"block kind {kind!r} exists already", "another name",
                         f'name the kind of {cls.__name__}: @fesloop.block("...")')
    require_contract(kind, cls, cls.__name__)
    _own[kind] = OwnClass(cls, source)
    find.cache_clear()


def source(kind: str) -> str | None:
    """Present source of the class that this process has registered as a kind; None if there is none."""
    return _own[kind].source() if kind in _own else None


def sources() -> dict[str, str]:
    """Present source of every class that this process has registered, by kind."""
    return {kind: own.source() for kind, own in _own.items()}


def require_contract(kind: str, cls: type[Any], place: str) -> None:
    """Raise InputError for a class that breaks the contract of blocks and plants."""
    from fesloop.loop.abilities import contract_faults  # which loads numpy: `fesloop list` does without

    if wrong := list(contract_faults(cls)):
        raise InputError("kind", f"block kind {kind!r} ({place}): {'; '.join(wrong)}",
                         "the members of fesloop.loop.block, and of fesloop.loop.abilities under their names",
                         "mend or rename the member")


def kinds() -> list[str]:
    """Every registered kind, by name."""
    return sorted({*_entries(), *_own})


@cache
def find(kind: str) -> type[Any]:
    """Import the block class of a kind.

    Raises InputError for an unknown kind, for one whose package does not import, and for a class that
    breaks the contract of blocks and plants.
    """
    if kind in _own:
        return _own[kind].cls
    entry = _entries().get(kind)
    if entry is None:
        remedy = (reinstall(BLOCKS, kind) or did_you_mean(kind, kinds()) if ":" not in kind else
                  "a class becomes a kind by @fesloop.block above it, or by an entry point of an installed "
                  f'package, in the group "{BLOCKS}"')
        raise InputError("kind", f"there is no block kind {kind!r}", ", ".join(kinds()), remedy)
    try:
        cls = cast("type[Any]", entry.load())
    except (ImportError, AttributeError) as fault:
        if isinstance(fault.__cause__ or fault.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from fault  # a module in C says "initialization failed" instead
        raise InputError("kind", f"block kind {kind!r} ({entry.value}) does not import: {fault}",
                         remedy="reinstall the package that provides it") from fault
    require_contract(kind, cls, entry.value)
    return cls


def reinstall(group: str, name: str) -> str:
    """Remedy for an entry point that the source of an installed package declares and the package lacks.

    An editable installation follows the source's code, but not its entry points. "" for a name that no source
    of a package installed from a folder declares.
    """
    import json
    import shlex
    import tomllib
    from importlib.metadata import distributions
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    for package in distributions():
        try:
            source = urlsplit(json.loads(package.read_text("direct_url.json") or "{}")["url"])
            folder = Path(url2pathname(source.path))
            project = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
            declared = source.scheme == "file" and name in project["entry-points"][group]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue  # not installed from a folder, or a project without entry points of this group
        if declared:
            return (f"{folder / 'pyproject.toml'} declares it since {package.name} was installed: install it "
                    f"again (pip install -e {shlex.quote(str(folder))})")
    return ""


def kind_of(block: type[Any]) -> str:
    """Kind under which a class is registered; "module:Class" if there is none.

    Raises InputError for a former definition of a class that has been registered again since.
    """
    value = f"{block.__module__}:{block.__qualname__}"
    for kind, own in _own.items():
        if own.cls is block:
            return kind
        if f"{own.cls.__module__}:{own.cls.__qualname__}" == value:
            raise InputError(block.__name__, "has been defined again since this object of it was made",
                             "an object of the present class", "make the object, and the experiment, again")
    return next((name for name, entry in _entries().items() if entry.value == value), value)


def summary(kind: str) -> str:
    """First line of the docstring of a kind's class.

    It is read from the source, because importing every block takes seconds; a class without a docstring
    there is imported.
    """
    entry = None if kind in _own else _entries().get(kind)
    source = _source(entry.module) if entry is not None else None
    if entry is not None and source is not None:
        head = rf'^class {re.escape(entry.attr)}\b[^"\']*?:\n\s+r?"""(.*?)(?:"""|$)'
        found = re.search(head, source.read_text("utf-8"), re.MULTILINE)
        if found:
            return found[1].strip()
    return (find(kind).__doc__ or "").strip().partition("\n")[0]


def _source(module: str) -> Path | None:
    """Source file of a module, found without an import of its packages; None if there is none."""
    places = None
    parts = module.split(".")
    for depth in range(len(parts)):
        spec = PathFinder.find_spec(".".join(parts[:depth + 1]), places)
        if spec is None:
            return None
        places = spec.submodule_search_locations
    return Path(spec.origin) if spec and spec.origin and spec.origin.endswith(".py") else None


def patient_reader() -> PatientReader:
    """The installed reader of patients. Raises InputError if there is none."""
    entry = _first(PATIENTS)
    if entry is None:
        raise InputError("patient", "no installed package reads patients",
                         remedy=f"install one with an entry point in {PATIENTS!r}")
    try:
        return cast("PatientReader", entry.load())
    except (ImportError, AttributeError) as fault:
        raise InputError("patient", f"the reader of patients {entry.name!r} ({entry.value}) does not import: "
                         f"{fault}", remedy="reinstall the package that provides it") from fault


def patient_presets() -> dict[str, str]:
    """Installed patients with a description each; none if no installed package reads patients."""
    return {} if _first(PATIENTS) is None else patient_reader().presets()


def identifier() -> Callable[..., Any]:
    """The function that identifies a patient's model. Raises InputError if none is installed."""
    return _function(IDENTIFIERS, "identify", "no installed package identifies models")


def system_importer() -> Callable[..., Any]:
    """The function that makes an experiment of an SSP archive. Raises InputError if none is installed."""
    return _function(SYSTEM_IMPORTERS, "import", "no installed package imports systems of FMUs")


def calibrator() -> Callable[..., Any]:
    """The function that calibrates a recording. Raises InputError if none is installed."""
    return _function(CALIBRATORS, "calibrate", "no installed package calibrates recordings")


def _function(group: str, command: str, found: str) -> Callable[..., Any]:
    entry = _first(group)
    if entry is None:
        raise InputError(command, found, remedy=f"install one with an entry point in {group!r}")
    return cast("Callable[..., Any]", entry.load())

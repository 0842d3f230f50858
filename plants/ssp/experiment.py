"""An SSP archive as an experiment: its FMUs, and a TOML file in which each connection is a wire."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.toml import toml_text
from fesloop.loop.clock import parse_rate
from plants.fmu.archive import ExtractedFmu, require_safe
from plants.fmu.description import FmuDescription, FmuVariable, direct_dependencies, read_description, unit_of
from plants.ssp.structure import Component, Connection, Structure, Transformation, read_structure

DURATION_S = 1.0
"""Duration where the description has no default experiment (chosen, as FMPy does)."""


class Imported(NamedTuple):
    """An imported system.

    Attributes
    ----------
    experiment: path of the experiment file.
    components, connections: how many there are.
    notes: what the experiment lacks, or what is not known, a line each.
    """

    experiment: Path
    components: int
    connections: int
    notes: tuple[str, ...]


def import_ssp(source: str | Path, folder: str | Path, rate: str = "1000") -> Imported:
    """Write an SSP archive as an experiment into a new folder.

    FMUs exchange values simultaneously at a communication rate (Jacobi): an output acts on connected inputs
    from its communication point on.

    Parameters
    ----------
    source: the .ssp file. folder: new or empty. rate: of communication points, Hz.

    Raises InputError for a file that is no SSP, an FMU that is missing or cannot be used, connectors that do
    not exist or do not fit each other in kind, shape or unit, an algebraic loop, and a folder that has files.
    """
    path, target = Path(source), Path(folder)
    parse_rate(rate, "--rate")
    try:
        archive = zipfile.ZipFile(path)
    except (OSError, zipfile.BadZipFile) as fault:
        why = fault.strerror if isinstance(fault, OSError) and fault.strerror else "it is no zip archive"
        raise InputError(str(path), f"cannot be read: {why}", "an SSP archive, .ssp") from None
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise InputError(
            f"--out {target}", "exists and is not empty", "a new folder", "name another, or remove it"
        )
    with archive:
        require_safe(archive, path)
        structure = read_structure(archive, path)
        files = {
            component.source: archive.read(component.source) for component in structure.components.values()
        }
    target.mkdir(parents=True, exist_ok=True)
    try:
        return _write(structure, files, path, target, rate)
    except BaseException:
        shutil.rmtree(target)  # it was empty, or did not exist
        raise


def _write(structure: Structure, files: Mapping[str, bytes], path: Path, target: Path, rate: str) -> Imported:
    for name, content in files.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_bytes(content)
    descriptions, direct, unknown = {}, {}, []
    for component in structure.components.values():
        extracted = ExtractedFmu(target / component.source)
        try:
            description = read_description(extracted.folder, extracted.path, _interface(component))
            dependencies = direct_dependencies(extracted.folder, extracted.path)
        finally:
            extracted.close()
        descriptions[component.path] = description
        direct[component.path] = dependencies or {}
        if dependencies is None:
            unknown.append(component.name)
        _check_connectors(path, component, description)
    _require_no_loop(path, structure, direct)
    tables = _tables(path, structure, descriptions, rate)
    experiment = target / f"{tables['experiment']['name']}.toml"
    experiment.write_text(
        f"# Made of {path.name}. Paths are relative to this file.\n\n"
        + toml_text(tables),
        encoding="utf-8",
    )
    notes = [
        f"{name} is fed from outside the system: its start value holds" for name in structure.open_inputs
    ]
    if unknown:
        notes.append(
            f"{', '.join(unknown)} does not declare how outputs depend on inputs: algebraic loops through "
            "it are not found, and take a communication step"
        )
    return Imported(experiment, len(structure.components), len(structure.connections), tuple(notes))


def _interface(component: Component) -> Any:
    return component.interface


def _check_connectors(path: Path, component: Component, description: FmuDescription) -> None:
    """Raise InputError for a connector without a variable of its kind and unit."""
    for name, connector in component.connectors.items():
        variable = description.variables.get(name)
        where = f"{path}: connector {component.name}.{name}"
        if variable is None:
            raise InputError(
                where,
                f"is no variable of {component.source}",
                ", ".join(list(description.variables)[:20]),
                did_you_mean(name, description.variables),
            )
        if connector.kind in ("input", "output") and variable.causality != connector.kind:
            raise InputError(where, f"is an {connector.kind}, in {component.source} it has the causality "
                             f"{variable.causality}", "the same in both")
        if connector.unit and variable.unit and connector.unit != variable.unit:
            raise InputError(
                where,
                f"is in {connector.unit!r}, in {component.source} it is in {variable.unit!r}",
                "the same unit in both",
            )


def _require_no_loop(
    path: Path, structure: Structure, direct: Mapping[tuple[str, ...], Mapping[str, tuple[str, ...]]]
) -> None:
    """Raise InputError where connections and declared direct dependencies close a loop."""
    feeds = {connection.target: connection.source for connection in structure.connections}
    done = set[tuple[tuple[str, ...], str]]()
    for connection in structure.connections:
        trail: list[tuple[tuple[str, ...], str]] = []
        _walk(path, connection.target, feeds, direct, trail, done)


def _walk(path: Path, end: Any, feeds: Mapping[Any, Any], direct: Mapping[Any, Any], trail: list[Any],
          done: set[Any]) -> None:
    """Follow an input back through what feeds it and what that output depends on directly."""
    if end in trail:
        names = [f"{'.'.join(component)}.{name}" for component, name in (*trail[trail.index(end):], end)]
        raise InputError(
            f"{path}: algebraic loop",
            f"{' <- '.join(names)} depend on each other at one instant",
            "an FMU on the loop whose outputs follow its inputs later",
            "add a delay, or have an FMU solve the loop",
        )
    if end in done or end not in feeds:
        return
    component, output = feeds[end]
    trail.append(end)
    for name in direct[component].get(output, ()):
        _walk(path, (component, name), feeds, direct, trail, done)
    trail.pop()
    done.add(end)


def _identifier(text: str) -> str:
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_") or "unnamed"
    return made if made[0].isalpha() else f"v_{made}"


def _unique(wanted: str, taken: set[str]) -> str:
    """The name, or one with a number behind it where it is taken."""
    name, number = wanted, 2
    while name in taken:
        name, number = f"{wanted}_{number}", number + 1
    taken.add(name)
    return name


def _tables(
    path: Path,
    structure: Structure,
    descriptions: Mapping[tuple[str, ...], FmuDescription],
    rate: str,
) -> dict[str, Any]:
    """Tables of the experiment file."""
    nodes, ports = dict[tuple[str, ...], str](), dict[Any, str]()
    for component in structure.components.values():
        nodes[component.path] = _unique(_identifier("_".join(component.path)), set(nodes.values()))
        own = {"input": set[str](), "output": set[str]()}
        for name, connector in component.connectors.items():
            if connector.kind in own:
                ports[component.path, name] = _unique(_identifier(name), own[connector.kind])
    fed = {connection.target: connection for connection in structure.connections}
    blocks = {}
    for component in structure.components.values():
        inputs, outputs, variables = [], [], descriptions[component.path].variables
        for name, connector in component.connectors.items():
            connection = fed.get((component.path, name))
            if connector.kind == "output":
                outputs.append({"name": ports[component.path, name], "variables": [name]})
            elif connector.kind == "input" and connection is not None:
                inputs.append({"name": ports[component.path, name], "variables": [name],
                               **_conversion(path, connection, descriptions)})
        block = {"kind": "fmu", "path": component.source, "step_rate": rate}
        if component.interface != "auto":
            block["interface"] = component.interface
        table = block | {
            "input_ports": inputs,
            "output_ports": outputs,
            "held_inputs": []
            if inputs
            else [each.name for each in variables.values() if each.causality == "input"],
            "starts": {
                name: _start(path, component, name, variables, *value)
                for name, value in component.parameters.items()
            },
        }
        blocks[nodes[component.path]] = {key: value for key, value in table.items() if value not in ([], {})}
    wires = [
        {"from": f"{nodes[source[0]]}.{ports[source]}", "to": f"{nodes[sink[0]]}.{ports[sink]}", "rate": rate}
        for source, sink, *_ in structure.connections
    ]
    return {"experiment": {"name": _identifier(structure.name), "description": f"FMUs of {path.name}",
                           "duration_s": structure.stop_s or DURATION_S},
            "record": {"plant_rate": rate}, "blocks": blocks, "wires": wires}


def _conversion(
    path: Path, connection: Connection, descriptions: Mapping[tuple[str, ...], FmuDescription]
) -> dict[str, Any]:
    """Unit, scale and offset of the port of a connected input: the wire has the source's values and unit."""
    (source_path, source_name), (sink_path, sink_name), change, converts = connection
    source, sink = (
        descriptions[source_path].variables[source_name],
        descriptions[sink_path].variables[sink_name],
    )
    where = (
        f"{path}: connection {'.'.join((*source_path, source_name))} -> {'.'.join((*sink_path, sink_name))}"
    )
    if source.shape != sink.shape:
        raise InputError(where, f"has the shapes {list(source.shape)} and {list(sink.shape)}", "equal shapes")
    if converts and source.unit and sink.unit:
        found = source.base.to(sink.base) if source.base is not None and sink.base is not None else None
        if found is None and source.unit != sink.unit:
            raise InputError(
                where,
                f"the units {source.unit!r} and {sink.unit!r} are of different quantities, or not defined",
                "units that can be converted",
                "correct one, or set suppressUnitConversion in the description",
            )
        change = change.after(Transformation(*found or (1.0, 0.0)))
    table: dict[str, Any] = {"unit": source.unit or "1"}
    if change != Transformation() or source.unit != sink.unit:
        table |= {"scale": change.factor, **({"offset": change.offset} if change.offset else {})}
    return table


def _start(
    path: Path, component: Component, name: str, variables: Mapping[str, FmuVariable], value: Any, unit: str
) -> Any:
    """A start value in the variable's own unit."""
    variable = variables.get(name)
    if variable is None:
        raise InputError(
            f"{path}: parameter {component.name}.{name}",
            f"is no variable of {component.source}",
            ", ".join(
                [each.name for each in variables.values() if each.causality in ("parameter", "input")][:20]
            ),
            did_you_mean(name, variables),
        )
    if not unit or unit == variable.unit or not variable.unit:
        return value
    ours = unit_of(unit)
    found = ours.to(variable.base) if ours is not None and variable.base is not None else None
    if found is None:
        raise InputError(f"{path}: parameter {component.name}.{name}", f"is in {unit!r}, its variable in "
                         f"{variable.unit!r}", "a unit that can be converted")
    return found[0] * value + found[1]

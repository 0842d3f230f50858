"""Structure of an SSP archive: FMUs, connections between them with nested systems resolved, and parameters.

System Structure and Parameterization 1.0 and 2.0 (Modelica Association, ssp-standard.org).
"""

from __future__ import annotations

import math
import posixpath
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from fesloop.errors import InputError, did_you_mean

DESCRIPTION = "SystemStructure.ssd"
_SPACE = "http://ssp-standard.org/SSP1/"
_NAMES = {"ssd": f"{_SPACE}SystemStructureDescription", "ssc": f"{_SPACE}SystemStructureCommon",
          "ssv": f"{_SPACE}SystemStructureParameterValues", "ssm": f"{_SPACE}SystemStructureParameterMapping"}
_SCHEMAS = {"1.0": "SystemStructureDescription.xsd", "1.1": "SystemStructureDescription11.xsd"}
_VERSIONS = ("1.0", "1.1", "2.0")
_FMU = "application/x-fmu-sharedlibrary"
_TYPES = (
    "Real",
    "Float64",
    "Float32",
    "Integer",
    *(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)),
    "Enumeration",
    "Boolean",
    "String",
)
_OTHER_TRANSFORMATIONS = ("BooleanMappingTransformation", "IntegerMappingTransformation",
                          "EnumerationMappingTransformation")
Value = float | int | bool | str


class Transformation(NamedTuple):
    """value at the target = factor x value at the source + offset."""

    factor: float = 1.0
    offset: float = 0.0

    def after(self, first: Transformation) -> Transformation:
        """`first`, then this one."""
        return Transformation(self.factor * first.factor, self.factor * first.offset + self.offset)


@dataclass(frozen=True, slots=True)
class Connector:
    """A connector of an FMU: its kind as in SSP, and its unit, "" if the description gives none."""

    kind: str
    unit: str


@dataclass(slots=True)
class Component:
    """An FMU of the system.

    Attributes
    ----------
    path: names of the systems around it below the outermost one, and its own.
    source: name of the FMU in the archive. interface: "auto", "co_simulation" or "model_exchange".
    connectors: by name.
    parameters: values by variable, each with its unit ("" for the variable's own).
    """

    path: tuple[str, ...]
    source: str
    interface: str
    connectors: dict[str, Connector]
    parameters: dict[str, tuple[Value, str]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Its name in messages."""
        return ".".join(self.path)


class Connection(NamedTuple):
    """A connection between two FMUs, (component, connector) each.

    `converts` is False where the description suppresses the conversion of units.
    """

    source: tuple[tuple[str, ...], str]
    target: tuple[tuple[str, ...], str]
    transformation: Transformation
    converts: bool


@dataclass(slots=True)
class Structure:
    """A system of FMUs.

    Attributes
    ----------
    name: of the system.
    stop_s: end of the default experiment; None if there is none.
    components: by path. connections: between them.
    open_inputs: "component.connector" of inputs that are fed from outside the system.
    """

    name: str
    stop_s: float | None
    components: dict[tuple[str, ...], Component]
    connections: list[Connection]
    open_inputs: list[str]


def read_structure(archive: zipfile.ZipFile, path: Path) -> Structure:
    """The structure of an SSP archive.

    Raises InputError for a description that is missing, is no XML or does not follow the standard, a version
    or an element that is not known, and a connection of what does not exist.
    """
    root = _xml(archive, DESCRIPTION, path)
    version = root.get("version", "")
    if version not in _VERSIONS:
        raise InputError(
            f"{path}: {DESCRIPTION}", f"has the version {version!r} of SSP", ", ".join(_VERSIONS)
        )
    _validate(root, version, path)
    system = root.find("ssd:System", _NAMES)
    if system is None:
        raise InputError(f"{path}: {DESCRIPTION}", "has no System", "one, as SSP requires")
    return _Reader(archive, path).structure(system, _stop_s(root))


def _stop_s(root: Any) -> float | None:
    experiment = root.find("ssd:DefaultExperiment", _NAMES)
    return (
        None
        if experiment is None or experiment.get("stopTime") is None
        else float(experiment.get("stopTime"))
    )


def _xml(archive: zipfile.ZipFile, name: str, path: Path) -> Any:
    """Root element of a file of the archive; entities are not resolved."""
    from lxml import etree

    try:
        content = archive.read(name)
    except KeyError:
        raise InputError(str(path), f"contains no {name}", "an SSP archive with all files that it names",
                         "export it again") from None
    try:
        return etree.fromstring(content, etree.XMLParser(resolve_entities=False, no_network=True))
    except etree.XMLSyntaxError as fault:
        raise InputError(
            f"{path}: {name}", f"is no XML: {fault.msg}", "well-formed XML", "export it again"
        ) from None


def _validate(root: Any, version: str, path: Path) -> None:
    """Raise InputError where the description breaks the standard's schema, where FMPy has that."""
    if version not in _SCHEMAS:
        return
    from importlib import resources

    from lxml import etree

    schema = etree.XMLSchema(file=str(resources.files("fmpy") / "ssp" / "schema" / _SCHEMAS[version]))
    if not schema.validate(root):
        fault = schema.error_log[0]
        text = " ".join(fault.message.split())
        for prefix, space in _NAMES.items():
            text = text.replace(f"{{{space}}}", f"{prefix}:")
        raise InputError(f"{path}: {DESCRIPTION}, line {fault.line}", f"is not valid SSP: {text}",
                         f"what SSP {version} allows", "export it again")


class _End(NamedTuple):
    """A connector of a component or of a system, whose path it begins with."""

    path: tuple[str, ...]
    name: str

    def __str__(self) -> str:
        return ".".join((*self.path, self.name))


class _Feed(NamedTuple):
    """Source of a connector's value."""

    source: _End
    transformation: Transformation
    converts: bool


class _Reader:
    """Walks the systems of a description."""

    def __init__(self, archive: zipfile.ZipFile, path: Path) -> None:
        self._archive, self._path = archive, path
        self._components: dict[tuple[str, ...], Component] = {}
        self._kinds: dict[_End, str] = {}
        self._feeds: dict[_End, _Feed] = {}

    def structure(self, system: Any, stop_s: float | None) -> Structure:
        """All of it."""
        self._system(system, ())
        connections, open_inputs = [], []
        for component in self._components.values():
            for name, connector in component.connectors.items():
                end = _End(component.path, name)
                if connector.kind not in ("input", "inout") or end not in self._feeds:
                    continue
                source, transformation, converts = self._origin(end)
                if source.path in self._components:
                    connections.append(Connection(source, end, transformation, converts))
                else:
                    open_inputs.append(str(end))
        return Structure(
            system.get("name") or self._path.stem, stop_s, self._components, connections, open_inputs
        )

    def _origin(self, end: _End) -> _Feed:
        """Source of a component's input, through the connectors of the systems around it."""
        feed = self._feeds[end]
        source, transformation, converts = feed
        passed = {end}
        while source.path not in self._components and source in self._feeds:
            if source in passed:
                raise self._fault(f"connector {source}", "feeds itself through connectors of systems",
                                  "connections that begin at an FMU")
            passed.add(source)
            source, before, keeps = self._feeds[source]
            transformation, converts = transformation.after(before), converts and keeps
        return _Feed(source, transformation, converts)

    def _system(self, system: Any, path: tuple[str, ...]) -> None:
        self._connectors(system, path)
        names = set[str]()
        elements = system.find("ssd:Elements", _NAMES)
        for element in () if elements is None else elements:
            if not isinstance(element.tag, str):
                continue  # a comment
            name, kind = str(element.get("name")), element.tag.rpartition("}")[2]
            if name in names:
                raise self._fault(f"element {'.'.join((*path, name))}", "is listed twice", "different names")
            names.add(name)
            if kind == "System":
                self._system(element, (*path, name))
            elif kind == "Component":
                self._component(element, (*path, name))
            else:
                raise self._fault(
                    f"element {'.'.join((*path, name))}", f"is a {kind}", "components and systems"
                )
        for connection in system.findall("ssd:Connections/ssd:Connection", _NAMES):
            self._connection(connection, path, names)
        for values, prefix in self._bindings(system):
            for name, value in values.items():
                self._assign(path, prefix + name, value)

    def _component(self, element: Any, path: tuple[str, ...]) -> None:
        kind = element.get("type", _FMU)
        where = f"component {'.'.join(path)}"
        if kind != _FMU:
            raise self._fault(where, f"has the type {kind}", _FMU)
        source = posixpath.normpath(str(element.get("source")))
        if source not in self._archive.namelist():
            raise self._fault(
                where,
                f"names the FMU {element.get('source')!r}, which is not in the archive",
                ", ".join(name for name in self._archive.namelist() if name.endswith(".fmu")) or "an FMU",
                "add it, or correct the source",
            )
        interfaces = {"CoSimulation": "co_simulation", "ModelExchange": "model_exchange"}
        made = Component(path, source, interfaces.get(element.get("implementation", ""), "auto"),
                         self._connectors(element, path))
        self._components[path] = made
        for values, prefix in self._bindings(element):
            made.parameters |= {prefix + name: value for name, value in values.items()}

    def _connectors(self, element: Any, path: tuple[str, ...]) -> dict[str, Connector]:
        found = {}
        for connector in element.findall("ssd:Connectors/ssd:Connector", _NAMES):
            name, kind = str(connector.get("name")), str(connector.get("kind"))
            units = [each.get("unit") for each in connector if each.get("unit")]
            found[name] = Connector(kind, units[0] if units else "")
            self._kinds[_End(path, name)] = kind
        return found

    def _connection(self, connection: Any, path: tuple[str, ...], names: set[str]) -> None:
        ends = []
        for side in ("start", "end"):
            element, name = connection.get(f"{side}Element"), str(connection.get(f"{side}Connector"))
            if element is not None and element not in names:
                raise self._fault(f"connection of {element}.{name}", f"there is no element {element!r}",
                                  ", ".join(sorted(names)), did_you_mean(element, names))
            end = _End(path if element is None else (*path, element), name)
            known = [each.name for each in self._kinds if each.path == end.path]
            if end not in self._kinds:
                raise self._fault(
                    f"connection of {end}",
                    f"there is no connector {name!r}",
                    ", ".join(known) or "none",
                    did_you_mean(name, known),
                )
            ends.append(end)
        source, target = ends
        # A system's own input is a source inside it, and its output a target.
        gives = "input" if source.path == path else "output"
        takes = "output" if target.path == path else "input"
        for end, wanted in ((source, gives), (target, takes)):
            if self._kinds[end] not in (
                wanted,
                "inout",
                "calculatedParameter" if wanted == "output" else "parameter",
            ):
                raise self._fault(
                    f"connection {source} -> {target}",
                    f"{end} is of the kind {self._kinds[end]!r}",
                    f"an {wanted}",
                )
        if target in self._feeds:
            raise self._fault(
                f"connection {source} -> {target}",
                f"{target} is fed by {self._feeds[target].source} too",
                "one connection to an input",
                "remove one",
            )
        converts = connection.get("suppressUnitConversion", "false") not in ("true", "1")
        where = f"connection {source} -> {target}"
        self._feeds[target] = _Feed(source, self._transformation(connection, where), converts)

    def _transformation(self, element: Any, where: str) -> Transformation:
        for name in _OTHER_TRANSFORMATIONS:
            if element.find(f"ssc:{name}", _NAMES) is not None:
                raise self._fault(where, f"has a {name}", "a LinearTransformation, or none")
        linear = element.find("ssc:LinearTransformation", _NAMES)
        if linear is None:
            return Transformation()
        made = Transformation(float(linear.get("factor", 1.0)), float(linear.get("offset", 0.0)))
        if not all(map(math.isfinite, made)) or made.factor == 0.0:
            raise self._fault(where, f"has the factor {made.factor:g} and the offset {made.offset:g}",
                              "finite numbers, and a factor other than 0")
        return made

    def _bindings(self, element: Any) -> Iterator[tuple[dict[str, tuple[Value, str]], str]]:
        """Values of each binding of an element, and the prefix of their names."""
        for binding in element.findall("ssd:ParameterBindings/ssd:ParameterBinding", _NAMES):
            sets = binding.findall("ssd:ParameterValues/ssv:ParameterSet", _NAMES)
            if binding.get("source") is not None:
                sets = [_xml(self._archive, self._file(binding.get("source")), self._path), *sets]
            values: dict[str, tuple[Value, str]] = {}
            for each in sets:
                values |= self._values(each)
            for mapping in binding.findall("ssd:ParameterMapping", _NAMES):
                source = mapping.get("source")
                found = mapping.find("ssm:ParameterMapping", _NAMES)
                table = _xml(self._archive, self._file(source), self._path) if source is not None else found
                if table is not None:
                    values = self._mapped(values, table)
            yield values, binding.get("prefix", "")

    def _file(self, source: str) -> str:
        return posixpath.normpath(source)

    def _values(self, parameters: Any) -> dict[str, tuple[Value, str]]:
        values: dict[str, tuple[Value, str]] = {}
        for parameter in parameters.findall("ssv:Parameters/ssv:Parameter", _NAMES):
            name = str(parameter.get("name"))
            for kind in _TYPES:
                entry = parameter.find(f"ssv:{kind}", _NAMES)
                if entry is not None:
                    values[name] = (self._value(name, kind, str(entry.get("value"))), entry.get("unit", ""))
                    break
            else:
                raise self._fault(f"parameter {name}", "has a value of no known type", ", ".join(_TYPES))
        return values

    def _value(self, name: str, kind: str, text: str) -> Value:
        try:
            if kind == "String":
                return text
            if kind == "Boolean":
                return {"true": True, "1": True, "false": False, "0": False}[text]
            return float(text) if kind in ("Real", "Float64", "Float32") else int(text)
        except (KeyError, ValueError):
            raise self._fault(
                f"parameter {name}", f"has the value {text!r}", f"one of the type {kind}"
            ) from None

    def _mapped(self, values: Mapping[str, tuple[Value, str]], table: Any) -> dict[str, tuple[Value, str]]:
        mapped = dict[str, tuple[Value, str]]()
        for entry in table.findall("ssm:MappingEntry", _NAMES):
            source, target = str(entry.get("source")), str(entry.get("target"))
            if source not in values:
                raise self._fault(f"mapping {source} -> {target}", f"there is no parameter {source!r}",
                                  ", ".join(values) or "none", did_you_mean(source, values))
            value, unit = values[source]
            change = self._transformation(entry, f"mapping {source} -> {target}")
            if change != Transformation():
                if isinstance(value, (str, bool)):
                    raise self._fault(f"mapping {source} -> {target}", f"transforms {value!r}", "a number")
                value = change.factor * value + change.offset
            mapped[target] = (value, unit)
        return mapped

    def _assign(self, path: tuple[str, ...], name: str, value: tuple[Value, str]) -> None:
        """Give a system's parameter to the component that its name begins with."""
        for component in self._components.values():
            if component.path[:len(path)] == path:
                own = ".".join(component.path[len(path):]) + "."
                if name.startswith(own):
                    component.parameters[name.removeprefix(own)] = value
                    return
        raise self._fault(f"parameter {'.'.join((*path, name))}", "belongs to no component of its system",
                          "COMPONENT.VARIABLE")

    def _fault(self, where: str, found: str, allowed: str, remedy: str = "") -> InputError:
        return InputError(f"{self._path}: {where}", found, allowed, remedy)

"""A block in C as an FMU: FMI 2.0 co-simulation, with fesloop's port names and units."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from fesloop.c_code.build import (
    BASE_UNITS,
    find_compiler,
    fmi_headers,
    platform,
    shared_library,
    write_archive,
)
from fesloop.c_code.program import Program, template
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Port

NO_COMPILER = "no C compiler (cc, gcc, clang) found, which an FMU's binary needs"

_UNITS = {**BASE_UNITS, "N": {"kg": "1", "m": "1", "s": "-2"}}


class _Variable(NamedTuple):
    """A real variable; its value reference is its place in the list."""

    name: str
    place: str
    unit: str
    causality: str
    start: float | None
    description: str


def write_fmu(program: Program, clock: RateClock, target: Path) -> str:
    """Write the FMU of a programme that steps on `clock`; return its GUID, a hash of its contents.

    Raises InputError for a block that learns between trials, a unit that FMI cannot define here, a file that
    cannot be written, and without a C compiler; RunError if the compiler fails.
    """
    if program.between:
        raise InputError(
            f"block {program.name}",
            "learns between trials, for which an FMU has no call",
            "format c",
            "export it as C",
        )
    compiler = find_compiler()
    if compiler is None:
        raise InputError("format fmu", NO_COMPILER, "one", "install gcc, or export C sources with --format c")
    variables = list(_variables(program))
    for each in variables:
        if each.unit not in _UNITS:
            raise InputError(f"block {program.name}", f"{each.name} has the unit {each.unit!r}",
                             ", ".join(_UNITS), "export it as C")
    files = fmi_headers()
    files |= {f"sources/{name}": text.encode() for name, text in program.files().items()}
    glue = template("fesloop.c_code", "fmi2_block.c").replace("BLOCK_HEADER", f"{program.name}.h")
    glue = glue.replace("block_", f"{program.name}_").replace("BLOCK_", f"{program.name.upper()}_")
    files["sources/fmi2_block.c"] = glue.encode()
    header = _header(program, variables, clock)
    content = hashlib.sha256(header.encode())
    for name in sorted(files):
        content.update(name.encode() + files[name])
    guid = "{" + content.hexdigest()[:32] + "}"
    upper = program.name.upper()
    files[f"sources/{program.name}_fmu.h"] = f'#define {upper}_FMU_GUID "{guid}"\n{header}'.encode()
    sources = (f"{program.name}.c", "fmi2_block.c")
    files["modelDescription.xml"] = _description(program, variables, clock, guid, sources)
    files[f"binaries/{platform()}/{program.name}.so"] = shared_library(compiler, files, sources, program.name)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"--out {target.parent}", f"cannot be made: {fault.strerror}", "a folder") from None
    write_archive(target, files)
    return guid


def _elements(program: Program, port: Port) -> Iterator[tuple[str, str, str, str]]:
    """Name in FMI, place in C, unit, and description of each element of a port."""
    sizes = [size or 0 for size in port.shape]
    units = port.unit.split(",")
    for index in itertools.product(*map(range, sizes)):
        name = f"{port.name}[{','.join(str(i + 1) for i in index)}]" if index else port.name
        unit = units[index[-1]] if index and len(units) == sizes[-1] else port.unit
        counted = [of for axis in program.axes if index and (of := axis.name_of(port.name, index))]
        about = f"{name} ({', '.join(counted)}), {unit}" if counted else f"{name}, {unit}"
        yield name, port.name + "".join(f"[{i}]" for i in index), unit, about


def _variables(program: Program) -> Iterator[_Variable]:
    for port in program.inputs:
        starts = np.ravel(port.initial_value())
        for (name, place, unit, about), start in zip(_elements(program, port), starts, strict=True):
            yield _Variable(name, f"in.{place}", unit, "input", float(start), f"Input {about}")
    for port in program.outputs:
        for name, place, unit, about in _elements(program, port):
            yield _Variable(name, f"out.{place}", unit, "output", None, f"Output {about}")
    for k, port in enumerate(program.inputs):
        yield _Variable(f"{port.name}_age", f"age[{k}]", "s", "parameter", 0.0,
                        f"Age of {port.name} at a tick: time since its capture, s")


def _header(program: Program, variables: list[_Variable], clock: RateClock) -> str:
    """Macros of fmi2_block.c."""
    upper = f"{program.name.upper()}_FMU"
    inputs = sum(each.causality == "input" for each in variables)
    first_age = sum(each.causality != "parameter" for each in variables)
    cases = " ".join(f"\\\n    case {k}: return &m->{each.place};" for k, each in enumerate(variables))
    starts = " ".join(f"\\\n    m->{each.place} = {each.start!r};" for each in variables if each.start)
    captures = " ".join(f"\\\n    m->in.{port.name}_newest_ns = m->in.time_ns - llround(m->age[{k}] * 1e9);"
                        for k, port in enumerate(program.inputs))
    return "\n".join([
        f"#define {upper}_INPUTS {inputs}", f"#define {upper}_FIRST_AGE {first_age}",
        f"#define {upper}_AGES {len(program.inputs)}",
        f"#define {upper}_PERIOD_NUM INT64_C({clock.period_num}) /* ns */",
        f"#define {upper}_PERIOD_DEN INT64_C({clock.period_den})", f"#define {upper}_VARIABLES {cases}",
        f"#define {upper}_STARTS {starts}", f"#define {upper}_CAPTURES {captures}", ""])


def _description(program: Program, variables: list[_Variable], clock: RateClock, guid: str,
                 sources: tuple[str, ...]) -> bytes:
    """Content of modelDescription.xml."""
    root = Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": program.name, "guid": guid,
        "description": "; ".join(filter(None, (program.title, program.origin))),
        "generationTool": "fesloop", "variableNamingConvention": "structured"})
    listed = SubElement(SubElement(root, "CoSimulation", {
        "modelIdentifier": program.name, "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}), "SourceFiles")
    for name in sources:
        SubElement(listed, "File", {"name": name})
    units = SubElement(root, "UnitDefinitions")
    for name in sorted({each.unit for each in variables}):
        SubElement(SubElement(units, "Unit", {"name": name}), "BaseUnit", _UNITS[name])
    SubElement(
        root,
        "DefaultExperiment",
        {
            "startTime": "0",
            "stopTime": "10",
            "stepSize": repr(clock.period_num / (clock.period_den * NS_PER_S)),
        },
    )
    listed = SubElement(root, "ModelVariables")
    for reference, each in enumerate(variables):
        kind = "fixed" if each.causality == "parameter" else "discrete"
        entry = SubElement(
            listed,
            "ScalarVariable",
            {
                "name": each.name,
                "valueReference": str(reference),
                "causality": each.causality,
                "variability": kind,
                "description": each.description,
            },
        )
        SubElement(
            entry, "Real", {"unit": each.unit} | ({} if each.start is None else {"start": repr(each.start)})
        )
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, name)
        for index, each in enumerate(variables):
            if each.causality == "output":
                SubElement(unknowns, "Unknown", {"index": str(index + 1), "dependencies": ""})
    indent(root)
    text: bytes = tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"

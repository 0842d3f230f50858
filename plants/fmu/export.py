"""Export of the finger as an FMI 2.0 FMU: C sources, and a binary where a compiler exists."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from fesloop.c_code.build import (
    BASE_UNITS,
    COMPILERS,
    find_compiler,
    fmi_headers,
    platform,
    shared_library,
    write_archive,
)
from fesloop.errors import InputError
from plants.finger.dynamics import JOINTS, MUSCLES, OUTPUTS, FingerEquations
from plants.finger.plant import Finger

_QUANTITY = {"angles": "Angle", "rates": "Rate", "accelerations": "Acceleration", "activation": "Activation"}
_PARTS = {"angles": JOINTS, "rates": JOINTS, "accelerations": JOINTS, "activation": MUSCLES}
OUTPUT_UNITS = {"angles": "rad", "rates": "rad/s", "accelerations": "rad/s^2", "activation": "1"}


@dataclass(frozen=True, slots=True)
class Variable:
    """A real variable of the FMU; its value reference is its index in the list."""

    name: str
    unit: str
    description: str
    start: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FingerData:
    """Equations of a finger and the FMU's variables, in the order of their value references."""

    equations: FingerEquations
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    derivatives: tuple[Variable, ...]
    parameters: tuple[Variable, ...]

    @classmethod
    def of(cls, equations: FingerEquations) -> FingerData:
        """Make the variables of a finger."""
        size = equations.a.shape[0]
        inputs = tuple(Variable(f"stimulation[{muscle + 1},{column}]", unit,
                                f"{quantity} of the pulses for {name.upper()}, {unit}", 0.0)
                       for muscle, name in enumerate(MUSCLES)
                       for column, unit, quantity in ((1, "A", "Current"), (2, "s", "Width")))
        outputs = tuple(Variable(f"{port}[{i + 1}]", OUTPUT_UNITS[port],
                                 f"{_QUANTITY[port]} of {_PARTS[port][i].upper()}, {OUTPUT_UNITS[port]}")
                        for port, rows in OUTPUTS.items() for i in range(rows.stop - rows.start))
        states = tuple(Variable(f"state[{i + 1}]", "", f"State {i + 1} of the linear model", 0.0)
                       for i in range(size))
        derivatives = tuple(Variable(f"der(state[{i + 1}])", "", f"Derivative of state {i + 1}")
                            for i in range(size))
        parameters = [*(Variable(f"gain_{muscle}", "1", f"Strength of {muscle.upper()}: factor on the force "
                                 "that its activation makes, 1", 1.0) for muscle in MUSCLES),
                      Variable("delay", "s", "From a change of stimulation to its effect on activation, s",
                               equations.delay_ns / 1e9)]
        if equations.threshold_ma:
            parameters += [Variable(f"threshold_{muscle}", "A", "Current of a very long pulse that excites "
                                    f"half of the axons of {muscle.upper()}, A", 1e-3 * threshold)
                           for muscle, threshold in zip(MUSCLES, equations.threshold_ma, strict=True)]
            parameters += [Variable(f"spread_{muscle}", "1", "Standard deviation of the logarithms of the "
                                    f"axons' thresholds of {muscle.upper()}, 1", spread)
                           for muscle, spread in zip(MUSCLES, equations.spread, strict=True)]
            parameters.append(Variable("chronaxie", "s", "Pulse width at which thresholds are twice those "
                                       "of a very long pulse, s", 1e-6 * equations.chronaxie_us))
        return cls(equations, inputs, outputs, states, derivatives, tuple(parameters))


def plant_data_header(data: FingerData, guid: str) -> str:
    """Text of plant_data.h: sizes, matrices (row-major) and defaults in full precision."""
    equations = data.equations
    states, muscles = equations.b.shape
    linear = not equations.threshold_ma
    lines = ["/* Written by fesloop: the numbers of one finger. */", "#ifndef PLANT_DATA_H",
             "#define PLANT_DATA_H", "", f'#define MODEL_GUID "{guid}"', f"#define STATES {states}",
             f"#define MUSCLES {muscles}", f"#define OUTPUTS {equations.c.shape[0]}",
             f"#define LINEAR_RECRUITMENT {int(linear)}"]
    if linear:
        lines.append(f"#define FULL_SCALE_S {1e-6 * equations.full_scale_us!r}")
    starts = np.array([variable.start for variable in data.parameters])
    for name, numbers in (("A", equations.a), ("B", equations.b), ("C", equations.c),
                          ("OFFSET", equations.offset), ("PARAMETER_START", starts)):
        lines += ["", _array(name, numbers)]
    return "\n".join([*lines, "", "#endif", ""])


def _array(name: str, numbers: NDArray[np.float64]) -> str:
    rows = np.atleast_2d(numbers)
    body = ",\n".join("    " + ", ".join(repr(float(value)) for value in row) for row in rows)
    return f"static const double {name}[{rows.size}] = {{\n{body}}};"


def model_description(data: FingerData, guid: str, sources: Sequence[str]) -> bytes:
    """Content of modelDescription.xml, FMI 2.0, for model exchange and co-simulation."""
    root = Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": "finger", "guid": guid, "numberOfEventIndicators": "0",
        "description": "Index finger (MCP, PIP, DIP) moved by four stimulated muscles (FDP, FDS, EDC, INT)",
        "generationTool": "fesloop", "variableNamingConvention": "structured"})
    common = {"modelIdentifier": "finger", "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
    for kind, special in (
            ("ModelExchange", {"completedIntegratorStepNotNeeded": "true"}),
            ("CoSimulation", {"canHandleVariableCommunicationStepSize": "true"})):
        listed = SubElement(SubElement(root, kind, common | special), "SourceFiles")
        for name in sources:
            SubElement(listed, "File", {"name": name})
    units = SubElement(root, "UnitDefinitions")
    for name, exponents in BASE_UNITS.items():
        SubElement(SubElement(units, "Unit", {"name": name}), "BaseUnit", exponents)
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "10", "stepSize": "0.001"})
    first = _variables(SubElement(root, "ModelVariables"), data)
    _structure(SubElement(root, "ModelStructure"), data, first)
    indent(root)
    text: bytes = tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _variables(parent: Element, data: FingerData) -> dict[str, int]:
    """Write all variables; returns the index (from 1) of the first of each group."""
    groups = (("input", data.inputs, "input", "continuous"), ("output", data.outputs, "output", "continuous"),
              ("state", data.states, "local", "continuous"),
              ("derivative", data.derivatives, "local", "continuous"),
              ("parameter", data.parameters, "parameter", "fixed"))
    first: dict[str, int] = {}
    reference = 0
    for group, variables, causality, variability in groups:
        first[group] = reference + 1
        for number, variable in enumerate(variables):
            entry = {"name": variable.name, "valueReference": str(reference), "causality": causality,
                     "variability": variability, "description": variable.description}
            real = {"unit": variable.unit} if variable.unit else {}
            if variable.start is not None:
                real["start"] = repr(variable.start)
                if group == "state":
                    entry["initial"] = "exact"
            if group == "derivative":
                real["derivative"] = str(first["state"] + number)
            SubElement(SubElement(parent, "ScalarVariable", entry), "Real", real)
            reference += 1
    return first


def _structure(parent: Element, data: FingerData, first: dict[str, int]) -> None:
    """Write dependencies: outputs and derivatives depend on states alone, as inputs act through the delay."""
    states = range(first["state"], first["state"] + len(data.states))
    outputs = range(first["output"], first["output"] + len(data.outputs))
    derivatives = range(first["derivative"], first["derivative"] + len(data.derivatives))
    for name, unknowns in (("Outputs", outputs), ("Derivatives", derivatives),
                           ("InitialUnknowns", [*outputs, *derivatives])):
        listed = SubElement(parent, name)
        for index in unknowns:
            SubElement(listed, "Unknown", {"index": str(index), "dependencies": " ".join(map(str, states))})


SOURCES = ("fmi2_life.c", "fmi2_variables.c", "fmi2_state.c", "fmi2_model_exchange.c", "fmi2_co_simulation.c",
           "muscle_plant.c", "expm.c")
HEADERS = ("instance.h", "muscle_plant.h", "expm.h")


@dataclass(frozen=True, slots=True)
class FmuBuilt:
    """An exported FMU.

    Attributes
    ----------
    path: file of the FMU.
    size: its size, bytes.
    guid: hash of its contents; equal parameters give equal bytes.
    binary: platform of its binary, "" with sources only.
    note: reason why there is no binary, or "".
    """

    path: Path
    size: int
    guid: str
    binary: str
    note: str


def build_finger_fmu(target: Path, *, finger: Finger | None = None, binary: bool | None = None) -> FmuBuilt:
    """Write the finger as a source FMU (co-simulation and model exchange), with a binary if possible.

    Parameters
    ----------
    target: file to write, ending in .fmu.
    finger: parameters; None for the default finger. Fatigue is refused: it makes the plant nonlinear.
    binary: True requires one, False omits it, None makes one if a C compiler is found.

    Raises
    ------
    InputError: for a bad target, a finger with fatigue, or no compiler where a binary is required.
    RunError: if the compiler fails.
    """
    target = Path(target)
    if target.suffix != ".fmu":
        raise InputError("target", f"{target} does not end in .fmu", "a file name such as finger.fmu")
    if not target.parent.is_dir():
        raise InputError("target", f"the folder {target.parent} does not exist", remedy="create it first")
    finger = finger if finger is not None else Finger()
    if finger.fatigue is not None:
        raise InputError("finger.fatigue", "an exported finger cannot tire", "no fatigue", "remove it")
    guid, files = _source_files(finger)
    system, note = "", "binary omitted as requested"
    if binary is not False:
        compiler = find_compiler()
        if compiler is not None:
            system = platform()
            files[f"binaries/{system}/finger.so"] = shared_library(compiler, files, SOURCES, "finger")
            note = ""
        else:
            note = f"no C compiler ({', '.join(COMPILERS)}) found: the FMU contains sources only"
            if binary:
                raise InputError("binary", note, remedy="install gcc, or export sources only")
    write_archive(target, files)
    return FmuBuilt(target, target.stat().st_size, guid, system, note)


def _source_files(finger: Finger) -> tuple[str, dict[str, bytes]]:
    """GUID, and all files of the source FMU by their names in the archive."""
    packaged = resources.files("plants.fmu") / "sources"
    files = {f"sources/{name}": (packaged / name).read_bytes() for name in (*SOURCES, *HEADERS)}
    files |= fmi_headers()
    data = FingerData.of(finger.equations())
    content = hashlib.sha256(plant_data_header(data, "").encode())
    for name in sorted(files):
        content.update(name.encode() + files[name])
    guid = "{" + content.hexdigest()[:32] + "}"
    files["sources/plant_data.h"] = plant_data_header(data, guid).encode()
    files["modelDescription.xml"] = model_description(data, guid, SOURCES)
    return guid, files

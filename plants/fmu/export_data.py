"""The parts of the finger's FMU that depend on its parameters: plant_data.h and modelDescription.xml."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from plants.finger.dynamics import JOINTS, MUSCLES, OUTPUTS, FingerEquations

UNITS: dict[str, dict[str, str]] = {
    "A": {"A": "1"}, "s": {"s": "1"}, "rad": {"rad": "1"}, "rad/s": {"rad": "1", "s": "-1"},
    "rad/s^2": {"rad": "1", "s": "-2"}, "1": {}}
_WHAT = {"angles": "Angle", "rates": "Rate", "accelerations": "Acceleration", "activation": "Activation"}
_OF = {"angles": JOINTS, "rates": JOINTS, "accelerations": JOINTS, "activation": MUSCLES}
OUTPUT_UNITS = {"angles": "rad", "rates": "rad/s", "accelerations": "rad/s^2", "activation": "1"}


@dataclass(frozen=True, slots=True)
class Variable:
    """A real variable of the FMU; its value reference is its place in the list."""

    name: str
    unit: str
    description: str
    start: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FingerData:
    """The finger's equations with the FMU's variables, in the order of their value references."""

    equations: FingerEquations
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    derivatives: tuple[Variable, ...]
    parameters: tuple[Variable, ...]

    @classmethod
    def of(cls, equations: FingerEquations) -> FingerData:
        """Name the variables of a finger."""
        size = equations.a.shape[0]
        inputs = tuple(Variable(f"stimulation[{muscle + 1},{column}]", unit,
                                f"{what} of the pulses for {name.upper()}, {unit}", 0.0)
                       for muscle, name in enumerate(MUSCLES)
                       for column, unit, what in ((1, "A", "Current"), (2, "s", "Width")))
        outputs = tuple(Variable(f"{port}[{i + 1}]", OUTPUT_UNITS[port],
                                 f"{_WHAT[port]} of {_OF[port][i].upper()}, {OUTPUT_UNITS[port]}")
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
    """plant_data.h: sizes, matrices (row-major) and defaults, every digit of them."""
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
    """modelDescription.xml of FMI 2.0, both kinds."""
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
    for name, exponents in UNITS.items():
        SubElement(SubElement(units, "Unit", {"name": name}), "BaseUnit", exponents)
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "10", "stepSize": "0.001"})
    first = _variables(SubElement(root, "ModelVariables"), data)
    _structure(SubElement(root, "ModelStructure"), data, first)
    indent(root)
    text: bytes = tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _variables(parent: Element, data: FingerData) -> dict[str, int]:
    """Write every variable; the index (from 1) of the first of each group."""
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
    """Outputs and derivatives depend on states alone within a step: inputs act through the delay."""
    states = range(first["state"], first["state"] + len(data.states))
    outputs = range(first["output"], first["output"] + len(data.outputs))
    derivatives = range(first["derivative"], first["derivative"] + len(data.derivatives))
    for name, unknowns in (("Outputs", outputs), ("Derivatives", derivatives),
                           ("InitialUnknowns", [*outputs, *derivatives])):
        listed = SubElement(parent, name)
        for index in unknowns:
            SubElement(listed, "Unknown", {"index": str(index), "dependencies": " ".join(map(str, states))})

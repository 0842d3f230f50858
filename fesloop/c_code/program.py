"""A block as C99: a struct of state, an init and a step function, and settings as named constants.

A `Program` has three files: NAME.h (interface), NAME_settings.h (constants with units) and NAME.c (code). The
code is written as templates in which `block_` and `BLOCK_` stand for the block's name.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port

KEYWORDS = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "while", "block", "main"))
"""Words of C, and those of the templates, that are no name of a programme."""


def number(value: float) -> str:
    """A double as C text with all of its digits."""
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "-INFINITY"
    return repr(float(value))


def define(name: str, value: float | int, comment: str) -> str:
    """A named constant of the preprocessor."""
    text = str(value) if isinstance(value, (int, np.integer)) else f"({number(value)})"
    return f"#define {name} {text} /* {comment} */"


def array(name: str, values: ArrayLike, comment: str, kind: str = "double") -> str:
    """A constant array of one, two or three dimensions."""
    numbers: NDArray[np.float64] = np.asarray(values)
    sizes = "".join(f"[{size}]" for size in numbers.shape)
    return f"/* {comment} */\nstatic const {kind} {name}{sizes} = {_braces(numbers, kind)};"


def _braces(numbers: NDArray[np.float64], kind: str) -> str:
    if numbers.ndim > 1:
        return "{\n" + ",\n".join(_braces(each, kind) for each in numbers) + "}"
    words = ", ".join(str(int(each)) if kind == "int" else number(each) for each in numbers)
    return "{" + "\n ".join(textwrap.wrap(words, 108, break_on_hyphens=False)) + "}"


@dataclass(frozen=True, slots=True)
class Operations:
    """Worst case of a step: sums, products, quotients and comparisons of doubles, and calls of math.h.

    Attributes
    ----------
    flops: of a step. calls: calls of exp, log, sqrt and erfc in a step.
    between: operations between two trials, of a block that learns.
    terms: where the numbers come from, and what bounds the loops, a line each.
    """

    flops: int
    calls: int
    terms: tuple[str, ...]
    between: int = 0


@dataclass(frozen=True, slots=True)
class Axis:
    """Names of the indices of some ports, such as joints or channels of stimulation.

    Attributes
    ----------
    kind: first part of the names of its constants, such as "CHANNEL".
    names: of what it counts, in order; any text. ports: names of the ports.
    dimension: of the ports' shapes, 0 or -1.
    units: of what it counts, one each; empty: those of the ports.
    """

    kind: str
    names: tuple[str, ...]
    ports: tuple[str, ...]
    dimension: int
    units: tuple[str, ...] = ()

    def name_of(self, port: str, index: tuple[int, ...]) -> str:
        """Name of what a place in a port is of; empty for a port without this axis."""
        return _in_a_comment(self.names[index[self.dimension]]) if port in self.ports else ""

    def declaration(self) -> list[str]:
        """An enumeration of the names; numbers take the place of names that are no identifiers of C."""
        suited = (len({name.upper() for name in self.names}) == len(self.names)
                  and all(re.fullmatch(r"\w+", name, re.ASCII) for name in self.names))
        which = "first" if self.dimension == 0 else "last"
        said = [[] if suited else [name] for name in self.names]
        for each, unit in zip(said, self.units, strict=False):
            each.append(unit)
        lines = [f"    BLOCK_{self.kind}_{name.upper() if suited else number},"
                 + (f" /* {_in_a_comment(', '.join(words))} */" if words else "")
                 for number, (name, words) in enumerate(zip(self.names, said, strict=True))]
        lines.append(f"    BLOCK_{self.kind}S = {len(self.names)}")
        return ["", f"/* {which} index of {', '.join(self.ports)} */", "enum {", *lines, "};"]


def _in_a_comment(text: str) -> str:
    """Text without what would end a comment of C, or is not ASCII."""
    return re.sub(r"[^\w .,;:()+=-]", "?", text, flags=re.ASCII)


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A block in C.

    Attributes
    ----------
    name: of the functions and files. title: what it is, in a line.
    period_ns: time from one step to the next.
    inputs, outputs: ports of the block, all of known size.
    state: C declarations of the members of the struct.
    sizes: numbers that these declarations use, by name without the block's; statuses: names from 0 on, with
        what they mean.
    settings: constants, as from `define` and `array`.
    code: bodies of the functions, templates one after the other.
    operations: of a step.
    types: declarations of further types of which the state has members.
    between: declaration and meaning of a further function, such as one between trials; empty for none.
    axes: what the indices of ports count, as far as it is known.
    origin: what it was made of, such as experiment, patient and model, in a line.
    """

    name: str
    title: str
    period_ns: int
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    state: tuple[str, ...]
    sizes: Mapping[str, int]
    statuses: Mapping[str, str]
    settings: tuple[str, ...]
    code: tuple[str, ...]
    operations: Operations
    types: tuple[str, ...] = ()
    between: tuple[str, ...] = ()
    axes: tuple[Axis, ...] = ()
    origin: str = ""

    def __post_init__(self) -> None:
        if self.name in KEYWORDS or not re.fullmatch(r"[a-z][a-z0-9_]*", self.name):
            raise InputError(
                f"block {self.name}",
                "is no name of C functions",
                "lower-case letters, digits and underscores, no keyword of C",
                "rename the block in the experiment",
            )

    def files(self) -> dict[str, str]:
        """Text of each file, by name."""
        return {f"{self.name}.h": self._named(self._header()),
                f"{self.name}_settings.h": self._named(self._settings()),
                f"{self.name}.c": self._named("\n".join(self.code))}

    def _named(self, text: str) -> str:
        text = text.replace("BLOCK_HEADER", f"{self.name}.h")
        return text.replace("block_", f"{self.name}_").replace("BLOCK_", f"{self.name.upper()}_")

    def _header(self) -> str:
        operations = self.operations
        comment = [
            f"{self.title}",
            *([f"Made of: {_in_a_comment(self.origin)}"] if self.origin else []),
            "",
            f"Call block_init once, then block_step at every tick, {self.period_ns} ns apart; time_ns counts "
            "from the first tick. Nothing is allocated, and all memory is in block_state: several "
            "controllers may run beside each other.",
            "",
            f"Worst case of a step: {operations.flops} operations on doubles (sums, products, quotients, "
            f"comparisons) and {operations.calls} calls of exp, log, sqrt or erfc:",
        ]
        lines = [piece for line in comment for piece in (textwrap.wrap(line, 104) or [""])]
        for term in operations.terms:
            lines += textwrap.wrap(f"- {term}", 104, subsequent_indent="  ")
        body = [
            "/*",
            *(f" * {line}".rstrip() for line in lines),
            " */",
            "#ifndef BLOCK_H",
            "#define BLOCK_H",
            "",
            "#include <stdint.h>",
            "",
            "enum {",
        ]
        body += [f"    BLOCK_{name} = {value}," for name, value in self.sizes.items()]
        body += [
            "    BLOCK_NEVER = -1 /* instant of the newest capture of an input that has not arrived */",
            "};",
            *(line for axis in self.axes for line in axis.declaration()),
            "",
            "/* what block_step returns */",
            "enum {",
        ]
        body += [f"    BLOCK_{name}{',' if i + 1 < len(self.statuses) else ''} /* {meaning} */"
                 for i, (name, meaning) in enumerate(self.statuses.items())]
        body += ["};", "", "typedef struct {", "    int64_t time_ns; /* instant of this step */"]
        for port in self.inputs:
            body += [f"    double {port.name}{_sizes(port)}; /* {port.unit} */",
                     f"    int64_t {port.name}_newest_ns; /* its newest capture, ns; BLOCK_NEVER: none */"]
        body += ["} block_inputs;", "", "typedef struct {"]
        body += [f"    double {port.name}{_sizes(port)}; /* {_units(port)} */" for port in self.outputs]
        body += [
            "} block_outputs;",
            "",
            *self.types,
            "typedef struct {",
            *(f"    {line}" for line in self.state),
            "} block_state;",
            "",
            "/* State at rest, before the first tick. */",
            "void block_init(block_state *state);",
            "",
            "/* Fill the outputs of a tick; returns a status from above. */",
            "int block_step(block_state *state, const block_inputs *in, block_outputs *out);",
        ]
        if self.between:
            body += ["", *self.between]
        return "\n".join([*body, "", "#endif", ""])

    def _settings(self) -> str:
        period = define("PERIOD_S", self.period_ns / NS_PER_S, "s, from tick to tick")
        return "\n".join(
            [
                f"/* Settings of block_step: {self.title} */",
                "#ifndef BLOCK_SETTINGS_H",
                "#define BLOCK_SETTINGS_H",
                "",
                "#include <math.h>",
                "",
                period,
                f"#define PERIOD_NS INT64_C({self.period_ns}) /* ns */",
                *self.settings,
                "",
                "#endif",
                "",
            ]
        )


def _sizes(port: Port) -> str:
    return "".join(f"[{size}]" for size in port.shape)


def _units(port: Port) -> str:
    """The unit, or one for each place of the last index."""
    return port.unit.replace(",", " and ")


def template(package: str, name: str) -> str:
    """Text of a C template of a package."""
    return (resources.files(package) / name).read_text(encoding="utf-8")


def write(program: Program, folder: Path) -> list[Path]:
    """Write the files into a new or empty folder; return their paths.

    Raises InputError for a folder that has files, or cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"--out {folder}", "is not empty", "a new folder", "name another, or remove it")
        paths: Sequence[Path] = [folder / name for name in program.files()]
        for path, text in zip(paths, program.files().values(), strict=True):
            path.write_text(text, encoding="utf-8")
    except OSError as fault:
        raise InputError(f"--out {folder}", f"cannot be written: {fault.strerror}", "a folder") from None
    return list(paths)

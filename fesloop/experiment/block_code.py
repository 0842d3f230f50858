"""A block of an experiment as C sources or as an FMU."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.files.patients import describe
from fesloop.experiment.registry import kind_of, reinstall
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.models.linear_model import LinearModel
from fesloop.models.patient_model import electrodes_in_words

if TYPE_CHECKING:
    from fesloop.c_code.program import Axis, Program
    from fesloop.experiment.specification import ExperimentSpecification

GROUP = "fesloop.c_exporters"
"""Group of entry points, by kind of block: functions (block, context, wired inputs, ticks of a trial) ->
`Program`."""
CodeForm = Literal["c", "fmu"]


def program_of(experiment: ExperimentSpecification, block: str) -> Program:
    """The C programme of an experiment's block.

    Raises InputError for a name that is no block, a kind that cannot be exported, and parameters that its
    programme lacks.
    """
    node = _node(experiment, block)
    exporters: dict[str, EntryPoint] = {entry.name: entry for entry in entry_points(group=GROUP)}
    kind = kind_of(type(node.part))
    if kind not in exporters:
        raise InputError(f"block {block}", f"is of the kind {kind!r}, which is not available in C",
                         ", ".join(sorted(exporters)),
                         reinstall(GROUP, kind) or "choose such a block, or such a kind")
    write: Callable[..., Program] = exporters[kind].load()
    wired = frozenset(end.target.part.inputs[end.target_port].name
                      for end in experiment.wiring.connections if end.target is node)
    context = node.context(experiment.seed, 0)
    ticks = context.clock.first_at_or_after(experiment.duration_ns) if context.clock else 0
    program = write(node.part, context, wired, ticks)
    axes = (*_angles(experiment, node, program), *_places(experiment, node, program),
            *_channels(experiment, node, program))
    return replace(program, axes=axes, origin=_origin(experiment, node))


def _origin(experiment: ExperimentSpecification, node: Node) -> str:
    """Experiment, patient and model of a block in a line."""
    words = [f"experiment {experiment.name}"]
    if experiment.patient is not None:
        named = {**experiment.patient, "file": Path(experiment.patient["file"]).stem}
        words.append(f"patient {describe(named)}")
    model = getattr(node.part, "model", None)
    if isinstance(model, LinearModel):
        words.append(f"model with the SHA-256 {model.digest()}")
    return "; ".join(words)


def _angles(experiment: ExperimentSpecification, node: Node, program: Program) -> Iterator[Axis]:
    """Names and units of the controlled angles: those of the measured signal, or those that are scored."""
    from fesloop.c_code.program import Axis
    from fesloop.streams.blocks.synergies import RAD_PER_M, Synergies

    ports = {port.name: port.shape[-1] for port in program.inputs if port.unit == "rad" and port.shape}
    ends = [end for end in experiment.wiring.connections
            if end.target is node and node.part.inputs[end.target_port].name in ports]
    rows = [end.source.part.outputs[end.source_port].row_names for end in ends]
    names = next((each for each in (*rows, experiment.score.joints) if each), ())
    counted = tuple(name for name, size in ports.items() if size == len(names))
    apertures = {end.source.part.aperture for end in ends if isinstance(end.source.part, Synergies)}
    units = tuple(f"rad, {RAD_PER_M / 1e3:.17g} for each mm" if number in apertures else "rad"
                  for number in range(len(names)))
    if counted:
        yield Axis("ANGLE", tuple(names), counted, -1, units)


def _places(experiment: ExperimentSpecification, node: Node, program: Program) -> Iterator[Axis]:
    """Names of the places of force sensors, as their source states them."""
    from fesloop.c_code.program import Axis

    read = {port.name for port in program.inputs if port.unit == "N" and port.shape}
    for end in experiment.wiring.connections:
        if end.target is node and (name := node.part.inputs[end.target_port].name) in read:
            yield Axis("PLACE", end.source.part.outputs[end.source_port].row_names, (name,), 0)


def _channels(experiment: ExperimentSpecification, node: Node, program: Program) -> Iterator[Axis]:
    """Names of the channels of stimulation: virtual electrodes of the stimulator that pulses lead to, or
    what the plant names them."""
    from fesloop.c_code.program import Axis

    (port,) = program.outputs
    count = port.shape[0] or 0
    blocks = experiment.document()["blocks"]
    behind = [node]
    for each in behind:
        for end in experiment.wiring.connections:
            entered = end.target.part.inputs[end.target_port]
            if end.source is not each or end.target in behind or entered.shape[:1] != (count,):
                continue
            behind.append(end.target)
            names = entered.row_names
            if "electrodes" in (table := blocks[end.target.name]) and not end.target.is_plant:
                names = tuple(f"elements {word}" for word in electrodes_in_words(table, count))
            if len(names) == count:
                yield Axis("CHANNEL", names, (port.name,), 0)
                return


def _node(experiment: ExperimentSpecification, block: str) -> Node:
    blocks = {node.name: node for node in experiment.wiring.nodes if not node.is_plant}
    if block not in blocks:
        raise InputError(f"--block {block}", f"is no block of {experiment.name}", ", ".join(blocks),
                         did_you_mean(block, blocks))
    return blocks[block]


def export_code(
    experiment: ExperimentSpecification, block: str, form: CodeForm, out: str | Path | None = None
) -> tuple[Path, Sequence[Path]]:
    """Write a block as C sources or as an FMU; return the folder or file, and all files.

    Parameters
    ----------
    block: name of the block in the experiment.
    form: "c" for a folder of C sources, "fmu" for an FMU (FMI 2.0 co-simulation), which needs a C compiler.
    out: new folder; for an FMU a file ending in .fmu, or a folder for it; None: the folder
        exports/EXPERIMENT-BLOCK-FORM.

    Raises InputError as `program_of` does, and for a target that exists or cannot be written; RunError if the
    compiler fails.
    """
    from fesloop.c_code.program import write

    if form not in ("c", "fmu"):
        raise InputError("--format", f"{form!r} is no format of a block", "c, fmu")
    program = program_of(experiment, block)
    target = Path("exports", f"{experiment.name}-{block}-{form}") if out is None else Path(out)
    if form == "c":
        return target, write(program, target)
    path = target if target.suffix == ".fmu" else target / f"{block}.fmu"
    clock = _node(experiment, block).clock
    if not isinstance(clock, RateClock) or clock.offset_ns:
        raise InputError(f"block {block}", "has no constant rate from 0 s on", "a rate without offset",
                         "give the block one, or export it as C")
    if path.exists():
        raise InputError(f"--out {path}", "exists", "a new file", "name another, or remove it")
    from fesloop.c_code.fmu import write_fmu

    write_fmu(program, clock, path)
    return path, (path,)

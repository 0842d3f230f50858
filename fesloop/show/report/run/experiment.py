"""What was run: the wiring drawn, every wire in a table, the experiment with every parameter resolved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from fesloop.experiment.specification import with_transport
from fesloop.forms.toml import toml_text
from fesloop.show.report.parts import Code, Drawing, Fold, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.wiring import is_plant, wiring_svg
from fesloop.show.report.run.words import counted

_LONGEST = 200_000
"""Characters of the experiment in the page (chosen: tables of measured numbers go on for megabytes)."""


def experiment_section(known: Known) -> Section:
    """From the tables in the recording, whether their kinds are installed here or not."""
    tables = known.recording.experiment
    about = tables.get("experiment", {}).get("description", "")
    parts: list[Part] = [Paragraph(text=about)] if about else []
    return Section(key="experiment", title="What was run", parts=[*parts, *_parts(known, tables)])


def _parts(known: Known, tables: Mapping[str, Any]) -> Iterator[Part]:
    blocks = tables.get("blocks", {})
    wires = [with_transport(wire, tables) for wire in tables.get("wires", [])]
    rates = {name: _rate(known, name, table) for name, table in blocks.items()}
    if blocks:
        yield Drawing(key="wiring", title="Blocks with their rates, wires with their latencies",
                      svg=wiring_svg(blocks, wires, rates),
                      text=f"{counted(len(blocks), 'block')} joined by {counted(len(wires), 'wire')}; the "
                      "tables below say the same.")
        yield Fold(title=f"{counted(len(blocks), 'block')} and {counted(len(wires), 'wire')}", parts=[
            Table(title="Blocks", columns=["block", "kind", "ticks"],
                  rows=[[name, str(table.get("kind", "")), rates[name]] for name, table in blocks.items()]),
            Table(title="Wires", columns=["from", "to", "latency", "loss", "late messages"],
                  rows=[_wire_row(wire) for wire in wires])])
    yield from _resolved(tables)
    versions = known.recording.versions
    yield Fold(title="Versions and identity", parts=[Table(columns=["", ""], rows=[
        *([name, version] for name, version in versions.items()),
        ["fingerprint of the experiment", known.recording.fingerprint],
        ["to run it once more", f"fesloop run {known.recording.path.name}"]])])


def _rate(known: Known, name: str, table: Mapping[str, Any]) -> str:
    """When a block ticks: as its clock says, else as its table does."""
    if known.experiment is not None:
        node = known.experiment.wiring.node(name)
        if node.is_plant:
            return f"steps at {node.plant.grid}" if node.plant.grid else "continuous"
        return str(node.clock).rpartition("stamps, ")[2]
    if "rate" in table:
        return f"{table['rate']} Hz"
    if "clock" in table:
        return f"with {table['clock']}"
    return "continuous" if is_plant(table) else "its own clock"


def _wire_row(wire: Mapping[str, Any]) -> list[str]:
    jitter = wire.get("jitter", {"kind": "zero"})
    varies = "" if jitter["kind"] == "zero" else f" + {jitter['kind']} jitter"
    burst = wire.get("burst_messages")
    bursts = f" in bursts of {burst:g}" if burst else ""
    return [wire["from"], wire["to"], f"{wire.get('latency_ms', 0.0):g} ms{varies}",
            f"{100.0 * wire['loss']:g} %{bursts}" if wire.get("loss") else "-", str(wire.get("late", ""))]


def _resolved(tables: Mapping[str, Any]) -> Iterator[Part]:
    """The experiment as TOML."""
    text = toml_text(without_none(tables))
    shown = text if len(text) <= _LONGEST else text[:text.rindex("\n", 0, _LONGEST) + 1]
    parts: list[Part] = [Code(text=shown)]
    if len(shown) < len(text):
        parts.append(Notice(text=f"{len(text) - len(shown)} characters of the experiment are left out here; "
                            "the recording has them."))
    yield Fold(title="The experiment, every parameter resolved", parts=parts)


def without_none(value: Any) -> Any:
    """Tables and lists without what is not given, which TOML has no word for."""
    if isinstance(value, Mapping):
        return {key: without_none(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [without_none(item) for item in value if item is not None]
    return value

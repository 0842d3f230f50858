"""Tables of experiments, recordings and results, as printed and as notebooks show them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from fesloop.experiment import registry
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from fesloop.tables import Table

_MOST_ROWS = 400
_LONGEST = 80


def exact_ms(latency_ms: float) -> str:
    """Format to the nanosecond: 110.000001 ms may miss a tick that 110 ms reaches."""
    return f"{latency_ms:.6f}".rstrip("0").rstrip(".") + " ms"


def wiring_tables(experiment: Any, patient: str = "") -> list[Table]:
    """Nodes and wires of an experiment; `patient` in words."""
    who = f", patient {patient}" if patient else ""
    title = (f"{experiment.name}: {experiment.trials} x {experiment.duration_ns / NS_PER_S:g} s, "
             f"seed {experiment.seed}{who}")
    return [Table(title, ("node", "kind", "ticks", "takes"),
                  [_node_row(node) for node in experiment.wiring.nodes]),
            Table("Wires", ("from", "to", "latency", "late messages"),
                  [_wire_row(wire) for wire in experiment.wires], folded=True)]


def experiment_tables(experiment: Any) -> list[Table]:
    """Description, nodes, wires and parameters of an experiment."""
    wiring = wiring_tables(experiment)
    if experiment.description:
        wiring[0] = wiring[0]._replace(title=f"{wiring[0].title}; {experiment.description}")
    document = experiment.document()
    rows = [(f"blocks.{name}.{key}", _short(value)) for name, table in document["blocks"].items()
            for key, value in table.items() if key not in ("kind", "rate", "offset_ms", "execution", "clock")]
    rows += [(f"score.{key}", _short(value)) for key, value in document["score"].items()]
    return [*wiring, Table("Settings", ("key", "value"), rows[:_MOST_ROWS], folded=True)]


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST - 4]} ..."


def _node_row(node: Node) -> tuple[str, str, str, str]:
    if node.is_plant:
        ticks = f"steps at {node.plant.grid}" if node.plant.grid else "continuous, exact"
    else:
        ticks = str(node.clock)
    return node.name, registry.kind_of(type(node.part)), ticks, node.execution.kind


def _wire_row(wire: Wire) -> tuple[str, str, str, str]:
    parts = [exact_ms(wire.latency_ns / NS_PER_MS)]
    if wire.jitter.random or wire.jitter.least_ns:
        parts.append(f"{wire.jitter.kind} jitter of {wire.jitter}")
    if wire.loss:
        in_bursts = f" in bursts of {wire.burst_messages:g}" if wire.burst_messages else ""
        parts.append(f"{100 * wire.loss:g} % lost{in_bursts}")
    by = "" if wire.link is None else f", by link {wire.link}"
    return wire.source, wire.target, " + ".join(parts) + by, wire.late


def recording_tables(recording: Any) -> list[Table]:
    """Signals of a recording with unit, shape, rate and length, and numbers of its events."""
    title = f"{recording.path}: {recording.name}, seed {recording.seed}"
    if recording.closed:
        return [Table(f"{title}; closed")]
    trials = recording.trials
    rows = [_signal_row(name, recording.extent(name)) for name in recording.signals]
    found = [Table(f"{title}, {recording.status}, {trials} trial{'s' * (trials != 1)}",
                   ("signal", "unit", "shape", "rate, Hz", "samples", "length, s"), rows)]
    return found + _event_tables(recording.events)


def _event_tables(events: Iterable[Any]) -> list[Table]:
    """Numbers of events by block and status; no table without events."""
    counts = Counter((event.where, event.status) for event in events)
    rows = [(*place, f"{count}") for place, count in counts.items()]
    return [Table("Events", ("where", "status", "times"), rows, folded=True)] if rows else []


def _signal_row(name: str, extent: Any) -> tuple[str, ...]:
    """A signal's row, of its first trial; its rate is the mean one."""
    shape = " x ".join(map(str, extent.shape)) or "scalar"
    span_s = (extent.last_ns - extent.first_ns) / NS_PER_S
    rate = f"{(extent.values - 1) / span_s:.5g}" if span_s > 0.0 else "-"
    return name, extent.unit, shape, rate, f"{extent.values}", f"{extent.last_ns / NS_PER_S:.5g}"


def result_tables(result: Any) -> list[Table]:
    """Troubles of a run, its metrics, and those that are tables themselves, such as by joint, folded."""
    status = f"{result.status}: {result.cause}" if result.cause else result.status
    rows = list(_metric_rows("", result.metrics))
    whole, parts = [row for row in rows if "." not in row[0]], [row for row in rows if "." in row[0]]
    tables = [Table(each) for each in result.troubles]
    title = f"{result.experiment}, seed {result.seed}: {status}; {result.recording}"
    tables.append(Table(title, ("metric", ""), whole))
    tables += _event_tables(result.events)
    return tables + ([Table("Their parts", ("metric", ""), parts, folded=True)] if parts else [])


def _metric_rows(place: str, metrics: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in metrics.items():
        if isinstance(value, Mapping):
            yield from _metric_rows(f"{place}{name}.", value)
        else:
            values = value if isinstance(value, (list, tuple)) else [value]
            yield f"{place}{name}", _short("  ".join(map(_number, values)))


def _number(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)

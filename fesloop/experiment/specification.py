"""Specification of an experiment: nodes, wires, duration, trials, recording and score."""

from __future__ import annotations

import copy
import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from fesloop.errors import InputError, InputErrors
from fesloop.experiment import registry
from fesloop.experiment.record_spec import Record
from fesloop.experiment.score_spec import Score
from fesloop.forms.schema import plain
from fesloop.loop.cautions import faults_in_place
from fesloop.loop.clock import FOREVER, NS_PER_S, RateClock, StampClock, duration_ns
from fesloop.loop.nodes import Node
from fesloop.loop.wire import TRANSPORT, Wire
from fesloop.loop.wiring import Wiring

if TYPE_CHECKING:
    from fesloop.loop.latency import LatencyReport

_REFERENCES = ("reference", "reference_preview")
_MEASURED = "measured"
_ROUNDING = 1e-8
"""Tolerance, rad, of angles converted into degrees and back."""


def row_faults(wiring: Wiring) -> list[InputError]:
    """Faults: references whose rows differ from the measured ones in name or order, or leave their ranges.

    Rows are known of a node that has `rows`, names of what its output lists; ranges of one that has `ranges`
    (m, 2), rad. A reference without names is known by its `extremes` (m, 2), rad.
    """
    sources: dict[str, dict[str, Node]] = {}
    for end in wiring.connections:
        port = end.target.part.inputs[end.target_port].name
        sources.setdefault(end.target.name, {})[port] = end.source
    faults: list[InputError] = []
    for controller, by_port in sources.items():
        measured = by_port.get(_MEASURED)
        references = {by_port[port].name: by_port[port] for port in _REFERENCES if port in by_port}
        if measured is not None:
            for reference in references.values():
                faults += _faults(reference, measured, controller)
    return faults


def _faults(reference: Node, measured: Node, controller: str) -> Iterator[InputError]:
    """Faults of one reference of a controller."""
    rows, names = _rows(reference), _rows(measured)
    if not names:
        return
    where = f"blocks.{reference.name}"
    if rows and rows != names:
        yield InputError(f"{where}.rows", ", ".join(rows),
                         f"{', '.join(names)}, as {measured.name} has that {controller} measures",
                         "give both the same rows in the same order")
    if rows or not (hasattr(reference.part, "extremes") and hasattr(measured.part, "ranges")):
        return
    extremes, limits = reference.part.extremes, measured.part.ranges
    for row, ends, (low, high) in zip(names, extremes, limits, strict=True):
        for value in ends:
            if not low - _ROUNDING <= value <= high + _ROUNDING:
                yield InputError(
                    where, f"{math.degrees(value):.5g} deg is outside the range of motion of {row}",
                    f"{math.degrees(low):.5g} to {math.degrees(high):.5g} deg", "stay within it")


def _rows(node: Node) -> tuple[str, ...]:
    """Names of the rows of a node's output; none if it has no names."""
    return tuple(getattr(node.part, "rows", ()))


_WIRE_NAMES = {"source": "from", "target": "to"}


def _wire_table(wire: Wire) -> dict[str, Any]:
    """The table of a wire in a file; the transport of a wire on a link is in the table of the link."""
    return {_WIRE_NAMES.get(key, key): value for key, value in plain(wire).items()
            if wire.link is None or key not in TRANSPORT}


def _link_tables(wires: Iterable[Wire]) -> dict[str, dict[str, Any]]:
    """The tables of the links in a file, by name."""
    return {wire.link: {key: value for key, value in plain(wire).items() if key in TRANSPORT}
            for wire in wires if wire.link is not None}


def with_transport(wire: Mapping[str, Any], document: Mapping[str, Any]) -> dict[str, Any]:
    """The table of a wire in a document, together with the transport of its link if it is on one."""
    return {**document.get("links", {}).get(wire.get("link"), {}), **wire}


_LONGEST_NAME = 100
_MOST_TRIALS, _GREATEST_SEED = 2**31 - 1, 2**63 - 1
"""Greatest numbers that a recording can store."""
MOST_TICKS = 10**10
"""Most ticks of a run (chosen: some six hours at 2 us each, the least that a tick takes)."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ExperimentSpecification:
    """Nodes and wires, run for some trials of some duration. Checked as a whole when made.

    Attributes
    ----------
    name, description: for people.
    nodes, wires: what runs, in the order of declaration.
    duration_s: of a trial, which covers [0, duration_s); None takes the longest recording that a node
        plays.
    trials: how many; learning blocks learn between them.
    seed: of everything random.
    record, score: what is recorded and compared.
    patient: whose parameters the nodes have, for the record: the table [patient] of the file.
    notes: what readers of its results have to know first, such as that a controller's model is a poor one.

    Raises
    ------
    InputError, InputErrors: every fault of the wiring, one line each.
    """

    name: str
    nodes: tuple[Node, ...]
    wires: tuple[Wire, ...] = ()
    duration_s: float | None = None
    trials: int = 1
    seed: int = 0
    description: str = ""
    record: Record = field(default_factory=Record)
    score: Score = field(default_factory=Score)
    patient: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()
    wiring: Wiring = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "trials", _as_integer(self.trials))
        object.__setattr__(self, "seed", _as_integer(self.seed))
        for key, kind in (("record", Record), ("score", Score)):
            if not isinstance(getattr(self, key), kind):
                raise InputError(key, f"{getattr(self, key)!r}", f"a {kind.__name__}",
                                 f"leave it out, or give {kind.__name__}()")
        _raise_any(self._faults_of_numbers())
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "nodes", tuple(self.nodes))
        object.__setattr__(self, "wires", tuple(self.wires))
        object.__setattr__(self, "wiring", Wiring(self.nodes, self.wires, self.seed))
        nodes = self.wiring.nodes
        faults = self.score.faults(nodes, self.record.leave_out) + self.record.faults(nodes)
        _raise_any(faults + row_faults(self.wiring))
        for node in self.nodes:
            if node.given_clock is not None:
                _owner(self.nodes, node)
        if self.score.after_s * NS_PER_S >= self.duration_ns:
            raise InputError("score.after_s", f"{self.score.after_s:g} leaves nothing of a trial",
                             f"below {self.duration_ns / NS_PER_S:g} s, the duration")
        _raise_any(self._faults_of_size())
        _raise_any(faults_in_place(self.wiring, self.duration_ns))

    def with_seed(self, seed: int) -> Self:
        """Copy the experiment with another seed; what does not depend on the seed is not checked again.

        It is the experiment that `load` makes with this seed. Raises InputErrors as that does.
        """
        made = copy.copy(self)
        object.__setattr__(made, "seed", _as_integer(seed))
        _raise_any(made._faults_of_numbers())
        object.__setattr__(made, "wiring", self.wiring.with_seed(made.seed))
        _raise_any(faults_in_place(made.wiring, made.duration_ns))
        return made

    def _faults_of_numbers(self) -> Iterator[InputError]:
        """Faults of everything but the wiring."""
        plain_name = self.name.replace("_", "a").replace("-", "a")
        if not plain_name.isalnum() or len(self.name) > _LONGEST_NAME:
            yield InputError("experiment.name", f"{self.name[:_LONGEST_NAME]!r}",
                             f"letters, digits, - and _, at most {_LONGEST_NAME}")
        if not (_is_integer(self.trials) and 1 <= self.trials <= _MOST_TRIALS):
            yield InputError("experiment.trials", f"{self.trials}",
                             f"an integer, 1 or more, at most {_MOST_TRIALS}")
        if not (_is_integer(self.seed) and 0 <= self.seed <= _GREATEST_SEED):
            yield InputError("experiment.seed", f"{self.seed}",
                             f"an integer, 0 or more, at most {_GREATEST_SEED}")
        if self.duration_s is not None and not 0.0 < self.duration_s * NS_PER_S < FOREVER:
            yield InputError("experiment.duration_s", f"{self.duration_s:g}",
                             f"seconds above 0, below {FOREVER / NS_PER_S:.2g}")
        if not self.nodes:
            yield InputError("blocks", "there is none", "one or more",
                             "add one: fesloop list names the kinds")

    def _faults_of_size(self) -> Iterator[InputError]:
        """Faults of runs that would take too long, each at the clock with the most ticks."""
        clocks = {f"blocks.{node.name}.rate": node.clock for node in self.nodes if not node.is_plant}
        clocks |= {f"blocks.{node.name}": node.plant.grid for node in self.nodes if node.is_plant}
        clocks["record.plant_rate"] = RateClock.from_rate(self.record.plant_rate)
        ticks = {where: self.trials * clock.first_at_or_after(self.duration_ns)
                 for where, clock in clocks.items() if clock is not None}
        if sum(ticks.values()) > MOST_TICKS:
            where, most = max(ticks.items(), key=lambda item: item[1])
            length = f"{self.trials} x {self.duration_ns / NS_PER_S:g} s"
            yield InputError(where, f"{clocks[where]} in {length} is {most:.2g} ticks",
                             f"at most {MOST_TICKS:.0e} ticks and steps of all blocks and plants in a run",
                             "take a lower rate, or a shorter run")

    @property
    def duration_ns(self) -> int:
        """Length of a trial, ns."""
        if self.duration_s is not None:
            return duration_ns(self.duration_s, NS_PER_S, "experiment.duration_s")
        ends = [int(clock.stamps_ns[-1]) + 1 for clock in (node.clock for node in self.nodes)
                if isinstance(clock, StampClock)]
        if not ends:
            raise InputError("experiment.duration_s", "is missing", "a number of seconds",
                             "add it: no node plays a recording that could give it")
        return max(ends)

    def document(self) -> dict[str, Any]:
        """Plain tables of the experiment with every parameter resolved, as a file would have them."""
        return copy.deepcopy(self._document())

    def _document(self) -> dict[str, Any]:
        """The document, without a copy of its cached tables."""
        about = {"name": self.name, "description": self.description,
                 "duration_s": None if self.duration_s is None else float(self.duration_s),
                 "trials": self.trials, "seed": self.seed, "notes": list(self.notes) or None}
        return {"experiment": {key: value for key, value in about.items() if value is not None},
                **self._tables, **({"code": code} if (code := self._code()) else {})}

    @cached_property
    def _tables(self) -> dict[str, Any]:
        """The document without the tables [experiment] and [code]: parameters do not change."""
        return {
            **({"patient": plain(self.patient)} if self.patient is not None else {}),
            "record": plain(self.record),
            "blocks": {node.name: self._block_table(node) for node in self.nodes},
            **({"links": links} if (links := _link_tables(self.wires)) else {}),
            "wires": [_wire_table(wire) for wire in self.wires],
            "score": plain(self.score),
        }

    def _code(self) -> dict[str, str]:
        """Present sources of classes that no installed package registers, by kind."""
        found = {}
        for part in dict.fromkeys(type(node.part) for node in self.nodes):
            kind = registry.kind_of(part)
            if source := registry.source(kind):
                found[kind] = source
            elif ":" in kind:
                from fesloop.experiment.own_blocks import kept_source  # installed kinds do without

                found[kind] = kept_source(part)
        return found

    def _block_table(self, node: Node) -> dict[str, Any]:
        place: dict[str, Any] = {}
        if not node.is_plant:
            place = {"offset_ms": float(node.offset_ms), "execution": plain(node.execution)}
        if node.given_clock is not None:
            place["clock"] = _owner(self.nodes, node)
        elif node.rate is not None:
            place["rate"] = plain(node.rate)
        return {"kind": registry.kind_of(type(node.part)), **place, **_parameters(node)}

    def fingerprint(self) -> str:
        """SHA-256 of the document as JSON text with all keys sorted, as hexadecimal text."""
        text = json.dumps(self._document(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    def as_json(self) -> str:
        """The document as JSON text, the same text for the same experiment.

        Keys are sorted, but blocks keep the order of their declaration, by which the loop breaks ties.
        """
        document = json.loads(json.dumps(self._document(), sort_keys=True))
        document["blocks"] = {node.name: document["blocks"][node.name] for node in self.nodes}
        return json.dumps(document, separators=(",", ":"))

    def latency_report(self) -> LatencyReport:
        """Latency of every path from a plant's output through blocks to a plant's input, over a trial."""
        from fesloop.loop.latency import LatencyReport

        return LatencyReport(self.wiring, horizon_ns=self.duration_ns)

    def __repr__(self) -> str:
        return (f"{type(self).__name__}({self.name!r}: {len(self.nodes)} nodes, {len(self.wires)} wires, "
                f"{self.trials} x {self.duration_ns / NS_PER_S:g} s, seed {self.seed})")

    def __str__(self) -> str:
        from fesloop.experiment.shown import experiment_tables
        from fesloop.tables import as_text

        return as_text(experiment_tables(self))

    def _repr_html_(self) -> str:
        from fesloop.experiment.shown import experiment_tables
        from fesloop.tables import as_html

        return as_html(experiment_tables(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ExperimentSpecification) and self.as_json() == other.as_json()

    def __hash__(self) -> int:
        return hash(self.as_json())


def _parameters(node: Node) -> dict[str, Any]:
    """Plain parameters of a node's part. Raises InputError for those that a document cannot hold."""
    part: object = node.part
    if not is_dataclass(part):
        raise InputError(f"blocks.{node.name}", f"{type(part).__name__} is no dataclass",
                         "parameters as fields of a frozen dataclass", "see docs/howto/add_a_block.md")
    parameters = plain(part)
    for key, value in parameters.items():
        try:
            json.dumps(value)
        except (TypeError, ValueError):
            raise InputError(f"blocks.{node.name}.{key}", f"a {type(value).__name__} cannot be recorded",
                             "numbers, text, arrays, and tuples or dataclasses of them",
                             "make it a method of the class, or a number that chooses it") from None
    return dict(parameters)


def _as_integer(number: Any) -> Any:
    """Convert an integer of NumPy into one of Python; other values are left to the check."""
    return int(number) if isinstance(number, np.integer) else number


def _is_integer(number: object) -> bool:
    return isinstance(number, int) and not isinstance(number, bool)


def _raise_any(faults: Iterable[InputError]) -> None:
    """Raise all faults as one error, if there are any."""
    every = list(faults)
    if every:
        raise InputErrors(every)


def _owner(nodes: Iterable[Node], follower: Node) -> str:
    """Name of the node with the clock that a node follows; raises InputError if there is none."""
    for node in nodes:
        if node.given_clock is None and node.clock == follower.given_clock:
            return node.name
    raise InputError(f"{follower.name}.rate", "is a clock that no other node has",
                     "a rate, or the clock of another node")

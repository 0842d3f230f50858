"""The loop: everything due at an instant, in the declared order, from one instant to the next.

At an instant t, in this order: plants are advanced to t under the inputs latched before t; messages due at
t are delivered; plant outputs are published; blocks due at t step in topological order over zero-latency
wires, sending as they step; the recorder reads. Plants are advanced and messages delivered only when their
values are read, which gives the same values and costs nothing for values that are not read.
"""

from __future__ import annotations

import pickle
from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from contextlib import ExitStack, suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property, partial
from hashlib import sha256
from heapq import heapify, heapreplace
from numbers import Rational, Real
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from fesloop.errors import FesloopError, InputError, RunError, SnapshotError
from fesloop.loop.abilities import Closes, Learns, offers
from fesloop.loop.assembly import AheadStation, BlockStation, assembled, sampled_in_order
from fesloop.loop.clock import NS_PER_MS, Clock, RateClock
from fesloop.loop.latency import LatencyReport
from fesloop.loop.nodes import Node
from fesloop.loop.plants import Sampler
from fesloop.loop.record import EventRow, Recorder
from fesloop.loop.signals import Sample, Value
from fesloop.loop.wiring import Wiring, require_count


def parameter_digests(part: object) -> dict[str, str]:
    """A digest of each parameter of a part, by name; derived fields are not parameters."""
    return {name: sha256("\n".join(_lines(value, ())).encode()).hexdigest()
            for name, value in _parameters(getattr(part, "__wrapped__", part))}


def changed(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names of the parameters that differ."""
    return [name for name in {**before, **now} if before.get(name) != now.get(name)]


def _parameters(part: Any) -> Iterator[tuple[str, Any]]:
    """Names and values: init fields of a dataclass, attributes of another object."""
    if is_dataclass(part):
        for field in fields(part):
            if field.init:
                yield field.name, getattr(part, field.name)
    else:
        yield from getattr(part, "__dict__", {}).items()


def _lines(value: Any, within: tuple[int, ...]) -> Iterator[str]:
    """Lines of text that are equal for equal values; `within` are the ids of the enclosing values."""
    if value is None or isinstance(value, str | bytes | Enum):
        yield repr(value)
    elif isinstance(value, Real):
        yield _number(value)
    elif isinstance(value, np.ndarray | np.generic):
        yield f"array {value.dtype} {value.shape}"
        if value.dtype.hasobject:
            yield from _inside("item", value.ravel().tolist(), within)
        else:
            yield value.tobytes().hex()
    elif isinstance(value, type):
        yield f"{value.__module__}.{value.__qualname__}"
    elif id(value) in within:
        yield "again"
    elif isinstance(value, MethodType | FunctionType | CodeType | partial):
        yield from _function(value, (*within, id(value)))
    elif callable(value) and hasattr(value, "__qualname__"):
        yield f"{value.__module__}.{value.__qualname__}"
        for name in ("py_func", "__self__"):  # what numba has compiled; what a method written in C is of
            if not isinstance(bound := getattr(value, name, None), ModuleType):
                yield from _lines(bound, (*within, id(value)))
    else:
        yield from _held(value, (*within, id(value)))


def _function(value: MethodType | FunctionType | CodeType | partial[Any],
              within: tuple[int, ...]) -> Iterator[str]:
    """Lines of a function: its name, its code, and the values bound to it.

    Two functions from one place in a file have one name, such as those of a factory or two lambdas. The path
    of the file and the line make no difference, nor do globals, which belong to the module.
    """
    if isinstance(value, MethodType):
        parts: tuple[Any, ...] = (value.__func__, value.__self__)
    elif isinstance(value, partial):
        parts = (value.func, value.args, value.keywords)
    elif isinstance(value, CodeType):
        parts = (value.co_code, value.co_consts, value.co_names, value.co_varnames, value.co_freevars,
                 value.co_argcount, value.co_kwonlyargcount, value.co_flags)
    else:
        cells = tuple(_content(cell) for cell in value.__closure__ or ())
        parts = (f"{value.__module__}.{value.__qualname__}", value.__code__, value.__defaults__,
                 value.__kwdefaults__, cells)
    yield from _inside("function", parts, within)


def _content(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # still empty
        return None


def _held(value: Any, within: tuple[int, ...]) -> Iterator[str]:
    """Lines of a container or object."""
    if isinstance(value, Mapping):
        yield f"mapping {len(value)}"
        yield from sorted("\n".join(_inside("item", item, within)) for item in value.items())
    elif isinstance(value, list | tuple):
        yield from _inside("sequence", value, within)
    elif isinstance(value, Set):
        yield f"set {len(value)}"
        yield from sorted("\n".join(_lines(each, within)) for each in value)
    else:
        named = list(_parameters(value))
        yield f"{type(value).__module__}.{type(value).__qualname__} {len(named)}"
        if not named:
            yield from _own_text(value)
        for each in named:
            yield from _inside("item", each, within)


def _own_text(value: object) -> Iterator[str]:
    """`repr` of an object without named parts, unless it contains the address of the object."""
    text = repr(value)
    if hex(id(value)) not in text.lower():
        yield text


def _inside(kind: str, values: Any, within: tuple[int, ...]) -> Iterator[str]:
    yield f"{kind} {len(values)}"
    for each in values:
        yield from _lines(each, within)


def _number(value: Real) -> str:
    """The same text for 1, 1.0 and numpy's 1.0."""
    if isinstance(value, Rational):
        return f"{value.numerator}/{value.denominator}" if value.denominator != 1 else str(value.numerator)
    number = float(value)
    return str(int(number)) if number.is_integer() else repr(number)


class Agenda:
    """Stations by the instants at which they are due, then by their number in the firing order."""

    __slots__ = ("_ahead", "_heap", "_numbers")

    def __init__(self, stations: Iterable[tuple[int, BlockStation | Sampler]]) -> None:
        self._heap = [(station.due, number, station) for number, station in stations]
        self._numbers = {id(station): number for _, number, station in self._heap}
        self._ahead = [station for _, _, station in self._heap if isinstance(station, AheadStation)]
        heapify(self._heap)

    def run_until(self, time_ns: int) -> None:
        """Fire everything due at or before `time_ns`."""
        heap = self._heap
        for each in self._ahead:
            each.until_ns = time_ns
        while heap and heap[0][0] <= time_ns:
            now, number, station = heap[0]
            heapreplace(heap, (station.fire(now), number, station))

    def run_before(self, time_ns: int, turn: BlockStation) -> None:
        """Fire everything due before `time_ns`, and at `time_ns` what comes before a block's turn."""
        heap = self._heap
        for each in self._ahead:
            each.until_ns = time_ns - 1
        last = (time_ns, self._numbers[id(turn)])
        while heap[0] < last:  # a longer tuple is not less than its beginning: stations are not compared
            now, number, station = heap[0]
            heapreplace(heap, (station.fire(now), number, station))

    def where(self) -> str:
        """Name and instant of the block or plant that fires, or comes next."""
        if not self._heap:
            return "the loop"
        now, _, station = self._heap[0]
        name = station.plant.name if isinstance(station, Sampler) else station.name
        return f"{name} at {now / NS_PER_MS:g} ms"

    def forget_ahead(self) -> None:
        """Remove the rows of ticks that were run ahead of the present instant, at which the run failed."""
        if not self._ahead:
            return
        now, turn, _ = self._heap[0]
        for _, number, station in self._heap:
            if isinstance(station, AheadStation):
                station.forget_after(now if number < turn else now - 1)

    def arrive(self, clock: RateClock, time_ns: int, skipping: Collection[str]) -> None:
        """Let a clock of arrivals tick at `time_ns`; the blocks of these names skip the tick."""
        for place, (_, number, station) in enumerate(self._heap):
            if station.clock == clock:
                station.due = time_ns
                if isinstance(station, BlockStation) and station.name in skipping:
                    station.skip("its message came late")
                self._heap[place] = station.due, number, station
        heapify(self._heap)

    def skip_until(self, time_ns: int, clocks: Collection[Clock]) -> set[int]:
        """Skip ticks of blocks on these clocks where the next is due by `time_ns` too; return instants."""
        skipped: set[int] = set()
        for place, (_, number, station) in enumerate(self._heap):
            if isinstance(station, BlockStation) and station.clock in clocks:
                while station.clock.tick(station.index + 1) <= time_ns:
                    skipped.add(station.due)
                    station.skip(f"{(time_ns - station.due) / NS_PER_MS:.3f} ms late")
                self._heap[place] = station.due, number, station
        heapify(self._heap)
        return skipped


class Snapshot:
    """A loop at rest at one instant, as bytes.

    Attributes
    ----------
    time_ns, trial: instant and trial of the snapshot.
    wiring: seed, nodes and wires as text.
    parameters: digests of each node's parameters, by their names.
    """

    __slots__ = ("content", "parameters", "time_ns", "trial", "wiring")

    def __init__(self, content: bytes, time_ns: int, trial: int, wiring: str,
                 parameters: Mapping[str, Mapping[str, str]]) -> None:
        self.content, self.time_ns, self.trial, self.wiring = content, time_ns, trial, wiring
        self.parameters = parameters


class Loop:
    """A wiring in operation.

    Parameters
    ----------
    wiring: what runs.
    trial: number of the first trial.
    recorder: receives what happens; None records nothing but events.

    Attributes
    ----------
    now: everything due at or before this instant (ns) has happened; -1 before t = 0.
    """

    def __init__(self, wiring: Wiring, trial: int = 0, recorder: Recorder | None = None) -> None:
        self.wiring, self.trial, self.now = wiring, require_count("trial", trial), -1
        self.recorder = recorder
        self._ended = ""
        self._events = recorder.events if recorder is not None else []
        states: dict[str, Any] = {}
        self._open: dict[str, Any] = states
        try:
            for node in wiring.nodes:
                states[node.name] = node.part.init(node.context(wiring.seed, trial))
        except BaseException:
            self.close()
            raise
        self._start(states)

    def _start(self, states: dict[str, Any]) -> None:
        """Put everything at t = 0 with the given states."""
        self._open = states
        self.now = -1
        made = assembled(self.wiring, self.trial, states, self.recorder, self._events)
        self._links, self._plants, self._blocks = made.links, made.plants, made.blocks
        self._named = {block.name: block for block in made.blocks}
        self._samplers, self._publishers = made.samplers, made.publishers
        self._schedule()

    def _schedule(self) -> None:
        """The events to come: block ticks, and samplings that must keep their place among them."""
        blocks, samplers = iter(self._blocks), iter(self._samplers)
        stations = [next(blocks) if isinstance(item, Node) else next(samplers) for item in self.wiring.order]
        ordered = sampled_in_order(self.wiring)
        self._agenda = Agenda((number, station) for number, station in enumerate(stations)
                              if not isinstance(station, Sampler) or station.plant.name in ordered)

    def run_until(self, time_ns: int) -> None:
        """Do everything due at or before `time_ns` that has not been done.

        Raises RunError where an output is not what its port declares, a plant's is not finite or a device
        fails; the record stays, and the loop continues from a snapshot only. Raises InputError, and
        does nothing, where `time_ns` is not a whole number.
        """
        self._advance(_whole_ns(time_ns), None)

    def run_until_turn(self, name: str, time_ns: int, observer: str | None = None) -> tuple[Sample, ...]:
        """Do everything due before a block's tick at `time_ns`, and return what the tick will read.

        At `time_ns` itself, this is what comes before the block in the order of the wiring. What is put into
        the block's state now, such as an action, acts in this tick, which the next call begins with.
        Samples that have reached the inputs of `observer`, another block, follow; it does not step for them.
        Raises InputError where the block has no tick to come at `time_ns`; else as `run_until`.
        """
        time_ns = _whole_ns(time_ns)
        turn = self._named.get(name)
        watching = self._named.get(observer) if observer is not None else None
        if turn is None or (observer is not None and watching is None):
            raise InputError("run_until_turn", f"there is no block {(name if turn is None else observer)!r}",
                             ", ".join(block.name for block in self._blocks))
        if turn.due != time_ns and not turn.due <= time_ns == turn.clock.tick(
                turn.clock.first_at_or_after(time_ns)):
            raise InputError("run_until_turn", f"{name} has no tick to come at {time_ns} ns",
                             f"a tick from {turn.due} ns on")
        self._advance(time_ns, turn, watching)
        return (*turn.held, *watching.held) if watching is not None else (*turn.held,)

    def _advance(self, time_ns: int, turn: BlockStation | None, watching: BlockStation | None = None) -> None:
        """Run until the end of an instant, or until a block's turn in it, which another block watches."""
        if self._ended:
            raise RunError(f"the loop {self._ended}")
        if self.recorder is None:
            self._events.clear()
        self._ended = "has failed: restore a snapshot of before"
        try:
            # Overflow needs no warning of numpy's: what is not finite is caught where it is put out.
            with np.errstate(over="ignore", invalid="ignore"):
                if turn is not None:
                    self._agenda.run_before(time_ns, turn)
                    turn.read(time_ns)
                    if watching is not None:
                        watching.read(time_ns)
                else:
                    self._agenda.run_until(time_ns)
                    for publisher in self._publishers.values():
                        publisher.until(time_ns)
                    for plant in self._plants.values():
                        plant.settle(time_ns)
        except Exception as fault:
            if not isinstance(fault, FesloopError):
                fault.add_note(f"fesloop: in {self._agenda.where()}, or in a plant that it reads")
            self._agenda.forget_ahead()
            self._keep(fault)
            raise
        self.now = max(self.now, time_ns if turn is None else time_ns - 1)
        self._ended = ""

    @property
    def events(self) -> tuple[EventRow, ...]:
        """(time in ns, node, status, detail) of each report.

        With a recorder, all reports in it; without one, those of the last `run_until` or `run_until_turn`.
        """
        return tuple(self._events)

    def arrive(self, clock: RateClock, time_ns: int, skipping: Collection[str] = ()) -> None:
        """Let every block on a clock of arrivals tick at `time_ns`, as its live stream has a message.

        The instant is later than `now`, and nothing happens before `run_until` reaches it. Blocks named in
        `skipping` skip the tick, which is recorded. Raises ValueError for an instant that has been run.
        """
        if time_ns <= self.now:
            raise ValueError(f"{time_ns} ns has been run, up to {self.now} ns")
        for sampler in self._samplers:
            if sampler.clock == clock:
                sampler.due = time_ns
        for publisher in self._publishers.values():
            publisher.settle()
        self._agenda.arrive(clock, time_ns, skipping)

    def skip_until(self, time_ns: int, clocks: Collection[Clock]) -> set[int]:
        """Skip late ticks of the blocks on these clocks; return their instants, ns.

        A tick is late where the next tick of its block is due at or before `time_ns` too.
        Each is recorded as an event `skipped`. Plants and other blocks run these instants as usual.
        """
        return self._agenda.skip_until(time_ns, clocks)

    def fail(self, cause: str) -> RunError:
        """Record the failure of a run that something outside the loop ends, and return it to be raised."""
        fault = RunError(cause)
        self._ended = "has been stopped"
        self._keep(fault)
        return fault

    def _keep(self, fault: Exception) -> None:
        """Record the outputs of plants before they failed, and the cause."""
        for plant in self._plants.values():
            with suppress(Exception):  # the first failure is the one reported
                plant.hand_over()
        now = max((plant.now for plant in self._plants.values()), default=max(self.now, 0))
        cause = str(fault) if isinstance(fault, RunError) else f"{type(fault).__name__}: {fault}"
        self._events.append((now, "loop", "failed", cause))

    def next_trial(self) -> None:
        """Return to t = 0 for the next trial, with what each part carries over (`Learns.next_trial`)."""
        if self._ended:
            raise RunError(f"the loop {self._ended}")
        for plant in self._plants.values():
            plant.finish(self.now)
        states = self.states()
        self.trial += 1
        fresh: dict[str, Any] = {}
        for node in self.wiring.nodes:
            context = node.context(self.wiring.seed, self.trial)
            if offers(node.part, Learns):
                fresh[node.name] = node.part.next_trial(states[node.name], context)
            else:
                del self._open[node.name]
                _close(node, states[node.name])
                fresh[node.name] = node.part.init(context)
            self._open[node.name] = fresh[node.name]
        self._start(fresh)

    def states(self) -> dict[str, Any]:
        """State of every node, by name."""
        states = {name: plant.state for name, plant in self._plants.items()}
        states.update((block.name, block.state) for block in self._blocks)
        return states

    def newest(self, name: str) -> dict[str, Value]:
        """Newest outputs of a node, by port: of a block what it has put out last, of a plant what it would
        put out now. A block that has put out nothing has none. Nothing changes."""
        if name in self._plants:
            return self._plants[name].peek()
        block = self._named[name]
        return {port.name: value for port, value in zip(block.block.outputs, block.newest, strict=True)
                if value is not None}

    def snapshot(self) -> Snapshot:
        """Snapshot of everything that changes. Raises SnapshotError where a device cannot save its state."""
        if self._ended:
            raise SnapshotError(f"the loop {self._ended}")
        saved = ([link.save() for link in self._links],
                 [station.save() for station in self._stations()],
                 {name: plant.save() for name, plant in self._plants.items()})
        try:
            content = pickle.dumps(saved, protocol=pickle.HIGHEST_PROTOCOL)
        except (TypeError, pickle.PicklingError, AttributeError) as cause:
            raise SnapshotError(f"the state of a block cannot be saved: {cause}") from cause
        return Snapshot(content, self.now, self.trial, self._signature(), self._parameters)

    @cached_property
    def _parameters(self) -> dict[str, dict[str, str]]:
        """Digests of every node's parameters, which never change."""
        return {node.name: parameter_digests(node.part) for node in self.wiring.nodes}

    def _signature(self) -> str:
        """The wiring as text, without the parameters of its parts."""
        nodes = [(n.name, type(n.part).__qualname__, str(n.clock), n.execution) for n in self.wiring.nodes]
        return repr((self.wiring.seed, nodes, [c.wire for c in self.wiring.connections]))

    def restore(self, snapshot: Snapshot) -> None:
        """Continue from a snapshot of this wiring.

        The recorder keeps the rows that it has, those after the snapshot's instant too: drain it before.

        Raises SnapshotError for one of another trial, of another wiring or of other parameters.
        """
        if snapshot.trial != self.trial:
            raise SnapshotError(f"the snapshot is of trial {snapshot.trial}, the loop is in {self.trial}")
        if snapshot.wiring != self._signature():
            raise SnapshotError("the snapshot is of another wiring or seed")
        for name, parameters in self._parameters.items():
            if differing := changed(snapshot.parameters[name], parameters):
                raise SnapshotError(f"{name}: the snapshot was made with other parameters "
                                    f"({', '.join(differing)}); restore it into a loop of the same")
        links, stations, plants = pickle.loads(snapshot.content)
        for node in self.wiring.nodes:
            if node.name in self._open:
                _close(node, self._open[node.name])
        for link, saved in zip(self._links, links, strict=True):
            link.restore(saved)
        for station, saved in zip(self._stations(), stations, strict=True):
            station.restore(saved)
        for name, saved in plants.items():
            self._plants[name].restore(saved, snapshot.time_ns)
        self._open = self.states()
        for publisher in self._publishers.values():
            publisher.settle()
        self._schedule()
        self.now, self._ended = snapshot.time_ns, ""
        if self.recorder is None:
            self._events.clear()

    def _stations(self) -> list[BlockStation | Sampler]:
        return [*self._blocks, *self._samplers]

    def message_counts(self) -> dict[str, dict[str, int]]:
        """Messages sent, lost and dropped as late, by wire."""
        counted = {id(link): s.sent for s in self._stations() for link in s.plain_links}
        return {link.wire_name: {"sent": counted.get(id(link), link.sent), "lost": link.lost,
                                 "late": link.late} for link in self._links}

    def latency_report(self, horizon_ns: int | None = None) -> LatencyReport:
        """Latency of every path from a plant output back to a plant input, by stage."""
        return LatencyReport(self.wiring, self.trial, horizon_ns)

    def close(self) -> None:
        """Close every device, the last first, whatever fails; failures are raised at the end."""
        try:
            with ExitStack() as letting_go:
                for node in self.wiring.nodes:
                    if node.name in self._open:
                        letting_go.callback(_close, node, self._open[node.name])
                self._open, self._ended = {}, "is closed"
        except RunError as fault:
            self._events.append((max(self.now, 0), "loop", "failed", str(fault)))
            raise


def _whole_ns(time_ns: float) -> int:
    """The instant as an integer. Raises InputError where it is no whole number of ns."""
    if type(time_ns) is int:
        return time_ns
    whole = isinstance(time_ns, int | float | np.integer) and not isinstance(time_ns, bool)
    if not whole or time_ns % 1 != 0:
        raise InputError("run_until", f"{time_ns!r}", "a whole number of ns",
                         "such as 1_500_000_000 for 1.5 s")
    return int(time_ns)


def _close(node: Node, state: Any) -> None:
    """Close a node's device, if it is one."""
    if offers(node.part, Closes):
        node.part.close(state)

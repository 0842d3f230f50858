"""Optional members of blocks and plants, each a Protocol, and the check of a class against the contract.

A part has an ability where it has the member (`offers`). `contract_faults` checks a class that is registered
as a kind against the contract and every Protocol here whose member it has.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from threading import Event
from typing import Any, Literal, Protocol, TypeGuard, TypeVar, cast

from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Block, Context, Plant, Tick, is_plant
from fesloop.loop.clock import Clock
from fesloop.loop.signals import Sample, Sensors, Value

Report = tuple[str, str]
"""(status, detail)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """Path of some inputs through a block, with the waits inside the block.

    A message takes effect `delay_ns` after `since`, until the next message that was read does; the block's
    steps from then on have outputs that follow it. With lanes a step serves one of them only. An input that
    no passage names acts on every output in the step that reads it.

    Attributes
    ----------
    inputs: names of the ports whose messages wait.
    outputs: names of the ports that follow them in this way; empty: all.
    delay_ns: wait inside the block.
    since: start of the delay: the message's arrival, or the step that first reads it.
    delay: name of the delay in the latency budget.
    lanes: names of what the block serves in turn, such as channels: the outputs of tick k follow the input
        for lane k mod `slots` alone, and there is no lane for the slots beyond. Empty: no turns.
    slots: turns of a round; at least as many as lanes.
    turn: name of the wait for a turn in the latency budget.
    holds: whether outputs show what a lane was given until its next turn; else in its turn only.
    later: when outputs follow what is read, in words, where that is no fixed time, such as "in the next
        trial"; empty where it is.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...] = ()
    delay_ns: int = 0
    since: Literal["arrival", "read"] = "arrival"
    delay: str = "delay"
    lanes: tuple[str, ...] = ()
    slots: int = 0
    turn: str = "wait for its turn"
    holds: bool = False
    later: str = ""

    def __post_init__(self) -> None:
        if self.slots < len(self.lanes) or (self.lanes and self.since == "read"):
            raise ValueError("a passage with lanes has a slot for each and counts from arrival")


@dataclass(frozen=True, slots=True, kw_only=True)
class AgeLimit:
    """Greatest age at which a block uses an input.

    Attributes
    ----------
    port: name of the input.
    limit_ms: the greatest age.
    since: start of the age: the oldest or the newest capture behind the value.
    key: the parameter that sets the limit.
    then: what the block does where the input is older, in words.
    """

    port: str
    limit_ms: float
    since: Literal["oldest", "newest"]
    key: str = "max_age_ms"
    then: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """Place of a block in its loop, known before anything runs.

    Attributes
    ----------
    loop_ns: of the slowest path from a plant output through the block to a plant input (each channel of a
        stimulator is one), the least time from capture to effect; 0 where no path leads through it.
    way: that path, in words.
    coming: by input port, everything that a block without inputs puts out on it over a trial, stacked along a
        first axis; ports wired otherwise are left out.
    actuation_ns: mean time from its tick to effect on a plant, on the slowest path; None where no path leads
        through it, and for `faults`.
    age_ns: by input port, mean time from capture to its tick, on the slowest path; as `actuation_ns`.
    """

    loop_ns: int = 0
    way: str = ""
    coming: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    actuation_ns: float | None = None
    followers: Mapping[str, str] = field(default_factory=dict)
    age_ns: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Present:
    """Start of a trial on the wall clock, for blocks that work with the outside world.

    Attributes
    ----------
    origin_ns: `time.monotonic_ns()` at t = 0 of the trial.
    bell: the loop sleeps on it; set it, from any thread, when something has arrived.
    """

    origin_ns: int
    bell: Event


class Designs(Protocol):
    """A part whose coefficients follow from its parameters and its clock."""

    def design(self, context: Context) -> Any:
        """Coefficients, which `init` puts into the state; no step changes them."""


class Learns(Protocol):
    """A part that carries something over to the next trial."""

    def next_trial(self, state: Any, context: Context) -> Any:
        """State at the start of the next trial, in place of `init(context)`."""


class Closes(Protocol):
    """A part that keeps something open outside Python, such as a device."""

    def close(self, state: Any) -> None:
        """Release it."""


class Resolves(Protocol):
    """A part with inputs of open size."""

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Any:
        """A copy for the shapes, by input name, of what is wired to the inputs."""


class UsesSensors(Protocol):
    """A part that depends on the sensors whose samples it reads."""

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Any:
        """A copy for the sensors, by input name, whose samples are wired to it."""


class ExplainsInputs(Protocol):
    """A part that knows another remedy for an input without a wire."""

    @property
    def for_open_inputs(self) -> str:
        """Remedy added to the message."""


class Linear(Protocol):
    """A part that is linear, or can be (`fesloop.models.linear_form`)."""

    def linear_form(self, place: Any) -> Any:
        """Linear form: of a block in a Context, of a plant with one of its outputs."""


class Warns(Protocol):
    """A part that warns about its own parameters."""

    def cautions(self, context: Context) -> Iterable[Report]:
        """Warnings about its parameters, shown by `fesloop check`."""


class HasClock(Protocol):
    """A block with a clock of its own; the wiring then gives no rate."""

    @property
    def clock(self) -> Clock | None:
        """Clock of its steps; None for the rate of the wiring."""


class StepsThrough(Protocol):
    """A block that does several ticks in one call, where what it reads at each of them is known."""

    def steps_through(self, state: Any, inputs: Sequence[Sequence[Sample]], ticks: Sequence[Tick]
                      ) -> tuple[Any, ...]:
        """Outputs of `ticks`, stacked along a first axis; `inputs[port][k]` is what tick k reads.

        Outputs, state and reports are to the last bit those of `step` at each tick in turn. The stacks are
        new arrays, a list of floats for a scalar port. Such a block puts something out at every tick, and
        does not set the capture of its outputs.
        """


class ChecksPlace(Protocol):
    """A block whose parameters cannot work in every place."""

    def faults(self, context: Context, surroundings: Surroundings) -> Iterable[InputError]:
        """Faults of its parameters in its place, raised when an experiment is made."""


class WarnsInPlace(Protocol):
    """A block whose parameters are doubtful in some places."""

    def cautions_in_place(self, context: Context, surroundings: Surroundings) -> Iterable[Report]:
        """Warnings about its parameters in its place, shown by `fesloop check`."""


class Delays(Protocol):
    """A block whose inputs wait before its outputs follow."""

    def passages(self, context: Context) -> Sequence[Passage]:
        """The waits, for the latency budget."""


class LimitsAge(Protocol):
    """A block that ignores inputs beyond an age."""

    def age_limits(self) -> Sequence[AgeLimit]:
        """The limits; `fesloop check` uses them to find inputs that are always too old."""


class Attaches(Protocol):
    """A block that works with the outside world as it is now: it needs a run in real time."""

    def attach(self, state: Any, present: Present) -> None:
        """Start of a trial, before its first tick."""


class AwaitsArrivals(Protocol):
    """A block that steps when a sample arrives, on a clock of arrivals."""

    def waiting(self, state: Any) -> int | None:
        """Loop time (ns) at which the oldest sample not yet read arrived; None if there is none.

        All blocks on the clock of arrivals tick at that instant, or at the next that has not been run; a step
        reads one sample.
        """


class Listens(Protocol):
    """A block that passes on what the run reports."""

    def heed(self, state: Any, events: Sequence[tuple[int, str, str, str]]) -> None:
        """Reports of an instant that has been run: (instant, block, status, detail) each."""


class Captures(Protocol):
    """A block whose outputs are captured when it steps, whatever it reads, such as a stimulated person's EMG.

    Its step sets `tick.captured_ns` to its instant.
    """

    @property
    def captures(self) -> bool:
        """True if it does with its parameters."""


class HasStandIn(Protocol):
    """A block that a rehearsal of a run must not touch."""

    def stand_in(self) -> Block:
        """A block with the same ports and a plain clock that touches nothing outside."""


class Seeks(Protocol):
    """A block that needs something outside to be there."""

    def seek(self) -> None:
        """Raise InputError for what is not there yet; called before the rehearsal, and may take a while."""


class Guarded(Protocol):
    """A device that acts on a person."""

    @property
    def guarded(self) -> Sequence[str]:
        """Inputs that a guard must feed directly."""


class ChecksGuard(Protocol):
    """A guarded device that makes demands on its guard."""

    def faults_behind(self, guard: Any) -> Iterable[InputError]:
        """Faults of this guard."""


class Guards(Protocol):
    """A block that may feed a guarded input: it limits what passes."""

    @property
    def guards(self) -> bool:
        """True if it limits anything with its parameters."""


class Interlocks(Protocol):
    """A guard that holds back stimulation until trackers are aligned."""

    @property
    def interlock(self) -> str:
        """Input that allows stimulation while it is above 0."""


class NeedsStillness(Protocol):
    """A tracker that begins with an initial pose, during which the wearer keeps still."""

    @property
    def needs_stillness(self) -> str:
        """Output of shape (1,) that is 0 until the pose has been taken; "" where its parameters need none."""


class Ignores(Protocol):
    """A plant with optional inputs that make no difference with its parameters."""

    @property
    def ignores(self) -> Sequence[str]:
        """Names of these inputs: no other plant is sampled for them."""


class KeepsOwnTime(Protocol):
    """A plant made elsewhere, in which a sample may spend time that no declaration here states."""

    @property
    def own_step_s(self) -> float:
        """Step that it declares for itself, such as a sampling period, s; 0 where it declares none."""


class Observes(Protocol):
    """An exact plant that evaluates its outputs ahead without being advanced."""

    def observe(self, state: Any, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
                ) -> tuple[Any, ...]:
        """Outputs at `times_ns` (all >= `start_ns`) under constant inputs, each stacked along a first axis.

        They equal to the last bit what a copy gives that is advanced to each of these instants, whichever
        others are listed; the state does not change.
        """


class AdvancesThrough(Protocol):
    """An exact plant that advances through many instants at once."""

    def advance_through(self, state: Any, inputs: Sequence[tuple[int, Sequence[Value]]],
                        times_ns: Sequence[int]) -> tuple[Any, ...]:
        """Outputs at ascending instants, stacked; to the last bit as advanced and read one by one.

        `inputs` are (instant, values of all ports from then on), ascending, the first of the instant that the
        state is of, and no other at or after the last of `times_ns`. Outputs of an instant at which an input
        changes do not show that yet.
        """


class AdvancesSteps(Protocol):
    """A plant of fixed steps that takes several of them in one call."""

    def advance_steps(self, state: Any, inputs: Sequence[Sequence[Value]], start_ns: int,
                      times_ns: Sequence[int]) -> bool:
        """Advance through grid ticks; `inputs[port][k]` acts in the step that ends at `times_ns[k]`.

        The state is to the last bit as after `advance` to each of them. False where it does not go that far,
        such as where the simulation becomes unstable: the state is then that of `start_ns`, and the caller
        takes the steps one by one.
        """


class Reports(Protocol):
    """A plant of fixed steps that reports trouble."""

    def reports(self, state: Any) -> Iterable[Report]:
        """Reports of its last step, or of its start."""


class Glances(Protocol):
    """A plant of fixed steps some of whose outputs need little work."""

    def glance(self, state: Any) -> Mapping[int, Value]:
        """These outputs, by port number. A wire that samples no other is spared `read`."""


COMMON: tuple[type, ...] = (Designs, Learns, Closes, Resolves, UsesSensors, ExplainsInputs, Linear, Warns)
OF_BLOCKS: tuple[type, ...] = (
    *COMMON, HasClock, StepsThrough, ChecksPlace, WarnsInPlace, Delays, LimitsAge, Attaches, AwaitsArrivals,
    Listens, Captures, HasStandIn, Seeks, Guarded, ChecksGuard, Guards, Interlocks, NeedsStillness)
OF_PLANTS: tuple[type, ...] = (
    *COMMON, Ignores, KeepsOwnTime, Observes, AdvancesThrough, AdvancesSteps, Reports, Glances)

A = TypeVar("A")


@cache
def members(ability: Hashable) -> dict[str, Any]:
    """Functions and properties that a Protocol declares, by name."""
    return {name: value for name, value in vars(ability).items()
            if not name.startswith("_") and (inspect.isfunction(value) or isinstance(value, property))}


def offers(part: object, ability: type[A]) -> TypeGuard[A]:
    """True if a part, or a class of parts, has an ability.

    `isinstance` would miss what a wrapper of a part forwards.
    """
    return all(hasattr(part, name) for name in members(cast(Hashable, ability)))


def contract_faults(cls: type) -> Iterator[str]:
    """Faults of the members of a class that is registered as a block or a plant, one line each."""
    contract, abilities = (Plant, OF_PLANTS) if is_plant(cls) else (Block, OF_BLOCKS)
    declared = {each.name for each in fields(cls)} if is_dataclass(cls) else set()
    for name, member in members(contract).items():
        if not hasattr(cls, name) and name not in declared:
            yield f"{_written(name, member)} is missing, which every {contract.__name__.lower()} has"
    for ability in (contract, *abilities):
        for name, member in members(ability).items():
            if hasattr(cls, name) and not _fits(inspect.getattr_static(cls, name), member):
                yield (f"{_written(name, inspect.getattr_static(cls, name))} is not the member "
                       f"{_written(name, member)} of {ability.__name__}")


def _fits(found: Any, member: Any) -> bool:
    """True if a class attribute can be used as a Protocol's member."""
    if isinstance(found, staticmethod | classmethod):
        found = found.__func__
    if not inspect.isfunction(member):
        return not inspect.isfunction(found)
    if not callable(found):
        return False
    try:
        inspect.signature(found).bind(*inspect.signature(member).parameters)
    except TypeError:
        return False
    return True


def _written(name: str, member: Callable[..., Any] | Any) -> str:
    """A member as it is used in code: a call with its parameters, or a name."""
    if not inspect.isfunction(member):
        return f"`{name}`"
    return f"`{name}({', '.join(list(inspect.signature(member).parameters)[1:])})`"

"""The contract of a sampled block and of a continuous plant with the loop.

Both are frozen, keyword-only dataclasses of parameters. Everything that they remember is in a state made by
`init`, a plain object that pickles; `step` and `advance` may update the state in place and touch nothing
else. The loop copies the arrays that a block puts out; nobody writes to what is read from an input.

Optional members are Protocols in `fesloop.loop.abilities`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

from fesloop.loop.clock import Clock, RateClock
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import NEVER, Port, Sample, Value


@dataclass(frozen=True, slots=True)
class Context:
    """Place of a block or plant when it makes its state.

    Attributes
    ----------
    name: the node's name in the experiment.
    seed, trial: of the run.
    clock: when the block ticks, or a plant's fixed steps; None for an exact plant.
    """

    name: str
    seed: int = 0
    trial: int = 0
    clock: Clock | None = None

    def noise(self, width: int, kind: str = "normal", purpose: str = "noise") -> NoiseStream:
        """Random rows that depend on (seed, name, purpose, trial, tick) alone."""
        return NoiseStream(stream_key(self.seed, f"{self.name}/{purpose}", self.trial), width, kind)


class Tick:
    """Instant of a step, reused by the loop: read it in `step`, do not keep it.

    Attributes
    ----------
    index: number of this tick.
    time_ns: its instant.
    captured_ns: set by a block whose values were captured elsewhere, such as a live stream's: the instant
        (from 0 to `time_ns`) that its outputs of this tick carry as their oldest and newest capture. An
        instant beyond is reported (`impossible_capture`) and clipped. NEVER otherwise.
    """

    __slots__ = ("captured_ns", "index", "reports", "time_ns")

    def __init__(self) -> None:
        self.index = 0
        self.time_ns = 0
        self.captured_ns = NEVER
        self.reports: list[tuple[str, str]] = []

    def report(self, status: str, detail: str = "") -> None:
        """Record trouble with this tick, such as ("infeasible", "QP: no point inside the slew limits")."""
        self.reports.append((status, detail))


class Block(Protocol):
    """A sampled block: named ports, a state, and a step."""

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Input ports, in the order of the inputs of `step`."""

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Output ports, in the order of the outputs of `step`."""

    def init(self, context: Context) -> Any:
        """A new state."""

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Outputs of one tick from its inputs; the state is updated in place.

        () puts out nothing at this tick, as a tracker does that has not had a sample: no message is sent, and
        readers know that none has come.
        """


class Plant(Protocol):
    """A continuous plant between the stimulator's plug and the sensors' cable."""

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Input ports."""

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Output ports."""

    @property
    def grid(self) -> RateClock | None:
        """Clock of the fixed steps, each one call of `advance`; None for a plant without fixed steps."""

    @property
    def feedthrough(self) -> bool:
        """True if an output depends on an input of the same instant."""

    def init(self, context: Context) -> Any:
        """A new state, at t = 0."""

    def advance(self, state: Any, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance from `start_ns` to `stop_ns` under inputs that are constant from `start_ns` on."""

    def read(self, state: Any, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Outputs now, fresh values each call; `inputs` matter only where `feedthrough` is true."""


def is_plant(part: object) -> TypeGuard[Plant]:
    """True if a part, or a class of parts, is a plant rather than a block."""
    return hasattr(part, "advance")

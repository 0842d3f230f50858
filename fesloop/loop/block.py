"""The contracts: what a sampled block and a continuous plant promise the loop.

Both are frozen, keyword-only dataclasses of parameters. All that they remember lives in a state made by
`init`, a plain object that pickles; `step` and `advance` may update the state in place and touch nothing
else. The loop copies the arrays that a block puts out; nobody writes to what is read from an input.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from fesloop.loop.clock import Clock, RateClock
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import NEVER, Port, Sample, Value


@dataclass(frozen=True, slots=True)
class Context:
    """What a block or plant may know of its place when it makes its state.

    Attributes
    ----------
    name: the node's name in the experiment.
    seed, trial: of the run.
    clock: when the block ticks; None for an exact plant.
    """

    name: str
    seed: int = 0
    trial: int = 0
    clock: Clock | None = None

    def noise(self, width: int, kind: str = "normal", purpose: str = "noise") -> NoiseStream:
        """Random rows that depend on (seed, name, purpose, trial, tick) alone."""
        return NoiseStream(stream_key(self.seed, f"{self.name}/{purpose}", self.trial), width, kind)


class Tick:
    """The instant of a step, lent to `step` and reused by the loop: read it, do not keep it.

    Attributes
    ----------
    index: number of this tick.
    time_ns: its instant.
    captured_ns: for a block to set whose values were captured elsewhere, such as a live stream's: the
        instant (from 0 to `time_ns`) that its outputs of this tick carry as their oldest and newest
        capture; one that lies beyond is told (`impossible_capture`) and moved there. NEVER otherwise.
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


@runtime_checkable
class Block(Protocol):
    """A sampled block.

    Optional members: `clock` (a Clock of its own, where the wiring gives no rate), `resolve(shapes)` (a
    copy of the block for the shapes, by input name, of what is wired to its open-sized inputs),
    `with_sensors(sources)` (a copy for the `Sensors`, by input name, whose samples are wired to it),
    `next_trial(state, context)` (the state that the next trial starts from, where it is not
    `init(context)`: a learning controller learns here), `close(state)` (a device lets go),
    `cautions(context)` ((status, detail) each: what its parameters give to fear, shown by `fesloop check`),
    `linear_form(context)` (what theory is told of a block that is linear, or can be: `models.linear_form`),
    `faults(context, surroundings)` (InputErrors: what of its parameters cannot work where it stands, told
    when an experiment is made; see `surroundings`),
    `cautions_in_place(context, surroundings)` ((status, detail) each: what is to be feared where it stands),
    `passages(context)` (what inputs wait for inside it before the outputs follow; see `passages`),
    `age_limits()` (the ages from which on it takes no notice of inputs; see `input_ages`).

    A block that hears the world as it is now has some of these too; with `attach` or a clock of arrivals it
    runs in step with the wall clock (`fesloop run --realtime`) and is refused elsewhere.
    `attach(state, present)`: called when t = 0 of a trial is now, before its first tick, with a `Present`
    (see `realtime`): when that is, and a bell to set from any thread when something has arrived.
    `waiting(state)`: loop time (ns) at which the oldest sample not yet taken arrived, None if there is none.
    All blocks on its clock of arrivals then tick at that instant, or the next that has not been run, and its
    `step` takes one sample. A block that looks at a fixed rate what has come has a plain rate, and no
    `waiting`.
    `heed(state, events)`: called once an instant has been run with what was reported at it, (instant, block,
    status, detail) each.
    `stand_in()`: a block with the same ports and a plain clock that touches nothing outside, for rehearsals.
    `seek()`: called before the rehearsal, which may take a while; tells a user of what is not there yet.

    A device that touches a person has `guarded` (names of inputs), and a block that may stand directly before
    it `guards = True`. `faults_behind(guard)`: InputErrors, what a device finds wrong with that one. A
    tracker that begins with an initial pose has `needs_stillness`: the name of the output, a vector, that is
    0 until the pose has been taken ("" where its parameters need none); a guard names in `interlock` the
    input that keeps stimulation off until then. See `guarding`.
    """

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Input ports, in the order in which `step` reads them."""

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Output ports, in the order in which `step` returns them."""

    def init(self, context: Context) -> Any:
        """A new state."""

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """One tick: outputs from inputs, the state updated in place.

        () puts out nothing at this tick, such as a tracker that has not had a sample: no message is sent, and
        whoever reads the block knows that none has come.
        """


@runtime_checkable
class Plant(Protocol):
    """A continuous plant between the stimulator's plug and the sensors' cable.

    `grid` is None for a plant that goes exactly to any instant, else the clock of its fixed steps: it is
    then advanced from grid tick to grid tick only, one step a call. `feedthrough` says whether `read`
    depends on the inputs. Optional members: `ignores` (names of optional inputs that make no difference with
    its parameters: no other plant is sampled for them), `observe(state, inputs, start_ns, times_ns)` (each
    output at later instants under held inputs, stacked along a first axis, state untouched: a faster way to
    what advancing a copy would give, at each instant the same to the last bit whichever others are asked
    for), `advance_through(state, inputs, start_ns, times_ns)` (what advancing to these ascending instants one
    by one and reading at each would give, to the last bit, outputs stacked in the same way),
    for fixed steps `reports(state)` ((status, detail) each: what it has to report of its last step, or of its
    beginning), `glance(state)` (by port number, those of the outputs that
    need none of the work that the others take: a wire that samples no other is spared `read`),
    `next_trial(state, context)`, `close(state)`, `resolve(shapes)`, `linear_form(output)` (as of a block,
    with one of the outputs).
    """

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Input ports."""

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Output ports."""

    @property
    def grid(self) -> RateClock | None:
        """Clock of the fixed steps, None for an exact plant."""

    @property
    def feedthrough(self) -> bool:
        """Whether an output depends on an input of the same instant."""

    def init(self, context: Context) -> Any:
        """A new state, at t = 0."""

    def advance(self, state: Any, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """From `start_ns` to `stop_ns` under inputs held from `start_ns` on."""

    def read(self, state: Any, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Outputs now; `inputs` matter only where `feedthrough` is true. Fresh values each call."""


class Observing(Protocol):
    """A plant that evaluates its outputs ahead without being advanced."""

    def observe(
        self, state: Any, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[NDArray[Any], ...]:
        """Outputs at `times_ns` (all >= `start_ns`), each stacked along a first axis."""

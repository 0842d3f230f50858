"""Environments of gymnasium on the exact loop: an agent in the place of an experiment's controller.

    import gymnasium
    import fesloop.gym

    env = gymnasium.make("fesloop/Finger-v0", settings=["latency_ms=50"])

Importing this module registers the environments:

- `fesloop/Finger-v0`: a finger with four muscles follows a movement (experiment `finger_control`).
- `fesloop/Hand-v0`: a hand opens and closes without an object (`grasp_mpc` with `scene=free`, scored to the
  end of the trial).
- `fesloop/Grasp-v0`: a hand grasps a cylinder, and holds it (`grasp_mpc`).

`LoopEnv` makes one of any experiment. Needs the extra `gym`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.files.parse import load
from fesloop.experiment.files.settings import Settings, setting_texts
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.loop.abilities import offers
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, Clock, RateClock, StampClock
from fesloop.loop.nodes import Node
from fesloop.loop.order import Sampling
from fesloop.loop.realtime import is_live
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

if TYPE_CHECKING:
    from fesloop.show.film.present import HandCamera

try:
    import gymnasium
except ImportError:
    raise ImportError("fesloop.gym: gymnasium is not installed; pip install 'fesloop[gym]'") from None

Array = NDArray[np.float64]
STOPPED = "emergency_stop"
"""Status of the safety block that ends an episode."""
_JUDGE = "gym_score"
_STOPPED_CLOCK = StampClock(np.array([FOREVER]))
"""Clock of a block that never steps."""
_ABOUT = ("age_s", "newest_age_s", "present")
_PICTURE_PX = 640, 480
_LOST_M = 0.1
"""Way of an object out of the hand from which its penalty no longer grows (chosen: the breadth of a hand)."""


class Drives(Protocol):
    """Conversion of drives to pulses, such as `controllers.allocation.Allocation`."""

    @property
    def channels(self) -> int:
        """Number of channels."""

    def reach(self) -> Array:
        """Greatest drive of each channel, (channels,); infinite where there is no limit."""

    def stimulation(self, drive: Array) -> Array:
        """Pulses (channels, 2), A and s, of drives (channels,)."""


class Allocates(Protocol):
    """A controller that converts drives to pulses."""

    def allocation(self) -> Drives:
        """The conversion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Agent:
    """A block that puts out the pulses that its state was given; its ports are those of the controller."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]

    def init(self, context: Context) -> SimpleNamespace:
        """State without stimulation."""
        return SimpleNamespace(pulses=self.outputs[0].initial_value())

    def step(self, state: SimpleNamespace, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick."""
        return (state.pulses,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judge:
    """A block that the signals that are scored reach; it acts on nothing, and is read without a step."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...] = ()

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Nothing."""
        return ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Task:
    """An experiment whose controller is replaced by an agent.

    Attributes
    ----------
    wiring: of the loop, with the agent and the judge.
    clock: of the agent.
    duration_ns: of an episode.
    drives: from drives to pulses. reach: (channels,), drive of action 1.
    seen: for each input that is wired, its number, and the first and the end of its values' entries.
    ports: number of the agent's inputs, after which the judge's follow in what the loop hands over.
    names: of the entries of an observation. high: (entries,), their upper bounds.
    gaps: whether an input may have lost samples.
    score: of the experiment. document: of the experiment as it was, with its controller.
    """

    wiring: Wiring
    clock: Clock
    duration_ns: int
    drives: Drives
    reach: Array
    seen: tuple[tuple[int, int, int], ...]
    ports: int
    names: tuple[str, ...]
    high: Array
    gaps: bool
    score: Score
    document: dict[str, Any]

    def observation(self, samples: Sequence[Sample], now_ns: int) -> Array:
        """Values, ages and presence of the samples of all inputs, (entries,)."""
        found = np.empty(self.high.size)
        for number, first, end in self.seen:
            value, oldest_ns, newest_ns, arrived_ns = samples[number]
            if arrived_ns < 0:  # as captured when the trial began
                oldest_ns = newest_ns = 0
            found[first:end] = value if isinstance(value, float) or value.ndim == 1 else value.ravel()
            found[end] = (now_ns - oldest_ns) / NS_PER_S
            found[end + 1] = (now_ns - newest_ns) / NS_PER_S
            found[end + 2] = arrived_ns >= 0
        return np.nan_to_num(found, copy=False) if self.gaps else found


def task_of(experiment: Experiment, controller: str, drives: Drives | None) -> Task:
    """Replace a controller. Raises InputError where the experiment has no place for an agent."""
    nodes = {node.name: node for node in experiment.wiring.nodes}
    node = _replaceable(nodes, controller)
    part = node.block
    if drives is None and offers(part, Allocates):
        drives = part.allocation()
    if drives is None:
        raise InputError(f"blocks.{controller}", "has no currents for the agent", "one of pid, mpc, ilc, "
                         "tuned_pid", "give LoopEnv(drives=...), such as controllers.allocation.Allocation("
                         "recruitment=None, current_ma=(20.0, 20.0), full_scale_us=300.0)")
    if part.outputs[0].shape != (drives.channels, 2):
        raise InputError("drives", f"{drives.channels} channels", f"{part.outputs[0].shape[0]}, as many as "
                         f"blocks.{controller} has")
    clock = node.clock
    assert clock is not None
    inputs, wires = _judged(experiment, nodes, clock)
    # Last in the order of declaration: at one instant the agent's turn comes after all that does not need it.
    agent = replace(node, part=Agent(inputs=part.inputs, outputs=part.outputs), rate=clock, offset_ms=0.0)
    judge = Node(_JUDGE, Judge(inputs=inputs), _STOPPED_CLOCK if isinstance(clock, RateClock) else clock)
    others = [each for name, each in nodes.items() if name != controller]
    wired = {end.target_port: end for end in experiment.wiring.connections if end.target.name == controller}
    names: list[str] = []
    high: list[float] = []
    seen = []
    for number in sorted(wired):
        source = wired[number].source.part.outputs[wired[number].source_port]
        entries = _entries(part.inputs[number], source.row_names)
        seen.append((number, len(names), len(names) + len(entries)))
        names += [*entries, *(f"{part.inputs[number].name}.{each}" for each in _ABOUT)]
        high += [math.inf] * len(entries) + [FOREVER / NS_PER_S, FOREVER / NS_PER_S, 1.0]
    return Task(
        wiring=Wiring([*others, judge, agent], [*experiment.wires, *wires], experiment.seed), clock=clock,
        duration_ns=experiment.duration_ns, drives=drives, reach=np.minimum(drives.reach(), 1.0),
        seen=tuple(seen), ports=len(part.inputs), names=tuple(names), high=np.array(high),
        score=experiment.score, document=experiment.document(),
        gaps=any(end.source.part.outputs[end.source_port].gaps for end in wired.values()))


def _replaceable(nodes: dict[str, Node], name: str) -> Node:
    """The node of a controller; raises InputError where an agent cannot take its place."""
    for each in nodes.values():
        if is_live(each):
            raise InputError(f"blocks.{each.name}", "is live: it runs in step with the wall clock only",
                             "an experiment without devices and live streams")
    if name not in nodes or nodes[name].is_plant:
        blocks = [each.name for each in nodes.values() if not each.is_plant]
        raise InputError("controller", f"there is no block {name!r}", ", ".join(blocks),
                         did_you_mean(name, blocks))
    outputs = nodes[name].block.outputs
    if [port.unit for port in outputs] != ["A,s"]:
        put_out = ", ".join(port.name for port in outputs) or "nothing"
        raise InputError("controller", f"{name!r} puts out {put_out}",
                         "a block whose one output is pulses, (channels, 2), A and s")
    return nodes[name]


def _judged(
    experiment: Experiment, nodes: dict[str, Node], clock: Clock
) -> tuple[tuple[Port, ...], list[Wire]]:
    """Inputs of the judge, and their wires, for the signals of the experiment's score at a clock's ticks."""
    score = experiment.score
    if score.truth is None or score.reference is None:
        raise InputError("score", "names no truth or no reference, so there is no reward", "both",
                         "add truth and reference to the table [score]")
    signals = {"truth": score.truth, "reference": score.reference}
    if score.grasp is not None and score.grasp.hand_position is not None:
        signals |= {"object": score.grasp.object, "hand": score.grasp.hand_position}
    inputs, wires = [], []
    for name, signal in signals.items():
        owner, _, port_name = signal.partition(".")
        port = next(port for port in nodes[owner].part.outputs if port.name == port_name)
        inputs.append(Port(name, port.shape, port.unit))
        wire = Wire(signal, f"{_JUDGE}.{name}")
        if nodes[owner].is_plant and isinstance(clock, RateClock):
            at = _shared(experiment, nodes[owner], clock)
            wire = replace(wire, rate=str(at.rate), offset_ms=at.offset_ns / NS_PER_MS)
        wires.append(wire)
    return tuple(inputs), wires


def _shared(experiment: Experiment, plant: Node, clock: RateClock) -> RateClock:
    """The clock, or the slowest that ticks with it and at whose ticks the loop samples the plant anyway.

    What is sampled at one instant for several readers is evaluated once. A plant of fixed steps is read at
    its steps, whoever asks.
    """
    if plant.plant.grid is not None:
        return clock
    shared = [each.clock for each in experiment.wiring.order
              if isinstance(each, Sampling) and each.plant.name == plant.name and not each.observing
              and isinstance(each.clock, RateClock) and _ticks_with(each.clock, clock)]
    return max(shared, key=lambda each: each.period_num, default=clock)


def _ticks_with(quick: RateClock, slow: RateClock) -> bool:
    """True if each tick of the slow clock is one of the quick clock."""
    between = slow.offset_ns - quick.offset_ns
    return not quick.arrivals and quick.period_den == slow.period_den == 1 and between >= 0 and (
        between % quick.period_num == slow.period_num % quick.period_num == 0)


def _entries(port: Port, rows: Sequence[str]) -> list[str]:
    """Names of a port's values, as they lie in an observation."""
    if port.shape == ():
        return [port.name]
    known = rows if (len(rows),) == port.shape else ()
    return [f"{port.name}[{known[place[0]] if known else ','.join(map(str, place))}]"
            for place in np.ndindex(*(size or 0 for size in port.shape))]


@compiled
def _fill_drive(share: Array, reach: Array, drive: Array) -> float:
    """Fill the drives (channels,) of an action (channels,); return its mean square, -1 for no action."""
    total = 0.0
    for i in range(share.size):
        if not 0.0 <= share[i] <= 1.0:
            return -1.0
        drive[i] = share[i] * reach[i]
        total += share[i] * share[i]
    return total / share.size


@compiled
def _mean_square(truth: Array, reference: Array) -> float:
    """Mean square of the difference of values (joints,)."""
    total = 0.0
    for i in range(truth.size):
        total += (truth[i] - reference[i])**2
    return total / truth.size


def _away(place: Array, sites: Array) -> float:
    """Distance, m, of a place (3,) from the least box along the axes that holds all sites (n, 3)."""
    inside = np.clip(place, sites.min(axis=0), sites.max(axis=0))
    return float(np.linalg.norm(place - inside))


def _copied(value: Value) -> Array:
    return np.array(value) if isinstance(value, float) else value.copy()


class LoopEnv(gymnasium.Env[Array, ArrayLike]):
    """An experiment, in which the agent takes the place of a controller.

    An action is the drive of each channel, (channels,), from 0 to 1: the share of the greatest drive that
    the channel reaches at its longest pulse. The controller's own conversion makes pulses of drives
    (`controllers.allocation`): its currents, and pulse widths by its model's recruitment; for a controller
    without a recruitment, the pulse width as a share of `full_scale_us`. An action acts in the tick of the
    observation that it answers, without a hidden period in between, as a controller's output does; safety
    and everything behind it are those of the experiment.

    An observation is what the controller would read in that tick, (entries,), named by `observation_names`:
    for each wired input the values, such as `measured[0]`, in the port's unit; `measured.age_s` and
    `measured.newest_age_s`, s since the oldest and the newest capture behind them; and `measured.present`, 1
    once a message has arrived. Before, values are the port's initial ones, captured when the trial began.
    Lost samples of sensors (NaN) are 0.

    The reward of a step is, with everything as it is at the next observation, minus

    - the mean square of `score.truth` less `score.reference` over joints, rad^2, from `score.after_s` to
      `score.until_s` and 0 otherwise: the true error, not the one that the tracker shows,
    - `effort_weight` times the mean square of the action,
    - with `score.grasp` and its `hand_position`, during the hold: `object_weight` times the square of how
      far the object's centre is outside the hand, 1 for 0.1 m and more, whether it fell or was never given.
      The hand is the least box along the axes of the global frame that holds its sites.

    A signal is as it was last put out: of a block at 100 Hz and a controller at 40 Hz, up to 10 ms before.

    An episode is a trial. `truncated` is true at its end, `terminated` after an emergency stop of safety.
    `info` has the instant (`time_ns`), the run's `seed`, `truth`, `reference` and `events`, the reports
    (ns, node, status, detail) since the last observation; where an object is scored also `object`,
    its place, (3,), m, and `object_away_m`, how far it is outside the hand, 0 or more.

    Parameters
    ----------
    experiment, settings: as of `fesloop.run`.
    controller: name of the block that the agent replaces; its one output is pulses.
    effort_weight: 1, above 0 or 0 (chosen: a tenth of full drive costs as much as 0.6 deg).
    object_weight: 1 (chosen: an object that is not in the hand costs as much as 57 deg).
    render_mode: "rgb_array": `render` returns the picture that a film would have of this instant: the true
        hand, and the tracker's over it, (480, 640, 3), uint8; None: there are no pictures. Needs OpenGL.
    drives: from drives to pulses, for a controller without `allocation`, or in place of it.

    Attributes
    ----------
    observation_names: names of the entries of an observation.
    loop: the loop of this episode; None before the first.

    Raises InputError, InputErrors for bad input, in the constructor, `reset` and `step`; RunError where a
    run fails.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012 - as gymnasium declares it

    def __init__(self, experiment: str | Path | Experiment, settings: Settings = (), *,
                 controller: str = "controller", effort_weight: float = 0.01, object_weight: float = 1.0,
                 drives: Drives | None = None, render_mode: str | None = None) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError("render_mode", f"{render_mode!r}", '"rgb_array" or None')
        self.render_mode = render_mode
        for key, weight in (("effort_weight", effort_weight), ("object_weight", object_weight)):
            if not (math.isfinite(weight) and weight >= 0.0):
                raise InputError(key, f"{weight}", "a finite number, 0 or more")
        self._experiment, self._settings = experiment, tuple(setting_texts(settings))
        self._controller, self._drives = controller, drives
        self._camera: HandCamera | None = None
        self._effort_weight, self._object_weight = effort_weight, object_weight
        self._base = self._task = self._made(())
        self.observation_names = self._base.names
        self.observation_space = gymnasium.spaces.Box(
            np.where(np.isinf(self._base.high), -np.inf, 0.0), self._base.high, dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(0.0, 1.0, (self._base.drives.channels,), np.float32)
        # In real time, as near as a whole number of pictures a second comes to it.
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / self._base.clock.period_s))}
        self.loop: Loop | None = None

    def _made(self, settings: Sequence[str]) -> Task:
        """The task of the experiment with further settings."""
        given = [*self._settings, *settings]
        if not isinstance(self._experiment, Experiment):
            return task_of(load(self._experiment, given), self._controller, self._drives)
        if given:
            raise InputError("settings", "given with an experiment that is made already",
                             "settings with a name or a path", "give LoopEnv the experiment's name or path")
        return task_of(self._experiment, self._controller, self._drives)

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin a trial; return its first observation, and info.

        Parameters
        ----------
        seed: of the run; None: one from the environment's own random numbers, in `info["seed"]`.
        options: {"settings": ...}: settings of this episode alone, beside those of the environment.
        """
        super().reset(seed=seed)
        given = dict(options or {})
        settings = setting_texts(given.pop("settings", ()))
        for name in given:
            raise InputError(f"options.{name}", "is unknown", "settings",
                             'give {"settings": ["KEY=VALUE"]}')
        task = self._made(settings) if settings else self._base
        if (task.names, task.drives.channels) != (self._base.names, self._base.drives.channels):
            raise InputError("options.settings", f"{', '.join(settings)} changes the entries of the "
                             "observation or the channels", "settings that leave both as they are",
                             "make another environment with these settings")
        self._close_loop()
        if task is not self._task:  # another hand, maybe
            self._close_camera()
        self._seed = int(self.np_random.integers(2**31)) if seed is None else seed
        self._task, self._tick = task, 0
        self.loop = Loop(task.wiring.with_seed(self._seed))
        states = self.loop.states()
        self._agent, self._ended = states[self._controller], False
        observation, info, _ = self._observe(self.loop)
        return observation, info

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Act in the tick of the last observation; return the next observation, reward and ends."""
        if self.loop is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if self._ended:
            raise gymnasium.error.ResetNeeded("the episode has ended; call reset before the next step")
        self._agent.pulses, effort = self._acted(action)
        self._tick += 1
        observation, info, penalty = self._observe(self.loop)
        stopped = bool(info["events"]) and any(status == STOPPED for _, _, status, _ in info["events"])
        over = info["time_ns"] >= self._task.duration_ns
        self._ended = stopped or over
        return observation, -self._effort_weight * effort - penalty, stopped, over, info

    def pulses(self, action: ArrayLike) -> Array:
        """Pulses (channels, 2), A and s, of an action; InputError for one that is no action."""
        return self._acted(action)[0]

    def _acted(self, action: ArrayLike) -> tuple[Array, float]:
        """Pulses and mean square of an action."""
        reach, share = self._task.reach, np.asarray(action, dtype=np.float64, order="C")
        drive = np.empty(reach.size)
        effort = _fill_drive(share, reach, drive) if share.shape == reach.shape else -1.0
        if effort < 0.0:
            found = f"shape {share.shape}" if share.shape != reach.shape else f"{share.tolist()}"
            raise InputError("action", found, f"shape {reach.shape}, each from 0 to 1",
                             "scale and clip it, as RescaleAction and ClipAction of gymnasium do")
        return self._task.drives.stimulation(drive), effort

    def _observe(self, loop: Loop) -> tuple[Array, dict[str, Any], float]:
        """Run until the turn of the agent; return observation, info, and penalty."""
        task = self._task
        now_ns = task.clock.tick(self._tick)
        samples = loop.run_until_turn(self._controller, now_ns, _JUDGE)
        truth, reference = _copied(samples[task.ports][0]), _copied(samples[task.ports + 1][0])
        info = {"time_ns": now_ns, "seed": self._seed, "truth": truth, "reference": reference,
                "events": loop.events}
        away_m = 0.0
        if len(samples) > task.ports + 2:
            info["object"] = thing = _copied(samples[task.ports + 2][0])
            info["object_away_m"] = away_m = _away(thing, np.asarray(samples[task.ports + 3][0]))
        penalty = self._penalty(now_ns, truth, reference, away_m)
        return task.observation(samples, now_ns), info, penalty

    def _penalty(self, now_ns: int, truth: Array, reference: Array, away_m: float) -> float:
        """Penalty of the tracking error and of an object that is not in the hand."""
        score = self._task.score
        now_s, penalty = now_ns / NS_PER_S, 0.0
        if score.after_s <= now_s and (score.until_s is None or now_s <= score.until_s):
            penalty = (_mean_square(truth, reference) if truth.ndim == 1
                       else _mean_square(truth.ravel(), reference.ravel()))
        if score.grasp is not None and score.grasp.from_s <= now_s <= score.grasp.until_s:
            away = min(away_m / _LOST_M, 1.0)
            penalty += self._object_weight * away * away
        return penalty

    def render(self) -> NDArray[np.uint8] | None:
        """Picture of this instant; None without a `render_mode`. Changes nothing in the loop."""
        if self.render_mode is None:
            return None
        if self.loop is None:
            raise gymnasium.error.ResetNeeded("call reset before render")
        if self._camera is None:
            from fesloop.show.film.opengl import require_opengl

            require_opengl()
            from fesloop.show.film.present import HandCamera

            self._camera = HandCamera(self._task.document, self.loop, *_PICTURE_PX)
        return self._camera.picture(self.loop)

    def close(self) -> None:
        """Close the loop and what draws."""
        self._close_camera()
        self._close_loop()

    def _close_loop(self) -> None:
        if self.loop is not None:
            self.loop.close()
            self.loop = None

    def _close_camera(self) -> None:
        if self._camera is not None:
            self._camera.close()
            self._camera = None


def free_hand(settings: Settings = (), **parameters: Any) -> LoopEnv:
    """The environment `fesloop/Hand-v0`, with the parameters of `LoopEnv`."""
    given = ("scene=free", "score.until_s=10", *setting_texts(settings))
    return LoopEnv("grasp_mpc", given, **parameters)


for _name, _entry, _given in (("Finger", LoopEnv, {"experiment": "finger_control"}), ("Hand", free_hand, {}),
                              ("Grasp", LoopEnv, {"experiment": "grasp_mpc"})):
    gymnasium.register(f"fesloop/{_name}-v0", f"fesloop.gym:{_entry.__name__}", kwargs=_given)

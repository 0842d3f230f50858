"""Small parts that the loop's tests wire together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import expm

from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port


@dataclass(slots=True)
class Memory:
    """State of the parts below."""

    x: Any = None
    log: list[Any] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pass:
    """Puts out a gain times its input, or times the sum of several."""

    gain: float = 1.0
    names: tuple[str, ...] = ("u",)

    @property
    def inputs(self):
        return tuple(Port(name) for name in self.names)

    @property
    def outputs(self):
        return (Port("y"),)

    def init(self, context: Context) -> Memory:
        return Memory()

    def step(self, state, inputs, tick):
        return (self.gain * sum(sample.value for sample in inputs),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Source:
    """Puts out its tick number."""

    inputs = ()
    outputs = (Port("y"),)

    def init(self, context: Context) -> Memory:
        return Memory()

    def step(self, state, inputs, tick):
        return (float(tick.index),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sink:
    """Keeps every input that it reads as (time, samples)."""

    names: tuple[str, ...] = ("u",)
    outputs = ()

    @property
    def inputs(self):
        return tuple(Port(name) for name in self.names)

    def init(self, context: Context) -> Memory:
        return Memory()

    def step(self, state, inputs, tick):
        state.log.append((tick.time_ns, *inputs))
        return ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImpulseProbe:
    """A plant whose output is 1 when it is sampled at (or holds the grid step at) `impulse_ns`, else 0.

    Its state logs (instant, value) whenever it is advanced under another input than before.
    """

    impulse_ns: int = -1
    grid: RateClock | None = None
    feedthrough = False
    inputs = (Port("u"),)
    outputs = (Port("y"),)

    def init(self, context: Context) -> Memory:
        return Memory(x=0)

    def advance(self, state, inputs, start_ns, stop_ns):
        if inputs[0] != (state.log[-1][1] if state.log else 0.0):
            state.log.append((start_ns, inputs[0]))
        state.x = stop_ns

    def read(self, state, inputs):
        return (1.0 if state.x == self.impulse_ns else 0.0,)


def peers_matrices():
    """The plant of the peers' loop: x'' = -2 z w x' - w^2 x + w^2 u at 2.5 Hz, z = 0.9."""
    w, z = 2 * np.pi * 2.5, 0.9
    return np.array([[0.0, 1.0], [-w * w, -2 * z * w]]), np.array([[0.0], [w * w]])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SecondOrder:
    """The peers' plant, exact at any instant, or in 1 ms steps on a grid."""

    grid: RateClock | None = None
    feedthrough = False
    inputs = (Port("u"),)
    outputs = (Port("y"),)

    def init(self, context: Context) -> Memory:
        return Memory(x=np.zeros(2))

    def advance(self, state, inputs, start_ns, stop_ns):
        a, b = peers_matrices()
        stacked = np.zeros((3, 3))
        stacked[:2, :2], stacked[:2, 2:] = a, b
        step = expm(stacked * ((stop_ns - start_ns) * 1e-9))
        state.x = step[:2, :2] @ state.x + step[:2, 2] * inputs[0]

    def read(self, state, inputs):
        return (float(state.x[0]),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PeersPi:
    """The PI controller of the peers' loop."""

    inputs = (Port("y"),)
    outputs = (Port("u"),)

    def init(self, context: Context) -> Memory:
        return Memory(x=0.0)

    def step(self, state, inputs, tick):
        error = 1.0 - inputs[0].value
        u = 0.6 * error + 3.0 * state.x
        state.x += 20e-3 * error
        return (u,)

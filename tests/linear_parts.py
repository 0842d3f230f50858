"""Small linear loops that the theory's tests take apart: a plant, and a gain on what is measured of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fesloop.experiment.record_spec import Record
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.loop.block import Context
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.nodes import Node
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.models.linear_form import memoryless
from plants.linear import StateSpace

PERIOD_S = 0.02


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Feedback:
    """u = -gain (y + noise), both one number."""

    gain: float
    noise: float = 0.0

    @property
    def inputs(self):
        return (Port("y", unit="rad"),)

    @property
    def outputs(self):
        return (Port("u"),)

    def linear_form(self, context: Context):
        noise = np.array([[-self.gain * self.noise]]) if self.noise else None
        return memoryless(("y",), "u", np.array([[-self.gain]]), noise)

    def init(self, context: Context) -> Any:
        return context.noise(1)

    def step(self, state, inputs, tick):
        return (-self.gain * (inputs[0].value + self.noise * float(state.row(tick.index)[0])),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sensor:
    """y with white noise: a block of its own, so that a wire lies between it and the feedback."""

    noise: float = 0.0

    @property
    def inputs(self):
        return (Port("y", unit="rad"),)

    @property
    def outputs(self):
        return (Port("y", unit="rad"),)

    def linear_form(self, context: Context):
        return memoryless(("y",), "y", np.eye(1), np.array([[self.noise]]))

    def init(self, context: Context) -> Any:
        return context.noise(1)

    def step(self, state, inputs, tick):
        return (inputs[0].value + self.noise * float(state.row(tick.index)[0]),)


def _plant(growth):
    return Node("plant", StateSpace(a=((growth,),), b=((1.0,),), c=((1.0,),), output_unit="rad"))


def _experiment(name, nodes, wires, plant_rate):
    return Experiment(name=name, nodes=nodes, wires=wires, duration_s=10.0,
                      record=Record(plant_rate=plant_rate), score=Score(truth="plant.y"))


def scalar_loop(growth, gain, noise=1.0, sensed=None, stimulated=None, plant_rate=50, execution=ZERO):
    """x' = growth x + u, u = -gain (x + noise), at 50 Hz; `sensed` and `stimulated` are keys of the wires."""
    feedback = Node("feedback", Feedback(gain=gain, noise=noise), rate=50, execution=execution)
    wires = (Wire("plant.y", "feedback.y", **(sensed or {})),
             Wire("feedback.u", "plant.u", **(stimulated or {})))
    return _experiment("scalar", (feedback, _plant(growth)), wires, plant_rate)


def oscillator_loop(omega, damping, gain, rate=200):
    """x'' = -omega^2 x - damping x' + gain u, where u is x as it was sampled."""
    plant = StateSpace(a=((0.0, 1.0), (-omega**2, -damping)), b=((0.0,), (gain,)), c=((1.0, 0.0),),
                       output_unit="rad")
    nodes = (Node("feedback", Feedback(gain=-1.0), rate=rate), Node("plant", plant))
    wires = (Wire("plant.y", "feedback.y"), Wire("feedback.u", "plant.u"))
    return _experiment("oscillator", nodes, wires, 50)


def sensed_loop(growth, gain, noise, wire, sensor_rate=100, plant_rate=50):
    """The same with a sensor of its own rate, and all noise in it; `wire` leads from it to the feedback."""
    nodes = (Node("sensor", Sensor(noise=noise), rate=sensor_rate),
             Node("feedback", Feedback(gain=gain), rate=50), _plant(growth))
    wires = (Wire("plant.y", "sensor.y"), Wire("sensor.y", "feedback.y", **wire),
             Wire("feedback.u", "plant.u"))
    return _experiment("sensed", nodes, wires, plant_rate)


def uniform(low_ms, high_ms):
    return Duration(kind="uniform", low_ms=low_ms, high_ms=high_ms)

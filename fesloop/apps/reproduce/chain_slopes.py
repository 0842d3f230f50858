"""Linearisation of a patient's chain from pulse widths to posture along a trajectory.

Recruitment is linearised by secants, muscles by their step response, the hand by MuJoCo's linearisation of
its steps with stiff tendons; the stretch reflex is left out. The slopes serve as search directions; the chain
itself evaluates the steps.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.open_chain import OpenChain
from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
SECANT_S = 20e-6
"""Half the interval of secants (chosen: contains some of a muscle's 64 axons)."""
_FIRST_STEP_S = 5e-6
"""First step of the search for thresholds (chosen: no muscle gains two axons within it)."""


class RecruitedFront:
    """Static map from pulse widths to recruitment: electrodes, arrays and axons, one channel per slot.

    Parameters
    ----------
    parts: with `stimulator` and `electrodes`.
    currents: (channels,), A.
    width_most: (channels,), s.
    seed: of the run.

    Attributes
    ----------
    threshold: (channels,), s, up to which a channel alone recruits nothing.
    """

    __slots__ = ("_clock", "_currents", "_electrodes", "_hertz", "_period", "_shares", "_slot", "_state",
                 "_still", "threshold", "width_most")

    def __init__(self, parts: dict[str, Any], currents: Array, width_most: Array, seed: int) -> None:
        stimulator, self._electrodes = parts["stimulator"], parts["electrodes"]
        self._clock, self._shares, self._currents = stimulator.clock, stimulator.shares, currents
        self._hertz = float(stimulator.frequency_hz)
        self._state = self._electrodes.init(Context("electrodes", seed, 0, self._clock))
        self._still = [Sample(port.initial_value(), -1, -1, -1) for port in self._electrodes.inputs[1:]]
        self._period, self._slot = round(1.0 / self._hertz / self._clock.period_s), 0
        self.width_most = width_most
        self.threshold = np.array([self._threshold(c) for c in range(len(currents))])

    def _threshold(self, channel: int) -> float:
        widths = np.zeros(len(self._currents))
        for width in np.arange(_FIRST_STEP_S, self.width_most[channel], _FIRST_STEP_S):
            widths[channel] = width
            if self.recruited(widths).any():
                return float(width) - _FIRST_STEP_S
        return float(self.width_most[channel])

    def recruited(self, widths: Array) -> Array:
        """Recruited shares, (29,), of pulses of `widths` (channels,), s, one a channel and period."""
        first = (self._slot // self._period + 2) * self._period
        tick, none = Tick(), Sample(np.zeros((self._electrodes.elements, 3)), -1, -1, -1)
        recruitment = np.zeros(0)
        firing = [channel for channel in range(len(widths)) if widths[channel] > 0.0]
        for channel in firing or [0]:
            tick.index = self._slot = first + channel
            tick.time_ns = self._clock.tick(tick.index)
            message = self._message(channel, widths[channel], tick.time_ns) if firing else none
            recruitment, _ = self._electrodes.step(self._state, [message, *self._still], tick)
        return recruitment

    def _message(self, channel: int, width: float, now_ns: int) -> Sample:
        """Message with the pulse of one channel in its slot."""
        pulses, row = np.zeros((self._electrodes.elements, 3)), self._shares[channel]
        on = row > 0.0
        pulses[on, 0] = self._currents[channel] * row[on]
        pulses[on, 1:] = width, self._hertz
        return Sample(pulses, now_ns, now_ns, now_ns)

    def slopes(self, widths: Array) -> Array:
        """Change of recruited shares with widths, (29, channels), 1/s, about `widths` (channels,), s."""
        columns = []
        for channel in range(len(widths)):
            shifted = []
            for side in (-SECANT_S, SECANT_S):
                moved = widths.copy()
                moved[channel] = np.clip(widths[channel] + side, 0.0, self.width_most[channel])
                shifted.append((moved[channel], self.recruited(moved)))
            (low, below), (high, above) = shifted
            columns.append((above - below) / (high - low))
        return np.stack(columns, axis=1)


PARTS = 2
"""Pieces of a tick in which the hand is treated as linear (chosen: 12.5 ms at 40 Hz)."""
_PERTURBED = 1e-6
_RESPONSE_S = 0.8
"""Length of a muscle's step response (chosen: ten time constants of the slowest model)."""


class ChainSlopes:
    """Linearisation of a chain.

    Parameters
    ----------
    chain: the plant.
    """

    __slots__ = ("_chain", "_delays", "_model", "_readout", "_response", "_scratch",
                 "front")

    def __init__(self, chain: OpenChain) -> None:
        self._chain, parts = chain, chain.parts
        hand = parts["hand"]
        if getattr(hand, "tendon_strain", 0.0) > 0.0:
            hand = replace(hand, tendon_strain=0.0)  # MuJoCo linearises its own muscles
        self._model: Any = getattr(hand, "model", None)
        names = [] if self._model is None else [self._model.joint(i).name for i in range(self._model.njnt)]
        self._readout = np.zeros((len(chain.rows), len(names)))
        for column, freedom in enumerate(chain.freedoms):
            if chain.rows[:, column].any():
                if freedom not in names:
                    raise InputError("hand", f"no joint of its model is {freedom}",
                                     "a hand whose joints are the freedoms", 'take kind = "hand"')
                self._readout[:, names.index(freedom)] = chain.rows[:, column]
        self._scratch = mujoco.MjData(self._model)
        self.front = RecruitedFront(parts, chain.currents, chain.width_most, chain.seed)
        self._delays = self._channel_delays(parts["stimulator"])
        self._response = self._step_response()

    def _channel_delays(self, stimulator: Any) -> Array:
        """Delay of each channel's slot after the tick, (channels,), ns."""
        slot, period = stimulator.clock.period_s * NS_PER_S, NS_PER_S / float(stimulator.frequency_hz)
        latency = stimulator.latency_ms * NS_PER_MS + self._chain.wire_latency_ns
        slots = slot * np.arange(len(self._chain.currents))
        delays: Array = slots + period * np.maximum(0.0, np.ceil((latency - slots) / period))
        return delays

    def _step_response(self) -> Array:
        """(ms, 29), activation after a step of recruitment, per unit of it."""
        muscles = replace(self._chain.parts["muscles"], fatigue=None)
        state, count = muscles.init(Context("muscles", self._chain.seed)), len(MUSCLES)
        hertz = float(self._chain.parts["stimulator"].frequency_hz)
        inputs = [np.full(count, 0.5), np.full(count, hertz), np.zeros(count), np.zeros(count)]
        response = np.zeros((round(1e3 * _RESPONSE_S) + 1, count))
        for ms in range(1, len(response)):
            muscles.advance(state, inputs, (ms - 1) * NS_PER_MS, ms * NS_PER_MS)
            response[ms] = muscles.read(state, inputs)[0] / 0.5
        return response

    def _answers(self, after_ms: Array) -> Array:
        """Step responses (..., 29) at these times after the step, ms; 0 before it."""
        index = np.clip(np.rint(after_ms).astype(np.int64), 0, len(self._response) - 1)
        return self._response[index]

    def jacobian(self, widths: Array, first: int, shapes: Array) -> tuple[Array, Array]:
        """Return (course, slopes) from tick `first` on.

        Parameters
        ----------
        widths: (ticks, channels), s.
        shapes: (ticks, k): how each of k parameters of a channel moves its widths; the recruitment's slopes
            are those where it does so most.

        Returns
        -------
        course: (ticks - first, m), rad. slopes: (ticks - first, m, k, channels), rad/s, of the course.
        """
        chain = self._chain
        stops = self._stops(first)
        states, fitness, course = self._trace(widths, first, stops)
        drives = self._activations(widths, first, shapes, stops, fitness)
        slopes = self._through_hand(states, drives, stops)[::PARTS]
        size = len(course), len(chain.rows), shapes.shape[1], len(chain.currents)
        return course, slopes.reshape(size)

    def settled(self, widths: Array, ticks: int) -> tuple[Array, Array]:
        """Return the steady state (sums, slopes) under constant `widths` (channels,), s, after `ticks`.

        sums: (m,), rad. slopes: (m, channels), rad/s, of the sums at rest."""
        chain, model = self._chain, self._model
        loop = chain.begin(np.tile(widths, (chain.ticks, 1)), 0)
        loop.run_until(chain.time_ns(ticks))
        states = loop.states()
        state = states["hand"]
        a, b = self._linear_step(state.data.qpos, state.data.qvel, self._controls(states))
        drives = self._response[-1][:, np.newaxis] * self.front.slopes(widths)
        moved = np.linalg.solve(np.eye(len(a)) - a, b @ drives)[:model.nv]
        sums = chain.rows @ chain.parts["hand"].glance(state)[0] + chain.offset
        return sums, self._readout @ moved

    def _stops(self, first: int) -> NDArray[np.int64]:
        """Instants, ns, from tick `first` to the last, `PARTS` a tick."""
        ticks = [self._chain.time_ns(k) for k in range(first, self._chain.ticks)]
        between = [np.linspace(a, b, PARTS, endpoint=False) for a, b in pairwise(ticks)]
        return np.append(np.concatenate(between), ticks[-1]).astype(np.int64)

    def _trace(self, widths: Array, first: int, stops: NDArray[np.int64]) -> tuple[
            list[tuple[Array, Array, Array]], Array, Array]:
        """States of the hand, fitness (stops, 29), and the course at the ticks."""
        chain = self._chain
        loop, hand, muscles = chain.begin(widths, first), chain.parts["hand"], chain.parts["muscles"]
        states, fitness, course = [], [], []
        for number, stop in enumerate(stops):
            loop.run_until(int(stop))
            seen = loop.states()
            data = seen["hand"].data
            states.append((data.qpos.copy(), data.qvel.copy(), self._controls(seen)))
            fitness.append(muscles.read(seen["muscles"], ())[1])
            if number % PARTS == 0:
                course.append(chain.rows @ hand.glance(seen["hand"])[0] + chain.offset)
        return states, np.array(fitness), np.array(course)

    def _controls(self, states: dict[str, Any]) -> Array:
        """Activation of the muscles, then MuJoCo's controls of other drives, from the states of a loop."""
        ctrl = states["hand"].data.ctrl
        others = self._model.nu - len(MUSCLES)
        activation = self._chain.parts["muscles"].read(states["muscles"], ())[0]
        return np.concatenate([activation, ctrl[len(ctrl) - others:]])

    def _linear_step(self, qpos: Array, qvel: Array, ctrl: Array) -> tuple[Array, Array]:
        """Matrices A (2 v, 2 v) and B (2 v, 29) of one step, linearised at this state."""
        size = 2 * self._model.nv
        a, b = np.zeros((size, size)), np.zeros((size, self._model.nu))
        self._scratch.qpos[:], self._scratch.qvel[:], self._scratch.ctrl[:] = qpos, qvel, ctrl
        mujoco.mjd_transitionFD(self._model, self._scratch, _PERTURBED, 0, a, b, None, None)
        return a, b[:, :len(MUSCLES)]

    def _activations(self, widths: Array, first: int, shapes: Array, stops: NDArray[np.int64],
                     fitness: Array) -> Array:
        """Change of activation in the middle of each piece, (pieces, 29, k channels)."""
        chain, count = self._chain, len(self._chain.currents)
        middles = 0.5 * (stops[1:] + stops[:-1])
        moved = np.zeros((len(middles), len(MUSCLES), shapes.shape[1], count))
        given = chain.given(widths)
        at = np.argmax(shapes, axis=0)
        peaks = {int(tick): self.front.slopes(given[tick]) for tick in at}
        for tick in range(first, chain.ticks):
            active = np.flatnonzero(shapes[tick])
            if not active.size:
                continue
            slopes = peaks[int(at[np.argmax(shapes[tick])])]
            for channel in range(count):
                hit = np.flatnonzero(slopes[:, channel])
                begun = chain.time_ns(tick) + self._delays[channel]
                ended = chain.time_ns(tick + 1) + self._delays[channel]
                pulse = (self._answers((middles - begun) / NS_PER_MS)
                         - self._answers((middles - ended) / NS_PER_MS))[:, hit]
                pulse *= slopes[hit, channel] * fitness[:-1, hit]
                for k in active:
                    moved[:, hit, k, channel] += shapes[tick, k] * pulse
        return moved.reshape(len(middles), len(MUSCLES), -1)

    def _through_hand(self, states: list[tuple[Array, Array, Array]], drives: Array,
                      stops: NDArray[np.int64]) -> Array:
        """Change of the scored sums at the stops, (stops, m, parameters)."""
        model = self._model
        moved = np.zeros((2 * model.nv, drives.shape[2]))
        seen = np.zeros((len(stops), len(self._readout), drives.shape[2]))
        step_ns = model.opt.timestep * NS_PER_S
        for number, change in enumerate(drives):
            a, b = self._linear_step(*states[number + 1])
            forced = b @ change
            for _ in range(round((stops[number + 1] - stops[number]) / step_ns)):
                moved = a @ moved + forced
            seen[number + 1] = self._readout @ moved[:model.nv]
        return seen

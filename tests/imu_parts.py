"""Sites of a made-up hand, and a run of sensors on them."""

from __future__ import annotations

import numpy as np

from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from plants.imus import Imus

NO_PULSES = Sample(np.zeros((1, 2)), NEVER, NEVER, NEVER)
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def names(count):
    """As many sites as a statistic needs."""
    return tuple(f"s{i}" for i in range(count))


def sites(count, orientation=UPRIGHT, position=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0),
          force=(0.0, 0.0, 9.80665)):
    """Values of the sites' four signals, each the same at every site unless given by site."""
    return [np.broadcast_to(np.asarray(value, dtype=float), (count, width)).copy()
            for value, width in ((orientation, 4), (position, 3), (rate, 3), (force, 3))]


def ideal(count, **parameters):
    """Sensors without any error but those that are given, on `count` sites."""
    return Imus(preset="ideal", site_names=names(count), **parameters)


def run(imus, given, ticks, rate="100", seed=0, trial=0, name="imus", pulses=NO_PULSES):
    """({kind: samples (ticks, n, 3)}, [(tick, status, detail)]); `given(k, t_s)` gives the sites' values."""
    clock = RateClock.from_rate(rate)
    state = imus.init(Context(name, seed=seed, trial=trial, clock=clock))
    rows, reports, tick = [], [], Tick()
    for k in range(ticks):
        tick.index, tick.time_ns = k, clock.tick(k)
        now = tick.time_ns
        values = given(k, now * 1e-9) if callable(given) else given
        inputs = [Sample(value, now, now, now) for value in values]
        if len(imus.inputs) > 4:
            inputs.append(pulses(now) if callable(pulses) else pulses)
        rows.append(imus.step(state, inputs, tick))
        reports += [(k, *report) for report in tick.reports]
        tick.reports.clear()
    kinds = [port.name for port in imus.outputs]
    return {kind: np.array([row[i] for row in rows]) for i, kind in enumerate(kinds)}, reports

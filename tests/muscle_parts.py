"""Inputs for the muscles, and runs of them."""

import numpy as np

from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context
from plants.muscles import Muscles
from plants.muscles.ding import Ding2003, Ding2003Fatigue
from plants.muscles.lags import Hammerstein, MuscleFatigue
from plants.muscles.patient_drive import MuscleTremor, StretchReflex
from plants.muscles.variation import Variation

MS = 1_000_000
COUNT = len(MUSCLES)
CONTEXT = Context("muscles", seed=3)
MODELS = ("hammerstein", "riener", "ding2003", "ding2007")


def given(recruited=0.0, frequency=40.0, velocity=0.0, voluntary=0.0):
    """The plant's inputs; a number stands for all muscles."""
    return [np.broadcast_to(np.asarray(value, dtype=np.float64), (COUNT,)).copy()
            for value in (recruited, frequency, velocity, voluntary)]


def tiring(model, **parameters):
    """Muscles of a model that tire by the equations it has."""
    if model == "ding2003":
        return Muscles(model=model, ding2003=Ding2003(fatigue=Ding2003Fatigue()), **parameters)
    return Muscles(model=model, fatigue=MuscleFatigue(), **parameters)


def own(middle, spread):
    """A number of each muscle's own around a middle, but for the first five."""
    return {name: middle + spread * np.sin(1.7 * k) for k, name in enumerate(MUSCLES) if k >= 5}


def patient(model):
    """Muscles with everything that a patient may have."""
    return tiring(model, reflex=StretchReflex(), tremor=MuscleTremor(), delay_growth=2.0,
                  delay_ms=20.0, delays_ms=own(20.0, 15.0), naturals_rad_s=own(25.0, 15.0),
                  variation=Variation(trial=0.1, muscle_trial=0.2, drift=0.1, muscle_drift=0.2),
                  hammerstein=Hammerstein(activation_rad_s=25.0, activations_rad_s=own(25.0, 15.0)))


def simulate(muscles, schedule, stops_ns, state=None):
    """(activation, fitness) at each stop, (stops, 2, muscles); inputs of the schedule {ns: inputs} held."""
    state = muscles.init(CONTEXT) if state is None else state
    now, held, seen = 0, given(0.0, 0.0), []
    for stop in stops_ns:
        for instant in sorted(t for t in schedule if now <= t < stop):
            if instant > now:
                muscles.advance(state, held, now, instant)
                now = instant
            held = schedule[instant]
        muscles.advance(state, held, now, stop)
        now = stop
        seen.append(np.stack(muscles.read(state, held)))
    return np.array(seen)


def contractions(muscles, on_ms, off_ms, frequency, count):
    """Peak activation of each of `count` contractions at full recruitment."""
    state, now, peaks = muscles.init(CONTEXT), 0, []
    for _ in range(count):
        peak = 0.0
        for inputs, span in ((given(1.0, frequency), on_ms), (given(0.0, 0.0), off_ms)):
            times = range(now, now + span * MS, 10 * MS)
            peak = max(peak, muscles.observe(state, inputs, now, times)[0].max())
            muscles.advance(state, inputs, now, now + span * MS)
            now += span * MS
        peaks.append(peak)
    return np.array(peaks)
